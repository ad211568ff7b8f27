"""What the window remembers: tolerant of everything, so that no bad entry stops the start."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from PySide6.QtCore import QByteArray, QSettings

from georibbon.gui.language import LANGUAGES, tr
from georibbon.gui.units import UNITS

if TYPE_CHECKING:
    from georibbon.gui.notifier import Notifier

MOST_RECENT = 10
VERSION = 1  # of the file; an entry whose meaning changes gets another name
LAYOUT_VERSION = 2  # an older layout is not taken up
LARGEST_FILE = 4_000_000  # bytes; ours has some thousands
THEMES = ("light", "dark")

T = TypeVar("T", bool, int, float, str, list[str], QByteArray)


class Settings:
    """Theme, language, unit, recent files and layout, in a file of the user's.

    path: in the place of the user's own.  notifier: told once where the file
    is broken, and once where it cannot be written.
    """

    def __init__(self, path: Path | None = None, notifier: "Notifier | None" = None) -> None:
        self._notifier = notifier
        self._told: set[str] = set()
        if path is None:
            path = _place()
        self._set_aside(path)
        self._kept = QSettings(str(path), QSettings.Format.IniFormat)
        if self._kept.status() == QSettings.Status.FormatError:
            self._tell(
                tr("the settings in {path} are damaged; what cannot be read is as at first",
                   path=path)
            )  # fmt: skip

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self._kept.fileName())

    def get(self, name: str, default: T) -> T:
        """An entry of the default's type; the default where there is none, or a bad one.

        name: with its part before a slash, as "capture/sound".
        """
        try:
            value = _read(self._kept.value(name), default)
        except (ValueError, TypeError, RecursionError, OverflowError):
            value = None
        return default if value is None else value

    def put(self, name: str, value: T) -> None:
        """Keep an entry: a bool, an int, a float, a str, a list of str or a QByteArray."""
        if isinstance(value, bool):
            value = "true" if value else "false"
        elif isinstance(value, int | float):
            value = repr(value)
        elif isinstance(value, list):
            value = json.dumps(value)
        self._kept.setValue(name, value)

    def forget(self, name: str) -> None:
        """Drop an entry; it is its default again."""
        self._kept.remove(name)

    @property
    def theme(self) -> str:
        """light or dark."""
        return _one_of(THEMES, self.get("theme", "light"))

    @theme.setter
    def theme(self, theme: str) -> None:
        self.put("theme", theme)

    @property
    def unit(self) -> str:
        """The symbol of the unit of lengths: mm, cm or in."""
        return _one_of(tuple(UNITS), self.get("unit", "mm"))

    @unit.setter
    def unit(self, symbol: str) -> None:
        self.put("unit", symbol)

    @property
    def language(self) -> str:
        """en or fr; the system's until a person chooses."""
        return _one_of(tuple(LANGUAGES), self.get("language", "") or _system_language())

    @language.setter
    def language(self, language: str) -> None:
        self.put("language", language)

    @property
    def sound(self) -> bool:
        """Whether a capture tells by sound what was taken."""
        return self.get("sound", True)

    @sound.setter
    def sound(self, sound: bool) -> None:
        self.put("sound", sound)

    @property
    def folder(self) -> Path | None:
        """Where files are looked for and put at first; None: where one was last."""
        text = self.get("folder", "")
        return Path(text) if text and _exists(Path(text)) else None

    @folder.setter
    def folder(self, folder: Path | None) -> None:
        self.put("folder", "" if folder is None else str(folder))

    @property
    def recent(self) -> list[Path]:
        """What was opened last and still exists, the newest first."""
        paths = [Path(text) for text in self.get("recent", list[str]()) if text]
        return [path for path in paths if _exists(path)][:MOST_RECENT]

    def opened(self, path: Path) -> None:
        """Put a path at the head of the recent ones."""
        path = path.absolute()
        paths = [path, *(one for one in self.recent if one != path)][:MOST_RECENT]
        self.put("recent", [str(one) for one in paths])

    def forget_recent(self) -> None:
        """Forget what was opened."""
        self.forget("recent")

    def layout(self) -> tuple[QByteArray, QByteArray] | None:
        """The window's geometry and state; None where there is none of this version."""
        if self.get("layout", 0) != LAYOUT_VERSION:
            return None
        geometry, state = self.get("geometry", QByteArray()), self.get("state", QByteArray())
        return None if geometry.isEmpty() or state.isEmpty() else (geometry, state)

    def keep_layout(self, geometry: QByteArray, state: QByteArray) -> None:
        """Keep the window's geometry and state."""
        self.put("layout", LAYOUT_VERSION)
        self.put("geometry", geometry)
        self.put("state", state)

    def save(self) -> None:
        """Write all to the file; what cannot be written is told, and lasts until the end."""
        self.put("version", VERSION)
        self._kept.sync()
        if self._kept.status() == QSettings.Status.AccessError:
            self._tell(
                tr("the settings cannot be written to {path}; they last until the window is "
                   "closed", path=self.path)
            )  # fmt: skip

    def _set_aside(self, path: Path) -> None:
        """What is no file of settings by its size is kept beside it, and not read."""
        try:
            if not path.is_file() or path.stat().st_size <= LARGEST_FILE:
                return
            aside = path.with_name(f"{path.name}.damaged")
            path.replace(aside)
        except (OSError, ValueError):
            return
        self._tell(
            tr("the settings in {path} are far too large to be any; they lie in {aside} now, and "
               "all is as at first", path=path, aside=aside)
        )  # fmt: skip

    def _tell(self, sentence: str) -> None:
        if self._notifier is not None and sentence not in self._told:
            self._told.add(sentence)
            self._notifier.tell("warning", sentence)


def _read(found: object, default: T) -> T | None:
    """What was found as the default's type; None, or an exception, where it is none."""
    if isinstance(default, QByteArray):
        return found if isinstance(found, QByteArray) else None
    if isinstance(default, list):
        return _texts(found)
    if not isinstance(found, str):
        return None
    if isinstance(default, bool):
        return {"true": True, "false": False}.get(found)
    if isinstance(default, float):
        return float(found) if math.isfinite(float(found)) else None
    return int(found) if isinstance(default, int) else found


def _texts(found: object) -> list[str] | None:
    made = json.loads(found) if isinstance(found, str) else None
    if isinstance(made, list) and all(isinstance(one, str) for one in made):
        return made
    return None


def _one_of(allowed: tuple[str, ...], found: str) -> str:
    return found if found in allowed else allowed[0]


def _place() -> Path:
    """The user's own file, where the system keeps such."""
    ini = QSettings.Format.IniFormat
    return Path(QSettings(ini, QSettings.Scope.UserScope, "Georibbon", "Georibbon").fileName())


def _system_language() -> str:
    from PySide6.QtCore import QLocale

    return QLocale.system().name().partition("_")[0]


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False
