"""The tables of a session file, version 2.

A session file is an SQLite database with `application_id` "GeoR" and the
version of these tables in `user_version`.  It is a journal: rows of `event` are
only ever added, and what the session holds is what follows from all of them
(`state`); undoing is an event too.  While a program writes, the database is in
WAL mode; closed, it is one plain file.

`event`: ids 1, 2, 3, ... without a gap.  `time`: UTC as ISO 8601.  `detail`: a
JSON object.  `digest`: the SHA-256 of the UTF-8 text "id\\ntime\\naction\\ndetail".
The actions and their details are listed in `events`.

`chunk`: frames.  A *part* is what one pose, pass or stream holds, and its number
stands in the event that tells of it; its chunks follow each other by `place`
from 0.  In a chunk, `t` is `frames` little-endian float64 (seconds), `counts` is
`frames` rows of little-endian signed integers of `width` bytes (2 or 4), one for
each axis in the order of the sensors; the least integer of that width stands for
a lost value.  `digest` is the SHA-256 of the ASCII text
"part,place,frames,width;" and the two blobs.  The chunks of a pose or a pass are
written in one transaction with its event.  A stream's grow: small chunks at its
end are taken together to chunks of `chunks.FRAMES` frames.
"""

APPLICATION_ID = 0x47656F52  # "GeoR"
VERSION = 2
# As large as what file systems write at once: a page is whole or it is not there,
# and the short transactions of a stream write few bytes beside their frames.
PAGE_SIZE = 4096

TABLES = {
    "event": (
        "id INTEGER PRIMARY KEY, time TEXT NOT NULL, action TEXT NOT NULL, detail TEXT NOT NULL, "
        "digest BLOB NOT NULL"
    ),
    "chunk": (
        "part INTEGER NOT NULL, place INTEGER NOT NULL, frames INTEGER NOT NULL, "
        "width INTEGER NOT NULL, t BLOB NOT NULL, counts BLOB NOT NULL, digest BLOB NOT NULL, "
        "UNIQUE (part, place)"
    ),
}


def statements() -> dict[str, str]:
    """The statement that creates each table, by its name."""
    return {name: f'CREATE TABLE "{name}" ({columns}) STRICT' for name, columns in TABLES.items()}
