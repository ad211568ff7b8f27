"""Plans: what is asked for, and what cannot be meant."""

import contextlib
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.calibration.plans import PLANS
from georibbon.capture.judging import (
    angle_off,
    asked_up,
    judge_pass,
    judge_pose,
    lies_as,
    rough_up,
    rough_ups,
)
from georibbon.capture.plan import (
    CapturePlan,
    PlannedLayout,
    PlannedPose,
    check_survey,
    places,
    read_plan,
    tie_places,
    write_plan,
)
from georibbon.errors import SettingsError
from georibbon.recording import Workpiece
from georibbon.rotations import about_x, about_y, about_z
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import virtual_ribbon

RIBBON = virtual_ribbon(RibbonSettings(sensors=16))
HEAD = 'format = "georibbon-plan"\nversion = 1\n'


def written(folder, text):
    path = folder / "plan.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_plan_file_says_everything(tmp_path):
    text = HEAD + (
        'title = "hull"\nposes = 12\npasses = 3\nties = 1\n[workpiece]\nlevel = true\n'
        'heading = 25.0\n[[mark]]\npass = "P3"\nat = 0.0\nposition = [0.1, 0.2, 0.3]\n'
        'sigma = 0.001\n[[crossing]]\npasses = ["P1", "T1"]\nat = [0.1, 0.2]\nsigma = 0.001\n'
    )
    plan = read_plan(written(tmp_path, text))
    assert (plan.title, plan.poses, plan.passes, plan.ties) == ("hull", 12, 3, 1)
    assert plan.workpiece.heading == 25.0
    assert [one.name for one in plan.planned_passes] == ["P1", "P2", "P3", "T1"]
    assert [one.kind for one in plan.planned_passes] == ["pass"] * 3 + ["tie"]
    names = [one.name for one in plan.planned_passes]
    marks, distances, crossings = check_survey(plan.survey, RIBBON, names, "plan.toml")
    assert (marks[0].pass_name, distances, crossings[0].passes) == ("P3", (), ("P1", "T1"))


def test_a_plan_of_two_lines_is_the_usual_one(tmp_path):
    assert read_plan(written(tmp_path, HEAD)) == CapturePlan(source="plan.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "format"),
        ('format = "georibbon-recording"\nversion = 1\n', "format"),
        ('format = "georibbon-plan"\nversion = 2\n', "version"),
        (HEAD + "poses = 13\n", "13 poses"),
        (HEAD + "passes = -1\n", "-1 passes"),
        (HEAD + "passes = 100000000000000\n", "passes"),
        (HEAD + "ties = 1.5\n", "ties"),
        (HEAD + "pases = 5\n", "pases"),
        (HEAD + "[workpiece]\nlevel = false\n", "level"),
        ("passes = [[[", "this is no plan"),
    ],
)
def test_what_a_plan_cannot_mean_is_named(tmp_path, text, words):
    with pytest.raises(SettingsError, match=words):
        read_plan(written(tmp_path, text))


@given(st.binary(max_size=200))
def test_any_bytes_are_a_plan_or_refused(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("plan") / "plan.toml"
    path.write_bytes(HEAD.encode() + data)
    with contextlib.suppress(SettingsError):
        assert isinstance(read_plan(path), CapturePlan)


def test_a_survey_may_speak_of_planned_passes_only():
    entry = {"pass": "P9", "at": 0.0, "position": [0.0, 0.0, 0.0], "sigma": 0.001}
    with pytest.raises(SettingsError, match="P9"):
        check_survey({"mark": [entry]}, RIBBON, ["P1"], "the survey")


@pytest.mark.parametrize("number", PLANS)
def test_every_planned_pose_is_itself_and_no_other_face(number):
    poses = CapturePlan(poses=number).planned_poses
    assert len({pose.key for pose in poses}) == number
    for pose in poses:
        up = asked_up(pose)
        assert lies_as(pose, up)
        for other in poses:
            if (other.roll, other.pitch) != (pose.roll, pose.pitch):
                assert not lies_as(other, up)


@given(st.floats(0, 360), st.floats(-60, 60), st.floats(0, 360))
def test_gravity_tells_roll_and_pitch_whatever_the_heading(roll, pitch, heading):
    r = about_z(np.radians([heading])) @ about_y(np.radians([-pitch])) @ about_x(np.radians([roll]))
    pose = PlannedPose("one", roll, 0.0, pitch, False)
    assert angle_off(pose, r[0].T @ [0.0, 0.0, 1.0]) < 1e-6


def means(up, dead=()):
    """The columns' means of a ribbon whose every accelerometer sees "up"."""
    parts = []
    for sensor in RIBBON.sensors:
        seen = np.array(up) if sensor.kind == "accelerometer" else np.array([0.3, 0.4, 0.5])
        values = sensor.counts_per_unit * seen[: sensor.axes]
        parts.append(np.full(sensor.axes, np.nan) if sensor.name in dead else values)
    return np.concatenate(parts)


def test_up_outvotes_a_sensor_that_is_wrong():
    counts = means([0.0, 0.0, 1.0])
    counts[:3] = [30000.0, 0.0, 0.0]
    assert np.allclose(rough_up(rough_ups(RIBBON, counts)), [0.0, 0.0, 1.0])


@pytest.mark.parametrize(("half", "fine"), [(0.0, True), (8.0, True), (30.0, False)])
def test_a_pose_is_straight(half, fine):
    """Sensors that tilt from minus to plus so many degrees: on an object, not on the bar."""
    pose = CapturePlan(poses=20).planned_poses[0]
    counts = means([0.0, 0.0, 1.0])
    places = RIBBON.indices("accelerometer")
    for i, tilt in zip(places, np.radians(np.linspace(-half, half, len(places))), strict=True):
        up = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
        counts[RIBBON.slices[i]] = up * RIBBON.sensors[i].counts_per_unit
    refusal = judge_pose(RIBBON, pose, counts)
    assert (refusal is None) == fine
    if not fine:
        assert refusal.code == "bent"
        assert "straight" in refusal.message


def test_another_face_is_refused_with_both_told():
    pose = CapturePlan(poses=20).planned_poses[4]
    assert judge_pose(RIBBON, pose, means([0.0, 1.0, 0.0])) is None
    refusal = judge_pose(RIBBON, pose, means([0.0, -1.0, 0.0]))
    assert refusal.code == "other-pose"
    assert refusal.forcible
    assert "left edge up" in refusal.message
    assert "right edge up" in refusal.message


@pytest.mark.parametrize(("off", "fine"), [(10.0, True), (20.0, False)])
def test_a_pose_on_the_table_lies_flat(off, fine):
    pose = CapturePlan(poses=20).planned_poses[0]
    up = [math.sin(math.radians(off)), 0.0, math.cos(math.radians(off))]
    refusal = judge_pose(RIBBON, pose, means(up))
    assert (refusal is None) == fine
    if not fine:
        assert "20° off" in refusal.message or "end 20° up" in refusal.message


def test_silent_sensors_take_neither_pose_nor_pass():
    names = {sensor.name for sensor in RIBBON.sensors}
    pose = CapturePlan(poses=20).planned_poses[0]
    silent = means([0.0, 0.0, 1.0], dead=names)
    assert judge_pose(RIBBON, pose, silent).code == "silent"
    assert judge_pass(RIBBON, "P1", silent).code == "silent"
    few = {sensor.name for sensor in RIBBON.sensors if sensor.name not in ("M01", "M02")}
    accelerometers = {name for name in names if name.startswith("A")}
    assert judge_pass(RIBBON, "P1", means([0.0, 0.0, 1.0], few - accelerometers)).code == "silent"
    assert judge_pass(RIBBON, "P1", means([0.0, 0.0, 1.0])) is None


@given(
    passes=st.integers(0, 1000),
    ties=st.integers(0, 1000),
    spacing=st.floats(0.005, 2.0),
    marks=st.integers(0, 9),
    sigma=st.floats(1e-5, 0.1),
    title=st.none() | st.text(st.characters(exclude_categories=("C",)), max_size=40),
)
def test_a_written_plan_is_read_back(tmp_path_factory, passes, ties, spacing, marks, sigma, title):
    path = tmp_path_factory.mktemp("plan") / "plan.toml"
    layout = PlannedLayout(spacing=spacing, marks=marks, mark_sigma=sigma)
    entry = {"pass": "P1", "at": 0.1, "position": [0.0, 1.0, 2.0], "sigma": 0.001}
    plan = CapturePlan(12, passes, ties, title, Workpiece(True, 12.5), {"mark": [entry]},
                       path.name, layout)  # fmt: skip
    write_plan(plan, path)
    assert read_plan(path) == plan


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("spacing = 0.001", "passes are 0.001 m apart"),
        ("spacing = -1", "spacing"),
        ("marks = 10", "plan 0 to 9"),
        ("marks = 1.5", "whole number"),
        ("mark_sigma = 1.0", "mark_sigma"),
        ("distances = -1", "distances"),
        ("gap = 1", "gap"),
    ],
)
def test_a_layout_that_cannot_be_meant_is_refused(tmp_path, text, words):
    with pytest.raises(SettingsError, match=words):
        read_plan(written(tmp_path, f"{HEAD}[layout]\n{text}\n"))


def test_places_are_spread_from_the_start_to_the_end():
    assert places(0, 0.9) == ()
    assert places(1, 0.9) == (0.0,)
    assert places(2, 0.9) == (0.0, 0.9)
    assert places(4, 0.9) == pytest.approx((0.0, 0.3, 0.6, 0.9))
    assert tie_places(0) == ()
    assert tie_places(1) == (0.5,)
    assert 0.1 < tie_places(3)[0] < tie_places(3)[-1] < 0.9
