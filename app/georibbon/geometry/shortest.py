"""The shortest way between two points of a surface near by: a geodesic by its ends.

The energy n sum |X_{k+1} - X_k|² of a chain of n + 1 points of the surface with
fixed ends is least where the chain is a discrete geodesic with links equally
long; it differs from the geodesic by O(1/n²).  The unknowns are the surface's
parameters at the points between.  Newton's method with the whole Hessian, which
is block-tridiagonal, starts from a straight line of the parameters.  The
direction at the start is then corrected by shooting, so that the curve is the
geodesic itself and not the chain.

What is found is the shortest way among those near by: a surface may have
another, shorter one.  Which way around is meant where a parameter is periodic,
the ends tell: they may lie beyond its period.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, eig_banded, solveh_banded

from georibbon.arrays import FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip, dot, unit
from georibbon.geometry.geodesics import directions_at, trace
from georibbon.geometry.reference import Jet, ReferenceSurface

NODES = 100
MOST_STEPS, MOST_HALVINGS, MOST_SHOTS = 100, 30, 12
SETTLED = 1e-12  # of the box: so small a step ends Newton's method
ASIDE = 1e-3  # of the box: how far a chain is moved that is the longest near by
MET = 1e-10  # of the length: a shot that ends so near to the second point has met it
AROUND = 1e-3  # of the box: parameters farther off are those of another turn about it
TURNED = 1e-6  # radians between the two shots that tell how the end moves

NOT_FOUND = "choose nearer points, or a pass between them"


class Chain(NamedTuple):
    """A discrete geodesic: the n + 1 points from the first to the second.

    uv: (n + 1, 2) parameters; points: (n + 1, 3) metres; steps: how many of
    Newton's method it took.
    """

    uv: FloatArray
    points: FloatArray
    steps: int


def shortest_geodesic(
    surface: ReferenceSurface, start: FloatArray, end: FloatArray, samples: int = 121
) -> Strip:
    """The geodesic between two points of a surface that is the shortest near by.

    start, end: (2,) their parameters.  samples: of the strip, evenly spaced by
    arc length.  The second point is met to 1e-10 of the length.  Raises
    SurfaceError where the two are one point, where the way leaves the surface's
    box, and where none is found.
    """
    chain = shortest_chain(surface, start, end)
    length = float(np.linalg.norm(np.diff(chain.points, axis=0), axis=1).sum())
    angle = _angle(surface.jet(chain.uv[:1]), chain.points)
    places, box = np.stack([chain.uv[0], chain.uv[0]]), _box(surface)
    for _ in range(MOST_SHOTS):
        ahead = directions_at(surface, places, np.array([angle, angle + TURNED]))
        s = np.linspace(0.0, length, samples)
        paths, (strip, beside) = trace(surface, places, ahead, s)
        gap = chain.points[-1] - strip.points[-1]
        around = np.abs(paths[-1, 0] - chain.uv[-1]) > AROUND * box
        if np.linalg.norm(gap) <= MET * length and not around.any():
            return strip
        spread = dot(beside.points[-1] - strip.points[-1], strip.conormals[-1]) / TURNED
        length += float(dot(gap, strip.tangents[-1]))
        if abs(spread) < 1e-6 * s[-1] or not 0.0 < length <= 2.0 * s[-1]:
            break
        angle += float(dot(gap, strip.conormals[-1]) / spread)
    raise SurfaceError(
        f"the shortest way between the two points, about {s[-1]:.3f} m, is not found exactly: it "
        f"runs too near a tip of the surface, or is not the only one there; {NOT_FOUND}"
    )


def _angle(jet: Jet, points: FloatArray) -> float:
    """Radians from p_u about the normal to the direction in which a chain starts.

    By the parabola through its first three points.
    """
    ahead = 4.0 * points[1] - 3.0 * points[0] - points[2]
    e1 = unit(jet.pu[0])
    return float(np.arctan2(dot(ahead, np.cross(jet.normals[0], e1)), dot(ahead, e1)))


def shortest_chain(
    surface: ReferenceSurface, start: FloatArray, end: FloatArray, nodes: int = NODES
) -> Chain:
    """The chain of `nodes` links between two points of a surface whose energy is least.

    start, end: (2,) parameters.  Raises SurfaceError as `shortest_geodesic`.
    """
    box = _box(surface)
    uv = np.linspace(np.asarray(start, float), np.asarray(end, float), nodes + 1)
    jet = surface.jet(uv)
    if not np.linalg.norm(jet.p[-1] - jet.p[0]) > 1e-9 * np.ptp(jet.p, axis=0).max():
        raise SurfaceError("the two points are one, or no numbers: give two different ones")
    for count in range(1, MOST_STEPS + 1):
        step, convex = _newton_step(jet)
        settled = bool((np.abs(step) <= SETTLED * box).all())
        if settled and convex:
            _check_inside(surface, uv)
            return Chain(uv, jet.p, count)
        if settled:
            uv[1:-1] += ASIDE * box * _way_down(jet)
        else:
            uv = _descend(surface, uv, step, _energy(jet.p))
        jet = surface.jet(uv)
    raise SurfaceError(
        f"no shortest way between the two points is found within {MOST_STEPS} steps: {NOT_FOUND}"
    )


def _box(surface: ReferenceSurface) -> FloatArray:
    return np.subtract(surface.upper, surface.lower)


def _energy(points: FloatArray) -> float:
    links = np.diff(points, axis=0)
    return float(len(links) * np.sum(links * links))


def _bent(jet: Jet) -> FloatArray:
    """(n - 1, 3) by how much a chain bends at its inner points, 2 X_k - X_{k-1} - X_{k+1}."""
    return 2.0 * jet.p[1:-1] - jet.p[:-2] - jet.p[2:]


def _hessian(jet: Jet, whole: bool) -> FloatArray:
    """(4, 2 (n - 1)) half the energy's Hessian over n, its upper bands as LAPACK keeps them.

    whole: with the second derivatives of the surface; without them it is
    positive definite everywhere, and approximate.
    """
    tangents = np.stack([jet.pu, jet.pv], axis=1)
    inner = tangents[1:-1]
    same = 2.0 * np.einsum("kai,kbi->kab", inner, inner)
    if whole:
        bent = _bent(jet)
        mixed = dot(bent, jet.puv[1:-1])
        same[:, 0, 0] += dot(bent, jet.puu[1:-1])
        same[:, 1, 1] += dot(bent, jet.pvv[1:-1])
        same[:, 0, 1] += mixed
    bands = np.zeros((4, 2 * len(inner)))
    bands[3, 0::2], bands[3, 1::2], bands[2, 1::2] = same[:, 0, 0], same[:, 1, 1], same[:, 0, 1]
    next_ = -np.einsum("kai,kbi->kab", inner[:-1], inner[1:])
    bands[1, 2::2], bands[0, 3::2] = next_[:, 0, 0], next_[:, 0, 1]
    bands[2, 2::2], bands[1, 3::2] = next_[:, 1, 0], next_[:, 1, 1]
    return bands


def _newton_step(jet: Jet) -> tuple[FloatArray, bool]:
    """(n + 1, 2) the step to the least energy, and whether the energy is convex here."""
    bent = _bent(jet)
    downhill = -np.stack([dot(bent, jet.pu[1:-1]), dot(bent, jet.pv[1:-1])], axis=1)
    step = np.zeros((len(jet.p), 2))
    for whole in (True, False):
        try:
            found = solveh_banded(_hessian(jet, whole), downhill.ravel())
        except (LinAlgError, ValueError):
            continue
        step[1:-1] = found.reshape(-1, 2)
        return step, whole
    raise SurfaceError(
        "the way between the two points runs through a place where the surface's parameters are "
        f"singular, such as a pole: {NOT_FOUND}"
    )


def _way_down(jet: Jet) -> FloatArray:
    """(n - 1, 2) the direction in which the energy bends down most, its largest entry 1."""
    vector = eig_banded(_hessian(jet, True), select="i", select_range=(0, 0))[1][:, 0]
    return np.asarray(vector / np.abs(vector).max()).reshape(-1, 2)


def _descend(
    surface: ReferenceSurface, uv: FloatArray, step: FloatArray, before: float
) -> FloatArray:
    """uv moved by the largest of step, step/2, step/4, ... that does not raise the energy."""
    share = 1.0
    for _ in range(MOST_HALVINGS):
        moved = uv + share * step
        if _energy(surface.points(moved)) <= before * (1.0 + 1e-14):
            return moved
        share /= 2.0
    raise SurfaceError(
        f"the shortest way between the two points cannot be followed over this surface: {NOT_FOUND}"
    )


def _check_inside(surface: ReferenceSurface, uv: FloatArray) -> None:
    for k, period in enumerate(surface.periods):
        low, high = surface.lower[k], surface.upper[k]
        slack = 1e-9 * (high - low)
        if period == 0.0 and not (low - slack <= uv[:, k].min() <= uv[:, k].max() <= high + slack):
            raise SurfaceError(
                "the shortest way between the two points leaves the surface over its edge: "
                f"{NOT_FOUND}"
            )
