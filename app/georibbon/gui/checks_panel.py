"""The checks of the surface: what each found, where, and the advice that helps."""

from __future__ import annotations

from itertools import combinations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QPlainTextEdit,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.language import N_, sentence, tr
from georibbon.gui.verdict_icon import verdict_icon

COLUMNS = (N_("Check"), N_("Verdict"), N_("Where"), N_("Found"))
CHECK, VERDICT, WHERE, FOUND = range(len(COLUMNS))
# A check's verdict in words, and the verdict on a pass whose sign it has.
VERDICTS = {
    "pass": (N_("passed"), "good"),
    "warn": (N_("warning"), "acceptable"),
    "fail": (N_("failed"), "redo"),
}
NAMES = {
    "heading-drift": N_("Heading drift"),
    "facing": N_("Side"),
    "seam": N_("Normals at the passes"),
    "fold": N_("Fold"),
    "tear": N_("Tear"),
    "directions": N_("Directions across"),
    "pinch": N_("Pinch"),
    "crossing": N_("Passes that cross"),
    "skew": N_("Skew"),
    "normal-turn": N_("Turn of the normals"),
    "gap": N_("Gap"),
    "overlap": N_("Overlap"),
    "tangent-lengths": N_("Tangent lengths"),
    "self-crossing": N_("Runs through itself"),
    "cells": N_("Cells between ties"),
    "corner-angle": N_("Angle at crossings"),
    "corner-normals": N_("Normals at crossings"),
    "corner-twist": N_("Twist at crossings"),
}


class ChecksPanel(QWidget):
    """A table of the checks, those that are amiss first, and beside it the sentence of one.

    chosen(names): the passes of the line that a person chose; none for the whole surface.
    """

    chosen = Signal(list)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._result = None
        self.list = QTreeWidget()
        self.list.setAccessibleName(tr("Checks of the surface"))
        self.list.setRootIsDecorated(False)
        self.list.setAlternatingRowColors(True)
        self.list.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.list.setHeaderLabels([tr(one) for one in COLUMNS])
        header = self.list.header()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)
        self.message = QPlainTextEdit()
        self.message.setReadOnly(True)
        self.message.setAccessibleName(tr("What the chosen check found, and what helps"))
        both = QSplitter()
        both.setChildrenCollapsible(False)
        both.addWidget(self.list)
        both.addWidget(self.message)
        both.setStretchFactor(0, 3)
        both.setStretchFactor(1, 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(both)
        self.list.currentItemChanged.connect(lambda now, _: self._tell(now))
        self.list.itemClicked.connect(self._choose)
        self.list.itemActivated.connect(self._choose)
        self.show_result(None)

    def show_result(self, result) -> None:
        """The checks of a result's surface, or that there are none."""
        self._result = result
        rows = _rows(result)
        if rows == [_texts(item) for item in self._items()]:
            return  # a slider moves: the list stays where it is
        self.list.clear()
        for row in rows:
            self.list.addTopLevelItem(_item(row))
        if rows:
            self.list.setCurrentItem(self.list.topLevelItem(0))
        else:
            self.message.setPlainText(tr("There is no surface to be checked."))

    def _items(self):
        return map(self.list.topLevelItem, range(self.list.topLevelItemCount()))

    def _tell(self, item: QTreeWidgetItem | None) -> None:
        if item is not None:
            self.message.setPlainText(item.toolTip(CHECK))

    def _choose(self, item: QTreeWidgetItem) -> None:
        _code, _verdict, where, _found, _message = _texts(item)
        self.chosen.emit(_passes_of(where, self._result))


def _rows(result) -> list[tuple[str, str, str, str, str]]:
    """What stands in each line, and its sentence."""
    if result is None or result.surface is None:
        return []
    from georibbon.export.words import check_rows

    checks = result.surface.checks
    told = [
        {"code": one.code, "where": one.where, "verdict": one.verdict, "unit": one.unit,
         "value": one.value, "message": one.message}
        for one in checks
    ]  # fmt: skip
    return [
        (row["code"], row["verdict"], row["where"], row["found"], _sentences(row, checks))
        for row in check_rows(told)
    ]


def _sentences(row: dict[str, str], checks) -> str:
    """What a line says: of what is amiss its own sentence, else those of all of its kind."""
    same = [one.message for one in checks if one.code == row["code"] and one.verdict == "pass"]
    return "\n".join(map(sentence, same if row["verdict"] == "pass" else [row["message"]]))


def _item(row: tuple[str, str, str, str, str]) -> QTreeWidgetItem:
    code, verdict, where, found, message = row
    word, sign = VERDICTS[verdict]
    name = tr(NAMES[code]) if code in NAMES else code
    item = QTreeWidgetItem([name, tr(word), sentence(where), found])
    item.setIcon(VERDICT, verdict_icon(sign))
    item.setData(CHECK, Qt.ItemDataRole.UserRole, row)
    for column in range(len(COLUMNS)):
        item.setToolTip(column, message)
    return item


def _texts(item: QTreeWidgetItem) -> tuple[str, str, str, str, str]:
    return item.data(CHECK, Qt.ItemDataRole.UserRole)


def _passes_of(where: str, result) -> list[str]:
    """The passes that a place names: one, or two neighbours."""
    from georibbon.geometry.checks import pair_name

    names = [one.name for one in result.passes]
    pairs = [pair for pair in combinations(names, 2) if pair_name(*pair) == where]
    return [where] if where in names else list(pairs[0]) if pairs else []
