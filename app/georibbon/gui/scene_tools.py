"""Pointing in the 3D view: a place, the distance of two, the section through two.

What takes longer than a moment, the way over the surface, is found in a worker.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QRunnable, Qt, QThreadPool, Signal

from georibbon.errors import GeoribbonError
from georibbon.gui.language import tr

if TYPE_CHECKING:
    from georibbon.gui.scene_stage import Stage
    from georibbon.reconstruction import Reconstruction
    from georibbon.scene.measuring import Distance, Pick, Probe, Section

TOOLS = ("none", "point", "distance", "section")


class _Work(QRunnable):
    """Work for the worker thread; `done` is told its number and its result or error."""

    def __init__(self, number: int, work: Callable[[], object], done: Callable[..., None]) -> None:
        super().__init__()
        self._number, self._work, self._done = number, work, done

    def run(self) -> None:
        """Called by Qt in the worker thread; nothing may be raised from here."""
        try:
            result = self._work()
        except Exception as error:
            result = error
        self._done(self._number, result)


class Tools(QObject):
    """The tool in the hand, what it has touched so far, and what it found.

    picked(Pick), measured(Distance), sectioned(Section): found.  changed(tool):
    another of TOOLS is in the hand.  hinted(sentence): what to do next, or why
    nothing was found; empty where there is nothing to say.  fault(exception):
    what is ours.
    """

    picked = Signal(object)
    measured = Signal(object)
    sectioned = Signal(object)
    changed = Signal(str)
    hinted = Signal(str)
    fault = Signal(object)
    _finished = Signal(int, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.tool = "none"
        self.upright = True  # whether sections stand upright, or lie along the line of sight
        self._stage: Stage | None = None
        self._result: Reconstruction | None = None
        self._probe: Probe | None = None
        self._first: Pick | None = None
        self._number = 0  # of what was begun last, whose marks are shown
        self._wanted = 0  # what was begun before this one is wanted no more
        self._pool = QThreadPool(self)
        self._pool.setMaxThreadCount(1)
        self._finished.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    def follow(self, stage: Stage | None, result: Reconstruction | None) -> None:
        """Another result is shown: what was measured on the one before goes."""
        self._stage = stage
        if result is not self._result:
            self._result, self._probe = result, None
            self.clear()

    def choose(self, tool: str) -> None:
        """Take another of TOOLS into the hand."""
        if tool not in TOOLS:
            raise ValueError(f"there is no tool {tool}")
        if tool != self.tool:
            self.tool = tool
            self._begin_anew()
            if self._stage is not None and tool == "none":
                self._stage.show_cross(False)
            self.changed.emit(tool)

    def clear(self) -> None:
        """Forget what was touched, and take its marks away; what is being found is dropped."""
        self._begin_anew()
        self._wanted = self._number

    def _begin_anew(self) -> None:
        self._first = None
        self._number += 1
        self._mark([], [])
        self.hinted.emit(self._hint())

    def click(self, x: float, y: float) -> None:
        """Touch what is seen there: device pixels from the upper left corner."""
        if self._stage is None or self._result is None or self.tool == "none":
            return
        if self._probe is None:
            from georibbon.scene.measuring import Probe

            self._probe = Probe(self._result)
        pick = self._probe.hit(*self._stage.line_of_sight(x, y))
        if pick is None:
            self.hinted.emit(tr("There is nothing there: click the surface or a pass."))
        elif self.tool == "point":
            self._mark([pick], [])
            self.picked.emit(pick)
            self.hinted.emit(self._hint())
        elif self._first is None:
            self._number += 1
            self._first = pick
            self._mark([pick], [])
            self.hinted.emit(self._hint())
        else:
            self._second(self._first, pick)

    def _second(self, first: Pick, second: Pick) -> None:
        import numpy as np

        probe, tool, self._first = self._probe, self.tool, None
        self._mark([first, second], [np.stack((first.position, second.position))])
        sight = None if self.upright else self._stage.sight

        def work() -> Distance | Section:
            if tool == "section":
                return probe.section(first, second, sight)
            return probe.distance(first, second)

        self._number += 1
        self._pool.start(_Work(self._number, work, self._finished.emit))

    def _deliver(self, number: int, found: object) -> None:
        from georibbon.scene.measuring import Distance, Section

        if number < self._wanted:
            return
        newest = number == self._number  # else another place is touched already
        if newest:
            self.hinted.emit(self._hint())
        if isinstance(found, Distance):
            lines = [found.path] if len(found.path) else []
            straight = [one.position for one in (found.first, found.second)]
            if newest:
                self._mark([found.first, found.second], [*lines, _stack(straight)])
            self.measured.emit(found)
        elif isinstance(found, Section):
            if newest:
                self._mark([found.first, found.second], [found.points])
            self.sectioned.emit(found)
        elif not isinstance(found, GeoribbonError):
            self.fault.emit(found)
        elif newest:
            self.hinted.emit(str(found))

    def _mark(self, picks: list[Pick], curves: list) -> None:
        if self._stage is not None:
            self._stage.show_marks(_stack([pick.position for pick in picks]), curves)

    def _hint(self) -> str:
        if self.tool == "point":
            return tr("Click a place on the surface.")
        if self.tool == "none":
            return ""
        return tr("Click the second place.") if self._first else tr("Click the first place.")


def _stack(places: list):
    import numpy as np

    return np.array(places, dtype=float).reshape(-1, 3)
