"""A result's surface made anew for a file, and results to look at beside one another."""

from dataclasses import dataclass, replace

import numpy as np

from georibbon.errors import ExportError
from georibbon.geometry.alignment import Motion
from georibbon.geometry.frames import Strip
from georibbon.geometry.mesh import Mesh, area, is_watertight
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.surface import Surface, build_surface
from georibbon.reconstruction import FittedPass, Reconstruction, ties_of


@dataclass(frozen=True)
class MeshFacts:
    """What a person asks of a mesh; size: along x, y and z, metres; area: m²."""

    triangles: int
    vertices: int
    size: tuple[float, float, float]
    area: float
    watertight: bool


def surface_with(result: Reconstruction, settings: SurfaceSettings) -> Surface:
    """The surface through the fitted passes with other settings of the surface.

    Raises ExportError where the result has no surface, SurfaceError where the
    settings give none.
    """
    if result.surface is None:
        raise ExportError("there is no surface to write; mend what the passes are told of first")
    curves = [one for one in result.passes if one.kind == "pass"]
    return build_surface(
        [one.strip for one in curves],
        [one.name for one in curves],
        settings,
        [one.position_sigma for one in curves],
        [one.normal_sigma for one in curves],
        ties_of(result.passes),
    )


def mesh_facts(mesh: Mesh) -> MeshFacts:
    """The facts of a mesh."""
    x, y, z = np.ptp(mesh.vertices, axis=0).tolist() if len(mesh.vertices) else (0.0, 0.0, 0.0)
    return MeshFacts(
        len(mesh.triangles), len(mesh.vertices), (x, y, z), area(mesh), is_watertight(mesh)
    )


def with_mesh(result: Reconstruction, mesh: Mesh) -> Reconstruction:
    """The result with this mesh as its surface, to be looked at."""
    return replace(result, survey=(), surface=Surface(mesh, area(mesh), ()))


def moved(result: Reconstruction, motion: Motion) -> Reconstruction:
    """The result, passes and surface, where a rigid motion carries it, to be looked at."""
    surface = result.surface
    if surface is not None:
        mesh = surface.mesh
        mesh = replace(
            mesh, vertices=motion.applied(mesh.vertices), normals=motion.turned(mesh.normals)
        )
        surface = Surface(mesh, surface.area, surface.checks)
    passes = tuple(_moved(one, motion) for one in result.passes)
    return replace(result, passes=passes, survey=(), surface=surface)


def _moved(fitted: FittedPass, motion: Motion) -> FittedPass:
    strip, turn = fitted.strip, motion.rotation
    return replace(
        fitted,
        strip=Strip(strip.s, motion.applied(strip.points), turn @ strip.frames),
        covariance=turn @ fitted.covariance @ turn.T,
    )
