"""What a session has accepted, on its way into the file: written, or held until it can be.

Used by the session's writer thread alone, but for `error`, which anybody reads,
and `lock`.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from georibbon.errors import SessionError, StorageError
from georibbon.session import moving, store
from georibbon.session.chunks import Chunk
from georibbon.session.events import Event, now
from georibbon.session.lock import Lock
from georibbon.session.store import Store
from georibbon.session.stream import Stream

MOST_KEPT = 2**20  # bytes of frames of poses and passes kept beside the file
RETRY = 2.0  # seconds after which a place that failed is tried again
Told = Callable[[str | None], None]


@dataclass(frozen=True, eq=False)
class Batch:
    """What belongs into one transaction."""

    events: tuple[Event, ...]
    chunks: tuple[Chunk, ...]


class Journal:
    """The file, what is not in it yet, and the frames that were put into it by this process.

    told: called with a sentence when the place fails, with None when it is
    mended.  lock: the right to write to the file.
    """

    def __init__(self, opened: Store, lock: Lock, told: Told) -> None:
        self.error: StorageError | None = None
        self._store = opened
        self.lock = lock
        self._told = told
        self._backlog: list[Batch] = []
        self._streams: list[Stream] = []
        self._kept: dict[int, tuple[Chunk, ...]] = {}

    def write(self, batch: Batch) -> None:
        """Write a batch after all that is held; StorageError where it is held too."""
        self._backlog.append(batch)
        for chunk in batch.chunks:
            self._kept[chunk.part] = (*self._kept.get(chunk.part, ()), chunk)
        self.flush()

    def add(self, stream: Stream) -> None:
        """Take a stream's frames from now on."""
        self._streams.append(stream)

    def tick(self) -> float | None:
        """Write what there is; the seconds after which to try again where that fails."""
        try:
            self.flush()
        except StorageError:
            return RETRY
        return None

    def flush(self) -> None:
        """Write everything that is held and all frames that wait.  Raises StorageError."""
        try:
            if self._backlog:
                self._write_backlog()
            for stream in self._streams:
                while (work := stream.work()) is not None:
                    self._store.write((), work.chunks, work.cuts)
                    stream.done(work)
        except StorageError as error:
            self._fail(error)
            raise
        self._mended()

    def _write_backlog(self) -> None:
        events = [event for batch in self._backlog for event in batch.events]
        self._store.write(events, [chunk for batch in self._backlog for chunk in batch.chunks])
        self._backlog.clear()
        self._forget()

    def _forget(self) -> None:
        """Keep of the frames that are in the file the latest only, so that memory is bounded."""
        room = MOST_KEPT
        for part in reversed(list(self._kept)):
            room -= sum(len(chunk.t) + len(chunk.counts) for chunk in self._kept[part])
            if room < 0:
                del self._kept[part]

    def _mended(self) -> None:
        if self.error is not None:
            self.error = None
            self._told(None)

    def _fail(self, error: StorageError) -> None:
        new = self.error is None or str(self.error) != str(error)
        self.error = error
        for stream in self._streams:
            stream.failed()
        if new:
            self._told(str(error))

    def chunks(self, part: int) -> tuple[Chunk, ...]:
        """The chunks of a part, from memory or from the file; SessionError if unreadable."""
        return self._kept.get(part) or self._store.chunks(part)

    def sizes(self) -> dict[int, int]:
        """How many frames of each part are in the file.  Raises SessionError."""
        return self._store.sizes()

    @property
    def gone(self) -> bool:
        """Whether the file was removed or replaced."""
        return self._store.gone

    def move(self, path: Path, lock: Lock, events: Sequence[Event], changed: bool) -> moving.Moved:
        """Put everything into a new file and go on there.

        events: all of the session; changed: whether something was written to the
        old file, which then tells that it was closed, if it still can.  Raises
        StorageError where the new place fails; everything is as before then.
        """
        moved = moving.gathered(events, self._store, self._kept, self._streams)
        store.create(path, moved.events, moved.chunks())
        try:
            opened = Store(path)
        except BaseException:
            store.unmake(path)
            raise
        if changed and self.error is None and not self.gone:
            self._tell_closed(events[-1].id)
        self._store.close()
        self._store.tidy()
        if lock is not self.lock:
            self.lock.release()
        self._store, self.lock = opened, lock
        self._backlog.clear()
        for stream in self._streams:
            if stream.part in moved.ends:
                stream.done(moved.ends[stream.part])
        self._forget()
        self._mended()
        return moved

    def _tell_closed(self, number: int) -> None:
        """Write as the last event into a file that is left that it was closed as it is now."""
        with suppress(SessionError):
            frames = sum(self._store.sizes().values())
            self._store.write((Event(number, now(), "closed", {"frames": frames}),), ())

    def close(self) -> str | None:
        """Close the file and give the right to write back; why it is not one plain file."""
        why = self._store.close()
        self.lock.release()
        for stream in self._streams:
            stream.abandon()
        return why
