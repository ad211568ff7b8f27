"""What a person opens, imports and saves: the questions for files, and what follows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QStandardPaths
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QMainWindow

from georibbon.errors import GeoribbonError
from georibbon.gui import dialogs
from georibbon.gui.language import tr
from georibbon.gui.parts import Parts


class Files:
    """The verbs of the menu of files.

    view_image(scale, transparent): a picture of what the view shows.
    """

    def __init__(
        self, window: QMainWindow, parts: Parts, view_image: Callable[[int, bool], QImage]
    ) -> None:
        self._window, self._parts, self._view_image = window, parts, view_image
        self._document = parts.document

    def open(self, path: Path) -> None:
        """Open a session or a recording folder; not while a capture goes on."""
        if self._free():
            self._document.open(path)

    def _free(self) -> bool:
        """Whether no capture goes on, which a file that is dropped must not end."""
        capture = self._parts.capture
        busy = capture.active or capture.beginning
        if busy:
            self._parts.notifier.tell(
                "error", tr("a capture goes on; finish it before you open something else")
            )
        return not busy

    def ask_session(self) -> None:
        """Open a session that a person chooses."""
        if not self._free():
            return
        path = dialogs.ask_session(self._window, self.folder())
        if path is not None:
            self.open(path)

    def ask_folder(self) -> None:
        """Open a recording folder that a person chooses."""
        if not self._free():
            return
        path = dialogs.ask_folder(self._window, self.folder(), tr("Open recording folder"))
        if path is not None:
            self.open(path)

    def ask_import(self) -> None:
        """Import a recording folder that a person chooses into a session file to be chosen too."""
        if not self._free():
            return
        folder = dialogs.ask_folder(self._window, self.folder(), tr("Import recording folder"))
        if folder is None:
            return
        proposal = folder.with_name(f"{folder.name}.georibbon")
        target = dialogs.ask_target(
            self._window, proposal, tr("Import into session"), tr(dialogs.SESSIONS)
        )
        if target is not None:
            self._document.import_folder(folder, target)

    def open_demonstration(self) -> None:
        """Open the virtual capture of a car bonnet."""
        if not self._free():
            return
        place = QStandardPaths.StandardLocation.AppLocalDataLocation
        self._document.open_demonstration(Path(QStandardPaths.writableLocation(place)))

    def save_picture(self) -> None:
        """Save what the view shows into a file that a person chooses."""
        from georibbon.export.files import PICTURE_ENDINGS, require_ending, write_whole

        name = self._document.path.stem if self._document.path else "georibbon"
        wanted = dialogs.ask_picture(self._window, self.folder() / f"{name}.png")
        if wanted is None:
            return
        try:
            require_ending(wanted.path, PICTURE_ENDINGS, "a picture")
            image = self._view_image(wanted.scale, wanted.transparent)
            write_whole(wanted.path, _png(image))
        except (GeoribbonError, OSError) as error:
            self._parts.notifier.tell("error", str(error))
        else:
            words = tr("written: {path}", path=wanted.path)
            self._parts.notifier.tell("info", words)
            self._window.statusBar().showMessage(words, 8000)

    def folder(self) -> Path:
        """Where a person looked last, or wants to look first."""
        settings = self._parts.settings
        path = self._document.path or next(iter(settings.recent), None)
        return settings.folder or (Path.home() if path is None else path.parent)


def calibrations_folder() -> Path:
    """Where calibrations are kept."""
    place = QStandardPaths.StandardLocation.AppLocalDataLocation
    return Path(QStandardPaths.writableLocation(place)) / "calibrations"


def _png(image: QImage) -> bytes:
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    image.save(buffer, "PNG")
    buffer.close()
    return bytes(data.data())
