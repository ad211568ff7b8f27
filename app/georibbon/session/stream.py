"""Frames that come without end, on their way into the session file."""

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from georibbon.errors import SessionError
from georibbon.ribbon import Readings
from georibbon.session.chunks import FRAMES, Chunk, joined, pack
from georibbon.session.counts import check_readings
from georibbon.session.writer import INTERVAL

MOST_AT_ONCE = 16 * FRAMES  # frames of one transaction
_LOST = -32768  # a lost value in counts of 16 bits


class FrameLike(Protocol):
    """A frame as the link delivers it: seconds, and (c,) int16 counts, -32768 for a lost value."""

    @property
    def t(self) -> float:
        """Seconds."""

    @property
    def counts(self) -> NDArray[np.int16]:
        """Counts."""


@dataclass(frozen=True, eq=False)
class Work:
    """What a transaction does for a stream, and how the stream stands after it.

    cuts: (part, place), see `Store.write`.  taken: how many of the waiting
    blocks, with so many frames, it writes.  base: the place of the first small
    chunk after it; tail: these small chunks.
    """

    cuts: tuple[tuple[int, int], ...]
    chunks: tuple[Chunk, ...]
    taken: int
    frames: int
    base: int
    tail: tuple[Chunk, ...]


class Stream:
    """A part of the session that grows; made by `Session.stream`.

    What is appended waits in memory, as compact as on the disk, until a
    transaction has taken it.
    """

    def __init__(self, part: int, columns: tuple[str, ...], poke: Callable[[float], None]) -> None:
        """Use `Session.stream`; poke: has the writer write after so many seconds."""
        self.part = part
        self._columns = columns
        self._poke = poke
        self._lock = threading.Lock()
        self._settled = threading.Condition(self._lock)
        self._failures = 0
        self._over = False
        self._waiting: list[Chunk] = []
        self._last = -np.inf
        self._frames = self._durable = 0
        self._base = 0
        self._tail: tuple[Chunk, ...] = ()
        self._ended = False

    @property
    def frames(self) -> int:
        """How many frames were appended."""
        return self._frames

    @property
    def durable(self) -> int:
        """How many of them are safe on the disk."""
        return self._durable

    def append(self, frames: Readings | Sequence[FrameLike]) -> None:
        """Take frames; never waits for the disk.

        Their times grow, also from one call to the next.  Raises RecordingError
        for what is none, and SessionError when the stream has ended.
        """
        readings = frames if isinstance(frames, Readings) else _readings(frames)
        if not readings.t.size:
            return
        name = f"stream {self.part}"
        check_readings(readings, self._columns, name)
        blocks = list(pack(readings, self.part))
        with self._lock:
            if self._ended:
                raise SessionError(f"{name} has ended; begin another one")
            if readings.t[0] <= self._last:
                raise SessionError(
                    f"{name}: a frame at {float(readings.t[0])!r} s after one at "
                    f"{float(self._last)!r} s; times that grow are expected"
                )
            self._last = readings.t[-1]
            self._frames += readings.t.size
            self._waiting += blocks
        self._poke(INTERVAL)

    def flush(self, timeout: float = 10.0) -> bool:
        """Have everything appended so far written now; whether it is safe.

        Returns when it is, when it could not be written, or after so many seconds.
        """
        with self._lock:
            target, failures = self._frames, self._failures
        self._poke(0.0)
        with self._settled:
            self._settled.wait_for(
                lambda: self._durable >= target or self._over or self._failures != failures,
                timeout,
            )
            return self._durable >= target

    def close(self) -> None:
        """End the stream and write what waits; what cannot be written stays with the session."""
        with self._lock:
            self._ended = True
        self.flush()

    def failed(self) -> None:
        """What waits could not be written.  Called by the writer."""
        with self._settled:
            self._failures += 1
            self._settled.notify_all()

    def abandon(self) -> None:
        """Nothing will be written any more.  Called by the writer."""
        with self._settled:
            self._over = self._ended = True
            self._settled.notify_all()

    def work(self) -> Work | None:
        """What there is to write.  Called by the writer."""
        blocks = self._some(0)
        if not blocks and not (self._ended and len(self._tail) > 1):
            return None
        ahead = sum(chunk.frames for chunk in self._tail)
        taken = sum(block.frames for block in blocks)
        if ahead + taken >= FRAMES or self._ended:
            start = Work((), (), 0, 0, self._base, self._tail)
            return self._merged(start, blocks)
        place = self._base + len(self._tail)
        chunks = tuple(pack(self._joined(blocks), self.part, place))
        return Work((), chunks, len(blocks), taken, self._base, (*self._tail, *chunks))

    def merging(self, base: int) -> Iterator[Work]:
        """Steps that put everything from its first small chunk on into another file.

        base: the place of the first of its chunks there.  Every step's full
        chunks are all but its tail; the last one's tail is the stream's end
        there, and `done` takes it.  Called by the writer.
        """
        work = Work((), (), 0, 0, base, self._tail)
        blocks = self._some(0)
        while blocks or work.tail:
            work = self._merged(work, blocks)
            yield work
            blocks = self._some(work.taken)
            if not blocks:
                return

    def _merged(self, before: Work, blocks: Sequence[Chunk]) -> Work:
        """What follows on `before`: its small chunks and some blocks in as few chunks as can be."""
        readings = self._joined([*before.tail, *blocks])
        chunks = tuple(pack(readings, self.part, before.base))
        full = sum(chunk.frames == FRAMES for chunk in chunks)
        return Work(
            ((self.part, before.base),),
            chunks,
            before.taken + len(blocks),
            before.frames + sum(block.frames for block in blocks),
            before.base + full,
            chunks[full:],
        )

    def done(self, work: Work) -> None:
        """The work is durable.  Called by the writer."""
        with self._settled:
            del self._waiting[: work.taken]
            self._base, self._tail = work.base, work.tail
            self._durable += work.frames
            self._settled.notify_all()

    @property
    def base(self) -> int:
        """The place of the first chunk that is not full.  For the writer."""
        return self._base

    def _some(self, start: int) -> list[Chunk]:
        """The blocks that wait, from one on, of not many more frames than a transaction takes."""
        with self._lock:
            waiting = self._waiting[start:]
        frames = 0
        for count, block in enumerate(waiting):
            if frames >= MOST_AT_ONCE:
                return waiting[:count]
            frames += block.frames
        return waiting

    def _joined(self, blocks: Sequence[Chunk]) -> Readings:
        placed = [replace(block, place=i) for i, block in enumerate(blocks)]
        return joined(placed, len(self._columns))


def _readings(frames: Sequence[FrameLike]) -> Readings:
    t = np.array([frame.t for frame in frames], dtype=np.float64)
    counts = np.array([frame.counts for frame in frames]).astype(np.float64)
    counts[counts == _LOST] = np.nan
    return Readings(t, counts)
