"""Files and folders read within bounds, and written whole or not at all."""

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Literal

from georibbon.errors import GeoribbonError

_PREFIX = ".georibbon-"
Kind = Literal["file", "folder", "other", "nothing"]


def kind_of(path: Path) -> Kind:
    """What is at a path; "nothing" where it cannot even be looked at."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return "nothing"
    if stat.S_ISDIR(mode):
        return "folder"
    return "file" if stat.S_ISREG(mode) else "other"


def read_bounded(path: Path, limit: int, name: str, error: type[GeoribbonError]) -> bytes:
    """The bytes of a regular file of at most `limit` bytes, else `error` with its name."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            raise error(f"{name}: this is no regular file; put the file itself there")
        with path.open("rb") as file:
            data = file.read(min(limit, found.st_size) + 1)
    except FileNotFoundError as cause:
        raise error(f"{name}: the file is missing; put it there or correct its name") from cause
    except (OSError, ValueError) as cause:
        reason = getattr(cause, "strerror", None) or cause
        raise error(f"{name}: the file cannot be read ({reason}); see to its rights") from cause
    if len(data) > limit:
        raise error(f"{name}: the file has more than {limit} bytes; split it or cut it down")
    return data


@contextmanager
def built_file(path: Path, error: type[GeoribbonError]) -> Iterator[Path]:
    """A place beside `path` to write to; it takes the place of `path` if nothing failed.

    Raises `error` where the folder cannot be written; leaves nothing behind then.
    """
    try:
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=path.absolute().parent))
    except OSError as cause:
        raise error(_cannot_write(path, cause)) from cause
    try:
        built = folder / path.name
        yield built
        built.replace(path)
    except OSError as cause:
        raise error(_cannot_write(path, cause)) from cause
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def copy_rights(source: Path, target: Path) -> None:
    """Give a file the owner and the rights of another, as far as that is allowed."""
    found = source.stat()
    if hasattr(os, "chown"):
        with suppress(OSError):
            os.chown(target, found.st_uid, found.st_gid)
    shutil.copymode(source, target)


def sync_folder(path: Path) -> None:
    """See that the name of a file just made survives a failure of the power, where that can be."""
    try:
        descriptor = os.open(path.resolve().parent, os.O_RDONLY)
    except OSError:
        return  # Windows opens no folders, and sees to names itself
    try:
        os.fsync(descriptor)
    except OSError:
        return  # a file system without it
    finally:
        os.close(descriptor)


@contextmanager
def built_folder(path: Path, error: type[GeoribbonError]) -> Iterator[Path]:
    """A folder beside `path` to fill; it becomes `path` if nothing failed.

    `path` may be an empty folder; one with contents, or a file, is refused.
    """
    there = kind_of(path) == "folder"
    if not there and os.path.lexists(path):
        raise error(f"{path}: this is no folder; give a new folder or an empty one")
    try:
        if there and any(path.iterdir()):
            raise error(f"{path}: the folder is not empty; give a new folder or an empty one")
        parent = path.absolute().parent
        parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=parent))
    except OSError as cause:
        raise error(_cannot_write(path, cause)) from cause
    try:
        built = folder / "built"
        built.mkdir()
        yield built
        if there:
            _move_into(built, path)
        else:
            built.rename(path)
    except OSError as cause:
        raise error(_cannot_write(path, cause)) from cause
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _move_into(source: Path, folder: Path) -> None:
    """Move all of a folder into an empty one, files last; all or nothing."""
    names = [item.name for item in sorted(source.iterdir(), key=Path.is_file)]
    try:
        for name in names:
            (source / name).rename(folder / name)
    except OSError:
        for name in names:
            if (folder / name).exists():
                (folder / name).rename(source / name)
        raise


def _cannot_write(path: Path, cause: OSError) -> str:
    reason = cause.strerror or cause
    return f"{path}: it cannot be written ({reason}); choose a place where you may write"
