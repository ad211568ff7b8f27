"""Where two curves on a surface meet, and whether one surface can hold both.

Two geodesics of one surface that cross at the angle alpha (from the first to
the second, counter-clockwise about the common normal) see the same shape
operator.  It is self-adjoint, dN(tau1) . tau2 = dN(tau2) . tau1, so that with
normal curvatures k = -N'.tau and geodesic torsions t = N'.V

    (t1 + t2) sin alpha = (k1 - k2) cos alpha.

For a geodesic k and t are, up to sign, its curvature and torsion: this is the
local one of the two conditions of Farouki, Szafran and Biard (Existence
conditions for Coons patches interpolating geodesic boundary curves, Computer
Aided Geometric Design 26, 2009) for a surface twice differentiable at the
crossing.  The global one is that the normals along all curves are those of
one oriented surface: equal at the crossings, continuous in between.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.edges import Along, Edge
from georibbon.geometry.frames import arc_angles

STEPS = 12
SETTLED = 1e-12  # m


@dataclass(frozen=True)
class Corner:
    """Two curves at their crossing.

    angle: radians, from the first tangent to the second, counter-clockwise about
    the first's normal, -pi to pi.  side: 1 where both normals face the same side,
    else -1; the second's are then turned over for what follows.  normals: radians
    between the two normals.  residual: 1/m, dN(tau1).tau2 - dN(tau2).tau1, zero on
    a smooth surface.
    """

    angle: float
    side: float
    normals: float
    residual: float


@dataclass(frozen=True)
class Meeting:
    """Where two curves come closest.

    places: metres along the first and the second.  miss: metres between them
    there.
    corner: the two curves there.
    """

    places: tuple[float, float]
    miss: float
    corner: Corner


def corner_of(first: Along, second: Along) -> Corner:
    """Two curves, each at one place, at their crossing."""
    tau, across, normal = first.frames[0].T
    other, _, facing = second.frames[0].T
    side = 1.0 if normal @ facing >= 0.0 else -1.0
    turn, other_turn = first.turns[0, :, 2], side * second.turns[0, :, 2]
    return Corner(
        angle=float(np.arctan2(other @ across, other @ tau)),
        side=side,
        normals=float(arc_angles(normal, side * facing)),
        residual=float(turn @ other - other_turn @ tau),
    )


def meeting(one: Edge, other: Edge) -> Meeting:
    """Where two edges come closest, between their ends, by Newton's method."""
    ends = [sorted((edge.first, edge.last)) for edge in (one, other)]
    low, high = np.array(ends).T
    at: FloatArray = nearest_places(one, other)
    for _ in range(STEPS):
        step = closing_step(one, other, at)
        new: FloatArray = np.clip(at + step, low, high)
        moved, at = float(np.abs(new - at).max()), new
        if moved < SETTLED:
            break
    here, there = one.at(at[:1]), other.at(at[1:])
    miss = float(np.linalg.norm(there.points[0] - here.points[0]))
    return Meeting((float(at[0]), float(at[1])), miss, corner_of(here, there))


def nearest_places(one: Edge, other: Edge) -> FloatArray:
    """(2,) metres: the nearest two of places on either edge, as dense as their knots."""
    places = [np.linspace(edge.first, edge.last, len(edge.spline.t)) for edge in (one, other)]
    a, b = (edge.spline(s)[:, :3] for edge, s in zip((one, other), places, strict=True))
    apart = np.sum((a[:, None] - b[None]) ** 2, axis=2)
    i, j = np.unravel_index(int(np.argmin(apart)), apart.shape)
    return np.array([places[0][i], places[1][j]])


def closing_step(one: Edge, other: Edge, at: FloatArray) -> FloatArray:
    """(2,) metres: the Gauss-Newton step of both places towards each other."""
    x, y = one.spline(at[0])[:3], other.spline(at[1])[:3]
    slopes = np.stack([one.spline(at[0], nu=1)[:3], -other.spline(at[1], nu=1)[:3]], axis=1)
    return np.asarray(np.linalg.lstsq(slopes, y - x)[0], dtype=np.float64)
