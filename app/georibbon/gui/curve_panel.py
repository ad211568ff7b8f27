"""Curves along the passes: shape, uncertainty, residuals and raw readings, with a cursor."""

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QItemSelectionModel, QPointF, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor, QGuiApplication, QKeyEvent, QKeySequence, QPen
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from georibbon.arrays import FloatArray
from georibbon.gui.curve_plots import Row
from georibbon.gui.curve_quantities import (
    FIRST,
    QUANTITIES,
    RAW,
    UNITS,
    Measure,
    Quantity,
    Run,
    Source,
    table,
)
from georibbon.gui.language import tr
from georibbon.gui.parts import Parts
from georibbon.gui.theme import colours_of
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.recording import Recording
from georibbon.scene.labels import short_name

KEPT = "curves/quantities"  # in the settings
_DASHES = ((), (10, 5), (4, 4), (12, 4, 3, 4))  # in pixels; () for a whole line
_SIGNS = ("───", "─ ─", "╌╌╌", "─ · ─")  # a line of words is never broken within
_MOST_NAMED = 12
_LEAST_HEIGHT = 68  # px of a plot with its title
_STEP = 0.01  # of the length, by which a key moves the cursor
_ID = Qt.ItemDataRole.UserRole


class CurvePanel(QWidget):
    """Quantities of chosen passes along their arc length.

    cursor_moved(pass, s): a person moved the cursor, to s metres along the pass
    that is nearest to the pointer.  Left and right move it, up and down change
    the pass, Ctrl+C copies.
    """

    cursor_moved = Signal(str, float)

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings, self._units = parts.settings, parts.units
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(tr("Curves along the passes"))
        self._result: Reconstruction | None = None
        self._recording: Recording | None = None
        self._passes: tuple[FittedPass, ...] = ()
        self._runs: list[list[Run]] = []  # by row, by pass
        self.rows: list[Row] = []
        self._pens: list[QPen] = []
        self._longest = 0.0  # m
        self._stale = False  # what is hidden is drawn when it is seen
        self._at: tuple[int, float] | None = None  # the cursor: which pass, and s in metres
        self._make_choice()
        self.legend, self.reading = _line(Qt.TextFormat.RichText), _line(Qt.TextFormat.PlainText)
        self.legend.setWordWrap(True)  # not the reading: the plots would jump under the pointer
        self.told = QLabel()
        self.copy_button = QPushButton(tr("&Copy"))
        self.copy_button.setToolTip(tr("Copy what is drawn, as CSV (Ctrl+C)"))
        self.copy_button.clicked.connect(self.copy)
        self._make_plots()
        self._lay_out()
        self._units.changed.connect(self._take_unit)
        self._build()

    # What others ask for

    def show_passes(
        self,
        reconstruction: Reconstruction | None,
        names: Sequence[str],
        recording: Recording | None = None,
    ) -> None:
        """Show these passes of a result, in its order; none where there is no result.

        recording: what it was made from, for the raw readings.
        """
        chosen = set(names)
        before = self._cursor_pass()
        self._result, self._recording = reconstruction, recording
        passes = () if reconstruction is None else reconstruction.passes
        self._passes = tuple(one for one in passes if one.name in chosen)
        places = {one.name: k for k, one in enumerate(self._passes)}
        if self._at is not None:
            self._at = (places[before], self._at[1]) if before in places else None
        self._fill()

    def show_quantities(self, ids: Sequence[str]) -> None:
        """Show these quantities, one plot above the other."""
        with QSignalBlocker(self.choice):
            for name, item in self._items.items():
                item.setCheckState(_checked(name in ids))
        self._build()

    @property
    def quantities(self) -> list[str]:
        """The ids of what is shown."""
        return [row.quantity.id for row in self.rows]

    def show_cursor(self, name: str, s: float) -> None:
        """Put the cursor at s metres along a pass; nothing where the pass is not shown."""
        names = [one.name for one in self._passes]
        if name in names:
            self._at = (names.index(name), s)
            self._show_cursor()

    def as_csv(self) -> str:
        """What is drawn, as CSV, in the units in use."""
        shown = [row.quantity for row in self.rows]
        runs = [(one.name, [of[k] for of in self._runs]) for k, one in enumerate(self._passes)]
        heads = [self._head(one) for one in shown]
        place = tr("arc length, {unit}", unit=self._units.symbol)
        return table(shown, runs, lambda measure, v: v * self._scale(measure), heads, place)

    def copy(self) -> None:
        """Put what is drawn on the clipboard."""
        self._fill(force=True)
        QGuiApplication.clipboard().setText(self.as_csv())
        self.told.setText(tr("copied"))

    # Making

    def _make_choice(self) -> None:
        self.choice = QListWidget()
        self.choice.setAccessibleName(tr("What is drawn along the passes"))
        self.choice.setStatusTip(tr("Space shows or hides a quantity"))
        self.choice.setMaximumWidth(210)
        self._items: dict[str, QListWidgetItem] = {}
        allowed = {one.id for one in QUANTITIES}
        kept = [name for name in self._settings.get(KEPT, list(FIRST)) if name in allowed]
        group = ""
        for one in QUANTITIES:
            if one.group != group:
                group = one.group
                self._add_heading(tr(group))
            item = QListWidgetItem(tr(one.text))
            item.setData(_ID, one.id)
            item.setFlags(
                Qt.ItemFlag.ItemIsEnabled
                | Qt.ItemFlag.ItemIsSelectable
                | Qt.ItemFlag.ItemIsUserCheckable
            )
            item.setCheckState(_checked(one.id in kept))
            self.choice.addItem(item)
            self._items[one.id] = item
        self.choice.setCurrentRow(1, QItemSelectionModel.SelectionFlag.NoUpdate)
        self.choice.itemChanged.connect(self._chosen)

    def _add_heading(self, text: str) -> None:
        item = QListWidgetItem(text)
        item.setFlags(Qt.ItemFlag.NoItemFlags)
        font = item.font()
        font.setBold(True)
        item.setFont(font)
        self.choice.addItem(item)

    def _make_plots(self) -> None:
        self.plots = pg.GraphicsLayoutWidget()
        self.plots.setAccessibleName(tr("Plots"))
        self.plots.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.plots.ci.layout.setSpacing(2)
        self.plots.ci.setContentsMargins(2, 4, 8, 2)
        self.plots.scene().sigMouseMoved.connect(self._pointed)
        self.plots.scene().sigMouseClicked.connect(self._clicked)

    def _lay_out(self) -> None:
        right = QVBoxLayout()
        right.setSpacing(4)
        area = QScrollArea()  # many plots are as high as they must be to be read
        area.setWidget(self.plots)
        area.setWidgetResizable(True)
        area.setFrameShape(QScrollArea.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        right.addWidget(area, 1)
        words = QHBoxLayout()
        words.addWidget(self.legend, 1)
        words.addWidget(self.told)
        right.addLayout(words)
        right.addWidget(self.reading)
        left = QVBoxLayout()
        left.setSpacing(4)
        left.addWidget(self.choice, 1)
        left.addWidget(self.copy_button)
        whole = QHBoxLayout(self)
        whole.setContentsMargins(6, 6, 6, 6)
        whole.setSpacing(6)
        whole.addLayout(left)
        whole.addLayout(right, 1)

    def _chosen(self, _item: QListWidgetItem) -> None:
        """A person has chosen other quantities: this is kept."""
        self._build()
        self._settings.put(KEPT, self.quantities)

    def _build(self) -> None:
        """One row for every quantity that is chosen."""
        chosen = [
            one for one in QUANTITIES if self._items[one.id].checkState() == Qt.CheckState.Checked
        ]
        if [row.quantity for row in self.rows] != chosen:
            self.plots.clear()
            self.rows = [Row(one, self.plots.addPlot(row=k, col=0)) for k, one in enumerate(chosen)]
            for row in self.rows[1:]:
                row.plot.setXLink(self.rows[0].plot)
            self.plots.setMinimumHeight(_LEAST_HEIGHT * len(self.rows))
            self._longest = 0.0
            self._label()
        self._fill()

    # Filling

    def showEvent(self, event) -> None:
        """Draw what came while nobody saw it."""
        super().showEvent(event)
        self._fill()

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "plots"):
            self._pens = []
            self._label()
            self._fill()

    def _take_unit(self) -> None:
        self._longest = 0.0
        self._label()
        self._fill()

    def _fill(self, force: bool = False) -> None:
        """Bring the lines up to date; where nobody sees them, later."""
        self._stale = not (self.isVisible() or force)
        if self._stale:
            return
        sources = self._sources()
        self._runs = [[row.quantity.of(one) for one in sources] for row in self.rows]
        looks = max(min(len(self._passes), _MOST_NAMED), 1)
        colours_known = bool(self._pens)
        x_scale = 1.0 / self._units.unit.metres
        for row, runs in zip(self.rows, self._runs, strict=True):
            new = len(row.lines) < looks
            row.fill_runs(runs, x_scale, self._scale(row.quantity.measure), looks)
            if new or not colours_known:
                row.colour(colours_of(self.palette()), self._looks())
        self._fit_width()
        self._tell()
        self._show_cursor()

    def _sources(self) -> list[Source]:
        result = self._result
        if result is None:
            return []
        raw = {} if self._recording is None else {one.name: one for one in self._recording.passes}
        return [Source(one, result.ribbon, raw.get(one.name)) for one in self._passes]

    def _fit_width(self) -> None:
        """All of the longest pass, once; then what a person looks at stays."""
        longest = max((float(one.strip.s[-1]) for one in self._passes), default=0.0)
        if self.rows and abs(longest - self._longest) > 0.02 * longest:
            self._longest = longest
            self.show_all()

    def show_all(self) -> None:
        """All of the passes' length."""
        if self.rows:
            end = self._units.value(self._longest or 1.0)
            self.rows[0].plot.getViewBox().setXRange(0.0, end, padding=0.02)

    def _tell(self) -> None:
        """Who is who, what is missing, and how thinned it is; only where it changed."""
        _say(self.legend, self._names())
        words = []
        points, of = (
            sum(getattr(row.drawn, name) for row in self.rows if row.thinned)
            for name in ("points", "of")
        )
        if of:
            words.append(tr("{n} of {all} points are drawn, with every peak", n=points, all=of))
        if any(row.quantity.group == RAW for row in self.rows) and self._recording is None:
            words.append(tr("the raw readings are not to be had here"))
        _say(self.told, " · ".join(words))

    def _names(self) -> str:
        """Who is who, as rich text."""
        if not self._passes:
            return tr("no pass is chosen")
        named = []
        for one, pen in zip(self._passes, self._looks(), strict=False):
            sign = _SIGNS[_DASHES.index(tuple(pen.dashPattern()))]
            drawn = sign.replace(" ", "&nbsp;")
            named.append(
                f'<span style="color:{pen.color().name()}"><b>{drawn}</b></span>'
                f"&nbsp;{_escaped(one.name)}"
            )
        more = len(self._passes) - len(named)
        if more > 0:
            named.append(tr("and {n} more", n=more))
        return " &nbsp; ".join(named)

    # Colours, words and units

    def _looks(self) -> list[QPen]:
        """The pens of the passes in turn: each next one differs in colour and in dashes."""
        if not self._pens:
            colours = colours_of(self.palette()).curves
            self._pens = [_pen(colours, k) for k in range(_MOST_NAMED)]
        return self._pens

    def _label(self) -> None:
        """Titles and axes in the theme's colours and the unit in use."""
        of = colours_of(self.palette())
        self.plots.setBackground(of.base)
        below = tr("arc length, {unit}", unit=self._units.symbol)
        for row in self.rows:
            row.label(self._head(row.quantity), below if row is self.rows[-1] else "", of.words)
            row.colour(of, self._looks())

    def _head(self, quantity: Quantity) -> str:
        unit = self._unit(quantity.measure)
        return (
            tr("{what}, {unit}", what=tr(quantity.text), unit=unit) if unit else tr(quantity.text)
        )

    def _unit(self, measure: Measure) -> str:
        return self._units.symbol if measure == "length" else tr(UNITS[measure] or "")

    def _scale(self, measure: Measure) -> float:
        return 1.0 / self._units.unit.metres if measure == "length" else 1.0

    # The cursor

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the cursor: along the pass, and from pass to pass; copy."""
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy()
            return
        along = {Qt.Key.Key_Left: -_STEP, Qt.Key.Key_Right: _STEP}.get(event.key(), 0.0)
        across = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}.get(event.key(), 0)
        if not self._passes or not (along or across):
            super().keyPressEvent(event)
            return
        k, s = self._at or (0, 0.0)
        k = min(max(k + across, 0), len(self._passes) - 1)
        self._move(k, s + along * float(self._passes[k].strip.s[-1]))

    def _cursor_pass(self) -> str | None:
        return None if self._at is None else self._passes[self._at[0]].name

    def _pointed(self, at: QPointF) -> None:
        """The pointer is over the plots: the cursor goes there, on the nearest curve."""
        for row, runs in zip(self.rows, self._runs, strict=False):
            box = row.plot.getViewBox()
            if self._passes and box.sceneBoundingRect().contains(at):
                place = box.mapSceneToView(at)
                s = self._units.metres(place.x())
                value = place.y() / self._scale(row.quantity.measure)
                self._move(_nearest(runs, s, value), s)
                return

    def _clicked(self, click: object) -> None:
        """A double click shows everything again."""
        if click.double():
            self.show_all()

    def _move(self, k: int, s: float) -> None:
        s = float(np.clip(s, self._passes[k].strip.s[0], self._passes[k].strip.s[-1]))
        if self._at != (k, s):
            self._at = (k, s)
            self._show_cursor()
            self.cursor_moved.emit(self._passes[k].name, s)

    def _show_cursor(self) -> None:
        if self._stale:
            return
        if self._at is None:
            for row in self.rows:
                row.unpoint()
            _say(self.reading, "")
            return
        k, s = self._at
        words = [tr("{name} at {s}", name=short_name(self._passes[k].name), s=self._units.text(s))]
        for row, runs in zip(self.rows, self._runs, strict=True):
            place, value, sensor = runs[k].at(s)
            scaled = value * self._scale(row.quantity.measure)
            row.point(self._units.value(place), scaled)
            words.append(self._reading(row.quantity, scaled, sensor))
        _say(self.reading, "   ".join(words))
        self.reading.setToolTip("\n".join(words))

    def _reading(self, quantity: Quantity, value: float, sensor: str) -> str:
        """A quantity under the cursor, in words."""
        name = f"{tr(quantity.text)} {sensor}".rstrip()
        number = f"{value:.4g}" if np.isfinite(value) else "–"
        return f"{name} {number} {self._unit(quantity.measure)}".rstrip()


def _checked(on: bool) -> Qt.CheckState:
    return Qt.CheckState.Checked if on else Qt.CheckState.Unchecked


def _pen(colours: Sequence[str], k: int) -> QPen:
    pen = QPen(QColor(colours[k % len(colours)]))
    pen.setCosmetic(True)  # and one pixel wide: two take several times as long
    dashes = _DASHES[(k + k // len(colours)) % len(_DASHES)]
    if dashes:
        pen.setDashPattern(dashes)
    return pen


def _say(label: QLabel, text: str) -> None:
    """Set words that differ: a layout that is asked again takes its time."""
    if label.text() != text:
        label.setText(text)


def _line(kind: Qt.TextFormat) -> QLabel:
    """A line of words that never widens the panel."""
    label = QLabel()
    label.setTextFormat(kind)
    label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
    return label


def _nearest(runs: Sequence[Run], s: float, value: float) -> int:
    """Which run is nearest to a value at s."""
    away: FloatArray = np.abs([run.at(s)[1] - value for run in runs])
    return int(np.argmin(np.where(np.isfinite(away), away, np.inf)))


def _escaped(name: str) -> str:
    shown = short_name(name)
    return shown.replace("&", "&amp;").replace("<", "&lt;").replace(" ", "&nbsp;")
