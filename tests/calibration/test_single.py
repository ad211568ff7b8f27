"""One accelerometer alone: exact without noise, honest with it, refused where poses lack."""

import numpy as np
import pytest

from georibbon.calibration import fit_accelerometer
from georibbon.calibration.single import WORST_SHIFT, _judged
from georibbon.errors import CalibrationError

GAIN = np.array([[4068.0, 14.0, 38.0], [0.0, 4045.0, -86.0], [0.0, 0.0, 4070.0]])
BIAS = np.array([33124.0, 33275.0, 32364.0])


def sphere(number):
    """(n, 3) directions spread over the sphere (a Fibonacci lattice)."""
    z = 1.0 - (2.0 * np.arange(number) + 1.0) / number
    turn = np.arange(number) * np.pi * (3.0 - np.sqrt(5.0))
    r = np.sqrt(1.0 - z**2)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def readings(directions, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    return directions @ GAIN.T + BIAS + noise * rng.normal(size=directions.shape)


@pytest.mark.parametrize("number", [9, 12, 38, 400])
def test_without_noise_gain_and_bias_are_recovered(number):
    found = fit_accelerometer(readings(sphere(number)))
    np.testing.assert_allclose(found.gain, GAIN, atol=1e-5)
    np.testing.assert_allclose(found.bias, BIAS, atol=1e-5)
    assert found.residual_mg < 1e-6
    assert found.shift < 1e-9


def test_every_pose_has_the_length_of_gravity():
    found = fit_accelerometer(readings(sphere(38), 0.4))
    lengths = np.linalg.norm(
        np.linalg.solve(found.gain, (readings(sphere(38), 0.4) - found.bias).T), axis=0
    )
    np.testing.assert_allclose(lengths, 1.0, atol=5e-4)
    assert found.residual_mg == pytest.approx(1e3 * np.sqrt(np.mean((lengths - 1.0) ** 2)))


def test_a_rotation_of_the_sensor_changes_neither_bias_nor_lengths():
    c, s = np.cos(0.3), np.sin(0.3)
    turned = sphere(38) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    found = fit_accelerometer(readings(turned))
    np.testing.assert_allclose(found.bias, BIAS, atol=1e-5)
    np.testing.assert_allclose(found.gain @ found.gain.T, GAIN @ GAIN.T, rtol=1e-9)


def test_the_gain_is_upper_triangular_with_a_positive_diagonal():
    gain = fit_accelerometer(readings(sphere(20), 0.4)).gain
    assert np.all(np.tril(gain, -1) == 0.0)
    assert np.all(np.diag(gain) > 0.0)


def test_the_order_of_the_poses_means_nothing():
    y = readings(sphere(20), 0.4)
    one, other = fit_accelerometer(y), fit_accelerometer(y[::-1])
    np.testing.assert_allclose(one.bias, other.bias, atol=1e-6)
    np.testing.assert_allclose(one.gain, other.gain, atol=1e-6)


def test_the_predicted_bias_error_is_the_found_one():
    errors = []
    for seed in range(60):
        found = fit_accelerometer(readings(sphere(30), 0.4, seed))
        errors.append((found.bias - BIAS) / found.sigma)
    assert 0.85 < np.sqrt(np.mean(np.square(errors))) < 1.15


def test_a_real_sensors_noise_leaves_a_tenth_of_a_milligravity():
    found = fit_accelerometer(readings(sphere(38), 0.45))
    assert found.residual_mg < 0.12
    assert np.abs(found.bias - BIAS).max() < 2.0
    assert found.coverage == pytest.approx(1.0, abs=0.05)
    assert found.notices == ()


def test_nine_poses_far_apart_are_enough():
    faces = np.concatenate([np.eye(3), -np.eye(3)])
    edges = np.array([[1.0, 1, 0], [0, 1, 1], [1, 0, -1]]) / np.sqrt(2.0)
    found = fit_accelerometer(readings(np.concatenate([faces, edges]), 0.4))
    assert np.abs(found.bias - BIAS).max() < 4.0


def cap(lowest, number=30):
    """(n, 3) directions with z above a height."""
    z = np.linspace(lowest, 1.0, number)
    turn = np.arange(number) * np.pi * (3.0 - np.sqrt(5.0))
    r = np.sqrt(1.0 - z**2)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


@pytest.mark.parametrize(
    ("means", "words"),
    [
        (readings(sphere(38))[:8], "8 poses were given, at least 9"),
        (np.zeros((0, 3)), "0 poses were given"),
        (readings(sphere(38))[:, :2], r"shape \(38, 2\)"),
        ([1.0, 2.0, 3.0], r"shape \(3,\)"),
        ([["a", "b", "c"]] * 10, "no table of numbers"),
        ([[1.0, 2.0], [3.0]], "no table of numbers"),
        (np.full((10, 3), np.nan), "row 1 of the poses' means"),
        (np.where(np.arange(38)[:, None] == 4, np.inf, readings(sphere(38))), "row 5"),
        (np.full((12, 3), 5.0), "all 12 poses read the same"),
        (readings(cap(0.6)), "sensor's z axis"),
        (readings(sphere(4)[[0, 1, 2, 3] * 5]), "4 different directions only"),
        (readings(np.concatenate([np.eye(3), -np.eye(3)])[[0, 1, 2, 3, 4, 5] * 4]), "6 different"),
    ],
)
def test_what_cannot_be_fitted_is_refused(means, words):
    with pytest.raises(CalibrationError, match=words):
        fit_accelerometer(means)


def test_poses_in_one_plane_are_refused_with_the_axis_that_is_missing():
    turn = np.linspace(0.0, 6.0, 20)
    ring = np.stack([np.cos(turn), 0.0 * turn, np.sin(turn)], axis=1)
    with pytest.raises(CalibrationError, match=r"one plane.*sensor's y axis"):
        fit_accelerometer(readings(ring))


def test_faces_and_small_tilts_leave_shears_free():
    """Many poses, all within a degree of the six faces: they hardly tell a shear."""
    rng = np.random.default_rng(3)
    near = np.tile(np.concatenate([np.eye(3), -np.eye(3)]), (5, 1)) + rng.normal(0, 0.002, (30, 3))
    near /= np.linalg.norm(near, axis=1)[:, None]
    with pytest.raises(CalibrationError, match=r"times their noise.*between the axes"):
        fit_accelerometer(readings(near, 0.4))


def test_weak_poses_are_told():
    found = fit_accelerometer(readings(cap(-0.1, 40), 0.05))
    assert {notice.code for notice in found.notices} == {"calibration-weak"}
    assert any("coverage" in notice.message for notice in found.notices)


def test_a_bias_that_moves_between_the_fits_is_told_or_refused():
    weak = _judged(1.0, 0.01, 1.0, sphere(20))
    assert "1.00 % of 1 g" in weak[0].message
    with pytest.raises(CalibrationError, match="algebraic"):
        _judged(1.0, 2.0 * WORST_SHIFT, 1.0, sphere(20))


def test_few_spread_poses_are_told_by_what_they_do_to_noise():
    assert "20 times their noise" in _judged(1.0, 0.0, 20.0, sphere(20))[0].message


def test_poses_that_lie_on_no_ellipsoid_are_refused():
    """A hyperboloid fits them best: the geometric fit starts from a sphere, and finds no truth."""
    turn = np.linspace(0.0, 6.0, 8, endpoint=False)
    rings = [
        np.stack([np.cosh(h) * np.cos(turn), np.cosh(h) * np.sin(turn), 0 * turn + np.sinh(h)], 1)
        for h in (-1.0, 0.0, 1.0)
    ]
    with pytest.raises(CalibrationError, match="poses"):
        fit_accelerometer(np.concatenate(rings))
