"""When the program fails: one window with a report, and crashes of before."""

import faulthandler
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QRunnable, Qt, QThreadPool, QTimer
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget

from georibbon import __version__
from georibbon.gui import dialogs
from georibbon.gui.crash import MOST_FAULTS, CrashReporter, Faults, HardCrashes, report
from georibbon.gui.notifier import Entry, Notifier

CRASH = """
import ctypes, sys
from pathlib import Path
from georibbon.gui.crash import HardCrashes
HardCrashes(Path(sys.argv[1]))
def deep_inside():
    ctypes.string_at(0)
deep_inside()
"""


# Shows the window; then crashes, or tells whether it told of a crash.
STARTED = """
import os, signal, sys
from PySide6.QtCore import QTimer
from georibbon.gui import app, window
made = window.MainWindow.__init__
def watched(self, *words):
    made(self, *words)
    QTimer.singleShot(300, lambda: act(self))
def act(self):
    if sys.argv[1] == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    told = self.crashes.window
    print(told is not None and told.isVisible() and told.what.text(), flush=True)
    self.close()
window.MainWindow.__init__ = watched
sys.exit(app.main())
"""


@pytest.fixture
def notifier():
    made = Notifier()
    made.install()
    yield made
    made.uninstall()


@pytest.fixture
def place():
    """Where the open session is said to lie; a test may change it."""
    return [Path("/data/part.georibbon")]


@pytest.fixture
def reporter(notifier, place, qtbot):
    window = QWidget()
    qtbot.addWidget(window)
    window.show()
    made = CrashReporter(notifier, lambda: place[0], window)
    yield made
    made.end()


def shown(reporter, qtbot):
    """The crash window, as soon as it is there."""
    qtbot.waitUntil(lambda: reporter.window is not None and reporter.window.isVisible())
    return reporter.window


def test_a_fault_in_a_slot_is_shown_in_plain_words(reporter, qtbot, capsys):
    def slot():
        raise ValueError("deep inside")

    QTimer.singleShot(0, slot)
    window = shown(reporter, qtbot)
    assert "not your doing" in window.what.text()
    assert "/data/part.georibbon" in window.safe.text()
    details = window.details.toPlainText()
    assert 'raise ValueError("deep inside")' in details
    assert f"Georibbon {__version__}" in details
    assert "numpy" in details
    assert "session: /data/part.georibbon" in details
    assert "deep inside" in capsys.readouterr().err


def test_faults_of_threads_and_workers_come_too(reporter, notifier, qtbot, capsys):
    def fail():
        raise RuntimeError("in a thread")

    class Work(QRunnable):
        def run(self):
            try:
                fail()
            except RuntimeError as error:
                notifier.exception(error)

    thread = threading.Thread(target=fail)
    thread.start()
    thread.join()
    QThreadPool.globalInstance().start(Work())
    qtbot.waitUntil(lambda: reporter._faults.count == 2)
    assert "in a thread" in shown(reporter, qtbot).details.toPlainText()
    assert "in a thread" in capsys.readouterr().err


def test_many_in_a_row_make_one_window(reporter, notifier, qtbot):
    for number in range(500):
        notifier.exception(KeyError(number % 2))
    window = shown(reporter, qtbot)
    notifier.exception(KeyError("another"))
    qtbot.waitUntil(lambda: "another" in window.details.toPlainText())
    assert reporter.window is window
    assert "(250 times)" in window.details.toPlainText()


def test_a_few_kinds_are_kept_and_the_others_are_counted():
    faults = Faults()
    for number in range(MOST_FAULTS + 7):
        faults.add(Entry("fault", f"fault {number}", f"trace {number}"))
    assert faults.text().count("trace ") == MOST_FAULTS
    assert faults.text().endswith("and 7 more")


def test_the_report_is_copied_and_saved(reporter, notifier, qtbot, tmp_path, monkeypatch):
    notifier.tell("info", "opened part.georibbon")
    notifier.exception(KeyError("k"))
    window = shown(reporter, qtbot)
    qtbot.mouseClick(window.copy_button, Qt.MouseButton.LeftButton)
    copied = QGuiApplication.clipboard().text()
    assert "KeyError: 'k'" in copied
    assert "info: opened part.georibbon" in copied
    for target in (tmp_path / "report.txt", tmp_path / "no" / "such" / "place.txt", None):
        monkeypatch.setattr(dialogs, "ask_target", lambda *_, target=target: target)
        qtbot.mouseClick(window.save_button, Qt.MouseButton.LeftButton)
    assert (tmp_path / "report.txt").read_text(encoding="utf-8") == copied
    assert str(tmp_path / "no" / "such" / "place.txt") in window.told.text()


def test_going_on_and_closing(reporter, notifier, qtbot):
    notifier.exception(KeyError("k"))
    window = shown(reporter, qtbot)
    with qtbot.assertNotEmitted(reporter.close_asked):
        qtbot.mouseClick(window.go_on_button, Qt.MouseButton.LeftButton)
    assert not window.isVisible()
    notifier.exception(KeyError("again"))
    shown(reporter, qtbot)
    with qtbot.waitSignal(reporter.close_asked):
        qtbot.mouseClick(window.close_button, Qt.MouseButton.LeftButton)


def test_a_mistake_of_a_person_opens_no_window(reporter, notifier, qtbot):
    notifier.tell("error", "found A, expected B")
    notifier.tell("fault", "broken")
    shown(reporter, qtbot)
    assert reporter._faults.count == 1


def test_the_report_can_be_had_at_any_time(reporter, place, qtbot):
    place[0] = None
    reporter.show_report()
    window = shown(reporter, qtbot)
    assert "No fault" in window.what.text()
    assert "No session" in window.safe.text()


def test_a_crash_of_the_process_is_told_by_the_next_one(reporter, notifier, qtbot, tmp_path):
    folder = tmp_path / "state"
    done = subprocess.run(
        [sys.executable, "-c", CRASH, str(folder)],
        env=os.environ | {"QT_QPA_PLATFORM": "offscreen"}, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    watched = HardCrashes(folder)
    assert "deep_inside" in watched.previous
    assert [path.name for path in folder.iterdir()] == [f"crash-{os.getpid()}.txt"]
    watched.end()
    assert list(folder.iterdir()) == []
    after = HardCrashes(folder)
    after.end()
    assert after.previous is None
    reporter.tell_of_before(watched.previous)
    window = shown(reporter, qtbot)
    assert "when it ran last" in window.what.text()
    assert "deep_inside" in window.details.toPlainText()
    assert any("ended by a crash" in one.text for one in notifier.entries)


def test_the_program_tells_of_its_crash_at_the_next_start(tmp_path):
    homes = ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME")
    environment = os.environ | dict.fromkeys(homes, str(tmp_path))
    environment["QT_QPA_PLATFORM"] = "offscreen"
    told = []
    for verb in ("crash", "look"):
        done = subprocess.run(
            [sys.executable, "-c", STARTED, verb],
            env=environment, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60,
        )  # fmt: skip
        told.append((done.returncode, done.stdout.strip()))
    assert told[0] == (-signal.SIGSEGV, "")
    assert told[1] == (0, "The program ended by a crash when it ran last.")
    assert list(tmp_path.rglob("crash-*.txt")) == []


@pytest.fixture(autouse=True)
def handlers():
    """Faults of the tests' own process go where they went before."""
    yield
    faulthandler.enable(sys.__stderr__)


def test_files_of_processes_that_live_or_were_killed(tmp_path):
    (tmp_path / "crash-1.txt").touch()  # of a process that lives
    (tmp_path / "crash-999999999.txt").touch()  # and of one that does not
    (tmp_path / "crash-odd.txt").write_bytes(b"\xff\xfe")
    (tmp_path / "other.txt").touch()
    watched = HardCrashes(tmp_path)
    watched.end()
    assert watched.previous is None
    assert sorted(one.name for one in tmp_path.iterdir()) == ["crash-1.txt", "other.txt"]


def test_a_state_folder_that_cannot_be_made_stops_nothing(tmp_path):
    (tmp_path / "file").touch()
    watched = HardCrashes(tmp_path / "file" / "state")
    assert watched.previous is None
    watched.end()


def test_nothing_happened_before(reporter, notifier):
    reporter.tell_of_before(None)
    assert notifier.entries == ()
    assert reporter.window is None


def test_a_report_holds_paths_and_nothing_else_of_a_person(monkeypatch):
    monkeypatch.setenv("GEORIBBON_SECRET", "not to be told")
    text = report("", [Entry("info", "opened", "detail")], None)
    assert "not to be told" not in text
    assert "session: none" in text
    assert "detail" not in text
