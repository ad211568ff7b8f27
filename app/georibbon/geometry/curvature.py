"""How a surface bends: Gaussian, mean and normal curvature at the vertices of a mesh.

Curvature is signed by the normals: positive where the surface bends towards
them, so that a ball with outward normals has the normal curvature -1/R.  The
shape operator is found from how the vertices' normals turn, dN = -S dP: first
differences only, and no more noise than the normals have.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import dot, rotations_between, unit
from georibbon.geometry.mesh import Mesh, facets

_FLAT = 1e-9  # sine of the angle between a grid's directions below which there is no plane
_PAIRS = ((0, 0), (0, 1), (1, 1))


@dataclass(frozen=True, eq=False)
class Curvature:
    """The curvature of a surface at n points.

    tensor: (n, 3, 3) 1/m, symmetric, with the surface's normal in its null
    space: t . tensor t is the normal curvature along a unit tangent t.  NaN
    where the mesh does not tell it.
    """

    tensor: FloatArray

    @property
    def mean(self) -> FloatArray:
        """(n,) 1/m: the mean of the principal curvatures, (k1 + k2) / 2."""
        return np.asarray(0.5 * np.trace(self.tensor, axis1=1, axis2=2))

    @property
    def gaussian(self) -> FloatArray:
        """(n,) 1/m²: the product of the principal curvatures, (tr² - tr of the square) / 2."""
        trace = np.trace(self.tensor, axis1=1, axis2=2)
        return np.asarray(0.5 * (trace**2 - np.sum(self.tensor**2, axis=(1, 2))))

    def along(self, directions: FloatArray) -> FloatArray:
        """(n,) 1/m: the normal curvature along tangent directions (n, 3) of any length."""
        unit_directions = unit(directions)
        return np.asarray(np.einsum("ni,nij,nj->n", unit_directions, self.tensor, unit_directions))


def grid_curvature(mesh: Mesh, shape: tuple[int, int]) -> Curvature:
    """The curvature of a mesh whose vertices are a grid of (rows, columns), in row-major order.

    With P_u, P_v the differences of the vertices along the grid and N_u, N_v
    those of the normals, the second fundamental form is h_ab = -N_a . P_b, and
    the tensor is h_ab times the dual basis.  Central differences, at the border
    those of second order to one side.
    """
    points, normals = mesh.vertices.reshape(*shape, 3), mesh.normals.reshape(*shape, 3)
    pu, pv = grid_differences(points)
    nu, nv = grid_differences(normals)
    pu, pv = _tangential(pu, normals), _tangential(pv, normals)
    e, f, g = dot(pu, pu), dot(pu, pv), dot(pv, pv)
    area = e * g - f * f
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(area > _FLAT**2 * e * g, 1.0 / area, np.nan)[..., None]
    dual_u, dual_v = (
        scale * (g[..., None] * pu - f[..., None] * pv),
        scale * (e[..., None] * pv - f[..., None] * pu),
    )
    huu, hvv = -dot(nu, pu), -dot(nv, pv)
    huv = -0.5 * (dot(nu, pv) + dot(nv, pu))
    tensor = (
        huu[..., None, None] * _outer(dual_u, dual_u)
        + huv[..., None, None] * (_outer(dual_u, dual_v) + _outer(dual_v, dual_u))
        + hvv[..., None, None] * _outer(dual_v, dual_v)
    )
    return Curvature(tensor.reshape(-1, 3, 3))


def grid_differences(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The differences of a grid's values (rows, columns, c), along the rows and across."""
    return _differences(values), _differences(values.swapaxes(0, 1)).swapaxes(0, 1)


def _differences(values: FloatArray) -> FloatArray:
    """(n, ...) for values (n, ...) at even parameters: half of what lies between both neighbours.

    At the ends of three or more (4 v1 - 3 v0 - v2) / 2, of two v1 - v0.
    """
    steps = np.empty_like(values)
    steps[1:-1] = 0.5 * (values[2:] - values[:-2])
    if len(values) > 2:
        steps[0] = 0.5 * (4.0 * values[1] - 3.0 * values[0] - values[2])
        steps[-1] = 0.5 * (3.0 * values[-1] - 4.0 * values[-2] + values[-3])
    else:
        steps[:] = values[-1] - values[0]
    return steps


def mesh_curvature(mesh: Mesh) -> Curvature:
    """The curvature of any triangle mesh, from its vertices' normals.

    In every triangle the tensor that fits the normals' differences along its
    three edges best (Rusinkiewicz, Estimating curvatures and their derivatives
    on triangle meshes, 2004), turned into the planes of its corners; at every
    vertex the mean of those around it, weighted by the triangles' areas.
    """
    corners, count = mesh.triangles.T.ravel(), len(mesh.vertices)
    doubled = 2.0 * facets(mesh)
    areas, across = np.sqrt(np.sum(doubled**2, axis=1)), unit(doubled)
    tensors = _fitted(mesh, across)
    usable = (areas > 0.0) & np.isfinite(tensors).all(axis=(1, 2))
    weights = np.tile(np.where(usable, areas, 0.0), 3)
    turn = rotations_between(np.tile(across, (3, 1)), mesh.normals[corners])
    parts = turn @ np.tile(np.where(usable[:, None, None], tensors, 0.0), (3, 1, 1))
    parts = weights[:, None, None] * (parts @ np.swapaxes(turn, -1, -2))
    total = np.bincount(corners, weights, count)
    tensor = np.empty((count, 3, 3))
    with np.errstate(divide="ignore", invalid="ignore"):
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            tensor[:, i, j] = np.bincount(corners, parts[:, i, j], count) / total
            tensor[:, j, i] = tensor[:, i, j]
    return Curvature(tensor)


def _fitted(mesh: Mesh, across: FloatArray) -> FloatArray:
    """(m, 3, 3) each triangle's tensor; across: (m, 3) its unit normal.  NaN without an area.

    With x, y along and across its first edge, the tensor (a, b; b, c) has
    a ex + b ey = -dnx and b ex + c ey = -dny along every edge e.
    """
    points, normals = mesh.vertices[mesh.triangles], mesh.normals[mesh.triangles]
    first = unit(points[:, 1] - points[:, 0])
    axes = np.stack((first, np.cross(across, first)), axis=-1)
    edges = (np.roll(points, -1, axis=1) - points) @ axes
    turns = (np.roll(normals, -1, axis=1) - normals) @ axes
    xx, xy, yy = (np.sum(edges[..., i] * edges[..., j], axis=1) for i, j in _PAIRS)
    zero = np.zeros_like(xx)
    left = np.stack((xx, xy, zero, xy, xx + yy, xy, zero, xy, yy), axis=-1).reshape(-1, 3, 3)
    mixed = np.sum(edges[..., 0] * turns[..., 1] + edges[..., 1] * turns[..., 0], axis=1)
    straight = [np.sum(edges[..., i] * turns[..., i], axis=1) for i in (0, 1)]
    right = -np.stack((straight[0], mixed, straight[1]), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = (xx + yy)[:, None]
        flat = xx * yy - xy * xy <= _FLAT**2 * (xx + yy) ** 2
        left = np.where(flat[:, None, None], np.eye(3), left / scale[..., None])
        a, b, c = np.linalg.solve(left, (right / scale)[..., None])[..., 0].T
    plane = np.stack((a, b, b, c), axis=-1).reshape(-1, 2, 2)
    plane[flat] = np.nan
    return np.asarray(axes @ plane @ np.swapaxes(axes, -1, -2))


def _tangential(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """(..., 3) the part of vectors square to unit normals."""
    return vectors - dot(vectors, normals)[..., None] * normals


def _outer(a: FloatArray, b: FloatArray) -> FloatArray:
    """(..., 3, 3) the products of the components of (..., 3) vectors."""
    return a[..., :, None] * b[..., None, :]
