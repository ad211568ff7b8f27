"""What the raw view shows of a ribbon's frames: kept for seconds, judged, thinned."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from georibbon.device.frames import LOST, Frame
from georibbon.gui.connect.raw import RawReadings
from georibbon.gui.connect.sensor_plot import thinned
from georibbon.ribbon import Ribbon, Sensor

RATE = 100.0
RIBBON = Ribbon(
    "GR-0007",
    0.4,
    RATE,
    tuple(
        Sensor(f"{'AM'[k % 2]}{k:02}", kind, axes, 0.05 * (k + 1), 1000.0)
        for k, (kind, axes) in enumerate([("accelerometer", 3), ("magnetometer", 2)] * 3)
    ),
)
STILL = np.array([0, 0, 1000, 400, -300] * 3)  # of the ribbon's columns


def frames_of(counts, start=0):
    return [
        Frame((start + k) / RATE, np.asarray(row, dtype=np.int16), 0.0)
        for k, row in enumerate(counts)
    ]


def still(count, seed=1):
    """(count, c) a ribbon at rest: 2 counts of noise."""
    return STILL + np.random.default_rng(seed).normal(0.0, 2.0, (count, STILL.size)).round()


def test_values_are_in_units_with_their_length_and_noise():
    state = RawReadings(RIBBON).feed(frames_of(still(100)))
    np.testing.assert_allclose(state.values, STILL / 1000.0, atol=0.01)
    np.testing.assert_allclose(state.norm, [1.0, 0.5] * 3, atol=0.02)
    np.testing.assert_allclose(state.noise, 0.002, rtol=0.5)
    assert state.words == ("",) * 6
    assert not state.flashing.any()


def test_nothing_is_told_before_the_first_frame():
    assert RawReadings(RIBBON).feed([]) is None


@given(st.lists(st.integers(1, 400), max_size=12))
def test_however_the_frames_come_the_last_ten_seconds_are_kept(sizes):
    readings = RawReadings(RIBBON)
    count = 0
    for size in sizes:
        rows = [STILL + (count + k) % 50 for k in range(size)]
        readings.feed(frames_of(rows, count))
        count += size
    t, values = readings.values(0)
    expected = np.arange(max(0, count - 1000), count)
    assert len(t) == len(expected)
    np.testing.assert_allclose(t, (expected - (count - 1)) / RATE, atol=1e-9)
    np.testing.assert_allclose(values[:, 0], (STILL[0] + expected % 50) / 1000.0)


def test_lost_saturated_and_stuck_sensors_are_named():
    counts = still(60)
    counts[30, 0] = LOST
    counts[:, 3] = 32767
    counts[:, 5:8] = 0
    state = RawReadings(RIBBON).feed(frames_of(counts))
    assert state.words == ("lost", "saturated", "stuck", "", "", "")


def test_a_sensor_without_any_value_breaks_nothing():
    counts = still(60)
    counts[:, 0:3] = LOST
    state = RawReadings(RIBBON).feed(frames_of(counts))
    assert np.isnan(state.values[:3]).all()
    assert state.words[0] == "lost"
    assert np.isfinite(state.noise).all()


def test_a_tapped_sensor_flashes_alone_and_not_for_ever():
    for sensor in range(6):
        readings = RawReadings(RIBBON)
        readings.feed(frames_of(still(100)))
        tapped = still(4, 2)
        tapped[2, RIBBON.slices[sensor].start] += 400
        state = readings.feed(frames_of(tapped, 100))
        assert list(np.flatnonzero(state.flashing)) == [sensor]
        for start in range(104, 304, 4):
            state = readings.feed(frames_of(still(4, start), start))
        assert not state.flashing.any()


def test_nothing_flashes_where_the_whole_ribbon_moves():
    readings = RawReadings(RIBBON)
    readings.feed(frames_of(still(100)))
    moved = still(8, 2) + 400
    assert not readings.feed(frames_of(moved, 100)).flashing.any()


@given(
    st.integers(0, 5000),
    st.integers(1, 50),
    st.integers(0, 2**32 - 1),
)
def test_thinning_keeps_every_peak(count, bins, seed):
    x = np.arange(count, dtype=float)
    y = np.random.default_rng(seed).normal(size=(count, 3))
    few, kept = thinned(x, y, bins)
    assert len(few) == len(kept) <= max(2 * count // max(count // bins, 1), 2 * bins) + 2
    assert (np.diff(few) > 0).all()
    if len(few) != count:
        size = count // bins
        inside = y[count % size :]
        np.testing.assert_array_equal(kept.max(axis=0), inside.max(axis=0))
        np.testing.assert_array_equal(kept.min(axis=0), inside.min(axis=0))


def test_thinning_keeps_what_is_lost_lost():
    y = np.full((100, 1), np.nan)
    y[50:] = 1.0
    _, kept = thinned(np.arange(100.0), y, 10)
    assert np.isnan(kept[:10]).all()
    assert (kept[10:] == 1.0).all()
