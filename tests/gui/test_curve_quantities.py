"""What is drawn along a pass, as numbers alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from georibbon.gui.curve_quantities import Run, closest, stems, thinned

values = arrays.arrays(
    np.float64, st.integers(1, 400), elements=st.floats(-1e3, 1e3) | st.just(float("nan"))
)


@given(values, st.integers(8, 100))
def test_thinning_loses_no_peak_and_no_end(y, most):
    x = np.arange(len(y), dtype=np.float64)
    thin_x, thin_y = thinned(x, y, most)
    assert len(thin_x) <= max(most, 4)
    assert np.all(np.diff(thin_x) > 0)
    assert (thin_x[0], thin_x[-1]) == (x[0], x[-1])
    assert np.array_equal(thin_y, y[thin_x.astype(int)], equal_nan=True)
    if np.isfinite(y).any():
        assert np.nanmax(thin_y) == np.nanmax(y)
        assert np.nanmin(thin_y) == np.nanmin(y)


@given(values)
def test_what_is_short_is_not_thinned(y):
    x = np.arange(len(y), dtype=np.float64)
    assert thinned(x, y, 400) == (x, y) or len(y) > 400


@given(st.integers(1, 6), st.integers(1, 12))
def test_stems_stand_side_by_side_within_their_room(passes, sensors):
    s = np.repeat(0.03 * np.arange(sensors), 3)
    runs = [Run(s, np.ones(len(s)), ("x",) * len(s)) for _ in range(passes)]
    drawn = stems(runs, 0.024)
    places = np.sort(np.concatenate([x[::2] for x, _ in drawn]))
    assert len(np.unique(np.round(places, 9))) == 3 * sensors * passes
    for x, y in drawn:
        assert np.all(np.abs(x[::2] - s) <= 0.012)
        assert np.array_equal(y, np.tile([0.0, 1.0], len(s)))


def test_between_points_a_run_is_straight_and_by_sensors_it_is_the_nearest():
    run = Run(np.array([0.0, 1.0, 2.0]), np.array([0.0, np.nan, 4.0]))
    assert run.at(1.0) == (1.0, pytest.approx(2.0), "")
    sensors = Run(np.array([0.0, 1.0, 1.0]), np.array([5.0, 1.0, -3.0]), ("A1x", "A2x", "A2y"))
    assert sensors.at(0.9) == (1.0, -3.0, "A2y")
    assert sensors.at(0.1) == (0.0, 5.0, "A1x")
    place, value, name = Run(np.array([0.0]), np.array([np.nan]), ("A1x",)).at(0.3)
    assert (place, name) == (0.3, "")
    assert np.isnan(value)


def test_the_closest_step():
    assert closest(np.array([0.0, 0.0, 0.05, 0.02])) == pytest.approx(0.02)
    assert closest(np.array([0.3])) == 0.01
