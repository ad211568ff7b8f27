"""The files of a surface and its curves: the words for them, what they may be, what is told."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.outputs import Outputs, signals_held
from georibbon.export.files import (
    CAD_ENDINGS,
    CURVES_ENDINGS,
    PICTURE_ENDINGS,
    SURFACE_ENDINGS,
    require_ending,
)

if TYPE_CHECKING:
    from georibbon.geometry.surface import Surface


def add_files(
    group: argparse._ArgumentGroup, *, unit: str, curves: str, report: str, picture: str
) -> None:
    """The words that name files to write; what differs between commands is told by them."""
    group.add_argument(
        "--surface", metavar="FILE", type=Path, action="append", default=[],
        help="the surface as .stl (binary), .obj or .ply, or as one spline for CAD programs, "
        ".step or .iges (they need the extra cad); may be repeated",
    )  # fmt: skip
    group.add_argument("--unit", choices=("mm", "cm", "m", "in"), default="mm", help=unit)
    group.add_argument("--curves", metavar="FILE", type=Path, help=curves)
    group.add_argument(
        "--report", metavar="FILE", type=Path, action="append", default=[], help=report
    )
    group.add_argument("--picture", metavar="FILE", type=Path, help=picture)


def targets(arguments: argparse.Namespace, require_report: Callable[[Path], object]) -> list[Path]:
    """All files to write; ExportError for an ending that names no format.

    require_report: raises it for an ending that is no report's.
    """
    curves = [arguments.curves] if arguments.curves else []
    pictures = [arguments.picture] if arguments.picture else []
    for paths, endings, what in (
        (arguments.surface, SURFACE_ENDINGS, "a surface"),
        (curves, CURVES_ENDINGS, "curves"),
        (pictures, PICTURE_ENDINGS, "a picture"),
    ):
        for path in paths:
            require_ending(path, endings, what)
    for path in arguments.report:
        require_report(path)
    check_cad(arguments.surface, arguments.thickness)
    return [*arguments.surface, *curves, *arguments.report, *pictures]


def check_cad(surfaces: Sequence[Path], thickness: float | None) -> None:
    """Raise ExportError where files for CAD programs are wanted that cannot be written.

    thickness: metres, of the solid that is asked for.
    """
    if any(path.suffix.lower() in CAD_ENDINGS for path in surfaces):
        from georibbon.export.surface_files import require_cad

        with signals_held():  # the kernel takes an interrupt while it loads for a fault of its own
            for path in surfaces:
                require_cad(path, thickness)


def write_surfaces(
    surface: "Surface | None", outputs: Outputs, arguments: argparse.Namespace, name: str
) -> dict[Path, str]:
    """Prepare the surface's files; returns what is to be told of some beside their names."""
    from georibbon.export.surface_files import in_words, write_surface

    told: dict[Path, str] = {}
    if surface is None:
        return told
    for path in arguments.surface:
        with signals_held():
            facts = write_surface(surface, outputs.place(path), arguments.unit, name)
        if facts is not None:
            told[path] = f", {in_words(facts)}"
    return told


def print_written(
    outputs: Outputs, arguments: argparse.Namespace, told: Mapping[Path, str]
) -> None:
    """A line a file, with the unit of the surface's and what is to be told of it."""
    for target in outputs.targets:
        unit = f" ({arguments.unit})" if target in arguments.surface else ""
        print(f"written: {target}{unit}{told.get(target, '')}")
