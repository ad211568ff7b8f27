"""A comparison as PDF: what its HTML page says and shows."""

import os
from datetime import datetime
from typing import Any

# The plotting library refuses to load where a notebook has left a backend of its own here.
os.environ["MPLBACKEND"] = "agg"

from reportlab.platypus import Flowable

from georibbon.export.comparison import Comparison
from georibbon.export.comparison_page import deviation_picture
from georibbon.export.figures import deviation_figure
from georibbon.export.pdf_pages import badge, facts, pages, picture, table, text, use_fonts
from georibbon.export.words import date_words, number
from georibbon.reconstruction import Reconstruction

_FIGURES = (
    ("Mean", "mean_mm"),
    ("Root mean square", "rms_mm"),
    ("95 % of the area within", "p95_mm"),
    ("Lowest", "lowest_mm"),
    ("Highest", "highest_mm"),
)


def comparison_pdf(
    comparison: Comparison,
    first: Reconstruction,
    data: dict[str, Any],
    created: datetime | None = None,
) -> bytes:
    """The pages; data: as `comparison_data` gives it."""
    date = date_words(created)
    heading = f"{data['first']} from {data['second']}"
    foot = f"{heading[:80]}, {date}, Georibbon {data['georibbon']}"
    return pages(comparison_story(comparison, first, data, heading, date), heading, foot)


def comparison_story(
    comparison: Comparison, first: Reconstruction, data: dict[str, Any], heading: str, date: str
) -> list[Flowable]:
    """What follows one another on the pages."""
    use_fonts()
    aligned = data["aligned"]
    frames = "as they are"
    if aligned:
        frames = f"laid onto the other first: turned {number(aligned['turned_deg'], 3)}°"
    pairs = [("Date", date), ("Made by", f"Georibbon {data['georibbon']}"), ("Frames", frames)]
    return [
        text("COMPARISON OF SURFACES", "kicker"),
        text(heading, "title"),
        facts(pairs),
        *_deviation(comparison, first, data),
        *_passes(data),
    ]


def _deviation(
    comparison: Comparison, first: Reconstruction, data: dict[str, Any]
) -> list[Flowable]:
    found = data["deviation"]
    if found is None:
        return [text("Deviation", "heading"), text("The two have no place in common.")]
    caption = (
        f"Positive: {data['first']} lies on the outer side of {data['second']}. Grey: "
        f"{data['second']} covers nothing there."
    )
    rows = [(name, f"{number(found[key], 3)} mm", "") for name, key in _FIGURES]
    within = f"Within {number(found['tolerance_mm'], 2)} mm"
    rows.append((within, f"{number(100 * found['within'], 1)} %", ""))
    rows.append(("Covered by the other", f"{number(100 * found['covered'], 1)} %", ""))
    return [
        picture(deviation_picture(comparison, first), caption, "Deviation"),
        table([("", "left"), ("", "right"), ("", "left")], rows, (4, 1.5, 4)),
        picture(deviation_figure(comparison.values, "png")),
    ]


def _passes(data: dict[str, Any]) -> list[Flowable]:
    rows = [
        (pair["name"], *_cells(pair["first"]), *_cells(pair["second"])) for pair in data["passes"]
    ]
    side: list[tuple[str, Any]] = [
        ("Verdict", "left"), ("Position 1σ, mm", "right"), ("Smoothing, mm", "right"),
    ]  # fmt: skip
    heads = [("Pass", "left"), *side, *side]
    return [
        text("Passes", "heading"),
        text(f"On the left {data['first']}, on the right {data['second']}.", "note"),
        table(heads, rows, (1.2, 1.6, 1.4, 1.4, 1.6, 1.4, 1.4)),
    ]


def _cells(one: dict[str, Any] | None) -> tuple[str | Flowable, str, str]:
    if one is None:
        return "–", "–", "–"
    sigma, smoothing = one["position_sigma_mm"], one["smoothing_mm"]
    return badge(one["quality"]), number(sigma, 2), number(smoothing, 0)
