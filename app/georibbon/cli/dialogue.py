"""The talk of ``georibbon capture``: readings to the engine, happenings to the terminal."""

import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.capture.engine import Engine, Live
from georibbon.capture.ledger import Happening
from georibbon.capture.verdict import curve_words
from georibbon.cli.keyboard import Words
from georibbon.cli.outputs import signals_noted
from georibbon.cli.verbs import obey
from georibbon.errors import DeviceError, GeoribbonError, StorageError
from georibbon.session.words import counted

if TYPE_CHECKING:
    from georibbon.capture.link_diary import LinkDiary
    from georibbon.device.ring import Tap
    from georibbon.session.session import Session

TICK = 0.04  # s: within 50 ms of a frame the person sees what it means
REDRAW = 0.1
PATIENCE = 60.0  # s without a frame, where standard input has ended
MARKS = {"taken": "ok", "refused": "--", "held": "!!", "chosen": "->", "complete": "**"}
HELP = (
    "Return (or space, Page Down) takes; NAME chooses; skip, undo, redo, add, remove, mark, "
    "distance, crossing, forget, note, calibrate, auto, status, save, quit: "
    "georibbon capture --help tells each"
)


class Dialogue:
    """One capture over a link into a session, spoken to through lines of text."""

    def __init__(self, tap: "Tap", diary: "LinkDiary", session: "Session", engine: Engine) -> None:
        self._tap, self._diary, self._session, self._engine = tap, diary, session, engine
        self._words = Words()
        self._line = StatusLine()
        self._quit = False

    def run(self, keep_all: bool) -> None:
        """Talk until the person quits, or all is done and no more words can come."""
        self._engine.observe(lambda happening: self._line.say(_words_of(happening)))
        self._words.start()
        told = ""
        # Only noted: an exception out of nowhere must not come between what is held and its rescue,
        # and a terminal that is closed sends a signal and refuses to be written to at once.
        with signals_noted() as signals:
            try:
                self._loop(keep_all, signals)
                told = "interrupted" if signals else ""
            finally:
                told = self._rescued() or told
                self._words.stop()
                with suppress(OSError):
                    self._line.say(told)
        if signals and signals[0] != signal.SIGINT:
            sys.exit(128 + signals[0])

    def _loop(self, keep_all: bool, signals: list[int]) -> None:
        """Frames, changes of the link and words, as they come; a glance at all on every tick."""
        tap = self._tap
        between = self._session.stream(self._engine.ribbon.rate) if keep_all else None
        heard = time.monotonic()
        while not (self._quit or signals):
            tap.wait(TICK)
            ended, closed = self._words.ended, tap.closed  # before what came until then is taken
            frames = tap.take()
            heard = time.monotonic() if frames else heard
            if between is not None:
                between.append(frames)
            self._try(lambda: self._engine.feed(frames))  # noqa: B023 (called at once)
            for entry in self._diary.take():
                self._try(lambda: self._engine.link_news(entry))  # noqa: B023 (called at once)
            for line in self._words.take():
                self._hear(line)
            if closed or (ended and self._engine.current is None):
                return
            if ended and time.monotonic() - heard > PATIENCE:
                raise DeviceError(
                    f"no frame for {PATIENCE:g} s, and nobody is there to be asked; "
                    f"{summary(self._engine, self._session)}"
                )
            if self._line.due():
                glance = _glance(self._engine, self._engine.refresh())
                self._line.show(glance, self._words.typed)

    def _hear(self, line: str) -> None:
        verb = line.strip().lower()
        if verb in ("quit", "exit"):
            self._end()
        elif verb == "status":
            self._line.say(_glance(self._engine, self._engine.refresh()))
            self._line.say(status(self._engine))
        elif verb in ("help", "?"):
            self._line.say(HELP)
        else:
            self._try(lambda: obey(self._engine, line))

    def _try(self, what: Callable[[], object]) -> None:
        """Do it; a fault that a person can mend ends nothing."""
        try:
            what()
        except GeoribbonError as error:
            self._line.say(f"not done: {error}")

    def _end(self) -> None:
        """Quit, unless something would be lost by it."""
        if self._session.held:
            self._line.say(
                f"not everything is on disk: {self._session.storage_error}; say save FILE for "
                "another place, or save to try here again"
            )
        else:
            self._quit = True

    def _rescued(self) -> str:
        """Bring what is held in memory to some place before the program ends; what to say of it."""
        if not self._session.held:
            return ""
        try:
            self._session.retry()
        except StorageError:
            stem = self._session.path.stem
            place = Path(tempfile.mkdtemp(prefix="georibbon-rescued-")) / f"{stem}.georibbon"
            self._session.move_to(place)
            return f"what could not be written in its place is safe in {place}"
        return ""


class StatusLine:
    """Lines for a person, and below them one that is drawn over and over on a terminal."""

    def __init__(self) -> None:
        self._live = sys.stdout.isatty()
        self._width = 0
        self._drawn = 0.0

    def due(self) -> bool:
        """Whether it is time to draw the live line anew."""
        return self._live and time.monotonic() - self._drawn >= REDRAW

    def show(self, text: str, typed: str = "") -> None:
        """Draw the live line, and what was typed after it."""
        self._drawn = time.monotonic()
        room = shutil.get_terminal_size().columns - 1
        typed = "".join(c if c.isprintable() else "?" for c in f" > {typed}"[-room // 2 :])
        text = f"{text[: room - len(typed)]}{typed}" if text else ""
        blank = max(0, self._width - len(text))
        sys.stdout.write(f"\r{text}{' ' * blank}" + "\b" * blank)
        sys.stdout.flush()
        self._width = len(text)

    def clear(self) -> None:
        """Wipe the live line."""
        if self._width:
            self.show("")
            sys.stdout.write("\r")

    def say(self, text: str) -> None:
        """A line that stays; without words only the live line goes."""
        self.clear()
        if text:
            print(text, flush=True)


def status(engine: Engine) -> str:
    """Every pose, pass and tie, how it stands, and the survey."""
    marks = {"taken": "x", "skipped": "-", "open": " "}
    current = engine.current
    lines = [
        f"{'>' if current is not None and item.key == current.key else ' '} "
        f"[{marks[item.status]}] {item.key}: {item.words}"
        for item in engine.items
    ]
    for table, entries in engine.survey.tables().items():
        lines += [f"  {table} {i}: {_entry(entry)}" for i, entry in enumerate(entries, start=1)]
    return "\n".join(lines)


def summary(engine: Engine, session: "Session") -> str:
    """What the session holds in the end, and what to do with it."""
    taken = [item for item in engine.items if item.status == "taken"]
    poses = sum(item.is_pose for item in taken)
    left = sum(item.status == "open" for item in engine.items)
    text = (
        f"{session.path}: {counted(poses, 'pose')}, "
        f"{counted(len(taken) - poses, 'pass or tie', 'passes and ties')}"
    )
    if left:
        return f"{text}; {left} still open: capture with -o {session.path} goes on with them"
    return f"{text}; next: georibbon reconstruct {session.path} --report report.html"


def _entry(entry: Mapping[str, object]) -> str:
    return ", ".join(f"{key} {value}" for key, value in entry.items())


def _words_of(happening: Happening) -> str:
    return f"{MARKS.get(happening.kind, '  ')} {happening.message}"


def _glance(engine: Engine, live: Live) -> str:
    """The live line: what is asked for, whether it is still, how well the curve fits."""
    items = engine.items
    done = sum(item.status != "open" for item in items)
    asked = "all done" if engine.current is None else engine.current.key
    words = f"[{done}/{len(items)}] {asked}"
    if live.stillness is None:
        return f"{words} | waiting for frames"
    if live.curve is not None:
        words += f" | {curve_words(live.curve)}"
    return f"{words} | {live.stillness.reason}"
