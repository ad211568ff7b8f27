"""Where a mesh runs through itself."""

import numpy as np

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.geometry.mesh import Mesh

TOGETHER = 1e-6  # m
TOUCHING = 1e-9  # m: an edge that reaches no farther through a plane merely touches it


def crossing_triangles(mesh: Mesh) -> IntArray:
    """(k, 2) pairs of triangles that cross, of those that share no vertex.

    Two triangles cross where an edge of one goes through the other; triangles
    that merely touch, or overlap within one plane, are not counted.  Vertices
    within a micrometre are one: where passes begin at one mark, or close to a ring.
    """
    corners, named = mesh.vertices[mesh.triangles], places_of(mesh.vertices)[mesh.triangles]
    first, second = near_pairs(corners)
    apart = (named[first, :, None] != named[second, None, :]).all(axis=(1, 2))
    first, second = first[apart], second[apart]
    a, b = corners[first], corners[second]
    hit = np.zeros(len(a), dtype=bool)
    for k in range(3):
        hit |= goes_through(a[:, k], a[:, (k + 1) % 3], b)
        hit |= goes_through(b[:, k], b[:, (k + 1) % 3], a)
    return np.stack([first[hit], second[hit]], axis=1)


def places_of(points: FloatArray) -> IntArray:
    """(n,) a number for each of (n, 3) points, the same for those that lie together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    first, second = cKDTree(points).query_pairs(TOGETHER, output_type="ndarray").T
    count = len(points)
    near = coo_array((np.ones(len(first), dtype=bool), (first, second)), shape=(count, count))
    return np.asarray(connected_components(near, directed=False)[1], dtype=np.int64)


def near_pairs(corners: FloatArray) -> tuple[IntArray, IntArray]:
    """Pairs (k,), (k,) of triangles (m, 3, 3) whose bounding boxes overlap, each pair once."""
    from scipy.spatial import cKDTree

    middles = corners.mean(axis=1)
    reach = 2.0 * np.sqrt(np.max(np.sum((corners - middles[:, None]) ** 2, axis=2)))
    first, second = cKDTree(middles).query_pairs(reach, output_type="ndarray").T.astype(np.int64)
    low, high = corners.min(axis=1), corners.max(axis=1)
    overlap = ((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)
    return first[overlap], second[overlap]


def goes_through(start: FloatArray, end: FloatArray, triangles: FloatArray) -> BoolArray:
    """(k,) whether segments (k, 3) to (k, 3) go through triangles (k, 3, 3).

    Möller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997; both ends
    must lie clear of the triangle's plane, or rounding would decide within one plane.
    """
    along = end - start
    e1, e2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p, t = np.cross(along, e2), start - triangles[:, 0]
    determinant = np.sum(e1 * p, axis=1)
    q, square = np.cross(t, e1), np.cross(e1, e2)
    before = np.sum(e2 * q, axis=1)  # the start's height over the plane, times |square|
    beyond = determinant - before  # the end's depth below it
    least = TOUCHING * np.sqrt(np.sum(square**2, axis=1))
    through = (np.minimum(before, beyond) > least) | (np.maximum(before, beyond) < -least)
    scale = 1.0 / np.where(through, determinant, 1.0)
    u, v = (np.sum(x * y, axis=1) * scale for x, y in ((t, p), (along, q)))
    inside: BoolArray = through & (u > 0.0) & (v > 0.0) & (u + v < 1.0)
    return inside
