"""The truth of a virtual capture, in memory and as a file beside the recording.

The file is JSON: `surface` (name), `yaw_degrees`, `passes` (for each name `s`,
`points`, `normals`, `tangents`; workpiece frame, metres), and besides
`surface_parameters` and `calibration` (dip and the sensors' true models).
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration, SensorModel
from georibbon.errors import RecordingError
from georibbon.geometry.frames import Strip
from georibbon.geometry.reference import ReferenceSurface
from georibbon.session.files import built_file, read_bounded
from georibbon.simulation.surfaces import make_surface

MAX_BYTES = 200_000_000


@dataclass(frozen=True, eq=False)
class Truth:
    """What a recording should give back.

    surface: the surface's name; parameters: those it was made with; shape: the
    surface itself, None where it is not known.  strips: each pass's and tie's
    true curve, workpiece frame.  yaw_degrees: world = Rz(yaw) workpiece.
    calibration: the sensors' true models, None where they are not known.
    """

    surface: str
    strips: Mapping[str, Strip]
    yaw_degrees: float
    parameters: Mapping[str, float] = field(default_factory=dict)
    shape: ReferenceSurface | None = None
    calibration: Calibration | None = None


def write_truth(truth: Truth, path: Path) -> None:
    """Write the truth as JSON; raises `RecordingError` where the file cannot be written."""
    data: dict[str, Any] = {
        "surface": truth.surface,
        "yaw_degrees": truth.yaw_degrees,
        "passes": {name: _strip_data(strip) for name, strip in truth.strips.items()},
    }
    if truth.shape is not None:
        data["surface_parameters"] = dict(truth.parameters)
    if truth.calibration is not None:
        data["calibration"] = _calibration_data(truth.calibration)
    with built_file(path, RecordingError) as built:
        built.write_text(json.dumps(data, allow_nan=False), encoding="utf-8")


def _strip_data(strip: Strip) -> dict[str, Any]:
    columns = {
        "s": strip.s,
        "points": strip.points,
        "normals": strip.normals,
        "tangents": strip.tangents,
    }
    return {name: np.round(values, 9).tolist() for name, values in columns.items()}


def _calibration_data(calibration: Calibration) -> dict[str, Any]:
    return {
        "ribbon": calibration.ribbon_id,
        "dip_degrees": float(np.degrees(calibration.dip)),
        "sensors": [
            {"name": model.name, "gain": model.gain.tolist(), "bias": model.bias.tolist()}
            for model in calibration.sensors
        ],
    }


def read_truth(path: Path) -> Truth:
    """Read what `write_truth` wrote, or a truth file without surface parameters or calibration.

    Raises `RecordingError` where the file is missing or is no truth file.
    """
    data = read_bounded(path, MAX_BYTES, str(path), RecordingError)
    try:
        return _truth(json.loads(data))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise RecordingError(
            f"{path.name} is not a truth file as `georibbon simulate` writes it: {error!r}; "
            "simulate the recording again"
        ) from error


def _truth(data: Any) -> Truth:
    name = str(data["surface"])
    strips = {str(key): _strip(value) for key, value in data["passes"].items()}
    yaw = float(data["yaw_degrees"])
    calibration = _calibration(data["calibration"]) if "calibration" in data else None
    if "surface_parameters" not in data:
        return Truth(name, strips, yaw, calibration=calibration)
    parameters = {str(k): float(v) for k, v in data["surface_parameters"].items()}
    shape = make_surface(name, parameters)
    return Truth(name, strips, yaw, parameters, shape, calibration)


def _array(value: Any, *shape: int) -> FloatArray:
    """A finite array of that shape (-1: any); raises `ValueError`."""
    array = np.asarray(value, dtype=np.float64)
    fits = array.ndim == len(shape) and all(
        want in (-1, have) for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits or not np.isfinite(array).all():
        raise ValueError(f"an array of {array.shape} where {shape} finite numbers are expected")
    return array


def _strip(data: Any) -> Strip:
    s = _array(data["s"], -1)
    points = _array(data["points"], len(s), 3)
    tangents = _array(data["tangents"], len(s), 3)
    normals = _array(data["normals"], len(s), 3)
    frames = np.stack([tangents, np.cross(normals, tangents), normals], axis=2)
    return Strip(s, points, frames)


def _calibration(data: Any) -> Calibration:
    models = tuple(
        SensorModel(str(item["name"]), _array(item["gain"], -1, 3), _array(item["bias"], -1))
        for item in data["sensors"]
    )
    return Calibration(str(data["ribbon"]), float(np.radians(data["dip_degrees"])), models)
