"""What a document is made of, without Qt: a session file or a recording folder, with undo.

Both have the same verbs.  A session keeps every change in its file; a recording
folder is never written to, so its changes, and those of a session that is read
only, last as long as it is open.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from georibbon.session.events import EVERY_PASS
from georibbon.session.restoring import recording_of
from georibbon.session.session import Session
from georibbon.session.source import SMOOTHING, folder_of, smoothing_of

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.recording import PassKind, Recording
    from georibbon.session.state import CapturedPass

Changes = Mapping[str, float | None]
RESET = "the smoothing of all passes"


@dataclass(frozen=True)
class PassEntry:
    """A pass or tie that was captured."""

    name: str
    kind: "PassKind"


class Opened(Protocol):
    """A session or a recording folder that is open.

    told: what a person must know of how it was opened.  undoable, redoable: in
    words what would be taken back or done again.
    """

    path: Path
    title: str | None
    told: tuple[str, ...]
    keeps: bool

    @property
    def passes(self) -> tuple[PassEntry, ...]:
        """The passes and ties in their order."""

    @property
    def smoothing(self) -> Mapping[str, float]:
        """Metres, by the pass's name or "*" for all others."""

    @property
    def calibration(self) -> "Calibration | None":
        """What stands in for the poses, where there are none."""

    @property
    def undoable(self) -> str | None:
        """What `undo` would take back."""

    @property
    def redoable(self) -> str | None:
        """What `redo` would do again."""

    def recording(self) -> "Recording":
        """The same object as long as nothing that was captured changes."""

    def smooth(self, changes: Changes) -> None:
        """Change the smoothing of passes; None: back to automatic.  One step of undo."""

    def undo(self) -> str | None:
        """Take the last step back; in words what it was."""

    def redo(self) -> str | None:
        """Do again what was undone last; in words what it was."""

    def close(self, discard: bool = False) -> None:
        """Let it go.

        Raises StorageError, and stays open, where something of it cannot be
        written; discard: let go of that too.
        """


def open_source(path: Path) -> Opened:
    """The recording folder or session file at a path.

    Raises RecordingError or SessionError, one sentence.
    """
    folder = folder_of(path)
    if folder is not None:
        from georibbon.session.folder import read_recording

        return OpenedRecording(folder, read_recording(folder))
    session = Session.open(path)
    return ReadOnlySession(session) if session.read_only else OpenedSession(session)


def in_words(changes: Changes) -> str:
    """What a change of smoothing is called."""
    if len(changes) > 1 or EVERY_PASS in changes:
        return RESET
    return f"the smoothing of pass {next(iter(changes))}"


class Edits:
    """Smoothing that is kept in memory alone, with its undo."""

    def __init__(self, smoothing: Mapping[str, float]) -> None:
        self.smoothing = dict(smoothing)
        self._done: list[tuple[str, dict[str, float]]] = []
        self._undone: list[tuple[str, dict[str, float]]] = []

    @property
    def undoable(self) -> str | None:
        return self._done[-1][0] if self._done else None

    @property
    def redoable(self) -> str | None:
        return self._undone[-1][0] if self._undone else None

    def smooth(self, changes: Changes) -> None:
        self._done.append((in_words(changes), self.smoothing))
        self._undone.clear()
        self.smoothing = changed(self.smoothing, changes)

    def undo(self) -> str | None:
        return self._go(self._done, self._undone)

    def redo(self) -> str | None:
        return self._go(self._undone, self._done)

    def _go(
        self, source: list[tuple[str, dict[str, float]]], target: list[tuple[str, dict[str, float]]]
    ) -> str | None:
        if not source:
            return None
        words, smoothing = source.pop()
        target.append((words, self.smoothing))
        self.smoothing = smoothing
        return words


def changed(smoothing: Mapping[str, float], changes: Changes) -> dict[str, float]:
    """The smoothing after some changes."""
    merged = {**smoothing, **changes}
    return {name: value for name, value in merged.items() if value is not None}


class OpenedRecording(Edits):
    """A recording folder: read once, never written."""

    keeps = False

    def __init__(
        self,
        path: Path,
        recording: "Recording",
    ) -> None:
        super().__init__({})
        self.path, self.title = path, recording.title
        self.told: tuple[str, ...] = ()
        self.calibration = None
        self._recording = recording

    @property
    def passes(self) -> tuple[PassEntry, ...]:
        return tuple(PassEntry(one.name, one.kind) for one in self._recording.passes)

    def recording(self) -> "Recording":
        return self._recording

    def close(self, discard: bool = False) -> None:
        """There is nothing to be done."""


class _OfSession:
    """What is read from a session, whether it can be written or not."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.path = session.path
        self._from: tuple[object, ...] = ()
        self._captured: tuple[CapturedPass, ...] = ()
        self._recording: Recording | None = None

    @property
    def title(self) -> str | None:
        return self.session.state.title

    @property
    def told(self) -> tuple[str, ...]:
        recovery = self.session.recovery
        return (*self.session.warnings, *([recovery.message] if recovery else []))

    @property
    def passes(self) -> tuple[PassEntry, ...]:
        return tuple(PassEntry(one.name, one.kind) for one in self.session.state.passes)

    @property
    def calibration(self) -> "Calibration | None":
        state = self.session.state
        return None if state.poses else state.calibration

    def recording(self) -> "Recording":
        state = self.session.state
        of = (
            state.ribbon, state.poses, state.passes, state.marks, state.distances,
            state.crossings, state.workpiece,
        )  # fmt: skip
        if self._recording is None or self._from != of:
            # of this very state: another thread may go on meanwhile
            fresh = recording_of(state, self.session.readings, self.path.name, complete=True)
            if self._recording is not None:
                fresh = _kept(fresh, state.passes, self._recording, self._captured)
            self._recording, self._from, self._captured = fresh, of, state.passes
        return self._recording

    def close(self, discard: bool = False) -> None:
        self.session.close(discard=discard)


def _kept(
    fresh: "Recording",
    captured: Sequence["CapturedPass"],
    old: "Recording",
    before: Sequence["CapturedPass"],
) -> "Recording":
    """The recording with the passes it had already as the same objects: they are fitted."""
    known = dict(zip(before, old.passes, strict=True))
    passes = tuple(known.get(entry, run) for entry, run in zip(captured, fresh.passes, strict=True))
    return replace(fresh, passes=passes)


class OpenedSession(_OfSession):
    """A session file that keeps what is changed."""

    keeps = True

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._steps: list[range] = []  # ids of events that undo and redo go over together

    @property
    def smoothing(self) -> Mapping[str, float]:
        return smoothing_of(self.session.state, self.path.name)

    @property
    def undoable(self) -> str | None:
        state = self.session.state
        return RESET if state.done and self._step(state.done[-1]) else state.undoable

    @property
    def redoable(self) -> str | None:
        state = self.session.state
        return RESET if state.undone and self._step(state.undone[-1]) else state.redoable

    def smooth(self, changes: Changes) -> None:
        events = [
            self.session.do("setting", **{"pass": name, "key": SMOOTHING, "value": value})
            for name, value in changes.items()
        ]
        if len(events) > 1:
            self._steps.append(range(events[0].id, events[-1].id + 1))

    def undo(self) -> str | None:
        words, state = self.undoable, self.session.state
        step = self._step(state.done[-1]) if state.done else None
        self.session.undo()
        while step and self.session.state.done and self.session.state.done[-1] in step:
            self.session.undo()
        return words

    def redo(self) -> str | None:
        words, state = self.redoable, self.session.state
        step = self._step(state.undone[-1]) if state.undone else None
        self.session.redo()
        while step and self.session.state.undone and self.session.state.undone[-1] in step:
            self.session.redo()
        return words

    def _step(self, event: int) -> range | None:
        return next((step for step in self._steps if event in step), None)


class ReadOnlySession(_OfSession):
    """A session that cannot be written, here or now: changes last as long as it is open."""

    keeps = False

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._edits = Edits(smoothing_of(session.state, session.path.name))

    @property
    def smoothing(self) -> Mapping[str, float]:
        return self._edits.smoothing

    @property
    def undoable(self) -> str | None:
        return self._edits.undoable

    @property
    def redoable(self) -> str | None:
        return self._edits.redoable

    def smooth(self, changes: Changes) -> None:
        self._edits.smooth(changes)

    def undo(self) -> str | None:
        return self._edits.undo()

    def redo(self) -> str | None:
        return self._edits.redo()
