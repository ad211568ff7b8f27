"""A virtual ribbon whose seconds are short, and a window with one: for tests of whole jobs."""

import time

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import Settings
from georibbon.gui.window import MainWindow
from georibbon.virtual import VirtualRibbon

LONG = 60_000  # ms that anything may take on a busy machine


def quicken(monkeypatch, times):
    """Every virtual ribbon that is made has so many of its seconds in one of ours."""
    origin = time.monotonic()

    def clock():
        return origin + times * (time.monotonic() - origin)

    monkeypatch.setattr(
        "georibbon.virtual.VirtualRibbon", lambda settings: VirtualRibbon(settings, clock=clock)
    )


class Person:
    """Somebody in front of a window: clicks, keys and looks."""

    def __init__(self, qtbot, folder, monkeypatch):
        monkeypatch.setenv("XDG_DATA_HOME", str(folder / "data"))
        settings = Settings(folder / "settings.ini")
        settings.folder = folder
        settings.sound = False
        self.qtbot = qtbot
        self.window = MainWindow(settings, Notifier())
        qtbot.addWidget(self.window)
        self.window.show()
        qtbot.waitExposed(self.window)
        self.come_forward()  # without a window manager nobody else gives it the keys

    def click(self, widget):
        """Click on a widget that can be seen and used."""
        self.wait(lambda: widget.isVisible() and widget.isEnabled())
        self.qtbot.mouseClick(widget, Qt.MouseButton.LeftButton, pos=widget.rect().center())

    def tick(self, box, on=True):
        """Tick a box where it is not as wanted."""
        self.wait(lambda: box.isVisible() and box.isEnabled())
        if box.isChecked() != on:
            box.setFocus()
            self.qtbot.keyClick(box, Qt.Key.Key_Space)
        assert box.isChecked() == on

    def type(self, widget, text):
        """Type a text in the place of what is there, and Return."""
        widget.setFocus()
        widget.selectAll()
        self.qtbot.keyClicks(widget, text)
        self.qtbot.keyClick(widget, Qt.Key.Key_Return)

    def press(self, key, modifier=Qt.KeyboardModifier.NoModifier):
        """Press a key, wherever the focus is."""
        self.come_forward()
        self.qtbot.keyClick(QApplication.focusWidget() or self.window, key, modifier)

    def come_forward(self):
        """Have the keys: the window of another test may have taken them meanwhile."""
        front = QApplication.activeModalWidget() or QApplication.activeWindow() or self.window

        def has_the_keys():
            if QApplication.activeWindow() is None:
                front.activateWindow()
            return QApplication.activeWindow() is not None

        self.wait(has_the_keys)

    def wait(self, until, timeout=LONG):
        """Wait until something is so."""
        self.qtbot.waitUntil(until, timeout=timeout)
