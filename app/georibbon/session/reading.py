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

from georibbon.errors import SessionError
from georibbon.ribbon import Readings
from georibbon.session import version1
from georibbon.session.chunks import Chunk, DamagedError, joined
from georibbon.session.database import (
    check_parts,
    check_tables,
    connect,
    damaged,
    read_chunks,
    read_events,
    read_sizes,
    version_of,
)
from georibbon.session.events import Event
from georibbon.session.files import kind_of
from georibbon.session.lock import holder, open_here
from georibbon.session.schema import statements
from georibbon.session.state import SessionState, fold, parts_of

MAX_SESSION = 2**38
_MAGIC = b"SQLite format 3\x00"


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
        session = open_here(path) or _head(path, len(_MAGIC)) == _MAGIC
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
    """The readings in the chunks of one part of a session; DamagedError where they are none."""
    columns = () if state.ribbon is None else state.ribbon.columns
    return joined(list(chunks), len(columns))


def read_part(database: sqlite3.Connection, part: int, state: SessionState) -> Readings:
    """The readings of a part; DamagedError where they are not as they were written."""
    return frames_of(read_chunks(database, part), state)


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection suited to how the file was left."""
    resolved = path.resolve()
    log, index, journal = (Path(f"{resolved}{end}") for end in ("-wal", "-shm", "-journal"))
    with tempfile.TemporaryDirectory(prefix="georibbon-") as folder:
        query = "mode=ro"
        if open_here(path) or holder(path) is not None:
            pass
        elif kind_of(journal) != "nothing" or (
            kind_of(log) != "nothing" and kind_of(index) == "nothing"
        ):
            # SQLite has to finish what was broken off: in a copy
            resolved, query = _copied(resolved, Path(folder)), "mode=rw"
        elif kind_of(log) != "nothing":
            query = "mode=ro&readonly_shm=1"
        elif _head(resolved, 20)[19:] == b"\x02":
            query = "mode=ro&immutable=1"  # in WAL mode, with nothing in the log
        with closing(connect(f"{resolved.as_uri()}?{query}")) as database:
            yield database


def _copied(path: Path, folder: Path) -> Path:
    """A copy of a session with its log and journal."""
    for end in ("", "-wal", "-journal"):
        if kind_of(Path(f"{path}{end}")) == "file":
            shutil.copyfile(f"{path}{end}", folder / f"{path.name}{end}")
    return folder / path.name


def _head(path: Path, count: int) -> bytes:
    with path.open("rb") as file:
        return file.read(count)
