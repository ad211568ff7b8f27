"""A surface into a file of any kind: triangles, or one spline for CAD programs."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.errors import ExportError
from georibbon.export.files import CAD_ENDINGS, SURFACE_ENDINGS, require_ending
from georibbon.export.mesh import Unit, write_mesh
from georibbon.geometry.surface import Surface

if TYPE_CHECKING:
    from georibbon.export.cad import CadFacts


def write_surface(surface: Surface, path: Path, unit: Unit, name: str) -> "CadFacts | None":
    """Write a surface; the format comes from the path's ending.

    A spline is within the tolerance that the surface was built with.  name: of the
    part, for CAD programs.  Returns what was found of a spline, None of triangles.
    Raises ExportError and SurfaceError as `write_mesh` and `write_cad` do, and for a
    solid that is to be one spline.
    """
    ending = require_ending(path, SURFACE_ENDINGS, "a surface")
    if ending not in CAD_ENDINGS:
        write_mesh(surface.export_mesh, path, unit)
        return None
    if surface.solid is not None:
        raise no_solid(path)
    if surface.plan is None:
        raise ExportError(f"{path}: this surface is triangles alone; write .stl, .obj or .ply")
    from georibbon.export.cad import write_cad

    return write_cad(surface.plan.model, surface.plan.tolerance, path, unit, name)


def require_cad(path: Path, thickness: float | None) -> None:
    """Raise ExportError where a file is for CAD programs and cannot be written.

    thickness: metres, of the solid that is asked for.
    """
    if path.suffix.lower() not in CAD_ENDINGS:
        return
    from georibbon.export.cad import require_kernel

    if thickness is not None:
        raise no_solid(path)
    require_kernel(path)


def no_solid(path: Path) -> ExportError:
    """The refusal of a solid for CAD programs."""
    return ExportError(
        f"{path}: a thickness was asked for, and a CAD file holds the surface alone; leave the "
        "thickness out and thicken it in the CAD program, or write .stl, .obj or .ply"
    )


def in_words(facts: "CadFacts") -> str:
    """What was found of a spline, as one says it."""
    along, across = facts.count
    corners = "" if facts.smooth else "; corners in its lines at the passes (c1-lines has none)"
    return (
        f"one spline within {1e3 * facts.deviation:.2g} mm and {math.degrees(facts.turn):.2g}° of "
        f"the patches, {along} × {across} control points, read back{corners}"
    )
