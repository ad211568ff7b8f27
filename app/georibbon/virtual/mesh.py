"""Passes across a triangle mesh out of a file."""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import SettingsError, SurfaceError
from georibbon.geometry.frames import Strip, frames_from, unit
from georibbon.mesh_geodesics import MeshGeodesics, OffTheMeshError
from georibbon.session.mesh_file import TriangleMesh, read_triangles
from georibbon.simulation.layout import fan_angles, middle_pass, samples, steps, tie_places
from georibbon.simulation.settings import LayoutSettings
from georibbon.virtual.settings import MeshSettings

SPACING = 0.1
"""Metres between passes unless the layout says otherwise."""
EXTENT = (0.05, 100.0)
"""Metres across: what a ribbon can be laid on."""


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
        self._corners = mesh.vertices[mesh.triangles]
        self._geodesics = _geodesics(mesh, turned=False)

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
            centres = self._corners.mean(axis=1)
            found = centres[np.argmin(np.linalg.norm(centres - middle, axis=1))]
        elif self._geodesics.normals(found[None])[0, 2] < 0:
            self._geodesics = _geodesics(self._mesh, turned=True)
        return found, self._geodesics.normals(found[None])[0]

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

    def cross(self, point: FloatArray, direction: FloatArray, half: float) -> Strip:
        """The curve both ways from a point, `half` metres each; its middle is at s = half."""
        s = np.linspace(0.0, 2 * half, max(round(2 * half / 0.0005), 20) + 1)
        return self.strip(point, direction, s, "the line across the passes")

    def strip(self, point: FloatArray, direction: FloatArray, s: FloatArray, name: str) -> Strip:
        """The geodesic whose middle is at `point`, at distances s (n,) from its start.

        point: (3,) on the mesh; direction: (3,) along it there.  Raises
        `SettingsError` where it runs off the mesh.
        """
        try:
            return self._geodesics.straightest(point, direction, s - s[-1] / 2)
        except OffTheMeshError as error:
            raise SettingsError(
                f"{self._mesh.name}: {name} runs off the mesh {error.reached:.3g} m from its "
                "middle; choose another start, heading or spacing, fewer passes or a shorter ribbon"
            ) from error


def _geodesics(mesh: TriangleMesh, turned: bool) -> MeshGeodesics:
    """The mesh's geodesics; turned: with its triangles facing the other way."""
    try:
        return MeshGeodesics(mesh.vertices, mesh.triangles[:, ::-1] if turned else mesh.triangles)
    except SurfaceError as error:
        raise SettingsError(f"{mesh.name}: {error}") from error


def _cross2(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n,) the z component of the cross products of the x and y of (n, 2 or 3) vectors."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
