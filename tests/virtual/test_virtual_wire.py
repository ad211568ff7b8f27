"""The ribbon's side of the protocol: commands, packets, the clock, and what the cable does."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import SMALL, clocks_of, packets_in, said, world_of

from georibbon.device.identity import read_identity
from georibbon.device.packets import DONE, FRAME, IDENTITY, MESSAGE, PacketReader
from georibbon.errors import DeviceError, SettingsError
from georibbon.virtual import VirtualSettings
from georibbon.virtual.wire import LONGEST_LINE, MOST_WAITING, LineReader
from waiting import wait_until


def kinds(packets):
    return [packet.type for packet in packets]


def answer(world, command):
    """Type and text of the one answer to a command."""
    (packet,) = said(world, command)
    return packet.type, packet.payload.decode()


def test_it_says_who_it_is():
    world = world_of(firmware="2.7.1")
    (packet,) = said(world, b"identify\n")
    assert packet.type == IDENTITY
    identity = read_identity(packet.payload)
    assert identity.ribbon == world.ribbon
    assert identity.firmware == "2.7.1"


def test_start_and_stop_are_answered_and_frames_come_in_between():
    world = world_of()
    assert said(world, b"", 1.0) == []
    packets = said(world, b"start\n", 1.0)
    assert kinds(packets) == [DONE] + [FRAME] * 100
    assert packets[0].payload == b"start"
    (done,) = said(world, b"stop\n", 1.0)
    assert (done.type, done.payload) == (DONE, b"stop")


def test_a_second_start_changes_nothing():
    world = world_of()
    said(world, b"start\n", 0.505)
    packets = said(world, b"start\n", 0.5)
    assert kinds(packets) == [DONE] + [FRAME] * 50
    assert np.diff(clocks_of(packets, world)).tolist() == [10000] * 49


@pytest.mark.parametrize(
    ("asked", "given_rate"),
    [("100", 100), ("1", 10), ("22", 20), ("23", 25), ("151", 200), ("1e3", 400), ("50.0", 50)],
)
def test_the_nearest_rate_is_taken_and_told(asked, given_rate):
    world = world_of()
    assert answer(world, f"rate {asked}\n".encode()) == (DONE, f"rate {asked}")
    (identity,) = said(world, b"identify\n")
    assert read_identity(identity.payload).ribbon.rate == given_rate
    frames = said(world, b"start\n", 2.0)[1:]
    assert len(frames) == 2 * given_rate
    step = np.diff(clocks_of(frames, world))
    assert np.abs(step - 1e6 / given_rate).max() <= 1.0


def test_the_ribbons_own_rate_is_one_it_has():
    world = world_of(replace(SMALL, ribbon=replace(SMALL.ribbon, rate=83.0)))
    said(world, b"rate 400\nrate 80\n")
    assert world.ribbon.rate == 83.0


def test_a_new_rate_holds_at_once_while_frames_come():
    world = world_of()
    said(world, b"start\n", 1.0)
    packets = said(world, b"rate 50\n", 1.0)
    assert kinds(packets) == [DONE] + [FRAME] * 50


@pytest.mark.parametrize("words", ["rate", "rate x", "rate -5", "rate 0", "rate nan", "rate inf"])
def test_a_rate_that_means_nothing_is_refused(words):
    kind, text = answer(world_of(), words.encode() + b"\n")
    assert kind == MESSAGE
    assert words in text


@pytest.mark.parametrize("words", [b"hello", b"start now", b"IDENTIFY", b"\xff\xfe", b"x" * 500])
def test_what_is_no_command_is_answered_by_a_message(words):
    world = world_of()
    kind, text = answer(world, words + b"\n")
    assert kind == MESSAGE
    assert "unknown command" in text
    assert answer(world, b"stop\n") == (DONE, "stop")


@given(st.lists(st.integers(0, 60), max_size=8))
def test_commands_may_come_in_pieces_and_with_any_line_ends(cuts):
    data = b"\r\nidentify\r\n\n\nstop\n\0rate 50\r\r\nstart\n"
    reader, lines = LineReader(), []
    edges = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    for a, b in pairwise(edges):
        lines += reader.feed(data[a:b])
    assert lines == ["identify", "stop", "rate 50", "start"]


@given(st.lists(st.binary(max_size=200), max_size=10))
def test_garbage_is_bounded_and_a_line_after_it_is_read(pieces):
    reader = LineReader()
    for piece in pieces:
        reader.feed(piece)
        assert len(reader._rest) <= LONGEST_LINE
    reader.feed(b"\n")
    assert reader.feed(b"stop\n") == ["stop"]


@given(st.lists(st.binary(max_size=60), max_size=6))
def test_no_bytes_of_a_host_do_harm(pieces):
    world = TALKATIVE
    for piece in pieces:
        world.receive(piece)
        packets_in(world.take_all())
    world.receive(b"\nstop\n")
    assert packets_in(world.take_all())[-1].payload == b"stop"


TALKATIVE = world_of()


def test_sequence_numbers_have_no_gap_and_wrap_and_so_does_the_clock():
    world = world_of(first_sequence=65500, power_up=2**32 - 250_000)
    packets = said(world, b"identify\nstart\nrate 100\n", 1.0)
    numbers = [packet.sequence for packet in packets]
    assert numbers == [(65500 + k) % 65536 for k in range(len(packets))]
    clocks = clocks_of(packets, world)
    assert clocks == [(2**32 - 250_000 + 10_000 * k) % 2**32 for k in range(1, 101)]


def test_frames_keep_to_the_clock_however_the_time_goes_by():
    world, rng = world_of(), np.random.default_rng(2)
    world.receive(b"start\n")
    data = world.take_all()
    for pause in rng.uniform(0.0, 0.06, 400):
        world.advance(float(pause))
        world.catch_up()
        data += world.take_all()
    clocks = clocks_of(packets_in(data), world)
    assert len(clocks) > 1000
    assert clocks == [10_000 * k for k in range(1, len(clocks) + 1)]


def test_what_is_due_next_is_told():
    world = world_of()
    assert world.catch_up() == float("inf")
    world.receive(b"start\n")
    assert world.catch_up() == pytest.approx(0.01)
    world.advance(0.004)
    assert world.catch_up() == pytest.approx(0.006)


def test_the_same_words_give_the_same_bytes():
    def story():
        world = world_of(drop=0.1, damage=0.1)
        data = said_raw(world, b"identify\nstart\n", 0.5)
        for words in ("lay P2", "magnet 0.3", "pose 3", "message hello", "lift"):
            world.do(words)
            data += world.run(1.0)
        return data

    assert story() == story()


def said_raw(world, data, seconds):
    world.receive(data)
    return world.take_all() + world.run(seconds)


def test_dropped_packets_leave_exactly_the_gaps_counted():
    world = world_of()
    said(world, b"start\n")
    world.do("drop 0.2")
    packets = said(world, b"", 20.0)
    world.do("drop 0")
    packets += said(world, b"stop\n")
    numbers = [packet.sequence for packet in packets]
    gaps = sum(b - a - 1 for a, b in zip([0, *numbers], numbers, strict=False))
    sent = world.sent
    assert 300 < sent.dropped < 500
    assert gaps == sent.dropped
    assert len(packets) + 1 == sent.whole == sent.packets - sent.dropped


def test_damaged_packets_are_none_and_touch_no_other():
    world = world_of(damage=0.3)
    said(world, b"start\n")
    data = world.run(20.0)
    reader = PacketReader()
    packets = reader.feed(data)
    sent = world.sent
    assert 450 < sent.damaged < 750
    assert reader.damaged == sent.damaged
    assert len(packets) + 1 == sent.whole
    columns = len(world.ribbon.columns)
    plain = world_of()
    said(plain, b"start\n")
    undamaged = {p.sequence: p.payload for p in packets_in(plain.run(20.0))}
    assert all(undamaged[packet.sequence] == packet.payload for packet in packets)
    assert {len(packet.payload) for packet in packets} == {4 + 2 * columns}


def test_a_host_that_does_not_read_loses_frames_but_not_the_clock():
    world = world_of()
    said(world, b"start\n")
    for _ in range(100):
        world.advance(0.1)
        world.catch_up()
    waiting = world.take_all()
    assert len(waiting) <= MOST_WAITING
    kept = packets_in(waiting)
    assert [packet.sequence for packet in kept] == list(range(1, len(kept) + 1))
    assert world.sent.overrun == 1000 - len(kept)
    later = said(world, b"", 0.1)
    assert [packet.sequence for packet in later] == list(range(1001, 1011))
    assert clocks_of(later, world) == [10_000 * k for k in range(1001, 1011)]


def test_after_a_long_sleep_the_missed_frames_are_lost_not_made():
    world = world_of()
    said(world, b"start\n")
    world.advance(3600.0)
    world.catch_up()
    packets = packets_in(world.take_all())
    assert len(packets) + world.sent.overrun == 360_000
    assert world.sent.frames == 360_000
    later = said(world, b"", 0.05)
    assert later[0].sequence == (1 + 360_000) % 65536


def test_stalled_it_is_silent_uses_no_number_and_obeys_afterwards():
    world = world_of()
    said(world, b"start\n", 0.5)
    world.do("stall 2")
    assert said(world, b"identify\n", 1.9) == []
    packets = said(world, b"", 0.6)
    assert kinds(packets)[0] == IDENTITY
    assert [packet.sequence for packet in packets] == list(range(51, 51 + len(packets)))
    assert clocks_of(packets, world)[0] == 2_510_000
    assert world.sent.whole == world.sent.packets


def test_unplugged_it_is_silent_and_replugged_its_numbers_and_clock_go_on():
    world = world_of()
    said(world, b"start\n", 0.5)
    world.do("unplug")
    assert not world.plugged
    assert said(world, b"", 2.0) == []
    world.do("replug")
    assert world.plugged
    assert said(world, b"", 1.0) == []
    packets = said(world, b"start\n", 0.05)
    assert [packet.sequence for packet in packets] == [51, 52, 53, 54, 55, 56]
    assert clocks_of(packets, world)[0] == 3_510_000


def test_it_is_plugged_in_again_by_itself_after_a_while():
    world = world_of()
    world.do("unplug 1.5")
    assert world.catch_up() == pytest.approx(1.5)
    world.advance(1.4)
    world.catch_up()
    assert not world.plugged
    world.advance(0.2)
    world.catch_up()
    assert world.plugged


def test_packets_that_wait_when_the_cable_is_pulled_are_counted():
    world = world_of()
    said(world, b"start\n")
    world.advance(0.2)
    world.catch_up()
    world.do("unplug")
    assert world.take() == b""
    assert world.sent.cut == 20
    assert world.sent.whole == 1


def test_at_a_wrong_baud_rate_there_are_bytes_but_no_packets():
    world = world_of()
    said(world, b"start\n")
    world.do("baud wrong")
    data = said_raw(world, b"identify\nstop\n", 2.0)
    assert len(data) > 10_000
    assert len(set(data)) == 256
    assert PacketReader().feed(data) == []
    assert world.sent.garbled == 201  # the frames, and one complaint
    world.do("baud right")
    assert kinds(said(world, b"stop\n")) == [DONE]


def test_another_identity_is_answered_from_then_on():
    world = world_of()
    assert world.do("identity GR-0099") == "answers as GR-0099"
    (packet,) = said(world, b"identify\n")
    assert read_identity(packet.payload).ribbon.id == "GR-0099"


def test_a_message_is_heard():
    world = world_of()
    world.do("message battery low: 10 %")
    (packet,) = packets_in(world.take_all())
    assert (packet.type, packet.payload) == (MESSAGE, b"battery low: 10 %")


def test_play_waits_for_the_host():
    world = world_of(play=True, hold=0.5)
    said(world, b"identify\n", 5.0)
    assert world.do("status").startswith("in the air")
    said(world, b"start\n", 3.5)
    assert world.do("status").startswith("in pose")
    said(world, b"", 80.0)
    assert world.played.is_set()


def test_a_ribbon_whose_identity_fits_no_packet_is_refused():
    with pytest.raises(DeviceError, match="sensors"):
        world_of(replace(SMALL, ribbon=replace(SMALL.ribbon, sensors=250)))


@pytest.mark.parametrize(
    "setting",
    [
        {"hold": 0.0}, {"pace": -1.0}, {"drop": 1.1}, {"damage": float("nan")}, {"noise": -1.0},
        {"power_up": 2**32}, {"first_sequence": 65536}, {"firmware": ""}, {"firmware": "a\nb"},
    ],
)  # fmt: skip
def test_settings_that_mean_nothing_are_refused(setting):
    with pytest.raises(SettingsError):
        VirtualSettings(**setting)


def test_a_wait_has_an_end():
    with pytest.raises(AssertionError, match="did not come about"):
        wait_until(lambda: False, 0.01)
