"""The calibrations that are kept, as far as a capture asks for one."""

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QStandardPaths

from georibbon.calibration.model import Calibration
from georibbon.errors import GeoribbonError

MOST_LISTED = 100


@dataclass(frozen=True, eq=False)
class Kept:
    """A calibration that was kept: its file, the name it was given, and itself."""

    path: Path
    name: str
    calibration: Calibration


def kept_folder() -> Path:
    """Where calibrations are kept."""
    place = QStandardPaths.StandardLocation.AppLocalDataLocation
    return Path(QStandardPaths.writableLocation(place)) / "calibrations"


def read_kept(path: Path) -> Kept:
    """One that was kept or exported; CalibrationError, one sentence, where it is none."""
    from georibbon.calibration.serial import from_dict
    from georibbon.session.calibration_file import read_document

    document = read_document(path)
    calibration = from_dict(document, str(path))
    name = document.get("name") if isinstance(document, dict) else None
    return Kept(path, name if isinstance(name, str) and name else path.stem, calibration)


def kept_calibrations(ribbon_id: str, folder: Path | None = None) -> tuple[Kept, ...]:
    """Those of one ribbon, the newest first; what cannot be read is left out."""
    folder = kept_folder() if folder is None else folder
    try:
        files = [(path.stat().st_mtime, path) for path in folder.glob("*.json")]
    except OSError:
        return ()
    out = []
    for _, path in sorted(files, reverse=True)[:MOST_LISTED]:
        try:
            one = read_kept(path)
        except (GeoribbonError, OSError):
            continue
        if one.calibration.ribbon_id == ribbon_id:
            out.append(one)
    return tuple(out)
