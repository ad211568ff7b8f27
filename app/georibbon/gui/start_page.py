"""The start page: what a person can begin with."""

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCommandLinkButton,
    QGridLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.actions import plain

BEGINNINGS = ("open", "open-folder", "import", "demonstration")


class StartPage(QWidget):
    """Open, import, the demonstration, and what was opened last.

    asked(path): one of the recent ones.
    """

    asked = Signal(Path)

    def __init__(self, actions: dict[str, QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        title = QLabel("Georibbon")
        font = title.font()
        font.setPointSizeF(2.2 * font.pointSizeF())
        title.setFont(font)
        words = QLabel("From what a ribbon of sensors measures to the surface it was laid on.")
        left = QVBoxLayout()
        self.buttons = {}
        for name in BEGINNINGS:
            action = actions[name]
            button = QCommandLinkButton(plain(action.text()), action.statusTip())
            button.setAccessibleName(plain(action.text()))
            button.setIconSize(QSize(24, 24))
            button.clicked.connect(action.trigger)
            action.changed.connect(lambda b=button, a=action: b.setIcon(a.icon()))
            left.addWidget(button)
            self.buttons[name] = button
        left.addStretch()
        self.recent = QListWidget()
        self.recent.setAccessibleName("Opened last")
        self.recent.setSpacing(3)
        self.recent.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.recent.itemActivated.connect(self._ask)
        self.recent.itemClicked.connect(self._ask)
        self._label = QLabel("Opened &last")
        self._label.setBuddy(self.recent)
        right = QVBoxLayout()
        right.addWidget(self._label)
        right.addWidget(self.recent)
        drop = QLabel("Or drop a session or a recording folder anywhere on this window.")
        grid = QGridLayout(self)
        grid.setContentsMargins(48, 32, 48, 32)
        grid.setHorizontalSpacing(32)
        grid.setVerticalSpacing(8)
        grid.addWidget(title, 0, 0, 1, 2)
        grid.addWidget(words, 1, 0, 1, 2)
        grid.setRowMinimumHeight(2, 16)
        grid.addLayout(left, 3, 0)
        grid.addLayout(right, 3, 1)
        grid.addWidget(drop, 4, 0, 1, 2)
        grid.setRowStretch(3, 1)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(1, 1)

    def show_recent(self, paths: Sequence[Path]) -> None:
        """List what was opened last."""
        self.recent.clear()
        for path in paths:
            item = QListWidgetItem(f"{path.name}\n{path.parent}")
            item.setData(Qt.ItemDataRole.UserRole, path)
            item.setToolTip(str(path))
            self.recent.addItem(item)
        if not paths:
            item = QListWidgetItem("Nothing yet: the demonstration is a good beginning.")
            item.setFlags(Qt.ItemFlag.NoItemFlags)
            self.recent.addItem(item)

    def _ask(self, item: QListWidgetItem) -> None:
        path = item.data(Qt.ItemDataRole.UserRole)
        if path is not None:
            self.asked.emit(Path(path))
