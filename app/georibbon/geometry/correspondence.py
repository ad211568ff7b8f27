"""Which point of a pass lies across from which point of its neighbour.

Points X_a(s) and X_b(t) of two strips are matched where they are each other's
feet, symmetrically:

    (X_b(t) - X_a(s)) . (tau_a(s) + tau_b(t)) = 0

Beyond the stretch where the strips overlap, the match is bent so that both
strips are covered to their ends, or both are cut there.  In the place of feet,
equal arc lengths from the beginning or equal fractions of the lengths can be
matched.  Over many passes the matches are chained outward from the middle
pass, so that all patches share one parameter.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from georibbon.arrays import BoolArray, FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip, unit
from georibbon.geometry.settings import CorrespondenceRule

IndexArray = NDArray[np.intp]

SLOPE_FLOOR = 0.2
NEWTON_STEPS = 3
END_SLACK = 1e-6
LEAST_OVERLAP = 0.1
MOST_NODES = 256  # of a strip, tried at once
CHUNK = 4096  # of a strip's points, as many at once
MOST_PRODUCTS = 1 << 22  # of points, at once


def match_feet(
    points_a: FloatArray,
    tangents_a: FloatArray,
    s_a: FloatArray,
    points_b: FloatArray,
    tangents_b: FloatArray,
    s_b: FloatArray,
    at: FloatArray,
) -> tuple[FloatArray, BoolArray]:
    """For each place on strip a the place across from it on strip b.

    points: (n, 3) metres; tangents: (n, 3) unit; s: (n,) metres, ascending, of
    either strip (the two may differ in n).  at: (k,) metres along a.

    Returns t (k,), metres along b, with (X_b(t) - X_a(at)) . (tau_a + tau_b) = 0,
    and valid (k,), False where no such place lies on b or `at` lies outside a
    (t is then b's nearest node).  Of several solutions the nearest is taken.
    Both strips must run in about the same direction.
    """
    here, ahead, _ = hermite(points_a, tangents_a, s_a, at)
    k, valid = bracketed(here, ahead, points_b, tangents_b)
    low, high = s_b[k], s_b[k + 1]
    t = 0.5 * (low + high)
    for _ in range(NEWTON_STEPS):
        x, slope, bend = hermite(points_b, tangents_b, s_b, t, k)
        both, chord = ahead + slope, x - here
        gap = np.sum(chord * both, axis=1)
        rate = np.sum(slope * both + chord * bend, axis=1)
        t = np.clip(t - gap / np.maximum(rate, SLOPE_FLOOR), low, high)
    return t, valid & (at >= s_a[0] - END_SLACK) & (at <= s_a[-1] + END_SLACK)


def bracketed(
    here: FloatArray, ahead: FloatArray, points: FloatArray, tangents: FloatArray
) -> tuple[IndexArray, BoolArray]:
    """For each point (k, 3) with its tangent the nearest interval of a strip that holds its foot.

    Returns the interval's first node (k,) and whether there is one; where there
    is none, an interval near the strip's nearest node.  Of many nodes some are tried
    first, and the interval between two of them halved.
    """
    last = len(points) - 1
    nodes = np.append(np.arange(0, last, -(-last // MOST_NODES)), last)
    parts = [slice(first, first + CHUNK) for first in range(0, len(here), CHUNK)]
    found = [crossed(here[i], ahead[i], points[nodes], tangents[nodes]) for i in parts]
    k, valid = (np.concatenate(one) for one in zip(*found, strict=True))
    low, high = nodes[k], nodes[k + 1]
    while (high - low > 1).any():
        middle = (low + high) // 2
        both, chord = ahead + tangents[middle], points[middle] - here
        beyond = np.sum(chord * both, axis=1) > 0.0
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return low, valid


def crossed(
    here: FloatArray, ahead: FloatArray, points: FloatArray, tangents: FloatArray
) -> tuple[IndexArray, BoolArray]:
    """The same among all nodes; where no interval holds the foot, that at the nearest node."""
    gap = (
        ahead @ points.T
        - here @ tangents.T
        + np.sum(points * tangents, axis=1)
        - np.sum(here * ahead, axis=1)[:, None]
    )
    gap[:, 0] -= END_SLACK
    gap[:, -1] += END_SLACK
    distance = np.sum(points * points, axis=1) - 2.0 * (here @ points.T)
    crossing = (gap[:, :-1] <= 0.0) & (gap[:, 1:] > 0.0)
    valid = crossing.any(axis=1)
    score = np.where(crossing | ~valid[:, None], distance[:, :-1] + distance[:, 1:], np.inf)
    return np.argmin(score, axis=1), valid


def hermite(
    points: FloatArray,
    tangents: FloatArray,
    s: FloatArray,
    at: FloatArray,
    k: IndexArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points, first and second derivatives, each (k, 3), of the cubic Hermite curve.

    points (n, 3), unit tangents (n, 3) at s (n,); at: (k,); k: the intervals
    they lie in, where known.
    """
    if k is None:
        k = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    h = (s[k + 1] - s[k])[:, None]
    v = (at - s[k])[:, None] / h
    start, end = points[k], points[k + 1]
    leave, arrive = h * tangents[k], h * tangents[k + 1]
    square = 3.0 * (end - start) - 2.0 * leave - arrive
    cube = leave + arrive - 2.0 * (end - start)
    x = start + v * (leave + v * (square + v * cube))
    first = (leave + v * (2.0 * square + 3.0 * v * cube)) / h
    second = (2.0 * square + 6.0 * v * cube) / (h * h)
    return x, first, second


def feet(a: Strip, b: Strip, at: FloatArray) -> tuple[FloatArray, BoolArray]:
    """`match_feet` on two strips."""
    return match_feet(a.points, a.tangents, a.s, b.points, b.tangents, b.s, at)


@dataclass(frozen=True, eq=False)
class PairMatch:
    """The places of two neighbouring strips that lie across from each other.

    a, b: (m,) metres, both strictly ascending, from end to end of either strip
    unless both are cut to where they overlap.
    overlap: the share of the shorter strip that truly has a foot on the other,
    or that is matched.  by_feet: False where feet were asked for, gave no
    one-to-one match, and equal fractions of the lengths were matched instead.
    """

    a: FloatArray
    b: FloatArray
    overlap: float
    by_feet: bool

    @cached_property
    def forward(self) -> CubicSpline | PchipInterpolator:
        """From places on a to those on b."""
        return ascending(self.a, self.b)

    @cached_property
    def backward(self) -> CubicSpline | PchipInterpolator:
        """From places on b to those on a."""
        return ascending(self.b, self.a)


def match_pair(a: Strip, b: Strip, rule: CorrespondenceRule = "foot-cover") -> PairMatch:
    """Match two strips that run the same way."""
    if rule == "fraction":
        return PairMatch(a.s[[0, -1]], b.s[[0, -1]], 1.0, True)
    if rule == "arc-length":
        common = np.array([0.0, min(a.s[-1] - a.s[0], b.s[-1] - b.s[0])])
        return PairMatch(a.s[0] + common, b.s[0] + common, 1.0, True)
    return match_by_feet(a, b, rule == "foot-cover")


def match_by_feet(a: Strip, b: Strip, cover: bool) -> PairMatch:
    """Match two strips by feet, covering both to their ends or cutting both to their overlap."""
    core = matched_core(a, b)
    if core is None:
        return PairMatch(a.s[[0, -1]], b.s[[0, -1]], 0.0, False)
    on_a, on_b = core
    shorter = min(a.s[-1] - a.s[0], b.s[-1] - b.s[0])
    overlap = min(on_a[-1] - on_a[0], on_b[-1] - on_b[0]) / shorter
    if overlap < LEAST_OVERLAP or (np.diff(on_a) <= 0.0).any() or (np.diff(on_b) <= 0.0).any():
        return PairMatch(a.s[[0, -1]], b.s[[0, -1]], float(max(overlap, 0.0)), False)
    on_a, on_b = refined(on_a, on_b)
    if not cover:
        return PairMatch(on_a, on_b, float(overlap), True)
    along = 0.5 * (on_a + on_b)
    covered_a = covering(along, on_a, a.s[0], a.s[-1])
    covered_b = covering(along, on_b, b.s[0], b.s[-1])
    return PairMatch(covered_a, covered_b, float(overlap), True)


def matched_core(a: Strip, b: Strip) -> tuple[FloatArray, FloatArray] | None:
    """The matched places (m,), (m,) where both strips overlap; None where they do not."""
    ends_a, ends_b = a.s[[0, -1]], b.s[[0, -1]]
    on_b, a_has_foot = feet(a, b, ends_a)
    on_a, b_has_foot = feet(b, a, ends_b)
    if not (a_has_foot | b_has_foot).all():
        return None
    low, high = np.where(a_has_foot, ends_a, on_a)
    inside = a.s[(a.s > low) & (a.s < high)]
    at = np.concatenate([[low], inside, [high]])
    t, valid = feet(a, b, at)
    t[[0, -1]] = np.where(a_has_foot, on_b, ends_b)
    valid[[0, -1]] = True
    apart = np.concatenate([[True], np.diff(at) > END_SLACK])
    keep = valid & apart
    return (at[keep], t[keep]) if valid.all() else None


def refined(on_a: FloatArray, on_b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same match (m,), (m,) four times as densely, so that it can be bent smoothly."""
    number = np.arange(len(on_a))
    dense = np.interp(np.linspace(0, number[-1], 4 * number[-1] + 1), number, on_a)
    return dense, ascending(on_a, on_b)(dense)


def covering(along: FloatArray, places: FloatArray, start: float, end: float) -> FloatArray:
    """(m,) the matched places of one strip, bent at both ends so that they reach its ends.

    A leftover length l is absorbed by l (1 - t)³(1 + 3t) with t = x / min(5/2 l,
    half the overlap), x the distance `along` (m,) from the overlap's end; the places
    stay ascending.
    """
    half = 0.5 * (along[-1] - along[0])
    bent = places - absorbed(places[0] - start, along - along[0], half)
    bent = bent + absorbed(end - places[-1], along[-1] - along, half)
    bent[0], bent[-1] = start, end
    return bent


def absorbed(leftover: float, x: FloatArray, half: float) -> FloatArray:
    """(m,) how much of a leftover length is added at distances x (m,) from the end."""
    if leftover <= 0.0:
        return np.zeros_like(x)
    t = np.minimum(x / min(2.5 * leftover, half), 1.0)
    share: FloatArray = leftover * (1.0 - t) ** 3 * (1.0 + 3.0 * t)
    return share


@dataclass(frozen=True, eq=False)
class Correspondence:
    """One parameter for all strips: the arc length u of the middle one.

    ends: (2,) metres, the first and last matched place of each strip, in order
    across.  matches: one for each pair of neighbours.  middle: which strip
    gives u.  rule: how they were matched.
    """

    ends: tuple[FloatArray, ...]
    matches: tuple[PairMatch, ...]
    middle: int
    rule: CorrespondenceRule = "foot-cover"

    def __call__(self, u: FloatArray) -> FloatArray:
        """(p, k) metres along each of the p strips at the parameters u (k,)."""
        rows = {self.middle: u}
        for i in range(self.middle, len(self.matches)):
            rows[i + 1] = np.clip(self.matches[i].forward(rows[i]), *self.ends[i + 1])
        for i in range(self.middle - 1, -1, -1):
            rows[i] = np.clip(self.matches[i].backward(rows[i + 1]), *self.ends[i])
        return np.stack([rows[i] for i in range(len(rows))])

    def with_rates(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(p, k) metres along each strip at the parameters u (k,), and their derivatives by u."""
        rows, rates = {self.middle: u}, {self.middle: np.ones_like(u)}
        for i in range(self.middle, len(self.matches)):
            onward = self.matches[i].forward
            rows[i + 1] = np.clip(onward(rows[i]), *self.ends[i + 1])
            rates[i + 1] = onward(rows[i], 1) * rates[i]
        for i in range(self.middle - 1, -1, -1):
            onward = self.matches[i].backward
            rows[i] = np.clip(onward(rows[i + 1]), *self.ends[i])
            rates[i] = onward(rows[i + 1], 1) * rates[i + 1]
        order = range(len(rows))
        return np.stack([rows[i] for i in order]), np.stack([rates[i] for i in order])


def ascending(source: FloatArray, target: FloatArray) -> CubicSpline | PchipInterpolator:
    """A strictly ascending curve through (source, target), both (m,) and ascending.

    The twice differentiable cubic spline where it ascends, else the monotone
    piecewise cubic.
    """
    spline = CubicSpline(source, target)
    return spline if ascends(spline) else PchipInterpolator(source, target)


def ascends(spline: CubicSpline) -> bool:
    """Whether a cubic spline's derivative 3 a x² + 2 b x + c is positive throughout."""
    a, b, c = spline.c[:3]
    width = np.diff(spline.x)
    turning = np.clip(-b / np.where(a == 0.0, 1.0, 3.0 * a), 0.0, width)
    places = np.stack([np.zeros_like(width), turning, width])
    return bool((3.0 * a * places**2 + 2.0 * b * places + c > 0.0).all())


def correspond(strips: Sequence[Strip], rule: CorrespondenceRule = "foot-cover") -> Correspondence:
    """Match all neighbours among strips that are in order across and run the same way.

    Raises SurfaceError where strips cut to where they overlap have nothing in common.
    """
    matches = tuple(match_pair(a, b, rule) for a, b in pairwise(strips))
    ends = tuple(strip.s[[0, -1]] for strip in strips)
    whole = Correspondence(ends, matches, (len(strips) - 1) // 2, rule)
    return whole if rule in {"foot-cover", "fraction"} else cut_to_common(whole)


def cut_to_common(whole: Correspondence) -> Correspondence:
    """The correspondence over the parameters at which every strip is matched.

    The interval that all matches so far have in common is carried outward from
    the middle strip, cut at every match, and its ends are carried back.
    """
    middle, last = whole.middle, len(whole.matches)
    low, high = whole.ends[middle]
    for outward in (range(middle, last), range(middle - 1, -1, -1)):
        way = [
            (one.a, one.forward, one.b, one.backward)
            if i >= middle
            else (one.b, one.backward, one.a, one.forward)
            for i, one in ((i, whole.matches[i]) for i in outward)
        ]
        reached = whole.ends[middle]
        for here, onward, _, _ in way:
            reached = onward(np.clip(reached, here[0], here[-1]))
        for _, _, there, back in reversed(way):
            reached = back(np.clip(reached, there[0], there[-1]))
        low, high = max(low, reached[0]), min(high, reached[1])
    length = whole.ends[middle][1] - whole.ends[middle][0]
    if high - low < LEAST_OVERLAP * length:
        raise SurfaceError(
            f"cut to where they overlap, the passes have {1e3 * max(high - low, 0.0):.0f} mm in "
            f"common, at least a tenth of a pass, {1e2 * length:.0f} mm, is needed: cover them to "
            "their ends, or start neighbouring passes level with each other"
        )
    span = np.array([low, high])
    places = whole(span)
    places[middle] = span
    return replace(whole, ends=tuple(places))


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Passes put in order across the surface, all run and facing the same way.

    order: for each place across, which pass lies there.  strips: in that
    order, turned where needed.  turned: those run backwards; flipped: those
    whose normal had to be negated, both as places in `order`.
    """

    order: tuple[int, ...]
    strips: tuple[Strip, ...]
    turned: BoolArray
    flipped: BoolArray


def order_passes(strips: Sequence[Strip]) -> tuple[int, ...]:
    """The order in which passes lie across the surface, however they are numbered or run.

    The distance of two passes is the mean of the distances of either's middle
    to the other.  The shortest tree that joins all passes is walked from one
    end of its longest path to the other, so passes around a pipe come in order
    too.  Runs from the end whose pass has the lower number.
    """
    tree = shortest_tree(pass_distances(strips))
    far = walk(tree, 0)[1]
    order, other = walk(tree, far)
    if other < far:
        order, _ = walk(tree, other)
    return tuple(order)


def pass_distances(strips: Sequence[Strip]) -> FloatArray:
    """(p, p) metres between each two strips, measured from their middles."""
    middles = np.stack([strip.points[len(strip.s) // 2] for strip in strips])
    points = np.concatenate([strip.points for strip in strips])
    centre = points.mean(axis=0)
    middles, points = middles - centre, points - centre
    starts = np.cumsum([0] + [len(strip.s) for strip in strips[:-1]])
    squares, rows = np.sum(points * points, axis=1), max(MOST_PRODUCTS // len(points), 1)
    nearest = np.concatenate(
        [
            np.minimum.reduceat(squares - 2.0 * (some @ points.T), starts, axis=1)
            for some in (middles[i : i + rows] for i in range(0, len(middles), rows))
        ]
    )
    nearest += np.sum(middles**2, axis=1)[:, None]
    distance: FloatArray = np.sqrt(np.maximum(nearest, 0.0))
    return 0.5 * (distance + distance.T)


def shortest_tree(distance: FloatArray) -> list[list[tuple[float, int]]]:
    """For each of p nodes its neighbours (length, node) in the shortest tree (Prim)."""
    count = len(distance)
    tree: list[list[tuple[float, int]]] = [[] for _ in range(count)]
    best, parent = distance[0].copy(), np.zeros(count, dtype=int)
    outside = np.ones(count, dtype=bool)
    outside[0] = False
    for _ in range(count - 1):
        new = int(np.argmin(np.where(outside, best, np.inf)))
        outside[new] = False
        old, length = int(parent[new]), float(best[new])
        tree[new].append((length, old))
        tree[old].append((length, new))
        nearer = distance[new] < best
        best[nearer], parent[nearer] = distance[new][nearer], new
    return tree


def walk(tree: list[list[tuple[float, int]]], start: int) -> tuple[list[int], int]:
    """All nodes in the order of a walk from one of them, shorter edges first, and the farthest."""
    order: list[int] = []
    farthest, reach = start, 0.0
    waiting = [(0.0, start, -1)]
    while waiting:
        length, node, parent = waiting.pop()
        order.append(node)
        if length > reach:
            farthest, reach = node, length
        ahead = sorted(((step, child) for step, child in tree[node] if child != parent))
        waiting.extend((length + step, child, node) for step, child in reversed(ahead))
    return order, farthest


def arrange(strips: Sequence[Strip]) -> Arrangement:
    """Order passes across and make them run and face the same way.

    The first pass given keeps its direction.  Normals face as most of them did.
    The order runs along the conormals, so that tau x (towards the next) = N.
    """
    order = order_passes(strips)
    ordered = [strips[i] for i in order]
    turned, flipped = np.zeros(len(order), dtype=bool), np.zeros(len(order), dtype=bool)
    for i in range(1, len(order)):
        along, facing = agreement(ordered[i - 1], ordered[i])
        turned[i] = turned[i - 1] ^ (along < 0.0)
        flipped[i] = flipped[i - 1] ^ (facing < 0.0)
    turned ^= turned[order.index(0)]
    if 2 * np.count_nonzero(flipped) > len(order):
        flipped = ~flipped
    facing_strips = tuple(
        aligned(strip, bool(t), bool(f))
        for strip, t, f in zip(ordered, turned, flipped, strict=True)
    )
    if across(facing_strips) < 0.0:
        return Arrangement(order[::-1], facing_strips[::-1], turned[::-1], flipped[::-1])
    return Arrangement(order, facing_strips, turned, flipped)


def agreement(a: Strip, b: Strip) -> tuple[float, float]:
    """How far b runs, and faces, as a does: sums of tau.tau and N.N at nearest nodes.

    Where the surface bends round an edge between them, N.N says little; on an
    arc N_b is N_a mirrored across the chord, however far it turns, so the
    greater of both sums counts.
    """
    some = np.linspace(0, len(a.s) - 1, 9).astype(int)
    away = a.points[some, None] - b.points[None]
    near = np.argmin(np.sum(away * away, axis=2), axis=1)
    along = np.sum(a.tangents[some] * b.tangents[near])
    chords = unit(b.points[near] - a.points[some])
    normals = a.normals[some]
    mirrored = normals - 2.0 * np.sum(normals * chords, axis=1, keepdims=True) * chords
    facing = max(np.sum(side * b.normals[near]) for side in (normals, mirrored))
    return float(along), float(facing)


def aligned(strip: Strip, turned: bool, flipped: bool) -> Strip:
    """The strip run backwards, and faced the other way, where asked."""
    if turned:
        strip = strip.reversed()
    if flipped:
        strip = Strip(strip.s, strip.points, strip.frames * np.array([1.0, -1.0, -1.0]))
    return strip


def across(strips: Sequence[Strip]) -> float:
    """Metres that the strips' middles advance along the conormals, each to the next."""
    middles = np.stack([strip.points[len(strip.s) // 2] for strip in strips])
    conormals = np.stack([strip.conormals[len(strip.s) // 2] for strip in strips])
    return float(np.sum(np.diff(middles, axis=0) * (conormals[:-1] + conormals[1:])))
