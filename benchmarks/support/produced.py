"""Points of produced surfaces, whoever produced them, and how far they are from the truth."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.closest import closest_point
from georibbon.geometry.frames import Strip, arc_angles, cross, dot, unit
from georibbon.geometry.reference import ReferenceSurface

ROWS, COLUMNS = 100, 24  # along the passes, and between two neighbours
MOST_SAMPLES = 20_000


@dataclass(frozen=True, eq=False)
class Sampled:
    """Points (n, 3) of a surface, metres, its unit normals (n, 3) and the area of each (n,), m²."""

    points: FloatArray
    normals: FloatArray
    areas: FloatArray


@dataclass(frozen=True, eq=False)
class Away:
    """How far n points are from the truth: distances (n,), m; angles of normals (n,), radians.

    weights: (n,), of sum 1.
    """

    distances: FloatArray
    angles: FloatArray
    weights: FloatArray

    @property
    def cells(self) -> tuple[float, float, float, float]:
        """rms and greatest distance, mm; rms and greatest angle of the normals, degrees."""
        return (
            1e3 * self._rms(self.distances),
            1e3 * float(np.abs(self.distances).max()),
            float(np.degrees(self._rms(self.angles))),
            float(np.degrees(self.angles.max())),
        )

    def _rms(self, values: FloatArray) -> float:
        return float(np.sqrt(np.sum(self.weights * values**2) / self.weights.sum()))


def midpoints(first: float, last: float, count: int) -> FloatArray:
    """(count,) the middles of equal parts of an interval."""
    return first + (last - first) * (np.arange(count) + 0.5) / count


def stacked(strips: Sequence[Strip]) -> FloatArray:
    """(k, p, 3) the points of p passes of k points each."""
    return np.stack([strip.points for strip in strips], axis=1)


def places_between(places: FloatArray) -> FloatArray:
    """(ROWS, w, 2) places in a plane, between passes at places (k, p, 2) straight across."""
    count, passes = places.shape[:2]
    u = midpoints(0.0, 1.0, ROWS) * (count - 1)
    v = midpoints(0.0, passes - 1, COLUMNS * (passes - 1))
    i, j = np.minimum(u.astype(int), count - 2), np.minimum(v.astype(int), passes - 2)
    a, b = (u - i)[:, None, None], (v - j)[None, :, None]
    rows = (1.0 - a) * places[i] + a * places[i + 1]
    between: FloatArray = (1.0 - b) * rows[:, j] + b * rows[:, j + 1]
    return between


def from_grid(points: FloatArray, normals: FloatArray) -> Sampled:
    """A grid (k, w, 3) of points with their unit normals (k, w, 3)."""
    square = cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    areas = np.sqrt(dot(square, square))
    return Sampled(points.reshape(-1, 3), normals.reshape(-1, 3), areas.ravel())


def from_slopes(points: FloatArray, along: FloatArray, across: FloatArray) -> Sampled:
    """A grid (k, w, 3) of points with the derivatives (k, w, 3) by both parameters."""
    return from_grid(points, unit(cross(along, across)))


def from_triangles(vertices: FloatArray, normals: FloatArray, triangles: FloatArray) -> Sampled:
    """The middles of triangles (t, 3), with the vertices' normals interpolated."""
    corners = vertices[triangles]
    square = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middles = unit(normals[triangles].sum(axis=1))
    return Sampled(corners.mean(axis=1), middles, 0.5 * np.sqrt(dot(square, square)))


def thinned(sampled: Sampled) -> Sampled:
    """At most so many of the points, by chance, the areas shared out anew."""
    count = len(sampled.points)
    if count <= MOST_SAMPLES:
        return sampled
    kept = np.random.default_rng(1).choice(count, MOST_SAMPLES, replace=False)
    return Sampled(sampled.points[kept], sampled.normals[kept], sampled.areas[kept])


@dataclass(frozen=True, eq=False)
class Covered:
    """The part of a true surface that exact passes, in order across, enclose.

    outline: (m, 2) a polygon of the surface's parameters: along the first pass,
    straight across to the last, back along it.
    """

    truth: ReferenceSurface
    outline: FloatArray

    def holds(self, uv: FloatArray) -> np.ndarray:
        """(n,) whether parameters (n, 2) lie inside: an odd number of sides to their right."""
        inside = np.zeros(len(uv), dtype=bool)
        ends = zip(self.outline, np.roll(self.outline, -1, axis=0), strict=True)
        for (u0, v0), (u1, v1) in ends:
            crossed = (v0 > uv[:, 1]) != (v1 > uv[:, 1])
            if v0 != v1:
                inside ^= crossed & (uv[:, 0] < u0 + (uv[:, 1] - v0) * (u1 - u0) / (v1 - v0))
        return inside


def covered_by(truth: ReferenceSurface, strips: Sequence[Strip]) -> Covered:
    """What exact passes cover of the surface that they lie on."""
    first, last = (closest_point(truth, one.points).uv for one in (strips[0], strips[-1]))
    return Covered(truth, np.concatenate([first, last[::-1]]))


def compared(covered: Covered, sampled: Sampled, facing: bool = False) -> Away:
    """The points of a produced surface whose closest true points are covered, against those.

    facing: only points whose normals are within 90 degrees of the truth's, for
    closed surfaces, of which the far side is no attempt at the truth; the
    normals of all others may be turned over, all of them together.
    Raises ValueError where no point is left, or one is not finite.
    """
    sampled = thinned(sampled)
    if not np.isfinite(sampled.points).all():
        raise ValueError("points that are not finite")
    nearest = closest_point(covered.truth, sampled.points)
    true_normals = covered.truth.normals(nearest.uv)
    kept = covered.holds(nearest.uv)
    if facing:
        kept &= dot(sampled.normals, true_normals) > 0.0
    if not kept.any():
        raise ValueError("nothing where the passes are")
    normals, true_normals, areas = sampled.normals[kept], true_normals[kept], sampled.areas[kept]
    side = 1.0 if np.sum(areas * dot(normals, true_normals)) >= 0.0 else -1.0
    angles = arc_angles(side * normals, true_normals)
    return Away(nearest.distance[kept], angles, areas / areas.sum())


def pooled(several: Sequence[Away]) -> Away:
    """Repetitions as one."""
    return Away(
        np.concatenate([one.distances for one in several]),
        np.concatenate([one.angles for one in several]),
        np.concatenate([one.weights for one in several]) / len(several),
    )
