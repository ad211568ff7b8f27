"""Geodesics of reference surfaces, by the initial value problem.

With p'' along the normal alone, the parameters obey
(u'', v'') = -G^-1 (p_u . A, p_v . A), A = p_uu u'² + 2 p_uv u'v' + p_vv v'²,
G the first fundamental form (do Carmo, Differential Geometry of Curves and
Surfaces, 4-4).
"""

from collections.abc import Sequence
from itertools import count

import numpy as np
from scipy.integrate import solve_ivp

from georibbon.arrays import FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip, frames_from, unit
from georibbon.geometry.reference import Jet, ReferenceSurface

# Gentle surfaces need some hundreds; near a pole of the parameters no number is enough.
MOST_EVALUATIONS = 20_000


def tangent_rates(jet: Jet, directions: FloatArray) -> FloatArray:
    """The (n, 2) rates of (u, v) that move along tangent vectors `directions` (n, 3)."""
    a = np.stack([_dot(jet.pu, directions), _dot(jet.pv, directions)], axis=1)
    return _solve_metric(jet, a)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ij,ij->i", a, b), dtype=np.float64)


def _solve_metric(jet: Jet, a: FloatArray) -> FloatArray:
    """G^-1 a for each of n points; a: (n, 2)."""
    e, f, g = _dot(jet.pu, jet.pu), _dot(jet.pu, jet.pv), _dot(jet.pv, jet.pv)
    det = e * g - f * f
    x = (g * a[:, 0] - f * a[:, 1]) / det
    y = (e * a[:, 1] - f * a[:, 0]) / det
    return np.stack([x, y], axis=1)


def directions_at(surface: ReferenceSurface, uv: FloatArray, angles: FloatArray) -> FloatArray:
    """(n, 3) unit tangents at uv (n, 2), turned by `angles` (n,) from p_u about the normal."""
    jet = surface.jet(uv)
    e1 = unit(jet.pu)
    e2 = np.cross(jet.normals, e1)
    return np.asarray(np.cos(angles)[:, None] * e1 + np.sin(angles)[:, None] * e2)


def geodesics(
    surface: ReferenceSurface,
    uv: FloatArray,
    directions: FloatArray,
    s: FloatArray,
    tolerance: float = 1e-11,
) -> tuple[Strip, ...]:
    """The geodesics through n points of a surface, each with its frames.

    uv: (n, 2), the points; directions: (n, 3) tangent vectors there, of any
    length (made unit and tangent).  s: (m,) ascending signed distances from the
    points, metres, at which the curves are given; the strips' arc length starts
    at 0, where s is least.  All are integrated together (DOP853), to the
    relative `tolerance`.  Raises SurfaceError where they run through a singular
    place of the parameters, such as an ellipsoid's pole.
    """
    return trace(surface, uv, directions, s, tolerance)[1]


def trace(
    surface: ReferenceSurface,
    uv: FloatArray,
    directions: FloatArray,
    s: FloatArray,
    tolerance: float = 1e-11,
) -> tuple[FloatArray, tuple[Strip, ...]]:
    """As `geodesics`, with the parameters (m, n, 2) of the curves' points besides."""
    jet = surface.jet(uv)
    rates = tangent_rates(jet, directions)
    speed = np.linalg.norm(jet.pu * rates[:, :1] + jet.pv * rates[:, 1:], axis=1, keepdims=True)
    start = np.concatenate([uv, rates / speed], axis=1)
    after = _integrate(surface, start, s[s >= 0], tolerance)
    back = np.array([1.0, 1.0, -1.0, -1.0])
    before = _integrate(surface, start * back, -s[s < 0][::-1], tolerance) * back
    states = np.concatenate([before[::-1], after])
    strips = tuple(_strip(surface, states[:, k], s - s[0]) for k in range(len(uv)))
    return states[:, :, :2], strips


def geodesic(
    surface: ReferenceSurface, uv: Sequence[float], direction: Sequence[float], s: FloatArray
) -> Strip:
    """One geodesic: see `geodesics`."""
    return geodesics(surface, np.array([uv], float), np.array([direction], float), s)[0]


def _integrate(
    surface: ReferenceSurface, start: FloatArray, s: FloatArray, tolerance: float
) -> FloatArray:
    """(m, n, 4) states (u, v, u', v') at distances s (m,) >= 0, ascending."""
    if len(s) == 0:
        return np.empty((0, *start.shape))
    if s[-1] == 0:
        return np.repeat(start[None], len(s), axis=0)

    evaluations = count(1)

    def rate(at: float, flat: FloatArray) -> FloatArray:
        if next(evaluations) > MOST_EVALUATIONS:
            raise SurfaceError(
                f"the geodesics cannot be followed beyond {at:.3f} m: the surface bends too "
                "sharply there for them, or ends in a point; choose a gentler or a larger surface, "
                "or another place on it"
            )
        state = flat.reshape(start.shape)
        jet = surface.jet(state[:, :2])
        du, dv = state[:, 2:3], state[:, 3:4]
        bend = jet.puu * du**2 + 2 * jet.puv * du * dv + jet.pvv * dv**2
        return np.concatenate([state[:, 2:], -tangent_rates(jet, bend)], axis=1).ravel()

    found = solve_ivp(
        rate,
        (0.0, float(s[-1])),
        start.ravel(),
        "DOP853",
        t_eval=s,
        rtol=tolerance,
        atol=tolerance / 100,
    )
    return np.asarray(found.y.T.reshape(len(s), *start.shape), dtype=np.float64)


def _strip(surface: ReferenceSurface, states: FloatArray, s: FloatArray) -> Strip:
    jet = surface.jet(states[:, :2])
    tau = unit(jet.pu * states[:, 2:3] + jet.pv * states[:, 3:4])
    return Strip(s, jet.p, frames_from(tau, jet.normals))
