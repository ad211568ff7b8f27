"""Lengths as a person reads them: millimetres, centimetres or inches; metres everywhere else."""

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

INCH = 0.0254


@dataclass(frozen=True)
class Unit:
    """A unit of length: its symbol, its size in metres, its decimals for a tenth of a mm."""

    symbol: str
    metres: float
    decimals: int


UNITS = {one.symbol: one for one in (Unit("mm", 1e-3, 1), Unit("cm", 1e-2, 2), Unit("in", INCH, 3))}


class Units(QObject):
    """The unit in use, one for the whole window.

    changed: another is in use; what shows a length shows it anew.
    """

    changed = Signal()

    def __init__(self, symbol: str = "mm", parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._unit = UNITS.get(symbol, UNITS["mm"])

    @property
    def unit(self) -> Unit:
        """The unit in use."""
        return self._unit

    @property
    def symbol(self) -> str:
        """Its symbol."""
        return self._unit.symbol

    def use(self, symbol: str) -> None:
        """Take up another unit; KeyError for one that is none of `UNITS`."""
        unit = UNITS[symbol]
        if unit != self._unit:
            self._unit = unit
            self.changed.emit()

    def value(self, metres: float) -> float:
        """A length in the unit."""
        return metres / self._unit.metres

    def metres(self, value: float) -> float:
        """A value in the unit as metres."""
        return value * self._unit.metres

    def number(self, metres: float, finer: int = 0) -> str:
        """A length as a number without its unit; finer: by so many decimals more."""
        return f"{self.value(metres):.{self._unit.decimals + finer}f}"

    def text(self, metres: float, finer: int = 0) -> str:
        """A length as a number with its unit."""
        return f"{self.number(metres, finer)} {self.symbol}"
