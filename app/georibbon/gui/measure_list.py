"""The list of what was picked and measured in the 3D view."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QGuiApplication, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QListWidget, QListWidgetItem

from georibbon.gui.language import N_, tr
from georibbon.gui.measure_words import distance_words, pick_words, section_words
from georibbon.gui.units import Units

if TYPE_CHECKING:
    from georibbon.scene.measuring import Distance, Pick, Section


class Results(QListWidget):
    """What was picked and measured, the newest last.

    chosen(Section | None): the section that is current, if it is one.  filled():
    it is another list.
    """

    chosen = Signal(object)
    filled = Signal()

    def __init__(self, units: Units) -> None:
        super().__init__()
        self._units = units
        self._found: list[tuple[str, Pick | Distance | Section]] = []
        self._numbers = {"point": 0, "distance": 0, "section": 0}
        self.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)
        self.setWordWrap(True)
        self.setAlternatingRowColors(True)
        self.setMinimumHeight(90)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setAccessibleName(tr("Picked and measured"))
        self.currentRowChanged.connect(lambda _row: self.chosen.emit(self.section()))

    def sizeHint(self) -> QSize:
        """A few lines, and more where there is room."""
        return QSize(200, 90)

    def add(self, found: Pick | Distance | Section) -> None:
        """Put what was found at the end, and choose it."""
        kind = type(found).__name__.lower().replace("pick", "point")
        self._numbers[kind] += 1
        titles = {"point": N_("Point {n}"), "distance": N_("Distance {n}"),
                  "section": N_("Section {n}")}  # fmt: skip
        self._found.append((tr(titles[kind], n=self._numbers[kind]), found))
        self.fill()
        self.setCurrentRow(self.count() - 1)
        self.filled.emit()

    def empty(self) -> None:
        """Forget everything."""
        self._found = []
        self._numbers = dict.fromkeys(self._numbers, 0)
        self.fill()
        self.filled.emit()

    def fill(self) -> None:
        """Write everything anew, in the unit in use."""
        row = self.currentRow()
        with QSignalBlocker(self):
            self.clear()
            for k in range(len(self._found)):
                self.addItem(QListWidgetItem(self._words(k)))
            self.setCurrentRow(row)

    def section(self) -> Section | None:
        """The current entry, if it is a section."""
        row = self.currentRow()
        found = self._found[row][1] if 0 <= row < len(self._found) else None
        return found if hasattr(found, "height") else None

    def text(self, rows: list[int] | None = None) -> str:
        """Some entries, or all, as text."""
        chosen = range(len(self._found)) if rows is None else rows
        return "\n\n".join(self._words(k) for k in chosen) + "\n"

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Copy what is chosen."""
        if event.matches(QKeySequence.StandardKey.Copy):
            rows = sorted(self.row(item) for item in self.selectedItems())
            QGuiApplication.clipboard().setText(self.text(rows))
        else:
            super().keyPressEvent(event)

    def _words(self, k: int) -> str:
        title, found = self._found[k]
        write = {"Pick": pick_words, "Distance": distance_words, "Section": section_words}
        return "\n   ".join((title, *write[type(found).__name__](found, self._units)))
