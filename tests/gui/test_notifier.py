"""One place for all that is told: errors, warnings, and what nobody caught, on any thread."""

import sys
import threading
import warnings

import pytest
from PySide6.QtCore import Qt, QThread
from PySide6.QtGui import QGuiApplication

from georibbon.errors import SessionError
from georibbon.gui import dialogs
from georibbon.gui.log import Banner, Bell, LogPanel
from georibbon.gui.notifier import MOST_KEPT, Notifier


@pytest.fixture
def notifier():
    made = Notifier()
    made.install()
    yield made
    made.uninstall()


def test_the_hooks_are_put_back():
    def hooks():
        return sys.excepthook, threading.excepthook, sys.unraisablehook, warnings.showwarning

    before = hooks()
    made = Notifier()
    made.install()
    assert not set(hooks()) & set(before)
    made.uninstall()
    made.uninstall()
    assert hooks() == before


def test_a_mistake_and_a_fault_are_told_apart(notifier):
    notifier.exception(SessionError("found A, expected B, do C"))
    notifier.exception(KeyError("k"))
    mistake, fault = notifier.entries
    assert (mistake.level, mistake.text) == ("error", "found A, expected B, do C")
    assert fault.level == "fault"
    assert "KeyError: 'k'" in fault.text
    assert "KeyError" in fault.detail


def test_what_nobody_caught_is_told(notifier, capsys):
    def fail():
        raise RuntimeError("in a thread")

    thread = threading.Thread(target=fail)
    thread.start()
    thread.join()
    try:
        raise ValueError("in the main thread")
    except ValueError as error:
        sys.excepthook(ValueError, error, error.__traceback__)
    assert [one.level for one in notifier.entries] == ["fault", "fault"]
    assert 'raise RuntimeError("in a thread")' in notifier.entries[0].detail
    assert "in the main thread" in capsys.readouterr().err


def test_warnings_are_told(notifier):
    notifier._warned(UserWarning("mind this"), UserWarning, "here.py", 3)
    (entry,) = notifier.entries
    assert (entry.level, entry.text) == ("warning", "mind this")
    assert "here.py:3" in entry.detail


def test_what_cannot_be_raised_is_told(notifier):
    class Odd:
        def __del__(self):
            raise ValueError("on its way out")

    Odd()
    (entry,) = notifier.entries
    assert entry.level == "warning"
    assert "on its way out" in entry.text
    assert 'raise ValueError("on its way out")' in entry.detail


def test_no_more_is_kept_than_can_be_read():
    notifier = Notifier()
    for number in range(MOST_KEPT + 5):
        notifier.tell("info", str(number))
    assert [notifier.entries[0].text, len(notifier.entries)] == ["5", MOST_KEPT]


def test_the_bell_rings_on_the_main_thread(qtbot):
    notifier = Notifier()
    bell = Bell(notifier)
    on = []
    bell.rang.connect(lambda entry: on.append((entry.text, QThread.isMainThread())))
    thread = threading.Thread(target=notifier.tell, args=("info", "from afar"))
    thread.start()
    thread.join()
    qtbot.waitUntil(lambda: on == [("from afar", True)])
    bell.end()
    bell.end()
    notifier.tell("info", "unheard")
    assert len(on) == 1


def test_the_log_shows_and_copies(qtbot):
    notifier, panel = Notifier(), LogPanel()
    qtbot.addWidget(panel)
    notifier.listen(panel.add)
    notifier.tell("info", "opened part.georibbon")
    notifier.tell("fault", "broken", "Traceback\n  line 3\n")
    assert panel.table.topLevelItemCount() == 2
    panel.table.topLevelItem(1).setSelected(True)
    assert "line 3" in panel.details.toPlainText()
    panel.copy()
    copied = QGuiApplication.clipboard().text()
    assert "fault: broken\nTraceback\n  line 3" in copied
    assert "opened" not in copied
    panel.table.clearSelection()
    panel.copy_button.click()
    assert "information" not in QGuiApplication.clipboard().text()
    assert "info: opened part.georibbon" in QGuiApplication.clipboard().text()


def test_the_banner_shows_plain_text(qtbot):
    banner = Banner()
    qtbot.addWidget(banner)
    notifier = Notifier()
    notifier.listen(banner.show_entry)
    assert banner.isHidden()
    notifier.tell("error", "found <b>A</b>")
    assert not banner.isHidden()
    assert banner.text.text() == "Found <b>A</b>"


def test_the_log_is_filtered_by_kind_and_words(qtbot):
    notifier, panel = Notifier(), LogPanel()
    qtbot.addWidget(panel)
    notifier.listen(panel.add)
    for level in ("info", "warning", "error", "fault"):
        notifier.tell(level, f"{level} about Pass P1", "with details")
    assert len(panel.shown) == 4
    for key, left in ((Qt.Key.Key_Down, 3), (Qt.Key.Key_Down, 2), (Qt.Key.Key_Down, 1)):
        qtbot.keyClick(panel.level, key)
        assert len(panel.shown) == left
    notifier.tell("info", "not shown")
    assert [one.level for one in panel.shown] == ["fault"]
    qtbot.keyClick(panel.level, Qt.Key.Key_Home)
    with qtbot.waitActive(panel):
        panel.show()
        panel.activateWindow()
    panel.table.setFocus()
    qtbot.keyClick(panel, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
    qtbot.waitUntil(panel.search.hasFocus)
    qtbot.keyClicks(panel.search, "p1 DETAILS warn")
    assert [one.level for one in panel.shown] == ["warning"]
    panel.copy()
    assert QGuiApplication.clipboard().text().count("\n") == 1


def test_the_log_is_saved(qtbot, tmp_path, monkeypatch):
    notifier, panel = Notifier(), LogPanel()
    qtbot.addWidget(panel)
    notifier.listen(panel.add)
    notifier.tell("error", "broken", "here")
    for target in (tmp_path / "log.txt", tmp_path / "no" / "place.txt", None):
        monkeypatch.setattr(dialogs, "ask_target", lambda *_, target=target: target)
        panel.save_button.click()
    assert "error: broken\nhere\n" in (tmp_path / "log.txt").read_text(encoding="utf-8")
    assert str(tmp_path / "no" / "place.txt") in panel.told.text()


def test_the_log_drops_its_oldest_lines(qtbot, monkeypatch):
    monkeypatch.setattr("georibbon.gui.log.MOST_KEPT", 5)
    notifier, panel = Notifier(), LogPanel()
    qtbot.addWidget(panel)
    notifier.listen(panel.add)
    for number in range(8):
        notifier.tell("info", str(number))
    assert [one.text for one in panel.shown] == ["3", "4", "5", "6", "7"]
