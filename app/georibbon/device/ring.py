"""Frames on their way to those who use them: a bounded ring for displays, a tap for recorders."""

import itertools
import threading
from collections import deque
from collections.abc import Sequence

from georibbon.device.frames import Frame


class Ring:
    """The last frames, at most `capacity` of them; who reads too slowly misses some.

    For displays, such as a window that draws what it gets to and tells what it
    `missed`; who needs every frame takes them from a `Tap`.  One writes, any
    number read, each at its own pace and from any thread.  The writer waits for
    no reader.
    """

    def __init__(self, capacity: int) -> None:
        if capacity < 1:
            raise ValueError(f"a ring of {capacity} frames; at least 1")
        self.capacity = capacity
        self._frames: deque[Frame] = deque(maxlen=capacity)
        self._written = 0
        self._grown = threading.Condition()

    def append(self, frames: Sequence[Frame]) -> None:
        """Put frames in; the oldest ones make room."""
        with self._grown:
            self._frames.extend(frames)
            self._written += len(frames)
            self._grown.notify_all()

    def reader(self) -> "RingReader":
        """A reader of all that is written from now on."""
        return RingReader(self)

    def last(self, count: int) -> list[Frame]:
        """The last frames, at most that many, in their order."""
        with self._grown:
            return _last(self._frames, count)

    def _since(self, place: int) -> tuple[list[Frame], int]:
        """What is left of the frames written from a place on, and the place after them."""
        with self._grown:
            return _last(self._frames, self._written - place), self._written

    def _wait(self, place: int, timeout: float) -> bool:
        with self._grown:
            return self._grown.wait_for(lambda: self._written > place, timeout)


def _last(frames: deque[Frame], count: int) -> list[Frame]:
    return list(itertools.islice(frames, max(len(frames) - max(count, 0), 0), None))


class RingReader:
    """One reader's place in a ring, and how many frames it has `missed`."""

    def __init__(self, ring: Ring) -> None:
        self.missed = 0
        self._ring = ring
        self._place = ring._written

    def take(self) -> list[Frame]:
        """The frames since the last call, in their order; none where none came."""
        frames, place = self._ring._since(self._place)
        self.missed += place - self._place - len(frames)
        self._place = place
        return frames

    def wait(self, timeout: float) -> bool:
        """Wait until there is something to take; whether there is, after at most `timeout` s."""
        return self._ring._wait(self._place, timeout)


class Tap:
    """All frames from its making on until it is closed, for a recorder: it drops none.

    What is not taken stays in memory, so who opens a tap takes from it.
    """

    def __init__(self) -> None:
        self._frames: list[Frame] = []
        self._open = True
        self._grown = threading.Condition()

    def append(self, frames: Sequence[Frame]) -> None:
        """Put frames in, unless the tap is closed."""
        with self._grown:
            if self._open:
                self._frames.extend(frames)
                self._grown.notify_all()

    def take(self) -> list[Frame]:
        """The frames since the last call, in their order; none where none came."""
        with self._grown:
            frames, self._frames = self._frames, []
            return frames

    def wait(self, timeout: float) -> bool:
        """Wait until there is something to take; whether there is, after at most `timeout` s."""
        with self._grown:
            return self._grown.wait_for(lambda: bool(self._frames) or not self._open, timeout)

    def close(self) -> None:
        """Take no more frames in; what came before can still be taken."""
        with self._grown:
            self._open = False
            self._grown.notify_all()

    @property
    def closed(self) -> bool:
        """Whether no more frames will come in."""
        return not self._open


class Outlets:
    """Where frames go: into one ring, and into every open tap."""

    def __init__(self, capacity: int) -> None:
        self.ring = Ring(capacity)
        self._taps: list[Tap] = []
        self._closed = False
        self._lock = threading.Lock()

    def tap(self) -> Tap:
        """A tap for all frames from now on; a closed one where no more will come."""
        tap = Tap()
        with self._lock:
            if self._closed:
                tap.close()
            else:
                self._taps.append(tap)
        return tap

    def append(self, frames: Sequence[Frame]) -> None:
        """Put frames everywhere."""
        self.ring.append(frames)
        with self._lock:
            self._taps = [tap for tap in self._taps if not tap.closed]
            taps = tuple(self._taps)
        for tap in taps:
            tap.append(frames)

    def close(self) -> None:
        """No more frames will come; what the taps hold can still be taken."""
        with self._lock:
            self._closed = True
            for tap in self._taps:
                tap.close()
            self._taps = []
