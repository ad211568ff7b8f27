"""The calibration file: a ribbon's calibration as JSON, for recordings that have no poses."""

import json
from collections.abc import Mapping
from pathlib import Path

from georibbon.calibration.model import Calibration
from georibbon.calibration.serial import from_dict, to_dict
from georibbon.errors import CalibrationError
from georibbon.session.files import built_file, read_bounded

MAX_CALIBRATION = 16 * 2**20


def read_calibration(path: Path) -> Calibration:
    """The calibration in a file; CalibrationError, with the file named, if there is none in it."""
    return from_dict(read_document(path), str(path))


def read_document(path: Path) -> object:
    """The JSON in a file of bounded size; CalibrationError, with the file named, if it is none."""
    data = read_bounded(path, MAX_CALIBRATION, str(path), CalibrationError)
    try:
        return json.loads(data.removeprefix(b"\xef\xbb\xbf"))
    except (ValueError, RecursionError) as error:
        place = f"line {error.lineno}" if isinstance(error, json.JSONDecodeError) else str(error)
        raise CalibrationError(
            f"{path}: this is not JSON ({place}); give a file that `georibbon calibrate` wrote"
        ) from error


def write_calibration(
    calibration: Calibration, path: Path, about: Mapping[str, object] | None = None
) -> None:
    """Write a calibration, whole or not at all; CalibrationError where it cannot be written.

    about: further fields, such as its name, which a calibration itself has not.
    """
    write_document({**(about or {}), **to_dict(calibration)}, path)


def write_document(document: Mapping[str, object], path: Path) -> None:
    """Write JSON, whole or not at all; CalibrationError where it cannot be written."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    with built_file(path, CalibrationError) as built:
        built.write_text(text + "\n", encoding="utf-8")
