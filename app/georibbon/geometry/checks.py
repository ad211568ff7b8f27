"""What a built surface says of itself: drift, seams, folds, tears, skew, gaps.

Every check has a verdict, the value found and a sentence with advice.  The
limits are engineering choices that fit measurements on many surfaces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.interpolate import BSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.correspondence import PairMatch
from georibbon.geometry.crossings import crossing_triangles
from georibbon.geometry.frames import arc_angles, unit
from georibbon.geometry.frenet import continuity
from georibbon.geometry.mesh import Mesh, grid_mesh
from georibbon.geometry.patch import Patches, PatchGrid, PatchSet
from georibbon.geometry.rails import PINCHED, sampled
from georibbon.geometry.scheme import Found

Verdict = Literal["pass", "warn", "fail"]

DRIFT_SIGMAS = (3.0, 6.0)
DRIFT_WITHOUT_SIGMA = np.radians(1.0)
SEAM_LIMIT = 0.05
FOLD_LIMITS = (0.3, 0.0)
TEAR_LIMITS = (3.0, 8.0)
PINCH_LIMIT = 5e-3
SKEW_LIMIT = 0.8
TURN_LIMIT = 60.0
DIRECTION_LIMITS = (60.0, 90.0)
GAP_LIMIT = 2.0
OVERLAP_LIMIT = 0.5
UNSETTLED_LIMIT = 0.01
CROSSING_ROWS = 25
CROSSING_STEP = 2


@dataclass(frozen=True)
class Check:
    """One self-check of the built surface.

    code: a stable word, such as "fold", "gap", "normal-turn", "heading-drift";
    verdict: "pass", "warn" or "fail"; value: what was found, in `unit`;
    message: the sentence for the person, with advice where it is not a pass.
    where: which pass or pair of passes, such as "P2" or "P2-P3".
    """

    code: str
    verdict: Verdict
    value: float
    unit: str
    where: str
    message: str


def graded(value: float, warn: float, fail: float) -> Verdict:
    """The verdict on a value that should stay small."""
    return "fail" if value > fail else "warn" if value > warn else "pass"


def all_checks(
    model: PatchSet,
    names: Sequence[str],
    patches: Patches,
    grid: PatchGrid,
    frame_sigma: Sequence[FloatArray] | None,
) -> tuple[Check, ...]:
    """All checks of a surface.

    names and frame_sigma (radians, (n,) each) are in the model's order across;
    patches: the model sampled along the passes; grid: the same, v from 0 to 1.
    """
    pairs = [pair_name(a, b) for a, b in pairwise(names)]
    expected = [None] * len(names) if frame_sigma is None else [rms(f) for f in frame_sigma]
    found = [
        heading_drift(spline, ends, sigma, name)
        for spline, ends, sigma, name in zip(
            model.splines, ends_of(model), expected, names, strict=True
        )
    ]
    found += [
        facing(bool(flip), name)
        for flip, name in zip(model.arrangement.flipped, names, strict=True)
    ]
    found += [seam(grid, i, name) for i, name in enumerate(names[1:-1])]
    for test in (fold, tear):
        found += [test(grid, i, pair) for i, pair in enumerate(pairs)]
    for measure in (directions, pinch, skew, normal_turn, gap):
        found += [measure(patches, i, pair) for i, pair in enumerate(pairs)]
    if model.match.rule in {"foot-cover", "foot-trim"}:
        found += [overlap(one, pair) for one, pair in zip(model.match.matches, pairs, strict=True)]
    if model.scheme.found is not None:
        found += [tangent_lengths(model.scheme.found, i, pair) for i, pair in enumerate(pairs)]
    return (*found, self_crossing(grid, pairs))


def ends_of(model: PatchSet) -> list[FloatArray]:
    """(2,) metres, the first and last place of every pass, matched or not."""
    return [strip.s[[0, -1]] for strip in model.arrangement.strips]


def pair_name(a: str, b: str) -> str:
    """The name of the patch between two passes: "P2-P3", the lower name first."""
    return "-".join(sorted((a, b), key=lambda name: (len(name), name)))


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values * values)))


def heading_drift(spline: BSpline, ends: FloatArray, frame_sigma: float | None, name: str) -> Check:
    """How far a pass turns within the surface: the integral of its geodesic curvature.

    kg = f'' . V on the interpolated curve; zero for a ribbon, which cannot bend
    in its own plane.  Its expected spread is that of the difference of two
    frames, sqrt(2) frame_sigma (radians); where that is not known, a degree
    counts as three of it.
    """
    s = np.linspace(ends[0], ends[1], 4 * len(spline.t))
    _, frames = sampled(spline, s)
    turning = np.sum(spline(s, nu=2)[:, :3] * frames[:, :, 1], axis=1)
    drift = abs(float(np.sum(0.5 * (turning[1:] + turning[:-1]) * np.diff(s))))
    spread = np.sqrt(2.0) * frame_sigma if frame_sigma is not None else DRIFT_WITHOUT_SIGMA / 3.0
    limits = [max(factor * spread, np.radians(0.05)) for factor in DRIFT_SIGMAS]
    verdict = graded(drift, *limits)
    message = (
        f"{name} turns by {np.degrees(drift):.2f}° within the built surface, where a ribbon cannot "
        f"turn (up to {np.degrees(limits[0]):.2f}° is expected)"
    )
    if verdict != "pass":
        message += (
            ": lay it flat again without pulling it sideways, or fit it by the ribbon method, "
            "which holds it to what a ribbon can do; of a curve from elsewhere, look for points "
            "that lie beside it"
        )
    return Check("heading-drift", verdict, float(np.degrees(drift)), "°", name, message)


def facing(flipped: bool, name: str) -> Check:
    """Whether a pass's normals faced the side that most passes' did."""
    if not flipped:
        message = f"{name} faces the same side as the other passes"
        return Check("facing", "pass", 0.0, "°", name, message)
    message = (
        f"{name} faced the other side than its neighbours and was turned over: "
        "check that the ribbon did not lie upside down"
    )
    return Check("facing", "warn", 180.0, "°", name, message)


def seam(grid: PatchGrid, i: int, name: str) -> Check:
    """The angle between the normals of the two patches that meet at an inner pass."""
    left = np.cross(grid.along[i, :, -1], grid.across[i, :, -1])
    right = np.cross(grid.along[i + 1, :, 0], grid.across[i + 1, :, 0])
    angle = float(np.degrees(arc_angles(left, right).max()))
    verdict = graded(angle, SEAM_LIMIT, 1.0)
    message = f"the surface's normals agree within {angle:.4f}° on both sides of {name}"
    if verdict != "pass":
        message += (
            f", {SEAM_LIMIT}° at most is expected: the patches beside it meet in a crease; "
            "check this pass's order and position among its neighbours"
        )
    return Check("seam", verdict, angle, "°", name, message)


def fold(grid: PatchGrid, i: int, pair: str) -> Check:
    """Whether the patch folds over: the least J = (F_u x F_v) . N / (|F_u| |F_v|)."""
    turn = grid.turn[i]
    least, folded = float(turn.min()), float(np.mean(turn <= FOLD_LIMITS[1]))
    verdict = graded(-least, -FOLD_LIMITS[0], -FOLD_LIMITS[1] - 1e-12)
    message = f"the surface between {pair} lies without a fold"
    if verdict == "warn":
        message = (
            f"the surface between {pair} is close to folding over: "
            "lay a pass in between or start both passes level with each other"
        )
    if verdict == "fail":
        message = (
            f"the surface between {pair} folds over on {100.0 * folded:.2f} % of the patch: "
            "check the order and the places of these passes, or lay a pass in between"
        )
    return Check("fold", verdict, least, "", pair, message)


def tear(grid: PatchGrid, i: int, pair: str) -> Check:
    """How far the patch is drawn out along the passes: |F_u| over that of its two passes."""
    speed = np.sqrt(np.sum(grid.along[i] ** 2, axis=-1))
    passes = np.maximum(speed[:, :1], speed[:, -1:])
    ratio = float(np.max(speed / passes))
    verdict = graded(ratio, *TEAR_LIMITS)
    message = (
        f"the surface between {pair} is drawn out {ratio:.2f} times as far as its passes at most"
    )
    if verdict != "pass":
        message += (
            f", {TEAR_LIMITS[0]:.0f} at most is expected; it tears where its passes' "
            "normals change suddenly; check these passes' sensors or lay a pass in between"
        )
    return Check("tear", verdict, ratio, "", pair, message)


def directions(patches: Patches, i: int, pair: str) -> Check:
    """How far the lines across turn from one place to the next where they leave and arrive."""
    apart = patches.rails.gaps[i] >= PINCHED
    ends = [unit(patches.control[i, apart, row]) for row in (1, -2)]
    turns = [continuity(one).greatest_turn for one in ends if len(one) > 1]
    angle = float(np.degrees(max(turns, default=0.0)))
    verdict = graded(angle, *DIRECTION_LIMITS)
    message = f"the lines across {pair} turn by up to {angle:.0f}° from one place to the next"
    if verdict != "pass":
        message += (
            f", {DIRECTION_LIMITS[0]:.0f}° at most is expected, or the surface tears there: "
            "choose the safe chord as their direction, or look at these passes' normals"
        )
    return Check("directions", verdict, angle, "°", pair, message)


def pinch(patches: Patches, i: int, pair: str) -> Check:
    """Whether two neighbours touch or cross: the least distance, and the side it is on."""
    least = float(patches.rails.gaps[i].min())
    chords = np.diff(patches.rails.points[i : i + 2], axis=0)[0]
    sides = np.sum(chords * patches.rails.frames[i, :, :, 1], axis=-1)
    if (sides < 0.0).any():
        share = 100.0 * float(np.mean(sides < 0.0))
        message = (
            f"{pair} cross or change sides over {share:.0f} % of their length: "
            "lay them side by side, or name one of them a tie"
        )
        return Check("crossing", "fail", least * 1e3, "mm", pair, message)
    verdict = graded(-least, -PINCH_LIMIT, np.inf)
    message = f"{pair} stay at least {1e3 * least:.1f} mm apart"
    if verdict != "pass":
        message += (
            f", {1e3 * PINCH_LIMIT:.0f} mm is the least that is useful: leave one of them out"
        )
    return Check("pinch", verdict, least * 1e3, "mm", pair, message)


def skew(patches: Patches, i: int, pair: str) -> Check:
    """How obliquely matched points lie across from each other: greatest |c . tau|."""
    length = np.maximum(patches.rails.gaps[i], 1e-12)
    tangents = patches.rails.frames[i : i + 2, :, :, 0]
    chords = np.diff(patches.rails.points[i : i + 2], axis=0)[0]
    along = np.abs(np.sum(chords * tangents, axis=-1)) / length
    value = float(along.max())
    verdict = graded(value, SKEW_LIMIT, np.inf)
    message = f"points of {pair} lie across from each other within {oblique(value):.0f}°"
    if verdict != "pass":
        message += (
            f", {oblique(SKEW_LIMIT):.0f}° at most is expected: one pass reaches far beyond the "
            "other; start and end neighbouring passes level with each other"
        )
    return Check("skew", verdict, value, "", pair, message)


def oblique(value: float) -> float:
    """Degrees of an angle whose sine is given."""
    return float(np.degrees(np.arcsin(min(value, 1.0))))


def normal_turn(patches: Patches, i: int, pair: str) -> Check:
    """The greatest angle between matched normals of two neighbours."""
    normals = patches.rails.frames[i : i + 2, :, :, 2]
    angle = float(np.degrees(arc_angles(normals[0], normals[1]).max()))
    verdict = graded(angle, TURN_LIMIT, 120.0)
    message = f"the normals turn by up to {angle:.0f}° between {pair}"
    if verdict != "pass":
        message += f", {TURN_LIMIT:.0f}° at most can be bridged well: lay a pass in between"
    return Check("normal-turn", verdict, angle, "°", pair, message)


def gap(patches: Patches, i: int, pair: str) -> Check:
    """The mean distance of two neighbours over the median of all neighbours."""
    means = patches.mean_gaps
    typical = float(np.median(means))
    ratio = float(means[i]) / typical if typical > 0.0 else 1.0
    verdict = graded(ratio, GAP_LIMIT, np.inf)
    message = f"{pair} lie {1e3 * means[i]:.0f} mm apart"
    if verdict != "pass":
        message += f", {ratio:.1f} times what is usual here: a pass may be missing between them"
    return Check("gap", verdict, ratio, "", pair, message)


def overlap(match: PairMatch, pair: str) -> Check:
    """The share of the shorter of two neighbours that lies across from the other."""
    message = f"{pair} lie across from each other over {100.0 * match.overlap:.0f} % of the shorter"
    if match.by_feet and match.overlap >= OVERLAP_LIMIT:
        return Check("overlap", "pass", match.overlap, "", pair, message)
    if match.by_feet:
        message += ": start and end neighbouring passes level with each other"
    else:
        message += (
            ", and their points do not follow each other side by side, so equal shares of their "
            "lengths were matched: check their order and places, or lay them side by side"
        )
    return Check("overlap", "warn", match.overlap, "", pair, message)


def tangent_lengths(found: Found, i: int, pair: str) -> Check:
    """At what share of a patch's lines the criterion chosen found no proper minimum."""
    unsettled, bounded = float(found.unsettled[i]), float(found.bounded[i])
    value = 100.0 * max(unsettled, bounded)
    verdict = graded(value, 100.0 * UNSETTLED_LIMIT, np.inf)
    what = "tangent lengths" if found.logs is not None else "directions"
    message = f"the {what} between {pair} minimise the criterion chosen"
    if value > 0.0:
        message += (
            f"; {100.0 * unsettled:.0f} % did not settle and {100.0 * bounded:.0f} % lie at the "
            "bounds"
        )
    if verdict != "pass":
        message += ": choose those of an arc"
    return Check("tangent-lengths", verdict, value, "%", pair, message)


def self_crossing(grid: PatchGrid, pairs: Sequence[str]) -> Check:
    """Whether patches run through each other, tried on a coarse mesh of them all."""
    mesh, columns = coarse_mesh(grid)
    crossing = crossing_triangles(mesh)
    if len(crossing) == 0:
        message = "the surface does not run through itself"
        return Check("self-crossing", "pass", 0.0, "", "surface", message)
    patch = crossing // 2 % (columns * len(pairs)) // columns
    one, other = (pairs[k] for k in np.unique(np.sort(patch, axis=1), axis=0)[0])
    both = f"between {one}" if one == other else f"between {one} and that between {other}"
    message = (
        f"the surface {both} runs through itself ({len(crossing)} pairs of triangles on a coarse "
        "mesh): check the order and the places of these passes, or lay a pass in between"
    )
    return Check("self-crossing", "fail", float(len(crossing)), "", one, message)


def coarse_mesh(grid: PatchGrid) -> tuple[Mesh, int]:
    """A mesh of all patches of at most 25 rows, and its columns a patch."""
    rows = np.unique(np.linspace(0, grid.points.shape[1] - 1, CROSSING_ROWS).astype(int))
    points = grid.points[:, rows][:, :, ::CROSSING_STEP]
    facing = grid.reference[:, rows][:, :, ::CROSSING_STEP]
    joined = [
        np.concatenate([values[0, :, :1], *values[:, :, 1:]], axis=1) for values in (points, facing)
    ]
    return grid_mesh(joined[0], joined[1]), points.shape[2] - 1
