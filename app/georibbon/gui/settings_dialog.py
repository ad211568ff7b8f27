"""The settings a person chooses: applied at once, kept, and shown as they are."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui import dialogs
from georibbon.gui.language import LANGUAGES, N_, tr
from georibbon.gui.parts import Parts
from georibbon.gui.theme import apply_theme

THEME_WORDS = {"light": N_("Light"), "dark": N_("Dark")}
UNIT_WORDS = {"mm": N_("Millimetres (mm)"), "cm": N_("Centimetres (cm)"), "in": N_("Inches (in)")}


@dataclass(frozen=True)
class Chosen:
    """What stands in the dialog, as plain data."""

    theme: str
    unit: str
    language: str
    sound: bool
    folder: Path | None


class SettingsDialog(QDialog):
    """Colours, unit, language, sound and folder.

    Everything is applied as it is chosen.  theme_chosen(theme): the window
    draws its icons anew.
    """

    theme_chosen = Signal(str)

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts = parts
        self._at_start = parts.settings.language
        self.setWindowTitle(tr("Settings"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.theme = _choice(THEME_WORDS, self._take_theme)
        self.unit = _choice(UNIT_WORDS, self._take_unit)
        self.language = _choice(LANGUAGES, self._take_language)
        self.language_told = QLabel()
        self.language_told.setWordWrap(True)
        self.sound = QCheckBox(tr("Tell by &sound what was taken"))
        self.sound.toggled.connect(self._take_sound)
        self.folder = QLineEdit()
        self.folder.setReadOnly(True)
        self.folder.setPlaceholderText(tr("Where files were last"))
        self.choose = QPushButton(tr("C&hoose…"))
        self.choose.clicked.connect(self._ask_folder)
        self.clear = QPushButton(tr("Clea&r"))
        self.clear.clicked.connect(lambda: self._take_folder(None))
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.RestoreDefaults | QDialogButtonBox.StandardButton.Close
        )
        self._lay_out()
        self._show()
        parts.units.changed.connect(self._show)

    @property
    def chosen(self) -> Chosen:
        """What stands in it."""
        return Chosen(
            self.theme.currentData(),
            self.unit.currentData(),
            self.language.currentData(),
            self.sound.isChecked(),
            self._parts.settings.folder,
        )

    def reset(self) -> None:
        """All as at first; what was opened and where panels are stays."""
        settings = self._parts.settings
        for name in ("theme", "unit", "language", "sound", "folder"):
            settings.forget(name)
        self._parts.units.use(settings.unit)
        self._apply_theme(settings.theme)
        self._show()

    def _lay_out(self) -> None:
        place = QHBoxLayout()
        place.addWidget(self.folder, 1)
        place.addWidget(self.choose)
        place.addWidget(self.clear)
        form = QFormLayout()
        form.addRow(tr("&Colours"), self.theme)
        form.addRow(tr("&Lengths"), self.unit)
        form.addRow(tr("L&anguage"), self.language)
        form.addRow("", self.language_told)
        form.addRow("", self.sound)
        form.addRow(tr("&Folder for files"), place)
        label = form.labelForField(place)
        label.setBuddy(self.folder)
        self.folder.setAccessibleName(tr("Folder for files"))
        restore = self.buttons.button(QDialogButtonBox.StandardButton.RestoreDefaults)
        restore.setText(tr("All as at firs&t"))
        restore.clicked.connect(self.reset)
        close = self.buttons.button(QDialogButtonBox.StandardButton.Close)
        close.setText(tr("Cl&ose"))
        close.setIcon(QIcon())  # the platform's is of no theme
        restore.setIcon(QIcon())
        for button in (self.choose, self.clear, restore):
            button.setAutoDefault(False)
        close.setDefault(True)
        self.buttons.rejected.connect(self.reject)
        whole = QVBoxLayout(self)
        whole.addLayout(form)
        whole.addStretch()
        whole.addWidget(self.buttons)
        self.resize(520, 0)

    def _show(self) -> None:
        """As it is kept."""
        settings = self._parts.settings
        for box, value in (
            (self.theme, settings.theme),
            (self.unit, self._parts.units.symbol),
            (self.language, settings.language),
        ):
            with QSignalBlocker(box):
                box.setCurrentIndex(box.findData(value))
        with QSignalBlocker(self.sound):
            self.sound.setChecked(settings.sound)
        self.folder.setText("" if settings.folder is None else str(settings.folder))
        self.clear.setEnabled(settings.folder is not None)
        self._tell_language()

    def _tell_language(self) -> None:
        other = self._parts.settings.language != self._at_start
        self.language_told.setText(
            tr("The language changes with the next start of the program.") if other else ""
        )

    def _take_theme(self, theme: str) -> None:
        self._parts.settings.theme = theme
        self._apply_theme(theme)

    def _apply_theme(self, theme: str) -> None:
        apply_theme(QApplication.instance(), theme)
        self.theme_chosen.emit(theme)

    def _take_unit(self, symbol: str) -> None:
        self._parts.settings.unit = symbol
        self._parts.units.use(symbol)

    def _take_language(self, language: str) -> None:
        self._parts.settings.language = language
        self._tell_language()

    def _take_sound(self, on: bool) -> None:
        self._parts.settings.sound = on

    def _take_folder(self, folder: Path | None) -> None:
        self._parts.settings.folder = folder
        self._show()

    def _ask_folder(self) -> None:
        now = self._parts.settings.folder or Path.home()
        found = dialogs.ask_folder(self, now, tr("Folder for files"))
        if found is not None:
            self._take_folder(found)


def _choice(words: Mapping[str, str], take: Callable[[str], None]) -> QComboBox:
    """A box of words, each with its value."""
    box = QComboBox()
    for value, text in words.items():
        box.addItem(tr(text), value)
    box.currentIndexChanged.connect(lambda index: take(box.itemData(index)))
    return box
