"""The calibrations that are kept: a folder of calibration files, each with a name and its checks.

A calibration's file is one that `georibbon calibrate` might have written, with two
fields more; beside it lies, once it was checked, a file of what the checks found.
"""

import datetime
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from georibbon.calibration.model import Calibration
from georibbon.calibration.serial import from_dict
from georibbon.errors import CalibrationError, GeoribbonError
from georibbon.session.calibration_file import read_document, write_calibration, write_document
from georibbon.session.events import now

HISTORY = ".checks.json"
HISTORY_FORMAT, HISTORY_VERSION = "georibbon-checks", 1
DISCARDED = "discarded"
MOST_FILES = 1000
MOST_CHECKS = 1000
LONGEST_NAME = 120
MOST_DEGREES = 1e6
_VERDICTS = ("good", "usable", "calibrate")


@dataclass(frozen=True)
class PastCheck:
    """One daily check: when (UTC, ISO 8601), its verdict, the worst sensor's degrees, why."""

    time: str
    verdict: str
    degrees: float
    reason: str


@dataclass(frozen=True, eq=False)
class Kept:
    """One calibration that is kept.  made: when, UTC, ISO 8601."""

    path: Path
    name: str
    made: str
    calibration: Calibration
    checks: tuple[PastCheck, ...] = ()


@dataclass(frozen=True)
class Spoilt:
    """A file of the folder that holds no calibration, and why."""

    path: Path
    reason: str


class Shelf:
    """The folder; it is made when the first calibration is kept."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def look(self) -> tuple[tuple[Kept, ...], tuple[Spoilt, ...]]:
        """All that is kept, the newest first, and the files that hold no calibration."""
        kept, spoilt = [], []
        for path in self._files():
            try:
                one, trouble = self._read(path)
            except GeoribbonError as error:
                spoilt.append(Spoilt(path, str(error)))
                continue
            kept.append(one)
            if trouble is not None:
                spoilt.append(trouble)
        kept.sort(key=lambda one: one.made, reverse=True)
        return tuple(kept), tuple(spoilt)

    def newest(self, ribbon_id: str) -> Kept | None:
        """The newest calibration of a ribbon; None where none is kept."""
        return next((o for o in self.look()[0] if o.calibration.ribbon_id == ribbon_id), None)

    def keep(self, calibration: Calibration, name: str, made: str | None = None) -> Kept:
        """Keep a calibration under a name; CalibrationError where it cannot be written.

        made: when, UTC, ISO 8601; now where None.
        """
        name, made = check_name(name), made or now()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CalibrationError(
                f"{self.folder}: the folder cannot be made ({error.strerror}); choose another"
            ) from error
        path = self._free(f"{calibration.ribbon_id} {name}")
        write_calibration(calibration, path, {"name": name, "made": made})
        return Kept(path, name, made, calibration)

    def load(self, path: Path) -> Kept:
        """Keep a calibration from a file elsewhere; CalibrationError where there is none in it.

        It is as old as its file says, so that it is not taken for the newest.
        """
        document = read_document(path)
        calibration = from_dict(document, str(path))
        return self.keep(calibration, _name_in(document, path), _made_in(document, path))

    def rename(self, kept: Kept, name: str) -> Kept:
        """Give it another name."""
        name = check_name(name)
        write_calibration(kept.calibration, kept.path, {"name": name, "made": kept.made})
        return Kept(kept.path, name, kept.made, kept.calibration, kept.checks)

    def discard(self, kept: Kept) -> Path:
        """Take it from the shelf; where it lies now, for `restore`."""
        away = self.folder / DISCARDED
        target = _unused(away / kept.path.name)
        try:
            away.mkdir(exist_ok=True)
            kept.path.rename(target)
            with suppress(FileNotFoundError):
                _history(kept.path).rename(_history(target))
        except OSError as error:
            raise CalibrationError(f"{kept.path}: it cannot be moved ({error.strerror})") from error
        return target

    def restore(self, discarded: Path) -> Kept:
        """Put back what was discarded."""
        target = _unused(self.folder / discarded.name)
        try:
            discarded.rename(target)
            with suppress(FileNotFoundError):
                _history(discarded).rename(_history(target))
        except OSError as error:
            raise CalibrationError(f"{discarded}: it cannot be moved ({error.strerror})") from error
        return self._read(target)[0]

    def note_check(self, kept: Kept, verdict: str, degrees: float, reason: str) -> Kept:
        """Write down a check of it; what was written of earlier ones stays."""
        checks = (*kept.checks, PastCheck(now(), verdict, degrees, reason))[-MOST_CHECKS:]
        document = {
            "format": HISTORY_FORMAT,
            "version": HISTORY_VERSION,
            "checks": [vars(one) for one in checks],
        }
        path = _history(kept.path)
        if path.exists() and not kept.checks:  # it could not be read: it is put aside, not lost
            with suppress(OSError):
                path.rename(_unused(path.with_suffix(".spoilt")))
        write_document(document, path)
        return Kept(kept.path, kept.name, kept.made, kept.calibration, checks)

    def _files(self) -> list[Path]:
        try:
            found = [path for path in self.folder.iterdir() if path.suffix == ".json"]
        except OSError:
            return []
        return sorted(path for path in found if not path.name.endswith(HISTORY))[:MOST_FILES]

    def _read(self, path: Path) -> tuple[Kept, Spoilt | None]:
        """One file, and what is wrong with that of its checks."""
        document = read_document(path)
        calibration = from_dict(document, path.name)
        made = _made_in(document, path)
        try:
            checks, trouble = _read_checks(_history(path)), None
        except GeoribbonError as error:
            checks, trouble = (), Spoilt(_history(path), str(error))
        return Kept(path, _name_in(document, path), made, calibration, checks), trouble

    def _free(self, name: str) -> Path:
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:60] or "calibration"
        return _unused(self.folder / f"{plain}.json")


def check_name(name: str) -> str:
    """The name without spaces around it; CalibrationError for one that cannot be shown."""
    name = name.strip()
    if not name or not name.isprintable() or len(name) > LONGEST_NAME:
        raise CalibrationError(
            f"a calibration's name has 1 to {LONGEST_NAME} printable characters, this one has "
            f"{len(name)}; give a short one"
        )
    return name


def _history(path: Path) -> Path:
    return path.with_name(path.stem + HISTORY)


def _unused(path: Path) -> Path:
    """The path, or one with a number where there is something."""
    found, number = path, 1
    while found.exists() or _history(found).exists():
        number += 1
        found = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return found


def _name_in(document: object, path: Path) -> str:
    name = document.get("name") if isinstance(document, Mapping) else None
    with suppress(CalibrationError):
        return check_name(name if isinstance(name, str) else path.stem)
    return "calibration"


def _made_in(document: object, path: Path) -> str:
    """When it was made, in UTC, so that texts sort as times do; the file's where none is told."""
    made = document.get("made") if isinstance(document, Mapping) else None
    if isinstance(made, str) and _is_time(made):
        with suppress(OverflowError):  # a day before the first in UTC
            at = datetime.datetime.fromisoformat(made).astimezone(datetime.UTC)
            return at.isoformat(timespec="milliseconds")
    changed = datetime.datetime.fromtimestamp(path.stat().st_mtime, datetime.UTC)
    return changed.isoformat(timespec="milliseconds")


def _is_time(text: str) -> bool:
    try:
        return datetime.datetime.fromisoformat(text).tzinfo is not None
    except ValueError:
        return False


def _read_checks(path: Path) -> tuple[PastCheck, ...]:
    if not path.exists():
        return ()
    document = read_document(path)
    known = isinstance(document, Mapping) and document.get("format") == HISTORY_FORMAT
    checks = document.get("checks") if known and isinstance(document, Mapping) else None
    if not isinstance(checks, Sequence) or isinstance(checks, str):
        raise CalibrationError(
            f"{path}: this is no list of checks; move it away, and a new one is begun"
        )
    return tuple(_check(entry, path) for entry in checks[-MOST_CHECKS:])


def _check(entry: object, path: Path) -> PastCheck:
    fields = entry if isinstance(entry, Mapping) else {}
    time, verdict, degrees, reason = (
        fields.get(name) for name in ("time", "verdict", "degrees", "reason")
    )
    if (
        isinstance(time, str)
        and _is_time(time)
        and isinstance(verdict, str)
        and verdict in _VERDICTS
        and isinstance(degrees, int | float)
        and abs(degrees) <= MOST_DEGREES
        and isinstance(reason, str)
    ):
        return PastCheck(time, verdict, float(degrees), reason)
    raise CalibrationError(
        f"{path}: a check has no time, verdict, degrees or reason; move the file away, and a new "
        "one is begun"
    )
