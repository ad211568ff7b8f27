"""The whole surface as one bicubic B-spline surface within a tolerance.

The surface's lines across are followed pass by pass: in the parameter w across,
every pass lies on a knot, and between passes the lines are cubic Hermite pieces,
whose ends are the lines' own points and slopes.  Along the passes all their
control points are interpolated by one cubic spline.  So the surface is

    S(u, w) = sum_ij P_ij B_i(u) B_j(w)

non-rational, on clamped knots, twice differentiable along.  Across, where the
lines run on over the passes, it is continuously differentiable; where they
have a corner at a pass, the pass is a threefold knot, and the surface keeps its
tangent plane there, as the patches do.

Pieces across and spans along are halved where the measured deviation is more
than is allowed, so that no more control points are spent than are needed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import cross, dot, unit
from georibbon.geometry.patch import (
    Patches,
    PatchGrid,
    PatchSet,
    basis,
    lifted,
    natural_parameters,
    patch_grid,
    patches_at,
)
from georibbon.geometry.rails import PINCHED

DEGREE = 3
MOST_CONTROL_POINTS = 100_000
MOST_TURN = np.radians(1.0)
FIRST_SPANS = 4
ROUNDS = 24
SHARE = 0.4  # of what is allowed, for either direction by itself
MARGIN = 1.1  # of the claim over the largest deviation that was found between the places looked at
INSIDE = np.array([0.15, 0.325, 0.5, 0.675, 0.85])  # of a span or piece, where it is looked at
AT_ONCE = 200_000  # points
MOST_NATURAL = 2000
SLOWEST = 0.3  # of a line's speed in its parameter, at a pass
CORNER = 1e-6  # radians
LEAST_FOR_TURN = 2e-3  # m: shorter spans are not halved for the sake of normals
MOST_FOR_TURN = 8  # nor are lines cut into more pieces for it
FOLDED = 0.1  # of the patches' J, below which normals are not compared


@dataclass(frozen=True, eq=False)
class Target:
    """What is to be one spline: q pieces side by side, at parameters u along and t across.

    nodes: (n,) where it is worth looking, from the first u to the last.  widths:
    (q,) of the pieces, as they shall be in w.  smooth: (q-1,) whether lines run
    on from one piece into the next: then their slopes by w agree.  grid: at
    u (k,) and t (m,) between 0 and 1 points, derivatives by u or any other along the
    surface, and by t, each (q, k, m, 3).
    """

    nodes: FloatArray
    widths: FloatArray
    smooth: BoolArray
    grid: Callable[[FloatArray, FloatArray], PatchGrid]


@dataclass(frozen=True, eq=False)
class OneSpline:
    """One bicubic B-spline surface.

    control: (n, m, 3) metres.  knots: (n+4,) of u, metres along the middle pass,
    and (m+4,) of w, metres across, clamped.  seams: (q+1,) w of the passes.
    deviation: metres, that it lies within from what it stands for, measured
    between its knots with a tenth to spare.  turn: radians, the same of the
    normals, where there is a normal to compare.
    smooth: whether it is continuously differentiable everywhere.
    """

    control: FloatArray
    knots: tuple[FloatArray, FloatArray]
    seams: FloatArray
    deviation: float = field(default=np.inf)
    turn: float = field(default=np.inf)
    smooth: bool = True

    @property
    def count(self) -> tuple[int, int]:
        """How many control points it has along and across."""
        return self.control.shape[0], self.control.shape[1]

    def __call__(self, u: FloatArray, w: FloatArray, nu: int = 0, nw: int = 0) -> FloatArray:
        """(k, m, 3) its points on the grid of u (k,) and w (m,), or derivatives of order nu, nw.

        At a knot that is a corner, derivatives by w are those after it.
        """
        along = BSpline(self.knots[0], self.control, DEGREE)(u, nu=nu)
        across = BSpline(self.knots[1], np.swapaxes(along, 0, 1), DEGREE)(w, nu=nw)
        points: FloatArray = np.swapaxes(across, 0, 1)
        return points

    def on_pieces(self, u: FloatArray, t: FloatArray, nu: int = 0, nw: int = 0) -> FloatArray:
        """(q, k, m, 3) the same at the parts t (m,) of every piece between seams, u (k,).

        At a piece's end derivatives by w are those before it.
        """
        first, last = self.seams[:-1, None], self.seams[1:, None]
        w = (1.0 - t) * first + t * last
        w = np.where(w >= last, np.nextafter(last, first), w)
        found = self(u, w.ravel(), nu, nw).reshape(len(u), *w.shape, 3)
        return np.swapaxes(found, 0, 1)


def one_spline(
    model: PatchSet,
    tolerance: float,
    turn: float = MOST_TURN,
    most: int = MOST_CONTROL_POINTS,
) -> OneSpline:
    """The surface of the patches as one spline, nowhere farther from them than the tolerance.

    model: the passes and how the patches are laid between them (`Surface.plan`).
    tolerance: metres; turn: radians, what normals should differ by at most (at a crease of
    the surface they differ by more, which is told).  most: control points.
    Raises SurfaceError where that takes more control points than `most`.
    """
    return approximated(target_of(model), tolerance, turn, most)


# What it is to follow


def target_of(model: PatchSet) -> Target:
    """The patches, their lines run through so that slopes agree where lines run on over a pass."""
    natural = natural_parameters(model)
    sample = patches_at(model, natural)
    widths = np.maximum(sample.mean_gaps, PINCHED)
    smooth = running_on(sample, widths)

    def grid(u: FloatArray, t: FloatArray) -> PatchGrid:
        patches = patches_at(model, u)
        if smooth.any():
            return run_through(patches, paces(patches, widths, smooth), t)
        return run_evenly(patches, t)

    return Target(natural, widths, smooth, grid)


def end_slopes(patches: Patches) -> tuple[FloatArray, FloatArray]:
    """(p-1, k, 3) twice: F_v at either end of the lines across."""
    return patches.control[:, :, 1], patches.control[:, :, -2]


def running_on(patches: Patches, widths: FloatArray) -> BoolArray:
    """(p-2,) at which inner passes all lines run on without a corner, at about one speed.

    Nowhere, where ties steer the lines.
    """
    if patches.cells is not None:
        return np.zeros(len(widths) - 1, dtype=np.bool_)
    leave, arrive = (slope / widths[:, None, None] for slope in end_slopes(patches))
    before, after = arrive[:-1], leave[1:]
    angle = np.arctan2(_size(cross(before, after)), dot(before, after))
    slow, fast = np.sort([_size(before), _size(after)], axis=0)
    fit = (angle < CORNER) & (slow > SLOWEST * fast)
    return np.asarray(fit.all(axis=1))


def paces(patches: Patches, widths: FloatArray, smooth: BoolArray) -> FloatArray:
    """(p-1, k, 2) dv/dt at either end of the lines: 1, or what makes speeds by w agree."""
    speeds = np.stack([_size(slope) for slope in end_slopes(patches)], axis=-1)
    speeds /= widths[:, None, None]
    pace = np.ones_like(speeds)
    common = np.sqrt(speeds[:-1, :, 1] * speeds[1:, :, 0])
    pace[:-1, :, 1][smooth] = (common / np.maximum(speeds[:-1, :, 1], 1e-300))[smooth]
    pace[1:, :, 0][smooth] = (common / np.maximum(speeds[1:, :, 0], 1e-300))[smooth]
    return pace


def run_evenly(patches: Patches, t: FloatArray) -> PatchGrid:
    """All patches at v = t (m,), with what ties add to them."""
    normals = patches.rails.frames[..., 2]
    ends = normals[:-1], normals[1:]
    grid = patch_grid(patches.control, patches.slope, ends, t)
    for i in range(len(grid.points)):
        one = PatchGrid(grid.points[i], grid.along[i], grid.across[i], grid.reference[i])
        more = lifted(one, patches, i, t)
        grid.points[i], grid.along[i], grid.across[i] = more.points, more.along, more.across
    return grid


def run_through(patches: Patches, pace: FloatArray, t: FloatArray) -> PatchGrid:
    """The patches at v(t), the cubic from 0 to 1 that has the paces (p-1, k, 2) at its ends.

    t: (m,).  The derivative along is the patches' own by u at that v.
    """
    start, end = pace[..., :1], pace[..., 1:]
    v = ((start + end - 2.0) * t + 3.0 - 2.0 * start - end) * t * t + start * t
    rate = (3.0 * (start + end - 2.0) * t + 2.0 * (3.0 - 2.0 * start - end)) * t + start
    count = patches.control.shape[-2]
    flat = v.ravel()
    values, slopes = (basis(flat, nu, count).reshape(*v.shape, count) for nu in (0, 1))
    normals = patches.rails.frames[..., 2]
    share = v[..., None]
    reference = (1.0 - share) * normals[:-1, :, None] + share * normals[1:, :, None]
    across = rate[..., None] * (slopes @ patches.control)
    return PatchGrid(values @ patches.control, values @ patches.slope, across, unit(reference))


# How it is followed


def approximated(target: Target, tolerance: float, turn: float, most: int) -> OneSpline:
    """The spline that follows a target within a tolerance, metres.

    Its normals are within a turn, radians, too, where spans and pieces of a sensible
    size are enough for that: not at a crease.  Raises SurfaceError as `one_spline`.
    """
    nodes = np.linspace(target.nodes[0], target.nodes[-1], FIRST_SPANS + 1)
    counts = np.ones(len(target.widths), dtype=np.int64)
    limits = np.array([tolerance, turn]) / MARGIN
    for _ in range(ROUNDS):
        if len(nodes) * columns_of(counts, target.smooth) > most:
            break
        spline = interpolated(target, nodes, counts)
        pieces = worst_pieces(target, spline, nodes, counts)
        coarse = too_much(pieces, SHARE * limits, counts < MOST_FOR_TURN)
        wide = worst_columns(target, spline, nodes, counts) > SHARE * tolerance
        if not (coarse.any() or wide.any()):
            spans = worst_spans(target, spline, nodes, counts)
            wide = too_much(spans, limits, np.diff(nodes) > LEAST_FOR_TURN)
            if not wide.any():
                return claiming(spline, MARGIN * spans.max(axis=1))
        counts = np.where(coarse, 2 * counts, counts)
        middles = 0.5 * (nodes[:-1] + nodes[1:])
        nodes = np.sort(np.concatenate([nodes, middles[wide]]))
    raise SurfaceError(
        f"one spline within {1e3 * tolerance:g} mm of the surface needs more than {most} control "
        "points: choose a larger tolerance, or check the passes for jumps"
    )


def too_much(worst: FloatArray, limits: FloatArray, for_turn: BoolArray) -> BoolArray:
    """(n,) where deviation or, only where it counts, turn of (2, n) is beyond its limit."""
    return np.asarray((worst[0] > limits[0]) | ((worst[1] > limits[1]) & for_turn))


def columns_of(counts: IntArray, smooth: BoolArray) -> int:
    """How many control points across there are: two a piece, one more at each corner and end."""
    return int(2 * counts.sum() + np.count_nonzero(~smooth) + 2)


def interpolated(target: Target, nodes: FloatArray, counts: IntArray) -> OneSpline:
    """The spline through a target's lines at `nodes` (n,), cut into counts (q,) pieces each."""
    columns = np.concatenate(list(columns_at(target, nodes, counts)), axis=1)
    along = make_interp_spline(nodes, columns, k=DEGREE)
    seams = np.concatenate([[0.0], np.cumsum(target.widths)])
    knots = across_knots(seams, counts, target.smooth)
    return OneSpline(along.c, (along.t, knots), seams, smooth=bool(target.smooth.all()))


def columns_at(target: Target, u: FloatArray, counts: IntArray) -> Iterator[FloatArray]:
    """(k, c, 3) the lines' control points, first those of the first piece, then on."""
    corner = np.concatenate([[True], ~target.smooth, [True]])
    grids = {
        int(count): target.grid(u, np.arange(count + 1) / count) for count in np.unique(counts)
    }
    for i, count in enumerate(counts):
        grid = grids[int(count)]
        points, thirds = grid.points[i], grid.across[i] / (3.0 * count)
        if corner[i]:
            yield points[:, :1]
        inner = np.stack([points[:, :-1] + thirds[:, :-1], points[:, 1:] - thirds[:, 1:]], axis=2)
        yield inner.reshape(len(u), -1, 3)
    yield points[:, -1:]


def across_knots(seams: FloatArray, counts: IntArray, smooth: BoolArray) -> FloatArray:
    """The knots of w: each place twice, a corner three times, the ends four times."""
    places, times = [seams[:1]], [[DEGREE + 1]]
    last = [*(np.where(smooth, 2, 3)), DEGREE + 1]
    for i, count in enumerate(counts):
        share = np.arange(1, count + 1) / count
        places.append((1.0 - share) * seams[i] + share * seams[i + 1])
        times.append([2] * (int(count) - 1) + [int(last[i])])
    return np.repeat(np.concatenate(places), np.concatenate(times))


# How far it is from it


def worst_columns(
    target: Target, spline: OneSpline, nodes: FloatArray, counts: IntArray
) -> FloatArray:
    """(n-1,) metres: how far the lines' control points leave the target's in each span."""
    u = looked_at(target, nodes)
    worst = np.zeros(len(nodes) - 1)
    found = BSpline(spline.knots[0], spline.control, DEGREE)
    for part in parts_of(u, spline.count[1]):
        exact = np.concatenate(list(columns_at(target, u[part], counts)), axis=1)
        apart = _size(found(u[part]) - exact).max(axis=1)
        np.maximum.at(worst, spans_of(u[part], nodes), apart)
    return worst


def worst_spans(
    target: Target, spline: OneSpline, nodes: FloatArray, counts: IntArray
) -> FloatArray:
    """(2, n-1) the largest deviation and turn in each span, everywhere across."""
    u = np.union1d(looked_at(target, nodes), nodes)
    count = int(counts.max())
    t = np.union1d(((np.arange(count)[:, None] + INSIDE) / count).ravel(), [0.0, 1.0])
    worst = np.zeros((2, len(nodes) - 1))
    for part, found in compared(target, spline, u, t):
        for row, values in zip(worst, found, strict=True):
            np.maximum.at(row, spans_of(u[part], nodes), values.max(axis=(0, 2)))
    return worst


def spans_of(u: FloatArray, nodes: FloatArray) -> IntArray:
    """(k,) the spans between nodes (n,) that parameters u (k,) lie in."""
    return np.clip(np.searchsorted(nodes, u, side="right") - 1, 0, len(nodes) - 2).astype(np.int64)


def worst_pieces(
    target: Target, spline: OneSpline, nodes: FloatArray, counts: IntArray
) -> FloatArray:
    """(2, q) the largest deviation of the lines at the nodes in each piece, and their tilt.

    tilt: radians, of a line's slope out of the tangent plane.
    """
    worst = np.zeros((2, len(counts)))
    for count in np.unique(counts):
        t = ((np.arange(count)[:, None] + INSIDE) / count).ravel()
        here = counts == count
        for part in parts_of(nodes, len(counts) * len(t)):
            grid, u = target.grid(nodes[part], t), nodes[part]
            gaps = _size(spline.on_pieces(u, t) - grid.points)
            tilts = tilted(spline.on_pieces(u, t, nw=1), grid)
            found = np.stack([gaps, tilts]).max(axis=(2, 3))
            worst[:, here] = np.maximum(worst, found)[:, here]
    return worst


def claiming(spline: OneSpline, claim: FloatArray) -> OneSpline:
    """The spline with its claim: deviation and turn."""
    deviation, turn = float(claim[0]), min(float(claim[1]), np.pi)
    return OneSpline(spline.control, spline.knots, spline.seams, deviation, turn, spline.smooth)


def looked_at(target: Target, nodes: FloatArray) -> FloatArray:
    """Parameters between the nodes: in every span, and between all the target's own."""
    spans = nodes[:-1, None] + np.diff(nodes)[:, None] * INSIDE
    middles = 0.5 * (target.nodes[:-1] + target.nodes[1:])
    every = int(np.ceil(len(middles) / MOST_NATURAL))
    return np.union1d(spans.ravel(), middles[::every])


def parts_of(u: FloatArray, width: int) -> Iterator[slice]:
    """Parts of u that fit the memory, where each has so many points across."""
    step = max(AT_ONCE // width, 1)
    return (slice(start, start + step) for start in range(0, len(u), step))


def compared(
    target: Target, spline: OneSpline, u: FloatArray, t: FloatArray
) -> Iterator[tuple[slice, tuple[FloatArray, FloatArray]]]:
    """By parts of u: which, and the distances (metres) and turns (radians), each (q, k, m)."""
    for part in parts_of(u, len(target.widths) * len(t)):
        grid, at = target.grid(u[part], t), u[part]
        gaps = _size(spline.on_pieces(at, t) - grid.points)
        normals = cross(spline.on_pieces(at, t, nu=1), spline.on_pieces(at, t, nw=1))
        yield part, (gaps, turned(normals, grid))


def tilted(slopes: FloatArray, grid: PatchGrid) -> FloatArray:
    """(q, k, m) radians of slopes (q, k, m, 3) out of the tangent planes, 0 where there is none."""
    own = cross(grid.along, grid.across)
    angle = np.arctan2(np.abs(dot(slopes, own)), _size(cross(slopes, own)))
    return np.where(upright(grid), angle, 0.0)


def turned(normals: FloatArray, grid: PatchGrid) -> FloatArray:
    """(q, k, m) radians between normals (q, k, m, 3) and the target's, 0 where it has none."""
    own = cross(grid.along, grid.across)
    angle = np.arctan2(_size(cross(normals, own)), dot(normals, own))
    return np.where(upright(grid), angle, 0.0)


def upright(grid: PatchGrid) -> BoolArray:
    """(q, k, m) where a target has a normal: neither folded nor pinched."""
    return np.asarray((grid.turn > FOLDED) & (_size(grid.across) > PINCHED))


def _size(vectors: FloatArray) -> FloatArray:
    """(...) the lengths of vectors (..., 3)."""
    length: FloatArray = np.sqrt(dot(vectors, vectors))
    return length
