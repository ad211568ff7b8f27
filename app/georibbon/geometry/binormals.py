"""Normals for curves that come without any: from the way in which they bend.

A ribbon's curve is a geodesic, so its principal normal is the surface's normal,
up to a sign that changes at every inflection, and undetermined where the curve
is straight.  All rules here give the roll angle phi of the normal

    N = cos(phi) e1 + sin(phi) e2

in a frame that does not turn about the curve, so that N stays square to it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_lsq_spline

from georibbon.arrays import BoolArray, FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import cross, dot, minimising_frame, unit
from georibbon.geometry.frenet import continued
from georibbon.geometry.penalised import penalised_spline
from georibbon.geometry.settings import NormalRule
from georibbon.geometry.spherical import any_normal

STEPS = 3
GREATEST_STEP = 0.5  # radians a step towards no geodesic curvature
STRAIGHT = 0.05  # 1/m: a curvature that tells no normal
STRAIGHT_CUTS = 2.0
STRAIGHT_SHARES = 0.2, 0.5  # of the curve, at least so much and never more
PLACES_A_KNOT = 4
LEAST_TURN = 1e-6  # radians over the whole curve


@dataclass(frozen=True, eq=False)
class Bend:
    """How a curve bends, in a frame that does not turn about it.

    s: (n,) metres.  tangents, first, second: (n, 3) unit, right-handed.
    along, across: (n,) 1/m, the curvature vector's parts along first and second.
    """

    s: FloatArray
    tangents: FloatArray
    first: FloatArray
    second: FloatArray
    along: FloatArray
    across: FloatArray

    @property
    def curvature(self) -> FloatArray:
        """(n,) 1/m, not negative."""
        return np.asarray(np.hypot(self.along, self.across))

    def normals(self, roll: FloatArray) -> FloatArray:
        """(n, 3) unit normals of roll angles (n,), radians."""
        return np.asarray(np.cos(roll)[:, None] * self.first + np.sin(roll)[:, None] * self.second)

    def roll(self, normals: FloatArray) -> FloatArray:
        """(n,) radians, without jumps: the roll angles of normals (n, 3)."""
        return np.unwrap(np.arctan2(dot(normals, self.second), dot(normals, self.first)))


def bend_of(s: FloatArray, points: FloatArray, tangents: FloatArray, bent: FloatArray) -> Bend:
    """The bend of a curve.

    s: (n,) metres.  points: (n, 3) metres.  tangents: (n, 3) unit.  bent:
    (n, 3) 1/m, curvature vectors.
    """
    first = minimising_frame(points, tangents, any_normal(tangents[0]))
    second = cross(tangents, first)
    return Bend(s, tangents, first, second, dot(bent, first), dot(bent, second))


def normals_from_bend(bend: Bend, rule: NormalRule, cut: float) -> FloatArray:
    """(n, 3) unit normals, square to the tangents, by one of the rules.

    doubled-angle: see `doubled_angle`.  spline: the binormals, continued from
    place to place and smoothed by a least squares B-spline, `cut` metres from
    knot to knot.  continuous: the principal normals, each on the side of the
    one before it.  raw: the principal normals as they are.  Where the curve is
    straight they take the nearest roll.  All have one sign free.  With a cut of
    0 the first two are the third.
    Raises SurfaceError for a curve that is straight from end to end.
    """
    require_bent(bend)
    smooths = cut > 0.0 or rule == "raw"
    return RULES[rule if smooths else "continuous"](bend, cut)


def require_bent(bend: Bend) -> None:
    """Raise SurfaceError for a curve that bends nowhere."""
    if float(np.ptp(bend.s)) * float(bend.curvature.max()) < LEAST_TURN:
        raise SurfaceError(
            "it is straight from end to end, which tells no normal: give measured normals for it"
        )


def doubled_angle(bend: Bend, cut: float) -> FloatArray:
    """(n,) roll angles, radians: the side of the bend, whatever its sign, smoothed over `cut`.

    With k1, k2 the curvature vector's parts, z = (k1 + i k2)² = kappa² e^(2 i phi)
    is the same on both sides of an inflection.  z / |z| is smoothed with the
    weights |z| and halved; then Gauss and Newton's steps towards no geodesic
    curvature kg = sin(phi) k1 - cos(phi) k2, whose rate is kn = cos(phi) k1 +
    sin(phi) k2, with the weights kn².  Over a straight stretch phi turns
    as smoothly as it can, beyond the last bend evenly.
    """
    square = (bend.along + 1j * bend.across) ** 2
    size = np.abs(square)
    side = np.divide(square, size, out=np.zeros_like(square), where=size > 0.0)
    pairs = np.stack([side.real, side.imag], axis=1)
    smooth = penalised_spline(bend.s, pairs, cut, size / size.mean())(bend.s)
    roll = 0.5 * np.unwrap(np.arctan2(smooth[:, 1], smooth[:, 0]))
    for _ in range(STEPS):
        sine, cosine = np.sin(roll), np.cos(roll)
        geodesic = sine * bend.along - cosine * bend.across
        normal = cosine * bend.along + sine * bend.across
        step = np.divide(geodesic, normal, out=np.zeros_like(normal), where=normal != 0.0)
        target = roll - np.clip(step, -GREATEST_STEP, GREATEST_STEP)
        weights = normal**2 / size.mean()
        roll = penalised_spline(bend.s, target, cut, weights)(bend.s)
    return roll


def _doubled(bend: Bend, cut: float) -> FloatArray:
    return bend.normals(doubled_angle(bend, cut))


def _raw(bend: Bend, _cut: float) -> FloatArray:
    told = np.flatnonzero(bend.curvature > 0.0)
    middles = 0.5 * (bend.s[told[1:]] + bend.s[told[:-1]])
    nearest = told[np.searchsorted(middles, bend.s)]
    return bend.normals(np.arctan2(bend.across, bend.along)[nearest])


def _continuous(bend: Bend, cut: float) -> FloatArray:
    return continued(_raw(bend, cut))


def _spline(bend: Bend, cut: float) -> FloatArray:
    binormals = cross(bend.tangents, _continuous(bend, cut))
    smooth = least_squares(bend.s, binormals, cut)
    return unit(cross(smooth, bend.tangents))


RULES: dict[NormalRule, Callable[[Bend, float], FloatArray]] = {
    "doubled-angle": _doubled,
    "spline": _spline,
    "continuous": _continuous,
    "raw": _raw,
}


def least_squares(s: FloatArray, values: FloatArray, spacing: float) -> FloatArray:
    """(n, c) values smoothed by the cubic B-spline with knots `spacing` apart nearest to them.

    s: (n,) metres, ascending, n >= 4.  A knot is left out where fewer than four
    places would lie on either side of it up to the next.
    """
    count = int(np.clip(np.ceil((s[-1] - s[0]) / spacing), 1, len(s) // PLACES_A_KNOT))
    inner, last = [], 0
    for knot in np.linspace(s[0], s[-1], count + 1)[1:-1]:
        at = int(np.searchsorted(s, knot))
        if min(at - last, len(s) - at) >= PLACES_A_KNOT:
            inner.append(float(knot))
            last = at
    knots = np.concatenate([np.repeat(s[0], 4), inner, np.repeat(s[-1], 4)])
    return np.asarray(make_lsq_spline(s, values, knots, k=3)(s))


def straight_stretches(bend: Bend, cut: float) -> tuple[tuple[float, float], ...]:
    """(from, to) metres of every stretch that is too straight, too long, to tell normals.

    The curvature, smoothed over `cut` metres (0: as it is), is below 0.05 1/m
    there, over more than two cuts and a fifth of the curve, or over half of it.
    """
    parts = np.stack([bend.along, bend.across], axis=1)
    if cut > 0.0:
        parts = penalised_spline(bend.s, parts, cut)(bend.s)
    least = float(np.clip(STRAIGHT_CUTS * cut, *(np.ptp(bend.s) * np.array(STRAIGHT_SHARES))))
    ends = runs(np.hypot(parts[:, 0], parts[:, 1]) < STRAIGHT)
    found = [(float(bend.s[first]), float(bend.s[last])) for first, last in ends]
    return tuple((a, b) for a, b in found if b - a > least)


def runs(flags: BoolArray) -> list[tuple[int, int]]:
    """The first and last index of every run of flags that are true."""
    padded = np.concatenate([[False], flags, [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]
