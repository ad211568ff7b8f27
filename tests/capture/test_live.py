"""The live curve: the same as the cold fit's, wherever the ribbon comes from."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lying import curve, lying

from georibbon.capture.live import OFTEN, POOR, SOON, LiveFit
from georibbon.errors import FitError
from georibbon.fitting.candidates import find_candidates
from georibbon.fitting.grid import Shape, integrate_frames
from georibbon.fitting.sensing import Noise, SensorArray, observe
from georibbon.fitting.smoothing import information_density, length_of_weight, weight_of_length
from georibbon.fitting.strip import StripProblem, fit_strips, sensed_vectors
from georibbon.rotations import about_z
from georibbon.world import field_direction

TWO, THREE = lying(axes=2), lying(axes=3)
GRID = TWO.grid
LENGTH = 0.1
attitudes = st.tuples(*[st.floats(-0.9, 0.9)] * 3)


def problem_of(lay, counts):
    """The cold fit's problem for one reading."""
    array = SensorArray.of(lay.ribbon, lay.calibration)
    observed = observe(lay.ribbon, array, counts[None], lay.sigma[None])
    vectors = sensed_vectors(array, field_direction(lay.calibration.dip))
    return StripProblem(lay.grid, array, observed, vectors, Noise())


def followed(lay, shapes, *, smoothing=LENGTH, fit=None, seed=1):
    """The last curve after readings of several shapes, one update each."""
    fit = fit or LiveFit(lay.ribbon, lay.calibration)
    for shape in shapes:
        told = fit.update(lay.counts(shape, seed), lay.sigma, smoothing)
    return told


def away(told, lay, shape):
    """Metres between the curve's points and the true ones, the greatest."""
    return np.linalg.norm(told.strip.points - lay.points(shape), axis=1).max()


# --- against the cold fit and the truth ---


@settings(max_examples=20)
@given(attitudes, st.floats(-1.5, 1.5), st.floats(-2.0, 2.0), st.sampled_from([TWO, THREE]))
def test_without_noise_the_curve_is_the_true_one(start, twist, bend, lay):
    truth = curve(lay.grid, start, twist, bend)
    fit = LiveFit(lay.ribbon, lay.calibration)
    told = fit.update(lay.counts(truth), lay.sigma, 0.05)
    assert away(told, lay, truth) < 1e-3
    np.testing.assert_allclose(told.strip.frames, integrate_frames(GRID, truth)[0], atol=0.02)
    assert told.misfit < 0.2
    assert told.disturbed == ()


@settings(max_examples=12)
@given(attitudes, st.integers(0, 100), st.sampled_from([TWO, THREE]))
def test_the_warm_fit_is_the_cold_fit(start, seed, lay):
    """Led from one shape to another, it ends where a fit of the last readings alone does."""
    fit = LiveFit(lay.ribbon, lay.calibration)
    for k in (0, 1, 2, 3, 4, 5, 5):
        counts = lay.counts(curve(lay.grid, start, 0.1 * k, 1.0 + 0.15 * k), seed)
        told = fit.update(counts, lay.sigma, LENGTH)
    problem = problem_of(lay, counts)
    weight = weight_of_length(np.array([LENGTH]), information_density(problem))
    cold = fit_strips(problem, curve(lay.grid, start, 0.5, 1.75), weight)
    frames = integrate_frames(lay.grid, cold.shape)[0]
    np.testing.assert_allclose(told.strip.frames, frames, atol=1e-3)
    present = np.isfinite(told.residuals)
    assert present.all()
    np.testing.assert_allclose(told.residuals, np.sqrt(cold.squares[0]), atol=0.05)
    assert told.smoothing == pytest.approx(LENGTH)


def test_left_to_itself_it_smooths_as_the_evidence_says():
    counts = TWO.counts(curve(GRID), 3)
    told = LiveFit(TWO.ribbon, TWO.calibration).update(counts, TWO.sigma)
    cold = find_candidates(problem_of(TWO, counts), np.array([np.nan]))[0]
    frames = integrate_frames(GRID, cold.shape)[0]
    np.testing.assert_allclose(told.strip.frames, frames, atol=1e-6)
    assert GRID.nodes[-1] / 20 < told.smoothing < 1.01 * GRID.nodes[-1]


@pytest.mark.parametrize("lay", [TWO, THREE])
def test_the_standard_deviation_is_honest(lay):
    """Over many layings the end is off by what is predicted, and the start by nothing."""
    truth = curve(lay.grid, (0.2, -0.3, 0.5))
    end, misses, sigmas = lay.points(truth)[-1], [], []
    fit = LiveFit(lay.ribbon, lay.calibration)
    for seed in range(60):
        told = fit.update(lay.counts(truth, seed), lay.sigma, 0.3)
        misses.append(np.linalg.norm(told.strip.points[-1] - end))
        sigmas.append(told.sigma[-1])
        np.testing.assert_allclose(told.sigma**2, np.trace(told.covariance, axis1=1, axis2=2))
    assert told.sigma[0] == 0.0
    assert 0.7 < np.sqrt(np.mean(np.square(misses)) / np.mean(np.square(sigmas))) < 1.3


# --- the frame of reference ---


@settings(max_examples=10)
@given(st.floats(-3.0, 3.0), attitudes)
def test_turning_ribbon_and_field_about_the_vertical_turns_the_curve(angle, start):
    truth = curve(GRID, start)
    turned = Shape(about_z(angle) @ truth.start, truth.rates)
    one = followed(THREE, [truth], seed=None)
    other = followed(THREE, [turned], seed=None)
    expected = one.strip.points @ about_z(angle).T
    np.testing.assert_allclose(other.strip.points, expected, atol=3e-4)
    np.testing.assert_allclose(other.normal_curvature, one.normal_curvature, atol=0.02)


def test_curvature_and_torsion_are_those_of_the_curve():
    told = followed(TWO, [curve(GRID, (0.1, 0.4, -0.6), 1.0, 1.5)])
    s, frames = told.strip.s, told.strip.frames
    slope = np.gradient(frames, s, axis=0)[2:-2]
    tangent, across, normal = (frames[2:-2, :, k] for k in range(3))
    bending = np.sum(slope[:, :, 0] * normal, axis=1)
    torsion = np.sum(slope[:, :, 1] * normal, axis=1)
    np.testing.assert_allclose(told.normal_curvature[2:-2], bending, atol=0.04)
    np.testing.assert_allclose(told.geodesic_torsion[2:-2], torsion, atol=0.04)
    np.testing.assert_allclose(np.sum(slope[:, :, 0] * across, axis=1), 0.0, atol=0.04)
    steps = np.diff(told.strip.points, axis=0)
    along = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    np.testing.assert_allclose(np.sum(along[2:-1] * tangent, axis=1), 1.0, atol=1e-3)
    np.testing.assert_array_equal(told.strip.points[0], 0.0)


# --- lifted and laid elsewhere ---


@pytest.mark.parametrize("lay", [TWO, THREE])
@pytest.mark.parametrize("seed", range(6))
def test_laid_elsewhere_it_is_found_again(lay, seed):
    rng = np.random.default_rng(seed)
    first = curve(lay.grid, rng.uniform(-0.8, 0.8, 3), 0.3, 1.0)
    second = curve(lay.grid, rng.uniform(-2.5, 2.5, 3), *rng.uniform(-2.0, 2.0, 2))
    fit = LiveFit(lay.ribbon, lay.calibration)
    assert followed(lay, [first] * 3, fit=fit).settled
    at_once = followed(lay, [second], fit=fit)
    assert not at_once.settled
    later = followed(lay, [second] * (SOON + 2), fit=fit)
    assert later.settled
    assert away(later, lay, second) < 0.02
    assert later.misfit < 1.2


@pytest.mark.parametrize(("lay", "counts"), [(TWO, 25.0), (THREE, 15.0)])
def test_readings_that_cost_more_than_usual_are_not_settled_until_all_was_tried(lay, counts):
    """Not so dear that any place would be called poor: the rise alone tells it."""
    truth = curve(lay.grid)
    fit = LiveFit(lay.ribbon, lay.calibration)
    assert followed(lay, [truth] * 3, fit=fit).settled
    noise = counts * np.random.default_rng(3).standard_normal(len(lay.sigma))
    risen = [fit.update(lay.counts(truth, 1) + noise, lay.sigma, LENGTH) for _ in range(5)]
    assert 1.0 < risen[-1].misfit < np.sqrt(POOR)
    assert away(risen[-1], lay, truth) < 0.05
    assert not any(one.settled for one in risen)
    later = [fit.update(lay.counts(truth, 1) + noise, lay.sigma, LENGTH) for _ in range(SOON + 2)]
    assert later[-1].settled


def false_minimum(lay):
    """A reading, and a shape from which the fit ends in a minimum that is not the least."""
    truth = curve(lay.grid, (0.0, 0.0, 0.0), 0.2, 3.0)
    rng = np.random.default_rng(0)
    problem = problem_of(lay, lay.counts(truth, 1))
    weight = weight_of_length(np.array([LENGTH]), information_density(problem))
    best = fit_strips(problem, truth, weight)
    while True:
        start = curve(lay.grid, rng.uniform(-3.0, 3.0, 3), *rng.uniform(-4.0, 4.0, 2))
        wrong = fit_strips(problem, start, weight)
        if wrong.cost[0] > best.cost[0] + 100.0:
            return truth, wrong.shape


def test_out_of_a_false_minimum_it_comes_by_itself():
    truth, wrong = false_minimum(TWO)
    fit = LiveFit(TWO.ribbon, TWO.calibration)
    followed(TWO, [wrong] * 2, fit=fit)
    told = followed(TWO, [truth] * (SOON + 2), fit=fit)
    assert away(told, TWO, truth) < 0.02
    assert told.settled


def test_the_mirror_twin_on_a_wall_is_called_ambiguous():
    """Level along a vertical wall, 2-axis magnetometers leave two shapes; 3-axis ones do not."""
    wall = np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    level = Shape((about_z(0.8) @ wall)[None], np.zeros((1, 2, GRID.coefficients)))
    square = [lying(axes=axes, mounting=0.0, cross_axis=0.0, soft_iron=0.0) for axes in (2, 3)]
    assert [followed(lay, [level]).ambiguous for lay in square] == [True, False]
    assert not followed(square[0], [curve(GRID)]).ambiguous


def test_a_twin_is_found_out_also_later_on():
    """First on a curve that is no riddle, then level along a wall."""
    wall = np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    level = Shape((about_z(0.8) @ wall)[None], np.zeros((1, 2, GRID.coefficients)))
    square = lying(axes=2, mounting=0.0, cross_axis=0.0, soft_iron=0.0)
    fit = LiveFit(square.ribbon, square.calibration)
    assert not followed(square, [curve(GRID)], fit=fit).ambiguous
    assert followed(square, [level] * (OFTEN + 8), fit=fit).ambiguous
    assert not followed(square, [curve(GRID)] * (OFTEN + 8), fit=fit).ambiguous


def test_left_to_itself_its_smoothing_follows_the_readings():
    straight, wavy = curve(GRID, None, 0.0, 0.0), curve(GRID, None, 3.0, 5.0)
    fit = LiveFit(THREE.ribbon, THREE.calibration)
    first = followed(THREE, [straight], smoothing=None, fit=fit)
    again = followed(THREE, [straight] * 5, smoothing=None, fit=fit)
    assert again.smoothing == pytest.approx(first.smoothing)
    later = followed(THREE, [wavy] * (OFTEN + 8), smoothing=None, fit=fit)
    assert later.smoothing < 0.7 * first.smoothing
    problem = problem_of(THREE, THREE.counts(wavy, 1))
    found = find_candidates(problem, np.array([np.nan]))[0].smoothing[0]
    cold = length_of_weight(found, information_density(problem))
    assert later.smoothing == pytest.approx(cold, rel=0.15)


# --- lost values ---


def test_lost_and_saturated_sensors_are_left_out():
    truth = curve(GRID)
    counts = TWO.counts(truth, 2)
    counts[TWO.ribbon.slices[4]] = np.nan
    counts[TWO.ribbon.slices[7].start] = 32767.0
    told = LiveFit(TWO.ribbon, TWO.calibration).update(counts, TWO.sigma, LENGTH)
    assert np.flatnonzero(np.isnan(told.residuals)).tolist() == [4, 7]
    assert away(told, TWO, truth) < 0.015


def test_sensors_that_the_calibration_leaves_out_are_left_out():
    models = tuple(
        replace(model, used=model.name not in ("A03", "M05")) for model in TWO.calibration.sensors
    )
    fit = LiveFit(TWO.ribbon, replace(TWO.calibration, sensors=models))
    told = fit.update(TWO.counts(curve(GRID), 2), TWO.sigma, LENGTH)
    names = [TWO.ribbon.sensors[i].name for i in np.flatnonzero(np.isnan(told.residuals))]
    assert names == ["A03", "M05"]


@pytest.mark.parametrize("kind", ["accelerometer", "magnetometer"])
def test_too_few_sensors_are_told(kind):
    counts = TWO.counts(curve(GRID), 2)
    for i in TWO.ribbon.indices(kind)[2:]:
        counts[TWO.ribbon.slices[i]] = np.nan
    with pytest.raises(FitError, match=f"2 {kind}s say something"):
        LiveFit(TWO.ribbon, TWO.calibration).update(counts, TWO.sigma)
