"""Figures 12 and 13: normals from curves whose points are not exact."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from georibbon.geometry.arch import arch
from georibbon.geometry.correspondence import aligned
from georibbon.geometry.frames import Strip, arc_angles, dot
from georibbon.geometry.framing import FramingSettings, framed
from georibbon.paper_figures.building import (
    DEFAULT,
    TEAR_LIMIT,
    Numbers,
    distances,
    error_numbers,
    laid_by,
    laid_plainly,
    model_of,
    shape_numbers,
    tear_ratio,
    verdict_of,
)
from georibbon.paper_figures.curves import waved
from georibbon.paper_figures.figure import Choice, Figure, Whose
from georibbon.paper_figures.known_surfaces import COLOURS, arch_passes

NOISE = 1e-6  # m, of every coordinate
SPACING = 0.1  # m, of the paper's B-splines' knots
AS_THEY_ARE = partial(FramingSettings, position_cut=0.0)  # the paper smooths binormals alone
SITUATION = (
    "The five geodesics of the uneven arch, a point every 4 mm, each coordinate with an error of "
    "0.001 mm; no normals are given. "
)


def figure_12() -> Figure:
    """The surface from binormals as they come."""
    return Figure(
        12,
        "Binormals of computed curves",
        SITUATION + "The paper's binormals are of the points as they are, the default's normals of "
        "points that are smoothed as their noise asks for; and the surface from them.",
        "Binormals of geodesics that were computed on a free-form surface waver, and so does the "
        "surface that starts from them.",
        "A binormal needs second derivatives, which a thousandth of a millimetre is enough to "
        "spoil wherever the curve bends little. The default measures the noise, smooths the points "
        "so far, and finds the normals by the doubled angle, which weighs every place by how much "
        "it bends.",
        (
            _choice("binormals as they come", "paper", AS_THEY_ARE("raw")),
            _choice("binormals kept from turning over", "paper", AS_THEY_ARE("continuous")),
            _choice("Georibbon's default", "georibbon", None),
        ),
        main=("normal_rms_deg", "normal_max_deg", "rms_mm", "max_mm"),
        towards=(-0.55, -0.75, 1.0),
        colours=COLOURS,
    )


def figure_13() -> Figure:
    """The surface from smoothed binormals."""
    smoothed = AS_THEY_ARE("spline", normal_cut=SPACING)
    wide = FramingSettings("doubled-angle", normal_cut=SPACING)
    return Figure(
        13,
        "Smoothed binormals",
        SITUATION + "Binormals smoothed over 100 mm, the paper's of the points as they are, the "
        "others of points that are smoothed as their noise asks for. Besides, the tear at the "
        "inflections of the S-curves of figure 4 with the same errors, the worst of five draws.",
        "The same binormals after a least-squares fit by B-splines, and a smooth surface from "
        "them.",
        "Smoothing mends binormals that waver; it cannot mend one that has turned over, for the "
        "fit follows it. The doubled angle has no sign to be wrong about.",
        (
            _choice("least-squares B-spline, 100 mm", "paper", smoothed),
            _choice("doubled angle, 100 mm", "other", wide),
            _choice("Georibbon's default", "georibbon", None),
        ),
        main=("normal_rms_deg", "normal_max_deg", "rms_mm", "s_curve_tear_ratio"),
        towards=(-0.55, -0.75, 1.0),
        colours=COLOURS,
    )


def _choice(name: str, whose: Whose, framing: FramingSettings | None) -> Choice:
    """The arch from its noisy curves, their normals found as said; None: the default."""
    rule: FramingSettings = framing or FramingSettings()
    strips = noisy_passes(rule)
    built = laid_by(strips)
    away = distances(built, arch())
    numbers = normal_numbers(strips) | error_numbers(away) | shape_numbers(built)
    numbers["s_curve_tear_ratio"] = s_curve_tear(rule)
    verdict = verdict_of(numbers)
    if verdict == "whole" and numbers["s_curve_tear_ratio"] > TEAR_LIMIT:
        verdict = "torn at inflections"
    return Choice(
        name,
        whose,
        _told(rule),
        numbers,
        verdict,
        model_of(built, strips, np.abs(away)),
    )


def _told(rule: FramingSettings) -> str:
    cut = "" if rule.normal_cut is None else f" {1e3 * rule.normal_cut:.0f} mm"
    points = ", points as they are" if rule.position_cut == 0.0 else ""
    return f"normals {rule.normals}{cut}{points}; {DEFAULT}"


def noisy_passes(rule: FramingSettings) -> list[Strip]:
    """The arch's geodesics as their noisy points tell them, facing outwards as a whole."""
    random = np.random.default_rng(12)
    strips = []
    for true in arch_passes():
        noise = NOISE * random.normal(size=true.points.shape)
        found = framed(true.points + noise, settings=rule)
        down = float(np.sum(dot(found.normals, true.normals))) < 0.0
        strips.append(aligned(found, False, down))
    return strips


def normal_numbers(strips: Sequence[Strip]) -> Numbers:
    """How far the normals of the arch's passes are from the true ones."""
    away = np.concatenate(
        [
            arc_angles(found.normals, true.normals)
            for found, true in zip(strips, arch_passes(), strict=True)
        ]
    )
    return {
        "normal_rms_deg": float(np.degrees(np.sqrt(np.mean(away**2)))),
        "normal_max_deg": float(np.degrees(away.max())),
    }


def s_curve_tear(rule: FramingSettings, draws: int = 5) -> float:
    """The worst tear along the conormals between two noisy S-curves framed by a rule."""
    random = np.random.default_rng(4)
    worst = 0.0
    for _ in range(draws):
        jets = waved(-0.12, 0.05), waved(0.12, 0.035, 0.3)
        strips = [
            framed(jet.points + NOISE * random.normal(size=jet.points.shape), settings=rule)
            for jet in jets
        ]
        worst = max(worst, tear_ratio(laid_plainly(strips, "conormal", (1.0, 1.0)).points))
    return worst
