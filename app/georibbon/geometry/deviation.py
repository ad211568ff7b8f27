"""How far one surface lies from another."""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.nearest import Nearest, TriangleLocator

ASLANT = 0.1
"""Tangent of the angle by which the way to a border may lean before it counts as beyond it."""
FARTHEST = 0.1
"""Share of the reference's size beyond which a point belongs to something else."""
_ROUNDING = 1e-6  # of the size: files hold single precision


@dataclass(frozen=True)
class DeviationStatistics:
    """Deviations in figures, metres; each place counts by its area.

    covered: share of the area that has something to be compared with.  mean:
    with its sign; rms; p95: 95 of 100 parts are not farther away; lowest,
    highest: with their signs.  tolerance: metres; within: the share of the
    covered area not farther away than that.
    """

    covered: float
    mean: float
    rms: float
    p95: float
    lowest: float
    highest: float
    tolerance: float
    within: float

    @property
    def largest(self) -> float:
        """The farthest away to either side, metres, without its sign."""
        return max(-self.lowest, self.highest)


def deviation(points: FloatArray, reference: TriangleLocator) -> FloatArray:
    """(n,) metres from the reference mesh to points (n, 3), positive outside.

    To the nearest point of its triangles.  NaN where the reference has nothing to
    compare with: where that point is on the mesh's border and the other does
    not stand straight over it, and farther away than a tenth of its size.
    """
    found = reference.nearest(points, FARTHEST * reference.size)
    return deviation_from(points, found, reference)


def deviation_from(points: FloatArray, found: Nearest, reference: TriangleLocator) -> FloatArray:
    """The deviation of points (n, 3) whose nearest points on the reference are known."""
    gap = points - found.points
    outward = reference.outward(found)
    along = np.sum(gap * outward, axis=1)
    sideways = np.linalg.norm(gap - along[:, None] * outward, axis=1)
    beyond = sideways > ASLANT * np.abs(along) + _ROUNDING * reference.size
    signed = np.copysign(found.distance, along)
    far = found.distance > FARTHEST * reference.size
    return np.where((reference.on_border(found) & beyond) | far, np.nan, signed)


def vertex_areas(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """(v,) m²: a third of the area of the triangles around each vertex."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    thirds = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    areas = np.zeros(len(vertices))
    np.add.at(areas, triangles.ravel(), np.repeat(thirds, 3))
    return areas


def deviation_statistics(
    values: FloatArray, areas: FloatArray, tolerance: float
) -> DeviationStatistics | None:
    """The figures of deviations (n,), metres, NaN where there are none, with areas (n,).

    None where there is nothing that was compared.
    """
    there = np.isfinite(values)
    weights = areas[there]
    total = float(weights.sum())
    if not total > 0.0:
        return None
    found, sizes = values[there], np.abs(values[there])
    order = np.argsort(sizes)
    reached = np.cumsum(weights[order])
    place = min(int(np.searchsorted(reached, 0.95 * total)), len(order) - 1)
    return DeviationStatistics(
        covered=total / float(areas.sum()),
        mean=float(weights @ found) / total,
        rms=float(np.sqrt(weights @ found**2 / total)),
        p95=float(sizes[order[place]]),
        lowest=float(found.min()),
        highest=float(found.max()),
        tolerance=tolerance,
        within=float(weights[sizes <= tolerance].sum()) / total,
    )
