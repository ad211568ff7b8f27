"""``georibbon capture``: a whole capture from the terminal, guided step by step."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser, add_link_options, whole
from georibbon.export.files import require_ending

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.capture.link_diary import LinkDiary
    from georibbon.capture.plan import CapturePlan
    from georibbon.device.ring import Tap
    from georibbon.session.session import Session

DESCRIPTION = """\
Capture an object with a ribbon, step by step: the calibration poses on the bar, then
the passes and ties, each taken by itself as soon as the ribbon was moved and has lain
still for a second.  Everything taken is safe in the session file before it is told.  A
session that exists already is gone on with: close it tonight, go on tomorrow.

While it runs, one line of words at a time is understood:

  (an empty line)          take now what is asked for; on a terminal the space bar and
                           Page Down (foot pedal) do the same
  force                    take it in spite of a doubt
  NAME                     ask for this pose or pass next (pose-07, P3, T1); taken ones are repeated
  skip                     leave out what is asked for; its NAME brings it back
  add NAME [tie]           a further pass, or tie
  remove NAME              take a pose or pass out again
  undo, redo               the last change, back and forth
  mark PASS AT X Y Z [SIGMA]                  survey: in metres, AT along the ribbon
  distance PASS AT PASS AT METRES [SIGMA]
  crossing PASS AT PASS AT [SIGMA]
  forget mark|distance|crossing N             take one out of the survey
  note TEXT                kept with its time
  calibrate                from the poses taken so far
  auto on|off              take by stillness, or only on an empty line
  status                   what is done and what is left
  save FILE                go on in another place (disk full, folder gone); "save" tries again
  quit                     close the session"""

EPILOG = """\
a plan file (TOML), everything in it optional but the first two lines:
  format = "georibbon-plan"
  version = 1
  poses = 20            # 12, 16 or 20; 0: no calibration poses
  passes = 5            # P1 to P5
  ties = 2              # T1, T2
  [[mark]]              # the survey, as in a recording.toml: mark, distance, crossing
  pass = "P1"
  at = 0.0
  position = [0.020, -0.200, 0.013]
  sigma = 0.0005

try it without a ribbon, in two terminals:
  georibbon virtual --surface bonnet --pty ribbon --plan bonnet.plan.toml --play
  georibbon capture ribbon -o bonnet.georibbon --plan bonnet.plan.toml
and then:
  georibbon reconstruct bonnet.georibbon --surface bonnet.stl --report bonnet.html"""

IDENTITY_SECONDS = 15.0


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    add_link_options(parser)
    parser.add_argument(
        "-o", "--output", metavar="S.georibbon", type=Path, required=True,
        help="the session file, new or to go on with",
    )  # fmt: skip
    parser.add_argument("--plan", metavar="FILE", type=Path, help="a plan file, see below")
    parser.add_argument("--poses", metavar="N", type=whole, help="12, 16, 20 (default) or 0")
    parser.add_argument("--passes", metavar="N", type=whole, help="how many passes (default 5)")
    parser.add_argument("--ties", metavar="N", type=whole, help="how many ties (default 0)")
    parser.add_argument(
        "--calibration", metavar="FILE", type=Path,
        help="a calibration of this ribbon, in place of the poses",
    )  # fmt: skip
    parser.add_argument(
        "--manual", action="store_true", help="take on an empty line only, not by stillness"
    )
    parser.add_argument(
        "--keep-all", action="store_true", help="keep the frames between poses and passes too"
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Connect, open the session, talk until it ends."""
    from georibbon.capture.link_diary import LinkDiary
    from georibbon.capture.plan import CapturePlan, read_plan
    from georibbon.capture.start import open_capture
    from georibbon.device.link import Link
    from georibbon.session.calibration_file import read_calibration

    require_ending(arguments.output, (".georibbon",), "a session")
    plan = None if arguments.plan is None else read_plan(arguments.plan)
    counts = _counts(arguments)
    (plan or CapturePlan()).with_counts(counts)  # refused before anything is opened
    given = None if arguments.calibration is None else read_calibration(arguments.calibration)
    link = Link(arguments.url, rate=arguments.rate, ribbon_id=arguments.id, baudrate=arguments.baud)
    diary, tap = LinkDiary(link), link.recorder()
    with link:
        identity = link.wait_for_identity(IDENTITY_SECONDS)
        session, plan = open_capture(arguments.output, identity, plan, counts)
        with session:
            _talk(tap, diary, session, plan, given, arguments)


def _talk(
    tap: "Tap",
    diary: "LinkDiary",
    session: "Session",
    plan: "CapturePlan",
    calibration: "Calibration | None",
    arguments: argparse.Namespace,
) -> None:
    from georibbon.capture.engine import Engine
    from georibbon.cli.dialogue import Dialogue, summary

    engine = Engine(session, plan, auto=not arguments.manual)
    print(f"ribbon {engine.ribbon.id} at {arguments.url}, session {session.path}")
    for words in (*session.warnings, *([session.recovery.message] if session.recovery else [])):
        print(words)
    if calibration is not None:
        engine.use_calibration(calibration)
    current = engine.current
    print("everything is taken" if current is None else f"-> {current.key}: {current.words}")
    Dialogue(tap, diary, session, engine).run(arguments.keep_all)
    print(summary(engine, session))


def _counts(arguments: argparse.Namespace) -> dict[str, int]:
    """The numbers of poses, passes and ties that were given."""
    names = ("poses", "passes", "ties")
    given = {name: getattr(arguments, name) for name in names}
    # With a calibration that is there already, a new session needs no poses.
    if arguments.calibration is not None and not arguments.output.exists():
        given["poses"] = given["poses"] or 0
    return {name: count for name, count in given.items() if count is not None}
