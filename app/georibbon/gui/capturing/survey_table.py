"""The survey in a table: marks, distances, crossings, edited in place, with their residuals."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from PySide6.QtCore import QEvent, QSignalBlocker, Qt
from PySide6.QtGui import QColor, QKeyEvent
from PySide6.QtWidgets import (
    QGridLayout,
    QHeaderView,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.capture.plan import places
from georibbon.capture.survey_rows import SurveyRow, make_entry, proposed
from georibbon.gui.capturing.board import Words
from georibbon.gui.capturing.model import CaptureModel
from georibbon.gui.language import N_, tr, trn
from georibbon.gui.language import sentence as spoken
from georibbon.gui.parts import Parts
from georibbon.gui.theme import colours_of

KIND, PASS, AT, OTHER, OTHER_AT, X, Y, Z, SIGMA, RESIDUAL, FIT = range(11)
WORDS = {"mark": N_("mark"), "distance": N_("distance"), "crossing": N_("crossing")}
GRADES = {
    "open": N_("—"),
    "fits": N_("fits"),
    "suspect": N_("look at it twice"),
    "outlier": N_("outlier: measure again"),
}
# Which columns an entry of a kind fills.
FIELDS = {
    "mark": (PASS, AT, X, Y, Z, SIGMA),
    "distance": (PASS, AT, OTHER, OTHER_AT, X, SIGMA),
    "crossing": (PASS, AT, OTHER, OTHER_AT, SIGMA),
}
NAMES = (PASS, OTHER)


@dataclass
class Draft:
    """An entry that is not complete yet; values: texts of names, metres of lengths."""

    table: str
    values: dict[int, str | float] = field(default_factory=dict)

    @property
    def missing(self) -> list[int]:
        """The columns that are empty."""
        return [column for column in FIELDS[self.table] if column not in self.values]


class SurveyTable(QWidget):
    """All entries; what is not complete yet stands below and is kept as soon as it is."""

    def __init__(self, parts: Parts, model: CaptureModel, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts, self._model = parts, model
        self._rows: tuple[SurveyRow, ...] = ()
        self.drafts: list[Draft] = []
        self.table = _Table(self)
        self.problem = Words()
        self.problem.setAccessibleName(tr("What is wrong with the survey"))
        self.problem.hide()
        self.state = Words()
        self.add_mark = QPushButton(tr("Add &mark"))
        self.add_distance = QPushButton(tr("Add distan&ce"))
        self.add_crossing = QPushButton(tr("Add cr&ossing"))
        self.propose = QPushButton(tr("Fill in what is planned"))
        self.delete = QPushButton(tr("Delete entry"))
        self._lay_out()
        self.add_mark.clicked.connect(lambda: self.add("mark"))
        self.add_distance.clicked.connect(lambda: self.add("distance"))
        self.add_crossing.clicked.connect(lambda: self.add("crossing"))
        self.propose.clicked.connect(self.fill_in)
        self.delete.clicked.connect(self.delete_chosen)
        self.table.itemChanged.connect(self._edited)
        self.table.itemSelectionChanged.connect(self._follow_selection)
        parts.units.changed.connect(self._fill)
        parts.capture.refused.connect(self._refuse)
        parts.document.not_yet.connect(self._not_yet)
        parts.document.reconstructed.connect(lambda _: self._not_yet(""))
        model.changed.connect(self.refresh)
        self._fill()

    def _lay_out(self) -> None:
        buttons = QGridLayout()  # in two rows: half a narrow window is theirs
        for column, button in enumerate((self.add_mark, self.add_distance, self.add_crossing)):
            buttons.addWidget(button, 0, column)
        buttons.addWidget(self.propose, 1, 0, 1, 2)
        buttons.addWidget(self.delete, 1, 2)
        buttons.setColumnStretch(3, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 6, 4, 4)
        layout.addLayout(buttons)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.problem)
        layout.addWidget(self.state)

    # --- what a person does ---

    def add(self, table: str) -> None:
        """A new line with what can be guessed; it is kept as soon as it is filled."""
        layout, passes = self._model.layout, self._model.pass_order
        sigma = getattr(layout, f"{table}_sigma")
        draft = Draft(table, {SIGMA: sigma})
        if passes:
            draft.values |= {PASS: passes[0], AT: 0.0}
        if table == "distance" and len(passes) > 1:
            draft.values |= {OTHER: passes[1], OTHER_AT: 0.0}
        ties = [name for name, kind in self._model.kinds.items() if kind == "tie"]
        if table == "crossing" and ties:
            draft.values[OTHER] = ties[0]
        if table == "crossing":
            del draft.values[AT]
        self.drafts.append(draft)
        self._fill()
        row = self.table.rowCount() - 1
        self.table.setCurrentCell(row, (draft.missing or [PASS])[0])
        self.table.setFocus()

    def fill_in(self) -> None:
        """Lines for all that is planned and not measured yet, filled as far as can be known."""
        ribbon, model = self._model.ribbon, self._model
        if ribbon is None:
            return
        kinds = model.kinds
        ties = [name for name in model.order if kinds.get(name) == "tie"]
        tables = self._parts.capture.survey
        new = proposed(model.layout, ribbon.length, model.pass_order, ties, tables)
        self._propose_marks(ribbon.length)
        if new:
            self._parts.capture.add_surveys(new)
        self._fill()

    def _propose_marks(self, length: float) -> None:
        there = {(row.passes[0], round(row.at[0], 3)) for row in self._rows if row.table == "mark"}
        there |= {
            (draft.values.get(PASS), round(float(draft.values.get(AT, -1.0)), 3))
            for draft in self.drafts
            if draft.table == "mark"
        }
        for name in self._model.pass_order:
            for at in places(self._model.layout.marks, length):
                if (name, round(at, 3)) not in there:
                    sigma = self._model.layout.mark_sigma
                    self.drafts.append(Draft("mark", {PASS: name, AT: at, SIGMA: sigma}))

    def delete_chosen(self) -> None:
        """Take the chosen entry out; undo brings it back."""
        k = self.table.currentRow()
        if 0 <= k < len(self._rows):
            row = self._rows[k]
            self._parts.capture.remove_survey(row.table, row.number)
        elif k - len(self._rows) in range(len(self.drafts)):
            del self.drafts[k - len(self._rows)]
            self._fill()

    def _edited(self, item: QTableWidgetItem) -> None:
        k, column = item.row(), item.column()
        self._refuse("")
        value = self._parsed(column, item.text())
        if value is None:
            self._refuse(
                tr("“{text}” is no number; give a length in {unit}", text=item.text(),
                   unit=self._parts.units.symbol)
            )  # fmt: skip
            self._fill()
            return
        if k < len(self._rows):
            row = self._rows[k]
            values = _values(row)
            if values.get(column) != value:
                entry = _entry(row.table, values | {column: value})
                self._parts.capture.change_survey(row.table, row.number, entry)
                self._fill()
            return
        draft = self.drafts[k - len(self._rows)]
        draft.values[column] = value
        if not draft.missing:
            self.drafts.remove(draft)
            self._parts.capture.add_survey(draft.table, _entry(draft.table, draft.values))
        self._fill()

    def _parsed(self, column: int, text: str) -> str | float | None:
        if column in NAMES:
            return text.strip()
        try:
            number = float(text.strip().replace(",", "."))
        except ValueError:
            return None
        units = self._parts.units
        return units.metres(number) if abs(units.metres(number)) < 1e6 else None

    def changeEvent(self, event: QEvent) -> None:
        """The lines' colours follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "delete"):
            self._fill()

    # --- showing ---

    def refresh(self) -> None:
        """Show the survey as it is now."""
        rows = self._model.survey()
        if rows != self._rows:
            self._rows = rows
            self._fill()
        self.propose.setEnabled(self._model.ribbon is not None)

    def _fill(self) -> None:
        place = (self.table.currentRow(), self.table.currentColumn())
        with QSignalBlocker(self.table):
            self._head()
            self.table.setRowCount(len(self._rows) + len(self.drafts))
            for k, row in enumerate(self._rows):
                self._line(k, row.table, _values(row), row)
            for k, draft in enumerate(self.drafts, start=len(self._rows)):
                self._line(k, draft.table, draft.values, None)
            if place[0] >= 0:
                self.table.setCurrentCell(min(place[0], self.table.rowCount() - 1), place[1])
        self._follow_selection()

    def _head(self) -> None:
        unit = self._parts.units.symbol
        self.table.setHorizontalHeaderLabels(
            [
                tr("Kind"), tr("Pass"), tr("at ({unit})", unit=unit), tr("Other pass"),
                tr("at ({unit})", unit=unit), tr("x or distance ({unit})", unit=unit),
                tr("y ({unit})", unit=unit), tr("z ({unit})", unit=unit),
                tr("± ({unit})", unit=unit), tr("missed by ({unit})", unit=unit), tr("Fit"),
            ]
        )  # fmt: skip

    def _line(self, k: int, table: str, values, row: SurveyRow | None) -> None:
        for column in range(FIT + 1):
            item = QTableWidgetItem(self._text(column, table, values, row))
            if column not in FIELDS[table]:
                item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            elif row is None and column not in values:
                item.setBackground(QColor(colours_of(self.palette()).other))
                item.setToolTip(tr("to be filled in"))
            if column not in (KIND, *NAMES, FIT):
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self._colour(item, column, row)
            self.table.setItem(k, column, item)

    def _text(self, column: int, table: str, values, row: SurveyRow | None) -> str:
        units = self._parts.units
        if column == KIND:
            return tr(WORDS[table])
        if column == FIT:
            if row is None:
                return tr("to be filled in")
            words = tr(GRADES[row.grade])
            return words if row.ratio is None else f"{words} ({row.ratio:.1f} σ)"
        if column == RESIDUAL:
            return "" if row is None or row.residual is None else units.number(row.residual, 1)
        if column not in values:
            return "?" if row is None and column in FIELDS[table] else ""
        return values[column] if column in NAMES else units.number(values[column], 1)

    def _colour(self, item: QTableWidgetItem, column: int, row: SurveyRow | None) -> None:
        of = colours_of(self.palette())
        if column in (RESIDUAL, FIT) and row is not None:
            colour = {"fits": of.good, "suspect": of.fair, "outlier": of.poor}.get(row.grade)
            if colour is not None:
                item.setForeground(QColor(colour))

    def _follow_selection(self) -> None:
        self.delete.setEnabled(0 <= self.table.currentRow() < self.table.rowCount())

    def _not_yet(self, sentence: str) -> None:
        """Why there are no residuals yet."""
        outliers = sum(row.grade == "outlier" for row in self._rows)
        words = spoken(sentence)
        if not sentence and outliers:
            words = trn("{n} outlier", "{n} outliers", outliers)
        self.state.setText(words)

    def _refuse(self, sentence: str) -> None:
        self.problem.say(spoken(sentence), "poor")
        self.problem.setVisible(bool(sentence))
        if sentence:
            self._fill()


class _Table(QTableWidget):
    """The table itself: Delete takes an entry out, the taking keys are left to the page."""

    def __init__(self, owner: SurveyTable) -> None:
        super().__init__(0, FIT + 1)
        self._owner = owner
        self.setAccessibleName(tr("Survey"))
        self.verticalHeader().hide()
        self.setAlternatingRowColors(True)
        self.setTabKeyNavigation(True)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """As its class says."""
        editing = self.state() == QTableWidget.State.EditingState
        if event.key() == Qt.Key.Key_Delete and not editing:
            self._owner.delete_chosen()
        elif event.key() == Qt.Key.Key_PageDown and not editing:
            event.ignore()
        else:
            super().keyPressEvent(event)


def _values(row: SurveyRow) -> dict[int, str | float]:
    """An entry by the table's columns."""
    out: dict[int, str | float] = {PASS: row.passes[0], AT: row.at[0], SIGMA: row.sigma}
    if len(row.passes) > 1:
        out |= {OTHER: row.passes[1], OTHER_AT: row.at[1]}
    out |= dict(zip((X, Y, Z), row.values, strict=False))
    return out


def _entry(table: str, values: dict[int, str | float]) -> dict[str, object]:
    """An entry as in a recording, from the table's columns."""
    passes: Sequence = [values[column] for column in NAMES if column in values]
    at = [values[column] for column in (AT, OTHER_AT) if column in values]
    numbers = [values[column] for column in (X, Y, Z) if column in values]
    return make_entry(table, passes, at, numbers, values[SIGMA])
