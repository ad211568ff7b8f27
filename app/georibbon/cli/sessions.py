"""``georibbon info``, ``import`` and ``export``: what is in a recording, and moving it."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser
from georibbon.cli.printing import json_text
from georibbon.export.files import require_ending
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.recording import Recording
    from georibbon.session.describe import Facts

TEXTS = {
    "info": (
        """\
Tell what a recording folder or a .georibbon session holds: the ribbon, its calibration
poses, its passes and ties, the survey; of a session also its notes, what was done and
when.  Everything is read and checked on the way, and nothing is changed.  A session may
be unfinished, open in another program, or left by a crash.""",
        """\
examples:
  georibbon info bonnet-recording
  georibbon info bonnet.georibbon --json     # for programs""",
    ),
    "import": (
        """\
Put a recording folder into a session file: one file that holds all raw counts, the
poses, the passes and the survey.  Nothing is lost: `georibbon export` gives the same
recording back.""",
        """\
example:
  georibbon import bonnet-recording -o bonnet.georibbon""",
    ),
    "export": (
        """\
Write the raw data of a session as a recording folder: plain text, a recording.toml and
one CSV file of counts for each pose and pass.  What a recording has no place for, such as
notes, is told.""",
        """\
example:
  georibbon export bonnet.georibbon --recording bonnet-recording""",
    ),
}


def configure(name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(*TEXTS[name])
    if name == "info":
        parser.add_argument(
            "source", metavar="SOURCE", type=Path, help="recording folder or .georibbon session"
        )
        parser.add_argument("--json", action="store_true", help="print one JSON object")
    elif name == "import":
        parser.add_argument("recording", metavar="RECORDING", type=Path, help="recording folder")
        parser.add_argument(
            "-o", "--output", metavar="S.georibbon", type=Path, required=True,
            help="the session file to make; one that is there already is never overwritten",
        )  # fmt: skip
    else:
        parser.add_argument("session", metavar="S.georibbon", type=Path, help="session file")
        parser.add_argument(
            "--recording", metavar="DIR", type=Path, required=True,
            help="the folder to make; it must be new or empty",
        )  # fmt: skip
    parser.set_defaults(run={"info": info, "import": import_, "export": export}[name])


def import_(arguments: argparse.Namespace) -> None:
    """Recording folder to session file."""
    from georibbon.session.file import check_place, create_session
    from georibbon.session.folder import read_recording

    require_ending(arguments.output, (".georibbon",), "a session")
    check_place(arguments.output)
    recording = read_recording(arguments.recording)
    create_session(arguments.output, recording)
    print(f"{_contents(recording)}\nwritten: {arguments.output}")


def export(arguments: argparse.Namespace) -> None:
    """Session file to recording folder."""
    from georibbon.session.file import read_session
    from georibbon.session.folder import write_recording

    recording = read_session(arguments.session)
    write_recording(recording, arguments.recording)
    print(f"{_contents(recording)}\nwritten: {arguments.recording}")
    left = _left_behind(arguments.session)
    if left:
        print(f"only in the session, as a recording has no place for it: {left}")


def _left_behind(path: Path) -> str:
    """What of a session is in no recording, in words."""
    from georibbon.session.telling import tell

    facts = tell(path)
    loose = sum(stream["frames"] for stream in facts["streams"])
    counts = (
        (loose, "frame between the passes", "frames between the passes"),
        (len(facts["notes"]), "note", None),
        (len(facts["settings"]), "setting", None),
        (int(facts["calibrated"]), "calibration", None),
        (len(facts["pending_survey"]), "pass in the survey that was not captured",
         "passes in the survey that were not captured"),
    )  # fmt: skip
    return ", ".join(counted(count, one, many) for count, one, many in counts if count)


def info(arguments: argparse.Namespace) -> None:
    """Tell what a source holds."""
    from georibbon.session.source import folder_of

    folder = folder_of(arguments.source)
    facts, text = _session(arguments.source) if folder is None else _folder(folder)
    print(json_text(facts) if arguments.json else text)


def _folder(path: Path) -> tuple["Facts", str]:
    from georibbon.session.describe import describe, describe_text
    from georibbon.session.folder import read_recording

    facts = describe(read_recording(path))
    return facts, describe_text(facts)


def _session(path: Path) -> tuple["Facts", str]:
    from georibbon.session.telling import tell, tell_text

    facts = tell(path)
    return facts, tell_text(facts)


def _contents(recording: "Recording") -> str:
    passes = sum(run.kind == "pass" for run in recording.passes)
    return (
        f"ribbon {recording.ribbon.id}: {counted(len(recording.poses), 'pose')}, "
        f"{counted(passes, 'pass', 'passes')}, {counted(len(recording.passes) - passes, 'tie')}"
    )
