"""Questions for files: each gives back plain data, or None where a person thought better."""

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from georibbon import __version__

SESSIONS = "Sessions (*.georibbon)"
SURFACES = "Surfaces (*.stl *.obj *.ply)"
PICTURES = "Pictures (*.png)"


def ask_session(parent: QWidget, folder: Path) -> Path | None:
    """A session file that is there."""
    found, _ = QFileDialog.getOpenFileName(parent, "Open session", str(folder), SESSIONS)
    return Path(found) if found else None


def ask_folder(parent: QWidget, folder: Path, title: str) -> Path | None:
    """A folder that is there."""
    found = QFileDialog.getExistingDirectory(parent, title, str(folder))
    return Path(found) if found else None


def ask_target(parent: QWidget, proposal: Path, title: str, filters: str) -> Path | None:
    """A file to write; it gets the proposal's ending where a person gives none."""
    found, _ = QFileDialog.getSaveFileName(parent, title, str(proposal), filters)
    if not found:
        return None
    path = Path(found)
    return path if path.suffix else path.with_suffix(proposal.suffix)


def show_about(parent: QWidget) -> None:
    """Version and licences."""
    QMessageBox.about(
        parent,
        "About Georibbon",
        f"<h3>Georibbon {__version__}</h3>"
        "<p>From what a ribbon of accelerometers and magnetometers measures to the surface it was "
        "laid on, with its uncertainty.</p>"
        "<p>BSD-3-Clause. <tt>georibbon licences</tt> lists the licences of all that is shipped; "
        "Qt and PySide6 are used under the LGPL.</p>",
    )


def ask_discard(parent: QWidget, sentence: str) -> bool:
    """Whether to let go of what cannot be written."""
    box = QMessageBox(parent)
    box.setIcon(QMessageBox.Icon.Warning)
    box.setWindowTitle("Not everything is written")
    box.setText(sentence)
    box.setInformativeText("Mend the place and try again, or close without the last changes.")
    stay = box.addButton("Stay open", QMessageBox.ButtonRole.RejectRole)
    leave = box.addButton("Close without them", QMessageBox.ButtonRole.DestructiveRole)
    box.setDefaultButton(stay)
    box.exec()
    return box.clickedButton() is leave
