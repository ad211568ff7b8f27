"""Smoothing: a length for people, chosen by the evidence."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import FLAT, both, constant, lay, ribbon, shape_of

from georibbon.fitting.grid import integrate_frames, make_grid
from georibbon.fitting.sensing import Noise
from georibbon.fitting.smoothing import (
    best_contact,
    best_lengths,
    information_density,
    length_of_weight,
    length_range,
    weight_of_length,
)
from georibbon.fitting.strip import fit_strips

RIBBON = ribbon(24, 3)
GRID = make_grid(RIBBON)
positive = st.floats(1e-3, 10.0)


@given(positive, st.floats(1e3, 1e9))
def test_length_and_weight_are_inverse(length, density):
    weight = weight_of_length(length, density)
    assert length_of_weight(weight, density) == pytest.approx(length, rel=1e-12)


@given(positive, positive)
def test_a_longer_length_is_a_greater_weight(one, other):
    assert (weight_of_length(one, 1e5) <= weight_of_length(other, 1e5)) == (one <= other)


def density_of(of, noise=None):
    return information_density(lay(of, shape_of(make_grid(of), FLAT, *ZERO), noise=noise).problem)


ZERO = (constant(0.0), constant(0.0))


def test_information_grows_with_sensors_axes_and_quiet():
    usual = Noise()
    half = Noise(0.5 * usual.contact, 0.5 * usual.acceleration, 0.5 * usual.field)
    assert density_of(RIBBON, half) == pytest.approx(4 * density_of(RIBBON))
    assert density_of(ribbon(24, 3, pitch=0.06)) == pytest.approx(0.5 * density_of(RIBBON))
    assert density_of(ribbon(48, 3)) == pytest.approx(density_of(RIBBON))
    assert density_of(ribbon(24, 2)) < density_of(RIBBON)


def test_sensors_that_are_not_used_do_not_inform():
    laid = lay(RIBBON, shape_of(GRID, FLAT, *ZERO))
    used = np.arange(24) >= 12
    problem = replace(laid.problem, array=replace(laid.problem.array, used=used))
    assert information_density(problem) == pytest.approx(0.5 * density_of(RIBBON))


def share_passed(wave, length):
    """How much of a wave of that length in the bending comes through the fit."""
    amplitude = 0.02
    shape = shape_of(
        GRID,
        FLAT,
        constant(0.0),
        lambda s: amplitude * (2 * np.pi / wave) * np.cos(2 * np.pi * s / wave),
    )
    laid = lay(RIBBON, shape)
    weight = weight_of_length(length, information_density(laid.problem))
    strips = fit_strips(laid.problem, shape, np.array([float(weight)]))
    inside = slice(len(GRID.nodes) // 4, -len(GRID.nodes) // 4)
    slope, true = (
        np.arcsin(integrate_frames(GRID, one)[0, inside, 2, 0]) for one in (strips.shape, shape)
    )
    slope, true = slope - slope.mean(), true - true.mean()
    return float(slope @ true / (true @ true))


@pytest.mark.parametrize("wave", [0.24, 0.36])
def test_half_of_a_wave_of_the_smoothing_length_passes(wave):
    """Roughly: the readings do not tell all rotations alike."""
    assert 0.35 < share_passed(wave, wave) < 0.75
    assert share_passed(wave, 0.6 * wave) > 0.9
    assert share_passed(wave, 1.6 * wave) < 0.2


def lengths_for(*bends, seed=1):
    """The evidence's lengths for strips with these bending rates."""
    truth = both(*(shape_of(GRID, FLAT, constant(0.1), bend) for bend in bends))
    laid = lay(RIBBON, truth, seed=seed)
    weight = weight_of_length(0.12, information_density(laid.problem))
    strips = fit_strips(laid.problem, truth, np.full(len(bends), float(weight)))
    return best_lengths(laid.problem, strips)


def test_the_evidence_prefers_long_lengths_for_smooth_and_short_for_rough():
    smooth, rough, rougher = lengths_for(
        constant(0.8),
        lambda s: 1.5 * np.sin(2 * np.pi * s / 0.3),
        lambda s: 6.0 * np.sin(2 * np.pi * s / 0.18),
    )
    assert smooth > 1.5 * rough > 1.5 * rougher


def test_lengths_stay_between_a_spline_interval_and_the_ribbon():
    low, high = length_range(GRID)
    assert low == pytest.approx(0.72 / 12)
    assert high == pytest.approx(0.72)
    for found in lengths_for(constant(0.0), lambda s: 40.0 * np.sin(2 * np.pi * s / 0.13)):
        assert low <= found <= high


def test_a_straight_ribbon_is_smoothed_over_its_whole_length():
    """Nothing but noise: the longest length that is tried, or nearly, over many draws."""
    found = np.array([lengths_for(constant(0.0), seed=seed)[0] for seed in range(8)])
    assert np.median(found) > 0.4


def test_the_chosen_length_gives_curves_about_as_good_as_any():
    def bend(s):
        return 2.0 * np.sin(2 * np.pi * s / 0.35)

    shape = shape_of(GRID, FLAT, constant(0.1), bend)
    chosen = float(lengths_for(bend)[0])
    errors = []
    for length in (chosen, *np.geomspace(0.06, 0.7, 8)):
        misses = []
        for seed in range(4):
            laid = lay(RIBBON, shape, seed=seed)
            weight = weight_of_length(length, information_density(laid.problem))
            strips = fit_strips(laid.problem, shape, np.array([float(weight)]))
            away = integrate_frames(GRID, strips.shape) - integrate_frames(GRID, shape)
            misses.append(np.sqrt(np.mean(away[..., 2] ** 2)))
        errors.append(np.mean(misses))
    assert errors[0] < 1.2 * min(errors[1:])
    assert errors[0] < 0.6 * max(errors[1:])


def contact_found(truly, *, magnet=False, passes=5, seed=0):
    """What the evidence says of the contact's noise, over what is usual."""
    usual = Noise()
    bends = [lambda s, k=k: 1.0 + 0.5 * np.sin(4.0 * s + k) for k in range(passes)]
    truth = both(*(shape_of(GRID, FLAT, constant(0.1), bend) for bend in bends))
    laid = lay(RIBBON, truth, seed=seed, noise=replace(usual, contact=truly * usual.contact))
    observed = laid.problem.observations
    if magnet:
        values = observed.values.copy()
        values[1, 9:16:2] += 0.25
        observed = replace(observed, values=values)
    problem = replace(laid.problem, noise=usual, observations=observed)
    weight = weight_of_length(0.2, information_density(problem))
    strips = fit_strips(problem, truth, np.full(passes, float(weight)))
    return best_contact(problem, strips) / usual.contact


@pytest.mark.parametrize("truly", [1.5, 2.0, 3.0])
def test_the_contact_noise_is_found(truly):
    found = np.array([contact_found(truly, seed=seed) for seed in range(6)])
    assert np.abs(found / truly - 1.0).max() < 0.25
    assert abs(found.mean() / truly - 1.0) < 0.1


@pytest.mark.parametrize("magnet", [False, True])
@pytest.mark.parametrize("truly", [0.2, 1.0])
def test_usual_readings_and_a_magnet_are_no_greater_noise(truly, magnet):
    found = [contact_found(truly, magnet=magnet, seed=seed) for seed in range(6)]
    assert min(found) >= 1.0
    assert max(found) < 1.2


def test_a_single_pass_tells_less_of_the_noise_than_many():
    one = np.array([contact_found(2.0, passes=1, seed=seed) for seed in range(8)])
    many = np.array([contact_found(2.0, passes=6, seed=seed) for seed in range(8)])
    assert many.std() < one.std()
