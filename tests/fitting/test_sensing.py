"""What sensors say: counts to units, and the covariance of what contact and noise leave."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laid import FLAT, calibration, counts, lay, ribbon, wavy

from georibbon.calibration.model import Calibration, SensorModel
from georibbon.fitting.grid import make_grid
from georibbon.fitting.sensing import Noise, Observations, SensorArray, observe, whitening
from georibbon.rotations import exp
from georibbon.world import field_direction

RIBBON = ribbon(4)


def array_of(gain, axes, field):
    """One sensor as an array."""
    return SensorArray(
        gain=np.array(gain)[None],
        bias=np.zeros((1, 3)),
        scale=np.ones(1),
        axes=np.array([[True] * axes + [False] * (3 - axes)]),
        field=np.array([field]),
        used=np.array([True]),
    )


def observed(sigma, present=True):
    return Observations(np.zeros((1, 1, 3)), np.array(sigma)[None, None], np.array([[present]]))


def test_the_array_predicts_the_counts_of_the_calibration():
    of, calibrated = RIBBON, calibration(RIBBON, seed=3)
    array = SensorArray.of(of, calibrated)
    grid = make_grid(of)
    frames = np.tile(exp(np.array([0.3, -0.8, 2.0])), (1, len(grid.sensor_nodes), 1, 1))
    said = counts(of, calibrated.sensors, frames, field_direction(1.0, 0.4))[0]
    for i, (sensor, where) in enumerate(zip(of.sensors, of.slices, strict=True)):
        up = field_direction(1.0, 0.4) if sensor.kind == "magnetometer" else np.array([0, 0, 1.0])
        units = array.gain[i] @ frames[0, i].T @ up
        back = array.scale[i] * units + array.bias[i]
        np.testing.assert_allclose(back[: sensor.axes], said[where], rtol=1e-12)
        np.testing.assert_array_equal(array.axes[i], np.arange(3) < sensor.axes)
    np.testing.assert_array_equal(array.field, [False, True, False, True])


def test_units_are_about_one_g_and_one_field():
    array = SensorArray.of(RIBBON, calibration(RIBBON, seed=4))
    counts_per_unit = [sensor.counts_per_unit for sensor in RIBBON.sensors]
    np.testing.assert_allclose(array.scale, counts_per_unit, rtol=0.1)


@pytest.mark.parametrize("axes", [2, 3])
def test_the_inverse_gives_the_least_vector_of_a_reading(axes):
    array = SensorArray.of(ribbon(4, axes), calibration(ribbon(4, axes), seed=6))
    vectors = np.random.default_rng(0).normal(size=(4, 3, 1))
    readings = array.gain @ vectors
    back = array.inverse @ readings
    np.testing.assert_allclose(array.gain @ back, readings, atol=1e-12)
    assert np.all(np.linalg.norm(back, axis=1) <= np.linalg.norm(vectors, axis=1) + 1e-12)
    np.testing.assert_allclose(back[::2], vectors[::2], atol=1e-12)


def test_observing_undoes_bias_and_scale():
    of, calibrated = RIBBON, calibration(RIBBON, seed=5)
    array = SensorArray.of(of, calibrated)
    means = np.random.default_rng(1).normal(1000, 300, (2, len(of.columns)))
    found = observe(of, array, means, np.full_like(means, 7.0))
    for i, where in enumerate(of.slices):
        k = of.sensors[i].axes
        back = found.values[:, i, :k] * array.scale[i] + array.bias[i, :k]
        np.testing.assert_allclose(back, means[:, where], rtol=1e-12)
        np.testing.assert_allclose(found.sigma[:, i, :k], 7.0 / array.scale[i])
        assert (found.values[:, i, k:] == 0).all()
    assert found.present.all()
    np.testing.assert_array_equal(found.take([1]).values, found.values[1:])


def test_a_sensor_with_a_missing_axis_is_absent_in_that_pass_alone():
    array = SensorArray.of(RIBBON, calibration(RIBBON))
    means = np.ones((2, len(RIBBON.columns)))
    means[1, RIBBON.slices[2].start] = np.nan
    found = observe(RIBBON, array, means, np.ones_like(means))
    np.testing.assert_array_equal(found.present, [[True] * 4, [True, True, False, True]])
    assert np.isfinite(found.values).all()


def test_a_sensor_whose_scatter_is_unknown_is_absent():
    array = SensorArray.of(RIBBON, calibration(RIBBON))
    means = np.ones((1, len(RIBBON.columns)))
    sigmas = np.ones_like(means)
    sigmas[0, 0] = np.nan
    found = observe(RIBBON, array, means, sigmas)
    assert not found.present[0, 0]
    assert np.isfinite(found.sigma).all()


def test_what_the_calibration_leaves_out_is_never_present():
    models = list(calibration(RIBBON).sensors)
    models[1] = replace(models[1], used=False, reason="dead")
    models[2] = SensorModel("A02", np.zeros((3, 3)), np.zeros(3))
    array = SensorArray.of(RIBBON, Calibration(RIBBON.id, 1.0, tuple(models)))
    means = np.ones((1, len(RIBBON.columns)))
    found = observe(RIBBON, array, means, means)
    np.testing.assert_array_equal(found.present, [[True, False, False, True]])
    assert np.isfinite(array.gain).all()


@pytest.mark.parametrize(("axes", "field"), [(3, False), (3, True), (2, True)])
def test_the_covariance_is_that_of_many_layings(axes, field):
    """Contact turns the sensor a little, each axis has its own noise: drawn 200 000 times."""
    rng = np.random.default_rng(8)
    gain = np.eye(3) + 0.2 * rng.normal(size=(3, 3))
    gain[axes:] = 0.0
    u = np.array([0.36, -0.48, 0.8])
    noise, scatter = Noise(0.03, 0.01, 0.02), np.array([0.02, 0.005, 0.03]) * (np.arange(3) < axes)
    floor = noise.field if field else noise.acceleration
    n = 200_000
    turned = exp(noise.contact * rng.standard_normal((n, 3))) @ u
    spread = np.where(np.arange(3) < axes, np.hypot(scatter, floor), 0.0)
    said = turned @ gain.T + spread * rng.standard_normal((n, 3))
    white = whitening(array_of(gain, axes, field), observed(scatter), noise, u[None, None])[0, 0]
    whitened = (said - gain @ u) @ white.T
    expected = np.diag((np.arange(3) < axes).astype(float))
    np.testing.assert_allclose(whitened.T @ whitened / n, expected, atol=0.015)


directions = (
    st.tuples(*(st.floats(-1, 1),) * 3)
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)


@given(directions, st.integers(0, 1000), st.sampled_from([2, 3]))
def test_whitening_is_a_root_of_the_inverse_covariance(u, seed, axes):
    rng = np.random.default_rng(seed)
    gain = rng.normal(size=(3, 3))
    gain[axes:] = 0.0
    sigma = rng.uniform(0.0, 0.02, 3) * (np.arange(3) < axes)
    noise = Noise()
    white = whitening(array_of(gain, axes, True), observed(sigma), noise, u[None, None])[0, 0]
    covariance = noise.contact**2 * gain @ (np.eye(3) - np.outer(u, u)) @ gain.T
    covariance += np.diag(sigma**2 + noise.field**2)
    within = (slice(axes), slice(axes))
    information = np.linalg.inv(covariance[within])
    np.testing.assert_allclose((white.T @ white)[within], information, rtol=1e-7, atol=1e-3)
    np.testing.assert_allclose(white[axes:, :axes], 0.0, atol=1e-12)


def test_contact_says_nothing_along_the_vector_itself():
    """Turning a sensor about gravity changes nothing; along it only the floor is left."""
    u = np.array([0.0, 0.0, 1.0])
    white = whitening(array_of(np.eye(3), 3, False), observed([0.0] * 3), Noise(), u[None, None])
    assert white[0, 0, 2, 2] == pytest.approx(1 / Noise().acceleration)
    assert white[0, 0, 0, 0] == pytest.approx(1 / np.hypot(Noise().contact, Noise().acceleration))


def test_an_absent_sensor_has_no_weight():
    white = whitening(
        array_of(np.eye(3), 3, True), observed([0.0] * 3, False), Noise(), np.ones((1, 1, 3)) / 3
    )
    assert (white == 0).all()


def test_noise_free_readings_of_a_laid_ribbon_have_no_residual():
    of = ribbon(12)
    laid = lay(of, wavy(make_grid(of), FLAT), skew_seed=2)
    assert laid.problem.observations.present.all()
    assert np.abs(laid.problem.observations.values).max() < 2.0
