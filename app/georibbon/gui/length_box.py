"""A box for a length: typed and shown in the unit in use, metres for the program."""

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QWidget

from georibbon.gui.units import Units


class LengthBox(QDoubleSpinBox):
    """A length between two bounds, metres.

    edited(metres): a person has changed it; not on every key, but on Return, on
    an arrow, and where the focus goes on.
    """

    edited = Signal(float)

    def __init__(
        self,
        units: Units,
        low: float,
        high: float,
        step: float = 1e-3,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._units, self._low, self._high, self._step = units, low, high, step
        self._metres = low
        self.setKeyboardTracking(False)
        self.valueChanged.connect(self._changed)
        units.changed.connect(self._take_unit)
        self._take_unit()

    @property
    def metres(self) -> float:
        """The length that is shown."""
        return self._metres

    def set_metres(self, metres: float) -> None:
        """Show a length; nothing is emitted."""
        self._metres = min(max(metres, self._low), self._high)
        with QSignalBlocker(self):
            self.setValue(self._units.value(self._metres))

    def _take_unit(self) -> None:
        units = self._units
        with QSignalBlocker(self):
            self.setDecimals(units.unit.decimals + 1)
            self.setRange(units.value(self._low), units.value(self._high))
            self.setSingleStep(units.value(self._step))
            self.setSuffix(f" {units.symbol}")
        self.set_metres(self._metres)

    def _changed(self, value: float) -> None:
        self._metres = self._units.metres(value)
        self.edited.emit(self._metres)
