"""What a document is made of, without Qt: a session file or a recording folder, with undo.

Both have the same verbs.  A session keeps every change in its file; a recording
folder is never written to, so its changes, and those of a session that is read
only, last as long as it is open.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from georibbon.calibration.serial import check_fits, to_dict
from georibbon.session.actions import settings_in_words
from georibbon.session.restoring import recording_of
from georibbon.session.session import Session
from georibbon.session.settings import Values
from georibbon.session.source import CALIBRATION, KEPT, calibration_of, folder_of

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.recording import PassKind, Recording
    from georibbon.session.events import Event
    from georibbon.session.state import CapturedPass, SessionState

CALIBRATED = "the calibration"
Changes = Mapping[tuple[str, str], object]  # by whose ("*" for all) and key; None takes it back


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
    def values(self) -> Values:
        """The settings as they are kept."""

    @property
    def calibration(self) -> "Calibration | None":
        """What stands in for the poses, where there are none or where that was chosen."""

    @property
    def has_poses(self) -> bool:
        """Whether it holds calibration poses of its own."""

    @property
    def undoable(self) -> str | None:
        """What `undo` would take back."""

    @property
    def redoable(self) -> str | None:
        """What `redo` would do again."""

    def recording(self) -> "Recording":
        """The same object as long as nothing that was captured changes."""

    def change(self, changes: Changes) -> None:
        """Change settings; None takes one back.  One step of undo."""

    def use_calibration(self, calibration: "Calibration | None") -> None:
        """Have a calibration stand in for the poses; None: the poses.  One step of undo.

        Raises CalibrationError or SessionError where it is of another ribbon.
        """

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


class Edits:
    """Settings that are kept in memory alone, with their undo."""

    def __init__(self, values: Values) -> None:
        self.values: Values = dict(values)
        self._done: list[tuple[str, Values]] = []
        self._undone: list[tuple[str, Values]] = []

    @property
    def undoable(self) -> str | None:
        return self._done[-1][0] if self._done else None

    @property
    def redoable(self) -> str | None:
        return self._undone[-1][0] if self._undone else None

    def change(self, changes: Changes) -> None:
        self._change(settings_in_words(list(changes)), changes)

    def use_calibration(self, calibration: "Calibration | None") -> None:
        self._change(CALIBRATED, {("*", CALIBRATION): calibration})

    def _change(self, words: str, changes: Changes) -> None:
        self._done.append((words, self.values))
        self._undone.clear()
        self.values = changed(self.values, changes)

    def undo(self) -> str | None:
        return self._go(self._done, self._undone)

    def redo(self) -> str | None:
        return self._go(self._undone, self._done)

    def _go(self, source: list[tuple[str, Values]], target: list[tuple[str, Values]]) -> str | None:
        if not source:
            return None
        words, values = source.pop()
        target.append((words, self.values))
        self.values = values
        return words


def _given(values: Values) -> "Calibration | None":
    """The calibration that was chosen for as long as the source is open."""
    from georibbon.calibration.model import Calibration

    value = values.get(("*", CALIBRATION))
    return value if isinstance(value, Calibration) else None


def changed(values: Values, changes: Changes) -> Values:
    """The settings after some changes."""
    merged = {**values, **changes}
    return {place: value for place, value in merged.items() if value is not None}


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
        self._recording = recording

    @property
    def passes(self) -> tuple[PassEntry, ...]:
        return tuple(PassEntry(one.name, one.kind) for one in self._recording.passes)

    @property
    def calibration(self) -> "Calibration | None":
        return _given(self.values)

    @property
    def has_poses(self) -> bool:
        return bool(self._recording.poses)

    def use_calibration(self, calibration: "Calibration | None") -> None:
        if calibration is not None:
            check_fits(calibration, self._recording.ribbon)
        super().use_calibration(calibration)

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
    def state(self) -> "SessionState":
        """What the session holds."""
        return self.session.state

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
    def values(self) -> Values:
        return self.session.state.settings

    @property
    def calibration(self) -> "Calibration | None":
        return _given(self.values) or calibration_of(self.session.state, self.values)

    @property
    def has_poses(self) -> bool:
        return bool(self.session.state.poses)

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
        # Ids of events that undo and redo go over together, and what they are called.
        self._steps: list[tuple[frozenset[int], str]] = []

    @property
    def undoable(self) -> str | None:
        state = self.session.state
        if state.done and state.done[-1] <= _made_at_once(state.history):
            return None  # a recording that was imported is not taken apart again
        step = self._step(state.done)
        return step[1] if step else state.undoable

    @property
    def redoable(self) -> str | None:
        state = self.session.state
        step = self._step(state.undone)
        return step[1] if step else state.redoable

    def change(self, changes: Changes) -> None:
        listed = [
            {"pass": whose, "key": key, "value": value} for (whose, key), value in changes.items()
        ]
        if len(listed) == 1:
            self.session.do("setting", **listed[0])
        else:
            self.session.do("settings", changes=listed)

    def use_calibration(self, calibration: "Calibration | None") -> None:
        session, events = self.session, []
        if calibration is not None:
            events.append(session.do("calibration", document=to_dict(calibration)))
        chosen = None if calibration is None else KEPT
        if self.values.get(("*", CALIBRATION)) != chosen:
            setting = {"pass": "*", "key": CALIBRATION, "value": chosen}
            events.append(session.do("setting", **setting))
        self._steps.append((frozenset(one.id for one in events), CALIBRATED))

    def undo(self) -> str | None:
        words, step = self.undoable, self._step(self.session.state.done)
        self.session.undo()
        while step and self._step(self.session.state.done) is step:
            self.session.undo()
        return words

    def redo(self) -> str | None:
        words, step = self.redoable, self._step(self.session.state.undone)
        self.session.redo()
        while step and self._step(self.session.state.undone) is step:
            self.session.redo()
        return words

    def _step(self, events: Sequence[int]) -> tuple[frozenset[int], str] | None:
        """The step that the next of these events belongs to, where it is one of several."""
        return next((step for step in self._steps if events and events[-1] in step[0]), None)


def _made_at_once(history: Sequence["Event"]) -> int:
    """The last event of those that a recording was imported by; 0 where none was.

    An import writes all of them, the closing too, at one time.
    """
    closed = next((event for event in history if event.action == "closed"), None)
    return closed.id if closed is not None and closed.time == history[0].time else 0


class ReadOnlySession(_OfSession):
    """A session that cannot be written, here or now: changes last as long as it is open."""

    keeps = False

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._edits = Edits(session.state.settings)

    @property
    def values(self) -> Values:
        return self._edits.values

    @property
    def undoable(self) -> str | None:
        return self._edits.undoable

    @property
    def redoable(self) -> str | None:
        return self._edits.redoable

    def change(self, changes: Changes) -> None:
        self._edits.change(changes)

    def use_calibration(self, calibration: "Calibration | None") -> None:
        ribbon = self.session.state.ribbon
        if calibration is not None and ribbon is not None:
            check_fits(calibration, ribbon)
        self._edits.use_calibration(calibration)

    def undo(self) -> str | None:
        return self._edits.undo()

    def redo(self) -> str | None:
        return self._edits.redo()
