"""What a curve says of itself: Frenet's frame, curvature and torsion, inflections, Darboux's rates.

With K the curvature vector of a curve f, its second derivative by arc length,

    tau = f' / |f'|,    K = (f'' - (f''.tau) tau) / |f'|²,    kappa = |K|,
    n = K / kappa,      b = tau x n,      torsion = det(f', f'', f''') / |f' x f''|²

(do Carmo, Differential Geometry of Curves and Surfaces, 1-5).  A ribbon's curve
is a geodesic of its surface, so n is the surface's normal N or -N, and b is
-V or V, wherever kappa is not 0.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.frames import Strip, arc_angles, body_rates, cross, dot, unit
from georibbon.geometry.penalised import penalised_spline

STRAIGHT = 1e-9  # of the greatest curvature: no side can be told below it
DEGREE = 5


@dataclass(frozen=True, eq=False)
class Frenet:
    """A curve's frame of Frenet at n places; where it is straight, normals and binormals are 0.

    points, tangents, normals, binormals: (n, 3), metres and unit.  curvature:
    (n,) 1/m, not negative.  torsion: (n,) 1/m, positive for a right-handed
    screw; 0 where the curve is straight.
    """

    points: FloatArray
    tangents: FloatArray
    normals: FloatArray
    binormals: FloatArray
    curvature: FloatArray
    torsion: FloatArray


@dataclass(frozen=True, eq=False)
class DarbouxRates:
    """How a frame [tau, V, N] turns along its curve, (n,) each, 1/m.

    geodesic: kg = tau'.V, 0 for a ribbon; normal: kn = tau'.N; torsion:
    tg = N'.V.  The frame's own rotation a metre is (-tg, -kn, kg) about its axes.
    `georibbon.geometry.frames.curvatures` gives kn and -tg.
    """

    geodesic: FloatArray
    normal: FloatArray
    torsion: FloatArray


@dataclass(frozen=True, eq=False)
class Continuity:
    """How a field of directions runs along its curve.

    flips: (k,) the first places of neighbours more than 90 degrees apart.
    greatest_turn: radians between neighbours.
    """

    flips: IntArray
    greatest_turn: float


def curve_through(s: FloatArray, points: FloatArray, cut: float = 0.0) -> BSpline:
    """A spline of points (n, 3) at s (n,): through them, quintic, or smoothed over `cut` metres.

    Smoothed it has small third derivatives, so that it bends up to its ends.
    At least 4 points; fewer than 6 give a cubic.  Raises SurfaceError where s
    does not ascend.
    """
    if cut > 0.0:
        return penalised_spline(s, points, cut, order=3)
    return make_interp_spline(s, points, k=DEGREE if len(s) > DEGREE else 3)


def curvature_vectors(curve: BSpline, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit tangents (n, 3) and curvature vectors K (n, 3), 1/m, of a curve at s (n,)."""
    first, second = curve(s, nu=1), curve(s, nu=2)
    tangents = unit(first)
    bent = second - dot(second, tangents)[:, None] * tangents
    return tangents, bent / dot(first, first)[:, None]


def frenet(curve: BSpline, s: FloatArray) -> Frenet:
    """Frenet's frame of a curve at s (n,), which need not be its arc length."""
    tangents, bent = curvature_vectors(curve, s)
    curvature = np.sqrt(dot(bent, bent))
    normals = unit(bent)
    first, third = curve(s, nu=1), curve(s, nu=3)
    across = cross(first, curve(s, nu=2))
    square = dot(across, across)
    torsion = np.divide(dot(across, third), square, out=np.zeros_like(square), where=square > 0.0)
    return Frenet(curve(s), tangents, normals, cross(tangents, normals), curvature, torsion)


def darboux_rates(strip: Strip) -> DarbouxRates:
    """The rates of a strip of two points or more, from the turn from frame to frame.

    The logarithm of R_k^T R_k+1 over the step is right to second order in its
    middle; at a point the mean of both sides stands, at an end the one.
    """
    rates = body_rates(strip)
    return DarbouxRates(geodesic=rates[:, 2], normal=-rates[:, 1], torsion=-rates[:, 0])


def inflections(s: FloatArray, bent: FloatArray) -> FloatArray:
    """(k,) metres: where a curve changes the side to which it bends.

    s: (n,).  bent: (n, 3) its curvature vectors.  There it turns by more than
    90 degrees from one place to the next at which the curve bends at all; the
    place is where the straight line from the one vector to the other comes
    nearest to 0.
    """
    size = np.sqrt(dot(bent, bent))
    told = np.flatnonzero(size > STRAIGHT * size.max(initial=0.0))
    before, after = told[:-1], told[1:]
    opposed = dot(bent[before], bent[after]) < 0.0
    before, after = before[opposed], after[opposed]
    step = bent[after] - bent[before]
    share = -dot(bent[before], step) / dot(step, step)
    return np.asarray(s[before] + share * (s[after] - s[before]))


def continuity(directions: FloatArray) -> Continuity:
    """How directions (n, 3) along a curve run: where they turn back, and how far they turn."""
    along = dot(directions[:-1], directions[1:])
    turns = arc_angles(directions[:-1], directions[1:])
    return Continuity(np.flatnonzero(along < 0.0), float(turns.max(initial=0.0)))


def continued(directions: FloatArray) -> FloatArray:
    """(n, 3) directions, each reversed where needed to lie on the side of the one before it.

    The plain rule b_k . b_k-1 >= 0; a zero vector takes no side and changes none.
    """
    told = np.flatnonzero(dot(directions, directions) > 0.0)
    along = dot(directions[told[:-1]], directions[told[1:]])
    signs = np.ones(len(directions))
    signs[told[1:]] = np.cumprod(np.where(along < 0.0, -1.0, 1.0))
    return directions * signs[:, None]
