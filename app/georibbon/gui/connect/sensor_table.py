"""A table of all sensors, every axis as a bar and a number, repainted without asking a model."""

from math import isnan

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QRect, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPen, QRegion
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from georibbon.gui.connect.raw import RawState
from georibbon.gui.connect.words import FLAGS, kind_words, sensor_words
from georibbon.gui.language import N_, tr
from georibbon.gui.theme import Colours, colours_of
from georibbon.gui.units import Units
from georibbon.ribbon import Ribbon

NAME, KIND, PLACE, X, Y, Z, NORM, NOISE, STATE = range(9)
TITLES = (
    N_("Sensor"), N_("Kind"), N_("From start"), N_("x"), N_("y"), N_("z"), N_("Length"),
    N_("Noise"), N_("State"),
)  # fmt: skip
TIPS = (
    N_("The sensor's name"),
    N_("What it measures"),
    N_("Where it sits, from the start of the ribbon"),
    N_("Along the ribbon: g, or times the field where it was scaled"),
    N_("Across the ribbon"),
    N_("Out of the surface"),
    N_("Length of what all its axes say; about 1 for an accelerometer that lies still"),
    N_("Standard deviation of an axis over half a second, in thousandths"),
    N_("What is wrong with it"),
)
WIDTHS = (56, 98, 80, 100, 100, 100, 58, 52, 80)
LIVE = (X, Y, Z, NORM, NOISE, STATE)
FULL = 1.5  # at the end of a bar: g, or times the field
NUMBER = 54  # px beside the bar
EDGE = 4  # px


class SensorModel(QAbstractTableModel):
    """The sensors and their newest values."""

    def __init__(self, units: Units, parent: QWidget) -> None:
        super().__init__(parent)
        self.units = units
        self.ribbon: Ribbon | None = None
        self.state: RawState | None = None

    def rowCount(self, parent: QModelIndex | None = None) -> int:
        """One row a sensor."""
        inside = parent is not None and parent.isValid()
        return 0 if inside or self.ribbon is None else len(self.ribbon.sensors)

    def columnCount(self, parent: QModelIndex | None = None) -> int:
        """Name, kind, place, three axes, length, noise, state."""
        return len(TITLES)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int) -> object:
        """The columns' titles."""
        if orientation == Qt.Orientation.Horizontal:
            if role == Qt.ItemDataRole.DisplayRole:
                return tr(TITLES[section])
            if role == Qt.ItemDataRole.ToolTipRole:
                return tr(TIPS[section])
        return None

    def data(self, index: QModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """A cell's text; what the screen shows is painted from `text` all the same."""
        if role == Qt.ItemDataRole.DisplayRole:
            return self.text(index.row(), index.column())
        if role == Qt.ItemDataRole.ToolTipRole and self.ribbon is not None:
            return sensor_words(self.ribbon.sensors[index.row()], self.units)
        return None

    def text(self, row: int, column: int) -> str:
        """What stands in a cell."""
        sensor = self.ribbon.sensors[row]
        if column == NAME:
            return sensor.name
        if column == KIND:
            return kind_words(sensor)
        if column == PLACE:
            return self.units.text(sensor.position)
        return "" if self.state is None else self._live(row, column)

    def _live(self, row: int, column: int) -> str:
        state = self.state
        if column == STATE:
            return tr("tapped") if state.flashing[row] else tr(FLAGS[state.words[row]])
        if column == NOISE:
            return f"{1e3 * state.noise[row]:.1f}"
        value = state.norm[row] if column == NORM else self.value(row, column - X)
        if value is None:
            return ""
        if isnan(value):
            return tr("lost")
        return f"{value:.3f}" if column == NORM else f"{value:+.3f}"

    def value(self, row: int, axis: int) -> float | None:
        """An axis' newest value; None where the sensor has no such axis or nothing came."""
        if self.state is None or axis >= self.ribbon.sensors[row].axes:
            return None
        return float(self.state.values[self.ribbon.slices[row].start + axis])


class _Painter(QStyledItemDelegate):
    """Paints a cell itself: asking the model for every property would take most of the time."""

    def __init__(self, model: SensorModel, view: QTableView) -> None:
        super().__init__(view)
        self._model, self._view = model, view
        self.take_colours()

    def take_colours(self) -> None:
        """The theme's colours, as Qt wants them."""
        self._of: Colours = colours_of(self._view.palette())
        self._words, self._chosen_words = QColor(self._of.words), QColor(self._of.on_chosen)
        self._bars = {k: QColor(self._of.curves[k]) for k in range(3)}
        for colour in self._bars.values():
            colour.setAlphaF(0.45)
        self._chosen_bar = QColor(self._of.on_chosen)
        self._chosen_bar.setAlphaF(0.45)
        self._chosen, self._zero = QColor(self._of.chosen), QPen(QColor(self._of.frame))
        self._poor, self._good = QColor(self._of.poor), QColor(self._of.good)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex) -> None:
        """Ground, bar, text."""
        row, column = index.row(), index.column()
        rect: QRect = option.rect
        chosen = bool(option.state & QStyle.StateFlag.State_Selected)
        if chosen:
            painter.fillRect(rect, self._chosen)
        if X <= column <= Z:
            self._bar(painter, rect, row, column, chosen)
        painter.setPen(self._pen(row, column, chosen))
        side = Qt.AlignmentFlag.AlignLeft
        if column not in (NAME, KIND, STATE):
            side = Qt.AlignmentFlag.AlignRight
        text = self._model.text(row, column)
        inside = rect.adjusted(EDGE, 0, -EDGE, 0)
        painter.drawText(inside, side | Qt.AlignmentFlag.AlignVCenter, text)

    def _pen(self, row: int, column: int, chosen: bool) -> QColor:
        state = self._model.state
        if chosen:
            return self._chosen_words
        if column == STATE and state is not None:
            if state.flashing[row]:
                return self._good
            if state.words[row]:
                return self._poor
        return self._words

    def _bar(self, painter: QPainter, rect: QRect, row: int, column: int, chosen: bool) -> None:
        value = self._model.value(row, column - X)
        if value is None or isnan(value):
            return
        half = (rect.width() - NUMBER) / 2 - EDGE
        middle = round(rect.left() + EDGE + half)
        length = max(-1.0, min(1.0, value / FULL)) * half
        bar = QRectF(min(middle, middle + length), rect.top() + 3, abs(length), rect.height() - 6)
        painter.fillRect(bar, self._chosen_bar if chosen else self._bars[column - X])
        painter.setPen(self._zero)
        painter.drawLine(middle, rect.top() + 2, middle, rect.bottom() - 2)


class SensorTable(QTableView):
    """All sensors of a ribbon in the order of its identity.

    chosen(i): a person chose the sensor with this place in the ribbon's list.
    """

    chosen = Signal(int)

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.sensors = SensorModel(units, self)
        self.setModel(self.sensors)
        self._painter = _Painter(self.sensors, self)
        self.setItemDelegate(self._painter)
        self.setAccessibleName(tr("Sensors"))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTabKeyNavigation(False)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 6)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        for column, width in enumerate(WIDTHS):
            self.setColumnWidth(column, width)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setStretchLastSection(True)
        self.selectionModel().currentRowChanged.connect(self._current_changed)
        self._quiet = False
        units.changed.connect(self.viewport().update)

    def show_ribbon(self, ribbon: Ribbon | None) -> None:
        """List a ribbon's sensors, or none."""
        self.sensors.beginResetModel()
        self.sensors.ribbon, self.sensors.state = ribbon, None
        self.sensors.endResetModel()

    def show_state(self, state: RawState | None) -> None:
        """Show the newest values; only what changes is painted."""
        self.sensors.state = state
        region = QRegion()
        for column in LIVE:
            left, width = self.columnViewportPosition(column), self.columnWidth(column)
            region += QRect(left, 0, width, self.viewport().height())
        self.viewport().update(region)

    def choose(self, sensor: int) -> None:
        """Mark a sensor as chosen; nothing is emitted."""
        self._quiet = True
        self.selectRow(sensor)
        self._quiet = False

    def changeEvent(self, event) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == event.Type.PaletteChange and hasattr(self, "_painter"):
            self._painter.take_colours()

    def _current_changed(self, current: QModelIndex, _before: QModelIndex) -> None:
        if current.isValid() and not self._quiet:
            self.chosen.emit(current.row())
