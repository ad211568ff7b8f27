"""``georibbon check``: whether a session file is in order; saving what can be read if not."""

import argparse
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.cli.arguments import Parser
from georibbon.cli.printing import json_text
from georibbon.errors import SessionError
from georibbon.export.files import require_ending
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.session.salvage import Checkup

DESCRIPTION = """\
Read all of a session file and tell whether it is in order: every event and every frame
against its digest.  The file itself is never changed.

Of a damaged session everything that can be read is written into a new session: every
event, and every pose and pass of which no frame is missing, to the last bit as they were
captured.  What else can be read of frames is kept beside them.  What was lost is listed,
and noted in the new session.

Exit code 0: in order; 2: damaged (even if all of it was saved), or no session."""

EPILOG = """\
examples:
  georibbon check bonnet.georibbon                       # bonnet.salvaged.georibbon if damaged
  georibbon check bonnet.georibbon --no-salvage --json   # look only, for programs
  georibbon check /media/stick/bonnet.georibbon --salvage bonnet-again.georibbon"""

ENDING = ".georibbon"


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    parser.add_argument("session", metavar="S.georibbon", type=Path, help="session file")
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--salvage", metavar="FILE", type=Path,
        help="the new session for what can be read of a damaged one (S.salvaged.georibbon "
        "beside it); never overwritten",
    )  # fmt: skip
    place.add_argument(
        "--no-salvage", action="store_true", help="write nothing, whatever is damaged"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Verify a session, save what can be read of a damaged one, and tell."""
    from georibbon.session.salvage import check_session, salvage

    path = arguments.session
    if arguments.salvage is not None:
        require_ending(arguments.salvage, (ENDING,), "a session")
    found = check_session(path)
    if found.ok or arguments.no_salvage:
        _print(found, None, arguments.json)
        if not found.ok:
            raise SessionError(f"{found.message}; without --no-salvage what can be read is saved")
        return
    target = _free_name(path) if arguments.salvage is None else arguments.salvage
    try:
        saved = salvage(path, target)
    except SessionError as error:
        _print(found, None, arguments.json)
        remedy = "with --salvage FILE what can be read is saved in another place"
        raise SessionError(f"{found.message}, and {error}; {remedy}") from error
    _print(found, saved, arguments.json)
    raise SessionError(f"{found.message}; what can be read of it was saved in {target}")


def _free_name(path: Path) -> Path:
    """A name beside a session's that no file has."""
    stem = path.name.removesuffix(ENDING)
    names = (f"{stem}.salvaged{f'-{i}' if i > 1 else ''}{ENDING}" for i in count(1))
    return next(path.with_name(name) for name in names if not path.with_name(name).exists())


def _print(found: "Checkup", saved: "Checkup | None", as_json: bool) -> None:
    """Tell what is there, what was saved, and what is lost."""
    best = saved or found
    numbers = {
        name: getattr(best, name) for name in ("poses", "passes", "frames", "notes", "events")
    }
    if as_json:
        facts = {
            "session": str(found.path),
            "verdict": found.verdict,
            "message": found.message,
            "salvaged": None if saved is None else str(saved.path),
            **numbers,
            "lost": list(best.lost),
        }
        print(json_text(facts))
        return
    plurals = {"passes": ("pass or tie", "passes and ties")}
    told = [
        counted(number, *plurals.get(name, (name.removesuffix("s"),)))
        for name, number in numbers.items()
    ]
    print(found.message)
    if not found.ok:
        print("\n".join(["lost:", *(f"  {line}" for line in best.lost or ["nothing"])]))
    print(f"{'' if found.ok else 'saved: ' if saved else 'can be saved: '}{', '.join(told)}")
    if saved is not None:
        print(f"written: {saved.path}")
