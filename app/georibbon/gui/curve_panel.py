"""Curves along the passes, in pyqtgraph."""

from collections.abc import Sequence

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget


class CurvePanel(QWidget):
    """Quantities of chosen passes along their arc length."""

    cursor_moved = Signal(str, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._names: tuple[str, ...] = ()

    def show_passes(self, reconstruction, names: Sequence[str]) -> None:
        """Show these passes of a result; all of them where `names` is empty; None for nothing."""
        self._names = tuple(names) if reconstruction is not None else ()
