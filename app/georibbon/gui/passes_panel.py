"""The passes: how good each is and why, its smoothing, and below what else can be chosen of it."""

import math

from PySide6.QtCore import QItemSelectionModel, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QSplitter,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.document import EVERY_PASS
from georibbon.gui.language import N_, sentence, tr
from georibbon.gui.parts import Parts
from georibbon.gui.pass_details import PassDetails
from georibbon.gui.smoothing import AS_ALL, AUTOMATIC, SmoothingControl
from georibbon.gui.verdict_icon import verdict_icon

COLUMNS = (N_("Pass"), N_("Verdict"), N_("σ ({unit})"), N_("Smoothing"))
NAME, VERDICT, SIGMA, SMOOTHING = range(len(COLUMNS))
MOST_REASONS = 6
ROWS = QItemSelectionModel.SelectionFlag.Select | QItemSelectionModel.SelectionFlag.Rows
ROOM = 64  # pixels: a verdict's sign, margins and a scroll bar
KINDS = {"pass": N_("pass"), "tie": N_("tie")}
VERDICTS = {"good": N_("good"), "acceptable": N_("acceptable"), "redo": N_("redo")}


class PassesPanel(QWidget):
    """A table of the passes, the first line for all of them, and the choices of the chosen one.

    chosen(names): the passes in the lines that a person selected.
    """

    chosen = Signal(list)

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._document, self._units = parts.document, parts.units
        self._names: list[str] = []
        self._controls: dict[str, SmoothingControl] = {}
        self._make_table()
        self.reasons = QLabel()
        self.reasons.setWordWrap(True)
        self.reasons.setTextFormat(Qt.TextFormat.PlainText)
        self.reasons.setMargin(4)
        self.reasons.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.reasons.setAccessibleName(tr("Why the passes are good or not"))
        above = QWidget()
        column = QVBoxLayout(above)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.table, 1)
        column.addWidget(self.reasons)
        self.details = PassDetails(parts)
        self.splitter = QSplitter(Qt.Orientation.Vertical)
        self.splitter.setChildrenCollapsible(False)
        self.splitter.addWidget(above)
        self.splitter.addWidget(self.details)
        self.splitter.setStretchFactor(0, 3)
        self.splitter.setStretchFactor(1, 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.splitter)
        self._connect()
        self._changed("source")

    def _make_table(self) -> None:
        self.table = QTableWidget(0, len(COLUMNS))
        self.table.setAccessibleName(tr("Passes"))
        self.table.verticalHeader().hide()
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setTabKeyNavigation(False)  # Tab goes on to the sliders
        self.table.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(SMOOTHING, QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(40)
        self._name_columns()

    def _connect(self) -> None:
        self.table.itemSelectionChanged.connect(self._select)
        self._document.changed.connect(self._changed)
        self._document.reconstructed.connect(self._show_result)
        self._units.changed.connect(self._take_unit)

    def _name_columns(self) -> None:
        unit = self._units.symbol
        self.table.setHorizontalHeaderLabels(
            [tr(one, unit=unit) if "{" in one else tr(one) for one in COLUMNS]
        )

    def _take_unit(self) -> None:
        self._name_columns()
        if self._document.reconstruction is not None:
            self._show_result(self._document.reconstruction)
        if self._controls:
            self._make_room()

    def control(self, name: str) -> SmoothingControl:
        """The smoothing of a pass, or of "*"."""
        return self._controls[name]

    def selected(self) -> list[str]:
        """The names of the passes in the selected lines, in their order."""
        rows = {index.row() for index in self.table.selectionModel().selectedRows()}
        return [name for row, name in enumerate(self._names, start=1) if row in rows]

    def select(self, names: list[str]) -> None:
        """Select the lines of these passes, and no others."""
        model = self.table.selectionModel()
        with QSignalBlocker(self.table):
            model.clearSelection()
            for name in names:
                index = self.table.model().index(self._row(name), 0)
                model.select(index, ROWS)
        self._select()

    def text(self, name: str, column: int) -> str:
        """What stands in a pass's line."""
        return self.table.item(self._row(name), column).text()

    def _select(self) -> None:
        names = self.selected()
        self.details.look_at(names[0] if len(names) == 1 else EVERY_PASS)
        self._show_reasons()
        self.chosen.emit(names)

    def _row(self, name: str) -> int:
        return 0 if name == EVERY_PASS else 1 + self._names.index(name)

    def _changed(self, what: str) -> None:
        passes = self._document.passes
        if what == "source" or [one.name for one in passes] != self._names:
            self._fill(passes)
            self.details.look_at(EVERY_PASS)
        self._show_smoothing()
        self.details.refresh()

    def _fill(self, passes) -> None:
        self.table.setRowCount(0)
        self._names = [one.name for one in passes]
        self._controls = {}
        self.reasons.clear()
        if not passes:
            return
        self.table.setRowCount(1 + len(passes))
        self._line(0, EVERY_PASS, tr("all"), tr("all passes without their own"))
        for row, one in enumerate(passes, start=1):
            kind = tr(KINDS[one.kind])
            whose = tr("{kind} {name}", kind=kind, name=one.name)
            self._line(row, one.name, one.name if one.kind == "pass" else whose, whose)
        self._make_room()
        for row in range(self.table.rowCount()):
            height = self._controls[EVERY_PASS].sizeHint().height() + 4
            self.table.setRowHeight(row, height)

    def _make_room(self) -> None:
        """So wide that no part of a line lies over another, whatever the verdicts will be."""
        header = self.table.horizontalHeader()
        columns = [
            max(self.table.sizeHintForColumn(column), header.sectionSizeHint(column))
            for column in (NAME, SIGMA)
        ]
        words = max(self.fontMetrics().horizontalAdvance(tr(one)) for one in VERDICTS.values())
        control = self._controls[EVERY_PASS].minimumSizeHint().width()
        self.table.setMinimumWidth(sum(columns) + words + control + ROOM)

    def _line(self, row: int, name: str, shown: str, whose: str) -> None:
        for column in range(len(COLUMNS)):
            self.table.setItem(row, column, QTableWidgetItem())
        self.table.item(row, NAME).setText(shown)
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        self.table.item(row, SIGMA).setTextAlignment(right)
        control = SmoothingControl(self._units, whose, tr(AUTOMATIC))
        document = self._document
        control.previewed.connect(lambda metres: document.preview_smoothing(name, metres))
        control.chosen.connect(lambda metres: document.set_smoothing(name, metres))
        control.reset.connect(lambda: document.set_smoothing(name, None))
        self.table.setCellWidget(row, SMOOTHING, control)
        self._controls[name] = control

    def _show_smoothing(self) -> None:
        smoothing, result = self._document.smoothing, self._document.reconstruction
        passes = () if result is None else result.passes
        fitted = {one.name: one.smoothing for one in passes if one.smoothing > 0.0}
        smooths = result is None or result.method != "paper"
        every = smoothing.get(EVERY_PASS)
        for name, control in self._controls.items():
            control.set_useful(smooths)
            if name == EVERY_PASS:
                usual = math.exp(_mean([math.log(one) for one in fitted.values()]))
                control.show_value(
                    every or (usual if fitted else None), every is not None, tr(AUTOMATIC)
                )
            else:
                otherwise = tr(AUTOMATIC if every is None else AS_ALL)
                own = smoothing.get(name)
                control.show_value(own or every or fitted.get(name), own is not None, otherwise)

    def _show_result(self, result) -> None:
        fitted = {one.name: one for one in result.passes}
        for name in self._names:
            if name in fitted:
                self._show_pass(self._row(name), fitted[name])
        self._show_smoothing()
        self._show_reasons()
        self.details.refresh()

    def _show_reasons(self) -> None:
        """Why, of the selected passes or of all, those with the same reason together."""
        result = self._document.reconstruction
        if result is None:
            return
        wanted = self.selected() or self._names
        together: dict[tuple[str, str], list[str]] = {}
        for one in result.passes:
            if one.name in wanted:
                verdict = (one.quality.verdict, one.quality.reason)
                together.setdefault(verdict, []).append(one.name)
        lines = [
            tr(
                "{names}: {verdict}: {reason}",
                names=", ".join(names),
                verdict=tr(VERDICTS[verdict]),
                reason=sentence(reason),
            )
            for (verdict, reason), names in together.items()
        ]
        self.reasons.setText("\n".join(lines[:MOST_REASONS]))

    def _show_pass(self, row: int, fitted) -> None:
        sigma = fitted.position_sigma
        rms = math.hypot(*sigma) / math.sqrt(len(sigma))
        quality = fitted.quality
        self.table.item(row, VERDICT).setText(tr(VERDICTS[quality.verdict]))
        self.table.item(row, VERDICT).setIcon(verdict_icon(quality.verdict))
        self.table.item(row, SIGMA).setText(self._units.number(rms, 1))
        for column in (NAME, VERDICT, SIGMA):
            self.table.item(row, column).setToolTip(sentence(quality.reason))


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else 0.0
