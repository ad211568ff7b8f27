"""The ribbon fit of single passes: exact derivatives, exact recovery, symmetries, honesty."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import (
    DIP,
    FLAT,
    both,
    degrees_between,
    lay,
    random_shape,
    ribbon,
    wavy,
    without,
)

from georibbon.fitting.grid import (
    Shape,
    differentiate_frames,
    differentiate_positions,
    integrate_frames,
    integrate_positions,
    make_grid,
)
from georibbon.fitting.sensing import Noise
from georibbon.fitting.smoothing import information_density, weight_of_length
from georibbon.fitting.strip import (
    ROBUST_LIMIT,
    evaluate,
    fit_strips,
    follow_shape,
    linear_cost,
    linear_weights,
    linearise,
    normal_equations,
    predict,
    prior,
    robust_cost,
    robust_weights,
    sensed_vectors,
    squared_residuals,
    whiten,
    whitened_residuals,
)
from georibbon.rotations import about_z, exp, log
from georibbon.world import field_direction

RIBBON = ribbon(16)
GRID = make_grid(RIBBON)
TILTED = exp(np.array([0.4, -0.3, 0.9]))
WEAK = 1e-9


def near(shape, degrees=8.0, rates=0.3, seed=1):
    """A start that is not far off."""
    rng = np.random.default_rng(seed)
    step = rng.normal(size=(len(shape.start), GRID.unknowns))
    step[:, :3] *= np.radians(degrees) / np.sqrt(3)
    step[:, 3:] *= rates
    return shape.moved(step)


def fitted(laid, smoothing=WEAK, start=None):
    shape = laid.shape if start is None else start
    return fit_strips(laid.problem, shape, np.full(len(shape.start), smoothing))


# --- the field and the equations ---


def test_the_field_dips_and_turns_with_the_heading():
    np.testing.assert_allclose(field_direction(DIP), [0, np.cos(DIP), -np.sin(DIP)])
    for heading in (-2.0, 0.3, 1.0):
        np.testing.assert_allclose(
            field_direction(DIP, heading), about_z(-heading) @ field_direction(DIP), atol=1e-15
        )


def test_accelerometers_sense_up_and_magnetometers_the_field():
    laid = lay(RIBBON, wavy(GRID))
    vectors = sensed_vectors(laid.problem.array, np.array([0.6, 0.0, -0.8]))
    np.testing.assert_array_equal(vectors[::2], np.tile([0.0, 0.0, 1.0], (8, 1)))
    np.testing.assert_array_equal(vectors[1::2], np.tile([0.6, 0.0, -0.8], (8, 1)))


@given(st.integers(0, 10**6))
def test_noise_free_readings_leave_no_residual_at_the_truth(seed):
    shape = random_shape(GRID, np.random.default_rng(seed), 2)
    laid = lay(RIBBON, shape, skew_seed=seed)
    directions, residuals = predict(laid.problem, integrate_frames(GRID, shape))
    np.testing.assert_allclose(residuals, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=2), 1.0, atol=1e-12)


@given(st.integers(0, 10**6), st.sampled_from([2, 3]))
def test_derivatives_of_the_readings_are_those_of_differences(seed, axes):
    of, rng = ribbon(16, axes), np.random.default_rng(seed)
    truth = random_shape(GRID, rng, 2)
    laid = lay(of, truth, seed=seed, skew_seed=seed)
    here = near(truth, seed=seed)
    white = whiten(laid.problem, here)
    linear = linearise(laid.problem, here, white)
    x, step = rng.normal(size=(2, GRID.unknowns)), 1e-6

    def residuals(shape):
        _, raw = predict(laid.problem, integrate_frames(GRID, shape))
        return (white @ raw[..., None])[..., 0]

    slope = (residuals(here.moved(step * x)) - residuals(here.moved(-step * x))) / (2 * step)
    expected = np.einsum("bnkm,bm->bnk", linear.rows, x)
    np.testing.assert_allclose(slope, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(linear.residuals, residuals(here), atol=1e-9)
    np.testing.assert_allclose(linear.squares, np.sum(linear.residuals**2, axis=2))
    np.testing.assert_allclose(
        squared_residuals(laid.problem, linear.turns.frames, white), linear.squares, rtol=1e-9
    )


def test_normal_equations_are_those_of_weighted_rows():
    laid = lay(RIBBON, both(wavy(GRID), wavy(GRID, TILTED)), seed=3)
    linear = linearise(laid.problem, laid.shape, whiten(laid.problem, laid.shape))
    weights = np.random.default_rng(1).uniform(0.1, 1.0, linear.squares.shape)
    normal, gradient = normal_equations(linear, weights)
    for b in range(2):
        rows = linear.rows[b].reshape(-1, GRID.unknowns)
        each = np.repeat(weights[b], 3)
        np.testing.assert_allclose(normal[b], rows.T @ (each[:, None] * rows), rtol=1e-9)
        np.testing.assert_allclose(
            gradient[b], rows.T @ (each * linear.residuals[b].ravel()), atol=1e-6
        )


def test_the_prior_is_the_roughness_of_both_rates_and_of_nothing_else():
    shape = random_shape(GRID, np.random.default_rng(4))
    x = np.concatenate([[5.0, 6.0, 7.0], shape.rates.ravel()])
    rough = sum(rate @ GRID.roughness @ rate for rate in shape.rates[0])
    np.testing.assert_allclose(x @ prior(GRID, np.array([2.0]))[0] @ x, 2.0 * rough)


# --- robust weights ---


@pytest.mark.parametrize(
    ("cost", "weights"), [(robust_cost, robust_weights), (linear_cost, linear_weights)]
)
@given(square=st.floats(0.0, 1e6))
def test_the_weight_is_the_derivative_of_the_cost(cost, weights, square):
    step = 1e-6 * max(square, 1.0)
    ahead, behind = cost(np.array([square + step, max(square - step, 0.0)]))
    slope = (ahead - behind) / (square + step - max(square - step, 0.0))
    assert weights(np.array(square)) == pytest.approx(slope, abs=1e-5)


def test_linearly_counted_a_miss_keeps_its_pull_but_does_not_gain():
    size = np.linspace(ROBUST_LIMIT, 100.0, 50)
    np.testing.assert_allclose(linear_weights(size**2) * size, ROBUST_LIMIT)
    assert (linear_cost(size**2) <= size**2).all()
    assert (linear_cost(size**2) >= robust_cost(size**2) - 1e-9).all()


def test_up_to_the_limit_a_sensor_counts_fully_and_beyond_its_pull_falls():
    squares = np.linspace(0.0, ROBUST_LIMIT**2, 10)
    np.testing.assert_array_equal(robust_weights(squares), 1.0)
    np.testing.assert_array_equal(robust_cost(squares), squares)
    size = np.linspace(ROBUST_LIMIT, 100.0, 200)
    pull = robust_weights(size**2) * size
    assert (np.diff(pull) < 0).all()
    assert (np.diff(robust_cost(size**2)) > 0).all()


def test_a_lying_sensor_loses_its_say_but_not_its_name():
    truth = wavy(GRID, TILTED)
    laid = lay(RIBBON, truth, seed=5)
    values = laid.problem.observations.values.copy()
    values[0, 6] = [0.9, 0.1, -0.4]
    observed = replace(laid.problem.observations, values=values)
    spoiled = fitted(replace(laid, problem=replace(laid.problem, observations=observed)), 1e-6)
    clean = fitted(without(laid, RIBBON.sensors[6].name), 1e-6)
    assert int(np.argmax(spoiled.squares[0])) == 6
    assert spoiled.squares[0, 6] > 1000
    apart = degrees_between(
        integrate_frames(GRID, spoiled.shape), integrate_frames(GRID, clean.shape)
    )
    assert apart.max() < 0.1


# --- recovery and symmetries ---


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("skew_seed", [None, 7])
def test_noise_free_readings_give_the_ribbon_back(axes, skew_seed):
    of = ribbon(16, axes)
    truth = both(wavy(GRID, TILTED), wavy(GRID, scale=-1.5), wavy(GRID, exp(np.array([0, 3.0, 0]))))
    laid = lay(of, truth, skew_seed=skew_seed)
    strips = fitted(laid, WEAK * 1e-6, near(truth))
    # 2-axis magnetometers and half as many places as unknowns: the flattest directions are weak.
    apart = degrees_between(integrate_frames(GRID, strips.shape), integrate_frames(GRID, truth))
    assert apart[:, GRID.sensor_nodes].max() < 0.02
    assert strips.squares.max() < 1e-3


def test_strips_of_a_stack_are_fitted_as_by_themselves():
    truth = both(wavy(GRID, TILTED), wavy(GRID, scale=-1.0))
    laid = lay(RIBBON, truth, seed=2)
    together = fit_strips(laid.problem, near(truth), np.array([1e-4, 1e-6]))
    for b in range(2):
        alone = fit_strips(
            laid.problem.take([b]), near(truth).take([b]), np.array([[1e-4], [1e-6]][b])
        )
        np.testing.assert_allclose(together.cost[b], alone.cost[0], rtol=1e-12)
        np.testing.assert_allclose(together.shape.rates[b], alone.shape.rates[0], atol=1e-9)
        part = together.take([b])
        np.testing.assert_array_equal(part.normal[0], together.normal[b])
        np.testing.assert_array_equal(part.smoothing, together.smoothing[b : b + 1])


@pytest.mark.parametrize("heading", [-2.5, 0.7, 3.0])
def test_turning_the_field_turns_the_result(heading):
    """The same readings in axes turned about the vertical: the same curve, turned."""
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=6)
    array = laid.problem.array
    turn = about_z(-heading)
    turned = replace(laid.problem, vectors=sensed_vectors(array, field_direction(DIP, heading)))
    here = fitted(laid, 1e-5)
    start = Shape(turn @ laid.shape.start, laid.shape.rates)
    there = fit_strips(turned, start, np.array([1e-5]))
    np.testing.assert_allclose(there.cost, here.cost, rtol=1e-9)
    np.testing.assert_allclose(
        integrate_frames(GRID, there.shape), turn @ integrate_frames(GRID, here.shape), atol=1e-6
    )


def test_a_ribbon_read_from_its_other_end_is_the_same_curve():
    """Sensors mirrored in place, each turned half round its normal: the curve run backwards."""
    about = np.diag([-1.0, -1.0, 1.0])
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=6)
    problem = laid.problem
    backwards = replace(
        problem,
        array=replace(problem.array, gain=problem.array.gain @ about),
        grid=replace(GRID, sensor_nodes=len(GRID.nodes) - 1 - GRID.sensor_nodes),
    )
    frames = integrate_frames(GRID, laid.shape)
    start = Shape(frames[:, -1] @ about, laid.shape.rates[..., ::-1])
    here = fitted(laid, 1e-5)
    there = fit_strips(backwards, start, np.array([1e-5]))
    np.testing.assert_allclose(there.cost, here.cost, rtol=1e-6)
    found = integrate_frames(GRID, there.shape)[0, ::-1] @ about
    apart = degrees_between(found, integrate_frames(GRID, here.shape)[0])
    assert apart.max() < 1e-3


def test_an_absent_sensor_has_no_part_in_the_fit():
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=7)
    values = laid.problem.observations.values.copy()
    values[0, 3] = 50.0
    nonsense = replace(
        laid,
        problem=replace(
            laid.problem, observations=replace(laid.problem.observations, values=values)
        ),
    )
    name = RIBBON.sensors[3].name
    one, other = fitted(without(laid, name)), fitted(without(nonsense, name))
    np.testing.assert_array_equal(one.shape.rates, other.shape.rates)
    assert one.squares[0, 3] == 0.0


def test_more_smoothing_makes_smoother_strips():
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=8)
    rough = []
    for smoothing in (1e-9, 1e-5, 1e-2, 1e2):
        rates = fitted(laid, smoothing).shape.rates[0]
        rough.append(np.einsum("ck,kl,cl->", rates, GRID.roughness, rates))
    assert np.all(np.diff(rough) < 0)


def test_the_fit_ends_where_the_cost_is_least():
    """Along every unknown the cost rises, with the noise as it acts there."""
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=9)
    smoothing = np.array([1e-5])
    strips = fit_strips(laid.problem, near(laid.shape), smoothing)
    white = whiten(laid.problem, strips.shape)
    sigma = np.sqrt(np.diag(np.linalg.inv(strips.normal[0])))
    for k in range(GRID.unknowns):
        for way in (-0.3, 0.3):
            step = np.zeros((1, GRID.unknowns))
            step[0, k] = way * sigma[k]
            there = evaluate(laid.problem, strips.shape.moved(step), smoothing, white)
            assert there.cost[0] > strips.cost[0]


def test_costs_of_minima_count_how_likely_the_noise_is():
    """With all sigmas doubled a perfect fit costs 2 log 2 more for each axis."""
    laid = lay(RIBBON, wavy(GRID, TILTED))
    noise = laid.problem.noise
    doubled = Noise(2 * noise.contact, 2 * noise.acceleration, 2 * noise.field)
    zero = np.zeros(1)
    costs = []
    for one in (noise, doubled):
        problem = replace(laid.problem, noise=one)
        costs.append(evaluate(problem, laid.shape, zero, whiten(problem, laid.shape)).cost[0])
    assert costs[1] - costs[0] == pytest.approx(len(RIBBON.columns) * 2 * np.log(2.0))


def test_whitened_residuals_are_those_of_the_fit():
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=10)
    strips = fitted(laid, 1e-5)
    residuals = whitened_residuals(laid.problem, integrate_frames(GRID, strips.shape))
    # The fit keeps the noise as it was one step before its end.
    np.testing.assert_allclose(np.sum(residuals**2, axis=2), strips.squares, rtol=1e-3, atol=1e-3)


def test_no_iterations_leave_the_start():
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=10)
    start = near(laid.shape)
    strips = fit_strips(laid.problem, start, np.array([1e-5]), iterations=0)
    np.testing.assert_array_equal(strips.shape.rates, start.rates)


# --- honesty ---


def draws(count, of, noise=None):
    """Fits of the same strip with `count` draws of the noise, and the strip."""
    grid = make_grid(of)
    truth = wavy(grid, TILTED)
    stack = Shape(np.repeat(truth.start, count, axis=0), np.repeat(truth.rates, count, axis=0))
    laid = lay(of, stack, seed=11, noise=noise)
    weight = weight_of_length(0.2, information_density(laid.problem))
    return laid, fit_strips(laid.problem, stack, np.full(count, float(weight)))


@pytest.mark.parametrize("axes", [2, 3])
def test_the_covariance_is_honest(axes):
    """Over 60 draws the errors of frames and points are as large as they are said to be."""
    of = ribbon(16, axes)
    laid, strips = draws(60, of)
    grid = laid.grid
    covariance = np.linalg.inv(strips.normal)
    turns = differentiate_frames(grid, strips.shape)
    points, moves = differentiate_positions(grid, strips.shape, turns)
    true_frames = integrate_frames(grid, laid.shape)
    turned = log(true_frames @ np.swapaxes(turns.frames, -1, -2))
    sigma = np.sqrt(np.einsum("bnim,bmk,bnik->bni", turns.delta, covariance, turns.delta))
    ratio = np.sqrt(np.mean((turned / sigma) ** 2))
    assert 0.85 < ratio < 1.15
    away = points - integrate_positions(grid, laid.shape, true_frames)
    sigma = np.sqrt(np.einsum("bnim,bmk,bnik->bni", moves, covariance, moves))[:, 5:]
    per_axis = np.sqrt(np.mean((away[:, 5:] / sigma) ** 2, axis=(0, 1)))
    assert ((per_axis > 0.8) & (per_axis < 1.25)).all()


def test_residuals_are_as_large_as_the_fit_leaves_them():
    """Their squares sum to the axes less what the fit follows: n - 2 tr S + tr S²."""
    laid, strips = draws(60, RIBBON)
    smooth = prior(laid.grid, strips.smoothing)
    follows = np.linalg.solve(strips.normal, strips.normal - smooth)
    twice = np.trace(follows, axis1=1, axis2=2) * 2
    expected = len(RIBBON.columns) - twice + np.trace(follows @ follows, axis1=1, axis2=2)
    assert strips.squares.sum(axis=1).mean() == pytest.approx(expected.mean(), rel=0.1)


def test_three_axes_tell_more_than_two():
    normals = []
    for axes in (2, 3):
        laid = lay(ribbon(16, axes), wavy(GRID, TILTED))
        white = whiten(laid.problem, laid.shape)
        normals.append(evaluate(laid.problem, laid.shape, np.ones(1), white).normal[0])
    more = np.linalg.eigvalsh(normals[1] - normals[0])
    assert more.min() > -1e-6 * more.max()
    assert more.max() > 1.0


def test_the_start_may_be_far_off_without_harm():
    laid = lay(RIBBON, wavy(GRID, FLAT), seed=12)
    one = fitted(laid, 1e-5)
    other = fitted(laid, 1e-5, near(laid.shape, degrees=25.0, rates=1.0))
    apart = degrees_between(integrate_frames(GRID, one.shape), integrate_frames(GRID, other.shape))
    assert apart.max() < 0.02
    np.testing.assert_allclose(one.cost, other.cost, atol=0.1)


# --- following ---


@given(st.integers(0, 10**6))
def test_following_from_nearby_ends_where_the_fit_does(seed):
    laid = lay(RIBBON, wavy(GRID, TILTED), seed=seed)
    smoothing = np.full(1, 1e-4)
    cold = fit_strips(laid.problem, laid.shape, smoothing)
    shape = follow_shape(laid.problem, near(cold.shape, 1.0, 0.05, seed), smoothing, 6)
    frames = (integrate_frames(GRID, one) for one in (cold.shape, shape))
    assert degrees_between(*frames).max() < 0.3
    followed = evaluate(laid.problem, shape, smoothing, whiten(laid.problem, shape))
    np.testing.assert_allclose(followed.cost, cold.cost, atol=0.5)
