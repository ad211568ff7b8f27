"""Triangle meshes: built from grids, oriented, thickened and checked."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.errors import SurfaceError
from georibbon.geometry.components import crossed, dotted, inner, interleaved, outer


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh.

    vertices: (n, 3) float64, metres, none twice.  triangles: (m, 3) int64,
    counter-clockwise seen from outside.  normals: (n, 3) float64, unit,
    outward.  sigma: (n,) float64, metres, the standard deviation of each
    vertex's position (square root of the covariance's trace), or None.
    """

    vertices: FloatArray
    triangles: IntArray
    normals: FloatArray
    sigma: FloatArray | None = None


def grid_mesh(points: FloatArray, normals: FloatArray, sigma: FloatArray | None = None) -> Mesh:
    """The mesh over a grid (k, m, 3) of points, metres, with normals (k, m, 3), sigma (k, m).

    The normals' side is outside where the second index grows to the left of
    the first.  Each quadrilateral is cut along its shorter diagonal.
    """
    triangles = cells_of(*points.shape[:2]).copy()
    step = np.multiply(second_shorter(points), points.shape[1], dtype=np.int64).ravel()
    # From c to d and from a to b: the other diagonal's triangles.
    triangles[:, 2] -= step
    triangles[:, 5] += step
    spread = None if sigma is None else sigma.ravel()
    vertices, facing = (interleaved(one).reshape(-1, 3) for one in (points, normals))
    return Mesh(vertices, triangles.reshape(-1, 3), facing, spread)


def second_shorter(points: FloatArray) -> BoolArray:
    """(k-1, m-1) where of a grid (k, m, 3)'s quadrilaterals the diagonal that does not
    begin at their least corner is the shorter.

    Single precision tells diagonals of millimetres apart by some 1e-5 of their length.
    """
    rows, columns = points.shape[:2]
    # As one row of numbers: the last of each row of cells is none and left out.
    run = inner(points).reshape(3, -1).astype(np.float32)
    first = run[:, columns + 1 :] - run[:, : -columns - 1]
    second = run[:, 1:-columns] - run[:, columns:-1]
    longer = np.zeros((rows - 1) * columns, dtype=np.bool_)
    one, other = (np.einsum("ij,ij->j", along, along) for along in (first, second))
    np.greater(one, other, out=longer[:-1])
    return longer.reshape(rows - 1, columns)[:, :-1]


@lru_cache(maxsize=2)
def cells_of(rows: int, columns: int) -> IntArray:
    """(n, 6) two triangles for every quadrilateral of a grid, along the diagonal from a to c.

    With corners a, then b in the next row, c opposite and d in the next column: a b c and c d a.
    """
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b = number[:-1, :-1], number[1:, :-1]
    c, d = number[1:, 1:], number[:-1, 1:]
    cells: IntArray = np.stack([a, b, c, c, d, a], axis=-1).reshape(-1, 6)
    cells.flags.writeable = False
    return cells


def facets(mesh: Mesh) -> FloatArray:
    """(m, 3) m²: each triangle's outward normal times its area."""
    return outer(facet_components(mesh))


def facet_components(mesh: Mesh) -> FloatArray:
    """(3, m) the same, component by component."""
    corners = mesh.triangles.T
    across = [np.take(component, corners) for component in inner(mesh.vertices)]
    first, second = (np.stack([one[k] - one[0] for one in across]) for k in (1, 2))
    halves = crossed(first, second)
    halves *= 0.5
    return halves


def area(mesh: Mesh) -> float:
    """The mesh's area, m²."""
    halves = facet_components(mesh)
    return float(np.sum(np.sqrt(dotted(halves, halves))))


def volume(mesh: Mesh) -> float:
    """The volume that a closed mesh encloses, m³, positive when oriented outward.

    By the divergence theorem: a third of the sum of each triangle's middle
    times its normal and area.
    """
    middles = mesh.vertices[mesh.triangles].mean(axis=1) - mesh.vertices.mean(axis=0)
    return float(np.sum(middles * facets(mesh)) / 3.0)


def directed_edges(mesh: Mesh) -> IntArray:
    """(3 m, 2) the edges of all triangles, each in its triangle's direction."""
    edges: IntArray = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return edges


def boundary_edges(mesh: Mesh) -> IntArray:
    """(e, 2) the edges that no triangle runs the other way, in their triangle's direction."""
    edges = directed_edges(mesh)
    count = len(mesh.vertices)
    return edges[~np.isin(edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0])]


def is_oriented(mesh: Mesh) -> bool:
    """Whether no edge is run twice in one direction: neighbours agree which side is outside."""
    edges = directed_edges(mesh)
    keys = edges[:, 0] * len(mesh.vertices) + edges[:, 1]
    return len(np.unique(keys)) == len(keys)


def is_watertight(mesh: Mesh) -> bool:
    """Whether every edge belongs to exactly two triangles that run it in opposite directions."""
    return is_oriented(mesh) and len(boundary_edges(mesh)) == 0


def folding_thickness(mesh: Mesh) -> float:
    """The least distance, metres, by which moving the mesh inward turns a triangle over.

    With edges e1, e2, their changes of normal d1, d2 and the triangle's unit
    normal n it is the least positive root t of
    n . ((e1 - t d1) x (e2 - t d2)) = A - t B + t² C; infinite where there is none.
    """
    points, normals = mesh.vertices[mesh.triangles], mesh.normals[mesh.triangles]
    e1, e2 = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    d1, d2 = normals[:, 1] - normals[:, 0], normals[:, 2] - normals[:, 0]
    square = np.cross(e1, e2)
    a = np.sum(square * square, axis=1)
    b = np.sum(square * (np.cross(d1, e2) + np.cross(e1, d2)), axis=1)
    c = np.sum(square * np.cross(d1, d2), axis=1)
    inner = b * b - 4.0 * a * c
    # The least positive root in the form that does not cancel: 2 a / (b + sqrt(b² - 4 a c)).
    below = b + np.sqrt(np.maximum(inner, 0.0))
    folds = (inner >= 0.0) & (below > 0.0) & (a > 0.0)
    return float(np.min(2.0 * a[folds] / below[folds], initial=np.inf))


def thicken(mesh: Mesh, thickness: float) -> Mesh:
    """A closed solid whose outer face is the mesh, an open skin.

    The inner face lies `thickness` metres inward along the normals; walls join
    the two along the skin's boundary.  Raises SurfaceError where the inner face
    would fold over because the skin bends more sharply than that.
    """
    limit = folding_thickness(mesh)
    if thickness >= limit:
        raise SurfaceError(
            f"a wall {1e3 * thickness:.2f} mm thick folds over itself where the surface bends "
            f"most sharply, at most {1e3 * limit:.2f} mm is possible: choose a smaller thickness"
        )
    count = len(mesh.vertices)
    a, b = boundary_edges(mesh).T
    walls = np.stack(
        [np.stack([b, a, a + count], axis=1), np.stack([b, a + count, b + count], axis=1)], axis=1
    ).reshape(-1, 3)
    return Mesh(
        np.concatenate([mesh.vertices, mesh.vertices - thickness * mesh.normals]),
        np.concatenate([mesh.triangles, mesh.triangles[:, ::-1] + count, walls]),
        np.concatenate([mesh.normals, -mesh.normals]),
        None if mesh.sigma is None else np.concatenate([mesh.sigma, mesh.sigma]),
    )
