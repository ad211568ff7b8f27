"""Whether all of a session is as it was written: every frame, and the log beside it."""

import sqlite3
from collections.abc import Generator, Iterable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np

from georibbon.errors import RecordingError
from georibbon.session.carving import Carving, carved
from georibbon.session.chunks import Chunk, DamagedError, joined
from georibbon.session.counts import check_readings
from georibbon.session.database import read_chunks
from georibbon.session.files import kind_of
from georibbon.session.joining import grows
from georibbon.session.lock import head
from georibbon.session.reading import Contents, frames_of
from georibbon.session.state import SessionState
from georibbon.session.words import counted

_IN_LOG = b"\x02"  # in the header of a database whose latest pages are in a log


def check_wholly(database: sqlite3.Connection, found: Contents, path: Path) -> None:
    """DamagedError unless all frames make sense and all that the log holds is read.

    For a session that no program has open.
    """
    ends = check_frames(database, found)
    if has_log(path):
        with carved(path) as carving:
            _check_log(carving, found, ends)


def check_frames(database: sqlite3.Connection, found: Contents) -> dict[int, float]:
    """When each part ends, seconds; DamagedError unless all frames are as they were written."""
    return {part: _check_part(database, part, found.state) for part in found.sizes}


def has_log(path: Path) -> bool:
    """Whether a log is beside a session: it is open, or was left by a crash."""
    return kind_of(_log(path)) == "file"


def left_log(path: Path) -> str | None:
    """What a person must know of a session whose log was left behind, in words.

    For a session that no program has open; None where all is as it should be.
    """
    try:
        header = head(path, 20) or b""
    except OSError:
        return None
    if header[18:] != 2 * _IN_LOG or has_log(path):
        return None
    return (
        f"{_log(path).name} is not beside it: in a copy that was made while the session was open, "
        "or under another name than it had then, what was done last is missing; look for that file"
    )


def _log(path: Path) -> Path:
    return Path(f"{path.resolve()}-wal")


def _check_part(database: sqlite3.Connection, part: int, state: SessionState) -> float:
    """Check the frames of a part; returns the time of the last.  Raises DamagedError."""
    columns = () if state.ribbon is None else state.ribbon.columns
    if any(part == stream.part for stream in state.streams):
        # left before its end, it would close its cursor when the database is closed
        with closing(cast("Generator[Chunk, None, None]", read_chunks(database, part))) as chunks:
            return _check_stream(chunks, len(columns))
    readings = frames_of(read_chunks(database, part), state)
    try:
        check_readings(readings, columns, f"part {part}")
    except RecordingError as error:
        raise DamagedError(str(error)) from error
    return float(readings.t[-1])


def _check_stream(chunks: Iterable[Chunk], columns: int) -> float:
    """Check a stream piece by piece: it may be long.  Returns the time of the last frame."""
    end = -np.inf
    for i, chunk in enumerate(chunks):
        t = joined([replace(chunk, place=chunk.place - i)], columns).t
        if not grows(t) or t[0] <= end:
            raise DamagedError(f"the times of frames in part {chunk.part} do not grow")
        end = float(t[-1])
    return end


def _check_log(carving: Carving, found: Contents, ends: dict[int, float]) -> None:
    """DamagedError where the log holds what its reader gives up, as behind a damaged page."""
    if carving.conflicts:
        raise DamagedError(
            f"it and the log beside it tell of event {carving.conflicts[0]} differently"
        )
    read = {event.row for event in found.events}
    beyond = [event.id for event in carving.events if event.row not in read]
    frames = sum(
        float(np.frombuffer(carving.chunk(piece).t, "<f8")[-1]) > ends.get(piece.part, -np.inf)
        for piece in carving.pieces
        if piece.start.frame is not None
    )
    if beyond or frames:
        number = f"{counted(len(beyond), 'event')} and {counted(frames, 'piece')} of frames"
        raise DamagedError(f"opening it would lose {number}")
