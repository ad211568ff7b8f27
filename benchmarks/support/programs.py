"""Georibbon and the programs it is measured against: each lays a surface through the same curves.

Every program gets the curves as they are: points by arc length and, where it can
use them, normals.  Across from each other lie, for the peers, equal fractions of
the curves' lengths; Georibbon and the solvers of scattered points find that
themselves.  `lay` makes the surface, `sample` evaluates it with its normals.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator, RectBivariateSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.frames import Strip, unit
from georibbon.geometry.patch import natural_parameters, patch_grid, patches_at, patches_between
from georibbon.geometry.settings import SurfaceSettings
from support.kernel import loft_lay, loft_sample, plate_lay, plate_sample
from support.produced import (
    COLUMNS,
    ROWS,
    Sampled,
    from_grid,
    from_slopes,
    from_triangles,
    midpoints,
    places_between,
    stacked,
)

STEP = 1e-5  # m, of differences
STEEPEST = 80.0  # degrees against the mean plane, of what may be called a height


@dataclass(frozen=True)
class Program:
    """A way to a surface.

    package: the distribution whose version counts, None for Georibbon's own.
    normals: whether it is told the normals.  closed: whether what it makes has
    a far side.  variants: settings among which the one nearest to the truth
    counts: no user could choose that well.
    """

    name: str
    package: str | None
    normals: bool
    lay: Callable[..., Any]
    sample: Callable[[Any], Sampled]
    closed: bool = False
    variants: tuple[dict[str, Any], ...] = ({},)


def gaps(points: FloatArray) -> FloatArray:
    """(p,) metres: mean distances of neighbouring passes (k, p, 3), added up."""
    apart = np.linalg.norm(np.diff(points, axis=1), axis=2).mean(axis=0)
    return np.concatenate([[0.0], np.cumsum(apart)])


def own_lay(strips: Sequence[Strip], **choice: Any) -> Any:
    """Georibbon's patches."""
    return patches_between(arrange(strips), SurfaceSettings(**choice))


def own_sample(model: Any) -> Sampled:
    """Points and normals of all patches."""
    ends = natural_parameters(model)
    patches = patches_at(model, midpoints(ends[0], ends[-1], ROWS))
    normals = patches.rails.frames[..., 2]
    v = midpoints(0.0, 1.0, COLUMNS)
    grid = patch_grid(patches.control, patches.slope, (normals[:-1], normals[1:]), v)
    side_by_side = [np.concatenate(list(one), axis=1) for one in (grid.points, grid.normals)]
    return from_grid(*side_by_side)


def spline_lay(strips: Sequence[Strip]) -> Any:
    """An interpolating spline of x, y and z over fraction and distance across."""
    points = stacked(strips)
    u, v = np.linspace(0.0, 1.0, len(points)), gaps(points)
    degree = min(3, len(strips) - 1)
    axes = [RectBivariateSpline(u, v, points[..., i], kx=3, ky=degree, s=0.0) for i in range(3)]
    return axes, v


def spline_sample(laid: Any) -> Sampled:
    """Its points and derivatives; across by differences, as a degree of 1 has them no other way."""
    axes, v = laid
    u, v = midpoints(0.0, 1.0, ROWS), midpoints(v[0], v[-1], COLUMNS * (len(v) - 1))

    def values(step: float, dx: int = 0) -> FloatArray:
        return np.stack([axis(u, v + step, dx=dx) for axis in axes], axis=-1)

    return from_slopes(values(0.0), values(0.0, 1), (values(STEP) - values(-STEP)) / (2.0 * STEP))


def thin_plate(places: FloatArray, values: FloatArray) -> RBFInterpolator:
    """The thin plate through values (k, p, c) at places (k, p, 2)."""
    flat = values.reshape(-1, values.shape[-1])
    return RBFInterpolator(places.reshape(-1, 2), flat, kernel="thin_plate_spline")


def jets(plate: RBFInterpolator, places: FloatArray) -> list[FloatArray]:
    """Values of a thin plate at places (k, w, 2) and their derivatives, by central differences."""
    shape = (*places.shape[:2], -1)

    def values(*step: float) -> FloatArray:
        moved = (places + np.array(step)).reshape(-1, 2)
        return np.asarray(plate(moved)).reshape(shape)

    halves = [(STEP, 0.0), (0.0, STEP)]
    slopes = [(values(*one) - values(-one[0], -one[1])) / (2.0 * STEP) for one in halves]
    return [values(0.0, 0.0), *slopes]


def parametric_lay(strips: Sequence[Strip]) -> Any:
    """Thin plates of x, y and z over arc length and distance across, metres."""
    points = stacked(strips)
    s = np.mean([strip.s for strip in strips], axis=0)
    places = np.stack(np.meshgrid(s, gaps(points), indexing="ij"), axis=2)
    return thin_plate(places, points), places


def parametric_sample(laid: Any) -> Sampled:
    """Its points and derivatives."""
    plate, places = laid
    return from_slopes(*jets(plate, places_between(places)))


def height_lay(strips: Sequence[Strip]) -> Any:
    """A thin plate of the height over the mean plane; ValueError where there is no one height."""
    points = stacked(strips)
    centre = points.reshape(-1, 3).mean(axis=0)
    axes = np.linalg.svd(points.reshape(-1, 3) - centre, full_matrices=False)[2]
    normals = np.concatenate([strip.normals for strip in strips])
    steep = np.degrees(np.arccos(np.clip(np.abs(normals @ axes[2]).min(), 0.0, 1.0)))
    upright = np.ptp(np.sign(normals @ axes[2])) == 0.0
    if steep > STEEPEST or not upright:
        raise ValueError(f"no height over a plane: up to {steep:.0f}° steep")
    local = (points - centre) @ axes.T
    return thin_plate(local[..., :2], local[..., 2:]), local[..., :2], (centre, axes)


def height_sample(laid: Any) -> Sampled:
    """Its points and normals."""
    plate, places, (centre, axes) = laid
    at = places_between(places)
    z, dx, dy = jets(plate, at)
    normals = unit(np.concatenate([-dx, -dy, np.ones_like(dx)], axis=2))
    return from_grid(np.concatenate([at, z], axis=2) @ axes + centre, normals @ axes)


def geomdl_lay(strips: Sequence[Strip]) -> Any:
    """geomdl's interpolating B-spline surface."""
    from geomdl import fitting

    points = stacked(strips)
    count, passes = points.shape[:2]
    flat = points.reshape(-1, 3).tolist()
    return fitting.interpolate_surface(flat, count, passes, 3, min(3, passes - 1)), passes


def geomdl_sample(laid: Any) -> Sampled:
    """Its points and derivatives, by its own evaluation."""
    surface, passes = laid
    v = midpoints(0.0, 1.0, COLUMNS * (passes - 1))
    found = [[surface.derivatives(a, b, 1) for b in v] for a in midpoints(0.0, 1.0, ROWS)]
    values = np.array(found)
    return from_slopes(values[:, :, 0, 0], values[:, :, 1, 0], values[:, :, 0, 1])


def poisson_lay(strips: Sequence[Strip], depth: int) -> Any:
    """Open3D's screened Poisson reconstruction from points and normals."""
    import open3d

    cloud = open3d.geometry.PointCloud()
    cloud.points = open3d.utility.Vector3dVector(np.concatenate([one.points for one in strips]))
    cloud.normals = open3d.utility.Vector3dVector(np.concatenate([one.normals for one in strips]))
    make = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson
    mesh, _ = make(cloud, depth=depth, linear_fit=True, n_threads=1)
    mesh.compute_vertex_normals()
    return mesh


def poisson_sample(mesh: Any) -> Sampled:
    """The middles of its triangles."""
    return from_triangles(*map(np.asarray, (mesh.vertices, mesh.vertex_normals, mesh.triangles)))


def own(name: str, **choice: Any) -> Program:
    """Georibbon with a choice of settings."""
    return Program(f"Georibbon, {name}", None, True, own_lay, own_sample, variants=(choice,))


PROGRAMS = (
    own("as it comes"),
    own("criterion 1", lengths="criterion1"),
    own("criterion 2", lengths="criterion2"),
    own("G2 interior", interior="g2"),
    own("planar sections", direction="section"),
    own("equal fractions", correspondence="fraction"),
    own(
        "as the source paper", direction="conormal", lengths="unit", correspondence="fraction"
    ),
    Program(
        "OpenCASCADE, loft",
        "cadquery-ocp-novtk",
        False,
        loft_lay,
        loft_sample,
        variants=({"degree": 3}, {"degree": 8}),
    ),
    Program(
        "OpenCASCADE, plate", "cadquery-ocp-novtk", False, plate_lay, plate_sample,
        variants=({"tangent": False, "order": 2}, {"tangent": False, "order": 3}),
    ),
    Program(
        "OpenCASCADE, plate with tangent planes", "cadquery-ocp-novtk", True, plate_lay,
        plate_sample, variants=({"tangent": True, "order": 2}, {"tangent": True, "order": 3}),
    ),
    Program("geomdl, interpolation", "geomdl", False, geomdl_lay, geomdl_sample),
    Program("SciPy, grid spline", "scipy", False, spline_lay, spline_sample),
    Program("SciPy, thin plates of x, y, z", "scipy", False, parametric_lay, parametric_sample),
    Program("SciPy, thin plate of the height", "scipy", False, height_lay, height_sample),
    Program(
        "Open3D, screened Poisson",
        "open3d",
        True,
        poisson_lay,
        poisson_sample,
        closed=True,
        variants=tuple({"depth": depth} for depth in range(5, 10)),
    ),
)  # fmt: skip
