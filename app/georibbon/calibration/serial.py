"""A calibration as plain data for a file, and back, strictly checked."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any, TypeGuard

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import (
    MOUNTING_SIGMA,
    Calibration,
    CalibrationQuality,
    SensorModel,
)
from georibbon.errors import CalibrationError
from georibbon.notices import Notice
from georibbon.ribbon import Ribbon

FORMAT = "georibbon-calibration"
VERSION = 1
MOST_SENSORS = 10_000
MOST_NOTICES = 10_000
MOST_NUMBER = 1e9  # counts per unit, counts; degrees and radians by far
SIGMAS = ("mounting_sigma", "gauge_sigma", "dip_sigma")
Data = Mapping[str, Any]


def to_dict(calibration: Calibration) -> dict[str, Any]:
    """Plain data (dict, list, str, float, bool) that JSON holds without loss."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "ribbon": calibration.ribbon_id,
        "dip": calibration.dip,
        **{name: getattr(calibration, name) for name in SIGMAS},
        "quality": None if calibration.quality is None else asdict(calibration.quality),
        "sensors": [
            {
                "name": model.name,
                "gain": model.gain.tolist(),
                "bias": model.bias.tolist(),
                "used": model.used,
                "reason": model.reason,
            }
            for model in calibration.sensors
        ],
        "notices": [asdict(notice) for notice in calibration.notices],
    }


def from_dict(data: object, where: str) -> Calibration:
    """The calibration that `data`, as `to_dict` gives it, holds.

    where: what the data was read from, for the message.  Raises
    CalibrationError that names the field, what was found and what is needed.
    """
    top = _mapping(data, where)
    if top.get("format") != FORMAT:
        raise CalibrationError(
            f"{where}: format is {top.get('format')!r}, {FORMAT!r} is needed; give a file that "
            "'georibbon calibrate' wrote"
        )
    version = top.get("version")
    if version != VERSION or isinstance(version, bool):
        raise CalibrationError(
            f"{where}: version is {version!r}, this program reads version {VERSION}; calibrate "
            "again or use a newer georibbon"
        )
    dip = _number(top, "dip", where)
    if abs(dip) > 0.5 * math.pi:
        raise CalibrationError(
            f"{where}: dip is {dip}, between -pi/2 and pi/2 radians is needed; calibrate again"
        )
    defaults = {"mounting_sigma": MOUNTING_SIGMA, "gauge_sigma": 0.0, "dip_sigma": 0.0}
    sigmas = {name: _sigma(top, name, where, defaults[name]) for name in SIGMAS}
    entries = _list(top, "sensors", where, MOST_SENSORS)
    sensors = tuple(_sensor(item, f"{where}: sensors[{k}]") for k, item in enumerate(entries))
    names = [sensor.name for sensor in sensors]
    twice = [name for name, number in Counter(names).items() if number > 1]
    if twice:
        raise CalibrationError(
            f"{where}: sensor {twice[0]} stands twice in sensors; keep one of them"
        )
    quality = top.get("quality")
    return Calibration(
        _text(top, "ribbon", where),
        dip,
        sensors,
        None if quality is None else _quality(quality, f"{where}: quality"),
        tuple(
            _notice(item, f"{where}: notices[{k}]")
            for k, item in enumerate(_list(top, "notices", where, MOST_NOTICES))
        ),
        **sigmas,
    )


def check_fits(calibration: Calibration, ribbon: Ribbon) -> None:
    """Raises CalibrationError, with both sides, where a calibration is not this ribbon's."""
    if calibration.ribbon_id != ribbon.id:
        raise CalibrationError(
            f"the calibration is of ribbon {calibration.ribbon_id}, the readings are of ribbon "
            f"{ribbon.id}; use that ribbon's calibration"
        )
    if len(calibration.sensors) != len(ribbon.sensors):
        raise CalibrationError(
            f"the calibration has {len(calibration.sensors)} sensors, ribbon {ribbon.id} has "
            f"{len(ribbon.sensors)}; calibrate the ribbon as it is now"
        )
    for model, sensor in zip(calibration.sensors, ribbon.sensors, strict=True):
        found = f"{model.name} with {len(model.bias)} axes"
        expected = f"{sensor.name} with {sensor.axes} axes"
        if found != expected:
            raise CalibrationError(
                f"the calibration has {found} where ribbon {ribbon.id} has {expected}; calibrate "
                "the ribbon as it is now"
            )


def _mapping(data: object, where: str) -> Data:
    if not isinstance(data, Mapping):
        raise CalibrationError(
            f"{where} holds {type(data).__name__}, named fields are needed; give a calibration file"
        )
    return data


def _wrong(where: str, name: str, value: object, expected: str) -> CalibrationError:
    shown = repr(value)
    shown = shown if len(shown) <= 60 else shown[:57] + "..."
    return CalibrationError(
        f"{where}: {name} is {shown}, {expected} is needed; correct it or calibrate again"
    )


def _is_number(value: object) -> TypeGuard[float]:
    """Whether it is a number of a size that a calibration can hold; not so nan."""
    return (
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MOST_NUMBER
    )


def _number(data: Data, name: str, where: str) -> float:
    value = data.get(name)
    if not _is_number(value):
        raise _wrong(where, name, value, f"a number of at most {MOST_NUMBER:g}")
    return float(value)


def _sigma(data: Data, name: str, where: str, default: float) -> float:
    if name not in data:
        return default
    value = _number(data, name, where)
    if value < 0.0:
        raise _wrong(where, name, value, "a standard deviation, zero or more")
    return value


def _text(data: Data, name: str, where: str) -> str:
    value = data.get(name)
    if not isinstance(value, str):
        raise _wrong(where, name, value, "text")
    return value


def _list(data: Data, name: str, where: str, most: int) -> list[Any]:
    value = data.get(name, [])
    if not isinstance(value, list) or len(value) > most:
        raise _wrong(where, name, value, f"a list of at most {most}")
    return value


def _table(data: Data, name: str, where: str, columns: int | None) -> FloatArray:
    """A list of numbers, or of rows of `columns` numbers, 2 or 3 long."""
    value = data.get(name)
    what = "2 or 3 numbers" if columns is None else "2 or 3 rows of 3 numbers"
    expected = f"a list of {what} of at most {MOST_NUMBER:g}"
    if not isinstance(value, list) or len(value) not in (2, 3):
        raise _wrong(where, name, value, expected)
    rows = [[item] for item in value] if columns is None else value
    for row in rows:
        if not isinstance(row, list) or len(row) != (columns or 1) or not all(map(_is_number, row)):
            raise _wrong(where, name, value, expected)
    table = np.array(rows, dtype=np.float64)
    return table[:, 0] if columns is None else table


def _sensor(item: object, where: str) -> SensorModel:
    data = _mapping(item, where)
    gain, bias = _table(data, "gain", where, 3), _table(data, "bias", where, None)
    if len(gain) != len(bias):
        raise _wrong(
            where, "bias", bias.tolist(), f"one number for each of gain's {len(gain)} rows"
        )
    if np.linalg.matrix_rank(gain) < len(gain):
        raise _wrong(where, "gain", gain.tolist(), "a row for each axis, none a sum of the others")
    used = data.get("used", True)
    if not isinstance(used, bool):
        raise _wrong(where, "used", used, "true or false")
    reason = _text(data, "reason", where) if "reason" in data else ""
    return SensorModel(_text(data, "name", where), gain, bias, used, reason)


def _quality(item: object, where: str) -> CalibrationQuality:
    data = _mapping(item, where)
    names = [entry.name for entry in fields(CalibrationQuality) if entry.name != "poses"]
    poses = data.get("poses")
    if not isinstance(poses, int) or isinstance(poses, bool) or poses < 0:
        raise _wrong(where, "poses", poses, "a whole number")
    return CalibrationQuality(poses, *(_number(data, name, where) for name in names))


def _notice(item: object, where: str) -> Notice:
    data = _mapping(item, where)
    optional = {
        name: None if data.get(name) is None else _text(data, name, where)
        for name in ("pass_name", "sensor")
    }
    return Notice(_text(data, "code", where), _text(data, "message", where), **optional)
