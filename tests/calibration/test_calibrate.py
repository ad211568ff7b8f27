"""Laws of the whole calibration: what is exact, what changes nothing, what is honest."""

from dataclasses import replace

import numpy as np
import pytest
from bar import SIXTEEN, TWELVE, TWENTY, Bar, codes, errors

from georibbon.calibration import calibrate
from georibbon.notices import Notice


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("plan", [TWELVE, SIXTEEN, TWENTY], ids=["12", "16", "20"])
def test_without_noise_every_parameter_is_recovered(axes, plan):
    bar = Bar(seed=1, axes=axes, noise=0.0)
    found = calibrate(bar.ribbon, bar.poses(plan))
    assert max(errors(found, bar)) < 1e-8
    assert found.dip == pytest.approx(bar.dip, abs=1e-8)
    assert found.notices == ()
    assert found.quality.poses == len(plan)
    assert found.quality.accelerometer_residual_mg < 1e-5


@pytest.mark.parametrize("dip", [-62.0, 5.0, 30.0, 76.0])
def test_any_inclination_is_found(dip):
    bar = Bar(seed=2, dip=np.radians(dip), noise=0.0)
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert np.degrees(found.dip) == pytest.approx(dip, abs=1e-6)
    assert max(errors(found, bar)) < 1e-8


def test_the_order_of_the_poses_means_nothing():
    bar = Bar(seed=3)
    poses = bar.poses(TWENTY)
    one, other = calibrate(bar.ribbon, poses), calibrate(bar.ribbon, poses[::-1])
    for a, b in zip(one.sensors, other.sensors, strict=True):
        np.testing.assert_allclose(a.gain, b.gain, rtol=0, atol=0.02)
        np.testing.assert_allclose(a.bias, b.bias, rtol=0, atol=0.02)


def test_all_headings_turned_by_one_angle_mean_nothing():
    bar = Bar(seed=4)
    poses = bar.poses(SIXTEEN)
    turned = [replace(pose, heading=pose.heading + 77.0) for pose in poses]
    one, other = calibrate(bar.ribbon, poses), calibrate(bar.ribbon, turned)
    for a, b in zip(one.sensors, other.sensors, strict=True):
        np.testing.assert_allclose(a.gain, b.gain, rtol=0, atol=0.02)


def test_a_turn_of_all_sensors_together_turns_the_gains():
    """The faces of the bar hold the frame: a common mounting error is seen, not absorbed."""
    bar = Bar(seed=5, noise=0.0)
    c, s = np.cos(np.radians(3.0)), np.sin(np.radians(3.0))
    common = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    bar.truth = [(gain @ common, bias) for gain, bias in bar.truth]
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert max(errors(found, bar)) < 1e-8


def test_the_models_have_the_ribbons_order_and_shapes():
    bar = Bar(seed=6)
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert found.ribbon_id == bar.ribbon.id
    for model, sensor in zip(found.sensors, bar.ribbon.sensors, strict=True):
        assert model.name == sensor.name
        assert model.gain.shape == (sensor.axes, 3)
        assert model.bias.shape == (sensor.axes,)


def test_errors_are_as_large_as_noise_and_poses_predict():
    """Over many ribbons the bias' error is the noise's through the normal matrices (A)."""
    ratios = []
    for seed in range(5):
        bar = Bar(seed=seed, sensors=8, frames=20)
        found = calibrate(bar.ribbon, bar.poses(TWENTY))
        noise_mg = 1.0 / np.sqrt(bar.frames)
        predicted = found.quality.magnetometer_percent * noise_mg
        ratios.append(100.0 * errors(found, bar)[1] / predicted)
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 3.0


def test_the_bend_of_the_bar_is_what_remains_of_the_tilt():
    """With 0.2 degrees of bend about each axis a tilt's error is the predicted 0.29."""
    squares, predicted = [], []
    for seed in range(4):
        bar = Bar(seed=20 + seed, bend=0.2, sensors=16)
        found = calibrate(bar.ribbon, bar.poses(TWENTY))
        predicted.append(found.quality.tilt)
        for model, (gain, bias) in zip(found.sensors[::2], bar.truth[::2], strict=True):
            for up in (np.array([0.0, 0, 1]), np.array([0.0, 0.6, 0.8]), np.array([0.6, 0, 0.8])):
                seen = np.linalg.solve(model.gain, gain @ up + bias - model.bias)
                squares.append(np.sum(np.cross(seen, up) ** 2))
    tilt = np.degrees(np.sqrt(np.mean(squares)))
    assert np.mean(predicted) == pytest.approx(0.29, abs=0.02)
    assert tilt == pytest.approx(np.mean(predicted), rel=0.2)


def test_a_steep_field_makes_headings_worse():
    flat, steep = (
        calibrate(bar.ribbon, bar.poses(TWENTY)).quality
        for bar in (Bar(seed=8, dip=np.radians(20.0)), Bar(seed=8, dip=np.radians(75.0)))
    )
    assert steep.heading > 2.0 * flat.heading


def test_the_remaining_uncertainties_are_told():
    bar = Bar(seed=9)
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert np.degrees(found.mounting_sigma) == pytest.approx(0.2)
    assert 0.0 < np.degrees(found.gauge_sigma) < 0.1
    assert 0.0 < np.degrees(found.dip_sigma) < 0.1


def test_no_headings_at_all_are_needed():
    bar = Bar(seed=10)
    poses = [replace(pose, heading=0.0) for pose in bar.poses(TWENTY)]
    found = calibrate(bar.ribbon, poses)
    assert max(errors(found, bar)) < 0.01
    notices = [n for n in found.notices if n.code == "pose-heading-corrected"]
    assert len(notices) == 1
    assert isinstance(notices[0], Notice)
    assert "poses only" in notices[0].message


def test_reversed_magnetometers_show_only_as_a_field_that_points_up():
    """The mirror solution fits as well: (-dip, heading + 180, -S)."""
    bar = Bar(seed=11)
    bar.truth = [
        (gain if sensor.kind == "accelerometer" else -gain, bias)
        for (gain, bias), sensor in zip(bar.truth, bar.ribbon.sensors, strict=True)
    ]
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert np.degrees(found.dip) == pytest.approx(-65.0, abs=0.3)
    assert codes(found) == {"field-points-up"}
    assert all(np.trace(model.gain[:2, :2]) > 0 for model in found.sensors)
