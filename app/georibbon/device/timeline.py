"""The ribbon's clock as seconds that grow, and the packets that did not come.

A frame carries microseconds since power-up modulo 2**32 (71.6 minutes) and a
sequence number modulo 65536 that counts packets of every type.  From one frame
to the next the two are held against each other and against the host's clock:
either they tell of the same time gone by, and the gap is what was lost; or they
do not, and the ribbon has started anew.
"""

from dataclasses import dataclass
from math import inf

from georibbon.device.frames import CLOCK
from georibbon.device.packets import SEQUENCES

TICK = 1e-6  # s
_WRAP = CLOCK * TICK
_CLOCKS_APART = 1.0  # s: how far the two clocks may differ, buffers and delays included,
_CLOCKS_DRIFT = 0.02  # and how much more for every second
_EXTRA = 50  # packets beyond the frames that the time explains: messages and answers
_PAUSE = 6.0  # s that frames may pause in one gap: a handshake's three tries


@dataclass(frozen=True, slots=True)
class Step:
    """One frame on the timeline.

    t: seconds since the first frame.  lost: packets that are missing before it.
    restarted: whether the ribbon's clock or numbers began anew before it; what
    was lost over that, nobody knows, and nothing is counted.
    """

    t: float
    lost: int
    restarted: bool


@dataclass(slots=True)
class _Mark:
    """A packet from which gaps are counted, and the packets without a clock since."""

    sequence: int
    others: int = 0

    def gap(self, sequence: int) -> int:
        return (sequence - self.sequence - 1 - self.others) % SEQUENCES


class Timeline:
    """Puts frames on one line of time, over wraps, gaps, restarts and reconnects."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.lost = 0
        self.restarts = 0
        self._last: _Mark | None = None
        self._anew: _Mark | None = None
        self._awaiting_anew = False
        self._clock: int | None = None
        self._ticks = 0
        self._arrived = 0.0
        self._lead = -inf  # s from arrival to t, of the frame that was least late

    def reconnected(self) -> None:
        """The port was opened again: what comes now may be from a ribbon that restarted."""
        self._anew, self._awaiting_anew = None, True

    def other(self, sequence: int) -> None:
        """A packet that carries no clock."""
        fresh = self._note_anew(sequence)
        if self._last is None:
            self._last = _Mark(sequence)
        else:
            self._last.others += 1
        if self._anew is not None and not fresh:
            self._anew.others += 1

    def frame(self, sequence: int, microseconds: int, arrived: float) -> Step | None:
        """Where a frame is on the line; None for one that came already.

        arrived: seconds of the host's monotonic clock, growing from call to call.
        """
        self._note_anew(sequence)
        if self._clock is None or self._last is None:
            step = Step(0.0, _sure(self._anew or self._last, sequence), False)
        elif self._repeats(sequence, microseconds):
            return None
        else:
            gap = self._last.gap(sequence)
            step = self._next(sequence, gap, (microseconds - self._clock) % CLOCK, arrived)
        self._last, self._clock, self._arrived = _Mark(sequence), microseconds, arrived
        self._lead = max(self._lead, step.t - arrived)
        self._anew = None
        self.lost += step.lost
        self.restarts += step.restarted
        return step

    def _note_anew(self, sequence: int) -> bool:
        """Remember the first packet after a reconnect; whether this is it."""
        fresh, self._awaiting_anew = self._awaiting_anew, False
        if fresh:
            self._anew = _Mark(sequence)
        return fresh

    def _repeats(self, sequence: int, microseconds: int) -> bool:
        last = self._last
        same = last is not None and last.others == 0 and last.sequence == sequence
        return same and self._clock == microseconds

    def _next(self, sequence: int, gap: int, ticks: int, arrived: float) -> Step:
        """The step over a gap (modulo 65536) and a difference of the clock (modulo 2**32)."""
        host = max(arrived - self._arrived, 0.0)
        again = self._anew is not None
        late = self._lead + self._arrived - self._ticks * TICK  # the last frame's, s
        whole = elapsed_ticks(ticks, gap, host, host + late, self.rate, again)
        if whole is None:
            self._ticks += max(round(host / TICK), 1)
            return Step(self._ticks * TICK, _sure(self._anew, sequence), True)
        self._ticks += max(whole, 1)
        return Step(self._ticks * TICK, missing(gap, whole * TICK, self.rate), False)


def _sure(mark: _Mark | None, sequence: int) -> int:
    """The gap since a mark, where no clock tells more: none where it may as well be a restart."""
    gap = 0 if mark is None or mark.sequence == sequence else mark.gap(sequence)
    return gap if gap < SEQUENCES // 2 else 0


def elapsed_ticks(
    ticks: int, gap: int, host: float, longest: float, rate: float, again: bool
) -> int | None:
    """Microseconds from one frame to the next; None where the ribbon has restarted.

    ticks: the difference of the ribbon's clock modulo 2**32.  gap: the missing
    sequence numbers modulo 65536.  host: seconds between the arrivals.  longest: s
    that can have gone by, had the first of the two arrived late.  rate: frames per
    second.  again: whether the port was opened again in between.  A
    frame may arrive late for any reason, never early: so the time that clock and
    sequence agree on is taken where it can have gone by (at 15.26 frames per second
    both begin anew together, and agree whatever happened), or else a time that the
    host's clock bears out.
    """
    frames = ticks * TICK * rate
    allowed = _CLOCKS_APART + _CLOCKS_DRIFT * host
    if abs(gap + 1 - frames) <= 2 + 0.02 * frames and ticks * TICK <= longest + allowed:
        return ticks
    wraps = max(round((host - ticks * TICK) / _WRAP), 0)
    whole = ticks + wraps * CLOCK
    apart = whole * TICK - host
    if apart > allowed or (again and apart < -allowed):
        return None
    if gap > 1.2 * whole * TICK * rate + _EXTRA:
        return None
    return whole


def missing(gap: int, elapsed: float, rate: float) -> int:
    """How many packets are missing, from their number modulo 65536 and the seconds gone by."""
    expected = elapsed * rate
    whole = gap + SEQUENCES * max(round((expected - gap) / SEQUENCES), 0)
    # Numbers that go on where they stopped are a pause, unless the time fits to a second.
    allowed = rate + 2 if gap < _EXTRA else 0.02 * expected + _PAUSE * rate + _EXTRA
    return whole if abs(whole - expected) <= allowed else gap
