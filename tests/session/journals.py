"""Session files of version 2 made with plain SQL, and what is in them."""

import sqlite3
from contextlib import closing

from made import RIBBON, readings

from georibbon.session.chunks import pack
from georibbon.session.events import Event
from georibbon.session.schema import APPLICATION_ID, VERSION, statements

TIME = "2026-02-03T04:05:06.789+00:00"


def event(number, action="note", **detail):
    """An event at some time."""
    return Event(number, TIME, action, detail)


def opened(path, page_size=4096, **settings):
    """A connection to a new journal in a new file."""
    database = sqlite3.connect(path, isolation_level=None, **settings)
    database.execute(f"PRAGMA page_size = {page_size}")
    database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    database.execute(f"PRAGMA user_version = {VERSION}")
    for statement in statements().values():
        database.execute(statement)
    return database


def add(database, events=(), chunks=()):
    """Put rows into a journal in one transaction."""
    database.execute("BEGIN")
    rows = [made.row for made in events]
    database.executemany("INSERT INTO event VALUES (?, ?, ?, ?, ?)", rows)
    rows = [made.row for made in chunks]
    database.executemany("INSERT INTO chunk VALUES (?, ?, ?, ?, ?, ?, ?)", rows)
    database.execute("COMMIT")


def write(path, events=(), chunks=(), page_size=4096):
    """A closed file with these rows."""
    with closing(opened(path, page_size)) as database:
        add(database, events, chunks)


def rows(carving):
    """Events and chunks that were found, as rows in their order."""
    events = [found.row for found in carving.events]
    return events, [carving.chunk(piece).row for piece in carving.pieces]


RIBBON_TABLE = {
    "id": RIBBON.id,
    "length": RIBBON.length,
    "rate": RIBBON.rate,
    "sensor": [
        {
            key: getattr(sensor, key)
            for key in ("name", "kind", "axes", "position", "counts_per_unit")
        }
        for sensor in RIBBON.sensors
    ],
}


def capture():
    """The events and chunks of a capture: poses, passes redone, undone and removed, a stream."""
    made = Capture()
    made.do("created", georibbon="2.0")
    made.do("ribbon", **RIBBON_TABLE)
    made.do("title", title="a bonnet")
    made.do("plan", poses=2, passes=4, ties=1)
    for i, roll in enumerate((0.0, 90.0)):
        angles = {"roll": roll, "heading": 0.0, "pitch": 0.0, "table": True}
        made.capture("pose", 60, key=f"pose-{i}", name=f"roll {roll:g}", **angles)
    stream = made.part(5000)
    made.do("stream", part=stream, rate=100.0)
    for name in ("P1", "P2", "P3", "P4"):
        made.capture("pass", 5000 if name == "P3" else 150, name=name, kind="pass")
    made.do("note", text="the table shook", **{"pass": "P2"})
    made.capture("pass", 130, name="P2", kind="pass")
    made.capture("pass", 40, name="T1", kind="tie")
    made.do("remove", **{"pass": "P4"})
    made.capture("pass", 10, name="P5", kind="pass")
    made.do("undo", of=made.events[-1].id)
    mark = {"pass": "P1", "at": 0.1, "position": [0.0, 0.1, 0.2], "sigma": 0.001}
    made.do("survey", mark=[mark], distance=[], crossing=[])
    made.do("order", passes=["P3", "P2", "P1", "T1"])
    made.do("setting", **{"pass": "P1", "key": "smoothing", "value": 0.5})
    made.do("link", state="stalled", reason="no packet for a second")
    made.do("closed", frames=sum(chunk.frames for chunk in made.chunks))
    return made


class Capture:
    """Events and chunks as they come."""

    def __init__(self):
        self.events, self.chunks, self.parts = [], [], {}

    def do(self, action, **detail):
        """One event more."""
        self.events.append(event(len(self.events) + 1, action, **detail))

    def part(self, frames):
        """The number of a new part of random frames."""
        number = len(self.parts) + 1
        self.parts[number] = readings(frames, seed=number)
        self.chunks += pack(self.parts[number], number)
        return number

    def capture(self, action, frames, **detail):
        """A pose or a pass."""
        self.do(action, **detail, part=self.part(frames), frames=frames)
