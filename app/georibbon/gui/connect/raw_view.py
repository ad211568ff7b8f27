"""Every axis of the connected ribbon, live; a sensor is chosen in the drawing or in the table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QLabel, QSplitter, QVBoxLayout, QWidget

from georibbon.device.telling import LinkState
from georibbon.gui.connect.raw import RawReadings, RawState
from georibbon.gui.connect.ribbon_drawing import RibbonDrawing
from georibbon.gui.connect.sensor_table import SensorTable
from georibbon.gui.connect.words import sensor_words
from georibbon.gui.language import tr

if TYPE_CHECKING:
    from georibbon.device.identity import Identity
    from georibbon.device.link import Link
    from georibbon.device.ring import RingReader
    from georibbon.gui.connect.sensor_plot import SensorPlot
    from georibbon.gui.parts import Parts
    from georibbon.ribbon import Ribbon

EVERY = 40  # ms
SIZES = (300, 200)  # px: the table and the plot, as they share the height at first
ODD = ("lost", "saturated", "stuck")


class RawView(QWidget):
    """The ribbon to scale, all sensors in a table, and the last seconds of the chosen one.

    It takes the newest state 25 times a second, and only while it is seen.
    """

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units, self._station = parts.units, parts.station
        self._ribbon: Ribbon | None = None
        self._link: Link | None = None
        self._reader: RingReader | None = None
        self._readings: RawReadings | None = None
        self._plot: SensorPlot | None = None
        self.drawing = RibbonDrawing(parts.units)
        self.table = SensorTable(parts.units)
        self.where = QLabel()
        self.where.setWordWrap(True)
        self.where.setAccessibleName(tr("The chosen sensor"))
        self.where.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.hint = QLabel()
        self.hint.setWordWrap(True)
        self._timer = QTimer(self)
        self._timer.setInterval(EVERY)
        self._timer.timeout.connect(self._refresh)
        self._lay_out()
        self.drawing.chosen.connect(self.choose)
        self.table.chosen.connect(self.choose)
        parts.units.changed.connect(self._say_where)
        parts.station.identified.connect(self._take_ribbon)
        parts.station.changed.connect(self._say_how)
        parts.station.disconnected.connect(self._let_go)
        if parts.station.identity is not None:
            self._take_ribbon(parts.station.identity)
        self._say_where()
        self._say_how()

    @property
    def chosen(self) -> int | None:
        """The place of the chosen sensor in the ribbon's list."""
        return self.drawing.current

    @property
    def plot(self) -> SensorPlot | None:
        """The plot; None before it is first shown."""
        return self._plot

    def choose(self, sensor: int) -> None:
        """Choose a sensor in the drawing, the table and the plot, and say where it sits."""
        self.drawing.choose(sensor)
        self.table.choose(sensor)
        self._say_where()
        self._show_plot()

    def showEvent(self, event: QShowEvent) -> None:
        """Seen: the newest state from now on."""
        super().showEvent(event)
        if self._ribbon is not None:
            self._begin()

    def hideEvent(self, event: QHideEvent) -> None:
        """Not seen: nothing is done."""
        super().hideEvent(event)
        self._timer.stop()

    # --- inside ---

    def _lay_out(self) -> None:
        self._lower = QWidget()
        self._lower.setMinimumHeight(130)
        below = QVBoxLayout(self._lower)
        below.setContentsMargins(0, 0, 0, 0)
        self._split = QSplitter(Qt.Orientation.Vertical)
        self._split.setChildrenCollapsible(False)
        self._split.addWidget(self.table)
        self._split.addWidget(self._lower)
        self._split.setSizes(list(SIZES))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.hint)
        layout.addWidget(self.drawing)
        layout.addWidget(self.where)
        layout.addWidget(self._split, 1)

    def _take_ribbon(self, identity: Identity) -> None:
        """A ribbon answers: list its sensors; what was chosen stays where it is the same one."""
        ribbon, link = identity.ribbon, self._station.link
        if link is None or (ribbon == self._ribbon and link is self._link):
            return
        before = self.chosen if ribbon == self._ribbon else None
        self._ribbon, self._link = ribbon, link
        self._readings, self._reader = RawReadings(ribbon), link.ring.reader()
        self._readings.feed(link.ring.last(link.ring.capacity))
        self.drawing.show_ribbon(ribbon)
        self.table.show_ribbon(ribbon)
        self.choose(before or 0)
        if self.isVisible():
            self._begin()

    def _begin(self) -> None:
        self._timer.start()
        QTimer.singleShot(0, self, self._make_plot)

    def _let_go(self) -> None:
        """No ribbon any more: what it said last stays to be looked at."""
        self._timer.stop()
        self._link = self._reader = None
        self._say_how()

    def _say_how(self, *_: object) -> None:
        """How a person finds out which sensor is which; or that what is seen is not of now."""
        if self._ribbon is not None and self._station.state is not LinkState.STREAMING:
            self.hint.setText(tr("No frames come now: these are the last values."))
        else:
            self.hint.setText(
                tr("Tap a sensor, or bring a magnet near it: it flashes in the drawing.")
            )

    def _refresh(self) -> None:
        if self._reader is None:
            return
        state = self._readings.feed(self._reader.take())
        if state is None:
            return
        self.table.show_state(state)
        self.drawing.flash(state.flashing, _odd(state))
        if self._plot is not None and self.chosen is not None:
            self._plot.show_values(*self._readings.values(self.chosen))

    def _make_plot(self) -> None:
        if self._plot is None:
            from georibbon.gui.connect.sensor_plot import SensorPlot

            self._plot = SensorPlot()
            self._lower.layout().addWidget(self._plot)
            self._show_plot()

    def _show_plot(self) -> None:
        if self._plot is not None and self._ribbon is not None and self.chosen is not None:
            self._plot.show_sensor(self._ribbon.sensors[self.chosen], self._ribbon.rate)
            self._plot.show_values(*self._readings.values(self.chosen))

    def _say_where(self) -> None:
        if self._ribbon is None or self.chosen is None:
            self.where.setText(tr("Connect a ribbon to see what each of its sensors says."))
        else:
            self.where.setText(sensor_words(self._ribbon.sensors[self.chosen], self._units))


def _odd(state: RawState) -> np.ndarray:
    """(n,) the sensors that something is wrong with."""
    return np.array([word in ODD for word in state.words])
