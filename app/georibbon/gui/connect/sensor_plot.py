"""The last seconds of one sensor's axes, in pyqtgraph; loaded when it is first shown."""

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from georibbon.arrays import FloatArray
from georibbon.gui.connect.raw import KEPT
from georibbon.gui.connect.words import UNIT_OF
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of
from georibbon.ribbon import AXIS_LETTERS, Sensor

BINS = 600  # along the time: two points each where there are more frames than that
BREAK = 5.0  # frame times without a frame, beyond which no line is drawn
LEAST_SPAN = 0.02  # of the vertical axis: noise alone does not fill the plot


class SensorPlot(QWidget):
    """One plot, a line for every axis; `told` says which colour is which, and what is thinned."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sensor: Sensor | None = None
        self._rate = 1.0
        self._points = 0
        self.plot = pg.PlotWidget()
        self.plot.setAccessibleName(tr("The last seconds of the chosen sensor"))
        self.plot.setMenuEnabled(False)
        self.plot.hideButtons()
        self.plot.setMouseEnabled(x=False, y=False)
        self.plot.showGrid(x=True, y=True, alpha=0.25)
        self.plot.setXRange(-KEPT, 0.0, padding=0.0)
        self.plot.getAxis("left").setWidth(52)
        for name in ("left", "bottom"):
            self.plot.getAxis(name).enableAutoSIPrefix(False)
        self.lines = [self.plot.plot(antialias=False) for _ in AXIS_LETTERS]
        self.told = QLabel()
        self.told.setAccessibleName(tr("What the lines are"))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self.told)
        layout.addWidget(self.plot, 1)
        self._colour()

    def show_sensor(self, sensor: Sensor | None, rate: float) -> None:
        """Show another sensor from now on; rate: frames a second."""
        self._sensor, self._rate, self._points = sensor, rate, 0
        for line in self.lines:
            line.setData([], [])
        if sensor is not None:
            self.plot.setLabel("left", tr(UNIT_OF[sensor.kind]))
            self.plot.setLabel("bottom", tr("seconds before now"))
        self._tell()

    def show_values(self, t: FloatArray, values: FloatArray) -> None:
        """Show (m,) seconds before now and (m, axes) values."""
        if self._sensor is None or not len(t):
            return
        x, y = thinned(t, values, BINS)
        if (len(x) != len(t)) != (self._points < 0):
            self._points = -1 if len(x) != len(t) else 0
            self._tell()
        near = np.diff(x, append=x[-1]) < BREAK * max(1.0 / self._rate, KEPT / BINS)
        for k, line in enumerate(self.lines):
            if k < y.shape[1]:
                good = np.isfinite(y[:, k])
                connect = good & np.append(good[1:], False) & near
                line.setData(x, np.nan_to_num(y[:, k]), connect=connect.astype(np.int32))
            else:
                line.setData([], [])
        self._set_range(y)

    def _set_range(self, y: FloatArray) -> None:
        """Room for all values, in steps, so that the axis does not tremble with the noise."""
        if not np.isfinite(y).any():
            return
        low, high = float(np.nanmin(y)), float(np.nanmax(y))
        step = max(high - low, LEAST_SPAN) / 4.0
        step = 10.0 ** np.ceil(np.log10(step)) / 2.0
        low, high = np.floor(low / step) * step, np.ceil(high / step) * step
        if (low, high) != tuple(self.plot.viewRange()[1]):
            self.plot.setYRange(low, high, padding=0.0)

    def _tell(self) -> None:
        of = colours_of(self.palette())
        if self._sensor is None:
            self.told.setText(tr("Choose a sensor to see its last seconds."))
            return
        letters = AXIS_LETTERS[: self._sensor.axes]
        names = [
            f'<span style="color:{of.curves[k]}"><b>───</b></span> {self._sensor.name}{letter}'
            for k, letter in enumerate(letters)
        ]
        if self._points < 0:
            names.append(tr("of several frames the least and the greatest is drawn"))
        self.told.setText(" &nbsp; ".join(names))

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "told"):
            self._colour()

    def _colour(self) -> None:
        of = colours_of(self.palette())
        self.plot.setBackground(of.base)
        for line, colour in zip(self.lines, of.curves, strict=False):
            line.setPen(pg.mkPen(colour, width=1))
        for name in ("left", "bottom"):
            axis = self.plot.getAxis(name)
            axis.setPen(of.frame)
            axis.setTextPen(of.words)
        self._tell()


def thinned(x: FloatArray, y: FloatArray, bins: int) -> tuple[FloatArray, FloatArray]:
    """(m,) and (m, k) as they are, or of every bin the least and the greatest of each column.

    A bin whose values are all NaN stays NaN.
    """
    size = len(x) // bins
    if size < 2:
        return x, y
    kept = len(x) // size * size
    x, y = x[len(x) - kept :], y[len(y) - kept :]
    boxes = y.reshape(-1, size, y.shape[1])
    there = np.isfinite(boxes)
    some = there.any(axis=1)
    low = np.where(some, np.where(there, boxes, np.inf).min(axis=1), np.nan)
    high = np.where(some, np.where(there, boxes, -np.inf).max(axis=1), np.nan)
    times = x.reshape(-1, size)
    both = np.stack([low, high], axis=1).reshape(-1, y.shape[1])
    return np.stack([times[:, 0], times[:, size // 2]], axis=1).ravel(), both
