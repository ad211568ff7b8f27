"""The discrete ribbon: unit speed, closed forms, order of convergence, exact derivatives."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import constant, random_shape, ribbon, shape_of, wavy
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from georibbon.fitting import grid as rooms
from georibbon.fitting.grid import (
    Shape,
    differentiate_frames,
    differentiate_positions,
    integrate_frames,
    integrate_positions,
    make_grid,
)
from georibbon.ribbon import Ribbon, Sensor
from georibbon.rotations import log, skew

GRID = make_grid(ribbon(12))
seeds = st.integers(0, 10**6)


def uneven(positions, length):
    """A ribbon with accelerometers at the given places."""
    sensors = [Sensor(f"A{k}", "accelerometer", 3, s, 1.0) for k, s in enumerate(positions)]
    return Ribbon("GR-0009", length, 100.0, tuple(sensors))


def basis_of(grid):
    """The documented basis: cubic B-splines on uniform knots over the ribbon."""
    length, intervals = grid.nodes[-1], grid.coefficients - 3
    knots = np.r_[[0.0] * 3, np.linspace(0, length, intervals + 1), [length] * 3]
    return BSpline(knots, np.eye(grid.coefficients), 3)


# --- the grid ---


@given(
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12).map(
        lambda places: [round(place, 4) for place in places]
    )
)
def test_every_sensor_sits_on_a_node(positions):
    grid = make_grid(uneven(positions, 1.0))
    np.testing.assert_allclose(grid.nodes[grid.sensor_nodes], positions, atol=2e-9)
    assert grid.nodes[0] == 0.0
    assert grid.nodes[-1] == 1.0
    np.testing.assert_allclose(grid.steps, np.diff(grid.nodes), atol=1e-15)
    assert grid.steps.min() > 0
    assert grid.steps.max() <= rooms.LONGEST_STEP + 1e-9


def test_sensors_at_one_place_share_its_node():
    grid = make_grid(uneven([0.1, 0.1, 0.1 + 1e-12, 0.3], 0.4))
    assert len(set(grid.sensor_nodes[:3])) == 1


def test_there_is_a_spline_interval_for_every_two_places():
    assert make_grid(ribbon(32)).coefficients == 16 + 3
    assert make_grid(uneven([0.1], 0.4)).coefficients == 3 + 3
    assert make_grid(ribbon(32)).unknowns == 3 + 2 * 19


def test_the_basis_sums_to_one_and_its_means_are_the_integrals():
    for values in (GRID.mean, GRID.half, GRID.at_nodes):
        np.testing.assert_allclose(values.sum(axis=1), 1.0, atol=1e-14)
    basis = basis_of(GRID)
    whole = basis.antiderivative()
    left, right = GRID.nodes[:-1], GRID.nodes[1:]
    middle = 0.5 * (left + right)
    np.testing.assert_allclose(basis(GRID.nodes), GRID.at_nodes, atol=1e-14)
    exact = (whole(right) - whole(left)) / GRID.steps[:, None]
    knots = np.unique(basis.t)[1:-1]
    plain = ~((knots > left[:, None] + 1e-12) & (knots < right[:, None] - 1e-12)).any(axis=1)
    np.testing.assert_allclose(GRID.mean[plain], exact[plain], atol=1e-14)
    np.testing.assert_allclose(GRID.mean, exact, atol=2e-3)
    first = (whole(middle) - whole(left)) / (0.5 * GRID.steps[:, None])
    np.testing.assert_allclose(GRID.half[plain], first[plain], atol=1e-14)


def test_roughness_is_the_integral_of_the_squared_second_derivative():
    coefficients = np.random.default_rng(2).normal(size=GRID.coefficients)
    spline = BSpline(basis_of(GRID).t, coefficients, 3)
    knots = np.unique(spline.t)
    square = sum(quad(lambda s: spline(s, 2) ** 2, a, b)[0] for a, b in pairwise(knots))
    assert coefficients @ GRID.roughness @ coefficients == pytest.approx(square, rel=1e-9)


def test_a_rate_that_changes_evenly_is_not_rough():
    slope = np.linalg.lstsq(GRID.at_nodes, 3.0 * GRID.nodes - 1.0, rcond=None)[0]
    assert slope @ GRID.roughness @ slope == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.matrix_rank(GRID.roughness) == GRID.coefficients - 2
    np.testing.assert_allclose(GRID.roughness, GRID.roughness.T, atol=1e-9)


# --- frames and positions ---


@given(seeds)
def test_frames_are_rotations_and_the_curve_has_unit_speed(seed):
    shape = random_shape(GRID, np.random.default_rng(seed), 3)
    frames = integrate_frames(GRID, shape)
    np.testing.assert_allclose(
        frames @ np.swapaxes(frames, -1, -2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-12)
    np.testing.assert_allclose(frames[:, 0], shape.start, atol=1e-15)
    chords = np.linalg.norm(np.diff(integrate_positions(GRID, shape, frames), axis=1), axis=2)
    assert (chords <= GRID.steps * (1 + 1e-9)).all()
    # A chord falls short of its arc by (curvature x arc)²/24.
    np.testing.assert_allclose(chords, np.broadcast_to(GRID.steps, chords.shape), rtol=1e-3)


@given(seeds)
def test_a_ribbon_never_bends_in_its_own_plane(seed):
    frames = integrate_frames(GRID, random_shape(GRID, np.random.default_rng(seed)))[0]
    turns = log(np.swapaxes(frames[:-1], 1, 2) @ frames[1:])
    np.testing.assert_allclose(turns[:, 2], 0.0, atol=1e-12)


@pytest.mark.parametrize("bend", [-2.0, -0.3, 0.7, 3.0])
def test_constant_bending_is_a_circular_arc(bend):
    shape = shape_of(GRID, np.eye(3), constant(0.0), constant(bend))
    frames = integrate_frames(GRID, shape)
    points = integrate_positions(GRID, shape, frames)[0]
    angle = bend * GRID.nodes
    # Turning about V = y takes the tangent x towards -z.
    expected = np.stack([np.sin(angle), 0 * angle, np.cos(angle) - 1], axis=1) / bend
    np.testing.assert_allclose(points, expected, atol=2e-10)
    np.testing.assert_allclose(
        frames[0], Rotation.from_rotvec(angle[:, None] * [0, 1, 0]).as_matrix(), atol=1e-12
    )


@pytest.mark.parametrize(("twist", "bend"), [(1.5, 2.0), (-4.0, 1.0), (3.0, 0.0)])
def test_constant_rates_are_a_helix(twist, bend):
    shape = shape_of(GRID, np.eye(3), constant(twist), constant(bend))
    points = integrate_positions(GRID, shape, integrate_frames(GRID, shape))[0]
    axis, rate = np.array([twist, bend, 0.0]), np.hypot(twist, bend)
    axis /= rate
    ahead = np.array([1.0, 0.0, 0.0])
    along = (axis @ ahead) * axis
    square, side = ahead - along, np.cross(axis, ahead)
    angle = rate * GRID.nodes[:, None]
    expected = GRID.nodes[:, None] * along
    expected = expected + (np.sin(angle) * square + (1 - np.cos(angle)) * side) / rate
    np.testing.assert_allclose(points, expected, atol=1e-8)


def reference_curve(grid, shape):
    """Frames (n + 1, 3, 3) and points (n + 1, 3) from R' = R [w]x, X' = R e_x, integrated."""
    rates = BSpline(basis_of(grid).t, shape.rates[0].T, 3)

    def slope(s, state):
        frame = state[:9].reshape(3, 3)
        turning = frame @ skew(np.append(rates(s), 0.0))
        return np.concatenate([turning.ravel(), frame[:, 0]])

    begin = np.concatenate([shape.start[0].ravel(), np.zeros(3)])
    span = (0.0, float(grid.nodes[-1]))
    solved = solve_ivp(
        slope, span, begin, method="DOP853", t_eval=grid.nodes, rtol=1e-11, atol=1e-12
    ).y.T
    return solved[:, :9].reshape(-1, 3, 3), solved[:, 9:]


def errors_against_reference(monkeypatch, step, scale):
    """(2,) radians and metres: what the grid with steps of that length misses."""
    monkeypatch.setattr(rooms, "LONGEST_STEP", step)
    grid = make_grid(ribbon(8, pitch=0.06))
    shape = wavy(grid, scale=scale)
    frames, points = reference_curve(grid, shape)
    found = integrate_frames(grid, shape)
    turn = np.linalg.norm(log(frames @ np.swapaxes(found[0], 1, 2)), axis=1).max()
    return np.array([turn, np.abs(integrate_positions(grid, shape, found)[0] - points).max()])


def test_frames_and_positions_converge_with_the_second_power_of_the_step(monkeypatch):
    coarse, fine, finest = (
        errors_against_reference(monkeypatch, step, 3.0) for step in (0.03, 0.015, 0.0075)
    )
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.35)
    np.testing.assert_allclose(np.log2(fine / finest), 2.0, atol=0.35)


def test_at_the_usual_step_the_frames_are_within_a_hundredth_of_a_degree(monkeypatch):
    turn, away = errors_against_reference(monkeypatch, rooms.LONGEST_STEP, 1.0)
    assert turn < np.radians(0.01)
    assert away < 0.05e-3


@given(seeds, seeds)
def test_strips_of_a_stack_do_not_know_each_other(seed, other):
    one, two = (random_shape(GRID, np.random.default_rng(k)) for k in (seed, other + 10**7))
    stack = Shape(np.concatenate([one.start, two.start]), np.concatenate([one.rates, two.rates]))
    frames = integrate_frames(GRID, stack)
    np.testing.assert_allclose(frames[1], integrate_frames(GRID, two)[0], atol=1e-13)
    np.testing.assert_allclose(integrate_frames(GRID, stack.take([1])), frames[1:], atol=1e-13)


@given(seeds)
def test_turning_the_start_turns_the_whole_curve(seed):
    rng = np.random.default_rng(seed)
    shape, turn = random_shape(GRID, rng), Rotation.random(random_state=seed).as_matrix()
    frames = integrate_frames(GRID, shape)
    turned = replace(shape, start=turn @ shape.start)
    np.testing.assert_allclose(integrate_frames(GRID, turned), turn @ frames, atol=1e-12)
    np.testing.assert_allclose(
        integrate_positions(GRID, turned, turn @ frames),
        integrate_positions(GRID, shape, frames) @ turn.T,
        atol=1e-13,
    )


@given(seeds)
def test_run_backwards_the_same_rates_give_the_same_curve(seed):
    """Backwards tau and V change sign: the bending keeps its sign about V, so does the twist."""
    shape = random_shape(GRID, np.random.default_rng(seed))
    frames = integrate_frames(GRID, shape)
    points = integrate_positions(GRID, shape, frames)[0]
    about = np.array([-1.0, -1.0, 1.0])
    back = Shape(frames[:, -1] * about, shape.rates[..., ::-1])
    frames_back = integrate_frames(GRID, back)
    points_back = integrate_positions(GRID, back, frames_back)[0]
    np.testing.assert_allclose(frames_back[0, ::-1] * about, frames[0], atol=1e-11)
    # Within a step the rates' change is seen from its start, which differs by some micrometres in
    # all: third order in the step, a thousandth of what a sensor's noise does.
    np.testing.assert_allclose(points_back[::-1] - points_back[-1], points, atol=5e-6)


# --- derivatives ---


@given(seeds)
def test_derivatives_of_frames_and_points_are_those_of_differences(seed):
    rng = np.random.default_rng(seed)
    shape = random_shape(GRID, rng, 2)
    turns = differentiate_frames(GRID, shape)
    points, moves = differentiate_positions(GRID, shape, turns)
    np.testing.assert_allclose(turns.frames, integrate_frames(GRID, shape), atol=1e-14)
    np.testing.assert_allclose(points, integrate_positions(GRID, shape, turns.frames), atol=1e-15)
    x, step = rng.normal(size=(2, GRID.unknowns)), 1e-5
    ahead, behind = shape.moved(step * x), shape.moved(-step * x)
    frames_ahead, frames_behind = integrate_frames(GRID, ahead), integrate_frames(GRID, behind)
    turn = log(frames_ahead @ np.swapaxes(frames_behind, -1, -2)) / (2 * step)
    expected = np.einsum("bnim,bm->bni", turns.delta, x)
    np.testing.assert_allclose(turn, expected, atol=1e-8)
    slope = integrate_positions(GRID, ahead, frames_ahead)
    slope = (slope - integrate_positions(GRID, behind, frames_behind)) / (2 * step)
    np.testing.assert_allclose(slope, np.einsum("bnim,bm->bni", moves, x), atol=1e-8)


def test_a_step_turns_the_start_from_the_left_and_adds_to_the_rates():
    shape = random_shape(GRID, np.random.default_rng(5))
    step = np.zeros((1, GRID.unknowns))
    step[0, 2], step[0, 3], step[0, -1] = 0.3, 1.0, 2.0
    moved = shape.moved(step)
    np.testing.assert_allclose(
        moved.start[0], Rotation.from_euler("z", 0.3).as_matrix() @ shape.start[0], atol=1e-14
    )
    change = moved.rates - shape.rates
    assert change[0, 0, 0] == pytest.approx(1.0)
    assert change[0, 1, -1] == pytest.approx(2.0)
    assert np.count_nonzero(np.abs(change) > 1e-12) == 2
