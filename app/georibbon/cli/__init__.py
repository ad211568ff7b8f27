"""The command line: ``georibbon COMMAND …``; without a command it opens the window.

Nothing heavy is imported here: a command's module is loaded when that command
is asked for, and numpy and all else when it runs.

Exit codes: 0 done; 2 the input is at fault, told in one sentence on standard
error; 1 a fault of the program, or, of `batch`, a session that failed; 130
interrupted.
"""

import codecs
import io
import os
import signal
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TextIO, cast

from georibbon import __version__
from georibbon.cli.arguments import Parser
from georibbon.errors import GeoribbonError
from georibbon.session.words import shown

# The commands in the order in which they are met: module, and what it does in one line.
COMMANDS = {
    "demo": ("demonstration", "capture a virtual car bonnet, reconstruct it, print the error"),
    "simulate": ("simulation", "make a recording of a virtual ribbon, with its truth"),
    "virtual": ("virtual", "be a ribbon on a virtual surface, on a port of this machine"),
    "ports": ("ports", "list the serial ports on which a ribbon may hang"),
    "record": ("record", "record what a ribbon says into a CSV file or a session"),
    "capture": ("capture", "capture an object step by step into a session"),
    "info": ("sessions", "tell what a recording or session holds"),
    "calibrate": ("calibration", "calibrate a ribbon from its poses into a file"),
    "reconstruct": ("reconstruction", "turn a recording or session into a surface"),
    "surface": ("surface", "lay a surface through curves of any origin"),
    "batch": ("batch", "reconstruct many sessions, several at a time"),
    "compare": ("comparison", "tell how one surface lies from another"),
    "figures": ("figures", "do the source paper's figures again, with numbers"),
    "import": ("sessions", "put a recording folder into a session file"),
    "export": ("sessions", "write a session's raw data as a recording folder"),
    "check": ("check", "verify a session; save what can be read of a damaged one"),
    "licences": ("licence_list", "list the licences of all that is shipped"),
}

DESCRIPTION = """\
Georibbon turns what a ribbon of accelerometers and magnetometers measures, laid on
a real surface in near-parallel passes, into that surface, with its uncertainty."""

EPILOG = """\
Without a command the window opens: `georibbon`, or `georibbon` with a session or a
recording folder.

examples:
  georibbon demo                 # see what it does, in build/demo
  georibbon info RECORDING       # what does this recording hold?
  georibbon reconstruct RECORDING --surface part.stl --report part.html

RECORDING is a folder with a recording.toml; a session is one .georibbon file.
georibbon COMMAND --help explains a command, with examples."""

FAULT, INPUT_AT_FAULT, INTERRUPTED, PIPE_CLOSED = 1, 2, 130, 141


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    if argv is None:
        _end_cleanly()
    _print_anything()
    streams = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast("TextIO", _Shown(stream)) for stream in streams)
    try:
        return _run(words)
    finally:
        sys.stdout, sys.stderr = streams


def _run(words: Sequence[str]) -> int:
    """Run the command that the words name; returns the exit code."""
    debug = "--debug" in words
    try:
        shown = window_for(words)
        if shown is not None:
            from georibbon.cli.window import run

            return run(*shown)
        arguments, unknown = build_parser(words).parse_known_args(words)
        if unknown:  # told by the command itself, whose own help explains its words
            arguments.command.error(f"unrecognized arguments: {' '.join(unknown)}")
        arguments.run(arguments)
        sys.stdout.flush()
    except SystemExit as end:  # argparse: help, version, or words it could not read
        return int(end.code or 0)
    except BrokenPipeError:
        # Whoever read our output has enough; keep Python from complaining at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
    except KeyboardInterrupt:
        print("georibbon: interrupted", file=sys.stderr)
        return INTERRUPTED
    except Exception as error:
        return _tell(error, debug)
    return 0


def window_for(words: Sequence[str]) -> tuple[Path | None] | None:
    """What the window is to show, `(None,)` for its start page; None for a command's words.

    A single word that is no command opens what lies there, or what its ending
    says is a session.
    """
    rest = [word for word in words if word != "--debug"]
    if not rest:
        return (None,)
    if len(rest) > 1 or rest[0].startswith("-") or rest[0] in COMMANDS:
        return None
    path = Path(rest[0])
    there = path.suffix.lower() == ".georibbon" or (os.sep in rest[0] or path.exists())
    return (path,) if there else None


def _end_cleanly() -> None:
    """Let a closed terminal or a plain kill end the program as an error does, with no litter."""
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), lambda number, _: sys.exit(128 + number))


class _Shown:
    """A stream that shows texts from outside, and never lets them steer the terminal.

    A carriage return before a text and backspaces behind it are the program's
    own: it writes a line once more with them.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text without what steers a terminal."""
        body = text.removeprefix("\r").rstrip("\b")
        start = len(text) - len(text.removeprefix("\r"))
        self._stream.write(text[:start] + shown(body) + text[start + len(body) :])
        return len(text)


def _print_anything() -> None:
    """Let no closed stream, no sign and no odd file name stop the output."""
    if sys.stdout is None:
        sys.stdout = io.StringIO()
    if sys.stderr is None:
        sys.stderr = io.StringIO()
    codecs.register_error("georibbon", _spelled)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="georibbon")


def _spelled(error: UnicodeError) -> tuple[str | bytes, int]:
    """The bytes of a file name that were no text as they came, any other sign by its number."""
    try:
        return codecs.lookup_error("surrogateescape")(error)
    except UnicodeError:
        return codecs.backslashreplace_errors(error)


def build_parser(words: Sequence[str]) -> Parser:
    """The parser; only the command that `words` name is loaded and described in full."""
    parser = Parser(prog="georibbon", description=DESCRIPTION, epilog=EPILOG)
    parser.add_argument("--version", action="version", version=f"georibbon {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, title="commands")
    asked = next((word for word in words if not word.startswith("-")), None)
    for name, (module, summary) in COMMANDS.items():
        command = commands.add_parser(name, help=summary)
        if name == asked:
            import_module(f"georibbon.cli.{module}").configure(name, command)
            command.add_argument(
                "--debug", action="store_true", help="on an error, print where it arose"
            )
            command.set_defaults(command=command)
    return parser


def _tell(error: Exception, debug: bool) -> int:
    """Say what went wrong on standard error; returns the exit code."""
    if debug:
        traceback.print_exception(error)
    if isinstance(error, GeoribbonError):
        print(f"georibbon: error: {error}", file=sys.stderr)
        return INPUT_AT_FAULT
    if isinstance(error, OSError) and error.strerror is not None:
        where = error.filename or "the output cannot be written"
        print(f"georibbon: error: {where}: {error.strerror}", file=sys.stderr)
        if error.filename is None:  # what is still in the buffer would fail once more at the end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return INPUT_AT_FAULT
    print(
        f"georibbon: a fault of the program, not of your input: {type(error).__name__}: {error}; "
        "please report it with what the same command prints with --debug",
        file=sys.stderr,
    )
    return FAULT
