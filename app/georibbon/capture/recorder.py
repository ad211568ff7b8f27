"""Everything a ribbon says, from the link to where it is kept: nothing missed, all counted."""

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from georibbon.device.frames import Frame
from georibbon.device.ring import Tap
from georibbon.errors import StorageError

PERIOD = 0.2  # seconds between two writes: what a crash of the computer can cost
RETRY = 1.0  # seconds until it is tried again to write what could not be written
FIRST = 5.0  # seconds beyond the end for a first frame to come at all
_LATE = 0.5  # seconds beyond the end for the last frames to arrive
_HALF_MICROSECOND = 5e-7


class Sink(Protocol):
    """Where a recorder puts what it takes; called by the recorder's thread alone."""

    @property
    def durable(self) -> int:
        """How many of the frames are safe on the disk; read by any thread."""

    def append(self, frames: Sequence[Frame]) -> None:
        """Take frames, and keep them whatever happens to the disk."""

    def sync(self) -> None:
        """See that what was taken gets to the disk; StorageError where it cannot be written."""


@dataclass(frozen=True)
class Progress:
    """How far a recorder is.

    frames: taken from the link; durable: of them, safe on the disk.  storage:
    why the rest cannot be written, or None.
    """

    frames: int
    durable: int
    storage: str | None


class Recorder:
    """Takes every frame of a tap to a sink, on a thread of its own.

    tap: opened before the link is started, it misses nothing.  seconds: how
    long, by the ribbon's clock, from the first frame on (where none comes, little
    longer by the host's); None: until `stop`.
    on_storage: called, in the recorder's thread, with a sentence when the frames
    can no longer be written, and with None when they can again; meanwhile they
    are kept in memory, without a bound, and every second it is tried again.
    """

    def __init__(
        self,
        tap: Tap,
        sink: Sink,
        *,
        seconds: float | None = None,
        on_storage: Callable[[str | None], None] = lambda _: None,
    ) -> None:
        self._tap = tap
        self._sink = sink
        self._limit = _Limit(seconds)
        self._on_storage = on_storage
        self._frames = 0
        self._storage: str | None = None
        self._again = 0.0
        self._stopping = threading.Event()
        self._finished = threading.Event()
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)

    @property
    def progress(self) -> Progress:
        """The counts at this moment."""
        durable = self._sink.durable  # asked first, so that it is never ahead
        return Progress(self._frames, durable, self._storage)

    @property
    def finished(self) -> bool:
        """Whether the seconds are over, or the recorder failed (`stop` then raises why)."""
        return self._finished.is_set()

    def start(self) -> None:
        """Begin, once, with what is in the tap already."""
        self._limit.begin()
        self._thread.start()

    def stop(self) -> None:
        """Take what has been delivered so far, write it, and end; the sink stays open.

        Frames that come later are not taken any more.  Raises what stopped the
        recorder before, if something did.
        """
        self._tap.close()
        self._stopping.set()
        self._thread.join()
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        try:
            while not self._stopping.wait(PERIOD):
                self._pass_on()
            self._again = 0.0
            self._pass_on()
        except Exception as failure:  # raised again by `stop`: nobody else would hear of it
            self._failure = failure
            self._finished.set()

    def _pass_on(self) -> None:
        frames = self._limit.within(self._tap.take())
        self._frames += len(frames)
        self._sink.append(frames)
        if time.monotonic() >= self._again:
            self._write()
        if self._limit.over:
            self._finished.set()

    def _write(self) -> None:
        try:
            self._sink.sync()
        except StorageError as error:
            self._again = time.monotonic() + RETRY
            self._tell(str(error))
        else:
            self._tell(None)

    def _tell(self, storage: str | None) -> None:
        if storage != self._storage:
            self._storage = storage
            self._on_storage(storage)


class _Limit:
    """So many seconds from the first frame on, by the ribbon's clock.

    Where the frames that should follow, or even the first, do not come, the host's
    clock ends it.
    """

    def __init__(self, seconds: float | None) -> None:
        self._seconds = seconds
        self._first: Frame | None = None
        self._reached = False
        self._begun = 0.0

    def begin(self) -> None:
        """Wait for the first frame from now on."""
        self._begun = time.monotonic()

    def within(self, frames: list[Frame]) -> list[Frame]:
        """Those of the frames that come before the end."""
        if self._seconds is None or not frames:
            return frames
        self._first = self._first or frames[0]
        end = self._first.t + self._seconds - _HALF_MICROSECOND
        kept = [frame for frame in frames if frame.t < end]
        self._reached = self._reached or len(kept) < len(frames)
        return kept

    @property
    def over(self) -> bool:
        """Whether the end is reached."""
        if self._reached or self._seconds is None:
            return self._reached
        if self._first is None:
            return time.monotonic() > self._begun + self._seconds + FIRST
        return time.monotonic() > self._first.arrived + self._seconds + _LATE
