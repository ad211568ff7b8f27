"""What a report says, as plain data: numbers, words, lists and tables by name."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from georibbon import __version__
from georibbon.calibration.model import Calibration
from georibbon.fitting.assessment import Verdict
from georibbon.geometry.surface import Surface
from georibbon.notices import Notice
from georibbon.reconstruction import FittedPass, Reconstruction, SurveyResidual
from georibbon.ribbon import Ribbon

_RANKS: tuple[Verdict, ...] = ("good", "acceptable", "redo")
_OF_CHECK: Mapping[str, Verdict] = {"pass": "good", "warn": "acceptable", "fail": "redo"}
_DIGITS = 6
_MOST_NAMES = 8


def report_data(
    reconstruction: Reconstruction, *, source: str, unit: str, files: Sequence[str] = ()
) -> dict[str, Any]:
    """The report as JSON holds it: only str, int, float, bool, None, lists and dicts.

    source: what was reconstructed; unit: of the surface files; files: the names
    of the files written beside.  Names end with their unit (_mm, _m, _deg).
    Numbers that are not finite become None; all have six significant digits.
    """
    verdict, reasons = overall(reconstruction)
    data = {
        "georibbon": __version__,
        "source": source,
        "method": reconstruction.method,
        "tangents": reconstruction.tangents if reconstruction.method == "paper" else None,
        "unit": unit,
        "files": list(files),
        "quality": verdict,
        "quality_reasons": reasons,
        "ribbon": _ribbon(reconstruction.ribbon),
        "calibration": _calibration(reconstruction.calibration),
        "heading": _heading(reconstruction),
        "passes": [_pass(fitted) for fitted in reconstruction.passes],
        "survey": [_observation(seen) for seen in reconstruction.survey],
        "surface": reconstruction.surface and surface_data(reconstruction.surface),
        "notices": [notice_data(notice) for notice in all_notices(reconstruction)],
    }
    document: dict[str, Any] = as_json(data)
    return document


def overall(reconstruction: Reconstruction) -> tuple[Verdict, list[str]]:
    """The worst verdict among passes and checks, and why: one sentence a reason, worst first.

    Passes or places with the same reason share its sentence.
    """
    found = [(one.name, one.quality.verdict, one.quality.reason) for one in reconstruction.passes]
    return worst(found + (of_checks(reconstruction.surface) if reconstruction.surface else []))


def of_checks(surface: Surface) -> list[tuple[str, Verdict, str]]:
    """Each check's place, verdict and sentence."""
    return [(one.where, _OF_CHECK[one.verdict], one.message) for one in surface.checks]


def worst(found: Sequence[tuple[str, Verdict, str]]) -> tuple[Verdict, list[str]]:
    """The worst of places with verdicts and reasons, and the reasons for what is not good."""
    places: dict[tuple[Verdict, str], list[str]] = {}
    for place, verdict, reason in found:
        places.setdefault((verdict, reason), []).append(place)
    ranked = sorted(places, key=lambda reason: -_RANKS.index(reason[0]))
    reasons = [
        f"{_joined(places[verdict, reason])}: {reason} ({verdict})"
        for verdict, reason in ranked
        if verdict != "good"
    ]
    return (ranked[0][0] if ranked else "good"), reasons


def _joined(names: list[str]) -> str:
    """Names in a row, the first few of many."""
    more = len(names) - _MOST_NAMES
    return ", ".join(names) if more <= 0 else f"{', '.join(names[:_MOST_NAMES])} and {more} more"


def all_notices(reconstruction: Reconstruction) -> list[Notice]:
    """The notices of the result and those of its calibration, none twice."""
    return list(dict.fromkeys((*reconstruction.calibration.notices, *reconstruction.notices)))


def _ribbon(ribbon: Ribbon) -> dict[str, Any]:
    return {
        "id": ribbon.id,
        "length_m": ribbon.length,
        "accelerometers": len(ribbon.indices("accelerometer")),
        "magnetometers": len(ribbon.indices("magnetometer")),
    }


def _heading(reconstruction: Reconstruction) -> dict[str, Any]:
    """The workpiece's heading against magnetic axes; sigma null where it was taken, not found."""
    sigma = reconstruction.heading_sigma
    return {
        "deg": np.degrees(reconstruction.heading),
        "sigma_deg": None if sigma is None else np.degrees(sigma),
    }


def _calibration(calibration: Calibration) -> dict[str, Any]:
    quality = calibration.quality
    return {
        "ribbon": calibration.ribbon_id,
        "dip_deg": math.degrees(calibration.dip),
        "sensors_ignored": [
            {"sensor": model.name, "reason": model.reason}
            for model in calibration.sensors
            if not model.used
        ],
        "quality": quality
        and {
            "poses": quality.poses,
            "tilt_deg": quality.tilt,
            "heading_deg": quality.heading,
            "gauge_deg": quality.gauge,
            "accelerometer_mg": quality.accelerometer_mg,
            "magnetometer_percent": quality.magnetometer_percent,
            "coverage": quality.coverage,
            "accelerometer_residual_mg": quality.accelerometer_residual_mg,
            "magnetometer_residual_percent": quality.magnetometer_residual_percent,
        },
    }


def _pass(fitted: FittedPass) -> dict[str, Any]:
    sigma = fitted.position_sigma
    return {
        "name": fitted.name,
        "kind": fitted.kind,
        "length_m": fitted.strip.s[-1] - fitted.strip.s[0],
        "position_sigma_mm": 1e3 * np.sqrt(np.mean(sigma**2)),
        "position_sigma_max_mm": 1e3 * np.max(sigma),
        "normal_sigma_deg": np.degrees(np.sqrt(np.mean(fitted.normal_sigma**2))),
        "residual_rms": fitted.residual_rms,
        "smoothing_mm": 1e3 * fitted.smoothing,
        "sensors_ignored": list(fitted.sensors_ignored),
        "sensors_off": list(fitted.sensors_off),
        "trim_mm": [1e3 * end for end in fitted.trim],
        "weight": fitted.weight,
        "quality": fitted.quality.verdict,
        "quality_reason": fitted.quality.reason,
    }


def _observation(seen: SurveyResidual) -> dict[str, Any]:
    return {
        "kind": seen.kind,
        "passes": list(seen.passes),
        "at_m": list(seen.at),
        "residual_mm": 1e3 * seen.residual,
        "sigma_mm": 1e3 * seen.sigma,
        "ratio": seen.ratio,
    }


def surface_data(surface: Surface) -> dict[str, Any]:
    """A surface's size and checks."""
    return {
        "area_m2": surface.area,
        "triangles": len(surface.mesh.triangles),
        "solid_triangles": surface.solid and len(surface.solid.triangles),
        "checks": [
            {
                "code": check.code,
                "verdict": check.verdict,
                "value": check.value,
                "unit": check.unit,
                "where": check.where,
                "message": check.message,
            }
            for check in surface.checks
        ],
    }


def notice_data(notice: Notice) -> dict[str, Any]:
    """A notice, with what it is about."""
    data = {"code": notice.code, "message": notice.message}
    if notice.pass_name is not None:
        data["pass"] = notice.pass_name
    if notice.sensor is not None:
        data["sensor"] = notice.sensor
    return data


def as_json(value: Any) -> Any:
    """The value with nothing in it that JSON or UTF-8 cannot say."""
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, str):  # a file name that is no UTF-8 holds lone surrogates
        return value.encode("utf-8", "backslashreplace").decode("utf-8")
    if isinstance(value, Mapping):
        return {as_json(name): as_json(entry) for name, entry in value.items()}
    if isinstance(value, Sequence):
        return [as_json(entry) for entry in value]
    number = float(value)
    return float(f"{number:.{_DIGITS}g}") if math.isfinite(number) else None
