"""One pass's smoothing: a slider over decades, a number in millimetres, and back to automatic."""

import math

from PySide6.QtCore import QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QHBoxLayout, QPushButton, QSlider, QWidget

# Those of `reconstruction`, whose import would keep the window from showing.
SHORTEST_SMOOTHING, LONGEST_SMOOTHING = 0.001, 10.0
SHORTEST, LONGEST = 0.005, 1.0  # metres, on the slider
STEPS = 400
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


class _Number(QDoubleSpinBox):
    """A number with the same manners."""

    def wheelEvent(self, event) -> None:
        """Turn the number, or have the table scrolled."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


class SmoothingControl(QWidget):
    """What a person wants of one pass, or of all others.

    previewed(metres): while it moves.  chosen(metres): to be kept.  reset():
    automatic again.
    """

    previewed = Signal(float)
    chosen = Signal(float)
    reset = Signal()

    def __init__(self, whose: str, automatic: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settling = QTimer(self)
        self._settling.setSingleShot(True)
        self._settling.setInterval(SETTLE_MS)
        self._settling.timeout.connect(self._settle)
        self.slider = _Slider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, STEPS)
        self.slider.setPageStep(STEPS // 20)
        self.slider.setSingleStep(STEPS // 100)
        self.slider.setMinimumWidth(80)
        self.slider.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.slider.setAccessibleName(f"Smoothing of {whose}, 5 to 1000 mm")
        self.slider.setToolTip(f"The finest detail that {whose} follows")
        self.number = _Number()
        self.number.setRange(1e3 * SHORTEST_SMOOTHING, 1e3 * LONGEST_SMOOTHING)
        self.number.setDecimals(0)
        self.number.setSuffix(" mm")
        self.number.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.number.setFixedWidth(self.number.fontMetrics().horizontalAdvance("10000 mm") + 16)
        self.number.setKeyboardTracking(False)
        self.number.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.number.setAccessibleName(f"Smoothing of {whose} in millimetres")
        self.back = QPushButton(automatic)
        self.back.setCheckable(True)
        self.back.setFixedWidth(self.back.fontMetrics().horizontalAdvance("automatic") + 20)
        self.back.setAccessibleName(f"Smoothing of {whose}: {automatic}")
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 0, 4, 0)
        row.addWidget(self.slider, 1)
        row.addWidget(self.number)
        row.addWidget(self.back)
        self.slider.valueChanged.connect(self._moved)
        self.slider.sliderReleased.connect(self._settle)
        self.number.valueChanged.connect(self._typed)
        self.back.clicked.connect(self._go_back)

    @property
    def held(self) -> bool:
        """Whether a person is moving it."""
        return self.slider.isSliderDown() or self._settling.isActive()

    def show_value(self, metres: float | None, own: bool, automatic: str) -> None:
        """Show a length; own: it was chosen here; automatic: what it is otherwise."""
        self.back.setText(automatic)
        with QSignalBlocker(self.back):
            self.back.setChecked(not own)
        self.back.setToolTip(f"It is {automatic}" if not own else f"Back to {automatic}")
        if metres is None or self.held:
            return
        with QSignalBlocker(self.slider), QSignalBlocker(self.number):
            self.slider.setValue(to_step(metres))
            self.number.setValue(1e3 * metres)

    def _moved(self, step: int) -> None:
        metres = to_metres(step)
        with QSignalBlocker(self.number):
            self.number.setValue(1e3 * metres)
        self.previewed.emit(metres)
        if not self.slider.isSliderDown():
            self._settling.start()

    def _settle(self) -> None:
        self._settling.stop()
        self.chosen.emit(to_metres(self.slider.value()))

    def _typed(self, millimetres: float) -> None:
        self._settling.stop()
        with QSignalBlocker(self.slider):
            self.slider.setValue(to_step(1e-3 * millimetres))
        self.chosen.emit(1e-3 * millimetres)

    def _go_back(self) -> None:
        self._settling.stop()
        self.reset.emit()
        if not self.back.isChecked():  # it was automatic already
            with QSignalBlocker(self.back):
                self.back.setChecked(True)
