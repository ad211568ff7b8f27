"""One line of time: what was lost is counted exactly, and time is the ribbon's own."""

from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from georibbon.device.frames import CLOCK
from georibbon.device.timeline import Timeline

RATE = 100.0
PERIOD = 10_000  # microseconds from frame to frame


class Wire:
    """A ribbon that sends, a line that loses some of it, and a timeline at its end."""

    def __init__(self, clock=0, sequence=0, rate=RATE):
        self.timeline = Timeline(rate)
        self.period = round(1e6 / rate)
        self.clock, self.sequence, self.host = clock, sequence, 1000.0
        self.t, self.sent, self.taken, self.pending = [], 0, 0, 0
        self.true = []

    def _number(self):
        number, self.sequence = self.sequence, (self.sequence + 1) % 65536
        return number

    def frames(self, count, arrive=True, delay=0.0):
        """Frames, one after the other, that arrive or do not."""
        for _ in range(count):
            self.pass_by(self.period)
            number = self._number()
            if not arrive:
                self.pending += bool(self.taken)
                continue
            self._came()
            step = self.timeline.frame(number, self.clock % CLOCK, self.host + delay)
            self.t.append(step.t)
            self.true.append(self.clock)

    def other(self, arrive=True):
        """A packet without a clock."""
        number = self._number()
        if arrive:
            self._came()
            self.timeline.other(number)
        else:
            self.pending += bool(self.taken)

    def _came(self):
        """What is missing before a packet that arrives is missed for good."""
        self.sent, self.pending, self.taken = self.sent + self.pending, 0, self.taken + 1

    def pass_by(self, microseconds):
        self.clock += microseconds
        self.host += microseconds * 1e-6

    def restart(self, after=0):
        """The power goes and comes; the host's time goes on."""
        self.host += after * 1e-6
        self.clock, self.sequence, self.pending = 0, 0, 0


STARTS = {
    "clock": st.integers(0, CLOCK - 1) | st.integers(CLOCK - 10 * PERIOD, CLOCK - 1),
    "sequence": st.integers(0, 65535) | st.integers(65500, 65535),
}
# (what, how many, whether it arrives)
RUNS = st.lists(
    st.tuples(st.sampled_from(["frames", "other"]), st.integers(1, 60), st.booleans()), max_size=20
)


def run(wire, runs):
    for what, count, arrive in runs:
        if what == "frames":
            wire.frames(count, arrive)
        else:
            wire.other(arrive)


@given(**STARTS, runs=RUNS, delay=st.floats(0.0, 3.0))
def test_what_is_lost_is_counted_and_time_is_the_ribbons(clock, sequence, runs, delay):
    wire = Wire(clock, sequence)
    wire.other()
    run(wire, runs)
    wire.frames(1, delay=delay)
    wire.frames(2, delay=delay)
    assert wire.timeline.lost == wire.sent
    assert wire.timeline.restarts == 0
    assert wire.t == pytest.approx([(c - wire.true[0]) * 1e-6 for c in wire.true], abs=1e-9)


@given(**STARTS, runs=RUNS, seconds=st.integers(0, 20_000), others=st.integers(0, 3))
@example(clock=5, sequence=5, runs=[], seconds=655, others=1)
@example(clock=5, sequence=5, runs=[], seconds=15_000, others=0)
def test_over_a_reconnect_a_ribbon_that_went_on(clock, sequence, runs, seconds, others):
    wire = Wire(clock, sequence)
    run(wire, runs)
    wire.frames(2)
    unplugged = round(seconds * RATE)
    wire.pass_by(unplugged * PERIOD)
    wire.sequence = (wire.sequence + unplugged) % 65536
    wire.pending += unplugged
    wire.timeline.reconnected()
    for _ in range(others):
        wire.other()
    wire.frames(3)
    assert wire.timeline.restarts == 0
    assert wire.timeline.lost == wire.sent
    assert wire.t == pytest.approx([(c - wire.true[0]) * 1e-6 for c in wire.true], abs=1e-9)


@given(
    before=st.integers(200, 3000),
    seconds=st.integers(1, 20_000),
    boot=st.integers(0, 300),
    lost=st.integers(0, 50),
    others=st.integers(1, 3),
)
def test_over_a_reconnect_a_ribbon_that_began_anew(before, seconds, boot, lost, others):
    wire = Wire()
    wire.frames(before)
    wire.restart(after=seconds * 10**6)
    wire.pass_by(boot * PERIOD)
    wire.timeline.reconnected()
    for _ in range(others):
        wire.other()
    wire.frames(lost, arrive=False)
    wire.frames(5)
    assert wire.timeline.restarts == 1
    assert wire.timeline.lost == lost
    assert all(b > a for a, b in pairwise(wire.t))
    gap = wire.t[before] - wire.t[before - 1]
    assert gap == pytest.approx(seconds + (boot + lost + 1) * 0.01)


# At about 15.26 frames per second clock and numbers begin anew together, and always agree.
RATES = st.floats(5.0, 1000.0) | st.floats(15.0, 15.5)


@given(**STARTS, others=st.integers(0, 3), rate=RATES)
@example(clock=60_000_000, sequence=900, others=0, rate=15.0)
def test_a_ribbon_that_began_anew_on_the_same_line(clock, sequence, others, rate):
    wire = Wire(clock + 10 * CLOCK, sequence, rate)
    wire.frames(100)
    already = wire.clock % CLOCK
    wire.restart(after=300_000)
    for _ in range(others):
        wire.other()
    wire.frames(5)
    # A clock and numbers that happen to go on are no restart that anyone could see.
    seen = 1 if already > 2 * 10**6 and CLOCK - already > 4 * 10**6 else wire.timeline.restarts
    assert wire.timeline.restarts == seen
    assert all(b > a for a, b in pairwise(wire.t))


@pytest.mark.parametrize("rate", [15, 100])
def test_frames_that_waited_in_a_buffer_are_not_lost(rate):
    wire = Wire(rate=rate)
    wire.frames(10)
    # The program is halted for two minutes: four seconds are kept, the rest is lost.
    late = wire.host + 120.0
    for _ in range(4 * rate):
        wire.frames(1, delay=late - wire.host - 1 / rate)
    wire.frames(115 * rate, arrive=False)
    wire.frames(rate)
    assert wire.timeline.restarts == 0
    assert wire.timeline.lost == 115 * rate


def test_a_frame_that_came_already_is_not_taken_twice():
    timeline = Timeline(RATE)
    assert timeline.frame(7, 1000, 0.0).t == 0.0
    assert timeline.frame(7, 1000, 0.0) is None
    assert timeline.frame(8, 11_000, 0.01).t == pytest.approx(0.01)
    assert timeline.lost == 0


def test_a_clock_that_stands_still_still_grows():
    timeline = Timeline(RATE)
    times = [timeline.frame(n, 500, n / RATE).t for n in range(5)]
    assert all(b > a for a, b in pairwise(times))


@pytest.mark.parametrize("silent", [0.0, 5.0, 653.0, 660.0, 700.0])
def test_a_pause_loses_nothing(silent):
    wire = Wire()
    wire.frames(50)
    wire.pass_by(round(silent * 1e6))
    wire.other()
    wire.frames(50)
    assert wire.timeline.lost == 0
    assert wire.timeline.restarts == 0


@given(
    st.lists(
        st.tuples(
            st.booleans(), st.integers(0, 65535), st.integers(0, CLOCK - 1), st.floats(0, 1e5)
        ),
        max_size=30,
    )
)
def test_whatever_comes_time_grows(packets):
    timeline, host, last, taken = Timeline(RATE), 0.0, -1.0, 0
    for is_frame, sequence, clock, pause in packets:
        host += pause
        lost = timeline.lost
        if not is_frame:
            timeline.other(sequence)
            continue
        step = timeline.frame(sequence, clock, host)
        if step is not None:
            assert step.t > last
            assert timeline.lost == lost + step.lost >= lost
            last, taken = step.t, taken + 1
