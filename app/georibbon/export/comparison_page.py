"""A comparison as one HTML page: the picture of the deviation, its figures, the passes."""

import base64
import hashlib
import os
from datetime import datetime
from typing import Any

from georibbon.export.comparison import Comparison
from georibbon.export.words import SIGNS, date_words, number
from georibbon.reconstruction import Reconstruction
from georibbon.resources import resource

_SIZE = (1600, 1000)
_FONT_SIZE = 23  # pixels, as in the report's picture


def comparison_html(
    comparison: Comparison,
    first: Reconstruction,
    data: dict[str, Any],
    created: datetime | None = None,
) -> str:
    """The page, complete in itself, as the report's is.

    data: as `comparison_data` gives it.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    os.environ["MPLBACKEND"] = "agg"
    from georibbon.export.figures import deviation_figure

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
    scene = histogram = None
    if comparison.statistics is not None:
        scene = _embedded(deviation_picture(comparison, first), "image/png")
        histogram = _embedded(deviation_figure(comparison.values), "image/svg+xml")
    return page.get_template("comparison.html").render(
        data,
        created=date_words(created),
        signs=SIGNS,
        style=Markup(style),  # noqa: S704  our own file, not a person's text
        style_hash=base64.b64encode(hashlib.sha256(style.encode("utf-8")).digest()).decode(),
        scene=scene,
        histogram=histogram,
    )


def deviation_picture(comparison: Comparison, first: Reconstruction) -> bytes:
    """The first surface coloured by its deviation, as the bytes of a PNG file."""
    from georibbon.export.picture import png
    from georibbon.scene.colouring import Look
    from georibbon.scene.offscreen import drawn
    from georibbon.scene.scene import Scene

    look = Look("deviation", deviation=comparison.values)
    scene = Scene(first, font_size=_FONT_SIZE, look=look)
    scene.frame(_SIZE[0] / _SIZE[1])
    return png(drawn(scene, _SIZE))


def _embedded(data: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"
