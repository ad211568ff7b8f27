"""One place for all that is told: errors, warnings, and what nobody caught, on any thread."""

import sys
import threading
import warnings

import pytest
from PySide6.QtCore import QThread
from PySide6.QtGui import QGuiApplication

from georibbon.errors import SessionError
from georibbon.gui.log import Banner, Bell, LogPanel
from georibbon.gui.notifier import MOST_KEPT, Notifier


@pytest.fixture
def notifier():
    made = Notifier()
    made.install()
    yield made
    made.uninstall()


def test_the_hooks_are_put_back():
    before = (sys.excepthook, threading.excepthook, warnings.showwarning)
    made = Notifier()
    made.install()
    assert sys.excepthook is not before[0]
    made.uninstall()
    made.uninstall()
    assert (sys.excepthook, threading.excepthook, warnings.showwarning) == before


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
