"""What a session file holds beside its recording, in figures and in words."""

import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import TypedDict

from georibbon.recording import Recording
from georibbon.ribbon import Readings, Ribbon
from georibbon.session.describe import Facts, SurveyFacts, describe, describe_text
from georibbon.session.events import EVERY_PASS, Event
from georibbon.session.lock import holder
from georibbon.session.reading import Contents, contents, read_part, reading
from georibbon.session.recovery import recovery_of
from georibbon.session.restoring import recording_of
from georibbon.session.soundness import check_wholly, has_log, left_log
from georibbon.session.words import counted, told

_NO_RIBBON = Ribbon("", 0.0, 0.0, ())


NoteFacts = TypedDict("NoteFacts", {"time": str, "text": str, "pass": str | None})
SettingFacts = TypedDict("SettingFacts", {"pass": str, "key": str, "value": object})


class EventFacts(TypedDict):
    """One thing that was done; detail: what the journal says of it."""

    id: int
    time: str
    action: str
    detail: dict[str, object]


class StreamFacts(TypedDict):
    """Frames between poses and passes; rate: frames per second; time: of its beginning."""

    part: int
    rate: float
    time: str
    frames: int


class JournalFacts(TypedDict):
    """What the journal says beside the recording.

    version: of the file.  frames: all that are in it.  pending_survey: passes
    that the survey names and that are not captured.  undoable: what undoing
    would take back.
    """

    version: int
    frames: int
    streams: list[StreamFacts]
    notes: list[NoteFacts]
    events: list[EventFacts]
    settings: list[SettingFacts]
    skipped: list[str]
    calibrated: bool
    pending_survey: list[str]
    undoable: str | None


class SessionFacts(Facts, JournalFacts):
    """What `georibbon info` tells of a session.

    open_in: who has it open for writing.  recovery: what a crash had left, until
    a program opens it for writing.
    """

    open_in: str | None
    recovery: str | None


def tell(path: Path) -> SessionFacts:
    """The facts of a session file, be it complete or not, closed, open elsewhere or left.

    Raises SessionError as `read_session` does.
    """
    live = holder(path)  # who closes it while it is read had it open when it was read
    with reading(path) as database:
        found = contents(database, path)
        live = live or holder(path)
        recovery = None if live else _left(database, found, path)
        facts = _recorded(found, path, lambda part: read_part(database, part, found.state))
    return {**facts, **_beside(found), "open_in": live, "recovery": recovery}


def _left(database: sqlite3.Connection, found: Contents, path: Path) -> str | None:
    """What a crash, or who copied the session, has left."""
    if not found.closed or has_log(path):
        check_wholly(database, found, path)
    left = left_log(path)
    message = None if found.closed else recovery_of(database, found, path.name).message
    if left is None:
        return message
    return f"{message}; but {left}" if message else f"{path.name}: {left}"


def _recorded(found: Contents, path: Path, frames: Callable[[int], Readings]) -> Facts:
    """The facts of what was captured, with all of the survey."""
    state = found.state
    if state.ribbon is None:
        recording = Recording(_NO_RIBBON, (), (), title=state.title, workpiece=state.workpiece)
    else:
        recording = recording_of(state, frames, path.name, complete=False)
    survey: SurveyFacts = {
        "marks": len(state.marks),
        "distances": len(state.distances),
        "crossings": len(state.crossings),
    }
    facts = describe(recording)
    ribbon = None if state.ribbon is None else facts["ribbon"]
    return {**facts, "ribbon": ribbon, "survey": survey}


def _beside(found: Contents) -> JournalFacts:
    state = found.state
    return {
        "version": found.version,
        "frames": sum(found.sizes.values()),
        "streams": [
            {"part": s.part, "rate": s.rate, "time": s.time, "frames": found.sizes.get(s.part, 0)}
            for s in state.streams
        ],
        "notes": [{"time": n.time, "text": n.text, "pass": n.pass_name} for n in state.notes],
        "events": [_event(event) for event in found.events],
        "settings": [
            {"pass": name, "key": key, "value": value}
            for (name, key), value in state.settings.items()
        ],
        "skipped": list(state.skipped),
        "calibrated": state.calibration is not None,
        "pending_survey": list(state.pending_survey),
        "undoable": state.undoable,
    }


def _event(event: Event) -> EventFacts:
    return {
        "id": event.id,
        "time": event.time,
        "action": event.action,
        "detail": dict(event.detail),
    }


def tell_text(facts: SessionFacts) -> str:
    """The facts as lines for a person."""
    lines = [describe_text(facts)]
    if facts["pending_survey"]:
        lines.append(f"the survey waits for {', '.join(facts['pending_survey'])}")
    if facts["skipped"]:
        lines.append(f"skipped: {', '.join(facts['skipped'])}")
    lines += [_setting_line(setting) for setting in facts["settings"]]
    if facts["calibrated"]:
        lines.append("a calibration is in the session")
    lines += [_stream_line(stream) for stream in facts["streams"]]
    lines.append(f"{counted(facts['frames'], 'frame')} in all, file version {facts['version']}")
    lines += [_note_line(note) for note in facts["notes"]]
    lines.append(_history_line(facts))
    if facts["open_in"]:
        lines.append(f"open for writing: {facts['open_in'].rstrip(',')}")
    if facts["recovery"]:
        lines.append(facts["recovery"])
    return "\n".join(lines)


def _setting_line(setting: SettingFacts) -> str:
    whose = "all passes" if setting["pass"] == EVERY_PASS else setting["pass"]
    return f"{setting['key']} of {whose}: {told(setting['value'])}"


def _stream_line(stream: StreamFacts) -> str:
    return (
        f"{counted(stream['frames'], 'frame')} at {stream['rate']:g} frames/s "
        f"from {stream['time']} on"
    )


def _note_line(note: NoteFacts) -> str:
    whose = f" ({note['pass']})" if note["pass"] else ""
    text = note["text"].replace("\n", "\n    ")
    return f"note of {note['time']}{whose}: {text}"


def _history_line(facts: SessionFacts) -> str:
    last = facts["events"][-1]
    undo = f"; undoing would take back {facts['undoable']}" if facts["undoable"] else ""
    return f"{counted(len(facts['events']), 'event')}, the last at {last['time']}{undo}"
