"""``georibbon virtual``: a ribbon that is not there, on a port that is."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser, number, whole
from georibbon.cli.outputs import Outputs
from georibbon.cli.simulation import (
    GROUPS,
    Option,
    add_option,
    default_of,
    parameter,
    settings_from,
    surfaces_told,
)
from georibbon.errors import ExportError, GeoribbonError, SettingsError

if TYPE_CHECKING:
    from georibbon.virtual import Port, VirtualRibbon, VirtualSettings

DESCRIPTION = """\
Be a ribbon: speak its protocol in real time on a pseudo-terminal or a TCP port of this
machine, hanging in the hands, laid on a reference surface or on a mesh, or in the
calibration's poses.  The first line printed is `ribbon at URL`; give that URL to
`georibbon record` or `georibbon capture` in another terminal.

Then it reads commands from standard input, a line each, and answers each with a line.
When standard input ends it goes on until it is interrupted (or, with --play, until
everything was played), so that `< /dev/null` lets it run in the background.  After
`unplug` and `replug` the ribbon's clock and sequence numbers go on, and it is silent
until the host says start, as a ribbon with its own battery is.

The hands of `play` do not look: what the host refuses is not laid again.  A ribbon has at
most 43 sensors here: its identity must fit into one packet.

The same words give the same sensors, passes and survey as `georibbon simulate`.

commands:
{commands}

surfaces, with the parameters that --parameter changes:
{surfaces}
"""

EPILOG = """\
examples:
  georibbon virtual --pty ribbon
  georibbon virtual --surface dome --ties 2 --tcp 127.0.0.1:7000 --truth dome.truth.json
  georibbon virtual --mesh part.stl --unit mm --passes 7 --pty --plan part.plan.toml
  georibbon virtual --pty ribbon --play --hold 4"""

DEFAULT_SURFACE = "bonnet"
# What `simulate` calls --plan is the number of poses; here --plan is the plan's file.
ELSEWHERE = {"--plan", "--frames"}
POSES = Option("--poses", "poses.plan", whole, "N", "a plan of so many poses; 0: no poses")


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    from georibbon.simulation import SimulationSettings
    from georibbon.virtual import COMMANDS

    commands = "\n".join(f"  {one.usage}\n      {one.help}" for one in COMMANDS.values())
    parser.teach(DESCRIPTION.format(commands=commands, surfaces=surfaces_told()), EPILOG)
    _add_place(parser)
    _add_behaviour(parser)
    for title, options in GROUPS.items():
        group = parser.add_argument_group(title)
        shown = [option for option in options if option.flag not in ELSEWHERE]
        if title == "the calibration poses":
            shown.insert(0, POSES)
        for option in shown:
            add_option(group, option, default_of(SimulationSettings(), option.setting))
    parser.set_defaults(run=run)


def _add_place(parser: Parser) -> None:
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--pty", metavar="PATH", nargs="?", const="",
        help="a pseudo-terminal, behind a link at PATH or, without it, in a private folder",
    )  # fmt: skip
    where.add_argument(
        "--tcp", metavar="HOST:PORT", help="a TCP port of this machine, such as 127.0.0.1:0"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--surface", metavar="SURFACE", default=DEFAULT_SURFACE,
        help=f"a reference surface (default {DEFAULT_SURFACE})",
    )  # fmt: skip
    what.add_argument(
        "--mesh", metavar="FILE", type=Path,
        help="a triangle mesh: STL, OBJ or PLY; --start is then X,Y in metres, --heading from "
        "the x direction",
    )  # fmt: skip
    parser.add_argument(
        "--unit", choices=("mm", "m"), default="mm",
        help="of the mesh's coordinates, which a file does not tell (default mm)",
    )  # fmt: skip
    parser.add_argument(
        "--parameter", metavar="NAME=NUMBER", type=parameter, action="append", default=[],
        help="one of the surface's parameters; may be repeated",
    )  # fmt: skip
    parser.add_argument("--truth", metavar="FILE", type=Path, help="write the truth there (JSON)")
    parser.add_argument(
        "--plan", metavar="FILE", type=Path,
        help="write a plan of the capture with its survey there, for `georibbon capture --plan`",
    )  # fmt: skip
    parser.add_argument(
        "--tell-heading", action="store_true", help="the plan says the workpiece's heading"
    )


def _add_behaviour(parser: Parser) -> None:
    group = parser.add_argument_group("the hands and the cable")
    group.add_argument(
        "--play", action="store_true",
        help="all poses, then all passes and ties, from when a host starts the frames",
    )  # fmt: skip
    for flag, metavar, default, told in (
        ("--hold", "S", 3.0, "how long poses and play hold each place still"),
        ("--pace", "FACTOR", 1.0, "how slow the hands are; 0: there at once"),
        ("--drop", "SHARE", 0.0, "of the frames, lost on the cable"),
        ("--damage", "SHARE", 0.0, "of the frames, damaged on the cable"),
        ("--noise", "FACTOR", 1.0, "of the sensors' own noise"),
    ):
        group.add_argument(
            flag, metavar=metavar, type=number, default=default,
            help=f"{told} (default {default:g})",
        )  # fmt: skip
    group.add_argument(
        "--firmware", metavar="TEXT", default="1.0.0", help="its version (default 1.0.0)"
    )


def virtual_settings(arguments: argparse.Namespace) -> "VirtualSettings":
    """The settings that the words ask for."""
    from georibbon.virtual import MeshSettings, VirtualSettings

    mesh = None if arguments.mesh is None else MeshSettings(arguments.mesh, arguments.unit)
    return VirtualSettings(
        simulation=settings_from(arguments),
        mesh=mesh,
        firmware=arguments.firmware,
        hold=arguments.hold,
        pace=arguments.pace,
        drop=arguments.drop,
        damage=arguments.damage,
        noise=arguments.noise,
        play=arguments.play,
    )


def run(arguments: argparse.Namespace) -> None:
    """Serve a virtual ribbon and carry out the commands on standard input."""
    from georibbon.virtual import VirtualRibbon

    if arguments.mesh is not None and arguments.parameter:
        raise SettingsError("a mesh has no parameters; leave --parameter out")
    host, port = (None, 0) if arguments.tcp is None else _address(arguments.tcp)
    world = VirtualRibbon(virtual_settings(arguments))
    _write(world, arguments.truth, arguments.plan)
    with _served(world, arguments.pty, host, port) as served:
        print(f"ribbon at {served.url}", flush=True)
        for line in _lines():
            print(_answer(world, line), flush=True)
            if world.ended.is_set() or not served.serves:
                return
        _go_on(world, served, arguments.play)


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise SettingsError(f"--tcp {text}: write it as HOST:PORT, such as 127.0.0.1:0")
    return host, int(port)


def _write(world: "VirtualRibbon", truth: Path | None, plan: Path | None) -> None:
    """The truth and the plan, where they are wanted, before anyone asks for them."""
    from georibbon.simulation import write_truth

    with Outputs([path for path in (truth, plan) if path is not None]) as outputs:
        if truth is not None:
            write_truth(world.truth, outputs.place(truth))
        if plan is not None:
            _keep(plan, world.plan_text())
            outputs.place(plan).write_text(world.plan_text(), encoding="utf-8")


def _keep(plan: Path, text: str) -> None:
    """Refuse to write over a plan that a person may have worked on."""
    if plan.exists() and plan.read_bytes() != text.encode():
        raise ExportError(
            f"{plan}: there is another file of this name and it is not overwritten; move it away "
            "or choose another name"
        )


def _served(world: "VirtualRibbon", link: str | None, host: str | None, port: int) -> "Port":
    from georibbon.virtual import serve_pty, serve_tcp

    if host is not None:
        return serve_tcp(world, host, port)
    return serve_pty(world, Path(link) if link else None)


def _lines() -> Iterator[str]:
    """The lines of standard input that are not empty; of one too long only its beginning."""
    longest = 4096
    whole_before = True
    while sys.stdin is not None and (data := sys.stdin.buffer.readline(longest)):
        line = data.decode("utf-8", errors="replace").strip()
        if line and whole_before:
            yield line
        whole_before = data.endswith(b"\n")


def _answer(world: "VirtualRibbon", line: str) -> str:
    try:
        return world.do(line)
    except GeoribbonError as error:
        return f"error: {error}"


def _go_on(world: "VirtualRibbon", served: "Port", play: bool) -> None:
    """Serve on, until everything was played, or until interrupted or a fault ends it."""
    done = world.played if play else world.ended
    while served.serves and not done.wait(
        0.5
    ):  # in turns, so that an interruption is noticed on every system
        continue
