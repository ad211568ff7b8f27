"""The passes of two results beside each other."""

import math
from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from georibbon.gui.language import N_, sentence, tr
from georibbon.gui.units import Units

WORDS = {
    "good": N_("✔ good"),
    "acceptable": N_("! acceptable"),
    "redo": N_("✖ redo"),
}
_NONE = "–"
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


class CompareTable(QTreeWidget):
    """For every pass its verdict, uncertainty and smoothing in the one and in the other."""

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = units
        self._pairs = ()
        self.setAccessibleName(tr("Passes of both, side by side"))
        self.setRootIsDecorated(False)
        self.setAlternatingRowColors(True)
        self.setUniformRowHeights(True)
        self.setColumnCount(7)
        self.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.header().setStretchLastSection(False)
        units.changed.connect(self._show)
        self._show()

    def show_pairs(self, pairs: Sequence) -> None:
        """Show `PassPair`s."""
        self._pairs = tuple(pairs)
        self._show()

    def _show(self) -> None:
        symbol = self._units.symbol
        side = (tr("Verdict"), tr("1σ, {unit}", unit=symbol), tr("Smoothing, {unit}", unit=symbol))
        other = [tr("{column} of the other", column=column) for column in side]
        self.setHeaderLabels([tr("Pass"), *side, *other])
        for column in (2, 3, 5, 6):
            self.headerItem().setTextAlignment(column, _RIGHT)
        self.clear()
        for pair in self._pairs:
            words = [pair.name, *self._cells(pair.first), *self._cells(pair.second)]
            item = QTreeWidgetItem(words)
            for column in (2, 3, 5, 6):
                item.setTextAlignment(column, _RIGHT)
            for column, fitted in ((1, pair.first), (4, pair.second)):
                if fitted is not None:
                    item.setToolTip(column, sentence(fitted.quality.reason))
            self.addTopLevelItem(item)

    def _cells(self, fitted) -> list[str]:
        if fitted is None:
            return [_NONE] * 3
        sigma = fitted.position_sigma
        rms = math.hypot(*sigma) / math.sqrt(len(sigma))
        return [
            tr(WORDS[fitted.quality.verdict]),
            self._units.number(rms, 1),
            self._units.number(fitted.smoothing),
        ]
