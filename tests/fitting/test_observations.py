"""The survey's equations: places between nodes, residuals, exact derivatives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import both, constant, placed, random_shape, ribbon, shape_of, wavy, with_derivatives

from georibbon.fitting import grid as rooms
from georibbon.fitting.grid import Shape, make_grid
from georibbon.fitting.survey import (
    CROSSING_NORMAL_SIGMA,
    AcrossSet,
    ChordSet,
    CrossingSet,
    DistanceSet,
    MarkSet,
    sample,
)
from georibbon.rotations import exp

GRID = make_grid(ribbon(12))
LENGTH = float(GRID.nodes[-1])
FIRST, SECOND = np.array([0, 1, 2]), np.array([1, 2, 0])
PAIRS_AT = np.array([[0.0, 0.09], [0.06, LENGTH], [0.123, 0.217]])
SIGMA = np.array([1e-3, 2e-3, 5e-4])
ORIGIN = np.array([[0.0, 0.0, 0.0], [0.02, 0.1, 0.01], [-0.01, 0.2, 0.03]])


def similar(seed):
    """Three lively passes that run in about the same direction."""
    rng = np.random.default_rng(seed)
    shape = both(wavy(GRID), wavy(GRID, exp(np.array([0.1, 0.05, -0.1]))), wavy(GRID, scale=0.5))
    step = rng.normal(size=(3, GRID.unknowns))
    step[:, :3] *= 0.2
    return shape.moved(0.5 * step)


OBSERVATIONS = {
    "mark": MarkSet(FIRST, PAIRS_AT[:, 0], ORIGIN + 0.01, SIGMA),
    "distance": DistanceSet(FIRST, SECOND, PAIRS_AT, np.array([0.1, 0.12, 0.2]), SIGMA),
    "crossing": CrossingSet(FIRST, SECOND, PAIRS_AT, SIGMA),
    "across": AcrossSet(FIRST, SECOND, PAIRS_AT, SIGMA),
    "chord": ChordSet(FIRST, SECOND, PAIRS_AT, np.array([0.0, 1e-3, -2e-3]), SIGMA),
}


def one_against(seed):
    """The same, with the second pass run against the others."""
    shape = similar(seed)
    turned = shape.start.copy()
    turned[1] = turned[1] @ np.diag([-1.0, -1.0, 1.0])
    return Shape(turned, shape.rates)


def residuals_after(observation, shape, step):
    """Residuals after a step (3, m + 3) of all unknowns."""
    there = placed(GRID, shape.moved(step[:, :-3]), ORIGIN + step[:, -3:])
    return observation.rows(there).residuals


@pytest.mark.parametrize("kind", list(OBSERVATIONS))
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("laid", [similar, one_against])
def test_derivatives_are_those_of_differences(kind, seed, laid):
    observation, shape = OBSERVATIONS[kind], laid(seed)
    rows = observation.rows(with_derivatives(GRID, shape, ORIGIN))
    x, h = np.random.default_rng(seed + 50).normal(size=(3, GRID.unknowns + 3)), 1e-6
    ahead = residuals_after(observation, shape, h * x)
    slope = (ahead - residuals_after(observation, shape, -h * x)) / (2 * h)
    expected = np.einsum("kdm,km->kd", rows.first, x[rows.i])
    expected = expected + np.einsum("kdm,km->kd", rows.second, x[rows.j])
    tolerance = 1e-6 * np.abs(expected).max(axis=1)
    # Between nodes a frame's turn is blended from its neighbours': to second order in the step.
    tolerance[2] *= 30 if kind in ("crossing", "across", "chord") else 1
    assert (np.abs(slope - expected).max(axis=1) < tolerance).all()


@pytest.mark.parametrize("kind", list(OBSERVATIONS))
def test_residuals_do_not_need_derivatives(kind):
    observation, shape = OBSERVATIONS[kind], similar(1)
    rows = observation.rows(placed(GRID, shape, ORIGIN))
    full = observation.rows(with_derivatives(GRID, shape, ORIGIN))
    np.testing.assert_allclose(rows.residuals, full.residuals, atol=1e-9)
    assert rows.first.shape[2] == 3
    np.testing.assert_allclose(full.squares, np.sum(full.residuals**2, axis=1))


@pytest.mark.parametrize("kind", ["distance", "crossing", "across", "chord"])
def test_moving_everything_rigidly_changes_no_relation_between_passes(kind):
    observation, shape = OBSERVATIONS[kind], similar(2)
    turn, shift = exp(np.array([0.4, -0.9, 2.0])), np.array([1.0, -2.0, 0.5])
    before = observation.rows(placed(GRID, shape, ORIGIN)).residuals
    turned = Shape(turn @ shape.start, shape.rates)
    after = observation.rows(placed(GRID, turned, ORIGIN @ turn.T + shift)).residuals
    if kind == "crossing":  # what the points are apart turns along
        before[:, :3] = before[:, :3] @ turn.T
    np.testing.assert_allclose(after, before, atol=1e-7)


@pytest.mark.parametrize("kind", list(OBSERVATIONS))
def test_residuals_are_counted_in_standard_deviations(kind):
    observation = OBSERVATIONS[kind]
    wider = type(observation)(**{**vars(observation), "sigma": 2 * observation.sigma})
    now, then = (
        one.rows(placed(GRID, similar(3), ORIGIN)).residuals for one in (observation, wider)
    )
    scaled = slice(0, 3)  # a crossing's normals have their own sigma
    np.testing.assert_allclose(then[:, scaled], 0.5 * now[:, scaled], rtol=1e-12)
    np.testing.assert_allclose(then[:, 3:], now[:, 3:])


def test_each_says_what_was_measured_minus_nothing():
    """Two flat passes, 0.1 m apart: every residual by hand."""
    flat = shape_of(GRID, np.eye(3), constant(0.0), constant(0.0))
    tipped = shape_of(GRID, exp(np.array([0.01, 0.0, 0.0])), constant(0.0), constant(0.0))
    here = placed(GRID, both(flat, tipped), np.array([[0.0, 0, 0], [0.02, 0.1, 0.03]]))
    i, j, at = np.array([0]), np.array([1]), np.array([[0.06, 0.06]])
    sigma = np.array([0.01])
    mark = MarkSet(i, at[:, 0], np.array([[0.05, 0.0, 0.02]]), sigma).rows(here)
    np.testing.assert_allclose(mark.residuals, [[1.0, 0.0, -2.0]], atol=1e-9)
    distance = DistanceSet(i, j, at, np.array([0.1]), sigma).rows(here)
    length = np.sqrt(0.02**2 + 0.1**2 + 0.03**2)
    np.testing.assert_allclose(distance.residuals, [[(length - 0.1) / 0.01]])
    across = AcrossSet(i, j, at, sigma).rows(here)
    np.testing.assert_allclose(across.residuals, [[2.0]])
    chord = ChordSet(i, j, at, np.array([0.01]), sigma).rows(here)
    normal = np.array([0.0, -np.sin(0.01), 1 + np.cos(0.01)]) / 2
    expected = (normal @ [0.02, 0.1, 0.03] - 0.01) / 0.01
    np.testing.assert_allclose(chord.residuals, [[expected]])
    crossing = CrossingSet(i, j, at, sigma).rows(here)
    tilt = -np.sin(0.01) / CROSSING_NORMAL_SIGMA
    np.testing.assert_allclose(crossing.residuals, [[-2.0, -10.0, -3.0, 0.0, tilt]], atol=1e-9)


def test_across_a_pass_that_runs_against_the_other_is_the_same():
    flat = shape_of(GRID, np.eye(3), constant(0.0), constant(0.0))
    back = shape_of(GRID, exp(np.array([0.0, 0.0, np.pi])), constant(0.0), constant(0.0))
    shapes, origin = both(flat, back), np.array([[0.0, 0, 0], [LENGTH, 0.1, 0]])
    at = np.array([[0.1, LENGTH - 0.12]])
    here = placed(GRID, shapes, origin)
    rows = AcrossSet(np.array([0]), np.array([1]), at, np.array([0.01])).rows(here)
    np.testing.assert_allclose(rows.residuals, [[2.0]], atol=1e-9)


def test_points_that_meet_have_no_direction_between_them_but_no_harm_comes():
    flat = shape_of(GRID, np.eye(3), constant(0.0), constant(0.0))
    here = with_derivatives(GRID, both(flat, flat), np.zeros((2, 3)))
    at = np.array([[0.1, 0.1]])
    rows = DistanceSet(np.array([0]), np.array([1]), at, np.array([0.0]), np.array([1e-3])).rows(
        here
    )
    assert np.isfinite(rows.first).all()
    np.testing.assert_allclose(rows.residuals, 0.0, atol=1e-5)


# --- places between nodes ---


@given(st.integers(0, 10**6))
def test_sampling_reproduces_the_nodes(seed):
    here = with_derivatives(GRID, random_shape(GRID, np.random.default_rng(seed), 3), ORIGIN)
    nodes = np.arange(len(GRID.nodes))
    for which in range(3):
        found = sample(here, np.full(len(nodes), which), GRID.nodes)
        np.testing.assert_allclose(found.points, here.points[which], atol=1e-15)
        np.testing.assert_allclose(found.frames, here.frames[which], atol=1e-12)
        np.testing.assert_allclose(found.moves[..., :-3], here.moves[which], atol=1e-15)
        np.testing.assert_allclose(found.turns[..., :-3], here.turns[which], atol=1e-15)
        np.testing.assert_array_equal(found.moves[..., -3:], np.tile(np.eye(3), (len(nodes), 1, 1)))
        np.testing.assert_array_equal(found.turns[..., -3:], 0.0)


@given(st.integers(0, 10**6), st.lists(st.floats(0.0, LENGTH), min_size=1, max_size=5))
def test_frames_between_nodes_are_rotations(seed, places):
    here = placed(GRID, random_shape(GRID, np.random.default_rng(seed), 3), ORIGIN)
    found = sample(here, np.ones(len(places), dtype=int), np.array(places))
    eye = np.broadcast_to(np.eye(3), found.frames.shape)
    np.testing.assert_allclose(found.frames @ np.swapaxes(found.frames, 1, 2), eye, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(found.frames), 1.0)


def test_beyond_the_ends_the_ribbon_ends():
    here = placed(GRID, similar(4), ORIGIN)
    found = sample(here, np.array([0, 0]), np.array([-0.01, LENGTH + 0.01]))
    np.testing.assert_allclose(found.points, here.points[0, [0, -1]], atol=1e-15)


def misses_between_nodes(monkeypatch, step):
    """(points, frames): how far places between nodes are off on a helix."""
    monkeypatch.setattr(rooms, "LONGEST_STEP", step)
    grid = make_grid(ribbon(8, pitch=0.06))
    monkeypatch.setattr(rooms, "LONGEST_STEP", step / 16)
    fine = make_grid(ribbon(8, pitch=0.06))
    rates = (constant(2.0), constant(3.0))
    coarse, true = (
        placed(g, shape_of(g, np.eye(3), *rates), np.zeros((1, 3))) for g in (grid, fine)
    )
    found = sample(coarse, np.zeros(len(fine.nodes), dtype=int), fine.nodes)
    away = np.abs(found.points - true.points[0]).max()
    return np.array([away, np.abs(found.frames - true.frames[0]).max()])


def test_between_nodes_points_are_of_fourth_and_frames_of_second_order(monkeypatch):
    coarse, fine = (misses_between_nodes(monkeypatch, step) for step in (0.03, 0.015))
    np.testing.assert_allclose(np.log2(coarse / fine), [4.0, 2.0], atol=0.3)
