"""``georibbon surface``: the surface through curves of any origin."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser, zero_or_millimetres
from georibbon.cli.outputs import Outputs, signals_held
from georibbon.cli.printing import print_notices, print_surface
from georibbon.cli.reconstruction import add_surface, require_heard
from georibbon.cli.result_files import add_files, print_written, targets, write_surfaces
from georibbon.errors import ExportError
from georibbon.geometry.settings import NORMAL_RULES, SurfaceSettings
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.export.laying import Laid, LaidCurve
    from georibbon.geometry.framing import FramingSettings
    from georibbon.session.curves_file import CurvesFile

DESCRIPTION = """\
Lay a surface through curves of any origin, such as those that `reconstruct --curves`
writes, and check it.  The curves must run side by side, each nearly a geodesic, as a
ribbon's are: a straight way over the surface.

CURVES.csv has a header line and one row a point, its columns in any order: x, y, z; and,
where they are known, pass (the curve's name), s (arc length), nx, ny, nz (normal), sigma,
kind (pass, or tie: one across the others, for --cells).  Without pass, blank lines part the
curves.  Without normals they are found from the way in which each curve bends.

Printed is one line a curve, every check that is not passed, with advice, and the notices.
Files are written all together at the end, or none."""

EPILOG = """\
examples:
  georibbon surface curves.csv --surface part.stl
  georibbon surface scan.csv --curves-unit mm --surface part.obj --picture part.png
  georibbon surface noisy.csv --position-cut 40 --normal-cut 150 --curves smooth.csv \\
      --report noisy.json
  georibbon surface curves.csv --normals spline --normal-cut 100 --surface paper.stl"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument("source", metavar="CURVES.csv", type=Path, help="the curves, .csv")
    parser.add_argument(
        "--curves-unit", choices=("mm", "cm", "m", "in"), default="m",
        help="of the lengths in CURVES.csv (default m, as Georibbon writes them)",
    )  # fmt: skip
    add_files(
        parser.add_argument_group("what to write"),
        unit="of the surface files (default mm)",
        curves="the curves as they were laid, as .csv, in metres, with all columns",
        report="curves, checks and notices as .json, for programs; may be repeated",
        picture="a .png of the surface and the curves",
    )
    group = parser.add_argument_group("how to take the curves")
    group.add_argument(
        "--normals", choices=NORMAL_RULES,
        help="find the normals, even where the file has some: from the side to which the curve "
        "bends, whatever its sign (doubled-angle, default where the file has none), from "
        "smoothed binormals (spline), from the bend as it is with its sign kept from point to "
        "point (continuous) or not (raw)",
    )  # fmt: skip
    group.add_argument(
        "--normal-cut", metavar="MM", type=zero_or_millimetres,
        help="smooth away what the normals do over less than so many mm, 0: nothing; with "
        "--normals spline, from knot to knot (default: what the noise asks for)",
    )  # fmt: skip
    group.add_argument(
        "--position-cut", metavar="MM", type=zero_or_millimetres,
        help="likewise of the points",
    )  # fmt: skip
    add_surface(parser.add_argument_group("how to lay the surface"))
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Lay the surface, write what was asked for, print what it is."""
    from georibbon.export.laying import lay
    from georibbon.session.curves_file import read_curves

    with Outputs(targets(arguments, _require_json), inputs=(arguments.source,)) as outputs:
        framing, settings = _framing(arguments), _settings(arguments)
        file = read_curves(arguments.source, arguments.curves_unit)
        laid = lay(file.curves, framing, settings, measured=arguments.normals is None)
        told = _write(laid, outputs, arguments)
        _write_reports(laid, file, (framing, settings), outputs, arguments)
    for curve in laid.curves:
        print(_line(curve, framing.normals))
    print_surface(laid.surface)
    print_notices((*file.notices, *laid.notices))
    print_written(outputs, arguments, told)


def _require_json(path: Path) -> None:
    """Raise ExportError for a report that is none for programs."""
    if path.suffix.lower() != ".json":
        raise ExportError(
            f"{path}: a report on curves is written as .json; pages (.html, .pdf) are of "
            "recordings, by georibbon reconstruct"
        )


def _framing(arguments: argparse.Namespace) -> "FramingSettings":
    from georibbon.geometry.framing import FramingSettings

    return FramingSettings(
        arguments.normals or "doubled-angle", arguments.normal_cut, arguments.position_cut
    )


def _settings(arguments: argparse.Namespace) -> SurfaceSettings:
    """The surface's settings that the words ask for, read as a session's are."""
    from georibbon.fitting.settings import ReconstructionSettings
    from georibbon.session.settings import OF_SURFACE, SURFACE, with_setting

    settings = ReconstructionSettings()
    asked = {key: getattr(arguments, key.removeprefix(SURFACE)) for key in OF_SURFACE}
    asked = {key: value for key, value in asked.items() if value is not None}
    for key, value in asked.items():
        settings = with_setting(settings, "*", key, value)
    surface = settings.surface or SurfaceSettings()
    require_heard(surface, asked)
    return surface


def _write(laid: "Laid", outputs: Outputs, arguments: argparse.Namespace) -> dict[Path, str]:
    """Prepare the surface, the curves and the picture; returns what is to be told of surfaces."""
    from georibbon.export.curves import write_strips

    told = write_surfaces(laid.surface, outputs, arguments, arguments.source.stem)
    if arguments.curves:
        curves = [(one.name, one.kind, one.strip, one.sigma) for one in laid.curves]
        write_strips(curves, outputs.place(arguments.curves))
    if arguments.picture:
        with signals_held():
            from georibbon.export.laying import shown
            from georibbon.export.picture import write_picture

            write_picture(shown(laid), outputs.place(arguments.picture))
    return told


def _write_reports(
    laid: "Laid",
    file: "CurvesFile",
    chosen: tuple["FramingSettings", SurfaceSettings],
    outputs: Outputs,
    arguments: argparse.Namespace,
) -> None:
    """Prepare the reports."""
    from georibbon.export.laid_report import laid_data, write_laid_report

    for path in arguments.report:
        data = laid_data(
            laid,
            *chosen,
            source=str(arguments.source),
            unit=arguments.unit,
            files=[target.name for target in outputs.targets],
            notices=file.notices,
        )
        write_laid_report(outputs.place(path), data)


def _line(curve: "LaidCurve", rule: str) -> str:
    """A curve for a person."""
    framed = curve.framed
    told = [f"normals {'measured' if framed.measured else f'found ({rule})'}"]
    if framed.normal_cut > 0.0:
        told[0] += f" over {1e3 * framed.normal_cut:.0f} mm"
    if framed.position_cut > 0.0:
        told.append(
            f"points smoothed over {1e3 * framed.position_cut:.0f} mm "
            f"(noise {1e3 * framed.noise:.2g} mm)"
        )
    length = curve.strip.s[-1] - curve.strip.s[0]
    points = counted(len(curve.strip.s), "point")
    return f"{curve.name:8} {curve.kind:5} {length:.3f} m  {points}  {', '.join(told)}"
