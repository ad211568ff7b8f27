"""Each fault is found by name, and the other sensors do not suffer."""

from dataclasses import replace

import numpy as np
import pytest
from bar import SIXTEEN, TWENTY, Bar, codes, errors, relabelled, told
from scipy.spatial.transform import Rotation

from georibbon.calibration import calibrate
from georibbon.errors import CalibrationError

FINE = 0.012


def sound(bar, plan=TWENTY, poses=None):
    """A calibration in which every sensor still used is right."""
    found = calibrate(bar.ribbon, bar.poses(plan) if poses is None else poses)
    assert max(errors(found, bar)) < FINE
    return found


def on(name, change):
    """A fault of the counts of one sensor."""
    return lambda place, sensor, y: change(place, y) if sensor.name == name else y


def unused(found):
    return [model.name for model in found.sensors if not model.used]


def with_axis(y, axis, value):
    y = y.copy()
    y[:, axis] = value
    return y


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("M04", lambda _p, y: y * 0.0 + 7.0, "its x and y axes did not move"),
        ("A03", lambda _p, y: y * 0.0 - 3.0, "its x, y and z axes did not move"),
        ("A03", lambda _p, y: with_axis(y, 1, 12.0), "its y axis did not move"),
        ("M02", lambda _p, y: with_axis(y, 0, np.nan), "its x axis gave values in fewer than 8"),
    ],
)
def test_a_dead_sensor_or_axis_is_left_out_by_name(name, change, words):
    bar = Bar(seed=1, counts=on(name, change))
    found = sound(bar)
    assert unused(found) == [name]
    assert codes(found) == {"sensor-dead"}
    [notice] = told(found, "sensor-dead")
    assert notice.sensor == name
    assert words in notice.message
    model = next(model for model in found.sensors if model.name == name)
    assert words in model.reason
    assert np.all(model.bias == 0.0)


def test_half_of_the_magnetometers_dead_are_all_named():
    dead = {"M01", "M03", "M05"}
    bar = Bar(seed=1, counts=lambda _p, s, y: y * 0.0 if s.name in dead else y)
    assert set(unused(sound(bar))) == dead


def test_a_pose_in_which_every_magnetometer_is_saturated_still_counts_for_gravity():
    bar = Bar(seed=1, counts=lambda p, s, y: 0 * y + 9000.0 if p == 6 and s.name[0] == "M" else y)
    found = sound(bar)
    assert len(told(found, "sensor-saturated")) == 6
    assert found.quality.poses == 20


@pytest.mark.parametrize(
    ("name", "order", "signs", "words"),
    [
        ("A05", [0, 1, 2], [-1, 1, 1], "-x +y +z"),
        ("A05", [1, 0, 2], [1, 1, 1], "+y +x +z"),
        ("A05", [0, 1, 2], [-1, -1, 1], "-x -y +z"),
        ("M05", [1, 0], [1, 1], "+y +x"),
        ("M05", [0, 1], [1, -1], "+x -y"),
    ],
)
def test_swapped_and_flipped_axes_are_told_as_they_are(name, order, signs, words):
    bar = Bar(seed=2, counts=on(name, lambda _p, y: y[:, order] * np.array(signs)))
    found = sound(bar)
    assert unused(found) == [name]
    [notice] = told(found, "sensor-axes-swapped")
    assert f"its axes are {words} of the ribbon's" in notice.message


def test_a_sensor_with_another_scale_is_left_out():
    bar = Bar(seed=3, counts=on("A02", lambda _p, y: y * 2.0))
    found = sound(bar)
    assert unused(found) == ["A02"]
    assert "times what its counts_per_unit says" in told(found, "sensor-scale")[0].message


def test_a_ribbon_whose_accelerometers_all_have_another_scale_is_refused():
    bar = Bar(seed=3, counts=lambda _p, s, y: y * 2.0 if s.kind == "accelerometer" else y)
    with pytest.raises(CalibrationError, match="counts_per_unit"):
        calibrate(bar.ribbon, bar.poses(SIXTEEN))


def test_a_ribbon_whose_magnetometers_all_have_another_scale_is_refused():
    bar = Bar(seed=3, counts=lambda _p, s, y: y * 9.0 if s.kind == "magnetometer" else y)
    with pytest.raises(CalibrationError, match="counts_per_unit"):
        calibrate(bar.ribbon, bar.poses(SIXTEEN))


def test_saturated_cells_are_left_out():
    bar = Bar(seed=4, counts=on("A04", lambda _p, y: np.minimum(y, 0.9 * 16384.0)))
    found = sound(bar)
    [notice] = told(found, "sensor-saturated")
    assert notice.sensor == "A04"
    assert "of 20 poses" in notice.message
    assert unused(found) == []


def test_a_sensor_saturated_in_most_poses_is_left_out():
    bar = Bar(seed=4, counts=on("A04", lambda _p, y: np.clip(y, -8000.0, 8000.0)))
    found = sound(bar)
    assert "sensor-saturated" in codes(found)
    assert unused(found) == ["A04"]


def test_steel_near_one_pose_is_that_poses():
    steel = np.array([0.15, -0.1, 0.12])
    bar = Bar(seed=5, field=lambda place, s: steel * (1 + s.position) if place == 7 else 0.0)
    found = sound(bar)
    assert codes(found) == {"pose-disturbed"}
    assert "pose 8 (" in told(found, "pose-disturbed")[0].message


def test_steel_near_a_few_sensors_in_one_pose_is_those_cells():
    near = {"M02", "M03"}
    field = np.array([0.1, 0.15, -0.1])
    bar = Bar(seed=6, field=lambda p, s: field if p == 3 and s.name in near else 0.0)
    found = sound(bar)
    [notice] = told(found, "pose-cell-disturbed")
    assert "pose 4 (" in notice.message
    assert "M02, M03" in notice.message
    assert notice.sensor is None


def test_one_disturbed_cell_names_its_sensor():
    field = np.array([0.1, 0.15, -0.1])
    bar = Bar(seed=6, field=lambda p, s: field if p == 3 and s.name == "M03" else 0.0)
    [notice] = told(sound(bar), "pose-cell-disturbed")
    assert notice.sensor == "M03"


def test_a_bar_that_was_accelerated_is_told():
    bar = Bar(seed=7, specific=lambda place, _s: np.array([0, 0, 0.03]) if place == 2 else 0.0)
    found = sound(bar)
    assert any("pose 3 (" in n.message for n in told(found, "pose-disturbed"))


def test_a_loose_accelerometer_is_told():
    rng = np.random.default_rng(0)
    turns = Rotation.from_rotvec(np.radians(4.0) * rng.normal(size=(20, 3))).as_matrix()
    bar = Bar(seed=8, counts=on("A03", lambda p, y: y @ turns[p]))
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert [n.sensor for n in told(found, "sensor-drifting")] == ["A03"]


def test_a_drifting_magnetometer_is_told():
    drift = 2000.0 * np.array([0.1, -0.07])
    bar = Bar(seed=9, counts=on("M03", lambda p, y: y + drift * p / 19.0))
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert [n.sensor for n in told(found, "sensor-drifting")] == ["M03"]


def test_a_sensor_that_never_agrees_is_left_out():
    rng = np.random.default_rng(1)
    jumps = 0.3 * 2000.0 * rng.normal(size=(20, 2))
    bar = Bar(seed=10, counts=on("M03", lambda p, y: y + jumps[p]))
    found = sound(bar)
    assert unused(found) == ["M03"]
    assert [n.sensor for n in told(found, "sensor-undetermined")] == ["M03"]


@pytest.mark.parametrize(
    ("place", "change", "words"),
    [
        (4, {"roll": 270.0}, "asked with the right edge up; the left edge up is what"),
        (12, {"pitch": -40.0}, "the start 40° up; the upper face up and the end"),
        (12, {"pitch": 0.0, "table": True}, "asked with the upper face up; the upper face up and"),
    ],
)
def test_a_mislabelled_pose_is_told_and_used_as_it_was(place, change, words):
    bar = Bar(seed=11)
    poses = relabelled(bar.poses(TWENTY), {place: change})
    found = sound(bar, poses=poses)
    [notice] = told(found, "pose-mislabelled")
    assert f"pose {place + 1} (" in notice.message
    assert words in notice.message


def test_wrong_headings_are_found_and_corrected():
    bar = Bar(seed=12)
    changes = {3: {"heading": 90.0}, 8: {"heading": 0.0}, 14: {"heading": 200.0}}
    found = sound(bar, poses=relabelled(bar.poses(TWENTY), changes))
    named = [n.message.split(" (")[0] for n in told(found, "pose-heading-corrected")]
    assert named == ["pose 4", "pose 9", "pose 15"]


def test_a_face_that_did_not_lie_flat_is_not_used_for_the_table():
    bar = Bar(seed=13)
    straight = bar.attitude
    tipped = Rotation.from_euler("x", 4.0, degrees=True).as_matrix()
    number = iter(range(20))
    bar.attitude = lambda *asked: straight(*asked) @ (tipped if next(number) == 5 else np.eye(3))
    found = sound(bar)
    [notice] = told(found, "pose-not-flat")
    assert "pose 6 (" in notice.message


def test_lost_values_of_single_frames_do_no_harm():
    bar = Bar(seed=14)
    poses = bar.poses(TWENTY)
    counts = poses[2].readings.counts.copy()
    counts[5:25, 4] = np.nan
    counts[:, 8] = np.nan
    poses[2] = replace(poses[2], readings=replace(poses[2].readings, counts=counts))
    found = sound(bar, poses=poses)
    assert found.notices == ()


@pytest.mark.parametrize("frames", [slice(7, 8), slice(0, 10)])
def test_values_at_the_end_of_the_range_do_no_harm_and_are_told(frames):
    bar = Bar(seed=14)
    poses = bar.poses(TWENTY)
    assert len(poses[0].readings.t) > 3 * 10
    for k, pose in enumerate(poses):
        counts = pose.readings.counts.copy()
        counts[frames, 4:] = -32768.0
        poses[k] = replace(pose, readings=replace(pose.readings, counts=counts))
    found = sound(bar, poses=poses)
    assert codes(found) == {"values-saturated"}
    lost = 20 * (frames.stop - frames.start) * (counts.shape[1] - 4)
    assert f"{lost} values" in found.notices[0].message
