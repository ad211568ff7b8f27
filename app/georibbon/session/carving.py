"""The rows of a session file found one by one, whatever else of the file is damaged.

Every row of `event` and of `chunk` carries its digest, so it needs no table
around it: the bytes are searched for what the head of such a row looks like,
the row is put together through its overflow pages, and taken if its digest is
right.  Whether the file's header, the tree above the row or the page around it
is in order does not matter; rows deleted long ago are found too, so who asks
for frames says which.
"""

import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from io import BufferedReader
from operator import itemgetter
from pathlib import Path

from georibbon.errors import SessionError
from georibbon.session.chunks import Chunk, DamagedError, chunk_of
from georibbon.session.events import Event, event_of
from georibbon.session.pages import (
    Pages,
    Place,
    body_length,
    decode,
    length_of,
    likely_sizes,
    log_size,
    read_at,
    varint,
)

MAX_PAYLOAD = 64 * 2**20
MAX_ROWS = 1_000_000
_BLOCK = 2**20
_OVERLAP = 32  # no head that is looked for is longer
_SECTOR = 512
_SPARE = 64 * 2**20

# The head of a record is its length and the types of its values: NULL for an id that is the
# row's own, odd for texts, even for blobs, 1 to 9 for whole numbers, 0x4C for 32 bytes of digest.
# It is looked for from its end, in the bytes turned round: so the search has a byte to run for.
_TYPE = rb"(?:[\x00-\x7f][\x80-\xff]{0,3})"
_HEAD = re.compile(
    rb"\x4c(?=(" + _TYPE + rb"{3}\x00[\x06-\x12]|"
    + _TYPE + rb"{2}[\x01-\x06\x08\x09]{4}[\x08-\x12]))"
)  # fmt: skip


@dataclass(frozen=True)
class Piece:
    """Where a row of the table `chunk` is whose digest was right, and what it says it holds."""

    part: int
    place: int
    frames: int
    columns: int
    digest: bytes
    start: Place
    length: int
    size: int
    newest: bool


@dataclass(frozen=True)
class Carving:
    """What was found in a session file.

    events: by their ids; conflicts: the ids for which there were two different
    events, of which the newer is taken; pieces: in the order of part and place,
    those that were deleted too; whole: whether all of the file was gone
    through, not given up as leading in circles; views: the pages by the sizes
    that they may have, the likeliest first.
    """

    events: tuple[Event, ...]
    conflicts: tuple[int, ...]
    pieces: tuple[Piece, ...]
    whole: bool
    views: dict[int, Pages]

    def chunk(self, piece: Piece) -> Chunk:
        """The frames of a piece, read once more.  Raises DamagedError where they are gone."""
        pages = self.views[piece.size]
        record = pages.payload(piece.start, piece.length, piece.newest)
        chunk = None if record is None else _chunk(record)
        if chunk is None or chunk.digest != piece.digest:
            raise DamagedError(f"frames of part {piece.part} changed while they were read")
        return chunk


@contextmanager
def carved(path: Path) -> Iterator[Carving]:
    """What can be found in a session file and the log beside it, which stay as they are.

    Raises SessionError where the file cannot be opened.
    """
    with ExitStack() as stack:
        try:
            log_path = Path(f"{path.resolve()}-wal")
            database = stack.enter_context(path.open("rb"))
            log = stack.enter_context(log_path.open("rb")) if log_path.is_file() else None
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise SessionError(
                f"{path}: it cannot be read ({reason}); see to its rights"
            ) from error
        yield _Search(database, log).run()


class _Search:
    """One search through a database and its log."""

    def __init__(self, database: BufferedReader, log: BufferedReader | None) -> None:
        self.files = (database, log)
        logged = None if log is None else log_size(log)
        self.views = [
            Pages(database, log if size == logged else None, size)
            for size in likely_sizes(database)
        ]
        total = length_of(database) + (0 if log is None else length_of(log))
        self.budget = 4 * total + _SPARE
        self.events: dict[int, dict[bytes, tuple[int, Event]]] = {}
        self.pieces: dict[bytes, Piece] = {}

    def run(self) -> Carving:
        """Look everywhere."""
        whole = self._look(0) and self._look(1)
        ids = sorted(self.events)
        events = tuple(max(self.events[i].values(), key=itemgetter(0))[1] for i in ids)
        conflicts = tuple(i for i in ids if len(self.events[i]) > 1)
        pieces = sorted(self.pieces.values(), key=lambda piece: (piece.part, piece.place))
        views = {pages.size: pages for pages in self.views}
        return Carving(events, conflicts, tuple(pieces), whole, views)

    def _look(self, which: int) -> bool:
        """Look at every head in one of the files; False when it was given up."""
        file = self.files[which]
        for offset in () if file is None else _heads(file):
            self._take(offset, which == 1)
            if self.budget < 0 or len(self.events) + len(self.pieces) > MAX_ROWS:
                return False
        return True

    def _take(self, offset: int, in_log: bool) -> None:
        """Take the row whose head is at a byte of a file, if there is one."""
        for pages in self.views:
            place = pages.place(offset, in_log)
            page = place and (
                pages.page(place.page, False) if place.frame is None else pages.frame(place.frame)
            )
            length = page and place and _record_length(page, place.offset)
            if not place or not page or not length:
                continue
            for newest in (True, False):
                record = pages.payload(place, length, newest)
                self.budget -= length if record is not None else pages.size
                if record is not None and self._keep(record, page, place, pages, newest):
                    return

    def _keep(self, record: bytes, page: bytes, place: Place, pages: Pages, newest: bool) -> bool:
        """Keep a record that is an event or a chunk; False where it is none."""
        if record[1] == 0:
            event = _event(record, page, place.offset)
            if event is not None:
                age = -1 if place.frame is None else place.frame
                known = self.events.setdefault(event.id, {})
                before, _ = known.get(record[-32:], (age, event))
                known[record[-32:]] = (max(age, before), event)
            return event is not None
        chunk = _chunk(record)
        if chunk is not None:
            columns = len(chunk.counts) // (chunk.frames * chunk.width)
            told = (chunk.part, chunk.place, chunk.frames, columns, chunk.digest)
            self.pieces[chunk.digest] = Piece(*told, place, len(record), pages.size, newest)
        return chunk is not None


def _heads(file: BufferedReader) -> Iterator[int]:
    """Every byte of a file at which the head of a row may be."""
    for start in range(0, length_of(file), _BLOCK):
        block = _block(file, start)
        for match in _HEAD.finditer(block[::-1]):
            place = len(block) - match.end(1)
            if place < _BLOCK:
                yield start + place


def _block(file: BufferedReader, start: int) -> bytes:
    """The bytes that are searched at once, with zeros for what the disk cannot read."""
    length = min(_BLOCK + _OVERLAP, length_of(file) - start)
    block = read_at(file, start, length)
    if len(block) == length:
        return block
    sectors = (
        (place, min(_SECTOR, start + length - place))
        for place in range(start, start + length, _SECTOR)
    )
    return b"".join(read_at(file, place, size).ljust(size, b"\0") for place, size in sectors)


def _record_length(page: bytes, offset: int) -> int | None:
    """How long the record with this head is; None where the head is none of ours."""
    end = offset + page[offset]
    at, lengths = offset + 1, []
    while at < end:
        found = varint(page, at)
        length = None if found is None else body_length(found[0])
        if found is None or length is None:
            return None
        lengths.append(length)
        at = found[1]
    if at != end or page[end - 1] != 0x4C:
        return None
    total = page[offset] + sum(lengths)
    return total if len(lengths) in (5, 7) and total <= MAX_PAYLOAD else None


def _event(record: bytes, page: bytes, offset: int) -> Event | None:
    """The event in a record whose head is at a byte of its page, right after its id."""
    values = decode(record)
    if values is None:
        return None
    for start in range(offset - 1, max(offset - 10, -1), -1):
        found = varint(page, start)
        if found is not None and found[1] == offset:
            try:
                return event_of((found[0], *values[1:]))
            except DamagedError:
                continue
    return None


def _chunk(record: bytes) -> Chunk | None:
    """The chunk in a record."""
    try:
        chunk = chunk_of(decode(record) or ())
    except DamagedError:
        return None
    fits = chunk.frames > 0 and chunk.place >= 0 and chunk.width in (2, 4)
    fits = fits and len(chunk.t) == 8 * chunk.frames
    return chunk if fits and len(chunk.counts) % (chunk.frames * chunk.width) == 0 else None
