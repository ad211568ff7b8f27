"""A session that a crash left open: whether all of it is sound, and how far it goes."""

import datetime
import sqlite3
from dataclasses import dataclass, replace

from georibbon.ribbon import Readings
from georibbon.session.actions import in_words
from georibbon.session.chunks import chunk_of, joined
from georibbon.session.events import Event
from georibbon.session.reading import Contents
from georibbon.session.state import StreamEntry
from georibbon.session.words import counted


@dataclass(frozen=True)
class Recovery:
    """What was recovered: one sentence; all frames of the file; the last moment kept (UTC)."""

    message: str
    frames: int
    time: str


def recovery_of(database: sqlite3.Connection, found: Contents, name: str) -> Recovery:
    """What a session that was not closed still holds, which is all that was acknowledged."""
    state, frames = found.state, sum(found.sizes.values())
    times = [found.events[-1].time]
    times += [_end(database, found, stream) for stream in state.streams]
    last = max(times, key=datetime.datetime.fromisoformat)
    holds = ", ".join(
        (
            counted(frames, "frame"),
            counted(len(state.poses), "pose"),
            counted(len(state.passes), "pass or tie", "passes and ties"),
        )
    )
    message = (
        f"{name} was not closed; it is sound, and everything acknowledged up to {last} is there: "
        f"{holds}; last came {in_words(_last(found))}"
    )
    return Recovery(message, frames, last)


def _last(found: Contents) -> Event:
    """The last event that a person knows of."""
    own = ("opened", "closed", "recovered")
    return next((one for one in reversed(found.events) if one.action not in own), found.events[0])


def _end(database: sqlite3.Connection, found: Contents, stream: StreamEntry) -> str:
    """When the last frame of a stream came: its beginning, and what its frames took."""
    first, last = (_moment(database, found, stream.part, order) for order in ("ASC", "DESC"))
    if first is None or last is None:
        return stream.time
    begun = datetime.datetime.fromisoformat(stream.time)
    try:
        end = begun + datetime.timedelta(seconds=float(last.t[-1] - first.t[0]))
    except (OverflowError, ValueError):
        return stream.time
    return end.isoformat(timespec="milliseconds")


def _moment(
    database: sqlite3.Connection, found: Contents, part: int, order: str
) -> Readings | None:
    """The frames of the first or the last chunk of a part."""
    query = f"SELECT * FROM chunk WHERE part = ? ORDER BY place {order} LIMIT 1"  # noqa: S608 (our words)
    row = database.execute(query, (part,)).fetchone()
    if row is None or found.state.ribbon is None:
        return None
    return joined([replace(chunk_of(row), place=0)], len(found.state.ribbon.columns))
