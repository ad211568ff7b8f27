"""The session file of version 1, which is read for ever and written no more.

Lengths in metres, angles in
degrees, times of day in UTC as ISO 8601.

Frames are kept in chunks: a *part* is what one CSV file of a recording holds,
its chunks follow each other by `place` from 0.  In a chunk, `t` is `frames`
little-endian float64, `counts` is `frames` rows of little-endian signed
integers of `width` bytes (2 or 4), one for each axis in the order of the
sensors; the least integer of that width stands for a lost value.  `digest` is
the SHA-256 of the ASCII text "part,place,frames,width;" and the two blobs.

`seal` holds for every other table the SHA-256 of its rows in the order of
their first column, each row a JSON array and the rows parted by newlines:
nothing that the file system or a program has damaged is taken for data.
Chunks and their digests are those of version 2.
"""

import hashlib
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence

from georibbon.session.chunks import DamagedError
from georibbon.session.database import check_tables
from georibbon.session.events import Event, Row, decode_detail, event_of

VERSION = 1
MAX_ROWS = 1_000_000
Spoken = tuple[str, str, Mapping[str, object]]

TABLES = {
    # title (where there is one), created, georibbon: the version that made the file
    "meta": "key TEXT PRIMARY KEY, value TEXT NOT NULL",
    # one row: the ribbon
    "ribbon": "one INTEGER PRIMARY KEY, id TEXT NOT NULL, length REAL NOT NULL, rate REAL NOT NULL",
    # its sensors, in the order of the columns
    "sensor": (
        "place INTEGER PRIMARY KEY, name TEXT NOT NULL, kind TEXT NOT NULL, axes INTEGER NOT NULL, "
        "position REAL NOT NULL, counts_per_unit REAL NOT NULL"
    ),
    # no row or one: the frame of the marks
    "workpiece": "one INTEGER PRIMARY KEY, level INTEGER NOT NULL, heading REAL",
    "part": "id INTEGER PRIMARY KEY, frames INTEGER NOT NULL",
    "pose": (
        "place INTEGER PRIMARY KEY, name TEXT NOT NULL, roll REAL NOT NULL, heading REAL NOT NULL, "
        "pitch REAL NOT NULL, on_table INTEGER NOT NULL, part INTEGER NOT NULL"
    ),
    "pass": (
        "place INTEGER PRIMARY KEY, name TEXT NOT NULL, kind TEXT NOT NULL, part INTEGER NOT NULL"
    ),
    # the survey, passes by their names
    "mark": (
        "place INTEGER PRIMARY KEY, pass TEXT NOT NULL, at REAL NOT NULL, x REAL NOT NULL, "
        "y REAL NOT NULL, z REAL NOT NULL, sigma REAL NOT NULL"
    ),
    "distance": (
        "place INTEGER PRIMARY KEY, pass1 TEXT NOT NULL, pass2 TEXT NOT NULL, at1 REAL NOT NULL, "
        "at2 REAL NOT NULL, distance REAL NOT NULL, sigma REAL NOT NULL"
    ),
    "crossing": (
        "place INTEGER PRIMARY KEY, pass1 TEXT NOT NULL, pass2 TEXT NOT NULL, at1 REAL NOT NULL, "
        "at2 REAL NOT NULL, sigma REAL NOT NULL"
    ),
    # settings of single passes, by name; value: JSON
    "setting": (
        "id INTEGER PRIMARY KEY, pass TEXT NOT NULL, key TEXT NOT NULL, value TEXT NOT NULL"
    ),
    # the operator's notes
    "note": "id INTEGER PRIMARY KEY, time TEXT NOT NULL, text TEXT NOT NULL",
    # what was done; detail: JSON
    "history": (
        "id INTEGER PRIMARY KEY, time TEXT NOT NULL, action TEXT NOT NULL, detail TEXT NOT NULL"
    ),
    # calibrations used; document: JSON as in a calibration file
    "calibration": "id INTEGER PRIMARY KEY, time TEXT NOT NULL, document TEXT NOT NULL",
}
UNSEALED = {
    "chunk": (
        "part INTEGER NOT NULL, place INTEGER NOT NULL, frames INTEGER NOT NULL, "
        "width INTEGER NOT NULL, t BLOB NOT NULL, counts BLOB NOT NULL, digest BLOB NOT NULL, "
        "UNIQUE (part, place)"
    ),
    "seal": "name TEXT PRIMARY KEY, digest BLOB NOT NULL",
}


def statements() -> dict[str, str]:
    """The statement that creates each table, by its name."""
    columns = TABLES | UNSEALED
    return {name: f'CREATE TABLE "{name}" ({columns[name]}) STRICT' for name in columns}


def read_events(database: sqlite3.Connection) -> tuple[Event, ...]:
    """What a session of version 1 holds, as events; its parts keep their numbers.

    Raises DamagedError where a table is not as it was written; whether the
    values can be meant is for `state.fold` to find.
    """
    check_tables(database, statements(), VERSION)
    seals = _pairs(database, "seal")
    for name in TABLES:
        if seals.get(name) != digest(select(database, name)):
            raise DamagedError(f"the table {name} does not match its seal")
    rows = (
        Event(number, time, action, detail).row
        for number, (action, time, detail) in enumerate(_spoken(database), start=1)
    )
    return tuple(event_of(row) for row in rows)


def _spoken(database: sqlite3.Connection) -> Iterator[Spoken]:
    """All that the tables say: action, time, detail."""
    meta = _pairs(database, "meta")
    made = str(meta.get("created"))
    yield "created", made, {"georibbon": meta.get("georibbon")}
    if "title" in meta:
        yield "title", made, {"title": meta["title"]}
    for action, detail in _outline(database):
        yield action, made, detail
    yield from _additions(database, made)
    frames = [count for count in _parts(database).values() if isinstance(count, int)]
    yield "closed", made, {"frames": sum(frames)}


def select(database: sqlite3.Connection, table: str) -> list[Row]:
    """All rows of a small table in the order of its first column."""
    query = f'SELECT * FROM "{table}" ORDER BY 1'  # noqa: S608 (the names are ours)
    rows = database.execute(query).fetchmany(MAX_ROWS + 1)
    if len(rows) > MAX_ROWS:
        raise DamagedError(f"the table {table} has more than {MAX_ROWS} rows")
    return rows


def digest(rows: Sequence[Row]) -> bytes:
    """The seal of a table's rows."""
    try:
        text = "\n".join(json.dumps(row) for row in rows)
    except TypeError as error:
        raise DamagedError("a row holds bytes where none belong") from error
    return hashlib.sha256(text.encode()).digest()


def _outline(database: sqlite3.Connection) -> Iterator[tuple[str, dict[str, object]]]:
    """Ribbon, workpiece, poses, passes and survey as actions and details."""
    sensor = ("name", "kind", "axes", "position", "counts_per_unit")
    for _, name, length, rate in select(database, "ribbon"):
        sensors = _named(select(database, "sensor"), sensor)
        yield "ribbon", {"id": name, "length": length, "rate": rate, "sensor": sensors}
    for _, level, heading in select(database, "workpiece"):
        known = {} if heading is None else {"heading": heading}
        yield "workpiece", {"level": _flag(level)} | known
    frames = _parts(database)
    pose = ("name", "roll", "heading", "pitch", "table", "part")
    for i, row in enumerate(_named(select(database, "pose"), pose), start=1):
        detail = row | {"table": _flag(row["table"]), "frames": frames.get(row["part"])}
        yield "pose", {"key": f"pose-{i:02}"} | detail
    for row in _named(select(database, "pass"), ("name", "kind", "part")):
        yield "pass", row | {"frames": frames.get(row["part"])}
    survey = _survey(database)
    if any(survey.values()):
        yield "survey", survey


def _survey(database: sqlite3.Connection) -> dict[str, object]:
    return {
        "mark": [
            {"pass": name, "at": at, "position": [x, y, z], "sigma": sigma}
            for _, name, at, x, y, z, sigma in select(database, "mark")
        ],
        "distance": [
            {"passes": [p, q], "at": [a, b], "distance": distance, "sigma": sigma}
            for _, p, q, a, b, distance, sigma in select(database, "distance")
        ],
        "crossing": [
            {"passes": [p, q], "at": [a, b], "sigma": sigma}
            for _, p, q, a, b, sigma in select(database, "crossing")
        ],
    }


def _additions(database: sqlite3.Connection, made: str) -> Iterator[Spoken]:
    """Settings, calibrations and notes."""
    for _, name, key, value in select(database, "setting"):
        yield "setting", made, {"pass": name, "key": key} | _json("value", value)
    for _, time, document in select(database, "calibration"):
        yield "calibration", str(time), _json("document", document)
    for _, time, text in select(database, "note"):
        yield "note", str(time), {"text": text}


def _json(key: str, text: object) -> dict[str, object]:
    """A text of JSON as the one value of a table."""
    return dict(decode_detail(f'{{"{key}":{text}}}'))


def _parts(database: sqlite3.Connection) -> dict[object, object]:
    """The number of frames in each part."""
    return _pairs(database, "part")


def _pairs(database: sqlite3.Connection, table: str) -> dict[object, object]:
    """The rows of a table of two columns."""
    return {row[0]: row[1] for row in select(database, table)}


def _named(rows: Sequence[Row], names: tuple[str, ...]) -> list[dict[str, object]]:
    """Rows as tables, without their first column."""
    return [dict(zip(names, row[1:], strict=True)) for row in rows]


def _flag(value: object) -> object:
    return bool(value) if value in (0, 1) else value
