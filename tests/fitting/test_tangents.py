"""The source paper's way: orientations at the sensors, their curve, and how sure it is."""

import numpy as np
import pytest
from laid import (
    DIP,
    FLAT,
    both,
    calibration,
    constant,
    degrees_between,
    lay,
    marked,
    placed,
    points_of,
    recording,
    ribbon,
    shape_of,
    sphere,
    wavy,
    without,
)

from georibbon.fitting.capture import prepare
from georibbon.fitting.grid import Shape, integrate_frames, make_grid
from georibbon.fitting.paper import fit_paper
from georibbon.fitting.placing import Link, place_rigidly
from georibbon.fitting.screening import screen
from georibbon.fitting.start import Starts, find_starts
from georibbon.fitting.tangents import (
    curves_of,
    orientation_sigma,
    position_variances,
    site_orientations,
)
from georibbon.rotations import exp

RIBBON = ribbon(16, 3)
GRID = make_grid(RIBBON)
TILTED = exp(np.array([0.4, -0.3, 0.9]))


def sites_of(laid):
    """Sites from the truth as the start of every pass."""
    owner = np.arange(len(laid.shape.start))
    return site_orientations(laid.problem, Starts(laid.shape, owner))


def paper_curves(laid):
    return curves_of(laid.grid, sites_of(laid), np.arange(len(laid.shape.start)))


def misses(pitch, twist=1.0, bend=2.0):
    """(degrees at the sites, metres on the curve) from noise-free readings of a helix."""
    of = ribbon(round(0.48 / pitch), 3, pitch)
    grid = make_grid(of)
    laid = lay(of, shape_of(grid, TILTED, constant(twist), constant(bend)), skew_seed=1)
    (sites,) = sites_of(laid)
    truth = integrate_frames(grid, laid.shape)[0]
    at = np.searchsorted(grid.nodes, sites.s - 1e-9)
    inner = slice(1, -1)
    angle = degrees_between(sites.frames[inner], truth[at][inner]).max()
    points = placed(grid, laid.shape, np.zeros((1, 3))).points[0]
    found = paper_curves(laid).points[0]
    middle = (grid.nodes > 0.1) & (grid.nodes < 0.38)
    gap = (found - points)[middle]
    return np.array([angle, np.linalg.norm(gap - gap.mean(axis=0), axis=1).max()])


def test_noise_free_readings_give_the_curve_to_second_order_in_the_pitch():
    """Gravity at a magnetometer is interpolated between its neighbours."""
    coarse, middle, fine = (misses(pitch) for pitch in (0.06, 0.03, 0.015))
    np.testing.assert_allclose(np.log2(coarse / middle), 2.0, atol=0.5)
    np.testing.assert_allclose(np.log2(middle / fine), 2.0, atol=0.5)
    assert fine[0] < 0.1
    assert fine[1] < 0.3e-3


@pytest.mark.parametrize("attitude", [FLAT, exp(np.array([np.pi, 0, 0])), TILTED])
def test_a_straight_ribbon_is_exact(attitude):
    laid = lay(RIBBON, shape_of(GRID, attitude, constant(0.0), constant(0.0)), skew_seed=3)
    found = paper_curves(laid)
    np.testing.assert_allclose(found.points[0], GRID.nodes[:, None] * attitude[:, 0], atol=1e-8)
    assert degrees_between(found.frames[0], attitude).max() < 1e-4
    assert found.cost[0] == pytest.approx(0.0, abs=1e-9)


def test_there_is_a_site_at_every_magnetometer_and_at_outer_accelerometers():
    laid = lay(RIBBON, wavy(GRID, TILTED))
    (sites,) = sites_of(laid)
    positions = [RIBBON.sensors[i].position for i in (0, *RIBBON.indices("magnetometer"))]
    np.testing.assert_allclose(sites.s, positions)
    (less,) = sites_of(without(laid, "M07", "M08", "A08", "M03"))
    expected = [RIBBON.sensors[i].position for i in (0, 1, 3, 7, 9, 11, 12)]
    np.testing.assert_allclose(less.s, expected)


def test_beyond_the_last_magnetometer_the_ribbon_goes_on_without_bending_in_its_plane():
    laid = without(
        lay(RIBBON, shape_of(GRID, TILTED, constant(0.0), constant(1.0))), "M08", "M07", "M06"
    )
    (sites,) = sites_of(laid)
    truth = integrate_frames(GRID, laid.shape)[0]
    at = np.searchsorted(GRID.nodes, sites.s - 1e-9)
    assert degrees_between(sites.frames[-3:], truth[at[-3:]]).max() < 0.5


@pytest.mark.parametrize("off", [0.3, -0.2])
def test_a_start_that_is_a_little_off_leads_to_the_same_sites(off):
    laid = lay(RIBBON, wavy(GRID, TILTED))
    (good,) = sites_of(laid)
    beside = Shape(exp(np.array([0.0, 0.0, off])) @ laid.shape.start, laid.shape.rates)
    (found,) = site_orientations(laid.problem, Starts(beside, np.array([0])))
    assert degrees_between(found.frames, good.frames).max() < 1e-3
    assert found.misfit == pytest.approx(good.misfit)


def test_a_wrong_start_has_a_misfit():
    laid = lay(RIBBON, wavy(GRID, TILTED))
    (good,) = sites_of(laid)
    back = Shape(exp(np.array([0.0, 0.0, np.pi])) @ laid.shape.start, laid.shape.rates)
    (bad,) = site_orientations(laid.problem, Starts(back, np.array([0])))
    assert good.misfit < 1.0
    assert bad.misfit > 1000.0


def test_each_start_has_its_curve():
    laid = lay(RIBBON, both(wavy(GRID, TILTED), wavy(GRID)), seed=1)
    starts = find_starts(laid.problem)
    sites = site_orientations(laid.problem, starts)
    curves = curves_of(GRID, sites, starts.owner)
    assert len(sites) == len(starts.owner) == len(curves.cost)
    np.testing.assert_array_equal(curves.owner, starts.owner)
    np.testing.assert_array_equal(curves.cost, [one.misfit for one in sites])
    np.testing.assert_allclose(curves.points[:, 0], 0.0)


# --- how sure ---


def test_an_orientations_sigma_is_that_of_many_sites():
    """Rotation errors at the sites of a flat ribbon over draws, root mean square of an axis."""
    flat = shape_of(GRID, FLAT, constant(0.0), constant(0.0))
    stack = flat.take([0] * 40)
    laid = lay(RIBBON, stack, seed=4)
    errors = [degrees_between(one.frames[1:-1], np.eye(3)) / np.sqrt(3) for one in sites_of(laid)]
    found = np.sqrt(np.mean(np.square(errors)))
    assert 0.6 < np.degrees(orientation_sigma(laid.problem)) / found < 1.6
    assert np.degrees(DIP) == pytest.approx(62.0)


def test_variances_are_those_of_curves_whose_tangents_err():
    """Against a Monte Carlo of site errors and link errors, linear throughout."""
    flat = shape_of(GRID, FLAT, constant(0.0), constant(0.0))
    laid = lay(RIBBON, both(flat, flat))
    sites = sites_of(laid)
    curves = curves_of(GRID, sites, np.arange(2))
    length = float(GRID.nodes[-1])
    links = [
        Link(0, 0.0, 1e-3),
        Link(0, length, 1e-3, target=(length, 0.0, 0.0)),
        Link(0, 0.09, 2e-3, 1, 0.09, target=(0.0, 0.1, 0.0)),
        Link(1, length, 1e-3, target=(length, 0.1, 0.0)),
    ]
    placing = place_rigidly(curves, links, 0.0, np.arange(2))
    sigma = 0.004
    variances = position_variances(curves, sites, links, placing, sigma)
    rng, draws = np.random.default_rng(5), 20_000
    knots = sites[0].s
    hats = np.stack([np.interp(GRID.nodes, knots, row) for row in np.eye(len(knots))])
    steps = 0.5 * (hats[:, 1:] + hats[:, :-1]) * GRID.steps
    drift = np.concatenate([np.zeros((len(knots), 1)), np.cumsum(steps, axis=1)], axis=1)
    heights = sigma * rng.standard_normal((draws, 2, len(knots))) @ drift
    shifts, _ = placing.response(links)
    at = [[int(np.argmin(np.abs(GRID.nodes - s))) for s in (link.s, link.t)] for link in links]
    misfit = np.stack(
        [
            heights[:, link.i, a] if link.j is None else heights[:, 1, b] - heights[:, 0, a]
            for link, (a, b) in zip(links, at, strict=True)
        ],
        axis=1,
    )
    measured = np.array([link.sigma for link in links]) * rng.standard_normal((draws, 4))
    origins = (measured - misfit) @ shifts.T
    spread = np.var(heights + origins[:, :, None], axis=0)
    np.testing.assert_allclose(variances, spread, rtol=0.06)


def test_sigma_tells_how_far_the_curves_are_off():
    """Over some captures of a sphere: the right size, within a factor."""
    shape, origin = sphere(GRID, 0.5, (-0.1, 0.0, 0.1))
    points = points_of(GRID, shape, origin)
    calibrated = calibration(RIBBON)
    ratios = []
    for seed in range(8):
        made = recording(RIBBON, shape, seed=seed, heading=0.5, marks=marked(GRID, points))
        fit = fit_paper(prepare(made, calibrated, screen(RIBBON, made.passes, calibrated)))
        variance = np.diagonal(fit.covariance, axis1=2, axis2=3)
        ratios.append(np.mean((fit.points - points) ** 2 / variance))
        assert (fit.lengths == 0).all()
        assert fit.ambiguous == (False,) * 3
        assert np.isfinite(fit.residuals).all()
    assert 0.5 < np.sqrt(np.mean(ratios)) < 2.0
