"""Meshes on disk: STL, OBJ and PLY.

Written with NumPy rather than by VTK's writers: those give an OBJ six digits
and no unit, a PLY no sigma, and cost a third of a second to load; these formats
are a header and one table each.  VTK's readers are the tests' reference.
"""

import struct
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from georibbon import __version__
from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import ExportError
from georibbon.export.files import MESH_ENDINGS, require_ending, write_whole
from georibbon.geometry import frames
from georibbon.geometry.mesh import Mesh, facets

Unit = Literal["mm", "cm", "m", "in"]
UNITS: tuple[Unit, ...] = ("mm", "cm", "m", "in")
_PER_METRE = {"mm": 1000.0, "cm": 100.0, "m": 1.0, "in": 1 / 0.0254}
_STL_HEADER_BYTES = 80
_CREASE = 0.5  # the cosine of 60 degrees between a triangle's normal and its vertices'


def write_mesh(mesh: Mesh, path: Path, unit: Unit) -> None:
    """Write a mesh; the format comes from the path's ending.

    .stl: binary, float32, facet normals from the triangles.  .obj: text, ten
    digits, vertex normals, split where the mesh has a crease.  .ply: binary
    little-endian, float32, vertex normals and, where the mesh has it, `sigma`
    (standard deviation of the vertex's position) as a vertex property.
    Coordinates and sigma are in `unit`, which the header or a comment names.
    The same mesh gives the same bytes.

    Raises ExportError for another ending, a mesh without triangles, a number
    that is not finite, or a place that cannot be written.
    """
    ending = require_ending(path, MESH_ENDINGS, "a mesh")
    _require_sound(mesh, path)
    encode = {".stl": _stl, ".obj": _obj, ".ply": _ply}[ending]
    write_whole(path, encode(mesh, unit))


def _require_sound(mesh: Mesh, path: Path) -> None:
    if len(mesh.triangles) == 0:
        raise ExportError(f"{path}: the surface has no triangle, so there is nothing to write")
    arrays = {"vertices": mesh.vertices, "normals": mesh.normals, "sigma": mesh.sigma}
    for name, array in arrays.items():
        bad = 0 if array is None else int(np.count_nonzero(~np.isfinite(array)))
        if bad:
            raise ExportError(
                f"{path}: {bad} of the surface's {name} values are no finite numbers; "
                "look at the passes' verdicts in the report and capture the worst again"
            )


def _corner_normals(mesh: Mesh) -> tuple[FloatArray, IntArray]:
    """Normals (k, 3), and which of them each triangle's corners (m, 3) have.

    The vertices' own; beyond a crease, as between a solid's face and its rim,
    that of the flat triangle.
    """
    flat = frames.unit(facets(mesh))
    along = np.sum(flat[:, None] * mesh.normals[mesh.triangles], axis=2).min(axis=1)
    creased = (along < _CREASE) & flat.any(axis=1)
    places = mesh.triangles.copy()
    places[creased] = len(mesh.normals) + np.arange(np.count_nonzero(creased))[:, None]
    return np.concatenate([mesh.normals, flat[creased]]), places


def _stl(mesh: Mesh, unit: Unit) -> bytes:
    corners = (mesh.vertices * _PER_METRE[unit])[mesh.triangles]
    records = np.zeros(
        len(corners),
        dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")],
    )
    records["normal"] = frames.unit(facets(mesh))
    records["corners"] = corners
    # A binary STL must not begin with "solid", by which readers know the text form.
    header = f"Georibbon {__version__} binary STL; unit: {unit}".encode().ljust(_STL_HEADER_BYTES)
    return header + struct.pack("<I", len(records)) + records.tobytes()


def _obj(mesh: Mesh, unit: Unit) -> bytes:
    head = f"# Georibbon {__version__}\n# unit: {unit}\n"
    normals, places = _corner_normals(mesh)
    corners = np.stack([mesh.triangles, places], axis=2).reshape(-1, 6) + 1
    return "".join(
        (
            head,
            _rows("v %.10g %.10g %.10g\n", mesh.vertices * _PER_METRE[unit]),
            _rows("vn %.7g %.7g %.7g\n", normals),
            _rows("f %d//%d %d//%d %d//%d\n", corners),
        )
    ).encode("ascii")


def _rows(pattern: str, table: NDArray[Any]) -> str:
    """One line a row: a single formatting of the whole table is the fast way."""
    return (pattern * len(table)) % tuple(table.ravel().tolist())


def _ply(mesh: Mesh, unit: Unit) -> bytes:
    names = ["x", "y", "z", "nx", "ny", "nz"]
    columns = [mesh.vertices * _PER_METRE[unit], mesh.normals]
    comments = [f"comment Georibbon {__version__}", f"comment unit: {unit}"]
    if mesh.sigma is not None:
        names.append("sigma")
        columns.append(mesh.sigma[:, None] * _PER_METRE[unit])
        comments.append(f"comment sigma: standard deviation of the vertex's position, {unit}")
    faces = np.zeros(len(mesh.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = mesh.triangles
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *comments,
        f"element vertex {len(mesh.vertices)}",
        *(f"property float {name}" for name in names),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    vertices = np.hstack(columns).astype("<f4")
    return "\n".join(header).encode("ascii") + vertices.tobytes() + faces.tobytes()
