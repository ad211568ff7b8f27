"""Recordings out of sessions, and sessions out of recordings."""

from collections.abc import Callable, Sequence

from georibbon import __version__
from georibbon.errors import RecordingError, SessionError
from georibbon.recording import Recording
from georibbon.ribbon import Readings, Ribbon
from georibbon.session.chunks import Chunk, pack
from georibbon.session.counts import check_readings
from georibbon.session.events import Event, now
from georibbon.session.fields import Source
from georibbon.session.folder import check_recording, readings_of
from georibbon.session.outline import (
    Outline,
    PassEntry,
    PoseEntry,
    check_count,
    read_outline,
    ribbon_table,
    survey_tables,
    tables_of,
)
from georibbon.session.state import SessionState

MAX_FRAMES = 2**30  # bytes of all poses and passes that are taken into memory


def recording_of(
    state: SessionState, frames: Callable[[int], Readings], name: str, complete: bool
) -> Recording:
    """The recording that a session holds so far; entries of the survey that wait are left out.

    frames: the readings of a part.  complete: refuse, with a SessionError, what
    cannot span a surface.
    """
    outline = _outline(state, Source(name, SessionError), complete)
    columns = outline.ribbon.columns
    frames_of = [pose.frames for pose in state.poses] + [run.frames for run in state.passes]
    size = sum(frames_of) * (8 + 2 * len(columns))
    if size > MAX_FRAMES:
        raise SessionError(
            f"{name}: frames of {size} bytes; at most {MAX_FRAMES} are read; split it"
        )
    found = []
    for file, what in zip(outline.files, outline.names, strict=True):
        readings = frames(int(file))
        try:
            check_readings(readings, columns, f"{name}, {what}")
        except RecordingError as error:
            raise SessionError(str(error)) from error
        found.append(readings)
    return outline.filled(found)


def _outline(state: SessionState, source: Source, complete: bool) -> Outline:
    """The outline of what is captured; the files are the numbers of the parts."""
    if state.ribbon is None:
        source.refuse("no ribbon was connected, and nothing captured; capture something first")
    poses = tuple(
        PoseEntry(p.name, p.roll, p.heading, p.pitch, p.table, str(p.part)) for p in state.poses
    )
    passes = tuple(PassEntry(run.name, run.kind, str(run.part)) for run in state.passes)
    if complete:
        check_count(passes, source)
    there = {run.name for run in passes}
    return Outline(
        state.ribbon,
        poses,
        passes,
        tuple(one for one in state.marks if one.pass_name in there),
        tuple(one for one in state.distances if there.issuperset(one.passes)),
        tuple(one for one in state.crossings if there.issuperset(one.passes)),
        state.workpiece,
        state.title,
    )


def journal_of(recording: Recording) -> tuple[tuple[Event, ...], list[Chunk]]:
    """The events and the frames of a new, closed session that holds a recording.

    Raises RecordingError where the recording cannot be meant.
    """
    readings = readings_of(recording)
    files = [str(part) for part in range(1, len(readings) + 1)]
    outline = read_outline(tables_of(recording, files), Source("the recording", RecordingError))
    check_recording(recording, outline)
    time = now()
    events = tuple(
        Event(i, time, action, detail)
        for i, (action, detail) in enumerate(_actions(outline, readings), start=1)
    )
    return events, [c for part, r in enumerate(readings, start=1) for c in pack(r, part)]


def _actions(outline: Outline, readings: Sequence[Readings]) -> list[tuple[str, dict[str, object]]]:
    """What has to be done for a session to hold a recording."""
    frames = [one.t.size for one in readings]
    found = begun(outline.ribbon, outline.title)
    piece = outline.workpiece
    if piece is not None:
        heading = {} if piece.heading is None else {"heading": piece.heading}
        found.append(("workpiece", {"level": piece.level, **heading}))
    for i, pose in enumerate(outline.poses):
        where = {"part": int(pose.file), "frames": frames[i]}
        fields = {k: getattr(pose, k) for k in ("name", "roll", "heading", "pitch", "table")}
        found.append(("pose", {"key": f"pose-{i + 1:02}"} | fields | where))
    for i, run in enumerate(outline.passes, start=len(outline.poses)):
        where = {"part": int(run.file), "frames": frames[i]}
        found.append(("pass", {"name": run.name, "kind": run.kind, **where}))
    survey = survey_tables(outline.marks, outline.distances, outline.crossings)
    if any(survey.values()):
        found.append(("survey", dict(survey)))
    return [*found, ("closed", {"frames": sum(frames)})]


def begun(ribbon: Ribbon | None, title: str | None) -> list[tuple[str, dict[str, object]]]:
    """The first actions of a session."""
    found: list[tuple[str, dict[str, object]]] = [("created", {"georibbon": __version__})]
    if ribbon is not None:
        found.append(("ribbon", ribbon_table(ribbon)))
    if title is not None:
        found.append(("title", {"title": title}))
    return found
