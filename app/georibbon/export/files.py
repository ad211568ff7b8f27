"""Output files: which endings they may have, and how they are whole or not there at all."""

from pathlib import Path

from georibbon.errors import ExportError
from georibbon.session.files import built_file, kind_of

MESH_ENDINGS = (".stl", ".obj", ".ply")
CAD_ENDINGS = (".step", ".stp", ".igs", ".iges")
SURFACE_ENDINGS = (*MESH_ENDINGS, *CAD_ENDINGS)
CURVES_ENDINGS = (".csv",)
REPORT_ENDINGS = (".json", ".html", ".pdf")
PICTURE_ENDINGS = (".png",)


def write_whole(path: Path, data: bytes) -> None:
    """Write `data` to `path` so that no half-written file is ever left under its name.

    Raises ExportError where the folder is missing or cannot be written.
    """
    if not path.parent.is_dir():
        raise ExportError(
            f"{path}: the folder {path.parent} does not exist; make it or choose another place"
        )
    if kind_of(path) == "folder":
        raise ExportError(f"{path} is a folder, a file was expected; add a file's name to it")
    with built_file(path, ExportError) as built:
        built.write_bytes(data)


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
