"""The calibrations that are kept: named, used, checked, exported, deleted and put back."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.errors import GeoribbonError
from georibbon.gui.calibrating.words import VERDICTS, told_words
from georibbon.gui.language import N_, tr
from georibbon.session.calibration_shelf import Kept, Shelf, Spoilt

COLUMNS = (
    N_("Name"), N_("Ribbon"), N_("Made"), N_("Tilt"), N_("Heading"), N_("Last check"),
)  # fmt: skip
NAME = 0


def local_time(moment: str) -> str:
    """A time in UTC, ISO 8601, as the clock here shows it."""
    return datetime.fromisoformat(moment).astimezone().strftime("%Y-%m-%d %H:%M")


class KeptList(QWidget):
    """The list.

    chosen(): another line is chosen.  wanted(what): "use", "check", "export" or
    "load", of the chosen one.  altered(): what is kept has changed here.
    """

    chosen = Signal()
    wanted = Signal(str)
    altered = Signal()

    def __init__(self, shelf: Shelf, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shelf = shelf
        self.kept: tuple[Kept, ...] = ()
        self._discarded: list[tuple[str, Path]] = []
        self.table = QTableWidget(0, len(COLUMNS))
        self.table.setHorizontalHeaderLabels([tr(one) for one in COLUMNS])
        self.table.setAccessibleName(tr("Calibrations that are kept"))
        self.table.verticalHeader().hide()
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setEditTriggers(
            QAbstractItemView.EditTrigger.EditKeyPressed
            | QAbstractItemView.EditTrigger.SelectedClicked
        )
        self.table.setTabKeyNavigation(False)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
        self.buttons = {
            "check": QPushButton(tr("Daily &check…")),
            "use": QPushButton(tr("Capture &with it")),
            "rename": QPushButton(tr("Rena&me")),
            "export": QPushButton(tr("&Export…")),
            "delete": QPushButton(tr("&Delete")),
            "load": QPushButton(tr("&Load from a file…")),
        }
        self.told = QLabel()
        self.told.setWordWrap(True)
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.undo = QPushButton(tr("&Undo"))
        self.undo.setVisible(False)
        self._lay_out()
        self.table.itemSelectionChanged.connect(self._select)
        self.table.itemChanged.connect(self._renamed)
        for key in ("check", "use", "export", "load"):
            self.buttons[key].clicked.connect(lambda _=False, key=key: self.wanted.emit(key))
        self.buttons["delete"].clicked.connect(self.delete)
        self.buttons["rename"].clicked.connect(self.rename)
        self.undo.clicked.connect(self.put_back)
        self._select()

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        for key in ("check", "use"):
            row.addWidget(self.buttons[key])
        row.addStretch()
        for key in ("rename", "export", "delete", "load"):
            row.addWidget(self.buttons[key])
        below = QHBoxLayout()
        below.addWidget(self.told, 1)
        below.addWidget(self.undo)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.table, 1)
        layout.addLayout(row)
        layout.addLayout(below)

    @property
    def current(self) -> Kept | None:
        """The chosen one."""
        row = self.table.currentRow()
        chosen = bool(self.table.selectedItems()) and 0 <= row < len(self.kept)
        return self.kept[row] if chosen else None

    def show_kept(self, kept: Sequence[Kept], spoilt: Sequence[Spoilt]) -> None:
        """Show what is kept, and what holds no calibration."""
        before = self.current
        self.kept = tuple(kept)
        with QSignalBlocker(self.table):
            self.table.setRowCount(len(self.kept))
            for row, one in enumerate(self.kept):
                self._fill(row, one)
        if spoilt:
            self.told.setText("\n".join(told_words(one.reason) for one in spoilt))
        paths = [one.path for one in self.kept]
        if paths:
            self.table.selectRow(paths.index(before.path) if before and before.path in paths else 0)
        self._select()

    def _fill(self, row: int, one: Kept) -> None:
        quality, last = one.calibration.quality, one.checks[-1] if one.checks else None
        figures = ["–", "–"]
        if quality is not None:
            figures = [tr("{value}°", value=f"{v:.2f}") for v in (quality.tilt, quality.heading)]
        check = tr("never")
        if last is not None:
            check = tr(
                "{verdict}, {degrees}°, {time}",
                verdict=tr(VERDICTS[last.verdict]),
                degrees=f"{last.degrees:.2f}",
                time=local_time(last.time),
            )
        texts = (one.name, one.calibration.ribbon_id, local_time(one.made), *figures, check)
        for column, text in enumerate(texts):
            item = QTableWidgetItem(text)
            if column != NAME:
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
            self.table.setItem(row, column, item)
        self.table.item(row, NAME).setToolTip(str(one.path))

    def _select(self) -> None:
        for key in ("check", "use", "rename", "export", "delete"):
            self.buttons[key].setEnabled(self.current is not None)
        self.chosen.emit()

    def tell(self, words: str) -> None:
        """Tell something about the list."""
        self.told.setText(words)

    def rename(self) -> None:
        """Edit the chosen one's name where it stands."""
        if self.current is not None:
            self.table.setFocus(Qt.FocusReason.OtherFocusReason)
            self.table.editItem(self.table.item(self.table.currentRow(), NAME))

    def _renamed(self, item: QTableWidgetItem) -> None:
        one = self.kept[item.row()]
        if item.column() != NAME or item.text() == one.name:
            return
        try:
            self._shelf.rename(one, item.text())
        except GeoribbonError as error:
            self.tell(told_words(str(error)))
            with QSignalBlocker(self.table):
                item.setText(one.name)
            return
        self.tell("")
        self.altered.emit()

    def delete(self) -> None:
        """Take the chosen one away; it can be put back."""
        one = self.current
        if one is None:
            return
        try:
            self._discarded.append((one.name, self._shelf.discard(one)))
        except GeoribbonError as error:
            self.tell(told_words(str(error)))
        else:
            self.tell(tr("“{name}” is deleted.", name=one.name))
        self.undo.setVisible(bool(self._discarded))
        self.altered.emit()

    def put_back(self) -> None:
        """Put back what was deleted last."""
        if not self._discarded:
            return
        name, path = self._discarded.pop()
        try:
            self._shelf.restore(path)
        except GeoribbonError as error:
            self.tell(told_words(str(error)))
        else:
            self.tell(tr("“{name}” is there again.", name=name))
        self.undo.setVisible(bool(self._discarded))
        self.altered.emit()
