"""Two surfaces compared: how the first lies from the second, and their passes side by side."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from georibbon import __version__
from georibbon.arrays import FloatArray, IntArray
from georibbon.errors import ExportError
from georibbon.export.summary import as_json
from georibbon.geometry.alignment import Motion, align
from georibbon.geometry.deviation import (
    DeviationStatistics,
    deviation,
    deviation_statistics,
    vertex_areas,
)
from georibbon.geometry.mesh import Mesh
from georibbon.geometry.nearest import TriangleLocator
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.session.files import kind_of
from georibbon.session.mesh_file import KINDS, read_triangles

TOLERANCE = 0.5e-3
"""Metres, unless a person says otherwise."""


@dataclass(frozen=True, eq=False)
class Other:
    """What is compared with: a mesh, and the result that it is the surface of, if of any."""

    name: str
    mesh: Mesh
    result: Reconstruction | None = None


@dataclass(frozen=True, eq=False)
class Comparison:
    """How the first surface lies from the other.

    values: (n,) metres, of the first mesh's vertices, positive where it lies on
    the outer side of the other, NaN where the other covers nothing.  statistics:
    None where they have nothing in common.  motion: what laid the first onto the
    other before, where that was asked for.
    """

    name: str
    other: Other
    values: FloatArray
    statistics: DeviationStatistics | None
    motion: Motion | None = None


@dataclass(frozen=True, eq=False)
class PassPair:
    """The passes of one name in both; None where one has none of it."""

    name: str
    first: FittedPass | None
    second: FittedPass | None


def is_mesh_file(path: Path) -> bool:
    """Whether a path names a mesh file by its ending."""
    return path.suffix.lower().removeprefix(".") in KINDS and kind_of(path) != "folder"


def read_other(path: Path, unit: str = "mm") -> Other:
    """What lies at a path: a mesh file in `unit`, or a session or recording, reconstructed.

    Raises the errors of reading and reconstructing, and ExportError where there
    is no surface.
    """
    if is_mesh_file(path):
        found = read_triangles(path, unit, ExportError)
        return Other(path.name, _with_normals(found.vertices, found.triangles))
    from georibbon.reconstruction import reconstruct
    from georibbon.session.source import load

    loaded = load(path)
    result = reconstruct(loaded.recording, loaded.settings, loaded.calibration)
    return other_of(result, path.absolute().name)


def other_of(result: Reconstruction, name: str) -> Other:
    """A result to compare with; ExportError where it has no surface."""
    if result.surface is None:
        raise ExportError(f"{name}: it has no surface to compare with")
    return Other(name, result.surface.mesh, result)


def compare(
    result: Reconstruction,
    name: str,
    other: Other,
    tolerance: float = TOLERANCE,
    aligned: bool = False,
) -> Comparison:
    """How a result's surface lies from another.

    tolerance: metres, for the share that is within.  aligned: lay it onto the
    other as well as it goes before, where the two have frames of their own.
    Raises ExportError where it has no surface.
    """
    mesh = other_of(result, name).mesh
    locator = TriangleLocator(other.mesh.vertices, other.mesh.triangles)
    points, motion = mesh.vertices, None
    if aligned:
        motion = align(points, locator, other.mesh.vertices)
        points = motion.applied(points)
    values = deviation(points, locator)
    areas = vertex_areas(mesh.vertices, mesh.triangles)
    found = deviation_statistics(values, areas, tolerance)
    return Comparison(name, other, values, found, motion)


def with_tolerance(comparison: Comparison, mesh: Mesh, tolerance: float) -> Comparison:
    """The same comparison, of this mesh, counted with another tolerance."""
    areas = vertex_areas(mesh.vertices, mesh.triangles)
    found = deviation_statistics(comparison.values, areas, tolerance)
    return Comparison(
        comparison.name, comparison.other, comparison.values, found, comparison.motion
    )


def pass_pairs(first: Reconstruction, second: Reconstruction | None) -> tuple[PassPair, ...]:
    """The passes of both by their names: those of the first in its order, then the others."""
    mine = {one.name: one for one in first.passes}
    theirs = {one.name: one for one in second.passes} if second is not None else {}
    names = dict.fromkeys([*mine, *theirs])
    return tuple(PassPair(name, mine.get(name), theirs.get(name)) for name in names)


def comparison_data(comparison: Comparison, first: Reconstruction) -> dict[str, Any]:
    """The comparison as JSON holds it; names end with their unit."""
    found, motion = comparison.statistics, comparison.motion
    data: dict[str, Any] = as_json(
        {
            "georibbon": __version__,
            "first": comparison.name,
            "second": comparison.other.name,
            "deviation": found
            and {
                "covered": found.covered,
                "mean_mm": 1e3 * found.mean,
                "rms_mm": 1e3 * found.rms,
                "p95_mm": 1e3 * found.p95,
                "lowest_mm": 1e3 * found.lowest,
                "highest_mm": 1e3 * found.highest,
                "tolerance_mm": 1e3 * found.tolerance,
                "within": found.within,
            },
            "aligned": motion
            and {
                "turned_deg": float(np.degrees(motion.angle)),
                "rotation": motion.rotation.tolist(),
                "translation_m": motion.translation.tolist(),
            },
            "passes": [
                {"name": pair.name, "first": _pass(pair.first), "second": _pass(pair.second)}
                for pair in pass_pairs(first, comparison.other.result)
            ],
        }
    )
    return data


def _pass(fitted: FittedPass | None) -> dict[str, Any] | None:
    if fitted is None:
        return None
    return {
        "quality": fitted.quality.verdict,
        "position_sigma_mm": 1e3 * float(np.sqrt(np.mean(fitted.position_sigma**2))),
        "smoothing_mm": 1e3 * fitted.smoothing,
    }


def _with_normals(vertices: FloatArray, triangles: IntArray) -> Mesh:
    """A mesh with the normals of its vertices, by the areas around them."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    sums = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(sums, triangles[:, k], np.cross(b - a, c - a))
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return Mesh(vertices, triangles, sums / np.where(lengths > 0, lengths, 1.0))
