"""Passes across a triangle mesh out of a file: straightest geodesics, smoothed a little.

A straightest geodesic (Polthier and Schmies 1998, "Straightest geodesics on
polyhedral surfaces") runs straight over every triangle and unfolds straight over
every edge; it is a polyline whose direction jumps from facet to facet.  A
ribbon bends smoothly: the pass is the least-squares cubic spline through it,
its knots no closer than the facets, and its normals are interpolated between
those of the corners.
"""

import numpy as np
import potpourri3d
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.spatial import cKDTree

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import SettingsError
from georibbon.geometry.frames import Strip, frames_from, unit
from georibbon.session.mesh_file import TriangleMesh, read_triangles
from georibbon.simulation.layout import fan_angles, middle_pass, samples, steps, tie_places
from georibbon.simulation.settings import LayoutSettings
from georibbon.virtual.settings import MeshSettings

SPACING = 0.1
"""Metres between passes unless the layout says otherwise."""
EXTENT = (0.05, 100.0)
"""Metres across: what a ribbon can be laid on."""
KNOTS = 0.02
"""Metres between the knots of a pass, at least."""
FACETS, LEAST = 4.0, 16
"""Facets between the knots, so that their edges are smoothed over; yet so many pieces at least."""
CREASE = 40.0
"""Degrees between facets beyond which their normals are not blended."""
_NEAR = 24  # facets looked at for a point, nearest centres first
_ON = 1e-6  # of the mesh's size: how far off its facet a point on the mesh may be


def read_mesh(settings: MeshSettings) -> TriangleMesh:
    """The mesh in an STL, OBJ or PLY file, equal corners joined.

    Raises `SettingsError` for what is no such file, is empty, too large, not
    manifold, or of a size that no ribbon can be laid on.
    """
    mesh = read_triangles(settings.path, settings.unit, SettingsError)
    _check_size(mesh, settings.unit)
    _check_edges(mesh)
    return mesh


def _check_size(mesh: TriangleMesh, unit_name: str) -> None:
    size = float(np.ptp(mesh.vertices, axis=0).max())
    least, most = EXTENT
    if not least <= size <= most:
        other = {"mm": "m", "m": "mm"}[unit_name]
        raise SettingsError(
            f"{mesh.name}: it is {size:.4g} m across in {unit_name}; {least:g} to {most:g} m is "
            f"expected: is it in {other} (--unit {other})?"
        )


def _check_edges(mesh: TriangleMesh) -> None:
    """Refuse edges with more than two triangles, and triangles that face different ways."""
    t = mesh.triangles
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    ends = np.sort(edges, axis=1)
    count = np.unique(ends[:, 0] * len(mesh.vertices) + ends[:, 1], return_counts=True)[1]
    many = int((count > 2).sum())
    if many:
        raise SettingsError(
            f"{mesh.name}: it is not manifold, {many} of its edges have more than two triangles; "
            "repair it in the program it came from"
        )
    directed = np.unique(edges[:, 0] * len(mesh.vertices) + edges[:, 1])
    if len(directed) < len(edges):
        raise SettingsError(
            f"{mesh.name}: its triangles do not all face one way; unify their normals in the "
            "program it came from"
        )


def lay_on_mesh(mesh: TriangleMesh, layout: LayoutSettings, length: float) -> dict[str, Strip]:
    """The passes and ties as strips in the mesh's frame, by name: P1, ..., T1, ...

    As on a reference surface, with start (x, y) in metres: the topmost point
    above it, by default above the mesh's middle (or, where nothing is there,
    the facet nearest to its middle); heading: from the mesh's x direction.
    Raises `SettingsError` where the mesh is too small for the ribbon or a pass
    runs off it.
    """
    tracer = Tracer(mesh)
    across = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    if across < length / 4:
        raise SettingsError(
            f"{mesh.name}: it is {across:.3g} m across, too small for a ribbon of {length:g} m; "
            "give a shorter ribbon, or the right unit"
        )
    start, normal = tracer.start(layout.start)
    s = samples(length)
    middles = _middles(tracer, layout, start, normal)
    passes = {
        f"P{k + 1}": tracer.strip(point, direction, s, f"P{k + 1}")
        for k, (point, direction) in enumerate(middles)
    }
    if layout.ties == 0:
        return passes
    middle = passes[middle_pass(layout)]
    index = np.rint(tie_places(layout) * (len(s) - 1)).astype(np.int64)
    ties = {
        f"T{k + 1}": tracer.strip(middle.points[i], middle.conormals[i], s, f"T{k + 1}")
        for k, i in enumerate(index)
    }
    return passes | ties


def _middles(
    tracer: "Tracer", layout: LayoutSettings, start: FloatArray, normal: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """The passes' middles (3,) and their directions there (3,)."""
    heading = np.radians(layout.heading or 0.0)
    # Upright, x is along the normal: y takes its place.
    x = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    frame = frames_from(unit(x - (x @ normal) * normal)[None], normal[None])[0]
    forward = np.cos(heading) * frame[:, 0] + np.sin(heading) * frame[:, 1]
    away = steps(layout) * (SPACING if layout.spacing is None else layout.spacing)
    half = max(float(np.abs(away).max()), 0.02)
    cross = tracer.cross(start, np.cross(normal, forward), half)
    found = []
    for distance, fan in zip(away, np.radians(fan_angles(layout)), strict=True):
        k = int(np.argmin(np.abs(cross.s - half - distance)))
        along, sideways = -cross.conormals[k], cross.tangents[k]
        found.append((cross.points[k], along * np.cos(fan) + sideways * np.sin(fan)))
    return found


class Tracer:
    """Follows geodesics over a mesh."""

    def __init__(self, mesh: TriangleMesh) -> None:
        """Of a mesh as `read_mesh` gives it."""
        self._mesh = mesh
        corners = mesh.vertices[mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._corners, self._normals = corners, unit(normals)
        self._size = float(np.ptp(mesh.vertices, axis=0).max())
        self._centres = corners.mean(axis=1)
        self._tree = cKDTree(self._centres)
        self._around = _triangles_around(mesh)
        self._sign = 1.0
        try:
            self._walker = potpourri3d.GeodesicTracer(mesh.vertices, mesh.triangles)
        except RuntimeError as error:
            raise SettingsError(
                f"{mesh.name}: it is not manifold, pieces touch in corners only; repair it in "
                "the program it came from"
            ) from error

    def start(self, place: tuple[float, float] | None) -> tuple[FloatArray, FloatArray]:
        """A point of the mesh (3,) and its normal there, outwards.

        place: (x, y), metres; None: the mesh's middle.  What is met from above is
        outside; where the file's triangles face the other way, all are turned.
        """
        low, high = self._mesh.vertices.min(axis=0), self._mesh.vertices.max(axis=0)
        middle = (low + high) / 2
        x, y = middle[:2] if place is None else place
        found = self._above(x, y)
        if found is None:
            if place is not None:
                raise SettingsError(
                    f"{self._mesh.name}: there is nothing at the start {x:g},{y:g} (m); give x "
                    f"from {low[0]:.3g} to {high[0]:.3g} and y from {low[1]:.3g} to {high[1]:.3g}"
                )
            found = self._centres[int(self._tree.query(middle)[1])]
        elif self.normals(found[None])[0, 2] < 0:
            self._sign = -1.0
        return found, self.normals(found[None])[0]

    def _above(self, x: float, y: float) -> FloatArray | None:
        """The topmost point of the mesh over (x, y)."""
        a, b, c = (self._corners[:, k] for k in range(3))
        place = np.array([x, y])
        whole = _cross2(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            v = _cross2(place - a[:, :2], c - a) / whole
            w = _cross2(b - a, place - a[:, :2]) / whole
            over = (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1 + 1e-9)
            z = a[:, 2] + v * (b - a)[:, 2] + w * (c - a)[:, 2]
        if not over.any():
            return None
        return np.array([x, y, z[over].max()])

    def normals(self, points: FloatArray) -> FloatArray:
        """(n, 3) unit normals, outwards, at points (n, 3) on the mesh, smooth but at creases."""
        faces, weights = self._locate(points)
        found = [
            sum(w * self._corner_normal(f, k) for k, w in enumerate(weight))
            for f, weight in zip(faces, weights, strict=True)
        ]
        return self._sign * unit(np.array(found))

    def _corner_normal(self, face: int, corner: int) -> FloatArray:
        """The normal at a corner of a facet: of those around it, by angle, across no crease."""
        starts, order = self._around
        vertex = self._mesh.triangles[face, corner]
        around = order[starts[vertex] : starts[vertex + 1]]
        faces, corners = around // 3, around % 3
        blended = self._normals[faces] @ self._normals[face] > np.cos(np.radians(CREASE))
        here = self._corners[faces, corners]
        one = unit(self._corners[faces, (corners + 1) % 3] - here)
        other = unit(self._corners[faces, (corners + 2) % 3] - here)
        angle = np.arccos(np.clip(np.sum(one * other, axis=1), -1.0, 1.0)) * blended
        return np.asarray(unit(angle @ self._normals[faces]))

    def _locate(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """For points (n, 3) their facets (n,) and barycentric weights (n, 3) there."""
        near = np.atleast_2d(self._tree.query(points, min(_NEAR, len(self._centres)))[1])
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

    def cross(self, point: FloatArray, direction: FloatArray, half: float) -> Strip:
        """The curve both ways from a point, `half` metres each; its middle is at s = half."""
        s = np.linspace(0.0, 2 * half, max(round(2 * half / 0.0005), 20) + 1)
        return self.strip(point, direction, s, "the line across the passes")

    def strip(self, point: FloatArray, direction: FloatArray, s: FloatArray, name: str) -> Strip:
        """The geodesic whose middle is at `point`, at distances s (n,) from its start.

        point: (3,) on the mesh; direction: (3,) along it there.  Raises
        `SettingsError` where it runs off the mesh.
        """
        half = float(s[-1]) / 2
        face, weight = (value[0] for value in self._locate(point[None]))
        ahead = self._walk(face, weight, direction, half, name)
        behind = self._walk(face, weight, -direction, half, name)
        points = np.concatenate([behind[:0:-1], ahead])
        return self._smoothed(points, s)

    def _walk(
        self, face: int, weight: FloatArray, direction: FloatArray, length: float, name: str
    ) -> FloatArray:
        """(m, 3) the corners of the polyline; `length` metres of it."""
        normal = self._normals[face]
        flat = unit(direction - (direction @ normal) * normal)
        found = self._walker.trace_geodesic_from_face(face, weight, length * flat)
        points = np.asarray(found, dtype=np.float64).reshape(-1, 3)
        reached = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        if not np.isfinite(points).all() or reached < length - max(1e-6, 1e-6 * length):
            raise SettingsError(
                f"{self._mesh.name}: {name} runs off the mesh {reached:.3g} m from its middle; "
                "choose another start, heading or spacing, fewer passes or a shorter ribbon"
            )
        return points

    def _smoothed(self, points: FloatArray, s: FloatArray) -> Strip:
        """The polyline (m, 3) as a smooth strip, at distances s (n,) of its whole length."""
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        points = points[np.concatenate([[True], gaps > 1e-12])]
        path = np.concatenate([[0.0], np.cumsum(gaps[gaps > 1e-12])])
        path *= s[-1] / path[-1]
        at = np.linspace(0.0, s[-1], 8 * len(s))
        sampled = np.stack([np.interp(at, path, column) for column in points.T], axis=1)
        facet = float(np.percentile(gaps, 90))
        count = int(s[-1] / np.clip(FACETS * facet, KNOTS, s[-1] / LEAST))
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


def _spline(at: FloatArray, values: FloatArray, pieces: int) -> BSpline:
    """The least-squares cubic spline of values (n, c) at places (n,), in so many pieces."""
    inner = np.linspace(at[0], at[-1], pieces + 1)[1:-1]
    knots = np.concatenate([np.repeat(at[0], 4), inner, np.repeat(at[-1], 4)])
    return make_lsq_spline(at, values, knots, 3)


def _triangles_around(mesh: TriangleMesh) -> tuple[IntArray, IntArray]:
    """Where each vertex's corners begin (v+1,), and the corners, 3 face + corner, by vertex."""
    flat = mesh.triangles.ravel()
    starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=len(mesh.vertices)))])
    return starts.astype(np.int64), np.argsort(flat, kind="stable").astype(np.int64)


def _cross2(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n,) the z component of the cross products of the x and y of (n, 2 or 3) vectors."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


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
