"""The report as PDF: what the HTML page says and shows, on pages of A4."""

import os
from collections.abc import Sequence
from datetime import datetime
from typing import Any

# The plotting library refuses to load where a notebook has left a backend of its own here.
os.environ["MPLBACKEND"] = "agg"

from reportlab.platypus import Flowable

from georibbon.export import figures
from georibbon.export.pdf_pages import (
    badge,
    box,
    facts,
    pages,
    picture,
    table,
    text,
    use_fonts,
)
from georibbon.export.picture import picture as scene_picture
from georibbon.export.words import (
    check_rows,
    chosen_words,
    date_words,
    method_words,
    number,
    page_title,
)
from georibbon.reconstruction import Reconstruction

_SCENE_SIZE = (1600, 1000)
_FAR = 3.0  # standard deviations
Story = list[Flowable]


def report_pdf(
    reconstruction: Reconstruction,
    data: dict[str, Any],
    *,
    title: str | None = None,
    created: datetime | None = None,
) -> bytes:
    """The pages, fonts and pictures inside.

    data: as `report_data` gives it for this result.  title, created: as
    `write_report` has them.
    """
    heading, date = page_title(data["source"], title), date_words(created)
    foot = f"{heading[:60]}, {date}, Georibbon {data['georibbon']}"
    return pages(report_story(reconstruction, data, heading, date), heading, foot)


def report_story(
    reconstruction: Reconstruction, data: dict[str, Any], heading: str, date: str
) -> Story:
    """What follows one another on the pages."""
    use_fonts()
    return [
        *_head(data, heading, date),
        *_verdict(data),
        *_notices(data["notices"]),
        *_surface(reconstruction, data["surface"]),
        *_passes(reconstruction, data["passes"]),
        picture(
            figures.residuals_figure(reconstruction, "png"),
            "Blue: the reading is below the fit; red: above; grey: not used; a cross: beyond four "
            "standard deviations. A column that stands out is a sensor, a row a pass, a patch "
            "something on the way (steel, a magnet, a lifted ribbon).",
            "Residuals by sensor",
        ),
        *_survey(data["survey"]),
        *_calibration(data["calibration"]),
    ]


def _head(data: dict[str, Any], heading: str, date: str) -> Story:
    ribbon, turned = data["ribbon"], data["heading"]
    sigma = turned["sigma_deg"]
    spread = " (taken, not measured)" if sigma is None else f", ± {number(sigma, 1)}°"
    files = ", ".join(data["files"])
    pairs = [
        ("Date", date),
        ("Source", data["source"]),
        (
            "Ribbon",
            f"{ribbon['id']}, {ribbon['accelerometers']} accelerometers, "
            f"{ribbon['magnetometers']} magnetometers, {number(ribbon['length_m'], 3)} m",
        ),
        ("Heading", f"{number(turned['deg'], 1)}° against magnetic axes{spread}"),
        ("Method", method_words(data)),
        ("Files", f"{f'{files}; ' if files else ''}surface in {data['unit']}"),
        ("Made by", f"Georibbon {data['georibbon']}"),
    ]
    return [text("SURFACE REPORT", "kicker"), text(heading, "title"), facts(pairs)]


def _verdict(data: dict[str, Any]) -> Story:
    verdict, reasons = data["quality"], data["quality_reasons"]
    checked = " and the surface passes its checks" if data["surface"] else ""
    said = [f"• {reason}" for reason in reasons] or [f"Every pass is good{checked}."]
    words = [badge(verdict, "text"), *(text(one) for one in said)]
    return [text("Verdict", "heading"), box(verdict, words)]


def _notices(notices: list[dict[str, Any]]) -> Story:
    if not notices:
        return []
    rows = [
        (one["code"], one.get("pass", "–"), one.get("sensor", "–"), one["message"])
        for one in notices
    ]
    heads = _heads("Code", "Pass", "Sensor", "Message")
    return [text("Notices", "heading"), table(heads, rows, (2.4, 1, 1.2, 8))]


def _surface(reconstruction: Reconstruction, surface: dict[str, Any] | None) -> Story:
    what = "The surface" if surface else "The passes"
    story: Story = [
        picture(
            scene_picture(reconstruction, _SCENE_SIZE),
            f"{what} in the workpiece frame, z up, coloured by position uncertainty (one standard "
            "deviation: the square root of the trace of the position's covariance).",
            "Surface" if surface else "Passes in space",
        ),
    ]
    if surface is None:
        return story
    pairs = [
        ("Area", f"{number(surface['area_m2'], 4)} m²"),
        ("Triangles", str(surface["triangles"])),
    ]
    if surface["solid_triangles"]:
        pairs.append(("Solid", f"closed, {surface['solid_triangles']} triangles"))
    story.append(facts(pairs))
    if surface["checks"]:
        rows = [
            (one["code"], one["where"], badge(one["verdict"]), one["found"], one["message"])
            for one in check_rows(surface["checks"])
        ]
        heads = _heads("Check", "Where", "Verdict", ">Found", "Message")
        story += [
            text("Checks of the surface", "heading 2"),
            table(heads, rows, (2, 1.6, 1.5, 1.8, 5)),
        ]
    return story


def _passes(reconstruction: Reconstruction, passes: list[dict[str, Any]]) -> Story:
    rows = [
        (
            one["name"],
            one["kind"],
            badge(one["quality"]),
            number(one["length_m"], 3),
            number(one["position_sigma_mm"], 2),
            number(one["position_sigma_max_mm"], 2),
            number(one["normal_sigma_deg"], 2),
            number(one["residual_rms"], 2),
            number(one["smoothing_mm"], 0),
            ", ".join(one["sensors_ignored"]) or "none",
        )
        for one in passes
    ]
    heads = _heads(
        "Pass", "Kind", "Verdict", ">Length, m", ">Position 1σ, mm", ">largest, mm",
        ">Normal 1σ, °", ">Residual rms", ">Smoothing, mm", "Sensors left out",
    )  # fmt: skip
    return [
        text("Passes", "heading"),
        table(heads, rows, (1.3, 1, 2, 1.3, 1.4, 1.3, 1.4, 1.5, 1.7, 2.4)),
        text(
            "Residual rms: readings against the fit, in their own standard deviations; about 1 is "
            "as expected. Smoothing: the shortest detail that is followed.",
            "note",
        ),
        *_chosen(passes),
        picture(figures.plan_figure(reconstruction, "png")),
        picture(figures.profiles_figure(reconstruction, "png")),
    ]


def _chosen(passes: list[dict[str, Any]]) -> Story:
    """Weights, cut ends and sensors that were switched off; nothing where none were."""
    words = chosen_words(passes)
    if not words:
        return []
    return [text("Chosen by hand", "heading 2"), *(text(f"• {one}") for one in words)]


def _survey(survey: list[dict[str, Any]]) -> Story:
    if not survey:
        return [text("Survey", "heading"), text("No mark, distance or crossing was given.")]
    rows = [
        (
            one["kind"],
            ", ".join(one["passes"]),
            ", ".join(number(at, 3) for at in one["at_m"]),
            number(one["residual_mm"], 2),
            number(one["sigma_mm"], 2),
            _ratio(one["ratio"]),
        )
        for one in survey
    ]
    heads = _heads(
        "Observation", "Passes", "At, m along the ribbon", ">Residual, mm", ">Stated 1σ, mm",
        ">Ratio",
    )  # fmt: skip
    return [
        text("Survey", "heading"),
        table(heads, rows, (1.5, 2, 3, 1.5, 1.5, 1)),
        text(
            "Ratio: the residual in standard deviations of the observation; beyond 3 look whether "
            "a number was mistyped or a pass has moved.",
            "note",
        ),
    ]


def _ratio(ratio: float | None) -> str:
    """The ratio; with a mark where it is far."""
    far = ratio is not None and abs(ratio) > _FAR
    return f"{'! ' if far else ''}{number(ratio, 1)}"


def _calibration(calibration: dict[str, Any]) -> Story:
    story: Story = [text("Calibration", "heading")]
    quality, dip = calibration["quality"], number(calibration["dip_deg"], 1)
    if quality is None:
        story.append(
            text(
                f"The calibration of ribbon {calibration['ribbon']} came without quality figures; "
                f"dip of the field {dip}°."
            )
        )
    else:
        rows = [
            ("Poses", str(quality["poses"])),
            ("Predicted tilt of a sensor, 1σ", f"{number(quality['tilt_deg'], 2)}°"),
            ("Predicted heading of a sensor, 1σ", f"{number(quality['heading_deg'], 2)}°"),
            ("Rotation common to all sensors, 1σ", f"{number(quality['gauge_deg'], 2)}°"),
            (
                "Worst accelerometer parameter for 1 mg of noise",
                f"{number(quality['accelerometer_mg'], 2)} mg",
            ),
            (
                "Worst magnetometer parameter for 0.5 % of noise",
                f"{number(quality['magnetometer_percent'], 2)} %",
            ),
            ("Coverage of directions (1 is even)", number(quality["coverage"], 2)),
            (
                "Accelerometer residual, rms",
                f"{number(quality['accelerometer_residual_mg'], 2)} mg",
            ),
            (
                "Magnetometer residual, rms",
                f"{number(quality['magnetometer_residual_percent'], 2)} %",
            ),
            ("Dip of the field", f"{dip}°"),
        ]
        story.append(table(_heads("", ">", ""), [(*row, "") for row in rows], (4, 1.5, 4)))
    if calibration["sensors_ignored"]:
        story.append(text("Left out of every fit:"))
        story += [
            text(f"• {one['sensor']}: {one['reason']}") for one in calibration["sensors_ignored"]
        ]
    return story


def _heads(*names: str) -> Sequence[tuple[str, Any]]:
    """Columns' names; one that begins with > is aligned on the right."""
    return [(name.removeprefix(">"), "right" if name.startswith(">") else "left") for name in names]
