"""Frames on the wire and as readings."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.device.frames import CLOCK, LOST, Frame, pack_frame, readings_of, unpack_frame

COUNTS = st.lists(st.integers(-32768, 32767), min_size=1, max_size=40)


@given(st.integers(0, 3 * CLOCK), COUNTS)
def test_a_frame_comes_back(microseconds, values):
    counts = np.array(values, dtype=np.int16)
    payload = pack_frame(microseconds, counts)
    clock, found = unpack_frame(payload, len(values))
    assert clock == microseconds % CLOCK
    assert found.tolist() == values
    assert found.flags.writeable


@given(st.binary(max_size=60), st.integers(1, 30))
def test_another_length_is_no_frame(payload, columns):
    found = unpack_frame(payload, columns)
    assert (found is None) == (len(payload) != 4 + 2 * columns)


def test_the_bytes_are_those_of_the_protocol():
    assert pack_frame(0x01020304, np.array([1, -2], dtype=np.int16)) == b"\4\3\2\1\1\0\xfe\xff"


def test_readings_begin_at_zero_and_name_what_was_lost():
    frames = [
        Frame(5.0, np.array([1, LOST], dtype=np.int16), 0.0),
        Frame(5.01, np.array([-32767, 32767], dtype=np.int16), 0.1),
    ]
    readings = readings_of(frames)
    assert readings.t == pytest.approx([0.0, 0.01])
    assert np.array_equal(readings.counts, [[1.0, np.nan], [-32767.0, 32767.0]], equal_nan=True)
