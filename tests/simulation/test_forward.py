"""The forward model: from true models and frames to counts."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.calibration.model import SensorModel
from georibbon.ribbon import Ribbon, Sensor
from georibbon.simulation.forward import CLIP, expected_counts, sample_counts
from georibbon.world import UP, field_direction

RIBBON = Ribbon(
    "GR-0001",
    0.2,
    100.0,
    (
        Sensor("A01", "accelerometer", 3, 0.05, 1000.0),
        Sensor("M01", "magnetometer", 3, 0.1, 2000.0),
        Sensor("M02", "magnetometer", 2, 0.15, 2000.0),
    ),
)
IDEAL = tuple(
    SensorModel(s.name, s.counts_per_unit * np.eye(3)[: s.axes], np.zeros(s.axes))
    for s in RIBBON.sensors
)
FIELD = field_direction(np.radians(60.0))
FRAMES = Rotation.random(3, rng=np.random.default_rng(1)).as_matrix()


def random_models(seed=2):
    rng = np.random.default_rng(seed)
    return tuple(
        SensorModel(m.name, m.gain + 100 * rng.standard_normal(m.gain.shape), 50 * m.gain[:, 0])
        for m in IDEAL
    )


def test_the_field_points_north_and_below_the_horizontal():
    np.testing.assert_allclose(FIELD, [0.0, 0.5, -np.sqrt(0.75)], atol=1e-15)


def test_ideal_sensors_give_the_frame_back():
    counts = expected_counts(RIBBON, IDEAL, FRAMES, FIELD)
    np.testing.assert_allclose(FRAMES[0] @ counts[:3] / 1000.0, UP, atol=1e-14)
    np.testing.assert_allclose(FRAMES[1] @ counts[3:6] / 2000.0, FIELD, atol=1e-14)
    np.testing.assert_allclose(counts[6:] / 2000.0, (FRAMES[2].T @ FIELD)[:2], atol=1e-14)


def test_each_reading_is_gain_times_what_is_seen_plus_bias():
    models = random_models()
    counts = expected_counts(RIBBON, models, FRAMES, FIELD)
    for sensor, columns, model, frame in zip(
        RIBBON.sensors, RIBBON.slices, models, FRAMES, strict=True
    ):
        seen = UP if sensor.kind == "accelerometer" else FIELD
        np.testing.assert_allclose(counts[columns], model.gain @ frame.T @ seen + model.bias)


def test_turning_ribbon_and_field_together_about_the_vertical_changes_nothing():
    turn = Rotation.from_euler("z", 0.7).as_matrix()
    before = expected_counts(RIBBON, random_models(), FRAMES, FIELD)
    after = expected_counts(RIBBON, random_models(), turn @ FRAMES, turn @ FIELD)
    np.testing.assert_allclose(after, before, atol=1e-9)


def test_a_magnet_adds_to_the_field_of_its_magnetometer_alone():
    added = np.zeros((3, 3))
    added[:2] = [0.1, 0.2, 0.3]
    plain = expected_counts(RIBBON, IDEAL, FRAMES, FIELD)
    moved = expected_counts(RIBBON, IDEAL, FRAMES, FIELD, added) - plain
    np.testing.assert_allclose(moved[[0, 1, 2, 6, 7]], 0.0)
    np.testing.assert_allclose(FRAMES[1] @ moved[3:6] / 2000.0, added[1], atol=1e-14)


def test_counts_are_whole_and_within_sixteen_bits():
    counts = sample_counts(
        np.array([0.4, 0.6, 1e6, -1e6]), np.zeros(4), 3, np.random.default_rng(1)
    )
    np.testing.assert_array_equal(counts, np.tile([0.0, 1.0, CLIP, -CLIP], (3, 1)))


@pytest.mark.parametrize("sigma", [5.0, 40.0])
def test_noise_is_white_and_as_large_as_asked(sigma):
    counts = sample_counts(
        np.array([100.0, -7.0]), np.array([sigma, sigma]), 20000, np.random.default_rng(3)
    )
    np.testing.assert_allclose(counts.std(axis=0), np.hypot(sigma, np.sqrt(1 / 12)), rtol=0.03)
    np.testing.assert_allclose(counts.mean(axis=0), [100.0, -7.0], atol=0.03 * sigma)
    later = np.corrcoef(counts[1:, 0], counts[:-1, 0])[0, 1]
    assert abs(later) < 0.03
    assert abs(np.corrcoef(counts.T)[0, 1]) < 0.03
