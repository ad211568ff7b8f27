"""``georibbon reconstruct``: the main job."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser, millimetres, pair
from georibbon.cli.outputs import Outputs, signals_held
from georibbon.cli.printing import print_reconstruction
from georibbon.errors import SettingsError
from georibbon.export.files import (
    CURVES_ENDINGS,
    PICTURE_ENDINGS,
    REPORT_ENDINGS,
    SURFACE_ENDINGS,
    require_ending,
)

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.reconstruction import Reconstruction, ReconstructionSettings
    from georibbon.session.source import Loaded

ALL_PASSES = "*"

DESCRIPTION = """\
Turn a recording into the surface that the ribbon was laid on: calibrate from the poses,
fit all passes together with the survey, lay a surface through them, check it.

Printed is one line a pass: its length, the standard deviation of its position (rms),
and whether it is good, acceptable or should be captured again, with the reason.
Whatever was ignored or assumed follows as a notice; look at these.

Files are written all together at the end, or none."""

EPILOG = """\
examples:
  georibbon reconstruct bonnet --surface bonnet.stl
  georibbon reconstruct bonnet.georibbon --surface bonnet.obj --surface print.stl \\
      --thickness 2 --report bonnet.html --picture bonnet.png
  georibbon reconstruct bonnet --curves bonnet.csv --smoothing 60 --smoothing P3=90
  georibbon reconstruct part-31 --calibration ribbon-7.json --report part-31.json"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "source", metavar="SOURCE", type=Path, help="recording folder or .georibbon session"
    )
    _add_outputs(parser.add_argument_group("what to write"))
    _add_settings(parser.add_argument_group("how to reconstruct"))
    parser.set_defaults(run=run)


def _add_outputs(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--surface", metavar="FILE", type=Path, action="append", default=[],
        help="the surface as .stl (binary), .obj or .ply; may be repeated",
    )  # fmt: skip
    group.add_argument(
        "--unit", choices=("mm", "m"), default="mm",
        help="of the surface files: millimetres (default) or metres; the report tells it",
    )  # fmt: skip
    group.add_argument(
        "--curves", metavar="FILE", type=Path,
        help="the passes as .csv, in metres: pass, s, x, y, z, nx, ny, nz, sigma, …",
    )  # fmt: skip
    group.add_argument(
        "--report", metavar="FILE", type=Path, action="append", default=[],
        help=".json for programs, .html for people; may be repeated",
    )  # fmt: skip
    group.add_argument(
        "--picture", metavar="FILE", type=Path,
        help="a .png of the surface coloured by its uncertainty",
    )  # fmt: skip


def _add_settings(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--method", choices=("ribbon", "paper"), default="ribbon",
        help="ribbon (default): all readings of a pass fitted at once, with the survey; "
        "paper: tangents interpolated from sensor to sensor",
    )  # fmt: skip
    group.add_argument(
        "--calibration", metavar="FILE", type=Path,
        help="use this calibration (georibbon calibrate) instead of the recording's poses",
    )  # fmt: skip
    group.add_argument(
        "--no-neighbours", dest="neighbours", action="store_false",
        help="fit without letting neighbouring passes correct each other",
    )  # fmt: skip
    group.add_argument(
        "--smoothing", metavar="auto|MM|PASS=MM", type=_smoothing, action="append", default=[],
        help="the finest detail to follow, in mm: for all passes or for one, may be repeated; "
        "auto (default): as fine as the readings themselves support",
    )  # fmt: skip
    group.add_argument(
        "--tolerance", metavar="MM", type=millimetres,
        help="how far the triangles may be from the surface, in mm (default 0.05)",
    )  # fmt: skip
    group.add_argument(
        "--thickness", metavar="MM", type=millimetres,
        help="thicken the surface inwards to a closed solid of so many mm, for printing",
    )  # fmt: skip


def _smoothing(text: str) -> tuple[str, float | None]:
    """(pass name, metres), for all passes under the name `ALL_PASSES`; None: automatic."""
    name, value = pair(text, "auto, MM or PASS=MM") if "=" in text else (ALL_PASSES, text)
    return name, None if value == "auto" else millimetres(value)


def run(arguments: argparse.Namespace) -> None:
    """Reconstruct, write what was asked for, print the summary."""
    from georibbon.reconstruction import reconstruct
    from georibbon.session.source import load

    with Outputs(targets(arguments), inputs=(arguments.source, arguments.calibration)) as outputs:
        settings = settings_from(arguments)
        calibration = _calibration(arguments.calibration)
        loaded = load(arguments.source)
        settings, used = with_session(settings, loaded, {name for name, _ in arguments.smoothing})
        if calibration is None and loaded.calibration is not None:
            calibration = loaded.calibration
            used.append("from the session: the calibration")
        result = reconstruct(loaded.recording, settings, calibration)
        write(result, outputs, arguments, loaded.recording.title)
    print_reconstruction(result)
    for line in used:
        print(line)
    for target in outputs.targets:
        unit = f" ({arguments.unit})" if target in arguments.surface else ""
        print(f"written: {target}{unit}")


def targets(arguments: argparse.Namespace) -> list[Path]:
    """All files to write; ExportError for an ending that names no format."""
    curves = [arguments.curves] if arguments.curves else []
    pictures = [arguments.picture] if arguments.picture else []
    for paths, endings, what in (
        (arguments.surface, SURFACE_ENDINGS, "a surface"),
        (curves, CURVES_ENDINGS, "curves"),
        (arguments.report, REPORT_ENDINGS, "a report"),
        (pictures, PICTURE_ENDINGS, "a picture"),
    ):
        for path in paths:
            require_ending(path, endings, what)
    return [*arguments.surface, *curves, *arguments.report, *pictures]


def _calibration(path: Path | None) -> "Calibration | None":
    from georibbon.session.calibration_file import read_calibration

    return None if path is None else read_calibration(path)


def settings_from(arguments: argparse.Namespace) -> "ReconstructionSettings":
    """The settings that the words ask for; no surface where curves alone are wanted."""
    from georibbon.geometry.surface import SurfaceSettings
    from georibbon.reconstruction import ReconstructionSettings

    smoothing = {name: value for name, value in arguments.smoothing if value is not None}
    if smoothing and arguments.method == "paper":
        raise SettingsError("--smoothing is for --method ribbon; the paper's way smooths nothing")
    surface = SurfaceSettings(thickness=arguments.thickness)
    if arguments.tolerance is not None:
        surface = replace(surface, tolerance=arguments.tolerance)
    others = arguments.surface or arguments.report or arguments.picture
    if arguments.curves and not others:
        for option in ("tolerance", "thickness"):
            if getattr(arguments, option) is not None:
                raise SettingsError(f"--{option} is of the surface; name its file with --surface")
    return ReconstructionSettings(
        method=arguments.method,
        neighbours=arguments.neighbours,
        smoothing=smoothing,
        surface=None if arguments.curves and not others else surface,
    )


def with_session(
    settings: "ReconstructionSettings", loaded: "Loaded", asked: set[str]
) -> tuple["ReconstructionSettings", list[str]]:
    """The settings, with the session's smoothing where the words ask for none, and what was added.

    asked: the passes whose smoothing the words give, `ALL_PASSES` for all.
    """
    if settings.method != "ribbon" or ALL_PASSES in asked:
        return settings, []
    added = {name: value for name, value in loaded.smoothing.items() if name not in asked}
    told = [
        f"from the session: the smoothing of {'all passes' if name == ALL_PASSES else name}, "
        f"{1e3 * value:g} mm"
        for name, value in added.items()
    ]
    return replace(settings, smoothing={**settings.smoothing, **added}), told


def write(
    result: "Reconstruction", outputs: Outputs, arguments: argparse.Namespace, title: str | None
) -> None:
    """Prepare every output."""
    for path in arguments.surface:
        _write_surface(result, outputs.place(path), arguments.unit)
    if arguments.curves:
        from georibbon.export.curves import write_curves

        write_curves(result, outputs.place(arguments.curves))
    for path in arguments.report:
        with signals_held():
            from georibbon.export.report import write_report

            write_report(
                result,
                outputs.place(path),
                source=str(arguments.source),
                unit=arguments.unit,
                files=[target.name for target in outputs.targets],
                title=title,
            )
    if arguments.picture:
        with signals_held():
            from georibbon.export.picture import write_picture

            write_picture(result, outputs.place(arguments.picture))


def _write_surface(result: "Reconstruction", place: Path, unit: str) -> None:
    from georibbon.export.mesh import write_mesh

    if result.surface is not None:
        write_mesh(result.surface.export_mesh, place, "m" if unit == "m" else "mm")
