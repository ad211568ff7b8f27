"""The points of a reference surface closest to given ones."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from georibbon.arrays import FloatArray
from georibbon.geometry.reference import Jet, ReferenceSurface


class ClosestPoints(NamedTuple):
    """The points of a surface closest to n given ones.

    uv: (n, 2) parameters; points: (n, 3) metres; distance: (n,) metres, signed,
    positive outside.
    """

    uv: FloatArray
    points: FloatArray
    distance: FloatArray


def closest_point(
    surface: ReferenceSurface, points: FloatArray, grid: int = 200, iterations: int = 60
) -> ClosestPoints:
    """The points of a surface closest to `points` (n, 3), metres.

    From the nearest of a grid of `grid` by `grid` points, by Newton's method
    with the true Hessian of |p(u, v) - x|² / 2 where that is positive definite,
    else its Gauss-Newton part, each step halved while the distance grows.
    """
    target = np.asarray(points, dtype=np.float64)
    uv = _nearest_on_grid(surface, target, grid)
    active = np.arange(len(target))
    for _ in range(iterations):
        step = _newton_step(surface.jet(uv[active]), target[active])
        uv[active] = _descend(surface, uv[active], step, target[active])
        moved = np.abs(step).max(axis=1) > 1e-13
        active = active[moved]
        if len(active) == 0:
            break
    jet = surface.jet(uv)
    gap = target - jet.p
    side = np.einsum("ij,ij->i", gap, jet.normals)
    return ClosestPoints(uv, jet.p, np.copysign(np.linalg.norm(gap, axis=1), side))


def _nearest_on_grid(surface: ReferenceSurface, target: FloatArray, grid: int) -> FloatArray:
    u = np.linspace(surface.lower[0], surface.upper[0], grid)
    v = np.linspace(surface.lower[1], surface.upper[1], grid)
    nodes = np.stack(np.meshgrid(u, v, indexing="ij"), axis=2).reshape(-1, 2)
    nearest = cKDTree(surface.points(nodes)).query(target)[1]
    return np.asarray(nodes[nearest], dtype=np.float64)


def _newton_step(jet: Jet, target: FloatArray) -> FloatArray:
    """(n, 2) the step that would end at the minimum of a quadratic."""
    gap = jet.p - target

    def dot(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("ij,ij->i", a, b))

    gu, gv = dot(jet.pu, gap), dot(jet.pv, gap)
    e, f, g = dot(jet.pu, jet.pu), dot(jet.pu, jet.pv), dot(jet.pv, jet.pv)
    huu, huv, hvv = e + dot(jet.puu, gap), f + dot(jet.puv, gap), g + dot(jet.pvv, gap)
    convex = (huu > 0) & (huu * hvv - huv**2 > 1e-6 * e * g)
    huu, huv, hvv = np.where(convex, huu, e), np.where(convex, huv, f), np.where(convex, hvv, g)
    det = huu * hvv - huv**2
    return np.stack([huv * gv - hvv * gu, huv * gu - huu * gv], axis=1) / det[:, None]


def _descend(
    surface: ReferenceSurface, uv: FloatArray, step: FloatArray, target: FloatArray
) -> FloatArray:
    """uv moved by the largest of step, step/2, step/4, ... that does not move away."""
    before = np.linalg.norm(surface.points(uv) - target, axis=1)
    share = np.ones((len(uv), 1))
    for _ in range(12):
        after = np.linalg.norm(surface.points(uv + share * step) - target, axis=1)
        worse = after > before + 1e-15
        if not worse.any():
            break
        share[worse] /= 2
    return uv + share * step
