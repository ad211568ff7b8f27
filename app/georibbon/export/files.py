"""Output files that are whole or not there at all."""

import uuid
from pathlib import Path

from georibbon.errors import ExportError


def write_whole(path: Path, data: bytes) -> None:
    """Write `data` to `path` so that no half-written file is ever left under its name.

    The bytes go to a temporary file in the same folder, which then takes the
    name in one step.  Raises ExportError where the folder is missing or cannot
    be written.
    """
    if not path.parent.is_dir():
        raise ExportError(
            f"{path}: the folder {path.parent} does not exist; make it or choose another place"
        )
    try:
        if path.is_dir():
            raise ExportError(f"{path} is a folder, a file was expected; add a file's name to it")
        _replace(path, data)
    except OSError as error:
        raise ExportError(
            f"{path}: cannot be written ({error.strerror}); free some space, "
            "allow writing there, or choose another place"
        ) from error


def _replace(path: Path, data: bytes) -> None:
    temporary = path.with_name(f".{path.name[:32]}.{uuid.uuid4().hex}")
    try:
        with temporary.open("xb") as file:
            file.write(data)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def require_ending(path: Path, endings: tuple[str, ...], what: str) -> str:
    """The path's ending in lower case; ExportError unless it is one of `endings`."""
    ending = path.suffix.lower()
    if ending not in endings:
        found = f"the ending {path.suffix!r}" if path.suffix else "no ending"
        raise ExportError(
            f"{path}: found {found}, expected {' or '.join(endings)} for {what}; "
            "rename the output file"
        )
    return ending
