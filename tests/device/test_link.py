"""The link: every frame arrives or is counted, every state is told with its reason."""

import errno
import threading
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from fake import RIBBON, DirectPort, FakeRibbon, PtyCable, TcpCable, open_files, settled

from georibbon.device import handshake
from georibbon.device.frames import pack_frame
from georibbon.device.identity import Identity, write_identity
from georibbon.device.link import Link, LinkState, LinkTiming
from georibbon.device.packets import FRAME, IDENTITY, MESSAGE
from georibbon.device.ports import PortInfo, SerialPort
from georibbon.device.telling import MOST_EVENTS, Listeners
from georibbon.errors import DeviceError
from waiting import wait_until

QUICK = LinkTiming(answer=5.0, stall=0.3, retry_first=0.01, retry_last=0.03)
HASTY = replace(QUICK, answer=0.25, tries=2)


class Told:
    """What a link tells."""

    def __init__(self, link):
        self.changes, self.events = [], []
        link.on_change(self.changes.append)
        link.on_event(self.events.append)

    def states(self):
        return [change.state for change in self.changes]

    def reasons(self):
        return [change.reason for change in self.changes]

    def messages(self, kind):
        return [event.message for event in self.events if event.kind == kind]


class Socket:
    """Where ports open: into the ribbon that is plugged in, if any."""

    def __init__(self, ribbon):
        self.ribbon, self.ports = ribbon, []

    def __call__(self, url, _baudrate):
        if self.ribbon is None:
            raise DeviceError(f'there is no port "{url}"')
        self.ports.append(DirectPort(self.ribbon))
        return self.ports[-1]

    def pull(self):
        self.ribbon = None
        self.ports[-1].gone.set()


def link_to(plugged, timing=QUICK, **more):
    """A link to a fake ribbon, what it tells, and the socket between them."""
    at = Socket(plugged)
    link = Link("fake", timing=timing, open_port=at, list_ports=list, **more)
    return link, Told(link), at


def streams(link, frames=10):
    """Wait until so many more frames have come."""
    goal = link.health().frames + frames
    wait_until(lambda: link.health().frames >= goal and link.state == "streaming")


def accounted(link, ribbon, before):
    """Wait until all that the ribbon sent, `before` the identity aside, is packets or lost."""
    ribbon.mute.set()
    wait_until(lambda: link.health().packets + link.health().lost == ribbon.sent - before)
    return link.health()


# Frames.


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_frames_come_over_a_cable(kind, tmp_path):
    ribbon = FakeRibbon()
    cable = PtyCable(ribbon, tmp_path / "ribbon") if kind == "pty" else TcpCable(ribbon)
    if kind == "pty":
        cable.plug()
    link = Link(cable.url, timing=QUICK)
    tap, told = link.recorder(), Told(link)
    with link:
        assert link.wait_for_identity(20.0) == Identity(RIBBON, "1.4.0")
        streams(link, 100)
        health = accounted(link, ribbon, 1)
    frames = tap.take()
    assert len(frames) == health.frames == ribbon.frames
    assert [int(frame.counts[0]) for frame in frames] == list(range(1, len(frames) + 1))
    clocks = [(clock - ribbon.clocks[0]) * 1e-6 for clock in ribbon.clocks]
    assert [frame.t for frame in frames] == pytest.approx(clocks, abs=1e-9)
    assert all(a.arrived <= b.arrived for a, b in pairwise(frames))
    assert (health.lost, health.damaged, health.stalls, health.reconnects) == (0, 0, 0, 0)
    assert told.states() == ["opening", "opening", "streaming", "disconnected"]
    assert told.reasons()[1] == 'the ribbon "GR-0007" (firmware 1.4.0) answers'
    wait_until(lambda: ribbon.commands == ["stop", "identify", "start", "stop"])
    cable.pull()
    if kind == "tcp":
        cable.close()


def test_what_is_damaged_or_dropped_is_lost_and_nothing_else():
    ribbon = FakeRibbon()
    ribbon.damage, ribbon.drop = {10, 11, 40}, {20, 50, 51, 52}
    link, _, _ = link_to(ribbon)
    tap = link.recorder()
    with link:
        streams(link, 100)
        health = accounted(link, ribbon, 1)
    assert (health.lost, health.damaged) == (7, 3)
    assert len(tap.take()) == health.frames == ribbon.frames - 7


def test_a_frame_of_another_length_is_damaged_and_told_once():
    ribbon = FakeRibbon()
    link, told, _ = link_to(ribbon)
    with link:
        streams(link)
        ribbon.says += [(FRAME, b"1234567"), (FRAME, b"")]
        streams(link)
        health = accounted(link, ribbon, 1)
    assert (health.lost, health.damaged) == (2, 2)
    (refused,) = told.messages("refused")
    assert refused.startswith(f"a frame of 7 bytes came, {4 + 2 * len(RIBBON.columns)} are what")


def test_an_unknown_packet_is_skipped_and_counted():
    ribbon = FakeRibbon()
    link, _, _ = link_to(ribbon)
    with link:
        streams(link)
        ribbon.says += [(0x77, b"?"), (0x05, b"")]
        streams(link)
        health = accounted(link, ribbon, 1)
    assert (health.unknown, health.lost) == (2, 0)


def test_what_the_line_held_before_is_dropped():
    ribbon = FakeRibbon()
    ribbon._streaming = True
    link, _, _ = link_to(ribbon)
    tap = link.recorder()
    with link:
        streams(link)
    frames = tap.take()
    assert frames[0].t == 0.0
    assert link.health().lost == 0


def test_what_came_before_the_first_identity_is_nobodys():
    """A ribbon that heeds "stop" late, and says something first."""
    ribbon = FakeRibbon()
    heard = ribbon._answer

    def late(line):
        said = ribbon.packet(MESSAGE, b"booted") + ribbon.frame() if line == "stop" else b""
        return said + heard(line)

    ribbon._answer = late
    link, told, _ = link_to(ribbon)
    tap = link.recorder()
    with link:
        streams(link)
        accounted(link, ribbon, 3)
    assert told.messages("message") == ["booted"]
    frames = tap.take()
    assert int(frames[0].counts[0]) == 2
    assert frames[0].t == 0.0


def test_a_packet_that_comes_twice_is_one_frame():
    ribbon = FakeRibbon()
    once, repeated = ribbon.packet, set()

    def twice(kind, payload):
        data = once(kind, payload)
        if kind != FRAME or repeated:
            return data
        repeated.add(1)
        return data + data

    ribbon.packet = twice
    link, _, _ = link_to(ribbon)
    tap = link.recorder()
    with link:
        streams(link, 20)
        health = accounted(link, ribbon, 1)
    assert (health.lost, health.damaged, health.restarts) == (0, 1, 0)
    assert [int(frame.counts[0]) for frame in tap.take()] == list(range(1, ribbon.frames + 1))


def test_a_slow_reader_misses_and_the_recorder_does_not():
    ribbon = FakeRibbon()
    link, _, _ = link_to(ribbon, capacity=20)
    tap, reader = link.recorder(), link.ring.reader()
    with link:
        streams(link, 100)
        health = accounted(link, ribbon, 1)
    got = reader.take()
    assert len(got) == 20
    assert reader.missed == health.frames - 20
    assert len(tap.take()) == health.frames
    assert tap.closed


def test_health_tells_the_frames_of_the_last_second():
    ribbon = FakeRibbon()
    link, _, _ = link_to(ribbon)
    with link:
        streams(link, 220)
        wait_until(lambda: 190.0 <= link.health().frames_per_second <= 210.0)
        ribbon.mute.set()
        wait_until(lambda: link.health().frames_per_second == 0.0)


# What the ribbon is asked and says.


def test_the_rate_is_asked_for_and_another_one_is_told():
    ribbon = FakeRibbon()
    link, told, _ = link_to(ribbon, rate=90.0)
    with link:
        assert link.wait_for_identity(20.0).ribbon.rate == 100.0
        streams(link)
        assert link.identity.ribbon.rate == 100.0
    assert told.messages("rate") == ["90 frames/s were asked for; the ribbon sends 100"]
    assert ribbon.commands[:5] == ["stop", "identify", "rate 90", "identify", "start"]


def test_the_rate_holds_though_the_answer_to_it_was_not_kept(monkeypatch):
    """More comes while the identity is awaited than is kept: the first is, the second is not."""
    monkeypatch.setattr(handshake, "MOST_HELD", 2)
    link, _, _ = link_to(FakeRibbon(), rate=50.0)
    with link:
        assert link.wait_for_identity(20.0).ribbon.rate == 50.0
        streams(link)
        assert link.identity.ribbon.rate == 50.0
        assert link._intake._timeline.rate == 50.0


def test_a_rate_that_it_has_is_no_news():
    link, told, _ = link_to(FakeRibbon(), rate=50.0)
    with link:
        assert link.wait_for_identity(20.0).ribbon.rate == 50.0
        streams(link)
    assert told.events == []


def test_messages_are_told_as_one_printable_line():
    ribbon = FakeRibbon()
    ribbon.says.append((MESSAGE, b"booted"))
    link, told, _ = link_to(ribbon)
    with link:
        streams(link)
        ribbon.says += [(MESSAGE, b"\x1b[31mhot\n\xff"), (MESSAGE, b"x" * 4000), (MESSAGE, b"")]
        wait_until(lambda: len(told.events) >= 4)
    said = told.messages("message")
    assert said[:2] == ["booted", "[31mhot \ufffd"]
    assert said[2:] == ["x" * 300, "(an empty message)"]


def test_a_ribbon_that_says_the_same_again_is_told_now_and_then(monkeypatch):
    ribbon = FakeRibbon()
    link, told, _ = link_to(ribbon)
    with link:
        streams(link)
        ribbon.says += [(MESSAGE, b"battery low")] * 50
        streams(link, 20)
        assert told.messages("message") == ["battery low"]
        monkeypatch.setattr("georibbon.device.intake.REPEATED", 0.0)
        ribbon.says += [(MESSAGE, b"battery low"), (MESSAGE, b"booted")]
        wait_until(lambda: len(told.messages("message")) == 3)
    assert told.messages("message") == ["battery low", "battery low (50 times)", "booted"]


def test_a_ribbon_that_says_too_much():
    ribbon = FakeRibbon()
    link, told, _ = link_to(ribbon)
    with link:
        streams(link)
        ribbon.says += [(MESSAGE, b"help %d" % n) for n in range(2000)]
        streams(link, 20)
        wait_until(lambda: link.health().packets > 2000)
        health = accounted(link, ribbon, 1)
    assert health.lost == 0
    said = told.messages("message")
    assert said[:2] == ["help 0", "help 1"]
    assert "more than is told" in said[19]
    assert len(said) < 1000


def test_what_a_ribbon_says_hides_nothing_else():
    listeners, events = Listeners(), []
    listeners.events.append(events.append)
    for n in range(100):
        listeners.happened("message", f"help {n}")
    for kind in ("restarted", "refused", "rate"):
        listeners.happened(kind, f"it is {kind}")
    assert {"it is restarted", "it is refused", "it is rate"} <= {one.message for one in events}


def test_a_ribbon_that_restarts_without_end_is_told_so_within_bounds():
    listeners, events = Listeners(), []
    listeners.events.append(events.append)
    began = time.monotonic()
    for _ in range(2000):
        listeners.happened("restarted", "anew")
    seconds = int(time.monotonic() - began) + 2
    assert len(events) <= seconds * MOST_EVENTS
    assert "more of this kind" in events[MOST_EVENTS - 1].message


def test_a_ribbon_that_stalls_is_asked_again():
    ribbon = FakeRibbon()
    link, told, _ = link_to(ribbon)
    with link:
        streams(link)
        ribbon.mute.set()
        wait_until(lambda: link.state == LinkState.STALLED)
        wait_until(lambda: ribbon.commands.count("start") >= 3)
        ribbon.mute.clear()
        streams(link)
        health = accounted(link, ribbon, 1)
    assert told.states()[2:5] == ["streaming", "stalled", "streaming"]
    assert "nothing comes; asking again" in told.reasons()[3]
    assert (health.stalls, health.lost, health.restarts) == (1, 0, 0)


def test_a_start_that_was_not_heard_is_said_again():
    ribbon = FakeRibbon()
    heard = ribbon._answer

    def hard_of_hearing(line):
        first = line == "start" and "start" not in ribbon.commands
        return (
            heard("stop" if first else line) if not first else ribbon.commands.append(line) or b""
        )

    ribbon._answer = hard_of_hearing
    link, told, _ = link_to(ribbon)
    with link:
        streams(link)
    assert told.states()[:4] == ["opening", "opening", "stalled", "streaming"]


def test_bytes_that_are_no_packets_while_frames_are_due():
    ribbon = FakeRibbon()
    link, told, at = link_to(ribbon)
    with link:
        streams(link)
        ribbon.mute.set()
        at.ports[-1].read = lambda: time.sleep(0.001) or b"noise"
        wait_until(lambda: link.state == LinkState.STALLED)
    assert "bytes come, but no frames" in told.reasons()[3]


# Cables.


@pytest.mark.parametrize("battery", [True, False])
def test_twenty_times_unplugged_and_plugged_in(battery, tmp_path):
    threads, files = threading.active_count(), len(open_files())
    ribbon = FakeRibbon(battery=battery)
    cable = PtyCable(ribbon, tmp_path / "ribbon")
    cable.plug()
    link = Link(cable.url, timing=QUICK)
    tap, told = link.recorder(), Told(link)
    with link:
        streams(link)
        for _ in range(20):
            cable.pull()
            wait_until(lambda: link.state == LinkState.DISCONNECTED)
            cable.plug()
            streams(link)
        ribbon.mute.set()
        if battery:
            health = accounted(link, ribbon, 1)
        else:
            wait_until(lambda: link.health().frames_per_second == 0.0)
            health = link.health()
    cable.pull()
    frames = tap.take()
    assert health.reconnects == 20
    assert len(frames) == health.frames
    assert all(b.t > a.t for a, b in pairwise(frames))
    assert told.states().count("disconnected") >= 21
    assert health.restarts == (0 if battery else 20)
    # With a battery nothing is unaccounted for; without, at most what was on the line.
    assert health.frames <= ribbon.frames <= health.frames + health.lost + (0 if battery else 200)
    wait_until(lambda: settled(threads, files))


def test_losses_over_a_replug_are_counted_exactly():
    ribbon = FakeRibbon()
    link, _, at = link_to(ribbon)
    tap = link.recorder()
    with link:
        for _ in range(20):
            streams(link)
            at.pull()
            before = ribbon.sent
            wait_until(lambda: link.state == LinkState.DISCONNECTED)
            at.ribbon = ribbon
            wait_until(lambda before=before: ribbon.sent > before + 5)
        streams(link)
        health = accounted(link, ribbon, 1)
    frames = tap.take()
    assert len(frames) == health.frames
    assert health.lost >= 20
    # Each frame carries its number: none twice, none invented.
    numbers = [int(frame.counts[0]) for frame in frames]
    assert numbers == sorted(set(numbers))
    clocks = [(ribbon.clocks[n - 1] - ribbon.clocks[0]) * 1e-6 for n in numbers]
    assert [frame.t for frame in frames] == pytest.approx(clocks, abs=1e-9)


def test_frames_before_the_second_identity_are_not_thrown_away():
    """A ribbon that does not heed "stop", and says late who it is: they are its frames."""
    ribbon = FakeRibbon()
    link, _, at = link_to(ribbon)
    tap = link.recorder()
    with link:
        streams(link)
        at.pull()
        wait_until(lambda: link.state == LinkState.DISCONNECTED)
        heard, asked = ribbon._answer, []
        ribbon._answer = lambda line: heard(line) if line == "start" else asked.append(line) or b""
        at.ribbon = ribbon
        wait_until(lambda: asked == ["stop", "identify"])
        before = ribbon.frames
        wait_until(lambda: ribbon.frames >= before + 20)
        ribbon.says.append((IDENTITY, write_identity(Identity(RIBBON, "1.4.0"))))
        streams(link)
        health = accounted(link, ribbon, 1)
    numbers = [int(frame.counts[0]) for frame in tap.take()]
    assert health.reconnects == 1
    assert len(numbers) == health.frames
    assert set(range(before + 1, ribbon.frames + 1)) <= set(numbers)


def test_what_a_ribbon_loses_after_it_began_anew_is_counted():
    ribbon = FakeRibbon(battery=False)
    ribbon.drop = {3}  # the first frame of each life
    link, _, at = link_to(ribbon)
    with link:
        streams(link, 50)
        assert link.health().lost == 1
        at.pull()
        wait_until(lambda: link.state == LinkState.DISCONNECTED)
        at.ribbon = ribbon
        streams(link, 20)
        wait_until(lambda: link.health().restarts == 1)
    assert link.health().lost == 2


def test_a_slow_ribbon_does_not_stall():
    ribbon = FakeRibbon(replace(RIBBON, rate=2.0))
    link, _, _ = link_to(ribbon, replace(QUICK, stall=0.05))
    with link:
        streams(link, 2)
    assert link.health().stalls == 0


def test_it_is_found_again_under_another_name():
    ribbon, names = FakeRibbon(), ["/dev/ttyACM0"]
    ports = []

    def opening(url, _baudrate):
        if url not in names:
            raise DeviceError(f'there is no port "{url}"')
        ports.append((url, DirectPort(ribbon)))
        return ports[-1][1]

    def listing():
        return [PortInfo(name, "Ribbon", "0007", 1, 2) for name in names]

    link = Link("/dev/ttyACM0", timing=QUICK, open_port=opening, list_ports=listing)
    with link:
        streams(link)
        names.clear()
        ports[-1][1].gone.set()
        wait_until(lambda: link.state == LinkState.DISCONNECTED)
        names.append("/dev/ttyACM3")
        streams(link)
        health = accounted(link, ribbon, 1)
    assert [name for name, _ in ports] == ["/dev/ttyACM0", "/dev/ttyACM3"]
    assert health.reconnects == 1


def test_a_port_of_the_same_device_that_does_not_open_is_passed_over():
    ribbon, names = FakeRibbon(), ["/dev/ttyACM0"]
    opened = []

    def opening(url, _baudrate):
        opened.append(url)
        if url == "/dev/ttyACM3":
            raise DeviceError("in use")
        return DirectPort(ribbon)

    def listing():
        return [PortInfo(name, "Ribbon", "0007", 1, 2) for name in names]

    link = Link("/dev/ttyACM0", timing=QUICK, open_port=opening, list_ports=listing)
    with link:
        streams(link)
        names[:] = ["/dev/ttyACM3"]
        link._finder.opened("/dev/ttyACM3")
        ribbon.says.append((IDENTITY, b"nonsense"))
        wait_until(lambda: link.health().reconnects == 1)
    assert opened == ["/dev/ttyACM0", "/dev/ttyACM3", "/dev/ttyACM0"]


def test_another_ribbon_is_refused_until_the_right_one_is_back():
    ribbon, other = FakeRibbon(), FakeRibbon(replace(RIBBON, id="GR-0009"))
    link, told, at = link_to(ribbon)
    tap = link.recorder()
    with link:
        streams(link)
        at.pull()
        wait_until(lambda: link.state == LinkState.DISCONNECTED)
        at.ribbon = other
        wait_until(lambda: other.commands.count("identify") > 2)
        with pytest.raises(DeviceError, match='"GR-0009" answers; "GR-0007" is expected'):
            link.wait_for_identity(20.0)
        assert link.identity.ribbon.id == "GR-0007"
        at.ribbon = ribbon
        streams(link)
        frames = link.health().frames
    assert len(tap.take()) >= frames > 0
    assert other.frames == 0
    assert len(told.messages("refused")) == 1
    assert all(port.closed.is_set() for port in at.ports)


@pytest.mark.parametrize(
    ("expected", "words"),
    [
        ({"ribbon_id": "GR-0009"}, '"GR-0007" answers; "GR-0009" is expected'),
        ({"ribbon": replace(RIBBON, id="GR-0009")}, '"GR-0007" answers; "GR-0009" is expected'),
        ({"ribbon": replace(RIBBON, length=0.6)}, "has other sensors than it had"),
    ],
)
def test_who_is_expected_may_be_said_beforehand(expected, words):
    link, told, _ = link_to(FakeRibbon(), **expected)
    with link, pytest.raises(DeviceError, match=words):
        link.wait_for_identity(20.0)
    assert told.states()[:2] == ["opening", "disconnected"]
    assert link.identity is None


def test_an_identity_that_changes_under_way_is_refused():
    ribbon = FakeRibbon()
    link, told, _ = link_to(ribbon)
    tap = link.recorder()
    other = write_identity(Identity(replace(RIBBON, id="GR-0009"), "1.4.0"))
    strange = pack_frame(0, np.full(len(RIBBON.columns), -7, dtype=np.int16))
    with link:
        streams(link)
        ribbon.says += [(IDENTITY, other), (FRAME, strange)]
        wait_until(lambda: "disconnected" in told.states())
        streams(link)
        ribbon.says.append((IDENTITY, b"nonsense"))
        wait_until(lambda: told.states().count("disconnected") == 2)
        streams(link)
    assert '"GR-0009" answers; "GR-0007" is expected' in told.messages("refused")[0]
    assert any("it is no JSON text" in reason for reason in told.reasons())
    assert link.health().reconnects == 2
    assert all(frame.counts[0] > 0 for frame in tap.take())


# What does not answer.


def test_nothing_answers():
    ribbon = FakeRibbon(answers=False)
    link, told, _ = link_to(ribbon, HASTY)
    with link:
        with pytest.raises(DeviceError, match=r'^"fake": nothing answers within 0\.5 s'):
            link.wait_for_identity(20.0)
        wait_until(lambda: ribbon.commands.count("identify") > 4)
    # Told once, however often it is tried.
    assert told.states() == ["opening", "disconnected", "disconnected"]


def test_bytes_that_are_no_packets():
    link, _, at = link_to(FakeRibbon(answers=False), HASTY)
    at.ribbon.due = lambda: b"\x80\xfe\x00\x06"
    with link, pytest.raises(DeviceError, match=r"\d+ bytes came that are no packets; the baud"):
        link.wait_for_identity(20.0)
    assert link.health().bytes > 0
    assert link.health().damaged == 0


def test_packets_but_no_identity():
    ribbon = FakeRibbon(answers=False)
    ribbon.says.append((MESSAGE, b"hello"))
    link, _, _ = link_to(ribbon, HASTY)
    with link, pytest.raises(DeviceError, match="1 packet came, but no identity"):
        link.wait_for_identity(20.0)


def test_an_identity_that_is_too_long():
    ribbon = FakeRibbon(answers=False)
    link, _, at = link_to(ribbon, HASTY)
    at.ribbon.due = lambda: b"\x01" * 5000 + b"\0"
    with link, pytest.raises(DeviceError, match="of more than 4096 bytes came"):
        link.wait_for_identity(20.0)


def test_an_identity_that_cannot_be_read():
    ribbon = FakeRibbon(answers=False)
    ribbon.says.append((IDENTITY, b'{"protocol": 2}'))
    link, _, _ = link_to(ribbon)
    with link, pytest.raises(DeviceError, match="version 2 of the protocol, this program"):
        link.wait_for_identity(20.0)


def test_a_port_that_is_not_there_and_comes_later():
    link, told, at = link_to(None)
    with link:
        with pytest.raises(DeviceError, match=r'^there is no port "fake"$'):
            link.wait_for_identity(20.0)
        at.ribbon = FakeRibbon()
        streams(link)
        assert link.wait_for_identity(0.0).ribbon == RIBBON
    assert told.states() == ["opening", "disconnected", "opening", "streaming", "disconnected"]
    assert link.health().reconnects == 0


def test_an_identity_is_waited_for_no_longer_than_asked():
    link, _, _ = link_to(FakeRibbon(answers=False))
    with link, pytest.raises(DeviceError, match=r'^opening "fake"$'):
        link.wait_for_identity(0.05)
    with pytest.raises(DeviceError, match="the link was stopped"):
        link.wait_for_identity(20.0)


@pytest.mark.parametrize(
    "more",
    [
        {"rate": 0.0},
        {"rate": float("nan")},
        {"rate": 10_001.0},
        {"baudrate": 0},
        {"baudrate": 10**9},
    ],
)
def test_numbers_that_mean_nothing(more):
    with pytest.raises(DeviceError, match="expected"):
        Link("fake", **more)


def test_a_url_that_means_nothing():
    with pytest.raises(DeviceError, match="of no kind known"):
        Link("http://ribbon.example:80")


# Stop.


class Blocking(DirectPort):
    """A port whose driver hangs in one call until it is let go."""

    def __init__(self, ribbon, where):
        super().__init__(ribbon)
        self.hangs, self.let_go = threading.Event(), threading.Event()
        self.armed = threading.Event()
        free = getattr(self, where)

        def hang(*arguments):
            if self.armed.is_set():
                self.hangs.set()
                self.let_go.wait()
            return free(*arguments)

        setattr(self, where, hang)


@pytest.mark.parametrize("where", ["read", "write", "drop", "close"])
def test_stop_does_not_wait_for_a_driver_that_hangs(where):
    threads = threading.active_count()
    port = Blocking(FakeRibbon(), where)
    link = Link("fake", timing=QUICK, open_port=lambda *_: port, list_ports=list)
    told = Told(link)
    if where in ("write", "drop"):
        port.armed.set()
    link.start()
    if where in ("read", "close"):
        streams(link)
        port.armed.set()
    if where == "close":
        port.gone.set()
    assert port.hangs.wait(20.0)
    link.stop()
    assert link.state == LinkState.DISCONNECTED
    assert told.reasons()[-1] == "the link was stopped"
    assert link._thread.is_alive()
    port.let_go.set()
    assert port.closed.wait(20.0)
    wait_until(lambda: threading.active_count() <= threads)
    assert told.reasons()[-1] == "the link was stopped"


def test_a_port_that_opens_after_the_stop_is_closed_again():
    opening, let_go = threading.Event(), threading.Event()
    ribbon = FakeRibbon()
    port = DirectPort(ribbon)

    def open_slowly(*_):
        opening.set()
        let_go.wait()
        return port

    link = Link("fake", timing=QUICK, open_port=open_slowly, list_ports=list)
    link.start()
    assert opening.wait(20.0)
    link.stop()
    let_go.set()
    assert port.closed.wait(20.0)
    link._thread.join()
    assert ribbon.commands == []


def test_stop_while_the_rate_is_asked_for():
    ribbon = FakeRibbon()
    heard = ribbon._answer
    ribbon._answer = lambda line: heard(line) if len(ribbon.commands) < 3 else b""
    link, _, _ = link_to(ribbon, rate=50.0)
    link.start()
    wait_until(lambda: "rate 50" in ribbon.commands)
    link.stop()
    link._thread.join()
    assert link.identity is None


def test_stop_ends_the_waits():
    link, _, _ = link_to(FakeRibbon(answers=False))
    link.start()
    failures = []

    def wait():
        try:
            link.wait_for_identity(60.0)
        except DeviceError as error:
            failures.append(str(error))

    thread = threading.Thread(target=wait)
    thread.start()
    link.stop()
    thread.join()
    link._thread.join()
    assert len(failures) == 1


def test_stop_twice_and_before_the_start():
    link, told, _ = link_to(FakeRibbon())
    link.stop()
    link.stop()
    assert told.reasons() == ["the link was stopped"]


def test_stop_from_a_callback():
    link, told, _ = link_to(FakeRibbon())
    link.on_change(lambda change: link.stop() if change.state == "streaming" else None)
    link.start()
    link._thread.join(20.0)
    assert not link._thread.is_alive()
    assert told.states()[-1] == "disconnected"


# Faults.


def test_a_callback_that_fails_stops_nothing(monkeypatch):
    caught = []
    monkeypatch.setattr(threading, "excepthook", caught.append)
    link, told, _ = link_to(FakeRibbon())
    link._listeners.changes.insert(0, lambda _: 1 / 0)
    with link:
        streams(link, 50)
    assert {args.exc_type for args in caught} == {ZeroDivisionError}
    assert told.states() == ["opening", "opening", "streaming", "disconnected"]


def test_a_fault_of_the_program_is_not_hidden(monkeypatch):
    caught = []
    monkeypatch.setattr(threading, "excepthook", caught.append)

    def faulty(*_):
        raise KeyError("a fault")

    link = Link("fake", timing=QUICK, open_port=faulty, list_ports=list)
    with link, pytest.raises(DeviceError, match="a fault of the program ended the link"):
        link.wait_for_identity(20.0)
    assert [args.exc_type for args in caught] == [KeyError]


def test_a_fault_of_the_program_leaves_nobody_waiting(monkeypatch):
    """What came before can be taken; who waits for more learns that none will come."""
    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    link, _, at = link_to(FakeRibbon())
    tap = link.recorder()
    with link:
        streams(link)
        at.ports[-1].read = lambda: {}["a fault"]
        wait_until(lambda: tap.closed)
        assert link.state == LinkState.DISCONNECTED
        assert len(tap.take()) == link.health().frames
        assert link.recorder().closed


def test_the_last_change_is_told_by_the_thread_that_stops_it():
    link, told, _ = link_to(FakeRibbon())
    threads = []
    link.on_change(lambda _: threads.append(threading.current_thread()))
    with link:
        streams(link)
    assert told.reasons()[-1] == "the link was stopped"
    assert threads[-1] is threading.current_thread()
    assert set(threads[:-1]) == {link._thread}


class Line:
    """What pyserial opens, with a ribbon in it and an unplug that the driver notices its way."""

    def __init__(self, ribbon):
        self._port, self._held, self.error = DirectPort(ribbon), b"", None
        self.write, self.close = self._port.write, self._port.close
        self.reset_input_buffer = self._port.drop

    @property
    def in_waiting(self):
        if self.error:
            raise self.error
        self._held += self._port.read()
        return len(self._held)

    def read(self, size):
        data, self._held = self._held[:size], self._held[size:]
        return data


@pytest.mark.parametrize(
    "error", [OSError(errno.EIO, "Input/output error"), TypeError("an integer is required")]
)
def test_an_unplug_that_shows_in_in_waiting(error):
    ribbon, lines = FakeRibbon(), []

    def opening(*_):
        lines.append(Line(ribbon))
        return SerialPort(lines[-1])

    link = Link("fake", timing=QUICK, open_port=opening, list_ports=list)
    told = Told(link)
    with link:
        streams(link)
        lines[-1].error = error
        wait_until(lambda: len(lines) == 2)
        streams(link)
        health = accounted(link, ribbon, 1)
    assert health.reconnects == 1
    assert "the port vanished: was the cable pulled?" in told.reasons()[3]
