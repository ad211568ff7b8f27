"""The report: as JSON for programs, as one HTML page that is filed with the part."""

import base64
import hashlib
import json
import os
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path, PurePath
from typing import Any

from georibbon.export.files import REPORT_ENDINGS, require_ending, write_whole
from georibbon.export.summary import report_data
from georibbon.reconstruction import Reconstruction
from georibbon.resources import resource

__all__ = ["report_data", "report_html", "write_report"]

_PICTURE_SIZE = (1600, 1000)


def write_report(
    reconstruction: Reconstruction,
    path: Path,
    *,
    source: str,
    unit: str,
    files: Sequence[str] = (),
    title: str | None = None,
    created: datetime | None = None,
) -> None:
    """Write the report; the format comes from the path's ending, .json or .html.

    source, unit, files: as `report_data` has them.  title and created are for
    the page alone: its heading (the source's name where None) and its date (now
    where None).  The same result gives the same JSON.  Raises ExportError for
    another ending or a place that cannot be written.
    """
    ending = require_ending(path, REPORT_ENDINGS, "a report")
    data = report_data(reconstruction, source=source, unit=unit, files=files)
    if ending == ".json":
        text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    else:
        text = report_html(reconstruction, data, title=title, created=created)
    write_whole(path, text.encode("utf-8"))


def report_html(
    reconstruction: Reconstruction,
    data: dict[str, Any],
    *,
    title: str | None = None,
    created: datetime | None = None,
) -> str:
    """The page, complete in itself: pictures and style inside, nothing fetched, no script.

    data: as `report_data` gives it for this result.
    """
    # Loaded here: a JSON report needs neither the plotting library nor VTK nor the templates.
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    # The plotting library refuses to load where a notebook has left a backend of its own here.
    os.environ["MPLBACKEND"] = "agg"
    from georibbon.export import figures
    from georibbon.export.picture import picture

    folder = resource("report")
    style = (folder / "report.css").read_text(encoding="utf-8")
    page = Environment(
        loader=FileSystemLoader(folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page.filters["number"] = _number
    return page.get_template("report.html").render(
        data,
        title=_title(data["source"], title),
        created=(created or datetime.now()).astimezone().isoformat(" ", "minutes"),
        style=Markup(style),  # noqa: S704  our own file, not a person's text
        style_hash=base64.b64encode(hashlib.sha256(style.encode("utf-8")).digest()).decode(),
        checks=_check_rows(data["surface"]["checks"]) if data["surface"] else [],
        scene=_embedded(picture(reconstruction, _PICTURE_SIZE), "image/png"),
        plan=_embedded(figures.plan_figure(reconstruction), "image/svg+xml"),
        profiles=_embedded(figures.profiles_figure(reconstruction), "image/svg+xml"),
        residuals=_embedded(figures.residuals_figure(reconstruction), "image/svg+xml"),
    )


def _title(source: str, title: str | None) -> str:
    return title or PurePath(source).name or source


def _embedded(data: bytes, kind: str) -> str:
    """A file as a data URI."""
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _number(value: float | None, digits: int) -> str:
    """A number as a person reads it; a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}f}"


def _check_rows(checks: list[dict[str, Any]]) -> list[dict[str, str]]:
    """The checks as a person reads them: each that is amiss, then one line a kind that passes."""
    rows = [{**check, "found": _found([check])} for check in checks if check["verdict"] != "pass"]
    passed: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        if check["verdict"] == "pass":
            passed.setdefault(check["code"], []).append(check)
    for code, same in passed.items():
        places = [check["where"] for check in same]
        rows.append(
            {
                "code": code,
                "where": places[0] if len(same) == 1 else f"{places[0]} to {places[-1]}",
                "verdict": "pass",
                "found": _found(same),
                "message": same[0]["message"] if len(same) == 1 else f"passes in all {len(same)}",
            }
        )
    return rows


def _found(checks: list[dict[str, Any]]) -> str:
    """What checks of one kind found: a value, or the least and the greatest, with the unit."""
    values = [check["value"] for check in checks if check["value"] is not None]
    if not values:
        return "–"
    least, greatest, unit = _short(min(values)), _short(max(values)), checks[0]["unit"]
    return f"{least if least == greatest else f'{least} to {greatest}'} {unit}".strip()


def _short(value: float) -> str:
    """A number to three digits; what would be less than a thousandth is 0."""
    return f"{value:.3g}" if abs(value) >= 5e-4 else "0"
