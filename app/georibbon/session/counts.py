"""The CSV files of a recording: raw counts in text, read fast and checked wholly.

A clean file goes through one pass of C code; only a file with signs, spaces or
faults is looked at field by field, which also finds the line and the column
that a message names.
"""

import re

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import RecordingError
from georibbon.ribbon import Readings
from georibbon.session.fields import MAX_NUMBER
from georibbon.session.words import nearest, told

MAX_COUNT = 2**31 - 1
_COUNT = re.compile(rb"[ \t]*[+-]?[0-9]{1,30}[ \t]*")
_TIME = re.compile(
    rb"[ \t]*[+-]?([0-9]{1,30}\.?[0-9]{0,60}|\.[0-9]{1,60})([eE][+-]?[0-9]{1,3})?[ \t]*"
)
_PLAIN = b"0123456789,-"
_LOST = b",-9999999999,"  # beyond the range of counts, so that it can stand for an empty field
_SHOWN = 5  # missing columns named in a message
_BLOCK = 4096  # rows written at a time, for the sake of memory


def parse_csv(data: bytes, columns: tuple[str, ...], name: str) -> Readings:
    """The frames in the bytes of a CSV file.

    columns: the names of all axes; name: the file's, for messages.  A byte
    order mark, CRLF line ends, spaces around numbers and a leading plus are
    tolerated.  An empty field of an axis is a lost value (NaN).  Raises
    RecordingError, with the line and the column, for anything else.
    """
    lines = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").rstrip(b"\n").split(b"\n")
    _check_header(lines[0], columns, name)
    rows = lines[1:]
    if not rows:
        raise RecordingError(f"{name}: the file has a header and no frame; record it again")
    t, counts = _parse_fast(rows, len(columns)) or _parse_slow(rows, columns, name)
    readings = Readings(t, counts)
    _check_range(readings, columns, f"{name}, line", 2)
    return readings


def format_csv(readings: Readings, columns: tuple[str, ...]) -> bytes:
    """The bytes of a CSV file that `parse_csv` reads back exactly (shortest digits of t)."""
    lines = [",".join(("t", *columns))]
    for start in range(0, readings.t.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        lost = np.isnan(readings.counts[block])
        fields = np.where(lost, 0.0, readings.counts[block]).astype(np.int64).astype(str)
        fields[lost] = ""
        times = map(repr, readings.t[block].tolist())
        rows = zip(times, fields.tolist(), strict=True)
        lines += [",".join((time, *row)) for time, row in rows]
    return ("\n".join(lines) + "\n").encode()


def check_readings(readings: Readings, columns: tuple[str, ...], name: str) -> None:
    """Refuse readings that a recording cannot hold: RecordingError names what is wrong."""
    t, counts = readings.t, readings.counts
    if t.ndim != 1 or counts.shape != (t.size, len(columns)):
        raise RecordingError(
            f"{name}: the readings have shapes {t.shape} and {counts.shape}; "
            f"(m,) times and (m, {len(columns)}) counts are expected"
        )
    if not t.size:
        raise RecordingError(f"{name}: no frame was recorded; record it again")
    kept = np.where(np.isnan(counts), 0.0, counts)
    bad = np.argwhere(kept != np.rint(kept))
    if bad.size:
        row, column = bad[0]
        raise RecordingError(
            f"{name}: frame {row + 1}, column {columns[column]}: {counts[row, column]} "
            "is no whole number; raw counts are expected"
        )
    _check_range(readings, columns, f"{name}, frame", 1)


def _check_header(line: bytes, columns: tuple[str, ...], name: str) -> None:
    expected = ("t", *columns)
    if line == ",".join(expected).encode():
        return
    if not line.strip():
        raise RecordingError(
            f"{name}: the file is empty or its first line is; a header is expected"
        )
    try:
        found = tuple(field.strip(" \t") for field in line.decode().split(","))
    except UnicodeDecodeError as error:
        raise RecordingError(
            f"{name}, line 1: the header is not UTF-8; save the file as UTF-8"
        ) from error
    if found == expected:
        return
    raise RecordingError(f"{name}, line 1: {_header_fault(found, expected)}")


def _header_fault(found: tuple[str, ...], expected: tuple[str, ...]) -> str:
    if len(found) == 1 and found[0].count(";") + found[0].count("\t") > 1:
        return (
            "the fields are not separated by commas; save the file with commas between the fields"
        )
    if found[0] != "t":
        return f'the first column is {told(found[0])}; "t" (seconds) is expected'
    count = f"the ribbon has {len(expected) - 1} columns after t, this file {len(found) - 1}"
    present, wanted = set(found), set(expected)
    missing = [column for column in expected if column not in present]
    unknown = [column for column in found if column not in wanted]
    if missing:
        hint = f", and {told(unknown[0])} is not one of its columns" if unknown else ""
        return f"{_columns(missing)} missing{hint} ({count}); export the file with every sensor"
    if unknown:
        hint = nearest(unknown[0], expected)
        return f"the column {told(unknown[0])} is not one of the ribbon's ({count}){hint}"
    if len(found) > len(present):
        twice = next(column for column in expected if found.count(column) > 1)
        return f"the column {told(twice)} is there twice ({count}); keep it once"
    i = next(i for i, pair in enumerate(zip(found, expected, strict=True)) if pair[0] != pair[1])
    return (
        f"column {i + 1} is {found[i]} where {expected[i]} is expected; "
        "put the columns in the order of the sensors in recording.toml"
    )


def _columns(names: list[str]) -> str:
    shown = ", ".join(told(name)[1:-1] for name in names[:_SHOWN])
    if len(names) == 1:
        return f"the column {shown} is"
    return f"the columns {shown}{' and others' if len(names) > _SHOWN else ''} are"


def _parse_fast(rows: list[bytes], width: int) -> tuple[FloatArray, FloatArray] | None:
    """Times and counts where every field is plain: -?[0-9]+ or nothing; else None."""
    pairs = [row.partition(b",") for row in rows]
    values = b"," + b",".join([pair[2] for pair in pairs]) + b","
    if (
        values.translate(None, _PLAIN)
        or values.count(b"-") != values.count(b",-")
        or b"-," in values
        or _LOST[2:-1] in values
        or any(pair[2].count(b",") != width - 1 for pair in pairs)
        or not all(_TIME.fullmatch(pair[0]) for pair in pairs)
    ):
        return None
    if b",," in values:
        values = values.replace(b",,", _LOST).replace(b",,", _LOST)
    whole = np.fromstring(values[1:-1], np.int64, sep=",").reshape(len(rows), width)
    counts = np.where(whole == int(_LOST[1:-1]), np.nan, whole)
    return np.array([float(pair[0]) for pair in pairs]), counts


def _parse_slow(
    rows: list[bytes], columns: tuple[str, ...], name: str
) -> tuple[FloatArray, FloatArray]:
    """The same, field by field; RecordingError names the first that is wrong."""
    t = np.empty(len(rows))
    counts = np.empty((len(rows), len(columns)))
    for i, row in enumerate(rows):
        time, *fields = row.split(b",")
        line = f"{name}, line {i + 2}"
        if len(fields) != len(columns):
            raise RecordingError(
                f"{line}: {len(fields) + 1} instead of {len(columns) + 1} fields; the line is "
                "damaged or cut off"
            )
        if not _TIME.fullmatch(time):
            raise RecordingError(f"{line}, column t: {_told(time)} is no number of seconds")
        t[i] = float(time)
        counts[i] = [_count(field, line, columns[j]) for j, field in enumerate(fields)]
    return t, counts


def _count(field: bytes, line: str, column: str) -> float:
    if _COUNT.fullmatch(field):
        return int(field) + 0.0
    if not field.strip(b" \t"):
        return np.nan
    raise RecordingError(
        f"{line}, column {column}: {_told(field)} is no whole number; "
        "raw counts are expected, or nothing where the value was lost"
    )


def _told(field: bytes) -> str:
    return told(field.decode(errors="replace"))


def _check_range(readings: Readings, columns: tuple[str, ...], rows: str, first: int) -> None:
    """Refuse times and counts out of range; rows, first: what a row is called, and its number."""
    t, counts = readings.t, readings.counts
    standing = np.concatenate([[False], t[1:] <= t[:-1]])
    bad_time = np.flatnonzero(~(np.abs(t) <= MAX_NUMBER) | standing)
    if bad_time.size:
        i = int(bad_time[0])
        before = f", the one before {float(t[i - 1])!r}" if i else ""
        raise RecordingError(
            f"{rows} {i + first}, column t: {float(t[i])!r}{before}; "
            f"seconds up to {MAX_NUMBER:g} that grow from frame to frame are expected"
        )
    bad = np.argwhere(np.abs(counts) > MAX_COUNT)
    if bad.size:
        row, column = bad[0]
        raise RecordingError(
            f"{rows} {row + first}, column {columns[column]}: {counts[row, column]:.0f} is out "
            f"of range; counts between {-MAX_COUNT} and {MAX_COUNT} are expected"
        )
