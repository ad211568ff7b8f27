"""Sensors that do not agree: magnets are told and named, and nothing else is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lying import curve, lying

from georibbon.capture.disturbance import expected_without, find_disturbed, names_of
from georibbon.capture.live import LiveFit
from georibbon.fitting.grid import integrate_frames
from georibbon.fitting.sensing import Noise, SensorArray, observe
from georibbon.fitting.strip import (
    StripProblem,
    fit_strips,
    linearise,
    predict,
    sensed_vectors,
    whiten,
)
from georibbon.world import field_direction

TWO, THREE = lying(32, axes=2), lying(32, axes=3)
POSITIONS = np.array([sensor.position for sensor in TWO.ribbon.sensors])


def magnet(strength, middle, reach=0.12, direction=(0.8, -0.36, 0.48)):
    """(n, 3) a field that is flat over the magnet and steep at its ends."""
    share = strength * np.exp(-(((POSITIONS - middle) / reach) ** 6))
    return share[:, None] * np.array(direction)


def named(lay, shape, seed, added=None):
    told = LiveFit(lay.ribbon, lay.calibration).update(
        lay.counts(shape, seed, added), lay.sigma, 0.15
    )
    return {one.sensor: one for one in told.disturbed}


def seen_by(lay, shape, added):
    """By the names of the magnetometers near the magnet, what they see of it, of the field."""
    frames = integrate_frames(lay.grid, shape)[0, lay.grid.sensor_nodes]
    near = [i for i in lay.ribbon.indices("magnetometer") if np.linalg.norm(added[i]) > 0.01]
    return {
        lay.ribbon.sensors[i].name: np.linalg.norm(
            lay.calibration.sensors[i].gain @ frames[i].T @ added[i]
        )
        / lay.ribbon.sensors[i].counts_per_unit
        for i in near
    }


@settings(max_examples=30)
@given(
    st.tuples(*[st.floats(-0.7, 0.7)] * 3),
    st.floats(-1.0, 2.0),
    st.integers(0, 1000),
    st.sampled_from([TWO, THREE]),
)
def test_where_nothing_is_wrong_nothing_is_named(start, bend, seed, lay):
    assert named(lay, curve(lay.grid, start, 0.4, bend), seed) == {}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("strength", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("lay", [TWO, THREE])
def test_a_magnet_near_four_magnetometers_is_told_and_named(lay, strength, seed):
    rng = np.random.default_rng(seed)
    shape = curve(lay.grid, rng.uniform(-0.5, 0.5, 3), 0.3, rng.uniform(0.2, 1.5))
    added = magnet(strength, 0.495)
    found = named(lay, shape, seed, added)
    seen = seen_by(lay, shape, added)
    assert {name for name, share in seen.items() if share > 0.1} <= set(found)
    assert {name for name, one in found.items() if one.grade == "bad"} <= {*seen}
    assert all(found[name].grade == "bad" for name, share in seen.items() if share > 0.25)
    assert len(set(found) - set(seen)) <= 2
    assert all("magnet" in one.reason and one.sensor in one.reason for one in found.values())


@pytest.mark.parametrize("lay", [TWO, THREE])
def test_a_weak_magnet_makes_suspects(lay):
    found = named(lay, curve(lay.grid), 1, magnet(0.08, 0.495, direction=(0.0, 1.0, 0.0)))
    assert found
    assert {one.grade for one in found.values()} == {"suspect"}
    assert all(one.share > 0.04 or one.degrees > 4.0 for one in found.values())


def test_three_axes_tell_the_strength_also_where_all_are_alike():
    """A field of another strength everywhere leaves all directions right."""
    field = field_direction(np.radians(62.0))
    found = named(THREE, curve(THREE.grid), 1, 0.07 * np.tile(field, (32, 1)))
    assert set(found) == set(THREE.sensors("magnetometer"))
    assert all(one.share == pytest.approx(0.07, abs=0.01) for one in found.values())
    assert all("strength" in one.reason for one in found.values())


def test_a_knocked_accelerometer_is_named_too():
    counts = TWO.counts(curve(TWO.grid), 1)
    where = TWO.ribbon.slices[10]
    counts[where] += 16384.0 * np.array([0.15, -0.2, 0.1])
    told = LiveFit(TWO.ribbon, TWO.calibration).update(counts, TWO.sigma, 0.15)
    assert names_of(told.disturbed) == (TWO.ribbon.sensors[10].name,)
    assert "lies flat" in told.disturbed[0].reason


def problem_without(lay, counts, left_out=()):
    array = SensorArray.of(lay.ribbon, lay.calibration)
    counts = counts.copy()
    for i in left_out:
        counts[lay.ribbon.slices[i]] = np.nan
    observed = observe(lay.ribbon, array, counts[None], lay.sigma[None])
    vectors = sensed_vectors(array, field_direction(lay.calibration.dip))
    return StripProblem(lay.grid, array, observed, vectors, Noise())


@pytest.mark.parametrize("lay", [TWO, THREE])
@pytest.mark.parametrize("i", [1, 9, 16, 31])
def test_what_is_expected_is_what_the_fit_says_without_the_sensor_and_its_neighbours(lay, i):
    shape = curve(lay.grid, (0.2, -0.1, 0.4))
    counts = lay.counts(shape, 7)
    problem, smoothing = problem_without(lay, counts), np.array([1e-4])
    strips = fit_strips(problem, shape, smoothing)
    white = whiten(problem, strips.shape)
    linear = linearise(problem, strips.shape, white)
    expected = expected_without(problem, linear, strips.normal, white)
    group = [k for k in (i - 2, i, i + 2) if 0 <= k < 32]
    alone = problem_without(lay, counts, group)
    refitted = fit_strips(alone, strips.shape, smoothing)
    _, residuals = predict(problem, integrate_frames(lay.grid, refitted.shape))
    np.testing.assert_allclose(expected.deleted[i], residuals[0, i], atol=1.5e-3)


def test_a_sensor_that_says_nothing_is_not_named():
    counts = TWO.counts(curve(TWO.grid), 1, magnet(0.5, 0.48))
    silent = [i for i in range(32) if abs(POSITIONS[i] - 0.48) < 0.15]
    problem = problem_without(TWO, counts, silent)
    strips = fit_strips(problem, curve(TWO.grid), np.array([1e-4]))
    white = whiten(problem, strips.shape)
    linear = linearise(problem, strips.shape, white)
    expected = expected_without(problem, linear, strips.normal, white)
    assert find_disturbed(TWO.ribbon, problem, expected) == ()
    np.testing.assert_array_equal(expected.size[silent], 0.0)
