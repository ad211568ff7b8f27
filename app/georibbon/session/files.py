"""Files and folders read within bounds, and written whole or not at all."""

import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from georibbon.errors import GeoribbonError


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
        folder = Path(tempfile.mkdtemp(prefix=f".{path.name[:40]}-", dir=path.absolute().parent))
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


@contextmanager
def built_folder(path: Path, error: type[GeoribbonError]) -> Iterator[Path]:
    """A folder beside `path` to fill; it becomes `path` if nothing failed.

    `path` may be an empty folder; one with contents, or a file, is refused.
    """
    if path.is_symlink() or (path.exists() and not path.is_dir()):
        raise error(f"{path}: this is no folder; give a new folder or an empty one")
    try:
        if path.exists() and any(path.iterdir()):
            raise error(f"{path}: the folder is not empty; give a new folder or an empty one")
        parent = path.absolute().parent
        parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{path.name[:40]}-", dir=parent))
    except OSError as cause:
        raise error(_cannot_write(path, cause)) from cause
    try:
        built = folder / "built"
        built.mkdir()
        yield built
        if path.exists():
            path.rmdir()
        built.rename(path)
    except OSError as cause:
        raise error(_cannot_write(path, cause)) from cause
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _cannot_write(path: Path, cause: OSError) -> str:
    reason = cause.strerror or cause
    return f"{path}: it cannot be written ({reason}); choose a place where you may write"
