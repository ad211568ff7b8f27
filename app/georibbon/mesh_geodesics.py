"""Geodesics of triangle meshes: from a point in a direction, and between two points.

From a point: the straightest geodesic (Polthier and Schmies, Straightest
geodesics on polyhedral surfaces, 1998), straight over every triangle, and over
every edge when both its triangles are unfolded.  Between two points: the
shortest way along edges, straightened by flipping edges until no corner of it
can be cut (Sharp and Crane, You can find geodesic paths in triangle meshes by
just flipping edges, 2020); the shortest near by, not of all.

Both are polylines whose direction jumps from facet to facet.  A ribbon bends
smoothly: the strip is the least-squares cubic spline through one, its knots no
closer than the facets, and its normals are interpolated between those of the
corners.  On a plane both are exact; on the finer and finer meshes of a smooth
surface they tend to its geodesics.
"""

import numpy as np
import potpourri3d
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.spatial import cKDTree

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import SurfaceError
from georibbon.geometry.frames import Strip, frames_from, unit

KNOTS = 0.02
"""Metres between the knots of a strip, at least."""
FACETS, LEAST = 4.0, 16
"""Facets between the knots, so that their edges are smoothed over; yet so many pieces at least."""
CREASE = 40.0
"""Degrees between facets beyond which their normals are not blended."""
_NEAR = 24  # facets looked at for a point, nearest centres first
_ON = 1e-6  # of the mesh's size: how far off its facet a point on the mesh may be
_CLEAR = 1e-3  # barycentric weight by which a place is kept off its triangle's edges

Place = tuple[int, FloatArray]
"""A triangle, and the (3,) weights of its corners."""


class OffTheMeshError(SurfaceError):
    """A geodesic runs off the mesh; `reached`: metres from where it began."""

    def __init__(self, reached: float) -> None:
        super().__init__(
            f"the geodesic runs off the mesh {reached:.3g} m from its beginning; take another "
            "direction or a shorter one"
        )
        self.reached = reached


class MeshGeodesics:
    """The geodesics of one mesh, as strips."""

    def __init__(self, vertices: FloatArray, triangles: IntArray) -> None:
        """Of a mesh (v, 3), metres, and (f, 3), counter-clockwise seen from outside.

        Raises SurfaceError where it is not manifold.
        """
        self._vertices, self._triangles = vertices, triangles
        corners = vertices[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._corners, self._normals = corners, unit(normals)
        self._size = float(np.ptp(vertices, axis=0).max())
        self._tree = cKDTree(corners.mean(axis=1))
        self._around = _triangles_around(len(vertices), triangles)
        try:
            self._walker = potpourri3d.GeodesicTracer(vertices, triangles)
        except RuntimeError as error:
            raise SurfaceError(
                "the mesh is not manifold, pieces touch in corners only; repair it in the program "
                "it came from"
            ) from error

    def straightest(self, point: FloatArray, direction: FloatArray, s: FloatArray) -> Strip:
        """The geodesic through a point of the mesh (3,) in a direction (3,) along it.

        s: (n,) ascending signed distances from the point, metres, from before
        (or at) it to beyond (or at) it; the strip's arc length starts at 0.
        Raises OffTheMeshError where it runs off the mesh.
        """
        face, weight = (value[0] for value in self.locate(point[None]))
        ahead = self._walk((face, weight), direction, float(s[-1]))
        behind = self._walk((face, weight), -direction, float(-s[0]))
        return self.smoothed(np.concatenate([behind[:0:-1], ahead]), s - s[0])

    def shortest(self, first: FloatArray, second: FloatArray, samples: int = 121) -> Strip:
        """The geodesic between two points of the mesh, (3,) each, shortest near by.

        samples: of the strip, evenly spaced.  Raises SurfaceError where the two
        are one point, or lie on pieces of the mesh that do not hang together.
        """
        faces, weights = self.locate(np.stack([first, second]))
        places = [(int(face), weight) for face, weight in zip(faces, weights, strict=True)]
        path = shortest_path(self._vertices, self._triangles, places[0], places[1])
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        if not length > 1e-9 * self._size:
            raise SurfaceError("the two points of the mesh are one: give two different ones")
        return self.smoothed(path, np.linspace(0.0, length, samples))

    def normals(self, points: FloatArray) -> FloatArray:
        """(n, 3) unit normals, outwards, at points (n, 3) on the mesh, smooth but at creases."""
        faces, weights = self.locate(points)
        found = [
            sum(w * self._corner_normal(f, k) for k, w in enumerate(weight))
            for f, weight in zip(faces, weights, strict=True)
        ]
        return unit(np.array(found))

    def _corner_normal(self, face: int, corner: int) -> FloatArray:
        """The normal at a corner of a facet: of those around it, by angle, across no crease."""
        starts, order = self._around
        vertex = self._triangles[face, corner]
        around = order[starts[vertex] : starts[vertex + 1]]
        faces, corners = around // 3, around % 3
        blended = self._normals[faces] @ self._normals[face] > np.cos(np.radians(CREASE))
        here = self._corners[faces, corners]
        one = unit(self._corners[faces, (corners + 1) % 3] - here)
        other = unit(self._corners[faces, (corners + 2) % 3] - here)
        angle = np.arccos(np.clip(np.sum(one * other, axis=1), -1.0, 1.0)) * blended
        return np.asarray(unit(angle @ self._normals[faces]))

    def locate(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """For points (n, 3) their facets (n,) and barycentric weights (n, 3) there."""
        near = np.atleast_2d(self._tree.query(points, min(_NEAR, len(self._triangles)))[1])
        near = near.reshape(len(points), -1)
        faces = np.zeros(len(points), dtype=np.int64)
        weights = np.zeros((len(points), 3))
        for i, point in enumerate(points):
            gap, weight = _closest(point, self._corners[near[i]])
            k = int(np.argmin(gap))
            faces[i], weights[i] = near[i, k], weight[k]
            if gap[k] > _ON * self._size:
                gap, weight = _closest(point, self._corners)
                k = int(np.argmin(gap))
                faces[i], weights[i] = k, weight[k]
        return faces, weights

    def _walk(self, place: Place, direction: FloatArray, length: float) -> FloatArray:
        """(m, 3) the corners of the straightest geodesic from a place; `length` metres of it."""
        face, weight = place
        if length == 0.0:
            return np.asarray((weight @ self._corners[face])[None])
        normal = self._normals[face]
        flat = unit(direction - (direction @ normal) * normal)
        found = self._walker.trace_geodesic_from_face(face, weight, length * flat)
        points = np.asarray(found, dtype=np.float64).reshape(-1, 3)
        reached = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        if not np.isfinite(points).all() or reached < length - max(1e-6, 1e-6 * length):
            raise OffTheMeshError(reached)
        return points

    def smoothed(self, points: FloatArray, s: FloatArray) -> Strip:
        """A polyline on the mesh (m, 3) as a smooth strip, at distances s (n,) of all its length.

        s: ascending from 0 to the polyline's length.
        """
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        points = points[np.concatenate([[True], gaps > 1e-12])]
        path = np.concatenate([[0.0], np.cumsum(gaps[gaps > 1e-12])])
        path *= s[-1] / path[-1]
        facet = float(np.percentile(gaps, 90))
        count = int(s[-1] / np.clip(FACETS * facet, KNOTS, s[-1] / LEAST))
        at = np.linspace(0.0, s[-1], 8 * max(len(s), count))
        sampled = np.stack([np.interp(at, path, column) for column in points.T], axis=1)
        curve = _spline(at, sampled, count)
        # By its own arc length, and as long as the polyline: smoothing cuts corners by microns.
        speed = np.linalg.norm(curve(at, 1), axis=1)
        arc = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(at))])
        u = np.interp(s * arc[-1] / s[-1], arc, at)
        tangents = unit(np.asarray(curve(u, 1), dtype=np.float64))
        some = np.linspace(0.0, s[-1], max(len(s) // 2, 8))
        on = np.stack([np.interp(some, path, column) for column in points.T], axis=1)
        normals = _spline(some, self.normals(on), min(count, len(some) // 2 - 3))(u)
        return Strip(s, np.asarray(curve(u)), frames_from(tangents, normals))


def shortest_path(
    vertices: FloatArray, triangles: IntArray, first: Place, second: Place
) -> FloatArray:
    """(n, 3) the shortest way over a mesh near by from one place on it to another.

    Both places become vertices of their triangles.  Raises SurfaceError where
    no way over the mesh leads from one to the other.
    """
    ends = np.stack([weights @ vertices[triangles[t]] for t, weights in (first, second)])
    if first[0] == second[0]:
        return ends
    begin, end = len(vertices), len(vertices) + 1
    inside = [_off_edges(vertices[triangles[t]], weights) for t, weights in (first, second)]
    parts = [_parted(triangles[t], k) for (t, _), k in ((first, begin), (second, end))]
    kept = np.delete(triangles, [first[0], second[0]], axis=0)
    try:
        solver = potpourri3d.EdgeFlipGeodesicSolver(
            np.vstack((vertices, *inside)), np.concatenate((kept, *parts))
        )
        path = np.asarray(solver.find_geodesic_path(begin, end), dtype=np.float64)
    except RuntimeError as error:
        raise SurfaceError(
            "no way over the mesh leads from one point to the other: it falls into pieces, or is "
            "not manifold; choose both on one piece"
        ) from error
    path[[0, -1]] = ends
    return path


def _off_edges(corners: FloatArray, weights: FloatArray) -> FloatArray:
    """(3,) a place in a triangle (3, 3), moved as little as needed off its edges."""
    inside = np.maximum(weights, _CLEAR)
    place: FloatArray = (inside / inside.sum()) @ corners
    return place


def _parted(corners: IntArray, new: int) -> IntArray:
    """(3, 3) the triangles about a new vertex inside a triangle."""
    a, b, c = corners.tolist()
    return np.array([[a, b, new], [b, c, new], [c, a, new]])


def _spline(at: FloatArray, values: FloatArray, pieces: int) -> BSpline:
    """The least-squares cubic spline of values (n, c) at places (n,), in so many pieces."""
    inner = np.linspace(at[0], at[-1], pieces + 1)[1:-1]
    knots = np.concatenate([np.repeat(at[0], 4), inner, np.repeat(at[-1], 4)])
    return make_lsq_spline(at, values, knots, 3)


def _triangles_around(count: int, triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Where each vertex's corners begin (v+1,), and the corners, 3 face + corner, by vertex."""
    flat = triangles.ravel()
    starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=count))])
    return starts.astype(np.int64), np.argsort(flat, kind="stable").astype(np.int64)


def _closest(point: FloatArray, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far (f,) triangles (f, 3, 3) are from a point, and the weights (f, 3) of its place.

    The point is taken into the triangle's plane and its weights cut to the
    triangle: exact for a point on it, an upper bound of the distance otherwise.
    """
    a = corners[:, 0]
    u, v, w = corners[:, 1] - a, corners[:, 2] - a, point - a
    normal = np.cross(u, v)
    whole = np.sum(normal * normal, axis=1)
    second = np.sum(np.cross(w, v) * normal, axis=1) / whole
    third = np.sum(np.cross(u, w) * normal, axis=1) / whole
    weights = np.clip(np.stack([1.0 - second - third, second, third], axis=1), 0.0, None)
    weights /= weights.sum(axis=1, keepdims=True)
    gap = np.linalg.norm(np.einsum("fk,fkj->fj", weights, corners) - point, axis=1)
    return gap, weights
