"""Triangle meshes out of files of others: STL, OBJ and PLY."""

import logging
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import GeoribbonError
from georibbon.session.files import read_bounded

MAX_BYTES = 200_000_000
MAX_TRIANGLES = 1_000_000
FARTHEST = 1e12  # of any unit: what is farther off is no place, and its square overflows
KINDS = ("stl", "obj", "ply")
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
"""Units that a mesh's numbers may be in."""
_NONE = np.zeros((0, 3), dtype=np.int64)
# What the parser says of a stranger's file is said here, in a sentence.
logging.getLogger("trimesh").addHandler(logging.NullHandler())


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangle mesh out of a file.

    name: the file's.  vertices: (v, 3) metres, none twice; triangles: (f, 3),
    counter-clockwise seen from the side that the file has outside.
    """

    name: str
    vertices: FloatArray
    triangles: IntArray


def read_triangles(path: Path, unit: str, error: type[GeoribbonError]) -> TriangleMesh:
    """The mesh in an STL, OBJ or PLY file, equal corners joined.

    unit: one of METRES, of the file's numbers.  Raises `error` for what is no
    such file, is too large, or holds no triangle with an area.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in KINDS:
        raise error(f"{path}: a mesh file ends with .stl, .obj or .ply; convert it")
    data = read_bounded(path, MAX_BYTES, str(path), error)
    vertices, triangles = _parsed(data, kind, path.name, error)
    joined, faces = _joined(vertices * METRES[unit], triangles)
    if len(faces) == 0:
        raise error(f"{path.name}: its triangles have no area; export the surface anew")
    return TriangleMesh(path.name, joined, faces)


def _parsed(
    data: bytes, kind: str, name: str, error: type[GeoribbonError]
) -> tuple[FloatArray, IntArray]:
    """The vertices (v, 3) and triangles (f, 3) as the file has them."""
    import trimesh

    try:
        # From bytes, so that no file that this one names is opened.
        found = trimesh.load_mesh(BytesIO(data), file_type=kind, process=False)
        vertices = np.asarray(found.vertices, dtype=np.float64)
        triangles = np.asarray(getattr(found, "faces", _NONE), dtype=np.int64)
    except Exception as cause:  # whatever a parser stumbles over in a stranger's file
        raise error(
            f"{name}: this is no {kind.upper()} file that can be read; "
            "write it anew with the program it came from"
        ) from cause
    if triangles.ndim != 2 or vertices.ndim != 2 or len(triangles) == 0:
        raise error(f"{name}: there are no triangles in it; export the surface as a mesh")
    if len(triangles) > MAX_TRIANGLES:
        raise error(
            f"{name}: {len(triangles)} triangles; at most {MAX_TRIANGLES} are read: coarsen it"
        )
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise error(f"{name}: a triangle names a corner that is not there; write it anew")
    if not (np.abs(vertices[np.unique(triangles)]) <= FARTHEST).all():  # nor is it NaN
        raise error(f"{name}: a corner is no finite point; write the file anew")
    return vertices, triangles


def _joined(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Equal corners made one, triangles without area left out, unused corners too."""
    corners = vertices[triangles.ravel()]
    size = float(np.ptp(corners, axis=0).max()) or 1.0
    # Files hold single precision: what is equal to a ten-millionth of the size is one corner.
    keys = np.round((corners - corners.min(axis=0)) / (1e-7 * size)).astype(np.int64)
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    joined, faces = corners[first], index.reshape(-1, 3)
    a, b, c = (joined[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1) & (area > 1e-14 * size**2)
    used, again = np.unique(faces[distinct], return_inverse=True)
    return joined[used], again.reshape(-1, 3).astype(np.int64)
