"""One plot above the other, in pyqtgraph: lines and stems that are moved, never made anew."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor, QPen

from georibbon.arrays import FloatArray
from georibbon.gui.curve_quantities import MOST_POINTS, Quantity, Run, closest, stems, thinned
from georibbon.gui.theme import Colours

_AXIS_WIDTH = 52  # px, alike in all rows, so that the same place stands above itself
_ROOM = 0.08  # of the height, left free above and below
_FULL = 0.35  # of the height is to be used, or the plot is fitted anew
_DENSITY = 0.6  # of the numbers beside a plot, which is low
_BELOW = 37  # px, for numbers and words under the last plot
_STEM_ROOM = 0.8  # of the way from sensor to sensor


@dataclass(frozen=True)
class Drawn:
    """Where a row's values were put: in the person's unit, points drawn of points there are."""

    points: int
    of: int


class Row:
    """The plot of one quantity: a line for each look, its grid, and the cursor.

    Values and places come in the person's unit.  The height follows the values
    in steps, so that what stands around a line that moves need not be drawn
    again with it.
    """

    def __init__(self, quantity: Quantity, plot: pg.PlotItem) -> None:
        self.quantity, self.plot = quantity, plot
        self.lines: list[pg.PlotCurveItem] = []
        self.drawn = Drawn(0, 0)
        self._heights: tuple[float, float] | None = None  # as they were fitted
        self.grid = pg.PlotCurveItem(connect="pairs")
        self.grid.setZValue(-10)
        self.cursor = pg.InfiniteLine(angle=90, movable=False)
        self.spot = pg.ScatterPlotItem(size=9, pxMode=True)
        for item in (self.grid, self.cursor, self.spot):
            plot.addItem(item, ignoreBounds=True)
        self.cursor.hide()
        self.spot.hide()
        self.title = plot.titleLabel  # above the plot, where no curve runs
        self.title.setAttr("justify", "left")
        self.title.item.document().setDocumentMargin(0)
        self._set_up()

    def _set_up(self) -> None:
        plot = self.plot
        plot.setMenuEnabled(False)
        plot.hideButtons()
        box = plot.getViewBox()
        box.setMouseEnabled(x=True, y=False)
        box.disableAutoRange()
        box.sigRangeChanged.connect(self._draw_grid)
        plot.getAxis("left").setWidth(_AXIS_WIDTH)
        plot.getAxis("left").setTickDensity(_DENSITY)
        for name in ("left", "bottom"):
            plot.getAxis(name).enableAutoSIPrefix(False)
            plot.getAxis(name).setStyle(maxTickLevel=0)

    def fill(self, x: Sequence[FloatArray], y: Sequence[FloatArray], looks: int) -> None:
        """Draw these runs' values over their places: all of one look as one line, with gaps."""
        while len(self.lines) < looks:
            line = pg.PlotCurveItem(antialias=False)
            self.plot.addItem(line, ignoreBounds=True)
            self.lines.append(line)
        connect = "pairs" if self.quantity.stems else "finite"
        for k, line in enumerate(self.lines):
            line.setData(*_joined(x[k::looks], y[k::looks]), connect=connect)
        self._fit_height(y)

    def fill_runs(self, runs: Sequence[Run], x_scale: float, y_scale: float, looks: int) -> None:
        """Draw these runs, metres and the quantity's own measure times the scales."""
        if self.quantity.stems:
            width = _STEM_ROOM * min((closest(run.s) for run in runs), default=0.01)
            points = stems(runs, width)
        else:
            most = max(MOST_POINTS // max(len(runs), 1), 8)
            points = [thinned(run.s, run.values, most) for run in runs]
        self.drawn = Drawn(
            sum(len(x) for x, _ in points) // (2 if self.quantity.stems else 1),
            sum(len(run.s) for run in runs),
        )
        self.fill([x * x_scale for x, _ in points], [y * y_scale for _, y in points], looks)

    @property
    def thinned(self) -> bool:
        """Whether not every point is drawn."""
        return not self.quantity.stems and self.drawn.points < self.drawn.of

    def colour(self, of: Colours, pens: Sequence[QPen]) -> None:
        """Take a theme's colours."""
        for k, line in enumerate(self.lines):
            pen = QPen(pens[k % len(pens)])
            if self.quantity.stems:
                pen.setStyle(pg.QtCore.Qt.PenStyle.SolidLine)
            line.setPen(pen)
        faint = QColor(of.frame)
        faint.setAlphaF(0.3)
        self.grid.setPen(_cosmetic(faint))
        self.cursor.setPen(_cosmetic(QColor(of.words)))
        self.spot.setPen(_cosmetic(QColor(of.words)))
        self.spot.setBrush(pg.mkBrush(of.base))
        for name in ("left", "bottom"):
            axis = self.plot.getAxis(name)
            axis.setPen(of.frame)
            axis.setTextPen(of.words)

    def label(self, title: str, below: str, colour: str) -> None:
        """The title, and what stands under the plot; "" for a plot that others stand under."""
        size = f"{self.plot.font().pointSizeF():g}pt"
        self.plot.setTitle(title, color=colour, size=size)
        height = self.title.itemRect().height()
        self.title.setMaximumHeight(height)
        self.plot.layout.setRowFixedHeight(0, height)
        bottom = self.plot.getAxis("bottom")
        bottom.setStyle(showValues=bool(below))
        bottom.setHeight(_BELOW if below else 6)
        self.plot.setLabel("bottom", below)
        bottom.showLabel(bool(below))

    def point(self, x: float, value: float) -> None:
        """Put the cursor at a place, and its spot on a value, NaN for none."""
        self.cursor.setPos(x)
        self.cursor.show()
        known = bool(np.isfinite(value))
        self.spot.setVisible(known)
        if known:
            self.spot.setData([x], [value])

    def unpoint(self) -> None:
        """No cursor."""
        self.cursor.hide()
        self.spot.hide()

    def _fit_height(self, values: Sequence[FloatArray]) -> None:
        """Have all values in sight; another range only where they leave it or use too little."""
        whole = np.concatenate([np.empty(0), *values])
        whole = whole[np.isfinite(whole)]
        if not len(whole):
            return
        low, high = float(whole.min()), float(whole.max())
        if not _fits(low, high, self._heights):
            room = _ROOM * (high - low) or max(abs(high) * _ROOM, 1e-9)
            self._heights = (low - room, high + room)
            self.plot.getViewBox().setYRange(*self._heights, padding=0)

    def _draw_grid(self, *_: object) -> None:
        """Lines at the axes' numbers."""
        (x0, x1), (y0, y1) = self.plot.getViewBox().viewRange()
        size = self.plot.getViewBox().size()
        xs = _ticks(self.plot.getAxis("bottom"), x0, x1, size.width())
        ys = _ticks(self.plot.getAxis("left"), y0, y1, size.height())
        x = np.concatenate((np.repeat(xs, 2), np.tile([x0, x1], len(ys))))
        y = np.concatenate((np.tile([y0, y1], len(xs)), np.repeat(ys, 2)))
        self.grid.setData(x, y)


def _joined(x: Sequence[FloatArray], y: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Several lines as one, with a gap behind each; stems need none, but no harm is done."""
    gap = np.full(2, np.nan)  # two, so that pairs stay pairs
    return (
        np.concatenate([np.empty(0), *(part for one in x for part in (one, gap))]),
        np.concatenate([np.empty(0), *(part for one in y for part in (one, gap))]),
    )


def _fits(low: float, high: float, heights: tuple[float, float] | None) -> bool:
    """Whether values lie within a range, and use enough of it."""
    if heights is None or low < heights[0] or high > heights[1]:
        return False
    return high - low >= _FULL * (heights[1] - heights[0])


def _ticks(axis: pg.AxisItem, low: float, high: float, size: float) -> FloatArray:
    """(n,) places of an axis's numbers."""
    found = axis.tickValues(low, high, size)
    return np.asarray(found[0][1], dtype=np.float64) if found else np.empty(0)


def _cosmetic(colour: QColor) -> QPen:
    """One pixel wide: two take several times as long."""
    pen = QPen(colour)
    pen.setCosmetic(True)
    return pen
