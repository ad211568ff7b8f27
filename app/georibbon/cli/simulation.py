"""``georibbon simulate``: a virtual capture from words."""

import argparse
import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from georibbon.cli.arguments import Parser, number, pair, whole
from georibbon.cli.outputs import Outputs
from georibbon.errors import SettingsError

if TYPE_CHECKING:
    from georibbon.simulation.settings import SimulationSettings

DESCRIPTION = """\
Make the recording of a virtual ribbon on a reference surface, as a real ribbon would
give it, and its truth beside it: the folder DIR (recording.toml, calibration/, passes/)
and DIR.truth.json with every pass's true points and normals every centimetre.

The same words give the same recording; --seed draws other errors.  Lengths are in
metres, angles in degrees, noise and errors as standard deviations.

surfaces, with the parameters that --parameter changes:
"""

EPILOG = """\
examples:
  georibbon simulate bonnet -o build/bonnet
  georibbon simulate sphere -o build/ball --parameter radius=0.3 --seed 7
  georibbon simulate saddle -o build/saddle --survey none --ties 3 --sensors 48
  georibbon simulate dome -o build/faulty --dead A05 --dead M12 --magnet 0.25"""


@dataclass(frozen=True)
class Option:
    """One option: the setting it sets, how a word of it is read, and what it means."""

    flag: str
    setting: str
    read: Callable[[str], Any]
    metavar: str
    help: str


def _pose(text: str) -> tuple[float, float, float, bool]:
    words = text.split(",")
    table = words[-1] == "table"
    angles = words[:-1] if table else words
    if len(angles) != 3:
        raise argparse.ArgumentTypeError(
            f"{text!r} found, ROLL,HEADING,PITCH or ROLL,HEADING,PITCH,table expected"
        )
    roll, heading, pitch = (number(word) for word in angles)
    return roll, heading, pitch, table


def _place(text: str) -> tuple[float, float]:
    words = text.split(",")
    if len(words) != 2:
        raise argparse.ArgumentTypeError(f"{text!r} found, U,V expected")
    return number(words[0]), number(words[1])


def _survey(text: str) -> tuple[str, ...]:
    return () if text == "none" else tuple(text.split(","))


def parameter(text: str) -> tuple[str, float]:
    """NAME=NUMBER."""
    name, value = pair(text, "NAME=NUMBER, such as radius=0.3,")
    return name, number(value)


GROUPS: dict[str, tuple[Option, ...]] = {
    "what": (
        Option("--seed", "seed", whole, "N", "draws all errors and noise"),
        Option("--title", "title", str, "TEXT", "the recording's title"),
        Option("--frames", "frames", whole, "N", "frames in each file"),
        Option("--dip", "dip", number, "DEG", "the field below the horizontal"),
        Option("--yaw", "yaw", number, "DEG", "the workpiece's heading; drawn if not given"),
    ),
    "the ribbon": (
        Option("--ribbon-id", "ribbon.id", str, "ID", "its name"),
        Option(
            "--sensors", "ribbon.sensors", whole, "N",
            "accelerometers and magnetometers together, alternating",
        ),
        Option("--length", "ribbon.length", number, "M", "its length"),
        Option(
            "--magnetometer-axes", "ribbon.magnetometer_axes", whole, "N",
            "2: along and across; 3: out of the surface as well",
        ),
        Option("--rate", "ribbon.rate", number, "HZ", "frames a second"),
        Option("--acceleration-noise", "ribbon.acceleration_noise", number, "G", "a sample"),
        Option(
            "--field-noise", "ribbon.field_noise", number, "SHARE", "a sample, of the local field"
        ),
        Option("--bias", "ribbon.bias", number, "G", "of the accelerometers"),
        Option("--scale", "ribbon.scale", number, "SHARE", "error of the gain"),
        Option("--cross-axis", "ribbon.cross_axis", number, "SHARE", "cross terms of the gain"),
        Option("--mounting", "ribbon.mounting", number, "DEG", "of each sensor, each axis"),
        Option("--hard-iron", "ribbon.hard_iron", number, "SHARE", "of the local field"),
        Option("--soft-iron", "ribbon.soft_iron", number, "SHARE", "of the local field"),
    ),
    "the calibration poses": (
        Option("--plan", "poses.plan", whole, "N", "a plan of so many poses; 0: no poses"),
        Option(
            "--pose", "poses.poses", _pose, "R,H,P[,table]",
            "a pose by roll, heading and pitch, in place of a plan; give it for each pose, "
            "and as --pose=-90,0,0 where it begins with a minus",
        ),
        Option(
            "--heading-care", "poses.heading_care", number, "DEG", "headings done from asked"
        ),
        Option("--pitch-care", "poses.pitch_care", number, "DEG", "pitches done from asked"),
        Option("--bend", "poses.bend", number, "DEG", "of the bar at each sensor"),
        Option("--table-tilt", "poses.table_tilt", number, "DEG", "of the table, each axis"),
    ),
    "the passes": (
        Option("--passes", "layout.passes", whole, "N", "how many"),
        Option(
            "--start", "layout.start", _place, "U,V",
            "surface coordinates of their middle; by default the surface's own",
        ),
        Option(
            "--heading", "layout.heading", number, "DEG",
            "from the surface's u direction; by default the surface's own",
        ),
        Option(
            "--spacing", "layout.spacing", number, "M",
            "between neighbours; by default the surface's own",
        ),
        Option("--fan", "layout.fan", number, "DEG", "between neighbours: not parallel"),
        Option(
            "--fan-kind", "layout.fan_kind", str, "KIND",
            "alternate: by turns one way and the other; spread: ever further",
        ),
        Option("--ties", "layout.ties", whole, "N", "cross passes"),
        Option(
            "--tie-place", "layout.tie_places", number, "SHARE",
            "where a tie crosses the middle pass, 0 to 1; give it for each tie",
        ),
        Option(
            "--contact", "layout.contact", number, "DEG", "of each sensor on the surface"
        ),
    ),
    "the survey": (
        Option(
            "--survey", "survey.kinds", _survey, "KINDS",
            "any of starts,ends,distances separated by commas, or none",
        ),
        Option("--mark-sigma", "survey.mark_sigma", number, "M", "of starts and ends"),
        Option("--distance-sigma", "survey.distance_sigma", number, "M", "of distances"),
        Option("--crossing-sigma", "survey.crossing_sigma", number, "M", "of tie crossings"),
    ),
    "faults": (
        Option("--dead", "faults.dead", str, "SENSOR", "says nothing but 0; may be repeated"),
        Option("--magnet", "faults.magnet", number, "SHARE", "a magnet, of the local field"),
        Option("--magnet-on", "faults.magnet_on", str, "PASS", "beside which pass"),
        Option(
            "--magnet-place", "faults.magnet_place", number, "M",
            "how far along it; by default its middle",
        ),
        Option("--magnet-reach", "faults.magnet_reach", number, "M", "how far it disturbs"),
        Option("--lost", "faults.lost", number, "SHARE", "of all values"),
    ),
}  # fmt: skip
REPEATED = {"poses.poses", "layout.tie_places", "faults.dead"}


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    from georibbon.simulation.settings import SimulationSettings
    from georibbon.simulation.surfaces import SURFACES

    parser.teach(DESCRIPTION + surfaces_told(), EPILOG)
    parser.add_argument("surface", metavar="SURFACE", help=f"one of {', '.join(SURFACES)}")
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, required=True,
        help="the recording folder to make, new or empty; DIR.truth.json comes beside it",
    )  # fmt: skip
    parser.add_argument(
        "--parameter", metavar="NAME=NUMBER", type=parameter, action="append", default=[],
        help="one of the surface's parameters; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--tell-heading", action="store_true", help="the recording says the workpiece's heading"
    )
    for title, options in GROUPS.items():
        group = parser.add_argument_group(title)
        for option in options:
            add_option(group, option, default_of(SimulationSettings(), option.setting))
    parser.set_defaults(run=run)


def surfaces_told() -> str:
    """The surfaces with their parameters, a line each, for a help text."""
    from georibbon.simulation.surfaces import SURFACES

    return "\n".join(
        f"  {name:10} {kind.description}"
        + "".join(f", {key} {value:g}" for key, value in kind.parameters.items())
        for name, kind in SURFACES.items()
    ).replace("%", "%%")


def add_option(group: Any, option: Option, default: object) -> None:
    """Add one option to a group of a parser."""
    told = "" if default in (None, (), "") else f" (default {_told(default)})"
    group.add_argument(
        option.flag,
        dest=option.setting,
        type=option.read,
        metavar=option.metavar,
        action="append" if option.setting in REPEATED else "store",
        default=argparse.SUPPRESS,
        help=option.help + told,
    )


def _told(default: object) -> str:
    return ",".join(map(str, default)) if isinstance(default, tuple) else str(default)


def default_of(settings: "SimulationSettings", setting: str) -> object:
    """A setting's value by its dotted name, such as "ribbon.length"."""
    return functools.reduce(getattr, setting.split("."), settings)


def settings_from(arguments: argparse.Namespace) -> "SimulationSettings":
    """The settings that the words ask for."""
    from georibbon.simulation.settings import SimulationSettings, changed

    settings = SimulationSettings(
        surface=arguments.surface,
        parameters=dict(arguments.parameter),
        tell_heading=arguments.tell_heading,
    )
    names = [option.setting for options in GROUPS.values() for option in options]
    given = {name: getattr(arguments, name) for name in names if name in arguments}
    return changed(
        settings,
        {name: tuple(value) if name in REPEATED else value for name, value in given.items()},
    )


def run(arguments: argparse.Namespace) -> None:
    """Simulate; write the recording and its truth."""
    from georibbon.session.folder import write_recording
    from georibbon.simulation import simulate, write_truth

    folder: Path = arguments.output
    _refuse(folder)
    truth = folder.with_name(folder.name + ".truth.json")
    with Outputs([truth]) as outputs:
        simulation = simulate(settings_from(arguments))
        write_truth(simulation.truth, outputs.place(truth))
        write_recording(simulation.recording, folder)
    print(f"written: {folder} (the recording)\nwritten: {truth} (the truth)")


def _refuse(folder: Path) -> None:
    """Refuse a folder that cannot be made, before any work."""
    if not folder.name or folder.name == "..":
        raise SettingsError(f"{folder}: name a new folder for the recording")
    if not folder.parent.is_dir():
        raise SettingsError(
            f"{folder}: there is no folder {folder.parent}; make it or choose another place"
        )
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise SettingsError(f"{folder}: this is there already; give a new or an empty folder")
