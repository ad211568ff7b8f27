"""The live curve beside the passes taken, from above and from the side.

pyqtgraph is loaded with this module: import it when the plots are made.
"""

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, Qt
from PySide6.QtWidgets import QVBoxLayout, QWidget

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import Strip
from georibbon.gui.capturing.model import CaptureModel, LivePicture
from georibbon.gui.language import tr
from georibbon.gui.parts import Parts
from georibbon.gui.theme import colours_of

STEP = 0.05  # m by which the plots' ranges go
MARGIN = 0.4  # of a step
NAMES = 0.09  # of the width before the passes' starts, for their names


class LivePlots(QWidget):
    """Plan above, profile below, both along the first pass; lengths in the unit in use."""

    def __init__(self, parts: Parts, model: CaptureModel, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts, self._model = parts, model
        self._live: LivePicture | None = None
        self._bounds: tuple[float, ...] = ()
        self.plots = pg.GraphicsLayoutWidget()
        self.plots.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.plots.setAccessibleName(tr("The live curve beside the passes taken, plan and profile"))
        self.setAccessibleName(tr("Plan and profile"))
        self.plan, self.profile = (self.plots.addPlot(row=k, col=0) for k in range(2))
        self._lines = {}
        for plot in (self.plan, self.profile):
            plot.setMenuEnabled(False)
            plot.hideButtons()
            plot.showGrid(x=True, y=True, alpha=0.2)
            plot.setAspectLocked(True)
            plot.disableAutoRange()
            plot.getAxis("left").setWidth(48)
            for axis in ("left", "bottom"):
                plot.getAxis(axis).enableAutoSIPrefix(False)
            lines = [plot.plot(connect="finite", antialias=False) for _ in range(5)]
            self._lines[plot] = lines
        self._labels: list[pg.TextItem] = []
        self._live_label = pg.TextItem("", anchor=(1.0, 0.5))
        self.plan.addItem(self._live_label, ignoreBounds=True)
        self._ways = self.plan.plot(connect="finite", antialias=False)
        self._way_labels = [pg.TextItem("", anchor=(0.0, 0.5)) for _ in range(2)]
        for label in self._way_labels:
            self.plan.addItem(label, ignoreBounds=True)
        self.plots.ci.layout.setRowStretchFactor(0, 3)
        self.plots.ci.layout.setRowStretchFactor(1, 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.plots)
        model.changed.connect(self._show_taken)
        model.lived.connect(self._show_live)
        parts.units.changed.connect(self._renew)
        self._colour()
        self._renew()

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_live_label"):
            self._colour()

    def _colour(self) -> None:
        of = colours_of(self.palette())
        self.plots.setBackground(of.base)
        pens = (
            pg.mkPen(of.dim),
            pg.mkPen(of.curves[1], style=Qt.PenStyle.DashLine),
            pg.mkPen(of.curves[2]),
            pg.mkPen(of.curves[0]),
            pg.mkPen(of.frame, style=Qt.PenStyle.DotLine),
        )
        for plot, lines in self._lines.items():
            for line, pen in zip(lines, pens, strict=True):
                line.setPen(pen)
            for name in ("left", "bottom"):
                plot.getAxis(name).setPen(of.frame)
                plot.getAxis(name).setTextPen(of.words)
        self._live_label.setColor(of.curves[0])
        self._ways.setPen(pg.mkPen(of.words, style=Qt.PenStyle.DotLine))
        for label in self._way_labels:
            label.setColor(of.words)
        for label in self._labels:
            label.setColor(of.words)

    def _renew(self) -> None:
        symbol = self._parts.units.symbol
        self.plan.setLabel("left", tr("across, {unit}", unit=symbol))
        self.profile.setLabel("left", tr("height, {unit}", unit=symbol))
        self.profile.setLabel("bottom", tr("along the passes, {unit}", unit=symbol))
        self._show_taken()
        self._show_live(self._live)

    def _shown(self, strip: Strip) -> FloatArray:
        """(n, 3) along, across, height in the unit in use."""
        points = strip.points @ self._model.axes()
        return points / self._parts.units.unit.metres

    def _show_taken(self) -> None:
        """Draw what was taken: passes, ties, the neighbour, with their names."""
        kinds, placed = self._model.kinds, self._model.placed
        live = self._live
        neighbour = live.beside.neighbour if live is not None and live.beside is not None else None
        own = None if live is None else live.name
        groups = (
            [n for n in placed if kinds.get(n) == "pass" and n not in (neighbour, own)],
            [n for n in placed if kinds.get(n) == "tie" and n != own],
            [n for n in placed if n == neighbour],
        )
        for k, names in enumerate(groups):
            self._draw(k, [self._shown(placed[name]) for name in names])
        self._draw(4, [self._shown(placed[own])] if own in placed else [])
        self._name([name for names in groups for name in names])
        self._fit()

    def _fit(self) -> None:
        """Both plots hold all that is shown; in steps, so that a moving ribbon shakes nothing."""
        strips = list(self._model.placed.values())
        if self._live is not None:
            strips.append(self._live.strip)
        if not strips:
            return
        points = np.concatenate([self._shown(strip) for strip in strips])
        step = STEP / self._parts.units.unit.metres
        low = np.floor(points.min(axis=0) / step - MARGIN) * step
        high = np.ceil(points.max(axis=0) / step + MARGIN) * step
        low[0] -= NAMES * (high[0] - low[0])
        bounds = (*low, *high)
        if bounds != self._bounds:
            self._bounds = bounds
            for plot, column in ((self.plan, 1), (self.profile, 2)):
                plot.setRange(
                    xRange=(low[0], high[0]), yRange=(low[column], high[column]), padding=0.0
                )

    def _draw(self, k: int, curves: list[FloatArray]) -> None:
        gap = np.full((1, 3), np.nan)
        points = np.concatenate([np.empty((0, 3)), *(x for c in curves for x in (c, gap))])
        for plot, column in ((self.plan, 1), (self.profile, 2)):
            self._lines[plot][k].setData(points[:, 0], points[:, column])

    def _name(self, names: list[str]) -> None:
        of = colours_of(self.palette())
        while len(self._labels) < len(names):
            label = pg.TextItem("", color=of.words, anchor=(1.0, 0.5))
            self._labels.append(label)
            self.plan.addItem(label, ignoreBounds=True)
        for k, label in enumerate(self._labels):
            label.setVisible(k < len(names))
            if k < len(names):
                start = self._shown(self._model.placed[names[k]])[0]
                label.setText(names[k])
                label.setPos(float(start[0]), float(start[1]))

    def _show_live(self, live: LivePicture | None) -> None:
        before, self._live = self._live, live
        if _about(before) != _about(live):
            self._show_taken()
        self._draw(3, [] if live is None else [self._shown(live.strip)])
        if live is not None:
            self._fit()
        self._live_label.setVisible(live is not None)
        if live is not None:
            start = self._shown(live.strip)[0]
            self._live_label.setText(live.name)
            self._live_label.setPos(float(start[0]), float(start[1]))

        self._show_ways(live)

    def _show_ways(self, live: LivePicture | None) -> None:
        """The ways to the neighbour where it is nearest and where it is farthest."""
        beside = None if live is None else live.beside
        other = None if beside is None else self._model.placed.get(beside.neighbour)
        ways = []
        if beside is not None and other is not None:
            theirs = self._shown(other)
            for at, far in ((beside.least_at, beside.least), (beside.most_at, beside.most)):
                k = int(np.argmin(np.abs(live.strip.s - at)))
                here = self._shown(live.strip)[k]
                there = theirs[np.argmin(np.linalg.norm(theirs - here, axis=1))]
                ways.append((here, there, self._parts.units.number(far)))
        gap = np.full(3, np.nan)
        line = np.array([x for here, there, _ in ways for x in (here, there, gap)]).reshape(-1, 3)
        self._ways.setData(line[:, 0], line[:, 1])
        for k, label in enumerate(self._way_labels):
            label.setVisible(k < len(ways))
            if k < len(ways):
                here, there, words = ways[k]
                middle = 0.5 * (here + there)
                label.setText(words)
                beyond = middle[0] > 0.5 * (self._bounds[0] + self._bounds[3])
                label.setAnchor((1.0 if beyond else 0.0, 0.5))  # the words stay in the plot
                label.setPos(float(middle[0]), float(middle[1]))


def _about(live: LivePicture | None) -> tuple[str, str | None] | None:
    """Whom a picture is about, and beside whom."""
    if live is None:
        return None
    return live.name, None if live.beside is None else live.beside.neighbour
