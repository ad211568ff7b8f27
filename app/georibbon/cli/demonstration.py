"""``georibbon demo``: all of it, once, on an object worth looking at."""

import argparse
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli import reconstruction
from georibbon.cli.arguments import Parser
from georibbon.cli.outputs import Outputs, folder_made
from georibbon.cli.printing import print_reconstruction

if TYPE_CHECKING:
    from georibbon.simulation import Score

DESCRIPTION = """\
Capture a virtual car bonnet with a virtual ribbon that is as imperfect as a real one,
keep the capture as a session, reconstruct the surface from it, and compare with the
truth.  Needs no ribbon, and takes some seconds.

With a display the window opens on it.  Without one, or with --output, the results are
written as files instead."""

EPILOG = """\
what comes out, in build/demo unless --output says otherwise:
  demo.georibbon   the capture: raw counts, poses, passes, survey
  surface.stl      the surface, in mm, for CAD and printing
  surface.obj      the same with its normals
  surface.png      a picture of it, coloured by its uncertainty
  curves.csv       the passes, in metres, with normals and standard deviations
  report.html      everything about the result, for people
  report.json      the same for programs

with --window a window of its own opens on demo.georibbon at the end, where there is a
display; this command ends meanwhile.  It is left out where the environment has CI or
GEORIBBON_NO_WINDOW.

then try:
  georibbon build/demo/demo.georibbon
  georibbon info build/demo/demo.georibbon
  georibbon reconstruct build/demo/demo.georibbon --surface build/demo/thick.stl --thickness 3"""

SESSION = "demo.georibbon"
FOLDER = Path("build/demo")
UNSEEN = ("offscreen", "minimal")  # platforms of Qt that show nothing to anybody
_opened: list[subprocess.Popen[bytes]] = []  # windows that go on by themselves


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path,
        help="write files into this folder, made if need be (default build/demo)",
    )  # fmt: skip
    parser.add_argument(
        "--window", action="store_true",
        help="write files, and then open the window on the result, where there is a display",
    )  # fmt: skip
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Open the window on the demonstration, or write its files.

    Ends by SystemExit where the window ended with another code than 0.
    """
    if arguments.output is None and not arguments.window:
        why = why_unseen(os.environ)
        if why is None:
            from georibbon.cli.window import run_demonstration

            if code := run_demonstration():
                raise SystemExit(code)
            return
        print(f"{why}; the results are written into {FOLDER}, as make demo does\n")
    folder: Path = arguments.output or FOLDER
    write_files(folder)
    if arguments.window:
        _open_window(folder / SESSION)


def why_unseen(environment: Mapping[str, str]) -> str | None:
    """Why nobody would see a window here; None where it would be seen."""
    from georibbon.gui.display import PLATFORM, why_no_display

    if environment.get(PLATFORM, "").partition(":")[0] in UNSEEN:
        return "there is no display here to show the window on"
    return why_no_display(environment)


def _open_window(session: Path) -> None:
    """Open the window in a process of its own, so that nothing waits for it."""
    why = why_unseen(os.environ)
    for name in ("CI", "GEORIBBON_NO_WINDOW"):
        if os.environ.get(name):
            why = f"the environment has {name}"
    if why is not None:
        print(f"\nno window is opened: {why}")
        return
    print(f"\nthe window opens on {session}; georibbon {session} opens it again")
    sys.stdout.flush()
    said = None if sys.stderr.isatty() else subprocess.DEVNULL
    _opened.append(
        subprocess.Popen(  # noqa: S603 - this program itself
            [sys.executable, "-m", "georibbon", str(session.absolute())],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            start_new_session=True,
        )
    )


def write_files(folder: Path) -> None:
    """Simulate, keep, reconstruct, write, compare."""
    from georibbon.reconstruction import reconstruct
    from georibbon.session.file import create_session, read_session
    from georibbon.simulation import score, simulate
    from georibbon.simulation.demonstration import demonstration_settings

    wanted = _wanted(folder)
    targets = [folder / SESSION, *reconstruction.targets(wanted)]
    with folder_made(folder), Outputs(targets) as outputs:
        simulation = simulate(demonstration_settings())
        session = outputs.place(folder / SESSION)
        create_session(session, simulation.recording)
        result = reconstruct(read_session(session), reconstruction.settings_from(wanted))
        reconstruction.write(result, outputs, wanted, simulation.recording.title)
    print_reconstruction(result)
    _print_score(score(result, simulation.truth))
    _print_places(outputs)


def _wanted(folder: Path) -> argparse.Namespace:
    """What `georibbon reconstruct` would be asked."""
    parser = Parser(prog="georibbon demo")
    reconstruction.configure("reconstruct", parser)
    files = {
        "--surface": ("surface.stl", "surface.obj"),
        "--picture": ("surface.png",),
        "--curves": ("curves.csv",),
        "--report": ("report.json", "report.html"),
    }
    words = [str(folder / SESSION)]
    for flag, names in files.items():
        words += [f"{flag}={folder / name}" for name in names]
    return parser.parse_args(words)


def _print_score(found: "Score") -> None:
    curves = found.curves.all
    print("\nerror against the truth (rms, and the worst):")
    print(f"  curves   {curves.rms:.2f} mm   (worst {curves.max:.2f})")
    print(f"  normals  {curves.normal_rms:.2f} degrees   (worst {curves.normal_max:.2f})")
    if found.surface_rms is not None:
        print(f"  surface  {found.surface_rms:.2f} mm   (worst {found.surface_max:.2f})")


def _print_places(outputs: Outputs) -> None:
    print("\nresults:")
    for target in outputs.targets:
        print(f"  {target}")
