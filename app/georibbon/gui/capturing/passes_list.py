"""The list of what is captured: state and quality of each, its order changed by drag or by keys."""

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QRectF, Qt, Signal
from PySide6.QtGui import QDropEvent, QFont, QIcon, QKeyEvent, QPainter, QPixmap
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from georibbon.gui.calibrating.signs import paint_sign
from georibbon.gui.capturing.model import Row
from georibbon.gui.capturing.words import KIND, STATUS, VERDICT
from georibbon.gui.language import sentence, tr
from georibbon.gui.theme import colours_of

NAME, STATE, QUALITY = range(3)
SIGN = {"good": "good", "acceptable": "fair", "redo": "bad"}
SIZE = 20


class PassesList(QTreeWidget):
    """One line a pass; the one that is asked for has an arrow and is bold.

    reordered(keys): a person dragged a line, or moved it by Alt and an arrow.
    asked(key): a line was double-clicked, or Return was pressed on it.
    deleted(key): Delete was pressed.
    """

    reordered = Signal(list)
    asked = Signal(str)
    deleted = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setHeaderLabels([tr("Pass"), tr("State"), tr("Quality")])
        self.setAccessibleName(tr("Passes and ties"))
        self.setRootIsDecorated(False)
        self.setUniformRowHeights(True)
        self.setAllColumnsShowFocus(True)
        self.setDragDropMode(QAbstractItemView.DragDropMode.InternalMove)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        header = self.header()
        header.setStretchLastSection(True)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.itemActivated.connect(lambda item, _column: self.asked.emit(_key(item)))
        self._rows: tuple[Row, ...] = ()

    @property
    def keys(self) -> list[str]:
        """What the lines are about, in their order."""
        return [_key(self.topLevelItem(k)) for k in range(self.topLevelItemCount())]

    @property
    def chosen(self) -> str | None:
        """The selected line's key."""
        items = self.selectedItems()
        return _key(items[0]) if items else None

    def choose(self, key: str) -> None:
        """Select a line."""
        for k in range(self.topLevelItemCount()):
            if _key(self.topLevelItem(k)) == key:
                self.setCurrentItem(self.topLevelItem(k))

    def show_rows(self, rows: Sequence[Row]) -> None:
        """Show these lines; the selection stays on the same pass."""
        if tuple(rows) == self._rows:
            return
        chosen = self.chosen
        if [row.key for row in rows] != self.keys:
            self.clear()
            self.addTopLevelItems([QTreeWidgetItem() for _ in rows])
        self._rows = tuple(rows)
        for k, row in enumerate(rows):
            self._fill(self.topLevelItem(k), row)
            if row.key == chosen:
                self.setCurrentItem(self.topLevelItem(k))

    def changeEvent(self, event: QEvent) -> None:
        """The signs follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and getattr(self, "_rows", ()):
            for k, row in enumerate(self._rows):
                self._fill(self.topLevelItem(k), row)

    def _fill(self, item: QTreeWidgetItem, row: Row) -> None:
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        if row.kind != "pose":
            flags |= Qt.ItemFlag.ItemIsDragEnabled
        item.setFlags(flags)
        item.setData(NAME, Qt.ItemDataRole.UserRole, row.key)
        item.setText(NAME, f"▶ {row.key}" if row.current else row.key)
        status = tr("asked for") if row.current and row.status == "open" else tr(STATUS[row.status])
        item.setText(STATE, status)
        quality = row.quality if row.status == "taken" else None
        if quality is None:
            item.setText(QUALITY, "")
            item.setIcon(QUALITY, QIcon())
        else:
            words = tr(VERDICT[quality.verdict])
            item.setText(QUALITY, words if quality.final else tr("{words}, alone", words=words))
            item.setIcon(QUALITY, self._icon(SIGN[quality.verdict]))
        tip = sentence(row.words if quality is None else quality.reason)
        for column in (NAME, STATE, QUALITY):
            item.setToolTip(column, tip)
            font = QFont(self.font())
            font.setBold(row.current)
            item.setFont(column, font)
        said = f"{tr(KIND[row.kind])} {row.key}, {status}, {item.text(QUALITY)}"
        item.setData(NAME, Qt.ItemDataRole.AccessibleTextRole, said)

    def _icon(self, state: str) -> QIcon:
        picture = QPixmap(SIZE, SIZE)
        picture.fill(Qt.GlobalColor.transparent)
        with QPainter(picture) as painter:
            paint_sign(painter, QRectF(1, 1, SIZE - 2, SIZE - 2), state, colours_of(self.palette()))
        return QIcon(picture)

    def move(self, by: int) -> None:
        """Move the selected line up (-1) or down (+1)."""
        keys, chosen = self.keys, self.chosen
        if chosen is None:
            return
        k = keys.index(chosen)
        if 0 <= k + by < len(keys):
            keys[k], keys[k + by] = keys[k + by], keys[k]
            self.reordered.emit(keys)

    def dropEvent(self, event: QDropEvent) -> None:
        """A line was dragged between others."""
        before = self.keys
        super().dropEvent(event)
        self.dropped(before)

    def dropped(self, before: list[str]) -> None:
        """The lines have changed their places since they stood as `before`."""
        after = self.keys
        self._rows = ()  # they are filled anew, wherever they are by now
        if after != before and sorted(after) == sorted(before):
            self.reordered.emit(after)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Alt and an arrow move the line, Return asks for it, Delete takes it out."""
        alt = event.modifiers() == Qt.KeyboardModifier.AltModifier
        key, chosen = event.key(), self.chosen
        if alt and key in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self.move(-1 if key == Qt.Key.Key_Up else 1)
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and chosen is not None:
            self.asked.emit(chosen)
        elif key == Qt.Key.Key_Delete and chosen is not None:
            self.deleted.emit(chosen)
        elif key in (Qt.Key.Key_Space, Qt.Key.Key_PageDown):
            event.ignore()  # they take what is asked for
        else:
            super().keyPressEvent(event)


def _key(item: QTreeWidgetItem) -> str:
    return item.data(NAME, Qt.ItemDataRole.UserRole)
