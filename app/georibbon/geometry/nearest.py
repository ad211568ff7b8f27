"""The points of a triangle mesh nearest to given ones."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.frames import unit

_AT_ONCE = 4096  # points
_PAIRS = 200_000  # of points and triangles at once, so that they fit the memory
_CLASS = 2.0  # ratio of the sizes of triangles that are searched together
_SMALLEST = 1e-6  # of the largest triangle: what is smaller is searched with this size
_ROUNDING = 1e-9


class Nearest(NamedTuple):
    """The points of a mesh nearest to n given ones.

    faces: (n,) the triangles they lie on; weights: (n, 3) barycentric weights there;
    points: (n, 3) metres; distance: (n,) metres, not negative.
    """

    faces: IntArray
    weights: FloatArray
    points: FloatArray
    distance: FloatArray


class _Class(NamedTuple):
    """Triangles of about one size: the tree of their middles, and the longest radius."""

    tree: cKDTree
    faces: IntArray
    radius: float


class TriangleLocator:
    """Finds nearest points on a mesh, exactly, and the side on which others lie.

    vertices: (v, 3) metres, none twice; triangles: (f, 3), at least one,
    counter-clockwise seen from outside.
    """

    def __init__(self, vertices: FloatArray, triangles: IntArray) -> None:
        self._triangles = triangles
        self._a, b, c = (vertices[triangles[:, k]] for k in range(3))
        self._ab, self._ac = b - self._a, c - self._a
        self._normals = unit(np.cross(self._ab, self._ac))
        self._squares = tuple(
            np.sum(one * other, axis=1)
            for one, other in ((self._ab, self._ab), (self._ab, self._ac), (self._ac, self._ac))
        )
        used = vertices[np.unique(triangles)]
        # By the corner farthest from the middle: the same however the mesh is turned.
        self.size = 2.0 * float(np.linalg.norm(used - used.mean(axis=0), axis=1).max())
        self._classes = _classes(np.stack([self._a, b, c], axis=1))
        self._edge_of, edge_count, self._edge_normals = _edges(triangles, self._normals)
        self._edge_open = edge_count == 1
        self._corner_normals = _corner_normals(vertices, triangles, self._normals)
        self._corner_open = np.zeros(len(vertices), dtype=bool)
        open_ends = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, 1, axis=1)], 2)
        self._corner_open[open_ends[self._edge_open[self._edge_of]]] = True

    def nearest(self, points: FloatArray, reach: float = np.inf) -> Nearest:
        """The nearest points to `points` (n, 3), finite, metres.

        reach: metres; for a point farther away than that it is some near point,
        and so its distance at most is too large.
        """
        parts = [
            self._nearest(points[start : start + _AT_ONCE], reach)
            for start in range(0, len(points), _AT_ONCE)
        ]
        if not parts:
            none = np.zeros((0, 3))
            return Nearest(np.zeros(0, dtype=np.int64), none, none, np.zeros(0))
        return Nearest(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def outward(self, found: Nearest) -> FloatArray:
        """(n, 3) unit normals at points of the mesh that tell inside from outside.

        Inside a triangle its own; on an edge the mean of its triangles'; at a
        corner the mean of all around it, by their angles there (Bærentzen and
        Aanæs 2005, "Signed distance computation using the angle weighted
        pseudonormal").
        """
        normals = self._normals[found.faces].copy()
        edge, corner = self._kinds(found)
        zero = np.argmin(found.weights, axis=1)
        normals[edge] = self._edge_normals[self._edge_of[found.faces[edge], zero[edge]]]
        normals[corner] = self._corner_normals[self._corners(found)[corner]]
        return normals

    def on_border(self, found: Nearest) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """(n,) whether points of the mesh lie on an edge that has one triangle alone."""
        edge, corner = self._kinds(found)
        zero = np.argmin(found.weights, axis=1)
        border = np.zeros(len(found.faces), dtype=bool)
        border[edge] = self._edge_open[self._edge_of[found.faces[edge], zero[edge]]]
        border[corner] = self._corner_open[self._corners(found)[corner]]
        return border

    def _kinds(self, found: Nearest) -> tuple[IntArray, IntArray]:
        """The numbers of the points that lie on an edge, and of those at a corner."""
        zeros = np.count_nonzero(found.weights <= _ROUNDING, axis=1)
        return np.flatnonzero(zeros == 1), np.flatnonzero(zeros == 2)

    def _corners(self, found: Nearest) -> IntArray:
        corners: IntArray = self._triangles[found.faces, np.argmax(found.weights, axis=1)]
        return corners

    def _nearest(self, points: FloatArray, reach: float) -> Nearest:
        found, least = self._hard_by(points)
        asked = np.flatnonzero(least <= reach)
        counts = np.zeros(len(asked), dtype=np.int64)
        for one in self._classes:
            away = _reach(found.distance[asked], one)
            counts += one.tree.query_ball_point(points[asked], away, return_length=True)
        blocks = np.cumsum(counts) // _PAIRS
        for block in np.unique(blocks):
            places = asked[blocks == block]
            better = self._among_candidates(points[places], found.distance[places])
            for whole, part in zip(found, better, strict=True):
                whole[places] = part
        return found

    def _hard_by(self, points: FloatArray) -> tuple[Nearest, FloatArray]:
        """Near points on the triangles whose middles are nearest, and what none is nearer than."""
        best: Nearest | None = None
        least = np.full(len(points), np.inf)
        for one in self._classes:
            away, at = one.tree.query(points)
            least = np.minimum(least, away - one.radius)
            faces = one.faces[at]
            weights, gap = self._closest(points, faces)
            found = Nearest(faces, weights, points - gap, np.linalg.norm(gap, axis=1))
            if best is None:
                best = found
                continue
            nearer = found.distance < best.distance
            for whole, part in zip(best, found, strict=True):
                whole[nearer] = part[nearer]
        if best is None:
            raise ValueError("a mesh without triangles has no nearest point")
        return best, least

    def _among_candidates(self, points: FloatArray, bound: FloatArray) -> Nearest:
        """The nearest points, which are not farther away than the bounds (n,).

        A triangle that reaches into the bound around a point has its middle
        within the bound and its own radius from it.
        """
        owners, faces = [], []
        for one in self._classes:
            lists = one.tree.query_ball_point(points, _reach(bound, one), return_sorted=False)
            counts = np.fromiter(map(len, lists), dtype=np.int64, count=len(points))
            owners.append(np.repeat(np.arange(len(points)), counts))
            faces.append(one.faces[np.concatenate([*lists, []]).astype(np.int64)])
        owner, face = np.concatenate(owners), np.concatenate(faces)
        weights, gap = self._closest(points[owner], face)
        square = np.sum(gap * gap, axis=1)
        order = np.lexsort((face, square, owner))  # of equally near ones the first triangle
        first = order[np.searchsorted(owner[order], np.arange(len(points)))]
        return Nearest(face[first], weights[first], points - gap[first], np.sqrt(square[first]))

    def _closest(self, points: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
        """For pairs of points (m, 3) and triangles (m,) the weights, and what leads from there.

        By the regions of the corners, the edges and the inside (Ericson 2005,
        "Real-Time Collision Detection", 5.1.5).
        """
        ab, ac = self._ab[faces], self._ac[faces]
        away = points - self._a[faces]
        bb, bc, cc = (square[faces] for square in self._squares)
        d1, d2 = np.sum(ab * away, axis=1), np.sum(ac * away, axis=1)
        d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
        va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
        regions = [
            (d1 <= 0) & (d2 <= 0),
            (d3 >= 0) & (d4 <= d3),
            (d6 >= 0) & (d5 <= d6),
            (vc <= 0) & (d1 >= 0) & (d3 <= 0),
            (vb <= 0) & (d2 >= 0) & (d6 <= 0),
            (va <= 0) & (d4 >= d3) & (d5 >= d6),
        ]
        zero, one = np.zeros(len(points)), np.ones(len(points))
        with np.errstate(divide="ignore", invalid="ignore"):
            on_ab, on_ac = d1 / (d1 - d3), d2 / (d2 - d6)
            on_bc = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            whole = va + vb + vc
            v = np.select(regions, [zero, one, zero, on_ab, zero, one - on_bc], vb / whole)
            w = np.select(regions, [zero, zero, one, zero, on_ac, on_bc], vc / whole)
        v, w = np.nan_to_num(v), np.nan_to_num(w)  # a triangle that is a line or a point
        return np.stack([1.0 - v - w, v, w], axis=1), away - v[:, None] * ab - w[:, None] * ac


def _reach(bound: FloatArray, of: _Class) -> FloatArray:
    """(n,) metres within which the middles of the triangles are that could be nearer."""
    return np.asarray((bound + of.radius) * (1.0 + 1e-9) + np.finfo(float).tiny)


def _classes(corners: FloatArray) -> tuple[_Class, ...]:
    """Triangles (f, 3, 3) sorted by their sizes, so that large ones widen no search for small."""
    middles = corners.mean(axis=1)
    radii = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    least = max(float(radii.max()) * _SMALLEST, np.finfo(float).tiny)
    kinds = np.floor(np.log(np.maximum(radii, least)) / np.log(_CLASS)).astype(np.int64)
    classes = []
    for kind in np.unique(kinds):
        faces = np.flatnonzero(kinds == kind)
        classes.append(_Class(cKDTree(middles[faces]), faces, float(radii[faces].max())))
    return tuple(classes)


def _edges(triangles: IntArray, normals: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """(f, 3) the edge opposite each corner; of each edge how many triangles, and its normal."""
    ends = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, 1, axis=1)], axis=2)
    ends = np.sort(ends.reshape(-1, 2), axis=1)
    _, edge, count = np.unique(
        ends[:, 0] * (int(triangles.max()) + 1) + ends[:, 1],
        return_inverse=True,
        return_counts=True,
    )
    sums = _summed(edge, np.repeat(normals, 3, axis=0), len(count))
    return edge.reshape(-1, 3).astype(np.int64), count, unit(sums)


def _corner_normals(vertices: FloatArray, triangles: IntArray, normals: FloatArray) -> FloatArray:
    """(v, 3) at each vertex the mean of the triangles' normals, by their angles there."""
    corners = vertices[triangles]
    one = unit(np.roll(corners, -1, axis=1) - corners)
    other = unit(np.roll(corners, 1, axis=1) - corners)
    angles = np.arccos(np.clip(np.sum(one * other, axis=2), -1.0, 1.0))
    weighted = (angles[:, :, None] * normals[:, None]).reshape(-1, 3)
    return unit(_summed(triangles.ravel(), weighted, len(vertices)))


def _summed(places: IntArray, vectors: FloatArray, count: int) -> FloatArray:
    """(count, 3) the sums of the vectors (m, 3) of each place (m,)."""
    return np.stack([np.bincount(places, vectors[:, k], count) for k in range(3)], axis=1)
