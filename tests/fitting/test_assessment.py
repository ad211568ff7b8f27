"""Verdicts: what is named, what counts as ignored, and when a pass must be laid again."""

from dataclasses import replace

import numpy as np
import pytest
from laid import FLAT, calibration, recording, ribbon, wavy

from georibbon.fitting.assessment import (
    ACCEPTABLE_RESIDUAL,
    ACCEPTABLE_SIGMA,
    IGNORED,
    NAMED,
    REDO_RESIDUAL,
    REDO_SIGMA,
    assess,
)
from georibbon.fitting.capture import prepare
from georibbon.fitting.grid import make_grid
from georibbon.fitting.result import PassesFit
from georibbon.fitting.screening import screen
from georibbon.fitting.strip import ROBUST_LIMIT, robust_weights

RIBBON = ribbon(16)
GRID = make_grid(RIBBON)
NAMES = [sensor.name for sensor in RIBBON.sensors]
AXES = np.array([np.arange(3) < sensor.axes for sensor in RIBBON.sensors])


def capture(count=4, of=RIBBON):
    shape = wavy(GRID, FLAT).take([0] * count)
    made, calibrated = recording(of, shape), calibration(of)
    return prepare(made, calibrated, screen(of, made.passes, calibrated))


CAPTURE = capture()


def fit(residuals=None, count=4, **fields):
    """A result whose residuals are 0.8 everywhere, but for those given as {(pass, name): size}."""
    n = len(GRID.nodes)
    each = np.where(AXES, 0.8, 0.0)[None].repeat(count, axis=0)
    for (p, name), size in (residuals or {}).items():
        i = NAMES.index(name)
        each[p, i] = np.where(AXES[i], size / np.sqrt(AXES[i].sum()), 0.0)
    plain = PassesFit(
        s=GRID.nodes,
        points=np.zeros((count, n, 3)),
        frames=np.tile(np.eye(3), (count, n, 1, 1)),
        covariance=np.tile(1e-6 * np.eye(3), (count, n, 1, 1)),
        normal_sigma=np.full((count, n), 0.004),
        residuals=each,
        present=np.ones((count, len(NAMES)), dtype=bool),
        lengths=np.full(count, 0.1),
        ambiguous=(False,) * count,
        heading=0.0,
        heading_sigma=None,
        notices=(),
    )
    return replace(plain, **fields)


def outcome(residuals=None, captured=CAPTURE, missed=None, **fields):
    return assess(captured, fit(residuals, **fields), missed or {})


def codes(notices):
    return [(notice.code, notice.pass_name, notice.sensor) for notice in notices]


def test_where_all_agree_all_is_good_and_nothing_is_said():
    passes, notices = outcome()
    assert notices == ()
    for one in passes:
        assert one.verdict == "good"
        assert one.ignored == ()
        assert one.residual_rms == pytest.approx(0.8)


def test_a_sensor_that_disagrees_in_one_pass_is_named_there():
    passes, notices = outcome({(1, "A03"): 8.0})
    assert codes(notices) == [("sensor-outlier", "P2", "A03")]
    assert "A03 is 8 standard deviations off" in notices[0].message
    assert passes[1].verdict == "good"


def test_just_below_the_limit_nothing_is_named():
    assert outcome({(1, "A03"): NAMED - 0.01})[1] == ()
    assert len(outcome({(1, "A03"): NAMED + 0.01})[1]) == 1


def test_a_sensor_of_little_weight_counts_as_ignored_and_the_pass_as_acceptable():
    assert robust_weights(np.array(IGNORED**2)) == pytest.approx(0.1)
    passes, _ = outcome({(2, "M04"): IGNORED + 0.1})
    assert passes[2].ignored == ("M04",)
    assert passes[2].verdict == "acceptable"
    assert "1 of 16 sensors" in passes[2].reason
    assert "M04" in passes[2].reason
    assert passes[2].residual_rms == pytest.approx(0.8)
    assert outcome({(2, "M04"): IGNORED - 0.1})[0][2].ignored == ()
    assert ROBUST_LIMIT < NAMED < IGNORED


def test_absent_sensors_count_as_ignored():
    present = np.ones((4, 16), dtype=bool)
    present[0, 3] = False
    passes, notices = outcome({(0, "M02"): 50.0}, present=present)
    assert passes[0].ignored == ("M02",)
    assert notices == ()  # the screening or the calibration has said why


def test_more_than_a_quarter_of_the_sensors_left_out_means_do_it_again():
    present = np.ones((4, 16), dtype=bool)
    present[0, :5], present[1, :4] = False, False
    passes, _ = outcome({}, present=present)
    assert [one.verdict for one in passes[:2]] == ["redo", "acceptable"]


def test_several_live_sensors_that_agree_with_no_curve_mean_do_it_again():
    apart = ["A01", "A03"]
    passes, _ = outcome({(0, name): 20.0 for name in apart} | {(1, "A01"): 20.0})
    assert passes[0].verdict == "redo"
    assert "2 live sensors agree with no curve" in passes[0].reason
    assert passes[1].verdict == "acceptable"


def test_neighbouring_magnetometers_that_disagree_are_a_disturbed_field():
    bad = {(2, name): 9.0 for name in ("M03", "M04", "M05", "M06")}
    _, notices = outcome(bad)
    assert codes(notices) == [("field-disturbed", "P3", f"M0{k}") for k in (3, 4, 5, 6)]
    for notice in notices:
        assert "take steel and magnets away" in notice.message


def test_an_accelerometer_among_them_and_a_lone_magnetometer_are_outliers():
    bad = {(2, name): 9.0 for name in ("M03", "M04", "A04", "M08")}
    assert codes(outcome(bad)[1]) == [
        ("field-disturbed", "P3", "M03"),
        ("sensor-outlier", "P3", "A04"),
        ("field-disturbed", "P3", "M04"),
        ("sensor-outlier", "P3", "M08"),
    ]


def test_a_sensor_that_disagrees_in_most_passes_is_named_once():
    bad = {(p, "M05"): 9.0 for p in range(3)}
    _, notices = outcome(bad)
    assert codes(notices) == [("sensor-outlier", None, "M05")]
    assert "calibrate again" in notices[0].message


def test_two_passes_are_too_few_to_blame_the_sensor():
    bad = {(p, "M05"): 9.0 for p in range(2)}
    two = outcome(bad, captured=capture(2), count=2)[1]
    assert codes(two) == [("sensor-outlier", "P1", "M05"), ("sensor-outlier", "P2", "M05")]


@pytest.mark.parametrize(
    ("size", "verdict"),
    [
        (ACCEPTABLE_RESIDUAL - 0.01, "good"),
        (ACCEPTABLE_RESIDUAL + 0.01, "acceptable"),
        (REDO_RESIDUAL + 0.01, "redo"),
    ],
)
def test_residuals_as_a_whole_decide(size, verdict):
    each = np.tile(np.where(AXES, size, 0.0), (4, 1, 1))
    passes, _ = assess(CAPTURE, replace(fit(), residuals=each), {})
    assert passes[0].verdict == verdict
    assert passes[0].residual_rms == pytest.approx(size)
    if verdict != "good":
        assert "times as far off the curve" in passes[0].reason


@pytest.mark.parametrize(
    ("sigma", "verdict"),
    [
        (0.9 * ACCEPTABLE_SIGMA, "good"),
        (1.1 * ACCEPTABLE_SIGMA, "acceptable"),
        (1.1 * REDO_SIGMA, "redo"),
    ],
)
def test_a_pass_whose_position_is_hardly_known_is_doubtful(sigma, verdict):
    covariance = np.tile(1e-6 / 3 * np.eye(3), (4, len(GRID.nodes), 1, 1))
    covariance[3] *= (sigma / 1e-3) ** 2
    passes, _ = outcome(covariance=covariance)
    assert [one.verdict for one in passes] == ["good"] * 3 + [verdict]
    if verdict != "good":
        assert f"known to {1e3 * sigma:.0f} mm only" in passes[3].reason


@pytest.mark.parametrize(("count", "verdict"), [(0, "good"), (1, "acceptable"), (2, "redo")])
def test_a_pass_that_misses_the_survey_is_doubtful(count, verdict):
    passes, _ = outcome(missed={"P2": count})
    assert [one.verdict for one in passes] == ["good", verdict, "good", "good"]
    if count:
        assert passes[1].reason == f"it misses {count} of the survey's measurements"


def test_a_pass_that_moved_or_has_two_shapes_must_be_laid_again():
    moved = replace(CAPTURE, moved=(False, True, False, False))
    passes, _ = outcome(captured=moved, ambiguous=(False, False, True, False))
    assert [one.verdict for one in passes] == ["good", "redo", "redo", "good"]
    assert "moved" in passes[1].reason
    assert "two shapes" in passes[2].reason


def test_the_worst_finding_is_the_verdict_and_all_as_bad_are_told():
    moved = replace(CAPTURE, moved=(True, False, False, False))
    passes, _ = outcome({(0, "A02"): 30.0}, captured=moved, ambiguous=(True, False, False, False))
    assert passes[0].verdict == "redo"
    assert passes[0].reason == "the ribbon moved while it was read; two shapes fit alike"


def on_wall(share):
    """Frames of which a share faces sideways."""
    frames = np.tile(np.eye(3), (4, len(GRID.nodes), 1, 1))
    steep = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    frames[2, : round(share * len(GRID.nodes))] = steep
    return frames


def test_a_steep_pass_of_a_two_axis_ribbon_is_told():
    passes, notices = outcome(frames=on_wall(0.7))
    assert codes(notices) == [("steep-wall", "P3", None)]
    assert "3-axis" in notices[0].message
    assert passes[2].verdict == "good"
    assert outcome(frames=on_wall(0.4))[1] == ()


def test_a_three_axis_ribbon_may_lie_on_walls():
    three = capture(of=ribbon(16, 3))
    assert assess(three, fit(frames=on_wall(0.7)), {})[1] == ()


def test_where_sensors_disagree_everywhere_the_calibration_is_named_and_no_sensor():
    many = {(p, name): 9.0 for p in range(4) for name in NAMES[p::5]}
    passes, notices = outcome(many)
    assert [one.code for one in notices] == ["calibration-doubtful"]
    assert {one.verdict for one in passes} <= {"acceptable", "redo"}


def test_a_reason_lists_some_names_and_counts_the_rest():
    present = np.ones((4, 16), dtype=bool)
    present[0, :11] = False
    reason = outcome({}, present=present)[0][0].reason
    assert "11 of 16 sensors left out" in reason
    assert reason.endswith("and 3 more)")
