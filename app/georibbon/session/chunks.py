"""Frames as the blobs of a session file, with a digest each."""

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.ribbon import Readings

FRAMES = 2048
_TIME = np.dtype("<f8")
_CODES = {2: "<i2", 4: "<i4"}


class DamagedError(Exception):
    """What was read is not what was written; the message says how."""


@dataclass(frozen=True)
class Chunk:
    """A row of the table `chunk`: successive frames of one part, see `schema`."""

    part: int
    place: int
    frames: int
    width: int
    t: bytes
    counts: bytes

    @property
    def digest(self) -> bytes:
        """SHA-256 of everything in the chunk."""
        head = f"{self.part},{self.place},{self.frames},{self.width};".encode()
        return hashlib.sha256(head + self.t + self.counts).digest()

    @property
    def row(self) -> tuple[object, ...]:
        """The row of the table."""
        fields = (self.part, self.place, self.frames, self.width, self.t, self.counts)
        return (*fields, self.digest)


def pack(readings: Readings, part: int, first: int = 0) -> Iterator[Chunk]:
    """The chunks of readings that `check_readings` accepts, as narrow as their values allow.

    first: the place of the first chunk.
    """
    for place, start in enumerate(range(0, readings.t.size, FRAMES), start=first):
        block = slice(start, start + FRAMES)
        counts = readings.counts[block]
        lost = np.isnan(counts)
        width = 4 if np.any(np.abs(counts[~lost]) >= -_lost(2)) else 2
        whole = np.where(lost, _lost(width), counts).astype(_CODES[width])
        t = readings.t[block].astype(_TIME)
        yield Chunk(part, place, t.size, width, t.tobytes(), whole.tobytes())


def unpack(rows: Iterable[Sequence[object]], columns: int) -> Readings:
    """The readings in one part's rows (part, place, frames, width, t, counts, digest).

    columns: the number of axes.  Raises DamagedError.
    """
    return joined([chunk_of(row) for row in rows], columns)


def chunk_of(row: Sequence[object]) -> Chunk:
    """The chunk in a row; DamagedError where the row is not as it was written."""
    if len(row) != 7:
        raise DamagedError("a chunk of frames has not the values that it should have")
    chunk = _chunk(row[:-1])
    if chunk.digest != row[-1]:
        raise DamagedError(f"frames of part {chunk.part} do not match their digest")
    return chunk


def joined(chunks: Sequence[Chunk], columns: int) -> Readings:
    """The readings in all chunks of one part; DamagedError where they make no sense."""
    times, counts = [], []
    for i, chunk in enumerate(chunks):
        if chunk.width not in _CODES or chunk.place != i or chunk.frames < 1:
            raise DamagedError(f"a chunk of part {chunk.part} is out of order")
        lengths = (chunk.frames * _TIME.itemsize, chunk.frames * columns * chunk.width)
        if (len(chunk.t), len(chunk.counts)) != lengths:
            raise DamagedError(f"a chunk of part {chunk.part} has not the length it should have")
        whole = np.frombuffer(chunk.counts, _CODES[chunk.width])
        times.append(np.frombuffer(chunk.t, _TIME).astype(np.float64))
        values_of = np.where(whole == _lost(chunk.width), np.nan, whole)
        counts.append(values_of.reshape(chunk.frames, columns))
    if not times:
        raise DamagedError("a pose or a pass has no frames")
    return Readings(np.concatenate(times), np.concatenate(counts))


def _lost(width: int) -> int:
    """What stands for a lost value: the least integer of so many bytes."""
    return -(1 << (8 * width - 1))


def _chunk(values: Sequence[object]) -> Chunk:
    part, place, frames, width, t, counts = values
    if not (
        isinstance(part, int)
        and isinstance(place, int)
        and isinstance(frames, int)
        and isinstance(width, int)
        and isinstance(t, bytes)
        and isinstance(counts, bytes)
    ):
        raise DamagedError("a chunk of frames has values of the wrong type")
    return Chunk(part, place, frames, width, t, counts)
