"""The pages of an SQLite database and of the log beside it, read without SQLite.

What is read here may be damaged or hostile in any byte: nothing is believed
but what fits, nothing is followed without a bound, nothing is changed.  The
layout is that of "Database File Format", sections 1 and 4
(https://www.sqlite.org/fileformat2.html).
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from io import BufferedReader
from pathlib import Path

SIZES = (4096, 512, 1024, 2048, 8192, 16384, 32768, 65536)
Value = int | float | str | bytes | None

_LEAF = 0x0D
_FILE_HEADER = 100
_LOG_HEADER = 32
_FRAME_HEADER = 24
_SAMPLE = 100
_SPARE = 2**20
_WIDTHS = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 6: 8}


@dataclass(frozen=True)
class Place:
    """A byte in the database or in its log; frame: the log's frame, from 0, or None."""

    page: int
    offset: int
    frame: int | None


class Pages:
    """The pages of a database of `size` bytes a page as its log leaves them.

    database, log: the open files; a log that is none counts as empty.  Of the
    log count the frames that bear its salts, up to the last that ends a
    transaction: what comes after was never promised, or is of the time before.
    A damaged frame does not end the log here as it does in SQLite.
    """

    def __init__(self, database: BufferedReader, log: BufferedReader | None, size: int) -> None:
        self._database, self._log = database, log
        self.size = size
        self.count = -(-length_of(database) // size)

    @cached_property
    def _numbers(self) -> dict[int, int]:
        """The log's frames that count, in their order, with the numbers of their pages."""
        return {} if self._log is None else _committed(self._log, self.size)

    @cached_property
    def _newest(self) -> dict[int, int]:
        """The last frame of each page in the log."""
        return {number: frame for frame, number in self._numbers.items()}

    def page(self, number: int, newest: bool = True) -> bytes:
        """A page by its number, from 1; nothing where there is none, short where it is cut off.

        newest: as the log has it, where the log has it.
        """
        frame = self._newest.get(number) if newest else None
        if frame is not None and self._log is not None:
            return read_at(self._log, self._start(frame), self.size)
        if not 1 <= number <= self.count:
            return b""
        return read_at(self._database, (number - 1) * self.size, self.size)

    def frame(self, frame: int) -> bytes:
        """The page in a frame of the log."""
        return b"" if self._log is None else read_at(self._log, self._start(frame), self.size)

    def place(self, offset: int, in_log: bool) -> Place | None:
        """Where a byte of a file is; None outside the pages that count."""
        if not in_log:
            return Place(offset // self.size + 1, offset % self.size, None)
        frame, rest = divmod(offset - _LOG_HEADER, _FRAME_HEADER + self.size)
        if frame not in self._numbers or rest < _FRAME_HEADER:
            return None
        return Place(self._numbers[frame], rest - _FRAME_HEADER, frame)

    def payload(self, place: Place, length: int, newest: bool = True) -> bytes | None:
        """The `length` bytes of a table's cell from a place on, through its overflow pages.

        None where they are not there.  The chain takes as many pages as the
        length asks for, whatever it leads to.
        """
        page = self.page(place.page, newest) if place.frame is None else self.frame(place.frame)
        local = _local(length, self.size)
        end = place.offset + local
        if end + (4 if local < length else 0) > len(page):
            return None
        parts, rest = [page[place.offset : end]], length - local
        following = int.from_bytes(page[end : end + 4])
        while rest > 0:
            page = self.page(following, newest)
            if len(page) < 4 + min(rest, self.size - 4):
                return None
            parts.append(page[4 : 4 + min(rest, self.size - 4)])
            rest -= len(parts[-1])
            following = int.from_bytes(page[:4])
        return b"".join(parts)

    def _start(self, frame: int) -> int:
        return _LOG_HEADER + frame * (_FRAME_HEADER + self.size) + _FRAME_HEADER


def likely_sizes(database: BufferedReader) -> list[int]:
    """All sizes that a page may have, what the header says first."""
    said = int.from_bytes(read_at(database, 16, 2))
    return sorted(SIZES, key=lambda size: size != (65536 if said == 1 else said))


def has_header(path: Path) -> bool:
    """Whether a log begins as one: without that, nothing of it is read by SQLite."""
    try:
        with path.open("rb") as log:
            return bool(_log_header(log))
    except OSError:
        return False


def log_size(log: BufferedReader) -> int:
    """The size of the pages in a log: what its header says, where the header is undamaged.

    Else the one with which most frames bear the salts of the first.
    """
    if _log_header(log):
        return int.from_bytes(read_at(log, 8, 4))
    return max(SIZES, key=lambda size: _alike(log, size))


def _alike(log: BufferedReader, size: int) -> int:
    """How many of the first frames bear the same salts, were pages of this size."""
    places = range(_LOG_HEADER + 8, length_of(log), _FRAME_HEADER + size)[:_SAMPLE]
    salts = [read_at(log, place, 8) for place in places]
    return salts.count(salts[0]) if salts else 0


def _log_header(log: BufferedReader) -> bytes:
    """The header of a log; nothing where it does not match its checksum (section 4.2)."""
    header = read_at(log, 0, _LOG_HEADER)
    if len(header) < _LOG_HEADER or header[:3] != b"\x37\x7f\x06":
        return b""
    words = struct.unpack(">6I" if header[3] & 1 else "<6I", header[:24])
    first = second = 0
    for one, other in zip(words[::2], words[1::2], strict=True):
        first = (first + one + second) % 2**32
        second = (second + other + first) % 2**32
    fine = (first, second) == struct.unpack(">2I", header[24:])
    return header if fine and int.from_bytes(header[8:12]) in SIZES else b""


def leaves(pages: Pages) -> Iterator[list[tuple[int, tuple[Value, ...]]]]:
    """For each page that is a leaf of a table: its rows that can be read, with their ids.

    It ends early where all rows together are far longer than the file: then
    they share what only one of them can hold.
    """
    budget = 2 * pages.count * pages.size + _SPARE
    for number in range(1, pages.count + 1):
        page = pages.page(number)
        start = _FILE_HEADER if number == 1 else 0
        if page[start : start + 1] == bytes([_LEAF]):
            cells = int.from_bytes(page[start + 3 : start + 5])
            pointers = page[start + 8 : start + 8 + 2 * cells]
            whole = pointers[: len(pointers) // 2 * 2]
            offsets = {offset for (offset,) in struct.iter_unpack(">H", whole)}
            rows = []
            for offset in sorted(offsets):
                row, length = _row(pages, number, page, offset)
                rows += [] if row is None else [row]
                budget -= length
                if budget < 0:
                    return
            yield rows


def varint(data: bytes, offset: int) -> tuple[int, int] | None:
    """A variable-length integer, unsigned, and where it ends; None where it is cut off."""
    value = 0
    for i in range(offset, min(offset + 9, len(data))):
        if i == offset + 8:
            return value << 8 | data[i], i + 1
        value = value << 7 | data[i] & 0x7F
        if data[i] < 0x80:
            return value, i + 1
    return None


def body_length(kind: int) -> int | None:
    """The bytes of a value of this serial type; None for the types that are reserved."""
    if kind >= 12:
        return (kind - 12) // 2
    return 8 if kind == 7 else 0 if kind in (0, 8, 9) else _WIDTHS.get(kind)


def decode(record: bytes) -> tuple[Value, ...] | None:
    """The values of a record; None where it is none."""
    head = varint(record, 0)
    if head is None or not head[1] <= head[0] <= len(record):
        return None
    end, at = head
    values: list[Value] = []
    body = end
    while at < end:
        found = varint(record, at)
        length = None if found is None else body_length(found[0])
        if found is None or length is None or body + length > len(record):
            return None
        kind, at = found
        try:
            values.append(_value(kind, record[body : body + length]))
        except UnicodeDecodeError:
            return None
        body += length
    return tuple(values) if at == end and body == len(record) else None


def _value(kind: int, data: bytes) -> Value:
    if kind == 0:
        return None
    if kind == 7:
        return float(struct.unpack(">d", data)[0])
    if kind < 12:
        return kind - 8 if kind >= 8 else int.from_bytes(data, signed=True)
    return data.decode() if kind % 2 else data


def _row(
    pages: Pages, number: int, page: bytes, offset: int
) -> tuple[tuple[int, tuple[Value, ...]] | None, int]:
    """The id and the values of a cell, and how many bytes were gone through for it."""
    length = varint(page, offset)
    key = length and varint(page, length[1])
    if not length or not key or length[0] > pages.count * pages.size:
        return None, 0
    record = pages.payload(Place(number, key[1], None), length[0])
    values = None if record is None else decode(record)
    return (None if values is None else (key[0], values)), length[0]


def _local(length: int, usable: int) -> int:
    """How many bytes of a payload are in the leaf of a table (section 1.6)."""
    if length <= usable - 35:
        return length
    least = (usable - 12) * 32 // 255 - 23
    fitting = least + (length - least) % (usable - 4)
    return fitting if fitting <= usable - 35 else least


def _committed(log: BufferedReader, size: int) -> dict[int, int]:
    """The frames of a log that count, with the numbers of their pages."""
    step = _FRAME_HEADER + size
    salts = _log_header(log)[16:24] or read_at(log, _LOG_HEADER + 8, 8)
    waiting: dict[int, int] = {}
    counted: dict[int, int] = {}
    for frame in range(max(length_of(log) - _LOG_HEADER, 0) // step):
        header = read_at(log, _LOG_HEADER + frame * step, 16)
        if header[8:16] == salts:
            waiting[frame] = int.from_bytes(header[:4])
            if header[4:8] != b"\0\0\0\0":
                counted |= waiting
                waiting = {}
    return counted


def length_of(file: BufferedReader) -> int:
    """The bytes of a file."""
    return file.seek(0, 2)


def read_at(file: BufferedReader, offset: int, length: int) -> bytes:
    """Bytes of a file; none where it ends, or the disk cannot read them."""
    try:
        file.seek(offset)
        return file.read(length)
    except OSError:
        return b""
