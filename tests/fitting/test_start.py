"""Starts and candidates: whatever the attitude, the true shape is among what is tried."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from laid import (
    both,
    constant,
    degrees_between,
    lay,
    ribbon,
    shape_of,
    wavy,
    without,
)
from scipy.spatial.transform import Rotation

from georibbon.fitting.candidates import KEEP_WITHIN, find_candidates, stack, with_borrowed
from georibbon.fitting.grid import Shape, integrate_frames, make_grid
from georibbon.fitting.start import find_starts, gravity_at
from georibbon.fitting.strip import evaluate, sensed_vectors, whiten
from georibbon.rotations import about_z, exp

# Degrees, at the worst place of a ribbon of half a metre: four standard deviations at its ends.
NEAR = 7.0
RIBBON, RIBBON3 = ribbon(16), ribbon(16, 3)
GRID = make_grid(RIBBON)
BY_EVIDENCE = np.nan

ATTITUDES = {
    "face up": Rotation.identity(),
    "upside down": Rotation.from_euler("x", 180, degrees=True),
    "facing sideways": Rotation.from_euler("x", 90, degrees=True),
    "facing the other side": Rotation.from_euler("x", -90, degrees=True),
    "standing, leading up": Rotation.from_euler("y", -90, degrees=True),
    "standing, leading down": Rotation.from_euler("y", 90, degrees=True),
    "askew": Rotation.from_euler("xyz", [40, -50, 20], degrees=True),
}
HEADINGS = np.radians(np.arange(0.0, 360.0, 30.0))


def turned(shape, headings):
    """One strip at every heading."""
    start = about_z(headings) @ shape.start
    return Shape(start, np.repeat(shape.rates, len(headings), axis=0))


def from_middle(shape, attitude):
    """The strip with the attitude (3, 3) in its middle."""
    middle = integrate_frames(GRID, shape)[0, len(GRID.nodes) // 2]
    return Shape((attitude @ middle.T)[None] @ shape.start, shape.rates)


def nearest(laid, strips, p):
    """Degrees by which the nearest of the candidates misses pass p, at its worst node.

    It must fit the readings better than the truth itself does: it is a minimum there.
    """
    truth = integrate_frames(laid.grid, laid.shape)[p]
    away = degrees_between(integrate_frames(laid.grid, strips.shape), truth).max(axis=1)
    k = int(np.argmin(away))
    problem, shape = laid.problem.take([p]), laid.shape.take([p])
    smoothing = strips.smoothing[[k]]
    at_truth = evaluate(problem, shape, smoothing, whiten(problem, shape)).cost[0]
    assert strips.cost[k] < at_truth
    return away[k]


def candidates(laid):
    return find_candidates(laid.problem, np.full(len(laid.shape.start), BY_EVIDENCE))


@pytest.mark.parametrize("attitude", list(ATTITUDES))
@pytest.mark.parametrize("of", [RIBBON, RIBBON3], ids=["2 axes", "3 axes"])
def test_at_every_heading_the_truth_is_among_the_candidates(of, attitude):
    shape = from_middle(wavy(GRID, scale=2.0), ATTITUDES[attitude].as_matrix())
    laid = lay(of, turned(shape, HEADINGS), seed=1, skew_seed=1)
    for p, strips in enumerate(candidates(laid)):
        assert nearest(laid, strips, p) < NEAR


def test_a_ribbon_curled_round_most_of_a_pipe_is_found():
    """From facing up over facing down to facing up again, at every heading."""
    arc = shape_of(GRID, ATTITUDES["askew"].as_matrix(), constant(0.5), constant(10.0))
    laid = lay(RIBBON3, turned(arc, HEADINGS), seed=2)
    for p, strips in enumerate(candidates(laid)):
        assert nearest(laid, strips, p) < NEAR


def test_with_three_axes_the_best_candidate_is_the_truth():
    shapes = [from_middle(wavy(GRID), one.as_matrix()) for one in ATTITUDES.values()]
    laid = lay(RIBBON3, both(*(turned(shape, HEADINGS[::3]) for shape in shapes)), seed=3)
    for p, strips in enumerate(candidates(laid)):
        assert nearest(laid, strips.take([0]), p) < NEAR


@pytest.mark.parametrize("dead", [("M01", "M02"), ("M04", "M05"), ("M08",), ("A03", "A04", "M02")])
def test_sensors_that_say_nothing_do_not_hide_the_truth(dead):
    shapes = [
        from_middle(wavy(GRID, scale=1.5), ATTITUDES[name].as_matrix())
        for name in ("face up", "upside down", "askew")
    ]
    laid = without(lay(RIBBON3, both(*shapes), seed=4), *dead)
    for p, strips in enumerate(candidates(laid)):
        assert nearest(laid, strips, p) < NEAR


def wall(heading):
    """Level along a wall of 1 m radius, facing out of it."""
    start = about_z(heading) @ ATTITUDES["facing sideways"].as_matrix()
    return shape_of(GRID, start, constant(0.0), constant(1.0))


@pytest.mark.parametrize("heading", np.radians([0.0, 60.0, 120.0, 210.0]))
def test_along_a_wall_two_axes_leave_a_twin_and_three_do_not(heading):
    two, three = (candidates(lay(of, wall(heading), seed=5))[0] for of in (RIBBON, RIBBON3))
    assert len(two.cost) == 2
    assert two.cost[1] - two.cost[0] < 15.0
    assert len(three.cost) == 1
    laid = lay(RIBBON, wall(heading), seed=5)
    assert nearest(laid, two, 0) < NEAR
    apart = degrees_between(*integrate_frames(GRID, two.shape))
    assert apart.min() > 10.0


def test_the_twin_says_the_same_to_every_sensor():
    """Along the ribbon both see the same field; what differs is the axis that is not measured."""
    laid = lay(RIBBON, wall(0.7))
    both_minima = find_candidates(laid.problem, np.array([0.2]))[0]
    frames = integrate_frames(GRID, both_minima.shape)[:, GRID.sensor_nodes]
    seen = np.einsum("nk,bnkc->bnc", laid.problem.vectors, frames)
    magnetic = laid.problem.array.field
    assert np.abs(seen[0] - seen[1])[:, :2].max() < 0.03
    assert np.abs(seen[0] - seen[1])[magnetic, 2].max() > 0.2


# --- what candidates are ---


def test_candidates_are_ordered_distinct_and_near_the_best():
    shapes = [from_middle(wavy(GRID), one.as_matrix()) for one in ATTITUDES.values()]
    laid = lay(RIBBON, both(*(turned(shape, HEADINGS[::2]) for shape in shapes)), seed=6)
    found = candidates(laid)
    assert any(len(strips.cost) > 1 for strips in found)
    for strips in found:
        assert (np.diff(strips.cost) >= 0).all()
        assert strips.cost[-1] <= strips.cost[0] + KEEP_WITHIN
        frames = integrate_frames(GRID, strips.shape)
        for a, b in product(range(len(frames)), repeat=2):
            if a != b:
                assert np.abs(frames[a] - frames[b]).max() > 0.05


def test_each_pass_is_found_as_by_itself():
    laid = lay(RIBBON, turned(wavy(GRID, scale=1.5), HEADINGS[:3]), seed=7)
    lengths = np.array([0.1, BY_EVIDENCE, 0.3])
    together = find_candidates(laid.problem, lengths)
    for p in range(3):
        alone = find_candidates(laid.problem.take([p]), lengths[[p]])[0]
        assert len(alone.cost) == len(together[p].cost)
        np.testing.assert_allclose(alone.cost, together[p].cost, atol=1e-6)
        np.testing.assert_allclose(alone.shape.rates, together[p].shape.rates, atol=1e-6)


def test_the_smoothing_asked_for_is_the_smoothing_used():
    laid = lay(RIBBON, turned(wavy(GRID), HEADINGS[:2]), seed=8)
    found = find_candidates(laid.problem, np.array([0.1, 0.2]))
    ratio = found[1].smoothing[0] / found[0].smoothing[0]
    assert ratio == pytest.approx(2.0**6)


def test_stacks_are_joined_in_their_order():
    laid = lay(RIBBON, turned(wavy(GRID), HEADINGS[:3]), seed=9)
    found = candidates(laid)
    whole = stack(found)
    at = 0
    for strips in found:
        k = len(strips.cost)
        part = whole.take(list(range(at, at + k)))
        for name in ("cost", "normal", "squares", "smoothing"):
            np.testing.assert_array_equal(getattr(part, name), getattr(strips, name))
        np.testing.assert_array_equal(part.shape.rates, strips.shape.rates)
        np.testing.assert_array_equal(part.shape.start, strips.shape.start)
        at += k
    assert at == len(whole.cost)


# --- the chain itself ---


def test_starts_belong_to_their_passes_in_order():
    laid = lay(RIBBON, turned(wavy(GRID), HEADINGS), seed=10)
    starts = find_starts(laid.problem)
    assert (np.diff(starts.owner) >= 0).all()
    assert set(starts.owner) == set(range(len(HEADINGS)))
    assert len(starts.shape.start) == len(starts.owner)


def test_the_first_start_is_within_reach_of_the_truth():
    """The ring's step is 5 degrees; the starts are about as good."""
    laid = lay(RIBBON3, turned(wavy(GRID), HEADINGS))
    starts = find_starts(laid.problem)
    frames = integrate_frames(GRID, starts.shape)
    for p, truth in enumerate(integrate_frames(GRID, laid.shape)):
        first = int(np.flatnonzero(starts.owner == p)[0])
        assert degrees_between(frames[first], truth).max() < 12.0


@pytest.mark.parametrize("heading", [-100.0, 35.0])
def test_turning_the_ribbon_by_whole_steps_turns_the_starts(heading):
    """72 headings: a turn by a multiple of 5 degrees changes nothing else."""
    shape = wavy(GRID, exp(np.array([0.3, 0.2, 0.1])))
    found = []
    for angle in (0.0, np.radians(heading)):
        starts = find_starts(lay(RIBBON3, turned(shape, np.array([angle]))).problem)
        found.append((about_z(-angle) @ integrate_frames(GRID, starts.shape)[0], starts))
    # The field does not turn along: only the best, which fits it, must be the same.
    np.testing.assert_allclose(found[0][0], found[1][0], atol=0.12)


def test_gravity_is_interpolated_between_the_accelerometers_that_speak():
    laid = without(lay(RIBBON, wavy(GRID, exp(np.array([0.3, 0.2, 0.1])))), "A04")
    up = gravity_at(laid.problem, GRID.nodes)[0]
    frames = integrate_frames(GRID, laid.shape)[0]
    accelerometers = [i for i in RIBBON.indices("accelerometer") if i != 6]
    nodes = GRID.sensor_nodes[accelerometers]
    np.testing.assert_allclose(up[nodes], frames[nodes, 2, :], atol=1e-12)
    np.testing.assert_allclose(up[0], up[nodes[0]])
    between = GRID.sensor_nodes[6]
    before, after = nodes[2], nodes[3]
    share = (GRID.nodes[between] - GRID.nodes[before]) / (GRID.nodes[after] - GRID.nodes[before])
    np.testing.assert_allclose(
        up[between], (1 - share) * up[before] + share * up[after], atol=1e-12
    )


# --- shapes that other passes lend ---


def magnetised(laid, which, share=0.6):
    """The passes, with a strong magnet beside most magnetometers of one."""
    values = laid.problem.observations.values.copy()
    magnetic = np.flatnonzero(laid.problem.array.field)
    near = magnetic[: int(share * len(magnetic))]
    values[which, near, :2] += [0.9, -0.7]
    observed = replace(laid.problem.observations, values=values)
    return replace(laid, problem=replace(laid.problem, observations=observed))


def parallel(seed):
    """Three passes of nearly one shape."""
    turns = exp(np.array([[0.1, 0.0, 0.0], [0.0, 0.0, 0.0], [-0.1, 0.0, 0.05]]))
    base = wavy(GRID)
    shapes = both(*(Shape(turn[None] @ base.start, base.rates) for turn in turns))
    return lay(RIBBON3, shapes, seed=seed)


def test_a_pass_led_astray_by_a_magnet_borrows_the_shape_of_the_others():
    laid = magnetised(parallel(12), 1)
    own = candidates(laid)
    lent = with_borrowed(laid.problem, own)
    truth = integrate_frames(GRID, laid.shape)[1]
    away = degrees_between(integrate_frames(GRID, lent[1].shape), truth).max(axis=1)
    assert away.min() < 15.0
    assert (np.diff(lent[1].cost) >= 0).all()
    for k in (0, 2):
        assert lent[k] is own[k]


def test_passes_at_peace_with_their_sensors_borrow_nothing():
    laid = parallel(13)
    own = candidates(laid)
    for one, other in zip(with_borrowed(laid.problem, own), own, strict=True):
        assert one is other


def test_where_every_pass_is_at_odds_there_is_nobody_to_lend():
    laid = parallel(14)
    for k in range(3):
        laid = magnetised(laid, k)
    own = candidates(laid)
    for one, other in zip(with_borrowed(laid.problem, own), own, strict=True):
        assert one is other


# --- nothing to go by ---


@pytest.mark.parametrize("said", [5.0, -3.0])
@pytest.mark.parametrize("seed", [None, 1])
def test_readings_that_tell_no_heading_still_give_a_start(said, seed):
    """Magnetometers far off whatever the heading: some start, and no crash."""
    laid = lay(RIBBON, turned(wavy(GRID), HEADINGS[:3]), seed=seed)
    values = laid.problem.observations.values.copy()
    values[1, laid.problem.array.field, :2] = said
    observed = replace(laid.problem.observations, values=values)
    starts = find_starts(replace(laid.problem, observations=observed))
    assert set(starts.owner) == {0, 1, 2}


def test_a_vertical_field_tells_no_heading_and_still_gives_a_start():
    laid = lay(RIBBON3, turned(wavy(GRID), HEADINGS[:2]))
    down = np.array([0.0, 0.0, -1.0])
    values = laid.problem.observations.values.copy()
    frames = integrate_frames(GRID, laid.shape)[:, GRID.sensor_nodes]
    magnetic = laid.problem.array.field
    values[:, magnetic] = (down @ frames)[:, magnetic]
    problem = replace(
        laid.problem,
        observations=replace(laid.problem.observations, values=values),
        vectors=sensed_vectors(laid.problem.array, down),
    )
    assert set(find_starts(problem).owner) == {0, 1}


def test_no_more_starts_than_are_worth_it():
    """Readings at random allow many chains."""
    laid = lay(RIBBON, turned(wavy(GRID), HEADINGS))
    values = laid.problem.observations.values.copy()
    magnetic = laid.problem.array.field
    rng = np.random.default_rng(3)
    values[:, magnetic, :2] = rng.uniform(-0.7, 0.7, (12, int(magnetic.sum()), 2))
    observed = replace(laid.problem.observations, values=values)
    starts = find_starts(replace(laid.problem, observations=observed))
    assert np.bincount(starts.owner).max() == 6
