"""Which cells ties close between neighbouring passes, and how the surface takes them up.

A tie closes cells of a patch together with the next tie that crosses both its
passes.  It is taken up where it passes both by a few millimetres at most, not too
obliquely, and sees about the same normals.  Then it is brought onto the passes,
which stay as they are:

    its points by an offset that is cubic in v: the crossing's miss at either end,
    with such a slope that the tie leaves within the pass's tangent plane;
    its normals by a turn about its tangent, cubic in v: at either end the angle
    to the pass's normal, with such a slope that the tie's normals and the patch's
    cross derivative turn alike, so that the corner's twists agree even where the
    local condition (`georibbon.geometry.meetings`) does not hold for the curves
    as measured.

The formulas of what is added to the patches are in `georibbon.geometry.lifts`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.checks import Check, graded, pair_name
from georibbon.geometry.coons import AGREE_LIMITS, OBLIQUE_LIMIT, acute, corner_checks
from georibbon.geometry.edges import Edge, edge_of
from georibbon.geometry.frames import Strip, cross, dot, frames_from, unit
from georibbon.geometry.lifts import Cells, PatchLift
from georibbon.geometry.meetings import Meeting, meeting
from georibbon.geometry.patch import Lines, PatchSet, basis
from georibbon.geometry.rails import PINCHED, sampled_moving
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.slopes import control_with_slope

MISS_LIMIT = 5e-3  # m between tie and pass
SNAP_LIMIT = 2e-3  # m: more is told
OUT_OF_REACH = 0.05  # m: a tie that far from a pass was not meant to cross it
CUT_OFF = 1e-9  # m
LEAST_WIDTH = 0.01  # m between ties
NODES = 33
TABLE = 401
NEWTON_STEPS = 4
LEAST_RATE = 1e-3
SLOWEST, FASTEST = 0.2, 3.0  # of a tie's mean speed: it never turns back
FADE = 4.0  # times the distance to the next tie


@dataclass(frozen=True, eq=False)
class Crossing:
    """A tie across a pass: where they meet, and the parameter u there."""

    met: Meeting
    u: float


@dataclass(frozen=True, eq=False)
class Span:
    """A tie between two neighbouring passes.

    tie: its number.  edge: its curve.  start, end: its crossings with the two.
    """

    tie: int
    edge: Edge
    start: Crossing
    end: Crossing

    @property
    def crossings(self) -> tuple[float, float]:
        """The parameters u at both passes."""
        return self.start.u, self.end.u


def with_cells(
    model: PatchSet, names: Sequence[str], ties: Sequence[tuple[str, Strip]]
) -> tuple[PatchSet, tuple[Check, ...]]:
    """The model with the ties taken up where they close cells, and what was found there.

    It is the same model where they close none.
    names: of the model's passes, in its order.  ties: with their names, of four points or more.
    """
    tie_names = [name for name, _ in ties]
    edges = [edge_of(tie) for _, tie in ties]
    rows = zip(map(edge_of, model.arrangement.strips), names, model.match.ends, strict=True)
    met = [
        [found_at(tie, of, one, name, ends) for tie, of in zip(edges, tie_names, strict=True)]
        for one, name, ends in rows
    ]
    crossed = located(model, met)
    lifts: list[PatchLift | None] = []
    found: list[Check] = []
    for i, pair in enumerate(pairwise(names)):
        spans, reasons = spans_between(crossed[i : i + 2], edges, pair, tie_names)
        lift, snap = (None, 0.0) if len(spans) < 2 else lift_of(model, i, spans)
        lifts.append(lift)
        found += checks_of(spans, reasons, pair, tie_names, snap)
    if any(lift is not None for lift in lifts):
        model = replace(model, cells=Cells(tuple(lifts)))
    return model, tuple(found)


def no_cells(settings: SurfaceSettings) -> Check:
    """That cells were asked for and there can be none."""
    why = "no tie was captured: lay at least two across the passes, or ask for no cells"
    if not settings.uses_cells:
        why = f'the interior is "{settings.interior}": choose "g1", or ask for no cells'
    return Check("cells", "warn", 0.0, "", "surface", f"no cell is closed, as {why}")


def found_at(tie: Edge, tie_name: str, one: Edge, name: str, ends: FloatArray) -> Meeting | str:
    """Where a tie meets a pass; why not where it does not, nothing where it is far off.

    name: of the pass.  ends: (2,) metres, between which the pass is matched.
    """
    met = meeting(tie, one)
    if met.miss > MISS_LIMIT:
        far = met.miss > OUT_OF_REACH
        return "" if far else f"{tie_name} misses {name} by {1e3 * met.miss:.1f} mm"
    if acute(met.corner) < OBLIQUE_LIMIT:
        return f"{tie_name} crosses {name} at {acute(met.corner):.0f}°"
    if np.degrees(met.corner.normals) > AGREE_LIMITS[1]:
        angle = np.degrees(met.corner.normals)
        return f"{tie_name} sees normals {angle:.0f}° from those of {name}"
    if not ends[0] - CUT_OFF <= met.places[1] <= ends[1] + CUT_OFF:
        return f"{tie_name} crosses {name} where the surface is cut off"
    return met


def located(model: PatchSet, met: Sequence[Sequence[Meeting | str]]) -> list[list[Crossing | str]]:
    """For every pass and tie where they meet, with the parameter u there, or why they do not."""
    places = [
        (i, one.places[1]) for i, row in enumerate(met) for one in row if not isinstance(one, str)
    ]
    passes, s = np.array(places).reshape(-1, 2).T
    u = iter(parameters_of(model, passes.astype(np.int64), s).tolist())
    return [[one if isinstance(one, str) else Crossing(one, next(u)) for one in row] for row in met]


def parameters_of(model: PatchSet, passes: IntArray, s: FloatArray) -> FloatArray:
    """(n,) the common parameters u at places s (n,), metres, each on the pass of its number."""
    low, high = model.match.ends[model.match.middle]
    table = np.linspace(low, high, TABLE)
    places, at = model.match(table), np.arange(len(s))
    u = np.array([np.interp(one, places[i], table) for i, one in zip(passes, s, strict=True)])
    for _ in range(NEWTON_STEPS):
        reached, rates = (of[passes, at] for of in model.match.with_rates(u))
        u = np.clip(u + (s - reached) / np.maximum(rates, LEAST_RATE), low, high)
    return u


def spans_between(
    crossed: Sequence[Sequence[Crossing | str]],
    edges: Sequence[Edge],
    pair: tuple[str, str],
    tie_names: Sequence[str],
) -> tuple[list[Span], list[str]]:
    """The ties that cross both passes of a pair, in the order of u, and why others do not.

    crossed: of either pass, for every tie.
    """
    spans, reasons = [], []
    for k, (edge, *ends) in enumerate(zip(edges, *crossed, strict=True)):
        found = span_of(k, edge, ends, (tie_names[k], *pair))
        if isinstance(found, Span):
            spans.append(found)
        elif found:
            reasons.append(found)
    spans.sort(key=lambda span: sum(span.crossings))
    kept: list[Span] = []
    for span in spans:
        gaps = np.subtract(span.crossings, kept[-1].crossings) if kept else np.ones(2)
        if gaps.min() < LEAST_WIDTH:
            reasons.append(f"{tie_names[span.tie]} crosses {tie_names[kept[-1].tie]} or lies on it")
        else:
            kept.append(span)
    return kept, reasons


def span_of(
    tie: int, edge: Edge, ends: Sequence[Crossing | str], names: tuple[str, str, str]
) -> Span | str:
    """A tie between the two passes of a pair; why it is none, nothing where it is far off.

    ends: its crossings with both, or why there are none.  names: the tie's and theirs.
    """
    start, end = ends
    if isinstance(start, Crossing) and isinstance(end, Crossing):
        span = Span(tie, edge, start, end)
        return unfit(span, *names) or span
    whys = [one for one in ends if isinstance(one, str) and one]
    return whys[0] if whys else ""


def unfit(span: Span, tie: str, first: str, second: str) -> str:
    """Why a tie that crosses two passes can still close no cell; nothing where it can."""
    if abs(span.end.met.places[0] - span.start.met.places[0]) < PINCHED:
        return f"{tie} crosses {first} and {second} where they touch"
    if span.start.met.corner.side != span.end.met.corner.side:
        return f"{tie} turns over between {first} and {second}"
    return ""


def checks_of(
    spans: Sequence[Span],
    reasons: Sequence[str],
    pair: tuple[str, str],
    tie_names: Sequence[str],
    snap: float,
) -> list[Check]:
    """What is told of the cells of one pair: how many, and the worst of their corners."""
    where = pair_name(*pair)
    if len(spans) < 2:
        why = "; ".join(reasons) or "two ties that cross both are needed"
        message = f"no cell is closed between {where}: {why}; the patch between the passes stands"
        return [Check("cells", "warn", 0.0, "", where, message)]
    corners = [
        corner_checks(at.met.corner, pair_name(tie_names[span.tie], name))
        for span in spans
        for at, name in zip((span.start, span.end), pair, strict=True)
    ]
    angles, normals, twists = zip(*corners, strict=True)
    return [
        cells_closed(spans, reasons, where, tie_names, snap),
        min(angles, key=lambda one: one.value),
        max(normals, key=lambda one: one.value),
        max(twists, key=lambda one: one.value),
    ]


def cells_closed(
    spans: Sequence[Span],
    reasons: Sequence[str],
    where: str,
    tie_names: Sequence[str],
    snap: float,
) -> Check:
    """How many cells two ties or more close between a pair, and how far they were moved."""
    cells, ties = len(spans) - 1, ", ".join(tie_names[span.tie] for span in spans)
    message = (
        f"{ties} close {cells} cell{'s' if cells > 1 else ''} between {where}, brought onto the "
        f"passes by {1e3 * snap:.2f} mm at most"
    )
    if snap > SNAP_LIMIT:
        message += (
            f"; {1e3 * SNAP_LIMIT:.0f} mm at most is expected: "
            "give the places where ties cross passes in the survey"
        )
    if reasons:
        message += f"; left out: {'; '.join(reasons)}"
    verdict = "warn" if reasons else graded(snap, SNAP_LIMIT, np.inf)
    return Check("cells", verdict, float(cells), "", where, message)


def lift_of(model: PatchSet, i: int, spans: Sequence[Span]) -> tuple[PatchLift, float]:
    """What the ties add to the i-th patch, and by how much they were moved at most, metres."""
    crossings = np.array([span.crossings for span in spans])
    gaps = np.diff(crossings, axis=0).min(axis=1)
    reach = FADE * float(gaps[0]), FADE * float(gaps[-1])
    v = np.linspace(0.0, 1.0, NODES)
    blank = CubicSpline(v, np.zeros((NODES, len(spans), 2, 3)))
    plain = PatchLift(crossings, reach, np.zeros((len(spans), 2, 2)), blank)
    curves = snapped(model, i, spans)
    steered = replace(plain, steer=np.stack([curve.steer for curve in curves]))
    parts = parts_of(model, i, steered, v, curves)
    parts[[0, -1]] = 0.0
    moved = max(curve.moved for curve in curves)
    return replace(steered, parts=CubicSpline(v, parts, bc_type="clamped")), moved


def pair_lines(model: PatchSet, i: int, u: FloatArray, lift: PatchLift | None = None) -> Lines:
    """The lines across of the i-th patch alone at u (k,), steered into ties by a lift."""
    pair = slice(i, i + 2)
    places, rates = model.match.with_rates(u)
    rails, moving = sampled_moving(model.splines[pair], places[pair], rates[pair])
    steer = None if lift is None else Cells((lift,)).steered
    control, slope = control_with_slope(rails, moving, model.scheme.of_patch(i), u, steer)
    return Lines(rails, control, slope)


@dataclass(frozen=True, eq=False)
class Snapped:
    """A tie between two passes as a curve of v, from 0 to 1, brought onto them.

    span: the tie.  places: (4,) Hermite coefficients of its place s(v).  offsets:
    (4, 3) those of what is added to its points.  steer: (2, 2) metres: what it
    asks of F_v at both ends beyond the patch's own, along V and tau.
    """

    span: Span
    places: FloatArray
    offsets: FloatArray
    steer: FloatArray

    @property
    def moved(self) -> float:
        """Metres, the greater of the offsets at its ends."""
        return float(np.linalg.norm(self.offsets[[0, 3]], axis=1).max())

    def at(self, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points, derivatives by v and unit normals, measured but square to them: (m, 3) each."""
        value, rate = basis(v), basis(v, 1)
        here = self.span.edge.at(value @ self.places)
        points = here.points + value @ self.offsets
        slopes = here.slopes * (rate @ self.places)[:, None] + rate @ self.offsets
        return points, slopes, frames_from(unit(slopes), here.normals)[:, :, 2]


def snapped(model: PatchSet, i: int, spans: Sequence[Span]) -> list[Snapped]:
    """Ties brought onto the i-th pass and the next, with what they ask of F_v there.

    The lines U(v) are straight; a tie's speed at its ends is that of the patch
    along its line, so that only directions and offsets differ.
    """
    crossings = np.array([span.crossings for span in spans])
    lines = pair_lines(model, i, crossings.ravel())
    ends = np.tile([0, 1], len(spans))
    at = np.arange(len(ends))
    frames = lines.rails.frames[ends, at].reshape(-1, 2, 3, 3)
    points = lines.rails.points[ends, at].reshape(-1, 2, 3)
    along = lines.slope[0, at, 3 * ends].reshape(-1, 2, 3) * np.diff(crossings, axis=1)[..., None]
    own = along + lines.control[0, at, 1 + ends].reshape(-1, 2, 3)
    return [brought(*one) for one in zip(spans, points, frames, own, strict=True)]


def brought(span: Span, points: FloatArray, frames: FloatArray, own: FloatArray) -> Snapped:
    """A tie brought onto two passes.

    points (2, 3), frames (2, 3, 3): the passes at the crossings.  own: (2, 3)
    metres, the patch's change by v there along the tie's line.
    """
    ends = np.array([at.met.places[0] for at in (span.start, span.end)])
    length = ends[1] - ends[0]
    speed = np.clip(np.sqrt(dot(own, own)), SLOWEST * abs(length), FASTEST * abs(length))
    speed *= np.sign(length)
    here = span.edge.at(ends)
    slopes = here.slopes * speed[:, None]
    upright = -dot(slopes, frames[..., 2])[:, None] * frames[..., 2]
    offsets = points - here.points
    lacking = slopes + upright - own
    return Snapped(
        span,
        np.array([ends[0], *speed, ends[1]]),
        np.stack([offsets[0], *upright, offsets[1]]),
        np.stack([dot(lacking, frames[..., 1]), dot(lacking, frames[..., 0])], axis=1),
    )


def parts_of(
    model: PatchSet, i: int, lift: PatchLift, v: FloatArray, curves: Sequence[Snapped]
) -> FloatArray:
    """(m, T, 2, 3) A and B of all ties of the i-th patch at v (m,).

    lift: what steers the patch into the ties.
    """
    first, last = lift.crossings.T[..., None]
    lines = pair_lines(model, i, (first + (last - first) * v).ravel(), lift)
    functions = basis(v)[:, :, None]
    shape = len(curves), len(v), 4, 3
    bare = np.sum(functions * lines.control[0].reshape(shape), axis=2)
    along = np.sum(functions * lines.slope[0].reshape(shape), axis=2)
    parts = [part_of(*one, v) for one in zip(curves, bare, along, strict=True)]
    return np.stack(parts, axis=1)


def part_of(curve: Snapped, bare: FloatArray, along: FloatArray, v: FloatArray) -> FloatArray:
    """(m, 2, 3) A and B of one tie at v (m,), where the patch has these points and P1_u (m, 3)."""
    points, slopes, upright = curve.at(v)
    aside = cross(unit(slopes), upright)
    # By which turn about the tie its measured normal becomes the patch's: at the ends the pass's.
    turn = -np.arctan(dot(along, upright) / dot(along, aside))
    rates = CubicSpline(v, turn)(v[[0, -1]], nu=1)
    angle = (basis(v) @ np.array([turn[0], *rates, turn[-1]]))[:, None]
    normals = np.cos(angle) * upright + np.sin(angle) * aside
    return np.stack([points - bare, -dot(along, normals)[:, None] * normals], axis=1)
