"""A section's profile as a small plot; loaded late, for it needs pyqtgraph."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pyqtgraph as pg
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QWidget

from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of
from georibbon.gui.units import Units

if TYPE_CHECKING:
    from georibbon.scene.measuring import Section


class ProfilePlot(pg.PlotWidget):
    """The height of a section over the way across, in one scale."""

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = units
        self._section: Section | None = None
        self.setFixedHeight(170)
        self.setMinimumWidth(120)
        self.setMenuEnabled(False)
        self.hideButtons()
        self.showGrid(x=True, y=True, alpha=0.25)
        self.setAspectLocked(True)
        self.setAccessibleName(tr("Profile of the section"))
        self._line = self.plot([], [], antialias=False)
        self._ends = pg.ScatterPlotItem(size=8, pxMode=True)
        self.addItem(self._ends)
        for name in ("left", "bottom"):
            self.getAxis(name).enableAutoSIPrefix(False)
        units.changed.connect(self._draw)
        self._colour()

    def show_section(self, section: Section) -> None:
        """Draw a section."""
        self._section = section
        self._draw()
        self.getPlotItem().enableAutoRange()

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_ends"):
            self._colour()

    def _draw(self) -> None:
        section = self._section
        if section is None:
            return
        size = self._units.unit.metres
        self._line.setData(section.across / size, section.height / size)
        apart = section.second.position - section.first.position
        nearest = abs(section.points - section.second.position).sum(axis=1).argmin()
        second = (section.across[nearest], section.height[nearest])
        places = [(0.0, 0.0), second] if section.between is not None and apart.any() else [(0, 0)]
        self._ends.setData([x / size for x, _ in places], [y / size for _, y in places])
        self.setLabel("bottom", tr("across, {unit}", unit=self._units.symbol))
        self.setLabel("left", tr("height, {unit}", unit=self._units.symbol))

    def _colour(self) -> None:
        of = colours_of(self.palette())
        self.setBackground(of.base)
        self._line.setPen(pg.mkPen(of.curves[0]))
        self._ends.setPen(pg.mkPen(of.words))
        self._ends.setBrush(pg.mkBrush(of.curves[1]))
        for name in ("left", "bottom"):
            axis = self.getAxis(name)
            axis.setPen(of.frame)
            axis.setTextPen(of.words)
