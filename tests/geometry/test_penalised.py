"""Penalised splines keep their gain law, agree with SciPy's, and choose their cut well."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_smoothing_spline

from georibbon.errors import SurfaceError
from georibbon.geometry.penalised import (
    PenalisedFit,
    best_cut,
    cuts_for,
    penalised_spline,
    roughness_bands,
)

CUT = 0.1


def gain(s, wavelength, cut=CUT, order=2):
    """How much of a wave is left, away from the ends."""
    wave = np.sin(2 * np.pi * s / wavelength)
    smooth = penalised_spline(s, wave, cut, order=order)(s)
    inside = (s > 0.5) & (s < 1.5)
    return smooth[inside] @ wave[inside] / (wave[inside] @ wave[inside])


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("share", [0.5, 1.0, 2.0, 4.0])
def test_the_gain_of_a_wave_is_that_of_the_law(share, order):
    s = np.linspace(0.0, 2.0, 801)
    exact = 2e-3 if order == 2 else 0.02  # a cubic's third derivative has steps
    assert gain(s, share * CUT, order=order) == pytest.approx(
        1 / (1 + share ** (-2 * order)), abs=exact
    )


def test_half_of_a_wave_as_long_as_the_cut_passes_whatever_the_sampling():
    rng = np.random.default_rng(4)
    for s in (
        np.linspace(0, 2, 161),
        np.sort(rng.uniform(0, 2, 2000)),
        2 * np.linspace(0, 1, 900) ** 1.5,
    ):
        assert gain(s, CUT) == pytest.approx(0.5, abs=0.03)


def test_a_line_stays_as_it_is():
    s = np.sort(np.random.default_rng(1).uniform(0, 1, 30))
    line = np.stack([3.0 - 2.0 * s, 0.5 + s], axis=1)
    for cut in (0.02, 0.3, 5.0):
        np.testing.assert_allclose(penalised_spline(s, line, cut)(s), line, atol=1e-9)


def test_order_three_keeps_a_parabola_and_with_it_the_bend_at_the_ends():
    s = np.sort(np.random.default_rng(1).uniform(0, 1, 40))
    parabola = 3.0 * s**2 - s
    for cut in (0.05, 0.4, 5.0):
        spline = penalised_spline(s, parabola, cut, order=3)
        np.testing.assert_allclose(spline(s), parabola, atol=1e-7)
        np.testing.assert_allclose(spline(s[[0, -1]], nu=2), 6.0, rtol=1e-3)
    flat = penalised_spline(s, parabola, 0.4)
    assert np.abs(flat(s[[0, -1]], nu=2)).max() < 3.0


def test_it_is_the_smoothing_spline_with_its_knots_at_the_places():
    s = np.linspace(0.0, 1.0, 200)
    noisy = np.random.default_rng(2).normal(size=200)
    ours = penalised_spline(s, noisy, 0.2)(s)
    theirs = make_smoothing_spline(s, noisy, lam=(0.2 / (2 * np.pi)) ** 4 / s[1])(s)
    assert np.abs(theirs).max() > 0.15
    np.testing.assert_allclose(ours, theirs, atol=4e-3)


@pytest.mark.parametrize("order", [2, 3])
def test_the_roughness_is_the_integral_of_a_derivative_squared(order):
    fit = PenalisedFit(np.linspace(0.0, 1.0, 30), 0.2)
    count = fit.information.shape[1]
    coefficients = np.random.default_rng(3).normal(size=count)
    bands = roughness_bands(count, fit.knots[1] - fit.knots[0], order)
    full = np.zeros((count, count))
    for k, band in enumerate(bands):
        full += np.diag(band[: count - k], -k)
        full += np.diag(band[: count - k], k) if k else 0.0
    x = (np.arange(200_000) + 0.5) / 200_000
    rough = BSpline(fit.knots, coefficients, 3)(x, nu=order)
    assert coefficients @ full @ coefficients == pytest.approx(np.mean(rough**2), rel=1e-6)


def test_the_degrees_of_freedom_are_the_trace_of_what_is_done_to_values():
    s = np.sort(np.random.default_rng(5).uniform(0, 1, 40))
    weights = np.random.default_rng(6).uniform(0.1, 2.0, 40)
    fit = PenalisedFit(s, 0.15, weights)
    assert fit.degrees_of_freedom == pytest.approx(np.trace(fit.spline(np.eye(40))(s)), rel=1e-9)


def test_what_has_no_weight_has_no_say():
    s = np.linspace(0.0, 1.0, 60)
    values, weights = np.cos(5 * s), np.where(np.arange(60) % 3, 1.0, 0.0)
    wild = np.where(weights > 0, values, 1e3)
    np.testing.assert_allclose(
        penalised_spline(s, wild, 0.1, weights)(s), penalised_spline(s, values, 0.1, weights)(s)
    )


def test_columns_are_smoothed_each_by_itself():
    s = np.linspace(0.0, 1.0, 50)
    values = np.random.default_rng(7).normal(size=(50, 3))
    together = penalised_spline(s, values, 0.1)(s)
    for k in range(3):
        np.testing.assert_allclose(together[:, k], penalised_spline(s, values[:, k], 0.1)(s))


@pytest.mark.parametrize("noise", [0.02, 0.1, 0.5])
def test_cross_validation_finds_a_cut_nearly_as_good_as_the_best(noise):
    s = np.linspace(0.0, 1.0, 120)
    truth = np.sin(9 * s) + 0.3 * np.cos(23 * s)
    ratios = []
    for seed in range(5):
        noisy = truth + noise * np.random.default_rng(seed).normal(size=120)
        errors = {
            cut: np.sqrt(np.mean((penalised_spline(s, noisy, cut)(s) - truth) ** 2))
            for cut in cuts_for(s)
        }
        ratios.append(errors[best_cut(s, noisy)] / min(errors.values()))
    assert np.median(ratios) < 1.15


def test_exact_values_are_left_nearly_as_they_are():
    s = np.linspace(0.0, 1.0, 100)
    assert best_cut(s, np.sin(6 * s)) == cuts_for(s)[0]
    assert best_cut(s, np.sin(6 * s), cuts=[0.5, 0.03, 0.1]) == 0.03


@pytest.mark.parametrize(
    ("s", "cut", "weights", "told"),
    [
        ([0.0], 0.1, None, "at least 2"),
        ([0.0, 0.2, 0.2], 0.1, None, "ascending"),
        ([0.0, 0.1, 0.2], 0.0, None, "above 0 mm"),
        ([0.0, 0.1, 0.2], np.nan, None, "above 0 mm"),
        ([0.0, 0.1, 0.2], 0.1, [0.0, 1.0, 0.0], "fewer than 2"),
    ],
)
def test_what_means_nothing_is_refused(s, cut, weights, told):
    with pytest.raises(SurfaceError, match=told):
        PenalisedFit(np.array(s), cut, None if weights is None else np.array(weights))


def test_places_too_uneven_for_the_numbers_are_refused():
    s = np.append(np.linspace(0.0, 1e-3, 300), 1e4)
    with pytest.raises(SurfaceError, match="too unevenly"):
        penalised_spline(s, np.sin(1e3 * s), 1e-4, order=3)
