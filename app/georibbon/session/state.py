"""What a session holds: the fold of its events, leaving out those that were undone."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from georibbon.calibration.model import Calibration
from georibbon.calibration.serial import check_fits, from_dict
from georibbon.errors import CalibrationError, SessionError
from georibbon.recording import Crossing, Distance, Mark, PassKind, Workpiece
from georibbon.ribbon import Ribbon
from georibbon.session.actions import in_words
from georibbon.session.chunks import DamagedError
from georibbon.session.events import MAX_EVENTS, UNDOABLE, Event
from georibbon.session.fields import Source, Table
from georibbon.session.outline import (
    MAX_FILES,
    read_pass,
    read_pose,
    read_ribbon,
    read_survey,
    read_workpiece,
)
from georibbon.session.words import nearest, told

MAX_PART = 2**31 - 1
MAX_PLANNED = 10_000
_POSE = ("key", "name", "roll", "heading", "pitch", "table", "part", "frames")
_PASS = ("name", "kind", "part", "frames")
_SURVEY = ("mark", "distance", "crossing")
_LAYOUT_COUNTS = ("marks", "distances")
_LAYOUT = ("spacing", *_LAYOUT_COUNTS, "mark_sigma", "distance_sigma", "crossing_sigma")
_HOLDING = ("pose", "pass", "stream")


@dataclass(frozen=True)
class SessionPlan:
    """How many poses, passes and ties are meant to be captured.

    layout: how they are meant to be laid and measured, numbers by name; empty: as usual.
    """

    poses: int
    passes: int
    ties: int
    layout: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class CapturedPose:
    """A pose that was captured, degrees; part: where its frames are."""

    key: str
    name: str
    roll: float
    heading: float
    pitch: float
    table: bool
    part: int
    frames: int


@dataclass(frozen=True)
class CapturedPass:
    """A pass or tie that was captured; part: where its frames are."""

    name: str
    kind: PassKind
    part: int
    frames: int


@dataclass(frozen=True)
class StreamEntry:
    """Frames between poses and passes, or of plain logging; rate: frames per second."""

    part: int
    rate: float
    time: str


@dataclass(frozen=True)
class Note:
    """What the operator wrote, when, and of which pass where it was said."""

    time: str
    text: str
    pass_name: str | None


@dataclass(frozen=True, eq=False)
class SessionState:
    """A session at one moment.

    marks, distances, crossings: the whole survey, also of passes that are not
    captured (yet).  skipped: keys of poses and names of passes.  settings: by
    (pass or "*", key).  holding: whether there are frames, be they undone.
    done, undone: the ids of the events that undoing and redoing would go
    through, the next one last.
    """

    ribbon: Ribbon | None = None
    firmware: str | None = None
    title: str | None = None
    workpiece: Workpiece | None = None
    plan: SessionPlan | None = None
    poses: tuple[CapturedPose, ...] = ()
    passes: tuple[CapturedPass, ...] = ()
    skipped: tuple[str, ...] = ()
    marks: tuple[Mark, ...] = ()
    distances: tuple[Distance, ...] = ()
    crossings: tuple[Crossing, ...] = ()
    settings: Mapping[tuple[str, str], object] = field(default_factory=dict)
    calibration: Calibration | None = None
    notes: tuple[Note, ...] = ()
    streams: tuple[StreamEntry, ...] = ()
    holding: bool = False
    history: tuple[Event, ...] = ()
    done: tuple[int, ...] = ()
    undone: tuple[int, ...] = ()

    @property
    def undoable(self) -> str | None:
        """What undoing would take back, in words."""
        return in_words(self.history[self.done[-1] - 1]) if self.done else None

    @property
    def redoable(self) -> str | None:
        """What redoing would do again, in words."""
        return in_words(self.history[self.undone[-1] - 1]) if self.undone else None

    @property
    def pending_survey(self) -> tuple[str, ...]:
        """The names in the survey of passes that are not captured, each once."""
        there = {run.name for run in self.passes}
        named = [mark.pass_name for mark in self.marks]
        named += [name for one in self.distances for name in one.passes]
        named += [name for one in self.crossings for name in one.passes]
        return tuple(dict.fromkeys(name for name in named if name not in there))


def fold(events: Sequence[Event], name: str = "the session") -> SessionState:
    """The state after all events.

    name: the session's, for messages.  Raises SessionError for events that
    cannot be meant and DamagedError where some are missing.
    """
    if len(events) > MAX_EVENTS:
        raise SessionError(f"{name}: more than {MAX_EVENTS} events; at most so many are read")
    if not events or events[0].action != "created":
        raise DamagedError("its first event is missing")
    done: list[int] = []
    undone: list[int] = []
    gone: set[int] = set()
    for i, event in enumerate(events, start=1):
        if event.id != i:
            raise DamagedError(f"event {i} is missing")
        moved = _step(event, done, undone, name)
        if moved is not None:
            gone ^= {moved}
    state = SessionState()
    for event in events:
        state = _applied(state, event, name, event.id in gone)
    return dataclasses.replace(state, history=tuple(events), done=tuple(done), undone=tuple(undone))


def advance(state: SessionState, event: Event, name: str = "the session") -> SessionState:
    """The state after one event more; SessionError where it cannot be meant."""
    if event.action in ("undo", "redo") or not state.history:
        return fold((*state.history, event), name)
    done, undone = list(state.done), list(state.undone)
    _step(event, done, undone, name)
    return dataclasses.replace(
        _applied(state, event, name),
        history=(*state.history, event),
        done=tuple(done),
        undone=tuple(undone),
    )


def _step(event: Event, done: list[int], undone: list[int], name: str) -> int | None:
    """Carry the stacks of undoing and redoing over one event; the event that went over."""
    if event.action in UNDOABLE:
        done.append(event.id)
        undone.clear()
    if event.action in ("undo", "redo"):
        source, target = (done, undone) if event.action == "undo" else (undone, done)
        of = event.detail.get("of")
        if set(event.detail) != {"of"} or type(of) is not int or not source or source[-1] != of:
            raise SessionError(
                f"{name}: event {event.id} would {event.action} {told(of)}; only the last one can "
                "be taken back or done again"
            )
        target.append(source.pop())
        return of
    return None


def parts_of(events: Iterable[Event]) -> dict[int, int | None]:
    """The parts that the events tell of, undone ones too: the number of frames, None for streams.

    Raises DamagedError where a number makes no sense or is used twice.
    """
    parts: dict[int, int | None] = {}
    for event in events:
        if event.action in _HOLDING:
            part, frames = event.detail.get("part"), event.detail.get("frames")
            if type(part) is not int or not 1 <= part <= MAX_PART or part in parts:
                raise DamagedError(
                    f"part {told(part)} of event {event.id} is used twice or is none"
                )
            if event.action == "stream":
                frames = None
            elif type(frames) is not int or frames < 1:
                raise DamagedError(f"event {event.id} tells of {told(frames)} frames")
            parts[part] = frames
    return parts


def _applied(state: SessionState, event: Event, name: str, gone: bool = False) -> SessionState:
    """The state with what an event changes, without its history; gone: it was undone."""
    change = _CHANGES.get(event.action)
    changed = {} if gone or not change else change(state, event, Source(name, SessionError))
    if event.action in _HOLDING:
        changed["holding"] = True
    return dataclasses.replace(state, **changed) if changed else state


Change = dict[str, Any]


def _ribbon(state: SessionState, event: Event, source: Source) -> Change:
    detail = dict(event.detail)
    firmware = None
    if "firmware" in detail:
        firmware = _table({"firmware": detail.pop("firmware")}, source, "ribbon", "firmware").text(
            "firmware", "the firmware's version"
        )
    ribbon = read_ribbon(detail, source)
    known = state.ribbon
    if known is not None and state.holding and not _alike(known, ribbon):
        source.refuse(
            f"its frames are of ribbon {known.id}, this is ribbon {ribbon.id}"
            f"{' with other sensors' if known.id == ribbon.id else ''}; begin a new session"
        )
    if state.calibration is not None:
        _check_fits(state.calibration, ribbon, source)
    return {"ribbon": ribbon, "firmware": firmware}


def _title(_state: SessionState, event: Event, source: Source) -> Change:
    table = _table(event.detail, source, "title", "title")
    return {"title": None if _null(table, "title") else table.prose("title", "a title")}


def _workpiece(_state: SessionState, event: Event, source: Source) -> Change:
    if not event.detail:
        return {"workpiece": None}
    top = Table({"workpiece": event.detail}, source, "", None, ("workpiece",))
    return {"workpiece": read_workpiece(top)}


def _plan(_state: SessionState, event: Event, source: Source) -> Change:
    table = _table(event.detail, source, "plan", "poses", "passes", "ties", "layout")
    poses, passes, ties = (
        _whole(table, key, 0, MAX_PLANNED) for key in ("poses", "passes", "ties")
    )
    laid = Table(table.data.get("layout", {}), source, "layout", None, _LAYOUT)
    layout = {
        key: _whole(laid, key, 0, MAX_PLANNED)
        if key in _LAYOUT_COUNTS
        else laid.positive(key, "a length in metres")
        for key in laid.data
    }
    return {"plan": SessionPlan(poses, passes, ties, layout)}


def _pose(state: SessionState, event: Event, source: Source) -> Change:
    _need_ribbon(state, source)
    table = _table(event.detail, source, "pose", *_POSE)
    key = table.text("key", "the pose's key")
    part, frames = _whole(table, "part", 1, MAX_PART), _whole(table, "frames", 1, None)
    found = read_pose(table, str(part))
    pose = CapturedPose(
        key, found.name, found.roll, found.heading, found.pitch, found.table, part, frames
    )
    poses = {one.key: one for one in state.poses} | {key: pose}
    _check_number(len(poses), source)
    return {"poses": tuple(poses.values()), "skipped": _without(state.skipped, key)}


def _pass(state: SessionState, event: Event, source: Source) -> Change:
    _need_ribbon(state, source)
    table = _table(event.detail, source, "pass", *_PASS)
    part, frames = _whole(table, "part", 1, MAX_PART), _whole(table, "frames", 1, None)
    found = read_pass(table, str(part))
    run = CapturedPass(found.name, found.kind, part, frames)
    passes = {one.name: one for one in state.passes} | {run.name: run}
    _check_number(len(passes), source)
    return {"passes": tuple(passes.values()), "skipped": _without(state.skipped, run.name)}


def _remove(state: SessionState, event: Event, source: Source) -> Change:
    kind, key = _one(event, source, "remove")
    if kind == "pose":
        _known(key, [one.key for one in state.poses], "pose", source)
        return {"poses": tuple(one for one in state.poses if one.key != key)}
    _known(key, [one.name for one in state.passes], "pass", source)
    return {"passes": tuple(one for one in state.passes if one.name != key)}


def _order(state: SessionState, event: Event, source: Source) -> Change:
    table = _table(event.detail, source, "order", "passes")
    count = len(state.passes)
    names = table.names("passes", count, f"the names of all {count} passes and ties")
    there = {one.name: one for one in state.passes}
    if set(names) != set(there):
        table.refuse("passes", "these are not the names of all passes and ties; name each once")
    return {"passes": tuple(there[name] for name in names)}


def _skip(state: SessionState, event: Event, source: Source) -> Change:
    _, key = _one(event, source, "skip")
    skipped = (*_without(state.skipped, key), key)
    _check_number(len(skipped), source)
    return {"skipped": skipped}


def _survey(state: SessionState, event: Event, source: Source) -> Change:
    top = Table(event.detail, source, "", None, _SURVEY)
    if not any(event.detail.values()):
        return {"marks": (), "distances": (), "crossings": ()}
    marks, distances, crossings = read_survey(top, _need_ribbon(state, source), None)
    return {"marks": marks, "distances": distances, "crossings": crossings}


def _setting(state: SessionState, event: Event, source: Source) -> Change:
    table = _table(event.detail, source, "setting", "pass", "key", "value")
    name = (table.text("pass", "a pass's name or *"), table.text("key", "the setting's name"))
    others = {key: value for key, value in state.settings.items() if key != name}
    if "value" not in event.detail:
        table.refuse(None, "the field value is missing; the setting's value is expected")
    value = event.detail["value"]
    _check_number(len(others) + 1, source)
    return {"settings": others if value is None else others | {name: value}}


def _settings(state: SessionState, event: Event, source: Source) -> Change:
    changes = event.detail.get("changes")
    if not isinstance(changes, list) or len(event.detail) != 1 or not changes:
        source.refuse("the changes of the settings are missing; a list of settings is expected")
    _check_number(len(changes), source)
    for one in changes:
        detail = one if isinstance(one, dict) else {}
        change = _setting(state, dataclasses.replace(event, detail=detail), source)
        state = dataclasses.replace(state, **change)
    return {"settings": state.settings}


def _calibration(state: SessionState, event: Event, source: Source) -> Change:
    table = _table(event.detail, source, "calibration", "document")
    if _null(table, "document"):
        return {"calibration": None}
    try:
        calibration = from_dict(event.detail["document"], f"{source.name}, the calibration")
    except CalibrationError as error:
        raise SessionError(str(error)) from error
    if state.ribbon is not None:
        _check_fits(calibration, state.ribbon, source)
    return {"calibration": calibration}


def _note(state: SessionState, event: Event, source: Source) -> Change:
    table = _table(event.detail, source, "note", "text", "pass")
    text = table.prose("text", "what is to be noted")
    name = table.text("pass", "a pass's name") if "pass" in event.detail else None
    _check_number(len(state.notes) + 1, source)
    return {"notes": (*state.notes, Note(event.time, text, name))}


def _stream(state: SessionState, event: Event, source: Source) -> Change:
    _need_ribbon(state, source)
    table = _table(event.detail, source, "stream", "part", "rate")
    part = _whole(table, "part", 1, MAX_PART)
    rate = table.positive("rate", "a number of frames per second greater than 0")
    _check_number(len(state.streams) + 1, source)
    return {"streams": (*state.streams, StreamEntry(part, rate, event.time))}


_CHANGES: dict[str, Callable[[SessionState, Event, Source], Change]] = {
    "ribbon": _ribbon,
    "title": _title,
    "workpiece": _workpiece,
    "plan": _plan,
    "pose": _pose,
    "pass": _pass,
    "remove": _remove,
    "order": _order,
    "skip": _skip,
    "survey": _survey,
    "setting": _setting,
    "settings": _settings,
    "calibration": _calibration,
    "note": _note,
    "stream": _stream,
}


def _alike(one: Ribbon, other: Ribbon) -> bool:
    """Whether the frames of one ribbon can stand beside those of the other."""
    return (one.id, one.length, one.sensors) == (other.id, other.length, other.sensors)


def _table(detail: Mapping[str, object], source: Source, name: str, *known: str) -> Table:
    return Table(detail, source, name, None, known)


def _null(table: Table, key: str) -> bool:
    """Whether a field stands there as null."""
    return key in table.data and table.data[key] is None


def _whole(table: Table, key: str, least: int, most: int | None) -> int:
    expected = f"a whole number from {least}" + ("" if most is None else f" to {most}")
    value = table.whole(key, expected)
    if value < least or value > (2**53 if most is None else most):
        table.refuse(key, f"{key} is {told(value)}; {expected} is expected")
    return value


def _one(event: Event, source: Source, name: str) -> tuple[str, str]:
    """Which pose or pass a detail names: ("pose", its key) or ("pass", its name)."""
    table = _table(event.detail, source, name, "pose", "pass")
    if len(event.detail) != 1:
        table.refuse(None, "one pose or one pass is expected")
    (kind,) = event.detail
    return kind, table.text(kind, f"a {kind}")


def _known(key: str, names: list[str], kind: str, source: Source) -> None:
    if key not in names:
        hint = nearest(key, names) or f"; name a {kind} that is there"
        source.refuse(f"there is no {kind} {told(key)}{hint}")


def _without(names: tuple[str, ...], name: str) -> tuple[str, ...]:
    return tuple(one for one in names if one != name)


def _need_ribbon(state: SessionState, source: Source) -> Ribbon:
    if state.ribbon is None:
        source.refuse("no ribbon is known yet; connect it first")
    return state.ribbon


def _check_number(count: int, source: Source) -> None:
    if count > MAX_FILES:
        source.refuse(f"{count} entries of one kind; a session keeps at most {MAX_FILES}")


def _check_fits(calibration: Calibration, ribbon: Ribbon, source: Source) -> None:
    try:
        check_fits(calibration, ribbon)
    except CalibrationError as error:
        raise SessionError(f"{source.name}: {error}") from error
