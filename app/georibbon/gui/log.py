"""The log: everything that was told, with its time, and the line above the view for the newest."""

from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal, Slot
from PySide6.QtGui import QGuiApplication, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QFrame,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QSizePolicy,
    QSplitter,
    QStyle,
    QToolButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui import dialogs
from georibbon.gui.language import N_, tr
from georibbon.gui.notifier import MOST_KEPT, Entry, Level, Notifier

WORDS: dict[Level, str] = {
    "info": N_("information"),
    "warning": N_("warning"),
    "error": N_("error"),
    "fault": N_("fault"),
}
ICONS: dict[Level, QStyle.StandardPixmap] = {
    "info": QStyle.StandardPixmap.SP_MessageBoxInformation,
    "warning": QStyle.StandardPixmap.SP_MessageBoxWarning,
    "error": QStyle.StandardPixmap.SP_MessageBoxCritical,
    "fault": QStyle.StandardPixmap.SP_MessageBoxCritical,
}
LEVELS: tuple[Level, ...] = ("info", "warning", "error", "fault")  # from light to grave
FILTERS = {
    "info": N_("Everything"),
    "warning": N_("Warnings and errors"),
    "error": N_("Errors and faults"),
    "fault": N_("Faults of the program"),
}
TEXTS = "Text (*.txt *.log)"


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
    """A table of what was told, with the details of the chosen line; to filter, copy and save."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._make_table()
        self.details = QPlainTextEdit()
        self.details.setReadOnly(True)
        self.details.setAccessibleName(tr("Details of the chosen line of the log"))
        self.details.setPlaceholderText(tr("Choose a line to read its details"))
        self.level = QComboBox()
        self.level.setAccessibleName(tr("Which kinds of lines are shown"))
        for level, words in FILTERS.items():
            self.level.addItem(tr(words), level)
        self.search = QLineEdit()
        self.search.setPlaceholderText(tr("Find in the log"))
        self.search.setAccessibleName(tr("Find in the log"))
        self.search.setClearButtonEnabled(True)
        self.copy_button = QPushButton(tr("Copy"))
        self.copy_button.setToolTip(tr("Copy the chosen lines, or all, with their details"))
        self.save_button = QPushButton(tr("Save…"))
        self.save_button.setToolTip(tr("Save the chosen lines, or all, with their details"))
        self.told = QLabel()
        self._lay_out()
        self.copy_button.clicked.connect(self.copy)
        self.save_button.clicked.connect(self.ask_save)
        self.level.currentIndexChanged.connect(self._filter)
        self.search.textChanged.connect(self._filter)
        self.table.itemSelectionChanged.connect(self._show_details)

    @Slot(object)
    def add(self, entry: Entry) -> None:
        """Add a line, and show it where the end was seen."""
        bar = self.table.verticalScrollBar()
        at_end = bar.value() == bar.maximum()
        time = entry.time.strftime("%H:%M:%S")
        item = QTreeWidgetItem([time, tr(WORDS[entry.level]), entry.text])
        item.setIcon(1, self.style().standardIcon(ICONS[entry.level]))
        item.setToolTip(0, entry.time.isoformat(sep=" ", timespec="milliseconds"))
        item.setToolTip(2, entry.text)
        item.setData(0, Qt.ItemDataRole.UserRole, entry)
        self.table.addTopLevelItem(item)
        item.setHidden(not self._fits(entry))
        if self.table.topLevelItemCount() > MOST_KEPT:
            self.table.takeTopLevelItem(0)
        if at_end:
            self.table.scrollToItem(item)

    def keyPressEvent(self, event) -> None:
        """Ctrl+C copies, Ctrl+F finds."""
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy()
        elif event.matches(QKeySequence.StandardKey.Find):
            self.search.setFocus()
            self.search.selectAll()
        else:
            super().keyPressEvent(event)

    @property
    def shown(self) -> list[Entry]:
        """The entries that pass the filter."""
        return [_entry(item) for item in self._items() if not item.isHidden()]

    def copy(self) -> None:
        """Put the chosen lines, or all that are shown, with their details on the clipboard."""
        QGuiApplication.clipboard().setText(self._text())
        self.told.setText(tr("Copied."))

    def ask_save(self) -> None:
        """Write the chosen lines, or all that are shown, into a file that a person chooses."""
        proposal = Path.home() / "georibbon-log.txt"
        target = dialogs.ask_target(self, proposal, tr("Save the log"), TEXTS)
        if target is None:
            return
        try:
            target.write_text(self._text() + "\n", encoding="utf-8")
        except OSError as error:
            self.told.setText(tr("{path}: {why}", path=target, why=error.strerror or str(error)))
        else:
            self.told.setText(tr("Written: {path}", path=target))

    def _make_table(self) -> None:
        self.table = QTreeWidget()
        self.table.setAccessibleName(tr("Log"))
        self.table.setHeaderLabels([tr("Time"), tr("Kind"), tr("What")])
        self.table.setRootIsDecorated(False)
        self.table.setUniformRowHeights(True)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setTextElideMode(Qt.TextElideMode.ElideRight)

    def _lay_out(self) -> None:
        splitter = QSplitter(Qt.Orientation.Horizontal)
        splitter.addWidget(self.table)
        splitter.addWidget(self.details)
        splitter.setStretchFactor(0, 2)
        splitter.setStretchFactor(1, 1)
        row = QHBoxLayout()
        row.addWidget(self.level)
        row.addWidget(self.search, 1)
        row.addWidget(self.told)
        row.addWidget(self.copy_button)
        row.addWidget(self.save_button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addLayout(row)
        layout.addWidget(splitter)

    def _items(self) -> list[QTreeWidgetItem]:
        return [self.table.topLevelItem(i) for i in range(self.table.topLevelItemCount())]

    def _fits(self, entry: Entry) -> bool:
        """Whether an entry is grave enough and has every word that is looked for."""
        if LEVELS.index(entry.level) < LEVELS.index(self.level.currentData()):
            return False
        told = f"{entry.text} {entry.detail}".lower()
        return all(word in told for word in self.search.text().lower().split())

    def _filter(self, *_: object) -> None:
        for item in self._items():
            item.setHidden(not self._fits(_entry(item)))
        current = self.table.currentItem()
        if current is not None and not current.isHidden():
            self.table.scrollToItem(current)

    def _text(self) -> str:
        seen = [item for item in self._items() if not item.isHidden()]
        entries = [_entry(item) for item in seen if item.isSelected()] or list(map(_entry, seen))
        return "\n".join(map(plain_line, entries))

    def _show_details(self) -> None:
        chosen = [_entry(item) for item in self.table.selectedItems()]
        self.details.setPlainText("\n\n".join(one.detail or one.text for one in chosen))


def _entry(item: QTreeWidgetItem) -> Entry:
    return item.data(0, Qt.ItemDataRole.UserRole)


def plain_line(entry: Entry, detail: bool = True) -> str:
    """An entry as text: its time, its kind in English, its words, and below them its details."""
    below = f"\n{entry.detail.rstrip()}" if entry.detail and detail else ""
    return f"{entry.time.isoformat(timespec='seconds')} {entry.level}: {entry.text}{below}"


class Banner(QFrame):
    """One line above the view with what went wrong last; it goes with the next success."""

    details_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAccessibleName(tr("What went wrong"))
        self._icon, self.text = QLabel(), QLabel()
        self.text.setWordWrap(True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        self.text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        # A name without end is cut off and not let widen the window.
        self.text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        log = QPushButton(tr("Show in log"))
        log.clicked.connect(self.details_asked)
        close = QToolButton()
        close.setIcon(self.style().standardIcon(QStyle.StandardPixmap.SP_TitleBarCloseButton))
        close.setAccessibleName(tr("Hide this message"))
        close.setToolTip(tr("Hide this message"))
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
        self._icon.setAccessibleName(tr(WORDS[entry.level]))
        self.text.setText(entry.text[:1].upper() + entry.text[1:])
        self.text.setToolTip(entry.text)
        self.show()
