"""``georibbon reconstruct``: the main job."""

import argparse
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli import result_files
from georibbon.cli.arguments import Parser, above_zero, millimetres, number, pair
from georibbon.cli.outputs import Outputs, signals_held
from georibbon.cli.printing import print_reconstruction
from georibbon.cli.result_files import add_files, print_written, write_surfaces
from georibbon.errors import SettingsError
from georibbon.export.files import REPORT_ENDINGS, require_ending
from georibbon.geometry.settings import (
    CORRESPONDENCES,
    DIRECTIONS,
    INTERIORS,
    LENGTHS,
    TANGENTS,
    SurfaceSettings,
)

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.reconstruction import Reconstruction, ReconstructionSettings
    from georibbon.session.source import Loaded

ALL_PASSES = "*"
OF_RIBBON = ("smoothing", "weight")  # what the paper's way knows nothing of
OF_PAPER = ("tangents",)  # and what it alone knows

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
  georibbon reconstruct bonnet --surface bonnet.stl --sensors-off P3=A09,M09 \\
      --trim P1=20,0 --weight P5=0.25
  georibbon reconstruct part-31 --calibration ribbon-7.json --report part-31.json"""


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "source", metavar="SOURCE", type=Path, help="recording folder or .georibbon session"
    )
    add_files(
        parser.add_argument_group("what to write"),
        unit="of the surface files (default mm); the report tells it",
        curves="the passes as .csv, in metres: pass, s, x, y, z, nx, ny, nz, sigma, …",
        report=".html or .pdf for people, .json for programs; may be repeated",
        picture="a .png of the surface coloured by its uncertainty",
    )
    add_settings(parser.add_argument_group("how to reconstruct"))
    parser.set_defaults(run=run)


def add_settings(group: argparse._ArgumentGroup) -> None:
    """The words that say how to reconstruct."""
    group.add_argument(
        "--method", choices=("ribbon", "paper"),
        help="ribbon (default): all readings of a pass fitted at once, with the survey; "
        "paper: tangents interpolated from sensor to sensor",
    )  # fmt: skip
    group.add_argument(
        "--tangents", choices=TANGENTS,
        help="for --method paper: how tangents are interpolated, by unrolling the sphere "
        "(unrolled, default), by averages on it (averages), or by components, made unit",
    )  # fmt: skip
    group.add_argument(
        "--calibration", metavar="FILE", type=Path,
        help="use this calibration (georibbon calibrate) instead of the recording's poses",
    )  # fmt: skip
    group.add_argument(
        "--neighbours", action=argparse.BooleanOptionalAction,
        help="let neighbouring passes correct each other (default), or not",
    )  # fmt: skip
    group.add_argument(
        "--smoothing", metavar="auto|MM|PASS=MM", type=_smoothing, action="append", default=[],
        help="the finest detail to follow, in mm: for all passes or for one, may be repeated; "
        "auto (default): as fine as the readings themselves support",
    )  # fmt: skip
    group.add_argument(
        "--sensors-off", metavar="[PASS=]NAME,…", type=_sensors, action="append", default=[],
        help="do not listen to these sensors, in all passes or in one; may be repeated",
    )  # fmt: skip
    group.add_argument(
        "--trim", metavar="[PASS=]MM,MM", type=_trim, action="append", default=[],
        help="cut so much off the start and the end of all passes or of one, for the curve and "
        "the surface; may be repeated",
    )  # fmt: skip
    group.add_argument(
        "--weight", metavar="[PASS=]NUMBER", type=_weight, action="append", default=[],
        help="let all passes or one count so many times against neighbours and survey "
        "(default 1); may be repeated",
    )  # fmt: skip
    add_surface(group)


def add_surface(group: argparse._ArgumentGroup) -> None:
    """The words that say how the surface is laid through the passes."""
    group.add_argument(
        "--direction", choices=DIRECTIONS,
        help="of the surface's lines across where they meet a pass: the chord to the neighbour, "
        "kept from turning back (safe-chord, default) or not (chord), square to the pass "
        "(conormal), in the plane of chord and normal (section), or at --angles",
    )  # fmt: skip
    group.add_argument(
        "--angles", metavar="A,B,C,D", type=_angles,
        help="for --direction angles, in degrees from square to the pass towards its run: where "
        "lines leave a pass at its beginning and end, and where they reach the next",
    )  # fmt: skip
    group.add_argument(
        "--lengths", metavar="CRITERION|A,B", type=_lengths,
        help="the tangents' lengths across: those of a circular arc (arc, default), the chord's "
        f"(unit), those that minimise a criterion ({', '.join(LENGTHS[2:])}), or so many times "
        "the chord's at either end, such as 1.1,0.9",
    )  # fmt: skip
    group.add_argument(
        "--correspondence", choices=CORRESPONDENCES,
        help="what lies across from what: feet, covering both passes to their ends (foot-cover, "
        "default) or cut to where they overlap (foot-trim), equal lengths, equal fractions",
    )  # fmt: skip
    group.add_argument(
        "--interior", choices=INTERIORS,
        help="across inner passes: smooth (g1, default), with lines that run on smoothly "
        "(c1-lines), or with equal curvature on both sides (g2)",
    )  # fmt: skip
    group.add_argument(
        "--cells", action=argparse.BooleanOptionalAction,
        help="let the surface run through the ties too, where they close cells with the passes "
        "(Coons patches; for --interior g1), or not (default)",
    )  # fmt: skip
    group.add_argument(
        "--tolerance", metavar="MM", type=millimetres,
        help="how far triangles, or the spline of a CAD file, may be from the surface, in mm "
        "(default 0.05)",
    )  # fmt: skip
    group.add_argument(
        "--thickness", metavar="MM", type=millimetres,
        help="thicken the surface inwards to a closed solid of so many mm, for printing",
    )  # fmt: skip


def _smoothing(text: str) -> tuple[str, float | None]:
    """(pass name, metres), for all passes under the name `ALL_PASSES`; None: automatic."""
    name, value = pair(text, "auto, MM or PASS=MM") if "=" in text else (ALL_PASSES, text)
    return name, None if value == "auto" else millimetres(value)


def _sensors(text: str) -> tuple[str, list[str]]:
    """(pass name or `ALL_PASSES`, names of sensors)."""
    name, value = pair(text, "NAME,… or PASS=NAME,…") if "=" in text else (ALL_PASSES, text)
    names = [one.strip() for one in value.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"{value!r} found, names of sensors expected: A09,M09")
    return name, names


def _trim(text: str) -> tuple[str, list[float]]:
    """(pass name or `ALL_PASSES`, [metres of the start, metres of the end])."""
    name, value = pair(text, "MM,MM or PASS=MM,MM") if "=" in text else (ALL_PASSES, text)
    ends = [number(one) for one in value.split(",")]
    if len(ends) != 2 or min(ends) < 0:
        raise argparse.ArgumentTypeError(
            f"{value!r} found, two lengths expected: mm of the start, mm of the end"
        )
    return name, [one / 1000.0 for one in ends]


def _weight(text: str) -> tuple[str, float]:
    """(pass name or `ALL_PASSES`, how many times it counts)."""
    name, value = pair(text, "NUMBER or PASS=NUMBER") if "=" in text else (ALL_PASSES, text)
    return name, above_zero(value)


def _lengths(text: str) -> str | list[float]:
    """A criterion's name, or the factors of the chord at either end."""
    if text in LENGTHS:
        return text
    try:
        factors = [number(one) for one in text.split(",")]
    except argparse.ArgumentTypeError:
        factors = []
    if len(factors) != 2:
        raise argparse.ArgumentTypeError(
            f"{text!r} found, two factors such as 1,1 or one of {', '.join(LENGTHS)} expected"
        )
    return factors


def _angles(text: str) -> list[float]:
    angles = [number(one) for one in text.split(",")]
    if len(angles) != 4:
        raise argparse.ArgumentTypeError(f"{text!r} found, four angles expected: 0,0,0,0")
    return angles


def run(arguments: argparse.Namespace) -> None:
    """Reconstruct, write what was asked for, print the summary."""
    from georibbon.reconstruction import reconstruct
    from georibbon.session.source import load

    with Outputs(targets(arguments), inputs=(arguments.source, arguments.calibration)) as outputs:
        settings_from(arguments)  # what is wrong with the words is told before the work
        calibration = _calibration(arguments.calibration)
        loaded = load(arguments.source)
        settings, used = with_session(arguments, loaded)
        if calibration is None and loaded.calibration is not None:
            calibration = loaded.calibration
            used.append("from the session: the calibration")
        result = reconstruct(loaded.recording, settings, calibration)
        told = write(result, outputs, arguments, loaded.recording.title)
    print_reconstruction(result)
    for line in used:
        print(line)
    print_written(outputs, arguments, told)


def targets(arguments: argparse.Namespace) -> list[Path]:
    """All files to write; ExportError for an ending that names no format."""
    return result_files.targets(
        arguments, lambda path: require_ending(path, REPORT_ENDINGS, "a report")
    )


def _calibration(path: Path | None) -> "Calibration | None":
    from georibbon.session.calibration_file import read_calibration

    return None if path is None else read_calibration(path)


def settings_from(arguments: argparse.Namespace) -> "ReconstructionSettings":
    """The settings that the words ask for; no surface where curves alone are wanted.

    Raises SettingsError for words that mean nothing, or nothing together.
    """
    return _settings(arguments, _asked(arguments))


def with_session(
    arguments: argparse.Namespace, loaded: "Loaded"
) -> tuple["ReconstructionSettings", list[str]]:
    """The settings of the words, with the session's where they ask for none, and what was added.

    What the words give for all passes stands in the place of all that the
    session has of it.
    """
    from georibbon.session.actions import setting_in_words
    from georibbon.session.settings import KEYS, OF_SURFACE

    asked = _asked(arguments)
    passes = {one.name for one in loaded.recording.passes}
    taken = {
        (whose, key): value
        for (whose, key), value in loaded.values.items()
        if key in KEYS
        and (whose in passes or whose == ALL_PASSES)
        and (whose, key) not in asked
        and (ALL_PASSES, key) not in asked
    }
    method = asked.get((ALL_PASSES, "method"), taken.get((ALL_PASSES, "method"), "ribbon"))
    if method == "ribbon" and (ALL_PASSES, "tangents") in asked:
        raise SettingsError(
            "--tangents is for --method paper; the fit to the readings interpolates no tangents"
        )
    unheard = OF_PAPER if method == "ribbon" else OF_RIBBON
    taken = {place: value for place, value in taken.items() if place[1] not in unheard}
    settings = _settings(arguments, {**taken, **asked})
    if settings.surface is None:
        taken = {place: value for place, value in taken.items() if place[1] not in OF_SURFACE}
    else:
        require_heard(settings.surface, [key for _, key in asked])
    told = [
        f"from the session: {setting_in_words(whose, key)}, {_in_words(key, value)}"
        for (whose, key), value in taken.items()
    ]
    return settings, told


def _asked(arguments: argparse.Namespace) -> dict[tuple[str, str], object]:
    """The words as a session keeps settings; None: as where nothing is chosen."""
    from georibbon.session.settings import BY_PASS, OF_SURFACE

    asked: dict[tuple[str, str], object] = {}
    for key in BY_PASS:
        for whose, value in getattr(arguments, key):
            asked[whose, key] = value
    for key in ("method", "neighbours", "tangents"):
        asked[ALL_PASSES, key] = getattr(arguments, key)
    for key in OF_SURFACE:
        asked[ALL_PASSES, key] = getattr(arguments, key.removeprefix("surface."))
    return {
        place: value for place, value in asked.items() if value is not None or place[1] in BY_PASS
    }


def _settings(
    arguments: argparse.Namespace, values: Mapping[tuple[str, str], object]
) -> "ReconstructionSettings":
    from georibbon.fitting.settings import ReconstructionSettings
    from georibbon.session.settings import OF_SURFACE, with_setting

    settings = ReconstructionSettings()
    for (whose, key), value in values.items():
        settings = with_setting(settings, whose, key, value)
    if settings.method == "paper":
        for key in OF_RIBBON:
            if getattr(settings, key):
                raise SettingsError(
                    f"--{key} is for --method ribbon; the paper's way smooths and weighs nothing"
                )
    others = arguments.surface or arguments.report or arguments.picture
    if not arguments.curves or others:
        return settings
    for key in OF_SURFACE:
        option = key.removeprefix("surface.")
        if getattr(arguments, option) is not None:
            raise SettingsError(f"--{option} is of the surface; name its file with --surface")
    return replace(settings, surface=None)


def require_heard(surface: SurfaceSettings, asked: Collection[str]) -> None:
    """Raise SettingsError where a surface's setting was asked for and another takes its place.

    asked: the settings' keys.
    """
    lost = [] if surface.uses_direction else ["direction", "angles"]
    if not surface.uses_lengths or (surface.lengths == "criterion4" and surface.interior != "g1"):
        lost.append("lengths")
    rival = "lengths criterion4" if surface.interior == "g1" else f"interior {surface.interior}"
    for option in lost:
        if f"surface.{option}" in asked:
            raise SettingsError(
                f"--{option} has no effect here, as --{rival} takes its place; leave one of them "
                "out"
            )
    if "surface.angles" in asked and surface.direction != "angles":
        raise SettingsError(
            "--angles is for --direction angles; ask for that direction too, or leave the angles "
            "out"
        )


def _in_words(key: str, value: object) -> str:
    """A session's value as a person writes it: lengths in mm."""
    if key in ("smoothing", "surface.tolerance", "surface.thickness"):
        return f"{1e3 * float(str(value)):g} mm"
    if key == "trim" and isinstance(value, list):
        return " and ".join(f"{1e3 * one:g} mm" for one in value)
    listed = value if isinstance(value, list) else [value]
    return ", ".join(str(one) for one in listed)


def write(
    result: "Reconstruction", outputs: Outputs, arguments: argparse.Namespace, title: str | None
) -> dict[Path, str]:
    """Prepare every output; returns what is to be told of surfaces, where there is something."""
    name = title or arguments.source.stem
    told = write_surfaces(result.surface, outputs, arguments, name)
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
    return told
