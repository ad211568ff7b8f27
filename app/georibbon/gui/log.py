"""The log: everything that was told, with its time, and the line above the view for the newest."""

from PySide6.QtCore import QObject, Qt, Signal, Slot
from PySide6.QtGui import QGuiApplication, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFrame,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QSplitter,
    QStyle,
    QToolButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.notifier import Entry, Level, Notifier

WORDS: dict[Level, str] = {
    "info": "information",
    "warning": "warning",
    "error": "error",
    "fault": "fault",
}
ICONS: dict[Level, QStyle.StandardPixmap] = {
    "info": QStyle.StandardPixmap.SP_MessageBoxInformation,
    "warning": QStyle.StandardPixmap.SP_MessageBoxWarning,
    "error": QStyle.StandardPixmap.SP_MessageBoxCritical,
    "fault": QStyle.StandardPixmap.SP_MessageBoxCritical,
}


class Bell(QObject):
    """Brings what the notifier tells, on whatever thread, to the main one."""

    rang = Signal(object)

    def __init__(self, notifier: Notifier, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._notifier = notifier
        notifier.listen(self.rang.emit)

    def end(self) -> None:
        """Listen no more."""
        self._notifier.leave(self.rang.emit)


class LogPanel(QWidget):
    """A table of what was told, with the details of the chosen line, to copy."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.table = QTreeWidget()
        self.table.setAccessibleName("Log")
        self.table.setHeaderLabels(["Time", "Kind", "What"])
        self.table.setRootIsDecorated(False)
        self.table.setUniformRowHeights(True)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.details = QPlainTextEdit()
        self.details.setReadOnly(True)
        self.details.setAccessibleName("Details of the chosen line of the log")
        self.details.setPlaceholderText("Choose a line to read its details")
        self.copy_button = QPushButton("Copy")
        self.copy_button.setToolTip("Copy the chosen lines, or all, with their details")
        self.copy_button.clicked.connect(self.copy)
        splitter = QSplitter(Qt.Orientation.Horizontal)
        splitter.addWidget(self.table)
        splitter.addWidget(self.details)
        splitter.setStretchFactor(0, 2)
        splitter.setStretchFactor(1, 1)
        row = QHBoxLayout()
        row.addStretch()
        row.addWidget(self.copy_button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(splitter)
        layout.addLayout(row)
        self.table.itemSelectionChanged.connect(self._show_details)

    @Slot(object)
    def add(self, entry: Entry) -> None:
        """Add a line, and show it where the end was seen."""
        bar = self.table.verticalScrollBar()
        at_end = bar.value() == bar.maximum()
        time = entry.time.strftime("%H:%M:%S")
        item = QTreeWidgetItem([time, WORDS[entry.level], entry.text])
        item.setIcon(1, self.style().standardIcon(ICONS[entry.level]))
        item.setToolTip(2, entry.text)
        item.setData(0, Qt.ItemDataRole.UserRole, entry)
        self.table.addTopLevelItem(item)
        if at_end:
            self.table.scrollToItem(item)

    def keyPressEvent(self, event) -> None:
        """Ctrl+C copies."""
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy()
        else:
            super().keyPressEvent(event)

    def copy(self) -> None:
        """Put the chosen lines, or all, with their details on the clipboard."""
        every = [self.table.topLevelItem(i) for i in range(self.table.topLevelItemCount())]
        entries = [_entry(item) for item in every if item.isSelected()] or list(map(_entry, every))
        QGuiApplication.clipboard().setText("\n".join(map(_plain, entries)))

    def _show_details(self) -> None:
        chosen = [_entry(item) for item in self.table.selectedItems()]
        self.details.setPlainText("\n\n".join(one.detail or one.text for one in chosen))


def _entry(item: QTreeWidgetItem) -> Entry:
    return item.data(0, Qt.ItemDataRole.UserRole)


def _plain(entry: Entry) -> str:
    detail = f"\n{entry.detail.rstrip()}" if entry.detail else ""
    return f"{entry.time.isoformat(timespec='seconds')} {entry.level}: {entry.text}{detail}"


class Banner(QFrame):
    """One line above the view with what went wrong last; it goes with the next success."""

    details_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAccessibleName("What went wrong")
        self._icon, self.text = QLabel(), QLabel()
        self.text.setWordWrap(True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        self.text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        log = QPushButton("Show in log")
        log.clicked.connect(self.details_asked)
        close = QToolButton()
        close.setIcon(self.style().standardIcon(QStyle.StandardPixmap.SP_TitleBarCloseButton))
        close.setAccessibleName("Hide this message")
        close.setToolTip("Hide this message")
        close.setAutoRaise(True)
        close.clicked.connect(self.hide)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 4, 4)
        row.addWidget(self._icon)
        row.addWidget(self.text, 1)
        row.addWidget(log)
        row.addWidget(close)
        self.hide()

    def show_entry(self, entry: Entry) -> None:
        """Show an entry, the newest alone."""
        size = self.style().pixelMetric(QStyle.PixelMetric.PM_SmallIconSize)
        self._icon.setPixmap(self.style().standardIcon(ICONS[entry.level]).pixmap(size, size))
        self._icon.setAccessibleName(WORDS[entry.level])
        self.text.setText(entry.text[:1].upper() + entry.text[1:])
        self.show()
