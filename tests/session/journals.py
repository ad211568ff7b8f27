"""Session files of version 2 made with plain SQL, and what is in them."""

import sqlite3
from contextlib import closing

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
