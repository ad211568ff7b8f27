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
nothing that the file system or a program has damaged is taken for data.  Who
changes a table renews its seal in the same transaction.
"""

VERSION = 1

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
