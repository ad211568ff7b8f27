"""One thing to write of a result, as a person chose it, and how it is written."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from georibbon.errors import ExportError, GeoribbonError
from georibbon.export.files import (
    CURVES_ENDINGS,
    SURFACE_ENDINGS,
    require_ending,
)
from georibbon.export.mesh import Unit
from georibbon.export.surface_files import write_surface
from georibbon.export.surfaces import surface_with
from georibbon.geometry.mesh import Mesh
from georibbon.geometry.settings import SurfaceSettings
from georibbon.reconstruction import Reconstruction
from georibbon.recording import Recording
from georibbon.session.files import built_file, kind_of

if TYPE_CHECKING:
    from georibbon.export.cad import CadFacts

Kind = Literal["surface", "curves", "report", "recording"]
KINDS: tuple[Kind, ...] = ("surface", "curves", "report", "recording")
ENDINGS: dict[Kind, tuple[str, ...]] = {
    "surface": SURFACE_ENDINGS,
    "curves": CURVES_ENDINGS,
    "report": (".html", ".pdf", ".json"),
    "recording": ("",),
}


class CancelledError(Exception):
    """It was cancelled; nothing was written."""


@dataclass(frozen=True)
class Choice:
    """What to write, and where.

    unit: of a surface's numbers.  settings: of the surface, with its tolerance
    and thickness; of all others as they are.
    """

    kind: Kind
    path: Path
    unit: Unit = "mm"
    settings: SurfaceSettings = field(default_factory=SurfaceSettings)


def write(
    choice: Choice,
    result: Reconstruction | None,
    recording: Callable[[], Recording],
    source: str,
    title: str | None,
    cancelled: Callable[[], bool],
) -> "CadFacts | None":
    """Write what was chosen, whole or not at all; returns what was found of a spline.

    result: of what is open; a recording's folder needs none.  recording: gives
    what was captured.  source: what is open, for the report.  cancelled: asked
    before anything is put in its place.  Raises ExportError and the other
    errors of what is written, and CancelledError.
    """
    if choice.kind == "recording":
        from georibbon.session.folder import write_recording

        captured = recording()
        _go_on(cancelled)
        write_recording(captured, choice.path)
        return None
    require_ending(choice.path, ENDINGS[choice.kind], f"a {choice.kind}")
    if result is None:
        raise ExportError("there is no result to write yet; mend what is told of first")
    if kind_of(choice.path) == "folder":
        raise ExportError(f"{choice.path} is a folder, a file was expected; add a file's name")
    with built_file(choice.path, ExportError) as built:
        try:
            facts = _write(replace(choice, path=built), result, source, title)
        except GeoribbonError as error:
            error.args = (str(error).replace(str(built), str(choice.path)),)
            raise
        _go_on(cancelled)
    return facts


def mesh_of(choice: Choice, result: Reconstruction) -> Mesh:
    """The very mesh that is written of a surface."""
    return surface_with(result, choice.settings).export_mesh


def _write(
    choice: Choice, result: Reconstruction, source: str, title: str | None
) -> "CadFacts | None":
    if choice.kind == "surface":
        surface = surface_with(result, choice.settings)
        return write_surface(surface, choice.path, choice.unit, title or Path(source).stem)
    if choice.kind == "curves":
        from georibbon.export.curves import write_curves

        write_curves(result, choice.path)
    else:
        from georibbon.export.report import write_report

        write_report(result, choice.path, source=source, unit=choice.unit, title=title)
    return None


def _go_on(cancelled: Callable[[], bool]) -> None:
    if cancelled():
        raise CancelledError
