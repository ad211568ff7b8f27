"""The session file: one SQLite database with everything that a capture measured.

What is in it is described in `schema`.  It is read as something that anybody
may have sent: read only, with the schema compared word for word, every row
against its seal, every value against the same checks as a recording folder's.
"""

import datetime
import hashlib
import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NoReturn

from georibbon import __version__
from georibbon.errors import RecordingError, SessionError
from georibbon.recording import Recording
from georibbon.ribbon import Readings
from georibbon.session.chunks import DamagedError, pack, unpack
from georibbon.session.counts import check_readings
from georibbon.session.fields import Source
from georibbon.session.files import built_file, kind_of
from georibbon.session.folder import check_recording, readings_of
from georibbon.session.outline import Outline, read_outline, tables_of
from georibbon.session.schema import APPLICATION_ID
from georibbon.session.version1 import TABLES, VERSION, statements

MAX_SESSION = 4 * 2**30
MAX_ROW = 64 * 2**20
MAX_ROWS = 1_000_000
MAX_FRAMES = 2**30
_MAGIC = b"SQLite format 3\x00"
Row = tuple[object, ...]


def create_session(path: Path, recording: Recording) -> None:
    """Write a recording into a new session file.

    It is written beside and renamed when whole.  Raises SessionError where a
    file is there already, or the place cannot be written; RecordingError where
    the recording cannot be meant.
    """
    check_place(path)
    files = [str(i + 1) for i in range(len(recording.poses) + len(recording.passes))]
    tables = tables_of(recording, files)
    outline = read_outline(tables, Source("the recording", RecordingError))
    check_recording(recording, outline)
    try:
        with (
            built_file(path, SessionError) as built,
            closing(sqlite3.connect(built, isolation_level=None)) as database,
        ):
            _fill(database, outline, readings_of(recording))
    except sqlite3.Error as error:
        raise SessionError(f"{path}: the session cannot be written ({error})") from error


def read_session(path: Path) -> Recording:
    """The recording in a session file; the file is opened read only.

    Raises SessionError, one sentence, for a file that is missing, no session,
    of a newer version, damaged in any place, or that holds what cannot be meant.
    """
    _check_file(path)
    try:
        with _opened(path) as database:
            _check_database(database, path)
            outline = read_outline(_tables(database), Source(path.name, SessionError))
            return outline.filled(_readings(database, outline, path))
    except DamagedError as error:
        _refuse_damaged(path, error)
    except sqlite3.OperationalError as error:
        if "locked" in str(error) or "busy" in str(error):
            message = f"{path.name}: another program is writing to the session; close it there"
            raise SessionError(message) from error
        _refuse_damaged(path, error)
    except (sqlite3.Error, OverflowError, MemoryError, UnicodeError) as error:
        _refuse_damaged(path, error)


def _refuse_damaged(path: Path, cause: Exception) -> NoReturn:
    raise SessionError(
        f"{path.name}: the session file is damaged ({cause}); take a copy of it made before, or "
        "import the recording again"
    ) from cause


def check_place(path: Path) -> None:
    """Raise SessionError where a new session cannot take this name."""
    kind = kind_of(path)
    if kind not in ("file", "nothing"):
        raise SessionError(f"{path}: this is a folder or a device; give the name of a file")
    if kind == "file":
        raise SessionError(
            f"{path}: there is such a file already and its data is not overwritten; choose another "
            "name"
        )
    for ending in ("-wal", "-journal"):
        if kind_of(Path(f"{path}{ending}")) != "nothing":
            raise SessionError(
                f"{path}{ending}: the session of this name is open in another program or was not "
                "closed; close it first or give another name"
            )


def _fill(database: sqlite3.Connection, outline: Outline, readings: Sequence[Readings]) -> None:
    """Fill a new database in one transaction; it needs no journal, as failing drops the file."""
    database.execute("PRAGMA journal_mode = OFF")
    database.execute("BEGIN")
    database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    database.execute(f"PRAGMA user_version = {VERSION}")
    for statement in statements().values():
        database.execute(statement)
    for name, rows in _rows(outline, readings).items():
        _insert(database, name, rows)
    for part, frames in enumerate(readings, start=1):
        _insert(database, "chunk", [chunk.row for chunk in pack(frames, part)])
    for name in TABLES:
        _insert(database, "seal", [(name, _digest(_select(database, name)))])
    database.execute("COMMIT")


def _insert(database: sqlite3.Connection, table: str, rows: Sequence[Row]) -> None:
    if rows:
        marks = ", ".join("?" * len(rows[0]))
        database.executemany(f'INSERT INTO "{table}" VALUES ({marks})', rows)  # noqa: S608 (our names)


def _rows(outline: Outline, readings: Sequence[Readings]) -> dict[str, list[Row]]:
    """The rows of the sealed tables."""
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    ribbon, piece = outline.ribbon, outline.workpiece
    title: list[Row] = [] if outline.title is None else [("title", outline.title)]
    sensors = enumerate(ribbon.sensors)
    return {
        "meta": [*title, ("created", now), ("georibbon", __version__)],
        "ribbon": [(1, ribbon.id, ribbon.length, ribbon.rate)],
        "sensor": [(i, s.name, s.kind, s.axes, s.position, s.counts_per_unit) for i, s in sensors],
        "workpiece": [] if piece is None else [(1, int(piece.level), piece.heading)],
        "part": [(i, frames.t.size) for i, frames in enumerate(readings, start=1)],
        "pose": [
            (i, p.name, p.roll, p.heading, p.pitch, int(p.table), int(p.file))
            for i, p in enumerate(outline.poses)
        ],
        "pass": [(i, p.name, p.kind, int(p.file)) for i, p in enumerate(outline.passes)],
        "mark": [(i, m.pass_name, m.at, *m.position, m.sigma) for i, m in enumerate(outline.marks)],
        "distance": [
            (i, *d.passes, *d.at, d.distance, d.sigma) for i, d in enumerate(outline.distances)
        ],
        "crossing": [(i, *c.passes, *c.at, c.sigma) for i, c in enumerate(outline.crossings)],
        "history": [(1, now, "created", json.dumps({"georibbon": __version__}))],
    }


def _check_file(path: Path) -> None:
    kind = kind_of(path)
    if kind == "nothing":
        raise SessionError(f"{path}: there is no such file; give the name of a session file")
    if kind != "file":
        raise SessionError(f"{path}: this is no file; give the name of a session file")
    try:
        with path.open("rb") as file:
            session = file.read(len(_MAGIC)) == _MAGIC
        size = path.stat().st_size
    except OSError as error:
        reason = error.strerror or error
        raise SessionError(f"{path}: it cannot be read ({reason}); see to its rights") from error
    if not session:
        raise SessionError(f"{path.name}: this is no Georibbon session; give a .georibbon file")
    if size > MAX_SESSION:
        raise SessionError(f"{path.name}: {size} bytes; at most {MAX_SESSION} are read")


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection that can only read, in one transaction.

    A session in WAL mode that no program has open is taken as it lies: to share
    it, SQLite would put two files beside it.
    """
    alone = kind_of(Path(f"{path}-wal")) == "nothing" and _in_wal_mode(path)
    uri = f"{path.resolve().as_uri()}?mode=ro{'&immutable=1' if alone else ''}"
    database = sqlite3.connect(uri, uri=True, isolation_level=None)
    with closing(database):
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_ROW)
        for setting in ("trusted_schema = OFF", "query_only = ON", "cell_size_check = ON"):
            database.execute(f"PRAGMA {setting}")
        database.execute("BEGIN")
        yield database


def _in_wal_mode(path: Path) -> bool:
    """Whether the header says so (byte 19, counted from 0: the version that a reader needs)."""
    with path.open("rb") as file:
        return file.read(20)[19:] == b"\x02"


def _check_database(database: sqlite3.Connection, path: Path) -> None:
    """Refuse another program's database, a newer version and damage."""
    if _pragma(database, "application_id") != APPLICATION_ID:
        raise SessionError(
            f"{path.name}: this is another program's database, no Georibbon session; give a "
            ".georibbon file"
        )
    version = _pragma(database, "user_version")
    if isinstance(version, int) and version > VERSION:
        raise SessionError(
            f"{path.name}: the session has version {version}, newer than {VERSION}, the newest "
            "that this program reads; use a newer Georibbon"
        )
    if version != VERSION:
        raise DamagedError(f"its version is {version}")
    found = database.execute(
        "SELECT type, name, sql FROM sqlite_schema WHERE sql IS NOT NULL"
    ).fetchmany(len(statements()) + 1)
    if set(found) != {("table", name, sql) for name, sql in statements().items()}:
        raise DamagedError("its tables are not those of version 1")
    fault = _pragma(database, "integrity_check(1)")
    if fault != "ok":
        raise DamagedError(str(fault).split("\n")[-1])
    seals = _pairs(database, "seal")
    for name in TABLES:
        if seals.get(name) != _digest(_select(database, name)):
            raise DamagedError(f"the table {name} does not match its seal")


def _pragma(database: sqlite3.Connection, name: str) -> object:
    row = database.execute(f"PRAGMA {name}").fetchone()
    return row[0] if row else None


def _select(database: sqlite3.Connection, table: str) -> list[Row]:
    """All rows of a small table in the order of its first column."""
    query = f'SELECT * FROM "{table}" ORDER BY 1'  # noqa: S608 (the names are ours)
    rows = database.execute(query).fetchmany(MAX_ROWS + 1)
    if len(rows) > MAX_ROWS:
        raise DamagedError(f"the table {table} has more than {MAX_ROWS} rows")
    return rows


def _digest(rows: Sequence[Row]) -> bytes:
    """The seal of a table's rows."""
    try:
        text = "\n".join(json.dumps(row) for row in rows)
    except TypeError as error:
        raise DamagedError("a row holds bytes where none belong") from error
    return hashlib.sha256(text.encode()).digest()


def _tables(database: sqlite3.Connection) -> dict[str, object]:
    """The session's rows as the tables of a recording."""
    meta = _pairs(database, "meta")
    tables: dict[str, object] = {"title": meta["title"]} if "title" in meta else {}
    sensor = ("name", "kind", "axes", "position", "counts_per_unit")
    for _, name, length, rate in _select(database, "ribbon"):
        sensors = _named(_select(database, "sensor"), sensor)
        tables["ribbon"] = {"id": name, "length": length, "rate": rate, "sensor": sensors}
    for _, level, heading in _select(database, "workpiece"):
        known = {} if heading is None else {"heading": heading}
        tables["workpiece"] = {"level": _flag(level)} | known
    pose = ("name", "roll", "heading", "pitch", "table", "file")
    tables["pose"] = [
        row | {"table": _flag(row["table"]), "file": str(row["file"])}
        for row in _named(_select(database, "pose"), pose)
    ]
    tables["pass"] = [
        row | {"file": str(row["file"])}
        for row in _named(_select(database, "pass"), ("name", "kind", "file"))
    ]
    return tables | _survey(database)


def _survey(database: sqlite3.Connection) -> dict[str, object]:
    return {
        "mark": [
            {"pass": name, "at": at, "position": [x, y, z], "sigma": sigma}
            for _, name, at, x, y, z, sigma in _select(database, "mark")
        ],
        "distance": [
            {"passes": [p, q], "at": [a, b], "distance": distance, "sigma": sigma}
            for _, p, q, a, b, distance, sigma in _select(database, "distance")
        ],
        "crossing": [
            {"passes": [p, q], "at": [a, b], "sigma": sigma}
            for _, p, q, a, b, sigma in _select(database, "crossing")
        ],
    }


def _pairs(database: sqlite3.Connection, table: str) -> dict[object, object]:
    """The rows of a table of two columns."""
    return {row[0]: row[1] for row in _select(database, table)}


def _named(rows: Sequence[Row], names: tuple[str, ...]) -> list[dict[str, object]]:
    """Rows as tables, without their first column."""
    return [dict(zip(names, row[1:], strict=True)) for row in rows]


def _flag(value: object) -> object:
    return bool(value) if value in (0, 1) else value


def _readings(database: sqlite3.Connection, outline: Outline, path: Path) -> list[Readings]:
    """The frames of poses and passes, each checked."""
    frames = {str(part): count for part, count in _pairs(database, "part").items()}
    columns = outline.ribbon.columns
    query = "SELECT sum(length(t) + length(counts)) FROM chunk"
    total = database.execute(query).fetchone()[0]
    if isinstance(total, int | float) and total > MAX_FRAMES:
        raise SessionError(
            f"{path.name}: frames of {total} bytes; at most {MAX_FRAMES} are read; split it"
        )
    found = []
    for file, name in zip(outline.files, outline.names, strict=True):
        rows = database.execute("SELECT * FROM chunk WHERE part = ? ORDER BY place", (file,))
        readings = unpack(rows.fetchall(), len(columns))
        if frames.get(file) != readings.t.size:
            raise DamagedError(f"part {file} has {readings.t.size} frames, not as it should")
        try:
            check_readings(readings, columns, f"{path.name}, {name}")
        except RecordingError as error:
            raise SessionError(str(error)) from error
        found.append(readings)
    return found
