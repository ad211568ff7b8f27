"""The daily check: an unchanged ribbon is good, what has changed is found with its name."""

from dataclasses import replace

import numpy as np
import pytest
from days import DIP, Ribbon

from georibbon.calibration.check import CHECK_POSES, GOOD, check_calibration
from georibbon.errors import CalibrationError
from georibbon.ribbon import Readings

SEEDS = range(4)


@pytest.fixture(scope="module")
def ribbons():
    """Four ribbons, each with its calibration."""
    return [Ribbon(seed=seed, axes=3 if seed == 3 else 2) for seed in SEEDS]


def named(check):
    """The sensors that are named."""
    return {notice.sensor for notice in check.findings if notice.sensor}


def codes(check):
    return [notice.code for notice in check.findings]


def of(check, name):
    return next(one for one in check.sensors if one.name == name)


def test_an_unchanged_ribbon_is_good(ribbons):
    checks = [ribbon.check() for ribbon in ribbons for _ in range(5)]
    assert {check.verdict for check in checks} == {"good"}
    assert all(check.undisturbed and check.findings == () for check in checks)
    assert all(check.degrees == max(one.degrees for one in check.sensors) for check in checks)
    assert all("all sensors agree" in check.reason for check in checks)


def test_the_field_is_measured(ribbons):
    for ribbon in ribbons:
        check = ribbon.check(ribbon.in_field(DIP + 1.5, 1.012), seat=0.0)
        assert check.norm == pytest.approx(1.012, abs=0.003)
        assert check.dip_change == pytest.approx(1.5, abs=0.3)
        assert check.dip == pytest.approx(DIP + 1.5, abs=0.4)


@pytest.mark.parametrize("name", ["A03", "M05"])
def test_a_turned_sensor_is_named_and_its_turn_measured(ribbons, name):
    rng = np.random.default_rng(7)
    for ribbon in ribbons:
        axis = rng.standard_normal(3)
        check = ribbon.check(ribbon.changed(name, turn=2.0 * axis / np.linalg.norm(axis)))
        assert named(check) == {name}
        assert check.verdict != "good"
        assert name in check.reason
        assert of(check, name).turned == pytest.approx(2.0, abs=0.6)
        assert all(one.degrees < GOOD for one in check.sensors if one.name != name)


@pytest.mark.parametrize(
    ("name", "bias", "said"),
    [("A02", (0.03, 0.0, 0.0), "bias had changed by"), ("M04", (0.06, 0.08, 0.0), "hard iron")],
)
def test_a_changed_bias_is_named_and_measured(ribbons, name, bias, said):
    for ribbon in ribbons:
        check = ribbon.check(ribbon.changed(name, bias=bias))
        unit = 1e3 if name[0] == "A" else 1e2
        assert named(check) == {name}
        assert check.verdict == "calibrate"
        assert of(check, name).shifted == pytest.approx(np.linalg.norm(bias) * unit, rel=0.2)
        assert any(said in notice.message for notice in check.findings)


@pytest.mark.parametrize(
    ("dip", "strength", "words"),
    [
        (DIP, 1.03, "stronger"),
        (DIP, 0.97, "weaker"),
        (DIP + 4, 1.0, "steeper"),
        (DIP - 4, 1.0, "flatter"),
    ],
)
def test_another_field_is_told_as_the_place_and_no_sensor(ribbons, dip, strength, words):
    for ribbon in ribbons:
        check = ribbon.check(ribbon.in_field(dip, strength))
        assert not check.undisturbed
        assert check.verdict == "calibrate"
        assert codes(check)[0] == "check-place"
        assert words in check.findings[0].message
        assert named(check) == set()


def test_a_dead_sensor_is_named(ribbons):
    for ribbon in ribbons:
        check = ribbon.check(ribbon.with_dead("M02"))
        assert "check-dead" in codes(check)
        assert named(check) == {"M02"}
        assert check.verdict == "calibrate"


def test_a_silent_sensor_is_named(ribbons):
    ribbon = ribbons[0]
    poses = ribbon.poses(CHECK_POSES)
    column = ribbon.ribbon.slices[4]
    for pose in poses:
        pose.readings.counts[:, column] = np.nan
    check = check_calibration(ribbon.ribbon, ribbon.calibration, poses)
    name = ribbon.ribbon.sensors[4].name
    assert named(check) == {name}
    assert np.isnan(of(check, name).degrees)


def test_steel_near_one_pose_is_told_by_the_pose(ribbons):
    beside = np.linspace(0.5, 1.5, 16)[:, None] * [0.15, -0.1, 0.08]
    for ribbon in ribbons:
        check = ribbon.check(disturbance={1: beside})
        assert check.again
        assert check.verdict == "calibrate"
        assert check.reason.startswith("take again")


def test_a_magnet_at_one_sensor_in_one_pose_asks_for_that_pose(ribbons):
    beside = np.zeros((16, 3))
    beside[5] = [0.3, 0.1, 0.1]
    for ribbon in ribbons:
        check = ribbon.check(disturbance={1: beside})
        assert codes(check) == ["check-cell"]
        assert check.again == ("roll 90, heading 90, pitch 0",)
        assert named(check) == {"M03"}


def test_a_bar_moved_in_one_pose_is_told_by_the_pose(ribbons):
    ribbon = ribbons[0]
    poses = ribbon.poses(CHECK_POSES)
    counts = poses[2].readings.counts.copy()
    rng = np.random.default_rng(1)
    for i in ribbon.ribbon.indices("accelerometer"):
        counts[:, ribbon.ribbon.slices[i]] += 16384.0 * 0.04 * rng.choice([-1.0, 1.0], 3)
    poses[2] = replace(poses[2], readings=Readings(poses[2].readings.t, counts))
    check = check_calibration(ribbon.ribbon, ribbon.calibration, poses)
    assert check.again == (poses[2].name,)
    assert "held still" in check.findings[0].message


def test_sensors_that_are_not_used_are_not_judged(ribbons):
    ribbon = ribbons[1]
    bench = ribbon.changed("A03", turn=(9.0, 9.0, 0.0))
    models = list(ribbon.calibration.sensors)
    models[4] = replace(models[4], used=False, reason="switched off")
    calibration = replace(ribbon.calibration, sensors=tuple(models))
    poses = ribbon.poses(CHECK_POSES, bench, seat=0.05)
    check = check_calibration(ribbon.ribbon, calibration, poses)
    assert check.verdict == "good"
    assert not of(check, "A03").used
    assert np.isnan(of(check, "A03").degrees)


def test_many_sensors_are_not_all_listed_in_the_reason(ribbons):
    ribbon = ribbons[0]
    bench = ribbon.bench
    for k in range(1, 8):
        bench = replace(
            ribbon.changed(f"M0{k}", turn=(0.0, 0.0, (-1.0) ** k * 4.0)),
            models=tuple(
                new if new.name == f"M0{k}" else old
                for old, new in zip(
                    bench.models,
                    ribbon.changed(f"M0{k}", turn=(0.0, 0.0, (-1.0) ** k * 4.0)).models,
                    strict=True,
                )
            ),
        )
    check = ribbon.check(bench)
    assert check.verdict == "calibrate"
    assert check.heading > 2.0


def test_too_few_or_too_similar_poses_are_refused(ribbons):
    ribbon = ribbons[0]
    flat = ((0.0, 0.0, 0.0, True), (0.0, 90.0, 0.0, True), (0.0, 180.0, 0.0, True))
    with pytest.raises(CalibrationError, match="1 different poses of 3, 3 are needed"):
        ribbon.check(plan=flat)
    with pytest.raises(CalibrationError, match="2 different poses of 2"):
        ribbon.check(plan=CHECK_POSES[:2])


def test_a_silent_ribbon_is_refused(ribbons):
    ribbon = ribbons[0]
    poses = ribbon.poses(CHECK_POSES)
    for i in ribbon.ribbon.indices("magnetometer"):
        poses[1].readings.counts[:, ribbon.ribbon.slices[i]] = np.nan
    with pytest.raises(CalibrationError, match="too few magnetometers"):
        check_calibration(ribbon.ribbon, ribbon.calibration, poses)


def test_another_ribbons_calibration_is_refused(ribbons):
    one, other = ribbons[0], ribbons[3]
    with pytest.raises(CalibrationError, match="axes"):
        check_calibration(one.ribbon, other.calibration, one.poses(CHECK_POSES))


def test_headings_do_not_matter(ribbons):
    """Only what gravity and the field say counts, however the bar was turned."""
    ribbon = ribbons[2]
    plan = tuple(
        (roll, heading + 77.0, pitch, table) for roll, heading, pitch, table in CHECK_POSES
    )
    assert ribbon.check(plan=plan).verdict == "good"
