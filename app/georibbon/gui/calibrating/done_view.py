"""A calibration that is made: how good it is, what has changed, its name, and where it goes."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QGroupBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.calibration.change import Difference
from georibbon.gui.calibrating.quality import QualityPanel
from georibbon.gui.calibrating.words import told_words
from georibbon.gui.language import N_, tr

COLUMNS = (
    N_("Sensor"), N_("Change"), N_("Tilt"), N_("Heading"), N_("Bias, hard iron"), N_("Scale"),
)  # fmt: skip


class DoneView(QWidget):
    """Keep, name, export, use, or back to the poses.

    keep(name), export(), use(), back().
    """

    keep = Signal(str)
    export = Signal()
    use = Signal()
    back = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.title = QLabel(tr("The calibration is made"))
        font = self.title.font()
        font.setPointSizeF(1.5 * font.pointSizeF())
        font.setBold(True)
        self.title.setFont(font)
        self.quality = QualityPanel()
        self.quality.progress.hide()
        self.name = QLineEdit()
        self.name.setMaxLength(120)
        self.name_label = QLabel(tr("&Name"))
        self.name_label.setBuddy(self.name)
        self.keep_button = QPushButton(tr("&Keep it"))
        self.use_button = QPushButton(tr("Capture &with it"))
        self.export_button = QPushButton(tr("&Export…"))
        self.back_button = QPushButton(tr("&Back to the poses"))
        self.told = QLabel()
        self.told.setWordWrap(True)
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.since = QLabel()
        self.words = QLabel()
        for label in (self.since, self.words):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.table = QTableWidget(0, len(COLUMNS))
        self.table.setHorizontalHeaderLabels([tr(one) for one in COLUMNS])
        self.table.setAccessibleName(tr("What has changed, by sensor"))
        self.table.verticalHeader().hide()
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setTabKeyNavigation(False)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self._lay_out()
        self.keep_button.clicked.connect(lambda: self.keep.emit(self.name.text()))
        self.name.returnPressed.connect(lambda: self.keep.emit(self.name.text()))
        self.export_button.clicked.connect(self.export)
        self.use_button.clicked.connect(self.use)
        self.back_button.clicked.connect(self.back)

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.addWidget(self.name_label)
        row.addWidget(self.name, 1)
        row.addWidget(self.keep_button)
        buttons = QHBoxLayout()
        for one in (self.use_button, self.export_button, self.back_button):
            buttons.addWidget(one)
        buttons.addStretch()
        left = QGroupBox(tr("How good it is"))
        box = QVBoxLayout(left)
        box.addWidget(self.quality)
        right = QGroupBox(tr("What has changed"))
        box = QVBoxLayout(right)
        box.addWidget(self.since)
        box.addWidget(self.words)
        box.addWidget(self.table, 1)
        box.addStretch()
        middle = QHBoxLayout()
        middle.addWidget(left, 2)
        middle.addWidget(right, 3)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.title)
        layout.addLayout(row)
        layout.addWidget(self.told)
        layout.addLayout(middle, 1)
        layout.addLayout(buttons)

    def show_name(self, name: str) -> None:
        """Propose a name; it is not kept yet."""
        self.name.setText(name)
        self.name.selectAll()
        self.keep_button.setText(tr("&Keep it"))
        self.tell(tr("It is not kept yet: give it a name and keep it."))

    def show_kept(self, words: str) -> None:
        """It is kept."""
        self.keep_button.setText(tr("&Keep under this name too"))
        self.tell(words)

    def tell(self, words: str) -> None:
        """Tell something."""
        self.told.setText(words)

    def show_change(self, since: str, found: Difference | None) -> None:
        """Show what has changed since the last one; None: there is none to compare with."""
        self.since.setText(since)
        self.words.setText("" if found is None else told_words(found.words))
        self.table.setVisible(found is not None)
        changes = (
            [] if found is None else [one for one in found.sensors if one.degrees == one.degrees]
        )
        changes.sort(key=lambda one: -one.degrees)
        self.table.setRowCount(len(changes))
        for row, one in enumerate(changes):
            self._fill(row, one)

    def _fill(self, row: int, one) -> None:
        unit = tr("mg") if one.kind == "accelerometer" else tr("% of the field")
        texts = (
            one.name,
            tr("{value}°", value=f"{one.degrees:.2f}"),
            tr("{value}°", value=f"{one.tilt:.2f}"),
            tr("{value}°", value=f"{one.heading:.2f}"),
            f"{one.bias:.1f} {unit}",
            tr("{value} %", value=f"{round(one.scale, 2) + 0.0:+.2f}"),
        )
        for column, text in enumerate(texts):
            item = QTableWidgetItem(text)
            if one.stands_out:
                bold = item.font()
                bold.setBold(True)
                item.setFont(bold)
            self.table.setItem(row, column, item)
