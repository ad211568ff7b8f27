"""Questions for files: each gives back plain data, or None where a person thought better."""

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QMessageBox,
    QSpinBox,
    QWidget,
)

from georibbon import __version__
from georibbon.gui.language import N_, tr

SESSIONS = N_("Sessions (*.georibbon)")
PICTURES = N_("Pictures (*.png)")
LARGEST_SCALE = 4


@dataclass(frozen=True)
class Picture:
    """A picture to be saved: how many times as large as on the screen, and whether see-through."""

    path: Path
    scale: int
    transparent: bool


def ask_session(parent: QWidget, folder: Path) -> Path | None:
    """A session file that is there."""
    found, _ = QFileDialog.getOpenFileName(parent, tr("Open session"), str(folder), tr(SESSIONS))
    return Path(found) if found else None


def ask_folder(parent: QWidget, folder: Path, title: str) -> Path | None:
    """A folder that is there."""
    found = QFileDialog.getExistingDirectory(parent, title, str(folder))
    return Path(found) if found else None


def ask_target(parent: QWidget, proposal: Path, title: str, filters: str) -> Path | None:
    """A file to write; it gets the proposal's ending where a person gives none.

    With that ending it is asked for before a file that is there is written over.
    """
    dialog = QFileDialog(parent, title, str(proposal.parent), filters)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setFileMode(QFileDialog.FileMode.AnyFile)
    dialog.setDefaultSuffix(proposal.suffix.removeprefix("."))
    dialog.selectFile(proposal.name)
    try:
        if dialog.exec() != QDialog.DialogCode.Accepted:
            return None
        (found,) = dialog.selectedFiles()
        return Path(found)
    finally:
        dialog.deleteLater()


class PictureDialog(QDialog):
    """How large a picture shall be, and whether its ground is left out."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Save picture"))
        self.scale = QSpinBox()
        self.scale.setRange(1, LARGEST_SCALE)
        self.scale.setSuffix(tr(" times as large as on the screen"))
        self.transparent = QCheckBox(tr("&Transparent ground"))
        buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form = QFormLayout(self)
        form.addRow(tr("&Size"), self.scale)
        form.addRow("", self.transparent)
        form.addRow(buttons)


def ask_picture(parent: QWidget, proposal: Path) -> Picture | None:
    """How a picture shall be saved, and where."""
    dialog = PictureDialog(parent)
    try:
        if dialog.exec() != QDialog.DialogCode.Accepted:
            return None
        path = ask_target(parent, proposal, tr("Save picture"), tr(PICTURES))
        scale, transparent = dialog.scale.value(), dialog.transparent.isChecked()
        return None if path is None else Picture(path, scale, transparent)
    finally:
        dialog.deleteLater()


def show_about(parent: QWidget) -> None:
    """Version and licences."""
    QMessageBox.about(
        parent,
        tr("About Georibbon"),
        tr(
            "<h3>Georibbon {version}</h3><p>From what a ribbon of accelerometers and "
            "magnetometers measures to the surface it was laid on, with its uncertainty.</p>"
            "<p>BSD-3-Clause. <tt>georibbon licences</tt> lists the licences of all that is "
            "shipped; Qt and PySide6 are used under the LGPL.</p>",
            version=__version__,
        ),
    )


def ask_discard(parent: QWidget, sentence: str) -> bool:
    """Whether to let go of what cannot be written."""
    box = QMessageBox(parent)
    box.setIcon(QMessageBox.Icon.Warning)
    box.setWindowTitle(tr("Not everything is written"))
    box.setText(sentence)
    box.setInformativeText(tr("Mend the place and try again, or close without the last changes."))
    stay = box.addButton(tr("Stay open"), QMessageBox.ButtonRole.RejectRole)
    leave = box.addButton(tr("Close without them"), QMessageBox.ButtonRole.DestructiveRole)
    box.setDefaultButton(stay)
    box.exec()
    return box.clickedButton() is leave
