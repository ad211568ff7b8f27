"""SQLite as sessions use it: connections, what they are checked for, what failures mean."""

import shutil
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

from georibbon.errors import SessionError, StorageError
from georibbon.session.chunks import Chunk, DamagedError, chunk_of
from georibbon.session.events import MAX_EVENTS, Event, event_of
from georibbon.session.schema import APPLICATION_ID, PAGE_SIZE, VERSION, statements
from georibbon.session.words import told

MAX_ROW = 64 * 2**20
_FULL = ("SQLITE_FULL",)
_RIGHTS = ("SQLITE_READONLY", "SQLITE_CANTOPEN", "SQLITE_PERM", "SQLITE_AUTH")
_TAKEN = ("SQLITE_BUSY", "SQLITE_LOCKED")
_FAILED = ("SQLITE_IOERR",)
_COLLISION = ("SQLITE_CONSTRAINT",)
_INDEX = 2**16  # bytes: the least that the index of a log grows by is half of it
_DAMAGED = ("SQLITE_CORRUPT", "SQLITE_NOTADB")


def connect(uri: str, timeout: float = 5.0) -> sqlite3.Connection:
    """A connection in autocommit mode that trusts nothing in the file; used by one thread a time.

    timeout: seconds to wait for another connection's lock.
    """
    database = sqlite3.connect(
        uri, uri=True, isolation_level=None, check_same_thread=False, timeout=timeout
    )
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_ROW)
    for setting in ("trusted_schema = OFF", "cell_size_check = ON"):
        database.execute(f"PRAGMA {setting}")
    return database


def pragma(database: sqlite3.Connection, name: str) -> object:
    """The first value that a pragma gives, or None."""
    row = database.execute(f"PRAGMA {name}").fetchone()
    return row[0] if row else None


def version_of(database: sqlite3.Connection, path: Path) -> int:
    """The version of a session's tables; SessionError for what is no session or a newer one."""
    if pragma(database, "application_id") != APPLICATION_ID:
        raise SessionError(
            f"{path.name}: this is another program's database, no Georibbon session; give a "
            ".georibbon file"
        )
    version = pragma(database, "user_version")
    if isinstance(version, int) and version > VERSION:
        raise SessionError(
            f"{path.name}: the session has version {version}, newer than {VERSION}, the newest "
            "that this program reads; use a newer Georibbon"
        )
    if not isinstance(version, int) or version < 1:
        raise DamagedError(f"its version is {version}")
    return version


def check_tables(database: sqlite3.Connection, expected: dict[str, str], version: int) -> None:
    """DamagedError unless the tables are, word for word, as expected, and the pages sound."""
    query = "SELECT type, name, sql FROM sqlite_schema WHERE sql IS NOT NULL"
    found = database.execute(query).fetchmany(len(expected) + 1)
    if set(found) != {("table", name, sql) for name, sql in expected.items()}:
        raise DamagedError(f"its tables are not those of version {version}")
    fault = pragma(database, "integrity_check(1)")
    if fault != "ok":
        raise DamagedError(str(fault).split("\n")[-1])


def fill(database: sqlite3.Connection, events: Sequence[Event], chunks: Iterable[Chunk]) -> None:
    """Fill a new database in one transaction; it needs no journal, as failing drops the file."""
    database.execute(f"PRAGMA page_size = {PAGE_SIZE}")
    database.execute("PRAGMA journal_mode = OFF")
    database.execute("PRAGMA synchronous = FULL")
    database.execute("BEGIN")
    database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    database.execute(f"PRAGMA user_version = {VERSION}")
    for statement in statements().values():
        database.execute(statement)
    insert(database, events, chunks)
    database.execute("COMMIT")


def insert(database: sqlite3.Connection, events: Iterable[Event], chunks: Iterable[Chunk]) -> None:
    """Put rows into the tables; the same ones twice are there once.

    Raises sqlite3.IntegrityError where another event has the id of one: events
    are never replaced.
    """
    database.executemany(
        "INSERT INTO event SELECT ?, ?, ?, ?, ? "
        "WHERE NOT EXISTS (SELECT 1 FROM event WHERE id = ? AND digest = ?)",
        ((*row, row[0], row[-1]) for row in (event.row for event in events)),
    )
    database.executemany(
        "INSERT OR REPLACE INTO chunk VALUES (?, ?, ?, ?, ?, ?, ?)", (c.row for c in chunks)
    )


def read_events(database: sqlite3.Connection) -> tuple[Event, ...]:
    """All events; DamagedError for a row that is not as it was written."""
    events: list[Event] = []
    # a cursor that an error keeps alive would keep the file locked
    with closing(database.execute("SELECT * FROM event ORDER BY id")) as rows:
        for row in rows:
            if len(events) == MAX_EVENTS:
                raise DamagedError(f"there are more than {MAX_EVENTS} events")
            events.append(event_of(row))
    return tuple(events)


def read_chunks(database: sqlite3.Connection, part: int) -> Iterator[Chunk]:
    """The chunks of a part in their order; DamagedError for one that is not as it was written."""
    query = "SELECT * FROM chunk WHERE part = ? ORDER BY place"
    with closing(database.execute(query, (part,))) as rows:
        for row in rows:
            yield chunk_of(row)


def read_sizes(database: sqlite3.Connection) -> dict[int, int]:
    """The number of frames in each part, as the rows tell it."""
    return dict(database.execute("SELECT part, sum(frames) FROM chunk GROUP BY part"))


def check_parts(parts: dict[int, int | None], sizes: dict[int, int]) -> None:
    """DamagedError unless the parts that events tell of are those that hold frames."""
    for part, frames in parts.items():
        found = sizes.get(part, 0)
        if frames is not None and frames != found:
            raise DamagedError(f"part {part} has {found} frames, not {frames}")
    unknown = sizes.keys() - parts.keys()
    if unknown:
        raise DamagedError(f"no event tells of part {min(unknown)}")


def busy(error: Exception) -> bool:
    """Whether another connection was in the way."""
    return _name(error).startswith(_TAKEN)


def unreadable(path: Path, error: Exception) -> SessionError:
    """What a failure to read from an open session means: the place fails, or it is damaged."""
    if isinstance(error, sqlite3.ProgrammingError):
        return SessionError(f"{path.name}: the session was closed meanwhile; open it again")
    if _name(error).startswith((*_FULL, *_FAILED, *_RIGHTS, *_TAKEN)):
        return storage_error(path, error)
    return damaged(path, error)


def storage_error(path: Path, error: Exception, held: bool = True) -> StorageError:
    """What a failure to write means, in one sentence with its remedy.

    held: whether something was to be written that is in memory.
    """
    kept = " (what is captured is kept in memory until then)" if held else ""
    return StorageError(f"{path.name}: {reason_of(path, error)}{kept}")


def reason_of(path: Path, error: Exception) -> str:
    """What a failure to write means, and its remedy, without the name of the file."""
    name = _name(error)
    if name.startswith(_FULL) or (name.startswith(_FAILED) and _no_room(path)):
        reason = "the disk is full; make room and try again, or save to another place"
    elif name.startswith(_RIGHTS):
        reason = (
            "it may not be written here; see to the rights of file and folder and try again, or "
            "save to another place"
        )
    elif name.startswith(_TAKEN):
        reason = "another program has locked it; close it there and try again"
    elif name.startswith(_DAMAGED):
        reason = "the file has been damaged; save to another place"
    elif name.startswith(_COLLISION):
        reason = "another program has written other events to it; save to another place"
    else:
        reason = f"it cannot be written ({told(str(error))[1:-1]}); save to another place"
    return reason


def _name(error: Exception) -> str:
    return getattr(error, "sqlite_errorname", "") or ""


def _no_room(path: Path) -> bool:
    """Whether a disk has no room even for an index: SQLite tells of that as of any failure."""
    try:
        return shutil.disk_usage(path.resolve().parent).free < _INDEX
    except OSError:
        return False


def damaged(path: Path, cause: Exception) -> SessionError:
    """The sentence for a file whose bytes are not what they were."""
    return SessionError(
        f"{path.name}: the session file is damaged ({told(str(cause))[1:-1]}); "
        "`georibbon check` saves what can be read"
    )
