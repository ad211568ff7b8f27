"""What a person may choose of one pass, or of all: weight, trimmed ends, sensors."""

import math

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QDoubleSpinBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.document import EVERY_PASS
from georibbon.gui.language import tr, trn
from georibbon.gui.length_box import LengthBox
from georibbon.gui.parts import Parts
from georibbon.gui.sensor_list import NAMED, SensorLine, SensorList

# As in `session.settings` and `fitting.settings`, whose import would keep the window waiting.
OF_PASS = ("smoothing", "sensors_off", "trim", "weight")
LEAST_WEIGHT, MOST_WEIGHT = 0.01, 100.0
MOST_TRIM = 10.0


class PassDetails(QWidget):
    """The choices of the pass that is looked at, or of "*"."""

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._document, self._units = parts.document, parts.units
        self._whose = EVERY_PASS
        self.title = QLabel()
        self.title.setTextFormat(Qt.TextFormat.PlainText)
        font = self.title.font()
        font.setBold(True)
        self.title.setFont(font)
        self.reset = QPushButton()
        self.weight = _weight_box()
        self.start = LengthBox(self._units, 0.0, MOST_TRIM, 5e-3)
        self.end = LengthBox(self._units, 0.0, MOST_TRIM, 5e-3)
        self.sensors = SensorList(self._units)
        self.switched_off = QLabel()
        self._lay_out()
        self.weight.valueChanged.connect(self._weighed)
        self.start.edited.connect(lambda _: self._trimmed())
        self.end.edited.connect(lambda _: self._trimmed())
        self.sensors.switched.connect(self._switched)
        self.reset.clicked.connect(lambda: self._document.reset_settings(OF_PASS, self._whose))
        self.look_at(EVERY_PASS)

    def _lay_out(self) -> None:
        head = QHBoxLayout()
        head.addWidget(self.title, 1)
        head.addWidget(self.reset)
        grid = QGridLayout()
        self.weight_label, self.start_label, self.end_label = QLabel(), QLabel(), QLabel()
        for column, (label, box, text) in enumerate(
            (
                (self.weight_label, self.weight, tr("&Weight")),
                (self.start_label, self.start, tr("Cut off at the &beginning")),
                (self.end_label, self.end, tr("Cut off at the e&nd")),
            )
        ):
            label.setText(text)
            label.setBuddy(box)
            grid.addWidget(label, 0, column)
            grid.addWidget(box, 1, column)
        tip = tr("How many times a pass counts against its neighbours and the survey")
        self.weight.setToolTip(tip)
        for box in (self.start, self.end):
            box.setToolTip(
                tr("So much is left out of the curve and of the surface; the fit uses it all")
            )
        column = QVBoxLayout(self)
        column.setContentsMargins(6, 4, 6, 0)
        column.setSpacing(4)
        column.addLayout(head)
        column.addLayout(grid)
        column.addWidget(self.switched_off)
        column.addWidget(self.sensors, 1)

    def look_at(self, whose: str) -> None:
        """Show the choices of a pass, or of "*"."""
        self._whose = whose
        every = whose == EVERY_PASS
        self.title.setText(
            tr("All passes without their own") if every else tr("Pass {name}", name=whose)
        )
        self.reset.setText(tr("Reset for all") if every else tr("Reset this pass"))
        self.reset.setToolTip(tr("Smoothing, weight, cut ends and sensors as they were at first"))
        self.refresh()

    def refresh(self) -> None:
        """Show what is chosen now, and what came of it."""
        document = self._document
        self.setEnabled(document.path is not None)
        if document.path is None:
            self.sensors.show_lines([])
            return
        settings = document.settings
        own = {key for whose, key in document.values if whose == self._whose}
        self.reset.setEnabled(bool(own & set(OF_PASS)))
        with QSignalBlocker(self.weight):
            self.weight.setValue(settings.weight_of(self._whose))
        start, end = settings.trim_of(self._whose)
        self.start.set_metres(start)
        self.end.set_metres(end)
        lines = sensor_lines(document.reconstruction, settings, self._whose)
        self.sensors.show_lines(lines)
        off = sum(not line.on for line in lines)
        odd = sum(line.on and (line.off_by or 0.0) > NAMED for line in lines)
        self.switched_off.setText(
            tr("Sensors")
            + ": "
            + trn("{n} switched off", "{n} switched off", off)
            + ", "
            + trn("{n} disagrees", "{n} disagree", odd)
        )

    def _weighed(self, weight: float) -> None:
        self._document.set_setting(self._whose, "weight", weight)

    def _trimmed(self) -> None:
        ends = [self.start.metres, self.end.metres]
        self._document.set_setting(self._whose, "trim", ends)

    def _switched(self, off: list[str]) -> None:
        self._document.set_setting(self._whose, "sensors_off", off or None)


def _weight_box() -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    box.setRange(LEAST_WEIGHT, MOST_WEIGHT)
    box.setDecimals(2)
    box.setStepType(QAbstractSpinBox.StepType.AdaptiveDecimalStepType)
    box.setKeyboardTracking(False)
    box.setPrefix("× ")
    return box


def sensor_lines(result, settings, whose: str) -> list[SensorLine]:
    """The sensors' lines of a pass, or of "*" with the pass in which each is off by most."""
    if result is None:
        return []
    passes = [one for one in result.passes if whose in (EVERY_PASS, one.name)]
    every = settings.off_in(EVERY_PASS)
    here = settings.off_in(whose)
    lines = []
    for i, sensor in enumerate(result.ribbon.sensors):
        sizes = [(_size(one.residuals[i]), one.name) for one in passes]
        said = [(size, name) for size, name in sizes if size is not None]
        worst, of = max(said) if said else (None, None)
        lines.append(
            SensorLine(
                name=sensor.name,
                kind=sensor.kind,
                at=sensor.position,
                off_by=None if sensor.name in here else worst,
                of=of if whose == EVERY_PASS and sensor.name not in here else None,
                on=sensor.name not in here,
                fixed=whose != EVERY_PASS and sensor.name in every,
            )
        )
    return lines


def _size(residuals) -> float | None:
    """The length of (3,) normalised residuals, of the axes there are; None without any."""
    values = [float(one) for one in residuals if not math.isnan(one)]
    return math.hypot(*values) if values else None
