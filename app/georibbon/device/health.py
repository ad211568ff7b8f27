"""How the link is: the figures that anyone may ask for at any moment."""

import threading
import time
from collections import deque
from dataclasses import dataclass, field

from georibbon.device.telling import LinkState

WINDOW = 1.0  # s over which frames per second are counted


@dataclass(frozen=True)
class Health:
    """The link's figures since its start.

    frames: delivered; frames_per_second: over the last second; bytes: read;
    packets: undamaged, of any type, from the ribbon's identity on; lost: missing
    in the sequence numbers, those that came damaged included; damaged: wrong
    checksum, length or stuffing; unknown: of a type that is not known;
    restarts: of the ribbon; reconnects: after the first time.
    """

    state: LinkState
    reason: str
    frames: int
    frames_per_second: float
    bytes: int
    packets: int
    lost: int
    damaged: int
    unknown: int
    stalls: int
    restarts: int
    reconnects: int


@dataclass
class Counts:
    """The counters behind `Health`; `lock` is held while several change together."""

    frames: int = 0
    bytes: int = 0
    packets: int = 0
    lost: int = 0
    damaged: int = 0
    unknown: int = 0
    stalls: int = 0
    restarts: int = 0
    reconnects: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)
    _recent: deque[tuple[float, int]] = field(default_factory=deque)

    def delivered(self, frames: int, arrived: float) -> None:
        """Frames that arrived at a time of the monotonic clock."""
        self.frames += frames
        self._recent.append((arrived, frames))
        self._forget(arrived)

    def health(self, state: LinkState, reason: str) -> Health:
        """The figures of this moment."""
        with self.lock:
            self._forget(time.monotonic())
            recent = sum(frames for _, frames in self._recent)
            return Health(
                state,
                reason,
                self.frames,
                recent / WINDOW,
                self.bytes,
                self.packets,
                self.lost,
                self.damaged,
                self.unknown,
                self.stalls,
                self.restarts,
                self.reconnects,
            )

    def _forget(self, moment: float) -> None:
        while self._recent and self._recent[0][0] < moment - WINDOW:
            self._recent.popleft()
