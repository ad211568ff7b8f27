"""The ring counts what a slow reader misses; a tap misses nothing."""

import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.device.frames import Frame
from georibbon.device.ring import Outlets, Ring, Tap

NONE = np.zeros(0, dtype=np.int16)


def frames(start, count):
    return [Frame(float(n), NONE, 0.0) for n in range(start, start + count)]


def times(taken):
    return [round(frame.t) for frame in taken]


@given(
    st.integers(1, 12),
    st.lists(st.tuples(st.sampled_from(["write", "one", "other"]), st.integers(0, 9)), max_size=40),
)
def test_each_frame_is_taken_or_missed_once(capacity, actions):
    ring, written = Ring(capacity), 0
    readers = {name: (ring.reader(), []) for name in ("one", "other")}
    for what, count in [*actions, ("one", 0), ("other", 0)]:
        if what == "write":
            ring.append(frames(written, count))
            written += count
            continue
        reader, got = readers[what]
        missed = reader.missed
        new = times(reader.take())
        begin = len(got) + missed
        begin += reader.missed - missed
        assert new == list(range(begin, written))
        assert len(new) <= capacity
        got += new
    for reader, got in readers.values():
        assert len(got) + reader.missed == written
    assert times(ring.last(5)) == list(range(written))[-min(5, capacity) :]


def test_a_reader_begins_with_what_comes_after_it():
    ring = Ring(4)
    ring.append(frames(0, 3))
    reader = ring.reader()
    assert reader.take() == []
    assert not reader.wait(0.0)
    ring.append(frames(3, 2))
    assert reader.wait(0.0)
    assert times(reader.take()) == [3, 4]
    assert times(ring.last(100)) == [1, 2, 3, 4]
    assert ring.last(0) == []


def test_an_empty_ring_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        Ring(0)


def test_a_writer_and_readers_at_once():
    outlets = Outlets(50)
    tap, reader, got, total = outlets.tap(), outlets.ring.reader(), [], 20_000

    def read():
        while len(got) + reader.missed < total:
            reader.wait(0.1)
            got.extend(times(reader.take()))

    thread = threading.Thread(target=read)
    thread.start()
    for start in range(0, total, 4):
        outlets.append(frames(start, 4))
    thread.join()
    assert got == sorted(set(got))
    assert len(got) + reader.missed == total
    assert times(tap.take()) == list(range(total))


def test_a_tap_keeps_all_until_it_is_closed():
    outlets = Outlets(2)
    outlets.append(frames(0, 3))
    tap = outlets.tap()
    assert not tap.wait(0.0)
    outlets.append(frames(3, 5))
    assert tap.wait(0.0)
    tap.close()
    outlets.append(frames(8, 2))
    assert tap.closed
    assert times(tap.take()) == [3, 4, 5, 6, 7]
    assert tap.take() == []


def test_who_waits_at_a_tap_is_woken_by_its_end():
    outlets = Outlets(2)
    tap, woken = outlets.tap(), threading.Event()

    def wait():
        tap.wait(60.0)
        woken.set()

    thread = threading.Thread(target=wait)
    thread.start()
    outlets.close()
    assert woken.wait(20.0)
    thread.join()
    assert tap.closed


def test_a_closed_tap_takes_nothing_in():
    tap = Tap()
    tap.close()
    tap.append(frames(0, 2))
    assert tap.take() == []
