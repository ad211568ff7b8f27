"""The tables of a damaged session file of version 1, each whole by its seal or not at all."""

import re
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing

from georibbon.session import version1
from georibbon.session.chunks import DamagedError
from georibbon.session.events import Event
from georibbon.session.pages import Pages, Value, leaves

MAX_RUNS = 40  # pages on which rows of one shape are looked for in every run of neighbours
_SEAL = 32  # bytes
_COLUMN = re.compile(r'"?(\w+)"? (INTEGER|TEXT|REAL|BLOB)( PRIMARY KEY)?( NOT NULL)?')
_KINDS = {"INTEGER": (int,), "TEXT": (str,), "REAL": (int, float), "BLOB": (bytes,)}
Row = tuple[Value, ...]
Leaf = list[tuple[int, Row]]


def sealed_events(views: Iterable[Pages]) -> tuple[tuple[Event, ...], list[str]]:
    """What the tables that can be read say, as events, and what is lost, a sentence each.

    views: the file's pages, by the sizes that they may have.  No event where
    there are no seals, or what they seal makes no sense.
    """
    for pages in views:
        found = [[row for row in leaf if _small(row[1])] for leaf in leaves(pages)]
        seals = {row[0]: row[1] for row in _rows(found, version1.UNSEALED["seal"])}
        tables = {name: _sealed(found, name, seals.get(name)) for name in version1.TABLES}
        if any(tables.values()):
            lost = [
                f"the table {name} (version 1) is lost" for name in tables if tables[name] is None
            ]
            return _events({name: rows or [] for name, rows in tables.items()}), lost
    return (), []


def _small(values: Row) -> bool:
    """Whether a row may be one of the sealed tables: that of the frames is not."""
    return not any(isinstance(value, bytes) and len(value) > _SEAL for value in values)


def _events(tables: dict[str, list[Row]]) -> tuple[Event, ...]:
    """The events in tables, read as those of a file are."""
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as database:
        try:
            _refill(database, tables)
            return version1.read_events(database)
        except (DamagedError, sqlite3.Error, OverflowError):
            return ()


def _refill(database: sqlite3.Connection, tables: dict[str, list[Row]]) -> None:
    """Make the tables of version 1 with these rows, and seal them anew."""
    for statement in version1.statements().values():
        database.execute(statement)
    for name, rows in tables.items():
        for row in rows:
            marks = ", ".join("?" * len(row))
            database.execute(f'INSERT INTO "{name}" VALUES ({marks})', row)  # noqa: S608 (our names)
        seal = (name, version1.digest(version1.select(database, name)))
        database.execute("INSERT INTO seal VALUES (?, ?)", seal)


def _sealed(found: Sequence[Leaf], name: str, seal: object) -> list[Row] | None:
    """The rows of a table; None where those that are there do not match its seal."""
    for candidate in _candidates(found, version1.TABLES[name]):
        rows = sorted(candidate, key=lambda row: row[0])  # type: ignore[arg-type,return-value] # one type a column
        if version1.digest(rows) == seal:
            return rows
    return None


def _candidates(found: Sequence[Leaf], declared: str) -> Iterator[list[Row]]:
    """Rows that may be a table's: none, those of all pages, those of each run of pages."""
    yield []
    leaves_of = [rows for rows in (_rows([leaf], declared) for leaf in found) if rows]
    yield _distinct(leaves_of)
    count = len(leaves_of)
    for length in range(1, count if count <= MAX_RUNS else 2):
        for start in range(count - length + 1):
            yield _distinct(leaves_of[start : start + length])


def _distinct(pages: Iterable[list[Row]]) -> list[Row]:
    return list(dict.fromkeys(row for rows in pages for row in rows))


def _rows(found: Iterable[Leaf], declared: str) -> list[Row]:
    """The rows that have the columns that a table declares."""
    columns = _COLUMN.findall(declared)
    rows = (_fitting(key, values, columns) for leaf in found for key, values in leaf)
    return [row for row in rows if row is not None]


def _fitting(key: int, values: Row, columns: list[tuple[str, str, str, str]]) -> Row | None:
    """A row with its id in its place and numbers as declared; None where it is not of the table."""
    if len(values) != len(columns):
        return None
    row: list[Value] = []
    for value, (_, kind, primary, required) in zip(values, columns, strict=True):
        if primary and kind == "INTEGER":
            if value is not None:
                return None
            row.append(key)
        elif value is None and not required and not primary:
            row.append(None)
        elif isinstance(value, _KINDS[kind]):
            row.append(float(value) if kind == "REAL" and isinstance(value, int) else value)
        else:
            return None
    return tuple(row)
