"""The window on a stage: a hurried virtual ribbon, waiting, and taking pictures."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from clipped import clipped
from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import Settings
from georibbon.gui.window import MainWindow

LONGEST = 60.0  # s that anything may take
QUICK = 80  # of Qt's measure: the least compression of all but none, in a third of the time
TURN = 10  # ms
FAST, CALM = 5.0, 2.0  # times as fast
CALMED = 2500  # ms after which rates are those of now
SETTLED = 120  # ms after which what was asked for is drawn


class StageError(Exception):
    """Something that was waited for did not come."""


class Clock:
    """A clock whose seconds are shorter than ours, as many times as it is told."""

    def __init__(self) -> None:
        self._since = (1.0, time.monotonic(), 0.0)  # replaced as a whole: other threads look

    def __call__(self) -> float:
        """Its seconds."""
        times, ours, its = self._since
        return its + times * (time.monotonic() - ours)

    def run(self, times: float) -> None:
        """So many of its seconds in one of ours from now on."""
        self._since = (times, time.monotonic(), self())


@dataclass(frozen=True)
class Wishes:
    """What is wanted: the pictures' folder by their theme, and which; all where empty.

    calm: nothing is hurried so much that it shows in the figures.
    """

    folders: dict[str, Path]
    names: frozenset[str]
    calm: bool


class Stage:
    """A window whose pictures are taken.  lacking: what has no room, by picture."""

    def __init__(self, home: Path, wishes: Wishes, settings: Settings) -> None:
        self.home, self.clock = home, Clock()
        self.lacking: dict[str, list[str]] = {}
        self.taken: list[str] = []
        self._wishes, self._calm = wishes, wishes.calm
        self._themes = list(wishes.folders)
        self._speed_ribbons()
        self.window = MainWindow(settings, Notifier())
        self._size = (self.window.width(), self.window.height())

    def _speed_ribbons(self) -> None:
        """Every virtual ribbon goes by the stage's clock."""
        import georibbon.virtual as room

        made, clock = room.VirtualRibbon, self.clock
        room.VirtualRibbon = lambda settings: made(settings, clock=clock)

    def hurry(self) -> None:
        """What is not seen goes by fast."""
        self.clock.run(CALM if self._calm else FAST)

    def calm_down(self) -> None:
        """What is seen goes by as it does; calmly, its figures too."""
        self.clock.run(1.0)
        if self._calm:
            self.rest(CALMED)

    def wait(self, until: Callable[[], object], what: str) -> None:
        """Wait until something is so."""
        end = time.monotonic() + LONGEST
        while not until():
            if time.monotonic() > end:
                self.window.grab().save(str(self._folder / "failed.png"))
                raise StageError(f"{what} did not come within {LONGEST:g} s; see failed.png")
            QTest.qWait(TURN)

    def rest(self, ms: int = SETTLED) -> None:
        """Let it be drawn."""
        QTest.qWait(ms)

    def resize(self, width: int, height: int) -> None:
        """Give the window a size; told as lacking where it cannot be so small."""
        self._size = (width, height)
        self.window.resize(width, height)

    @property
    def _folder(self) -> Path:
        return self._wishes.folders[self.window.settings.theme]

    def _dress(self, theme: str) -> None:
        if theme != self.window.settings.theme:
            self.window.set_dark(theme == "dark")

    def take(self, name: str, widget: QWidget | None = None) -> None:
        """A picture of the window, or of a part of it."""
        if self._wishes.names and name not in self._wishes.names:
            return
        widget = widget or self.window
        for theme in tuple(self._themes):
            self._dress(theme)
            self.rest()
            if not widget.grab().save(str(self._folder / f"{name}.png"), "PNG", QUICK):
                raise StageError(f"{name}.png cannot be written into {self._folder}")
        self._themes.reverse()  # the next one begins as this one ended
        self.taken.append(name)
        found = clipped(widget.window())
        there = (widget.width(), widget.height())
        if widget is self.window and there != self._size:
            least = self.window.minimumSizeHint()
            found.append(
                f"the window is {there[0]} x {there[1]} and not {self._size[0]} x {self._size[1]}; "
                f"it needs {least.width()} x {least.height()}"
            )
        if found:
            self.lacking[name] = found

    def take_dialog(self, name: str, show: Callable[[], object]) -> None:
        """A picture of a dialog that keeps its caller waiting."""

        def look() -> None:
            dialog = QApplication.activeModalWidget()
            if dialog is not None:
                self.take(name, dialog)
                dialog.close()

        QTimer.singleShot(SETTLED, look)
        show()
