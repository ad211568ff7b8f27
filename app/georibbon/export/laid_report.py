"""The report on curves that were laid, for programs."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from georibbon import __version__
from georibbon.export.files import require_ending, write_whole
from georibbon.export.laying import Laid, LaidCurve
from georibbon.export.summary import as_json, notice_data, of_checks, surface_data, worst
from georibbon.geometry.framing import FramingSettings
from georibbon.geometry.settings import SurfaceSettings
from georibbon.notices import Notice

LAID_ENDINGS = (".json",)


def write_laid_report(path: Path, data: dict[str, Any]) -> None:
    """Write the report as `laid_data` gives it; ExportError for another ending than .json."""
    require_ending(path, LAID_ENDINGS, "a report on curves")
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(path, text.encode("utf-8"))


def laid_data(
    laid: Laid,
    framing: FramingSettings,
    settings: SurfaceSettings,
    *,
    source: str,
    unit: str,
    files: Sequence[str] = (),
    notices: Sequence[Notice] = (),
) -> dict[str, Any]:
    """The report as JSON holds it.

    source: the file of curves; unit: of the surface files; files: the names of
    those written beside; notices: of the file, before those of the curves.
    Names end with their unit.  Numbers that are not finite become None.
    """
    verdict, reasons = worst(of_checks(laid.surface))
    data = {
        "georibbon": __version__,
        "source": source,
        "unit": unit,
        "files": list(files),
        "quality": verdict,
        "quality_reasons": reasons,
        "curves": [_curve(one, framing) for one in laid.curves],
        "settings": asdict(settings),
        "surface": surface_data(laid.surface),
        "notices": [notice_data(notice) for notice in (*notices, *laid.notices)],
    }
    document: dict[str, Any] = as_json(data)
    return document


def _curve(curve: LaidCurve, framing: FramingSettings) -> dict[str, Any]:
    framed = curve.framed
    sigma = None if curve.sigma is None else 1e3 * np.sqrt(np.mean(curve.sigma**2))
    return {
        "name": curve.name,
        "kind": curve.kind,
        "points": len(curve.strip.s),
        "length_m": curve.strip.s[-1] - curve.strip.s[0],
        "normals": "measured" if framed.measured else framing.normals,
        "noise_mm": 1e3 * framed.noise,
        "position_cut_mm": 1e3 * framed.position_cut,
        "normal_cut_mm": 1e3 * framed.normal_cut,
        "position_sigma_mm": sigma,
        "straight_mm": [[1e3 * a, 1e3 * b] for a, b in framed.straight],
    }
