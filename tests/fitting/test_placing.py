"""Rigid placing: headings in closed form, the right candidates, contradictions outvoted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import both, constant, placed, ribbon, shape_of, sphere, wavy

from georibbon.fitting.grid import Shape, integrate_frames, make_grid
from georibbon.fitting.placing import (
    DRIFT_SIGMA,
    MOST_COMBINATIONS,
    Curves,
    Link,
    best_placings,
    place_rigidly,
)
from georibbon.rotations import about_z, exp

GRID = make_grid(ribbon(12))
LENGTH = float(GRID.nodes[-1])
FLAT = shape_of(GRID, np.eye(3), constant(0.0), constant(0.0))
angles = st.floats(-3.1, 3.1)


def curves_of(shapes, owner=None, cost=None):
    """Candidates in magnetic axes, each from the origin."""
    count = len(shapes.start)
    here = placed(GRID, shapes, np.zeros((count, 3)))
    return Curves(
        GRID.nodes,
        np.arange(count) if owner is None else np.array(owner),
        np.zeros(count) if cost is None else np.array(cost, dtype=float),
        here.points,
        here.frames,
    )


def three():
    """Three different passes and their start points in the workpiece."""
    shapes = both(wavy(GRID), wavy(GRID, exp(np.array([0.1, 0.2, 0.3]))), wavy(GRID, scale=-1.0))
    origins = np.array([[0.1, 0.0, 0.0], [0.1, 0.2, 0.05], [0.0, 0.35, 0.1]])
    return curves_of(shapes), origins


def marks(curves, origins, heading, places=(0.0, LENGTH), sigma=1e-3):
    """Links to the true places of the points at some arc lengths of every pass."""
    out = []
    for p, origin in enumerate(origins):
        for s in places:
            there = about_z(-heading) @ curves.point(p, s) + origin
            out.append(Link(p, s, sigma, target=tuple(there)))
    return out


ALL = np.arange(3)


@given(angles)
def test_exact_marks_give_heading_and_origins_exactly(heading):
    curves, origins = three()
    found = place_rigidly(curves, marks(curves, origins, heading), None, ALL)
    assert found.heading == pytest.approx(heading, abs=1e-5)
    np.testing.assert_allclose(found.origins, origins, atol=1e-6)
    assert found.cost == pytest.approx(0.0, abs=1e-6)


@given(angles, angles)
def test_turning_the_workpiece_turns_heading_and_origins(heading, turn):
    curves, origins = three()
    links = marks(curves, origins, heading)
    rotation, shift = about_z(-turn), np.array([0.3, -0.2, 0.1])
    moved = [Link(k.i, k.s, k.sigma, target=tuple(rotation @ k.target + shift)) for k in links]
    one = place_rigidly(curves, links, None, ALL)
    two = place_rigidly(curves, moved, None, ALL)
    assert np.exp(1j * (two.heading - one.heading - turn)) == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(two.origins, one.origins @ rotation.T + shift, atol=1e-6)


@given(angles)
def test_a_known_heading_is_kept(heading):
    curves, origins = three()
    links = marks(curves, origins, heading, places=(0.0,))
    found = place_rigidly(curves, links, heading, ALL)
    assert found.heading == heading
    np.testing.assert_allclose(found.origins, origins, atol=1e-6)


def test_links_between_passes_place_the_second_by_the_first():
    curves, origins = three()
    heading = 0.8
    first = marks(curves, origins[:1], heading)
    between = []
    for i, j, s, t in ((0, 1, 0.1, 0.2), (1, 2, 0.3, 0.05)):
        there = about_z(-heading)
        gap = there @ (curves.point(j, t) - curves.point(i, s)) + origins[j] - origins[i]
        between.append(Link(i, s, 1e-3, j, t, target=tuple(gap)))
    found = place_rigidly(curves, [*first, *between], heading, ALL)
    np.testing.assert_allclose(found.origins, origins, atol=2e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_side_is_along_the_mean_conormal_whatever_the_heading(side):
    shape, origin = sphere(GRID, 0.5, (0.0, 0.1))
    curves = curves_of(shape)
    links = [Link(0, 0.0, 1e-3), Link(0, 0.15, 1e-3, 1, 0.15, side=side * 0.1)]
    for heading in (0.0, 1.0):
        found = place_rigidly(curves, links, heading, np.arange(2))
        start = [about_z(-heading) @ curves.point(p, 0.15) + found.origins[p] for p in range(2)]
        chord = start[1] - start[0]
        assert np.linalg.norm(chord) == pytest.approx(0.1, abs=1e-6)
        conormal = about_z(-heading) @ curves.left(0, 0.15, 0)
        assert side * (chord @ conormal) > 0.099
    left = np.diff(origin, axis=0)[0] @ curves.left(0, 0.0, 0)
    assert left > 0  # the second great circle was laid to the left of the first


def test_how_well_the_heading_is_told_is_the_curvature_of_the_misfit():
    """The cost near the best heading is that plus (change / sigma)²."""
    curves, origins = three()
    links = marks(curves, origins, 0.4)
    best = place_rigidly(curves, links, None, ALL)
    step = 0.3 * best.heading_sigma
    for way in (step, -step):
        beside = place_rigidly(curves, links, best.heading + way, ALL)
        assert beside.cost - best.cost == pytest.approx(0.09, rel=0.02)


def test_starts_alone_do_not_tell_the_heading_and_ends_do():
    curves, origins = three()
    starts, ends = (
        place_rigidly(curves, marks(curves, origins, 0.4, places), None, ALL)
        for places in ((0.0,), (0.0, LENGTH))
    )
    assert starts.heading_sigma > np.radians(90)
    assert ends.heading_sigma < np.radians(1.5)
    np.testing.assert_allclose(starts.origins, origins, atol=1e-6)


def test_a_pass_that_nothing_holds_stays_at_the_origin():
    curves, origins = three()
    found = place_rigidly(curves, marks(curves, origins[:2], 0.4), 0.4, ALL)
    np.testing.assert_allclose(found.origins[2], 0.0, atol=1e-12)


def test_a_link_that_contradicts_the_others_loses():
    curves, origins = three()
    links = marks(curves, origins, 0.4, places=(0.0, 0.1, 0.2, LENGTH))
    slip = links[5]
    links[5] = Link(slip.i, slip.s, slip.sigma, target=tuple(np.add(slip.target, [0.0, 0.2, 0.0])))
    found = place_rigidly(curves, links, None, ALL)
    assert found.heading == pytest.approx(0.4, abs=np.radians(2.0))
    np.testing.assert_allclose(found.origins, origins, atol=0.02)
    np.testing.assert_allclose(found.origins[[0, 2]], origins[[0, 2]], atol=0.012)


def test_a_grosser_contradiction_costs_more():
    curves, origins = three()
    costs = []
    for away in (0.0, 0.05, 0.2, 1.0):
        links = marks(curves, origins, 0.4)
        links[1] = Link(0, LENGTH, 1e-3, target=tuple(np.add(links[1].target, [0, 0, away])))
        costs.append(place_rigidly(curves, links, None, ALL).cost)
    assert (np.diff(costs) > 5).all()


# --- candidates ---


def with_twins(passes, heading=0.4):
    """Each pass with its truth and a mirrored twin that its readings like a little better."""
    rng = np.random.default_rng(2)
    shapes, owner, cost, origins = [], [], [], []
    for p in range(passes):
        turn = exp(np.array([0.0, 0.0, 0.3 * rng.normal()]))
        bend = 1.0 + 0.5 * rng.random()
        shapes += [
            shape_of(GRID, turn @ exp(np.array([0.0, 0.5, 0.0])), constant(0.0), constant(way))
            for way in (-bend, bend)
        ]
        owner += [p, p]
        cost += [0.0, 2.0]
        origins.append([0.0, 0.1 * p, 0.0])
    curves = curves_of(both(*shapes), owner, cost)
    truth = 2 * np.arange(passes) + 1
    links = []
    for p, origin in enumerate(origins):
        for s in (0.0, LENGTH):
            there = about_z(-heading) @ curves.point(int(truth[p]), s) + origin
            links.append(Link(p, s, 5e-4, target=tuple(there)))
    return curves, links, truth, np.array(origins)


@pytest.mark.parametrize("passes", [1, 3, 8, 12])
def test_the_survey_decides_between_candidates(passes):
    """12 passes have 4096 combinations: the good one is found without trying all."""
    curves, links, truth, origins = with_twins(passes)
    assert (2.0**passes > MOST_COMBINATIONS) == (passes > 8)
    best = best_placings(curves, links, None, 60.0)[0]
    np.testing.assert_array_equal(best.choice, truth)
    np.testing.assert_allclose(best.origins, origins, atol=1e-5)
    assert best.cost == pytest.approx(2.0 * passes, abs=1e-3)


def test_where_nothing_decides_the_readings_do():
    curves, _, truth, _ = with_twins(3)
    links = [Link(p, 0.0, 5e-4, target=(0.0, 0.1 * p, 0.0)) for p in range(3)]
    found = best_placings(curves, links, 0.4, 60.0)
    np.testing.assert_array_equal(found[0].choice, truth - 1)
    assert len(found) == 8


def test_placings_come_best_first_and_none_beyond_the_limit():
    curves, links, *_ = with_twins(4)
    every = best_placings(curves, links, None, np.inf)
    assert len(every) == 16
    costs = [one.cost for one in every]
    assert costs == sorted(costs)
    within = costs[4] - costs[0] + 1e-9
    assert len(best_placings(curves, links, None, within)) == sum(
        cost <= costs[0] + within for cost in costs
    )


def test_many_combinations_keep_those_that_differ_in_one_pass():
    curves, links, truth, _ = with_twins(12)
    every = best_placings(curves, links, None, np.inf)
    assert len(every) == 1 + 12
    assert all(np.count_nonzero(one.choice != truth) <= 1 for one in every)


# --- how origins answer ---


def test_origins_answer_to_links_as_differences_say():
    curves, origins = three()
    heading = 0.4
    links = marks(curves, origins, heading)
    apart = about_z(-heading) @ (curves.point(1, 0.1) - curves.point(0, 0.1))
    apart = apart + origins[1] - origins[0]
    links.append(Link(0, 0.1, 2e-3, 1, 0.1, target=tuple(apart)))
    best = place_rigidly(curves, links, heading, ALL)
    shifts, variance = best.response(links)
    for row, link in enumerate(links):
        moved = list(links)
        target = tuple(np.add(link.target, [1e-4, 0.0, 0.0]))
        moved[row] = Link(link.i, link.s, link.sigma, link.j, link.t, target=target)
        there = place_rigidly(curves, moved, heading, ALL)
        slope = (there.origins - best.origins)[:, 0] / 1e-4
        np.testing.assert_allclose(slope, shifts[:, row], atol=1e-5)
    sigmas = np.array([link.sigma for link in links])
    np.testing.assert_allclose(variance, np.sum((shifts * sigmas) ** 2, axis=1))


def test_links_are_trusted_no_more_than_a_curve_drifts():
    curves, origins = three()
    links = marks(curves, origins, 0.4, places=(0.0,), sigma=1e-6)
    links[0] = Link(0, 0.0, 1e-6, target=tuple(np.add(origins[0], [DRIFT_SIGMA, 0.0, 0.0])))
    links.append(Link(0, 0.0, 1e-6, target=tuple(origins[0])))
    found = place_rigidly(curves, links, 0.4, ALL)
    assert found.cost == pytest.approx(0.5, rel=1e-3)


def test_points_and_conormals_between_nodes():
    curves, _ = three()
    middle = 0.5 * (GRID.nodes[3] + GRID.nodes[4])
    np.testing.assert_allclose(
        curves.point(1, middle), 0.5 * (curves.points[1, 3] + curves.points[1, 4]), atol=1e-12
    )
    assert np.linalg.norm(curves.left(1, middle, 1)) == pytest.approx(1.0)
    np.testing.assert_allclose(curves.left(1, GRID.nodes[3], 1), curves.frames[1, 3, :, 1])


def test_left_is_left_of_the_first_pass_for_passes_that_run_against_it():
    shape, _ = sphere(GRID, 0.5, (0.0, 0.1))
    about = np.diag([-1.0, -1.0, 1.0])
    frames = integrate_frames(GRID, shape)
    back = Shape(np.stack([shape.start[0], frames[1, -1] @ about]), shape.rates)
    forth, against = curves_of(shape), curves_of(back)
    np.testing.assert_allclose(against.left(1, LENGTH - 0.1, 0), forth.left(1, 0.1, 0), atol=1e-9)
    links = [Link(0, 0.0, 1e-3), Link(0, 0.15, 1e-3, 1, LENGTH - 0.15, side=0.1)]
    found = place_rigidly(against, links, 0.0, np.arange(2))
    chord = against.point(1, LENGTH - 0.15) + found.origins[1] - against.point(0, 0.15)
    assert chord @ forth.left(0, 0.15, 0) > 0.099
