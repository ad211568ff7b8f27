"""Session files opened for reading only: nothing in or beside them changes.

How a file is opened depends on how it was left: closed as one plain file, open
in another program, or left by a crash with its log (`-wal`) or its journal
beside it.
"""

import shutil
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from georibbon.errors import SessionError
from georibbon.ribbon import Readings
from georibbon.session import version1
from georibbon.session.chunks import Chunk, DamagedError, joined
from georibbon.session.database import (
    check_parts,
    check_tables,
    connect,
    damaged,
    pragma,
    read_chunks,
    read_events,
    read_sizes,
    version_of,
)
from georibbon.session.events import Event
from georibbon.session.files import kind_of
from georibbon.session.lock import head, holder, open_here
from georibbon.session.pages import has_header
from georibbon.session.schema import statements
from georibbon.session.state import SessionState, fold, parts_of

MAX_SESSION = 2**38
_MAGIC = b"SQLite format 3\x00"
_LOG_HEADER = 32  # bytes: a shorter log holds nothing


@dataclass(frozen=True, eq=False)
class Contents:
    """What a session file holds beside its frames.

    sizes: the number of frames in each part.  closed: whether it was closed by
    the program that wrote it last.
    """

    version: int
    events: tuple[Event, ...]
    state: SessionState
    sizes: dict[int, int]
    closed: bool


def check_file(path: Path) -> None:
    """Raise SessionError for what is no file, no SQLite database or too large."""
    kind = kind_of(path)
    if kind == "nothing":
        raise SessionError(f"{path}: there is no such file; give the name of a session file")
    if kind != "file":
        raise SessionError(f"{path}: this is no file; give the name of a session file")
    try:
        session = head(path, len(_MAGIC)) in (None, _MAGIC)
        size = path.stat().st_size
    except OSError as error:
        reason = error.strerror or error
        raise SessionError(f"{path}: it cannot be read ({reason}); see to its rights") from error
    if not session:
        raise SessionError(f"{path.name}: this is no Georibbon session; give a .georibbon file")
    if size > MAX_SESSION:
        raise SessionError(f"{path.name}: {size} bytes; at most {MAX_SESSION} are read")


@contextmanager
def reading(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection to a session file that can only read, in one transaction.

    Raises SessionError, one sentence, for whatever goes wrong in it.
    """
    check_file(path)
    try:
        with _opened(path) as database:
            database.execute("PRAGMA query_only = ON")
            database.execute("BEGIN")
            yield database
    except DamagedError as error:
        raise damaged(path, error) from error
    except sqlite3.OperationalError as error:
        if "locked" in str(error) or "busy" in str(error):
            message = f"{path.name}: another program is writing to the session; close it there"
            raise SessionError(message) from error
        raise damaged(path, error) from error
    except (sqlite3.Error, OverflowError, MemoryError, UnicodeError) as error:
        raise damaged(path, error) from error
    except OSError as error:
        reason = error.strerror or error
        raise SessionError(f"{path}: it cannot be read ({reason}); see to its rights") from error


def contents(database: sqlite3.Connection, path: Path) -> Contents:
    """What the file holds, all of it checked but the frames themselves."""
    version = version_of(database, path)
    if version == 1:
        events = version1.read_events(database)
    else:
        check_tables(database, statements(), version)
        events = read_events(database)
    state, sizes = fold(events, path.name), read_sizes(database)
    check_parts(parts_of(events), sizes)
    last = events[-1]
    if last.action == "closed" and last.detail.get("frames") != sum(sizes.values()):
        raise DamagedError("frames are missing")
    return Contents(version, events, state, sizes, last.action == "closed")


def frames_of(chunks: Iterable[Chunk], state: SessionState) -> Readings:
    """The readings in the chunks of one part of a session, none in a stream without any.

    Raises DamagedError where they make no sense.
    """
    columns = 0 if state.ribbon is None else len(state.ribbon.columns)
    found = list(chunks)
    return joined(found, columns) if found else Readings(np.empty(0), np.empty((0, columns)))


def read_part(database: sqlite3.Connection, part: int, state: SessionState) -> Readings:
    """The readings of a part; DamagedError where they are not as they were written."""
    return frames_of(read_chunks(database, part), state)


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection suited to how the file was left."""
    resolved = path.resolve()
    query = _way(resolved)
    database = None if query is None else _tried(resolved, query)
    if database is not None:
        with closing(database):
            yield database
        return
    # SQLite has to finish what was broken off: in a copy
    with tempfile.TemporaryDirectory(prefix="georibbon-") as folder:
        copy = _copied(resolved, Path(folder))
        with closing(connect(f"{copy.as_uri()}?mode=rw")) as database:
            yield database


def _way(path: Path) -> str | None:
    """How SQLite can read a file where it is and change nothing; None where it cannot."""
    log, index, journal = (Path(f"{path}{end}") for end in ("-wal", "-shm", "-journal"))
    if open_here(path) or holder(path) is not None:
        return "mode=ro"
    if kind_of(journal) != "nothing":
        return None
    if _size(log) >= _LOG_HEADER:
        # of a log whose header is damaged SQLite would make no index, and wait for one for long
        fits = kind_of(index) != "nothing" and has_header(log)
        return "mode=ro&readonly_shm=1" if fits else None
    if (head(path, 20) or b"")[19:] == b"\x02":
        return "mode=ro&immutable=1"  # in WAL mode, with nothing in the log
    return "mode=ro"


def _tried(path: Path, query: str) -> sqlite3.Connection | None:
    """A connection of one kind; None where the log or its index was left half made."""
    database = connect(f"{path.as_uri()}?{query}")
    try:
        pragma(database, "schema_version")
    except sqlite3.Error:
        database.close()
        if "readonly_shm" in query:
            return None
        raise
    return database


def _size(path: Path) -> int:
    """The size of a file, 0 where there is none."""
    return path.stat().st_size if kind_of(path) == "file" else 0


def _copied(path: Path, folder: Path) -> Path:
    """A copy of a session with its log and journal."""
    for end in ("", "-wal", "-journal"):
        if kind_of(Path(f"{path}{end}")) == "file":
            shutil.copyfile(f"{path}{end}", folder / f"{path.name}{end}")
    return folder / path.name
