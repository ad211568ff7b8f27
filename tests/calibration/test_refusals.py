"""What cannot give a calibration is refused, and the message says what to do."""

from dataclasses import replace

import numpy as np
import pytest
from bar import ONE_HEADING, SIXTEEN, TABLE_ONLY, TWELVE, TWENTY, TWO_FACES, Bar, codes, told

from georibbon.calibration import calibrate, gates
from georibbon.calibration.poses import attitudes
from georibbon.errors import CalibrationError
from georibbon.ribbon import Readings


def refused(bar, poses, *words, **settings):
    with pytest.raises(CalibrationError) as caught:
        calibrate(bar.ribbon, poses, **settings)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("number", [0, 1, 6, 9])
def test_too_few_poses(number):
    bar = Bar()
    refused(bar, bar.poses(TWENTY[:number]), f"{number} poses", "at least 10")


@pytest.mark.parametrize("number", [10, 11])
def test_ten_poses_are_for_a_first_look(number):
    bar = Bar(seed=1)
    found = calibrate(bar.ribbon, bar.poses(TWELVE[:number]))
    assert "calibration-few-poses" in codes(found)
    assert "first look" in told(found, "calibration-few-poses")[0].message


@pytest.mark.parametrize("seed", range(4))
def test_one_heading(seed):
    bar = Bar(seed=seed)
    refused(bar, bar.poses(ONE_HEADING), "table's tilt", "end for end")


def test_the_table_only():
    bar = Bar(seed=2)
    refused(bar, bar.poses(TABLE_ONLY), "x axis", "lift one end")


def test_two_faces_only():
    bar = Bar(seed=3)
    refused(bar, bar.poses(TWO_FACES), "2 of its 4 faces", "the left edge up", "the right edge up")


def test_a_missing_face_is_told():
    bar = Bar(seed=4)
    plan = [pose for pose in TWENTY if not (pose[0] == 270 and pose[3])]
    found = calibrate(bar.ribbon, bar.poses(plan))
    assert any("right edge up" in notice.message for notice in told(found, "calibration-weak"))


def test_the_wrong_hemisphere():
    bar = Bar(seed=5)
    poses = bar.poses(TWELVE)
    refused(bar, poses, "points down by 65°", "mounted reversed", hemisphere="south")
    assert calibrate(bar.ribbon, poses, hemisphere="north").notices == ()
    southern = Bar(seed=5, dip=np.radians(-65.0))
    poses = southern.poses(TWELVE)
    refused(southern, poses, "points up by 65°", hemisphere="north")
    assert calibrate(southern.ribbon, poses, hemisphere="south").notices == ()


def test_no_magnetometer_left():
    bar = Bar(counts=lambda _p, s, y: y * 0.0 if s.kind == "magnetometer" else y)
    # When all are dead alike none moves less than the others: the range says so.
    with pytest.raises(CalibrationError, match="magnetometer"):
        calibrate(bar.ribbon, bar.poses(SIXTEEN))


def test_no_accelerometer_left():
    bar = Bar(counts=lambda _p, s, y: y * np.nan if s.kind == "accelerometer" else y, sensors=4)
    refused(bar, bar.poses(SIXTEEN), "no accelerometer", "connection")


def test_another_ribbons_columns():
    bar = Bar()
    poses = bar.poses(SIXTEEN)
    whole = poses[3].readings
    poses[3] = replace(poses[3], readings=Readings(whole.t, whole.counts[:, 1:]))
    refused(bar, poses, "roll 90, heading 180", "29 columns", "30")


def test_poses_without_any_accelerometer_are_left_out():
    bar = Bar(axes=3, counts=lambda p, s, y: y * np.nan if p < 2 and s.name[0] == "A" else y)
    found = calibrate(bar.ribbon, bar.poses(TWENTY))
    assert len(told(found, "pose-lost")) == 2


def test_an_angle_that_is_no_number():
    bar = Bar()
    poses = bar.poses(SIXTEEN)
    poses[2] = replace(poses[2], roll=float("nan"))
    refused(bar, poses, "roll 90, heading 0", "no finite number")


def test_a_pose_without_values_is_left_out_and_told():
    bar = Bar()
    poses = bar.poses(TWENTY)
    lost = np.full_like(poses[2].readings.counts, np.nan)
    poses[2] = replace(poses[2], readings=Readings(poses[2].readings.t, lost))
    poses[5] = replace(poses[5], readings=Readings(np.empty(0), np.empty((0, lost.shape[1]))))
    found = calibrate(bar.ribbon, poses)
    assert [n.message[:30] for n in told(found, "pose-lost")] == [
        f"pose {poses[k].name!r}"[:30] for k in (2, 5)
    ]
    assert found.quality.poses == 18


def test_poses_keep_their_numbers_when_one_is_left_out():
    steel = np.array([0.15, -0.1, 0.12])
    bar = Bar(seed=5, field=lambda place, _s: steel if place == 7 else 0.0)
    poses = bar.poses(TWENTY)
    lost = np.full_like(poses[2].readings.counts, np.nan)
    poses[2] = replace(poses[2], readings=Readings(poses[2].readings.t, lost))
    [notice] = told(calibrate(bar.ribbon, poses), "pose-disturbed")
    assert "pose 8 (" in notice.message


@pytest.mark.parametrize(("a", "b", "word"), [(2.0, 0.3, "2.00 mg"), (0.1, 1.5, "1.50 %")])
def test_parameters_that_are_left_free(a, b, word):
    with pytest.raises(CalibrationError, match=word):
        gates.require_parameters(a, b)


def test_a_weak_parameter_is_told():
    bar = Bar(seed=1)
    found = calibrate(bar.ribbon, bar.poses(TWELVE))
    weak = replace(found.quality, accelerometer_mg=0.5, magnetometer_percent=0.8)
    notices = gates.weaknesses(weak, attitudes(bar.poses(TWELVE), np.ones(12, dtype=bool)))
    assert [notice.code for notice in notices] == ["calibration-weak"] * 2
