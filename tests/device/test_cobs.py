"""Stuffing: nothing is lost, no zero is left, and any bytes are read or refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.device.cobs import StuffingError, stuff, unstuff

# Many zeros, and runs about as long as the longest.
PIECES = st.lists(st.sampled_from([b"\0", b"\1", b"\xff", bytes(range(1, 255)), b"ab" * 126]))
BYTES = st.binary(max_size=600) | PIECES.map(b"".join)


@given(BYTES)
def test_what_was_stuffed_comes_back(data):
    stuffed = stuff(data)
    assert 0 not in stuffed
    assert len(stuffed) <= len(data) + len(data) // 254 + 1
    assert unstuff(stuffed) == data


@given(BYTES)
def test_any_bytes_are_read_or_refused(data):
    try:
        read = unstuff(data)
    except StuffingError:
        return
    assert len(read) < len(data)
    assert unstuff(stuff(read)) == read


@pytest.mark.parametrize(
    ("data", "stuffed"),
    [
        (b"", b"\1"),
        (b"\0", b"\1\1"),
        (b"\0\0", b"\1\1\1"),
        (b"\x11\x22\0\x33", b"\3\x11\x22\2\x33"),
        (bytes(range(1, 255)), b"\xff" + bytes(range(1, 255)) + b"\1"),
        (bytes(range(1, 256)), b"\xff" + bytes(range(1, 255)) + b"\2\xff"),
    ],
)
def test_stuffed_by_hand(data, stuffed):
    assert stuff(data) == stuffed
    assert unstuff(stuffed) == data


def test_the_empty_run_after_a_longest_one_may_be_left_out():
    assert unstuff(b"\xff" + bytes(range(1, 255))) == bytes(range(1, 255))


@pytest.mark.parametrize("data", [b"", b"\2", b"\3a", b"\2a\0", b"\0"])
def test_refused(data):
    with pytest.raises(StuffingError):
        unstuff(data)
