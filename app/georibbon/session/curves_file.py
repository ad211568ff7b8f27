"""Curves out of a CSV file: those that Georibbon writes, or of any other origin.

One row a point, under a header line with the columns' names in any order:

    pass          the curve's name; rows of a curve follow each other
    x, y, z       the point
    s             the arc length, ascending
    nx, ny, nz    the normal, of any length
    sigma         the standard deviation of the point
    kind          "pass" (or nothing) or "tie"

Only x, y and z must be there.  A curve may leave out s, its normals or its
sigma, in all of its rows.  Without a column `pass`, blank lines part the
curves, which are then called C1, C2 and so on.  Fields are parted by commas,
semicolons or tabs; after semicolons and tabs a number may have a decimal comma.
The tangents tx, ty, tz that Georibbon writes follow from the points and are not
read; of other columns a notice tells.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import cast

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.errors import CurvesError
from georibbon.notices import Notice
from georibbon.recording import PassKind
from georibbon.session.fields import MAX_NAME, Source
from georibbon.session.files import read_bounded
from georibbon.session.mesh_file import METRES
from georibbon.session.words import told

MAX_BYTES = 200_000_000
MAX_POINTS = 1_000_000
MAX_CURVES = 10_000
MAX_COLUMNS = 1000
MAX_LINE = 1_000_000  # characters
FARTHEST = 1e5  # m
GREATEST = 1e9  # of a normal's parts
SEPARATORS = (",", ";", "\t")
POINT, NORMAL = ("x", "y", "z"), ("nx", "ny", "nz")
READ = ("pass", "s", *POINT, *NORMAL, "sigma", "kind")
FOLLOWING = ("tx", "ty", "tz")
KINDS = ("pass", "tie")
_NUMBER = re.compile(r"[+-]?([0-9]{1,60}\.?[0-9]{0,60}|\.[0-9]{1,60})([eE][+-]?[0-9]{1,3})?")
_SHOWN = 5  # columns named in a notice

Rows = list[tuple[int, list[str]]]  # the number of the line, and its fields


@dataclass(frozen=True, eq=False)
class BareCurve:
    """A curve as a file has it, in metres; what it has not is None.

    s: (n,), its arc length.  points: (n, 3).  normals: (n, 3), of any length.
    sigma: (n,), the standard deviation of its points.
    """

    name: str
    kind: PassKind
    s: FloatArray | None
    points: FloatArray
    normals: FloatArray | None
    sigma: FloatArray | None


@dataclass(frozen=True, eq=False)
class CurvesFile:
    """What a file of curves holds, and what of it was not read."""

    curves: tuple[BareCurve, ...]
    notices: tuple[Notice, ...]


def read_curves(path: Path, unit: str = "m") -> CurvesFile:
    """The curves in a CSV file, in its order.

    unit: one of `METRES`, of its lengths.  Raises CurvesError, with the line,
    for what is no such file, is too large, or holds no curve.
    """
    source = Source(str(path), CurvesError)
    data = read_bounded(path, MAX_BYTES, str(path), CurvesError)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise CurvesError(
            f"{path}, line {line}: this is not UTF-8 text; save the file as CSV, UTF-8"
        ) from error
    separator, columns, rows = _table(text, source)
    groups = list(_groups(columns, rows, source))
    if not groups:
        source.refuse("the file has no point below its header; write the curves anew")
    decimal_comma = separator != ","
    curves = tuple(
        _curve(name, one, columns, decimal_comma, METRES[unit], source) for name, one in groups
    )
    return CurvesFile(curves, _notices(columns))


def _table(
    text: str, source: Source
) -> tuple[str, dict[str, int], Iterator[tuple[int, list[str]]]]:
    """The separator, where each column stands, and the lines below the header."""
    first, _, _ = text.lstrip("\r\n").partition("\n")
    separator = max(SEPARATORS, key=first.count)
    lines = _lines(text, separator, source)
    number, header = next(((at, one) for at, one in lines if one), (1, []))
    names = [name.strip().lower() for name in header]
    missing = [name for name in POINT if name not in names]
    if missing:
        source.refuse(
            f"line {number} has no column {', '.join(missing)}; a header line with at least "
            "x, y, z is expected, parted by commas, semicolons or tabs"
        )
    twice = next((name for name in READ if names.count(name) > 1), None)
    if twice:
        source.refuse(f"line {number} has the column {twice} twice; leave one of them out")
    some = [name for name in NORMAL if name in names]
    if some and len(some) < len(NORMAL):
        source.refuse(
            f"line {number} has {', '.join(some)} alone; a normal has nx, ny and nz: add the "
            "others or leave it out"
        )
    return separator, {name: k for k, name in reversed(list(enumerate(names)))}, lines


def _lines(text: str, separator: str, source: Source) -> Iterator[tuple[int, list[str]]]:
    """Each line with its number; its fields are none where it is blank."""
    reader = csv.reader(_bounded(text, source), delimiter=separator, strict=True)
    width: int | None = None  # of the first line that is not blank, the header
    while True:
        number = reader.line_num + 1
        try:
            fields = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            source.refuse(f"line {number} cannot be read ({error}); write the file anew")
        if len(fields) > MAX_COLUMNS:
            source.refuse(
                f"line {number} has {len(fields)} columns, at most {MAX_COLUMNS} are read; write "
                "the file anew"
            )
        if not any(field.strip() for field in fields):
            fields = []
        elif width is None:
            width = len(fields)
        elif any(field.strip() for field in fields[width:]):
            source.refuse(
                f"line {number} has {len(fields)} fields under a header of {width}; decimal commas "
                "need semicolons or tabs between the fields"
            )
        yield number, fields


def _bounded(text: str, source: Source) -> Iterator[str]:
    """The text line by line; a longer one would fill the memory with its fields."""
    for number, line in enumerate(StringIO(text, newline=""), 1):
        if len(line) > MAX_LINE:
            source.refuse(
                f"line {number} has {len(line)} characters, at most {MAX_LINE} are read; write the "
                "file anew"
            )
        yield line


def _groups(
    columns: Mapping[str, int], lines: Iterable[tuple[int, list[str]]], source: Source
) -> Iterator[tuple[str, Rows]]:
    """Each curve's name and lines."""
    seen: set[str] = set()
    width, points = 1 + max(columns[one] for one in READ if one in columns), 0
    name: str | None = None
    rows: Rows = []
    for number, fields in lines:
        if not fields:
            if "pass" not in columns and name is not None:
                yield name, rows
                name, rows = None, []
            continue
        if len(fields) < width:
            source.refuse(f"line {number} has {len(fields)} fields of {width}; write the file anew")
        points += 1
        if points > MAX_POINTS:
            source.refuse(f"it has more than {MAX_POINTS} points; thin it out or split it")
        found = _name(fields, columns, len(seen) + (name is None), number, source)
        if found != name:
            if name is not None:
                yield name, rows
            if found in seen:
                source.refuse(
                    f"line {number}: {told(found)} begins again; bring the points of a curve "
                    "together, or give each curve its own name"
                )
            if len(seen) == MAX_CURVES:
                source.refuse(f"it has more than {MAX_CURVES} curves; split it")
            seen.add(found)
            name, rows = found, []
        rows.append((number, fields))
    if name is not None:
        yield name, rows


def _name(
    fields: Sequence[str], columns: Mapping[str, int], number: int, line: int, source: Source
) -> str:
    """The name of the curve that a line belongs to; number: of the curve, from 1."""
    if "pass" not in columns:
        return f"C{number}"
    name = fields[columns["pass"]]
    if not name.strip() or not name.isprintable() or len(name) > MAX_NAME:
        source.refuse(
            f"line {line}: the curve is called {told(name)}; a name of 1 to {MAX_NAME} printable "
            "characters is expected"
        )
    return name


def _curve(
    name: str,
    rows: Rows,
    columns: Mapping[str, int],
    decimal_comma: bool,
    metres: float,
    source: Source,
) -> BareCurve:
    def read(column: str, limit: float) -> FloatArray:
        place = columns[column]
        fields = [(number, one[place]) for number, one in rows]
        return _numbers(fields, column, limit, decimal_comma, source)

    def group(wanted: Sequence[str], limit: float) -> FloatArray | None:
        if wanted[0] not in columns or not _given(name, rows, [columns[c] for c in wanted], source):
            return None
        return np.stack([read(column, limit) for column in wanted], axis=1)

    far = FARTHEST / metres
    s, sigma = group(["s"], far), group(["sigma"], far)
    points = np.stack([read(column, far) for column in POINT], axis=1)
    if sigma is not None and (sigma < 0.0).any():
        source.refuse(f"{told(name)}: a sigma is below 0; a standard deviation is expected")
    return BareCurve(
        name,
        _kind(name, rows, columns, source),
        None if s is None else metres * s[:, 0],
        metres * points,
        group(NORMAL, GREATEST),
        None if sigma is None else metres * sigma[:, 0],
    )


def _given(name: str, rows: Rows, places: Sequence[int], source: Source) -> bool:
    """Whether a curve has these columns, in all of its rows; not in some of them."""
    empty = [at for at, fields in rows if not any(fields[k].strip() for k in places)]
    if empty and len(empty) < len(rows):
        source.refuse(
            f"line {empty[0]} leaves out what other points of {told(name)} have; fill it in, or "
            "leave it out for the whole curve"
        )
    return not empty


def _numbers(
    fields: list[tuple[int, str]], column: str, limit: float, decimal_comma: bool, source: Source
) -> FloatArray:
    """(n,) the numbers in fields, each with the number of its line."""
    texts = [field.strip() for _, field in fields]
    if decimal_comma:
        texts = [text if "." in text else text.replace(",", ".", 1) for text in texts]
    for (line, field), text in zip(fields, texts, strict=True):
        if not _NUMBER.fullmatch(text):
            source.refuse(f"line {line}, {column}: {told(field)} is found, a number is expected")
    values = np.array(texts, dtype=np.float64)
    wild = np.flatnonzero(~(np.abs(values) <= limit))
    if wild.size:
        line, field = fields[wild[0]]
        source.refuse(
            f"line {line}, {column}: {told(field)} is out of all bounds; is it in another unit?"
        )
    return values


def _kind(name: str, rows: Rows, columns: Mapping[str, int], source: Source) -> PassKind:
    if "kind" not in columns:
        return "pass"
    place = columns["kind"]
    kind = rows[0][1][place].strip().lower() or "pass"
    if kind not in KINDS:
        source.refuse(
            f"line {rows[0][0]}: {told(name)} is of the kind {told(kind)}; pass or tie is expected"
        )
    other = next((at for at, one in rows if (one[place].strip().lower() or "pass") != kind), None)
    if other:
        source.refuse(f"line {other}: {told(name)} changes its kind; a curve is a pass or a tie")
    return cast("PassKind", kind)


def _notices(columns: Iterable[str]) -> tuple[Notice, ...]:
    """A notice where there are columns that nobody reads."""
    others = sorted(name for name in columns if name not in (*READ, *FOLLOWING) and name)
    if not others:
        return ()
    names = ", ".join(told(name) for name in others[:_SHOWN])
    more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
    message = f"the columns {names}{more} of the file are not known here and were not read"
    return (Notice("columns-ignored", message),)
