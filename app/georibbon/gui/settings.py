"""What the window remembers: tolerant of everything, so that no bad entry stops the start."""

from pathlib import Path

from PySide6.QtCore import QByteArray, QSettings

MOST_RECENT = 10
VERSION = 1  # of the layout: an older one is not taken up


class Settings:
    """Theme, recent files and layout, in a file of the user's."""

    def __init__(self, path: Path | None = None) -> None:
        ini = QSettings.Format.IniFormat
        if path is None:
            self._kept = QSettings(ini, QSettings.Scope.UserScope, "Georibbon", "Georibbon")
        else:
            self._kept = QSettings(str(path), ini)

    @property
    def theme(self) -> str:
        """light or dark."""
        return "dark" if self._kept.value("theme") == "dark" else "light"

    @theme.setter
    def theme(self, theme: str) -> None:
        self._kept.setValue("theme", theme)

    @property
    def recent(self) -> list[Path]:
        """What was opened last and still exists, the newest first."""
        found = self._kept.value("recent")
        texts = [found] if isinstance(found, str) else found if isinstance(found, list) else []
        paths = [Path(text) for text in texts if isinstance(text, str) and text]
        return [path for path in paths if _exists(path)][:MOST_RECENT]

    def opened(self, path: Path) -> None:
        """Put a path at the head of the recent ones."""
        path = path.absolute()
        paths = [path, *(one for one in self.recent if one != path)][:MOST_RECENT]
        self._kept.setValue("recent", [str(one) for one in paths])

    def forget_recent(self) -> None:
        """Forget what was opened."""
        self._kept.remove("recent")

    def layout(self) -> tuple[QByteArray, QByteArray] | None:
        """The window's geometry and state; None where there is none of this version."""
        geometry, state = self._kept.value("geometry"), self._kept.value("state")
        if str(self._kept.value("layout")) != str(VERSION):
            return None
        if isinstance(geometry, QByteArray) and isinstance(state, QByteArray):
            return geometry, state
        return None

    def keep_layout(self, geometry: QByteArray, state: QByteArray) -> None:
        """Keep the window's geometry and state."""
        for key, value in (("layout", VERSION), ("geometry", geometry), ("state", state)):
            self._kept.setValue(key, value)

    def save(self) -> None:
        """Write all to the file."""
        self._kept.sync()


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False
