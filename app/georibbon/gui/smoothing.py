"""One pass's smoothing: a slider over decades, a length, and back to automatic."""

import math

from PySide6.QtCore import QLocale, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QHBoxLayout, QPushButton, QSlider, QWidget

from georibbon.gui.language import N_, tr
from georibbon.gui.length_box import LengthBox
from georibbon.gui.units import Units

# Those of `reconstruction`, whose import would keep the window from showing.
SHORTEST_SMOOTHING, LONGEST_SMOOTHING = 0.001, 10.0
SHORTEST, LONGEST = 0.005, 1.0  # metres, on the slider
STEPS = 400
AUTOMATIC, AS_ALL = N_("auto"), N_("as all")
SETTLE_MS = 500  # after the last key or turn of the wheel what is shown is kept


def to_metres(step: int) -> float:
    """The length at a step of the slider: from 5 mm to 1000 mm, in equal ratios."""
    return SHORTEST * (LONGEST / SHORTEST) ** (step / STEPS)


def to_step(metres: float) -> int:
    """The step of the slider nearest to a length."""
    share = math.log(metres / SHORTEST) / math.log(LONGEST / SHORTEST)
    return round(STEPS * min(max(share, 0.0), 1.0))


class _Slider(QSlider):
    """A slider that a wheel turns only where it was chosen: the table is scrolled over it."""

    def wheelEvent(self, event) -> None:
        """Turn the slider, or have the table scrolled."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


class _Number(LengthBox):
    """A length with the same manners, written without zeros that say nothing."""

    def wheelEvent(self, event) -> None:
        """Turn the number, or have the table scrolled."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def textFromValue(self, value: float) -> str:
        """The value as short as it can be: four digits tell a smoothing."""
        locale = self.locale()
        locale.setNumberOptions(QLocale.NumberOption.OmitGroupSeparator)
        return locale.toString(float(f"{value:.4g}"), "g", 6)


class SmoothingControl(QWidget):
    """What a person wants of one pass, or of all others.

    previewed(metres): while it moves.  chosen(metres): to be kept.  reset():
    automatic again.
    """

    previewed = Signal(float)
    chosen = Signal(float)
    reset = Signal()

    def __init__(
        self, units: Units, whose: str, automatic: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._units, self._whose = units, whose
        self._settling = QTimer(self)
        self._settling.setSingleShot(True)
        self._settling.setInterval(SETTLE_MS)
        self._settling.timeout.connect(self._settle)
        self.slider = _Slider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, STEPS)
        self.slider.setPageStep(STEPS // 20)
        self.slider.setSingleStep(STEPS // 100)
        self.slider.setMinimumWidth(60)
        self.slider.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.slider.setToolTip(tr("The finest detail that {whose} follows", whose=whose))
        self.number = _Number(units, SHORTEST_SMOOTHING, LONGEST_SMOOTHING)
        self.number.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.number.setFixedWidth(self.number.fontMetrics().horizontalAdvance("9999 mm") + 16)
        self.number.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.number.setAccessibleName(tr("Smoothing of {whose}, a length", whose=whose))
        self.back = QPushButton(automatic)
        self.back.setCheckable(True)
        words = max((automatic, tr(AS_ALL)), key=len)
        self.back.setFixedWidth(self.back.fontMetrics().horizontalAdvance(words) + 18)
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 0, 4, 0)
        row.setSpacing(4)
        row.addWidget(self.slider, 1)
        row.addWidget(self.number)
        row.addWidget(self.back)
        self.slider.valueChanged.connect(self._moved)
        self.slider.sliderReleased.connect(self._settle)
        self.number.edited.connect(self._typed)
        self.back.clicked.connect(self._go_back)
        units.changed.connect(self._name)
        self._name()

    def _name(self) -> None:
        low, high = self._units.text(SHORTEST), self._units.text(LONGEST)
        self.slider.setAccessibleName(
            tr("Smoothing of {whose}, {low} to {high}", whose=self._whose, low=low, high=high)
        )

    @property
    def held(self) -> bool:
        """Whether a person is moving it."""
        return self.slider.isSliderDown() or self._settling.isActive()

    def show_value(self, metres: float | None, own: bool, automatic: str) -> None:
        """Show a length; own: it was chosen here; automatic: what it is otherwise."""
        self.back.setText(automatic)
        with QSignalBlocker(self.back):
            self.back.setChecked(not own)
        way = tr("Back to {way}", way=automatic) if own else tr("It is {way}", way=automatic)
        self.back.setToolTip(way)
        self.back.setAccessibleName(
            tr("Smoothing of {whose}: {way}", whose=self._whose, way=automatic)
        )
        if metres is None or self.held:
            return
        with QSignalBlocker(self.slider):
            self.slider.setValue(to_step(metres))
        self.number.set_metres(metres)

    def set_useful(self, useful: bool) -> None:
        """Whether smoothing does anything; where not, it says so and cannot be moved."""
        self.setEnabled(useful)
        self.setToolTip("" if useful else tr("Passes fitted from tangents are not smoothed"))

    def _moved(self, step: int) -> None:
        metres = to_metres(step)
        self.number.set_metres(metres)
        self.previewed.emit(metres)
        if not self.slider.isSliderDown():
            self._settling.start()

    def _settle(self) -> None:
        self._settling.stop()
        self.chosen.emit(to_metres(self.slider.value()))

    def _typed(self, metres: float) -> None:
        self._settling.stop()
        with QSignalBlocker(self.slider):
            self.slider.setValue(to_step(metres))
        self.chosen.emit(metres)

    def _go_back(self) -> None:
        self._settling.stop()
        self.reset.emit()
        if not self.back.isChecked():  # it was automatic already
            with QSignalBlocker(self.back):
                self.back.setChecked(True)
