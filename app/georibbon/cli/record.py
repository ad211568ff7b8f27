"""``georibbon record``: everything a ribbon says into a file, until told to end."""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Protocol, TextIO

from georibbon.cli.arguments import Parser, above_zero, add_link_options
from georibbon.cli.outputs import signals_noted
from georibbon.errors import DeviceError, GeoribbonError, StorageError
from georibbon.export.files import require_ending
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.capture.recorder import Recorder
    from georibbon.device.frames import Frame
    from georibbon.device.identity import Identity
    from georibbon.device.link import Link
    from georibbon.device.ring import Tap

DESCRIPTION = """\
Record what a ribbon says into a file, frame by frame: the CSV file of a recording, or a
.georibbon session.  It goes on over stalls and unplugged cables until --seconds are over
or it is interrupted (Ctrl-C): that is its normal end.

Once a second, and at the end, one JSON line is printed:
  frames      taken from the ribbon
  durable     of them, safe on the disk, whatever happens to this computer
  lost        packets missing by their numbers, those that came damaged among them
  damaged     packets that arrived damaged and were dropped
  stalls      times the ribbon fell silent
  reconnects  times the port was opened again
  state       disconnected, opening, streaming or stalled
  path        the file

What happens to the link and to the disk is told on standard error, a sentence each.  While
the disk is full or the file cannot be written, the frames are kept in memory and it is tried
again every second.  A file that is there is never overwritten.  In a CSV file whose last
line has no line feed at its end, a crash cut that line off: remove it."""

EPILOG = """\
examples:
  georibbon ports                                        # which ports are there?
  georibbon record /dev/ttyACM0 -o run.csv               # until Ctrl-C
  georibbon record COM5 --seconds 60 --rate 50 -o run.georibbon
  georibbon record socket://192.168.0.7:4000 --id GR-0007 -o run.csv

without a ribbon, in two terminals:
  georibbon virtual --tcp 127.0.0.1:4000
  georibbon record socket://127.0.0.1:4000 --seconds 10 -o run.csv"""

ANSWER = 15.0  # seconds until it is given up that a ribbon answers; the link says so before
PATIENCE = 10.0  # seconds at the end for a disk that refuses, before another place is taken
EVERY = 1.0  # seconds between two lines
_TICK = 0.05


class _Log(Protocol):
    """A recorder's sink with a file of its own."""

    @property
    def path(self) -> Path: ...

    @property
    def durable(self) -> int: ...

    @property
    def gone(self) -> int: ...

    def append(self, frames: "Sequence[Frame]") -> None: ...

    def sync(self) -> None: ...

    def move_to(self, path: Path) -> None: ...

    def close(self) -> None: ...


def configure(_name: str, parser: Parser) -> None:
    """Describe the command and its arguments."""
    parser.teach(DESCRIPTION, EPILOG)
    add_link_options(parser)
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True,
        help="the file to make, F.csv or F.georibbon",
    )  # fmt: skip
    parser.add_argument(
        "--seconds", metavar="N", type=above_zero,
        help="how long, from the first frame on (default: until interrupted)",
    )  # fmt: skip
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Record until the end; raises GeoribbonError where no ribbon answers or frames are lost."""
    from georibbon.capture.recorder import Recorder
    from georibbon.device.link import Link

    voice = _Voice()
    link = Link(arguments.url, rate=arguments.rate, ribbon_id=arguments.id, baudrate=arguments.baud)
    open_log = _opener(arguments.output, link, voice)
    link.on_change(lambda change: voice.hear(f"{change.state}: {change.reason}"))
    link.on_event(lambda event: voice.hear(f"{event.kind}: {event.message}"))
    tap = link.recorder()
    link.start()
    try:
        log = open_log(link.wait_for_identity(ANSWER))
        recorder = Recorder(
            tap, log, seconds=arguments.seconds,
            on_storage=lambda fault: voice.hear(fault or f"{log.path}: all is on the disk again"),
        )  # fmt: skip
        with signals_noted() as signals:
            recorder.start()
            _Run(link, tap, recorder, log, voice, signals).to_the_end()
    finally:
        link.stop()


def _opener(path: Path, link: "Link", voice: "_Voice") -> Callable[["Identity"], _Log]:
    """What makes the file once the ribbon is known; a bad place is refused here, before."""
    if require_ending(path, (".csv", ".georibbon"), "a recording") == ".csv":
        from georibbon.capture.csv_log import CsvLog, check_csv_place

        check_csv_place(path)
        return lambda identity: CsvLog(path, identity.ribbon.columns)
    from georibbon.capture.link_diary import LinkDiary
    from georibbon.capture.session_log import SessionLog
    from georibbon.session.file import check_place

    check_place(path)
    diary = LinkDiary(link)

    def session(identity: "Identity") -> _Log:
        log = SessionLog(path, identity, diary)
        for warning in log.warnings:
            voice.hear(warning)
        return log

    return session


class _Voice:
    """What is told to a person and to programs, by the main thread alone.

    Others leave their sentences here: none of them waits for a slow terminal.
    A stream that nobody reads any more is passed over.
    """

    def __init__(self) -> None:
        self._heard: SimpleQueue[str] = SimpleQueue()
        self._mute: set[TextIO] = set()

    def hear(self, sentence: str) -> None:
        """Take a sentence from any thread."""
        self._heard.put(sentence)

    def say_all(self) -> None:
        """Print what was heard, on standard error."""
        with suppress(Empty):
            while True:
                self.print(f"georibbon: {self._heard.get_nowait()}", sys.stderr)

    def print(self, line: str, stream: TextIO) -> None:
        """Print a line at once; nobody reading it is no reason to end a recording."""
        if stream in self._mute:
            return
        try:
            print(line, file=stream, flush=True)
        except OSError:
            self._mute.add(stream)
            with suppress(OSError, ValueError):  # its rest would fail once more at the end
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class _Run:
    """A recording that has begun."""

    def __init__(
        self,
        link: "Link",
        tap: "Tap",
        recorder: "Recorder",
        log: _Log,
        voice: _Voice,
        signals: list[int],
    ) -> None:
        self._link, self._tap, self._recorder, self._log = link, tap, recorder, log
        self._voice, self._signals = voice, signals
        self._broken: str | None = None  # why the link has ended by itself
        self._next_line = time.monotonic() + EVERY
        self._last_state: str | None = None

    def to_the_end(self) -> None:
        """Tell how it goes until it is over; then see that every frame is on the disk."""
        try:
            while not self._over():
                self._pause()
            self._last_state = self._link.state  # stopping it is no news
            self._link.stop()
            self._recorder.stop()
            self._insist()
            moved = self._take_elsewhere()
        finally:
            with suppress(StorageError):  # told already, or by what `_take_elsewhere` says
                self._log.close()
        self._voice.say_all()
        self._print_line()
        self._judge(moved)

    def _over(self) -> bool:
        """Whether it is at its end; a link that closes its tap by itself brings nothing more."""
        if self._tap.closed and not self._recorder.finished:
            self._broken = self._link.health().reason
        return self._recorder.finished or bool(self._signals) or self._broken is not None

    def _pause(self) -> None:
        """A moment, with all that there is to tell."""
        time.sleep(_TICK)
        self._voice.say_all()
        if time.monotonic() >= self._next_line:
            self._next_line += EVERY
            self._print_line()

    def _print_line(self) -> None:
        health, progress = self._link.health(), self._recorder.progress
        line = {
            "frames": progress.frames,
            "durable": progress.durable,
            "lost": health.lost,
            "damaged": health.damaged,
            "stalls": health.stalls,
            "reconnects": health.reconnects,
            "state": str(self._last_state or health.state),
            "path": str(self._log.path),
        }
        self._voice.print(json.dumps(line, ensure_ascii=False), sys.stdout)

    def _unwritten(self) -> int:
        progress = self._recorder.progress
        return progress.frames - progress.durable - self._log.gone

    def _insist(self) -> None:
        """Give a disk that refuses some time; another interrupt ends it."""
        if not self._unwritten():
            return
        self._voice.hear(
            f"{counted(self._unwritten(), 'frame')} not on the disk yet, make room; after "
            f"{PATIENCE:.0f} seconds, or with another interrupt, another place is tried"
        )
        seen, end = len(self._signals), time.monotonic() + PATIENCE
        while self._unwritten() and len(self._signals) == seen and time.monotonic() < end:
            with suppress(StorageError):
                self._log.sync()
            self._pause()

    def _take_elsewhere(self) -> Path | None:
        """Where what cannot be written in its place is, all of it; None where it could be."""
        if not self._unwritten():
            return None
        with suppress(OSError, GeoribbonError):  # what is not there then is told by `_judge`
            folder = Path(tempfile.mkdtemp(prefix="georibbon-"))
            try:
                self._log.move_to(folder / self._log.path.name)
            except GeoribbonError:
                folder.rmdir()
        return self._log.path

    def _judge(self, moved: Path | None) -> None:
        if self._unwritten():
            raise StorageError(
                f"{self._log.path}: {counted(self._unwritten(), 'frame')} could not be written "
                "anywhere and are lost; all before them are in the file"
            )
        if self._log.gone:
            raise StorageError(
                f"{self._log.path}: another program cut off what was written, so "
                f"{counted(self._log.gone, 'frame')} may be lost; all after them are in this file"
            )
        if moved is not None:
            raise StorageError(
                f"the file could not be written in its place; all of it is in {moved}, move it "
                "to where there is room"
            )
        if self._broken is not None:
            raise DeviceError(
                f"{self._log.path}: the link ended before the recording: {self._broken}; "
                f"{counted(self._recorder.progress.frames, 'frame')} came until then; go on in "
                "another file"
            )
        if not self._recorder.progress.frames:
            raise DeviceError(
                f"{self._log.path}: no frame came from the ribbon, so nothing was recorded; "
                "see what it is told to do, and try again"
            )
