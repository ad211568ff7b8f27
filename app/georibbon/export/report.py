"""The report: as JSON for programs, as an HTML page or a PDF that is filed with the part."""

import base64
import hashlib
import json
import os
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from georibbon.export.files import REPORT_ENDINGS, require_ending, write_whole
from georibbon.export.summary import report_data
from georibbon.export.words import (
    SIGNS,
    check_rows,
    chosen_words,
    date_words,
    method_words,
    number,
    page_title,
)
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
    """Write the report; the format comes from the path's ending, .json, .html or .pdf.

    source, unit, files: as `report_data` has them.  title and created are for
    the pages alone: their heading (the source's name where None) and their date
    (now where None).  The same result gives the same bytes, but for the date.
    Raises ExportError for another ending or a place that cannot be written.
    """
    ending = require_ending(path, REPORT_ENDINGS, "a report")
    data = report_data(reconstruction, source=source, unit=unit, files=files)
    if ending == ".json":
        text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        write_whole(path, text.encode("utf-8"))
    elif ending == ".pdf":
        from georibbon.export.pdf import report_pdf

        write_whole(path, report_pdf(reconstruction, data, title=title, created=created))
    else:
        page = report_html(reconstruction, data, title=title, created=created)
        write_whole(path, page.encode("utf-8"))


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
    page.filters["number"] = number
    return page.get_template("report.html").render(
        data,
        title=page_title(data["source"], title),
        created=date_words(created),
        style=Markup(style),  # noqa: S704  our own file, not a person's text
        style_hash=base64.b64encode(hashlib.sha256(style.encode("utf-8")).digest()).decode(),
        method_words=method_words(data),
        signs=SIGNS,
        chosen=chosen_words(data["passes"]),
        checks=check_rows(data["surface"]["checks"]) if data["surface"] else [],
        scene=_embedded(picture(reconstruction, _PICTURE_SIZE), "image/png"),
        plan=_embedded(figures.plan_figure(reconstruction), "image/svg+xml"),
        profiles=_embedded(figures.profiles_figure(reconstruction), "image/svg+xml"),
        residuals=_embedded(figures.residuals_figure(reconstruction), "image/svg+xml"),
    )


def _embedded(data: bytes, kind: str) -> str:
    """A file as a data URI."""
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"
