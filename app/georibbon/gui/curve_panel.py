"""Curves along the passes, in pyqtgraph: curvature, torsion, uncertainty, place."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QPen
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import curvatures
from georibbon.gui.theme import Colours, colours_of
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.scene.labels import short_name


@dataclass(frozen=True)
class Quantity:
    """What can be drawn along a pass.

    id: for the program; text: on its button and in its plot; unit: of its
    numbers; of: a pass's (n,) values in that unit.
    """

    id: str
    text: str
    unit: str
    of: Callable[[FittedPass], FloatArray]


QUANTITIES = (
    Quantity("curvature", "Normal curvature", "1/m",
             lambda one: curvatures(one.strip)[0]),
    Quantity("torsion", "Geodesic torsion", "1/m",
             lambda one: curvatures(one.strip)[1]),
    Quantity("sigma", "Uncertainty (1σ)", "mm", lambda one: one.position_sigma * 1e3),
    Quantity("x", "x", "mm", lambda one: one.strip.points[:, 0] * 1e3),
    Quantity("y", "y", "mm", lambda one: one.strip.points[:, 1] * 1e3),
    Quantity("z", "z", "mm", lambda one: one.strip.points[:, 2] * 1e3),
)  # fmt: skip
_FIRST = ("curvature", "sigma")
_DASHES = ((), (10, 5), (4, 4), (12, 4, 3, 4))  # in pixels; () for a whole line
_SIGNS = ("───", "─ ─", "- - -", "─ · ─")
_MOST_NAMED = 12
_AXIS_WIDTH = 46  # px, alike in all rows, so that the same place stands above itself
_STEP = 0.01  # of the length, by which a key moves the cursor


class _Row:
    """The plot of one quantity: a line for each look, and the cursor."""

    def __init__(self, quantity: Quantity, plot: pg.PlotItem) -> None:
        self.quantity, self.plot = quantity, plot
        self.values: list[FloatArray] = []
        self.lines: list[pg.PlotDataItem] = []
        self.cursor = pg.InfiniteLine(angle=90, movable=False)
        self.spot = pg.ScatterPlotItem(size=9, pxMode=True)
        for item in (self.cursor, self.spot):
            item.hide()
            plot.addItem(item, ignoreBounds=True)
        self.title = pg.LabelItem(justify="left")
        self.title.setParentItem(plot.getViewBox())
        self.title.anchor(itemPos=(0, 0), parentPos=(0, 0), offset=(4, -2))
        plot.setMenuEnabled(False)
        plot.showGrid(x=True, y=True, alpha=0.25)
        plot.getViewBox().setMouseEnabled(x=True, y=False)
        plot.getViewBox().setDefaultPadding(0.02)
        left, bottom = plot.getAxis("left"), plot.getAxis("bottom")
        left.setWidth(_AXIS_WIDTH)
        for axis in (left, bottom):
            axis.enableAutoSIPrefix(False)

    def fill(self, passes: Sequence[FittedPass], looks: int) -> None:
        """Draw these passes: all of one look as one line, with gaps between them."""
        self.values = [self.quantity.of(one) for one in passes]
        while len(self.lines) < looks:
            self.lines.append(self.plot.plot(connect="finite", antialias=False))
        for k, line in enumerate(self.lines):
            s = [np.append(one.strip.s * 1e3, np.nan) for one in passes[k::looks]]
            y = [np.append(values, np.nan) for values in self.values[k::looks]]
            line.setData(np.concatenate([np.empty(0), *s]), np.concatenate([np.empty(0), *y]))

    def colour(self, of: Colours, pens: Sequence[QPen], last: bool) -> None:
        """Take a theme's colours; only the last row has words under it."""
        for line, pen in zip(self.lines, pens, strict=False):
            line.setPen(pen)
        self.cursor.setPen(pg.mkPen(of.words))
        self.spot.setPen(pg.mkPen(of.words))
        self.spot.setBrush(pg.mkBrush(of.base))
        for name in ("left", "bottom"):
            axis = self.plot.getAxis(name)
            axis.setPen(of.frame)
            axis.setTextPen(of.words)
        self.title.setText(f"{self.quantity.text}, {self.quantity.unit}", color=of.words)
        self.plot.getAxis("bottom").setStyle(showValues=last)
        self.plot.getAxis("bottom").setHeight(None if last else 6)
        self.plot.setLabel("bottom", "arc length, mm" if last else "")
        self.plot.getAxis("bottom").showLabel(last)


class CurvePanel(QWidget):
    """Quantities of chosen passes along their arc length.

    cursor_moved(pass, s): a person moved the cursor, to s metres along the pass
    that is nearest to the pointer.  Left and right move it, up and down change
    the pass.
    """

    cursor_moved = Signal(str, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Curves along the passes")
        self._passes: tuple[FittedPass, ...] = ()
        self._rows: list[_Row] = []
        self._at: tuple[int, float] | None = None  # the cursor: which pass, and s in metres
        self.buttons = {one.id: self._button(one) for one in QUANTITIES}
        self.legend, self.reading = _line(Qt.TextFormat.RichText), _line(Qt.TextFormat.PlainText)
        self.legend.setWordWrap(True)  # not the reading: the plots would jump under the pointer
        self.plots = pg.GraphicsLayoutWidget()
        self.plots.setAccessibleName("Plots")
        self.plots.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.plots.ci.layout.setSpacing(2)
        self.plots.ci.setContentsMargins(2, 4, 8, 2)
        self.plots.scene().sigMouseMoved.connect(self._pointed)
        self.plots.scene().sigMouseClicked.connect(self._clicked)
        self._lay_out()
        self._build()

    def show_passes(self, reconstruction: Reconstruction | None, names: Sequence[str]) -> None:
        """Show these passes of a result, in its order; none where there is no result."""
        chosen = set(names)
        passes = () if reconstruction is None else reconstruction.passes
        before = self._cursor_pass()
        self._passes = tuple(one for one in passes if one.name in chosen)
        places = {one.name: k for k, one in enumerate(self._passes)}
        if self._at is not None:
            self._at = (places[before], self._at[1]) if before in places else None
        self._fill()

    def show_quantities(self, ids: Sequence[str]) -> None:
        """Show these quantities, one plot above the other."""
        for name, button in self.buttons.items():
            with QSignalBlocker(button):
                button.setChecked(name in ids)
        self._build()

    def show_cursor(self, name: str, s: float) -> None:
        """Put the cursor at s metres along a pass; nothing where the pass is not shown."""
        names = [one.name for one in self._passes]
        if name in names:
            self._at = (names.index(name), s)
            self._show_cursor()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the cursor: along the pass, and from pass to pass."""
        along = {Qt.Key.Key_Left: -_STEP, Qt.Key.Key_Right: _STEP}.get(event.key(), 0.0)
        across = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}.get(event.key(), 0)
        if not self._passes or not (along or across):
            super().keyPressEvent(event)
            return
        k, s = self._at or (0, 0.0)
        k = min(max(k + across, 0), len(self._passes) - 1)
        s += along * float(self._passes[k].strip.s[-1])
        self._move(k, s)

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "plots"):
            self._colour()

    # --- making ---

    def _button(self, quantity: Quantity) -> QCheckBox:
        button = QCheckBox(self)
        button.setText(quantity.text)
        button.setChecked(quantity.id in _FIRST)
        button.setToolTip(f"{quantity.text} along the passes, {quantity.unit}")
        button.setStatusTip(f"Show or hide the {quantity.text.lower()} along the passes")
        button.setAccessibleName(quantity.text)
        button.toggled.connect(self._build)
        return button

    def _lay_out(self) -> None:
        choice = QHBoxLayout()
        choice.setSpacing(12)
        for button in self.buttons.values():
            choice.addWidget(button)
        choice.addStretch(1)
        words = QHBoxLayout()
        words.addWidget(self.legend, 2)
        words.addWidget(self.reading, 3)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(6, 6, 6, 6)
        whole.setSpacing(4)
        whole.addLayout(choice)
        whole.addWidget(self.plots, 1)
        whole.addLayout(words)

    def _build(self, *_: object) -> None:
        """One row for every quantity that is chosen."""
        chosen = [one for one in QUANTITIES if self.buttons[one.id].isChecked()]
        if [row.quantity for row in self._rows] != chosen:
            self.plots.clear()
            self._rows = [
                _Row(one, self.plots.addPlot(row=k, col=0)) for k, one in enumerate(chosen)
            ]
            for row in self._rows[1:]:
                row.plot.setXLink(self._rows[0].plot)
        self._fill()

    def _fill(self) -> None:
        looks = max(min(len(self._passes), len(self._looks())), 1)
        for row in self._rows:
            row.fill(self._passes, looks)
        self._colour()
        self._show_cursor()

    def _looks(self) -> list[QPen]:
        """The pens of the passes in turn: each next one differs in colour and in dashes."""
        colours = colours_of(self.palette()).curves
        pens = []
        for k in range(_MOST_NAMED):
            pen = QPen(QColor(colours[k % len(colours)]))
            pen.setCosmetic(True)  # and one pixel wide: two take several times as long
            dashes = _DASHES[(k + k // len(colours)) % len(_DASHES)]
            if dashes:
                pen.setDashPattern(dashes)
            pens.append(pen)
        return pens

    def _colour(self) -> None:
        of, pens = colours_of(self.palette()), self._looks()
        self.plots.setBackground(of.base)
        for row in self._rows:
            row.colour(of, pens, last=row is self._rows[-1])
        self.legend.setText(self._names(pens))

    def _names(self, pens: Sequence[QPen]) -> str:
        """Who is who, as rich text."""
        if not self._passes:
            return "no pass is chosen"
        signs = [_SIGNS[_DASHES.index(tuple(pen.dashPattern()))] for pen in pens]
        named = [
            f'<span style="color:{pen.color().name()}; white-space:pre"><b>{sign}</b></span>'
            f"&nbsp;{_escaped(one.name)}"
            for one, pen, sign in zip(self._passes, pens, signs, strict=False)
        ]
        more = len(self._passes) - len(named)
        return " &nbsp; ".join(named) + (f" &nbsp; and {more} more" if more > 0 else "")

    # --- the cursor ---

    def _cursor_pass(self) -> str | None:
        return None if self._at is None else self._passes[self._at[0]].name

    def _pointed(self, at: QPointF) -> None:
        """The pointer is over the plots: the cursor goes there, on the nearest curve."""
        for row in self._rows:
            box = row.plot.getViewBox()
            if self._passes and box.sceneBoundingRect().contains(at):
                place = box.mapSceneToView(at)
                s = place.x() / 1e3
                self._move(_nearest(self._passes, row.values, s, place.y()), s)
                return

    def _clicked(self, click: object) -> None:
        """A double click shows everything again."""
        if click.double():
            for row in self._rows:
                row.plot.enableAutoRange()

    def _move(self, k: int, s: float) -> None:
        s = float(np.clip(s, self._passes[k].strip.s[0], self._passes[k].strip.s[-1]))
        if self._at != (k, s):
            self._at = (k, s)
            self._show_cursor()
            self.cursor_moved.emit(self._passes[k].name, s)

    def _show_cursor(self) -> None:
        words = []
        for row in self._rows:
            for item in (row.cursor, row.spot):
                item.setVisible(self._at is not None)
            if self._at is not None:
                k, s = self._at
                row.cursor.setPos(s * 1e3)
                value = float(np.interp(s, self._passes[k].strip.s, row.values[k]))
                row.spot.setData([s * 1e3], [value])
                words.append(f"{row.quantity.text.lower()} {value:.4g} {row.quantity.unit}")
        if self._at is not None:
            k, s = self._at
            words = [f"{short_name(self._passes[k].name)} at {s * 1e3:.0f} mm", *words]
        self.reading.setText("   ".join(words))
        self.reading.setToolTip("\n".join(words))


def _line(kind: Qt.TextFormat) -> QLabel:
    """A line of words that never widens the panel."""
    label = QLabel()
    label.setTextFormat(kind)
    label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
    return label


def _nearest(
    passes: Sequence[FittedPass], values: Sequence[FloatArray], s: float, value: float
) -> int:
    """Which pass's curve is nearest to a value at s."""
    away = [
        abs(float(np.interp(s, one.strip.s, curve)) - value)
        for one, curve in zip(passes, values, strict=True)
    ]
    return int(np.argmin(away))


def _escaped(name: str) -> str:
    shown = short_name(name)
    return shown.replace("&", "&amp;").replace("<", "&lt;").replace(" ", "&nbsp;")
