"""The sensors of a pass: which are listened to, and how far each is off the curve."""

from dataclasses import dataclass

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from georibbon.gui.language import N_, tr
from georibbon.gui.units import Units

# As in `fitting.assessment`, whose import would keep the window waiting.
NAMED = 5.0
IGNORED = 3.0 * 10.0**0.5
COLUMNS = (N_("Sensor"), N_("Off by (σ)"), N_("Meaning"), N_("At"), N_("Kind"))
SENSOR, OFF_BY, MEANING, AT, KIND = range(len(COLUMNS))
KINDS = {"accelerometer": N_("accelerometer"), "magnetometer": N_("magnetometer")}
_PLACE = Qt.ItemDataRole.UserRole


@dataclass(frozen=True)
class SensorLine:
    """One sensor's line.

    at: metres along the ribbon.  off_by: normalised residual, None where there
    is none; of: the pass it is of, where several are looked at.  on: whether it
    is listened to; fixed: it was switched off in all passes at once.
    """

    name: str
    kind: str
    at: float
    off_by: float | None
    of: str | None
    on: bool
    fixed: bool = False


class _Item(QTreeWidgetItem):
    """A line that is sorted by numbers where they are numbers."""

    def __lt__(self, other: QTreeWidgetItem) -> bool:
        column = self.treeWidget().sortColumn()
        mine, theirs = self.data(column, _PLACE), other.data(column, _PLACE)
        if mine is None or theirs is None:
            return self.text(column) < other.text(column)
        return bool(mine < theirs)


class SensorList(QTreeWidget):
    """Sensors with boxes to be checked; a click on a column's head sorts by it.

    switched(names): those that are off now, of those that can be switched here.
    """

    switched = Signal(list)

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = units
        self._lines: list[SensorLine] = []
        self._fitted: set[int] = set()
        self.setRootIsDecorated(False)
        self.setAlternatingRowColors(True)
        self.setUniformRowHeights(True)
        self.setHeaderLabels([tr(name) for name in COLUMNS])
        # Widths by the contents at every change of a cell would take longer than all the rest.
        self.header().setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        self.header().setStretchLastSection(True)
        self.setSortingEnabled(True)
        self.sortByColumn(AT, Qt.SortOrder.AscendingOrder)
        self.setAccessibleName(tr("Sensors, checked where they are listened to"))
        self.itemChanged.connect(self._toggled)
        units.changed.connect(self._show_places)

    def show_lines(self, lines: list[SensorLine]) -> None:
        """Show sensors; nothing is emitted, and who stands on one stays there."""
        if lines == self._lines:
            return
        before, self._lines = {line.name: line for line in self._lines}, lines
        with QSignalBlocker(self):
            self.setSortingEnabled(False)
            while self.topLevelItemCount() > len(lines):
                self.takeTopLevelItem(self.topLevelItemCount() - 1)
            while self.topLevelItemCount() < len(lines):
                self.addTopLevelItem(_Item())
            here = self.currentItem().text(SENSOR) if self.currentItem() else None
            for k, line in enumerate(lines):
                item = self.topLevelItem(k)
                if item.text(SENSOR) != line.name or before.get(line.name) != line:
                    self._fill(item, line)
                if line.name == here:
                    self.setCurrentItem(item)
            self.setSortingEnabled(True)
        self._fit_columns()

    def _fit_columns(self) -> None:
        """Columns as wide as their contents; none narrower than it was, so that nothing jumps."""
        for column in range(KIND):
            width = max(self.sizeHintForColumn(column), self.header().sectionSizeHint(column))
            if width > self.columnWidth(column) or column not in self._fitted:
                self.setColumnWidth(column, width)
            self._fitted.add(column)

    def _fill(self, item: QTreeWidgetItem, line: SensorLine) -> None:
        item.setText(SENSOR, line.name)
        item.setText(KIND, tr(KINDS.get(line.kind, line.kind)))
        item.setText(AT, self._units.text(line.at))
        item.setData(AT, _PLACE, line.at)
        off_by = "–" if line.off_by is None else f"{line.off_by:.1f}"
        item.setText(OFF_BY, f"{off_by} ({line.of})" if line.of else off_by)
        item.setData(OFF_BY, _PLACE, -1.0 if line.off_by is None else line.off_by)
        item.setText(MEANING, _meaning(line))
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        for column in (AT, OFF_BY):
            item.setTextAlignment(column, right)
        font = item.font(MEANING)
        font.setBold(line.on and (line.off_by or 0.0) > NAMED)
        for column in (SENSOR, OFF_BY, MEANING):
            item.setFont(column, font)
        flags = Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemIsUserCheckable
        item.setFlags(flags if line.fixed else flags | Qt.ItemFlag.ItemIsEnabled)
        item.setCheckState(SENSOR, Qt.CheckState.Checked if line.on else Qt.CheckState.Unchecked)

    def _show_places(self) -> None:
        lines, self._lines = self._lines, []
        self._fitted.clear()
        self.show_lines(lines)

    def _toggled(self, _item: QTreeWidgetItem, column: int) -> None:
        if column != SENSOR:
            return
        fixed = {line.name for line in self._lines if line.fixed}
        items = [self.topLevelItem(k) for k in range(self.topLevelItemCount())]
        off = [
            item.text(SENSOR)
            for item in sorted(items, key=lambda one: one.data(AT, _PLACE))
            if item.checkState(SENSOR) == Qt.CheckState.Unchecked and item.text(SENSOR) not in fixed
        ]
        self.switched.emit(off)


def _meaning(line: SensorLine) -> str:
    """What a residual means, in words."""
    if line.fixed:
        return tr("switched off in all passes")
    if not line.on:
        return tr("switched off")
    if line.off_by is None:
        return tr("says nothing")
    if line.off_by > IGNORED:
        return tr("▲ disagrees: has no say")
    if line.off_by > NAMED:
        return tr("▲ disagrees: counts for less")
    return tr("agrees")
