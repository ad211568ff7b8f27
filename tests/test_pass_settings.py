"""Weights, trimmed ends and sensors switched off: laws of what they do, and of what they leave."""

from dataclasses import replace

import numpy as np
import pytest

from georibbon.errors import FitError, SettingsError
from georibbon.geometry.surface import SurfaceSettings, build_surface
from georibbon.reconstruction import ReconstructionSettings, Stages, reconstruct
from georibbon.ribbon import Readings
from georibbon.simulation import (
    FaultSettings,
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    simulate,
)

BAD = "A03"


def simulated(**changes):
    """A small capture: 3 passes of 16 sensors on a dome, with its calibration."""
    usual = {
        "surface": "dome",
        "seed": 3,
        "ribbon": RibbonSettings(sensors=16, length=0.48),
        "layout": LayoutSettings(passes=3),
        "frames": 24,
        "poses": PoseSettings(plan=0),
    }
    return simulate(SimulationSettings(**{**usual, **changes}))


@pytest.fixture(scope="module")
def made():
    return simulated()


def run(made, recording=None, stages=None, **settings):
    return reconstruct(
        recording or made.recording,
        ReconstructionSettings(**settings),
        made.truth.calibration,
        stages,
    )


@pytest.fixture(scope="module")
def plain(made):
    return run(made)


def same(one, other):
    """Bit for bit."""
    for a, b in zip(one.passes, other.passes, strict=True):
        np.testing.assert_array_equal(a.strip.points, b.strip.points)
        np.testing.assert_array_equal(a.covariance, b.covariance)
        np.testing.assert_array_equal(a.residuals, b.residuals)
        assert a.quality == b.quality
    np.testing.assert_array_equal(one.surface.mesh.vertices, other.surface.mesh.vertices)
    assert one.notices == other.notices


def shaken(recording, name, sensor, by):
    """The recording with one sensor's counts of some passes changed."""
    i = [one.name for one in recording.ribbon.sensors].index(sensor)
    where = recording.ribbon.slices[i]
    passes = []
    for one in recording.passes:
        counts = one.readings.counts.copy()
        if name in (None, one.name):
            counts[:, where] += by * recording.ribbon.sensors[i].counts_per_unit
        passes.append(replace(one, readings=Readings(one.readings.t, counts)))
    return replace(recording, passes=tuple(passes))


@pytest.mark.parametrize(
    "settings",
    [
        {"weight": {"P1": 1.0, "*": 1.0}},
        {"trim": {"P1": (0.0, 0.0), "*": (0.0, 0.0)}},
        {"sensors_off": {"P1": (), "*": ()}},
    ],
)
def test_what_is_as_usual_changes_nothing(made, plain, settings):
    same(run(made, **settings), plain)


# Sensors


@pytest.mark.parametrize("whose", ["P2", "*"])
def test_what_a_switched_off_sensor_says_does_not_matter(made, whose):
    off = {whose: (BAD,)}
    first = run(made, sensors_off=off)
    name = None if whose == "*" else whose
    for by in (0.3, -7.0, np.nan):
        same(run(made, shaken(made.recording, name, BAD, by), sensors_off=off), first)


def test_a_switched_off_sensor_has_no_residual_and_is_told(made):
    result = run(made, sensors_off={"P2": (BAD, "M01")})
    names = [one.name for one in made.recording.ribbon.sensors]
    for one in result.passes:
        off = [i for i, name in enumerate(names) if one.name == "P2" and name in (BAD, "M01")]
        assert np.isnan(one.residuals[off]).all()
        assert one.sensors_off == tuple(names[i] for i in off)
        assert not set(one.sensors_ignored) & {BAD, "M01"}
    (notice,) = (one for one in result.notices if one.code == "sensor-off")
    assert notice.pass_name == "P2"
    assert notice.message == "pass P2: sensors M01, A03 are switched off and have no say"


def test_one_that_is_off_everywhere_is_told_once(made):
    result = run(made, sensors_off={"*": (BAD,), "P1": (BAD, "M01")})
    told = [one.message for one in result.notices if one.code == "sensor-off"]
    assert told == [
        "all passes: sensor A03 is switched off and has no say",
        "pass P1: sensor M01 is switched off and has no say",
    ]


def test_switching_a_bad_sensor_off_mends_the_verdict(made):
    bad = shaken(made.recording, "P2", BAD, 0.2)
    before, after = run(made, bad), run(made, bad, sensors_off={"P2": (BAD,)})
    assert before.passes[1].quality.verdict != "good"
    assert BAD in before.passes[1].quality.reason
    assert after.passes[1].quality.verdict == "good"
    assert [one.sensor for one in before.notices] == [BAD]
    assert [one.code for one in after.notices] == ["sensor-off"]


def test_a_dead_sensor_that_is_switched_off_is_not_told_as_dead():
    made = simulated(faults=FaultSettings(dead=(BAD,)))
    assert "sensor-dead" in {one.code for one in run(made).notices}
    after = run(made, sensors_off={"*": (BAD,)})
    assert {one.code for one in after.notices} == {"sensor-off"}
    assert all(one.quality.verdict == "good" for one in after.passes)


def test_fewer_sensors_know_less(made):
    off = tuple(one.name for one in made.recording.ribbon.sensors if one.kind == "magnetometer")
    less = run(made, sensors_off={"P2": off[1::2]}, neighbours=False)
    more = run(made, neighbours=False)
    assert less.passes[1].position_sigma.mean() > more.passes[1].position_sigma.mean()


def test_too_few_sensors_are_refused_with_the_reason(made):
    off = tuple(one.name for one in made.recording.ribbon.sensors if one.kind == "magnetometer")
    with pytest.raises(FitError, match=r"P2: 2 magnetometers say something.*6 are switched off"):
        run(made, sensors_off={"P2": off[2:]})


def test_switching_one_off_fits_that_pass_alone_again(made, monkeypatch):
    from georibbon import reconstruction as room

    stages, fitted, real = Stages(), [], room.fit_alone

    def watched(capture, missing, settings):
        fitted.append(list(missing))
        return real(capture, missing, settings)

    monkeypatch.setattr(room, "fit_alone", watched)
    first = run(made, stages=stages)
    run(made, stages=stages, sensors_off={"P2": (BAD,)})
    same(run(made, stages=stages), first)
    assert fitted == [[0, 1, 2], [1], [1]]


# Trims


def test_trimmed_ends_leave_the_rest_as_it_was(made, plain):
    result = run(made, trim={"P2": (0.05, 0.1)})
    (before, after) = (one.passes[1].strip for one in (plain, result))
    assert after.s[[0, -1]] == pytest.approx([0.05, 0.38])
    inside = (before.s > 0.05 + 1e-9) & (before.s < 0.38 - 1e-9)
    np.testing.assert_allclose(after.points[1:-1], before.points[inside], atol=1e-12)
    np.testing.assert_allclose(after.frames[1:-1], before.frames[inside], atol=1e-12)
    # the fit uses it all
    np.testing.assert_array_equal(result.passes[1].residuals, plain.passes[1].residuals)
    for k in (0, 2):
        np.testing.assert_array_equal(result.passes[k].strip.points, plain.passes[k].strip.points)
    frames = after.frames
    np.testing.assert_allclose(
        np.swapaxes(frames, 1, 2) @ frames, np.broadcast_to(np.eye(3), frames.shape), atol=1e-12
    )


def test_new_ends_lie_on_the_curve(made, plain):
    strip = plain.passes[0].strip
    k = len(strip.s) // 3
    at = run(made, trim={"P1": (float(strip.s[k]), 0.0)}).passes[0].strip
    np.testing.assert_allclose(at.points[0], strip.points[k], atol=1e-9)
    between = float(0.5 * (strip.s[k] + strip.s[k + 1]))
    cut = run(made, trim={"P1": (between, 0.0)}).passes[0]
    chord = 0.5 * (strip.points[k] + strip.points[k + 1])
    step = strip.s[k + 1] - strip.s[k]
    assert np.linalg.norm(cut.strip.points[0] - chord) < step**2  # the sag of an arc, R > 1/8 m
    assert cut.position_sigma[0] == pytest.approx(plain.passes[0].position_sigma[k], rel=0.1)


def test_a_trim_makes_the_surface_smaller(made, plain):
    area = run(made, trim={"*": (0.06, 0.06)}).surface.area
    assert area == pytest.approx(plain.surface.area * 0.36 / 0.48, rel=0.05)


def test_what_is_left_makes_the_same_surface_run_the_other_way(made):
    passes = run(made, trim={"*": (0.05, 0.1)}).passes
    names = [one.name for one in passes]
    one = build_surface([one.strip for one in passes], names, SurfaceSettings())
    other = build_surface([one.strip.reversed() for one in passes], names, SurfaceSettings())
    assert other.area == pytest.approx(one.area, rel=1e-7)
    for end in (np.min, np.max):
        np.testing.assert_allclose(
            end(other.mesh.vertices, axis=0), end(one.mesh.vertices, axis=0), atol=1e-5
        )


# Weights


def test_a_pass_of_no_survey_but_its_own_does_not_know_its_weight():
    """One pass by itself, held at its start alone: nothing stands against its readings."""
    made = simulated(layout=LayoutSettings(passes=2))
    recording = replace(made.recording, passes=made.recording.passes[:1])
    marks = tuple(one for one in recording.marks if one.pass_name == "P1")[:1]
    recording = replace(recording, marks=marks, distances=(), crossings=())
    settings = {"surface": None, "neighbours": False}
    one = run(made, recording, **settings)
    for weight in (0.25, 30.0):
        other = run(made, recording, weight={"P1": weight}, **settings)
        np.testing.assert_allclose(
            other.passes[0].strip.points, one.passes[0].strip.points, atol=1e-4
        )
        assert other.passes[0].smoothing == pytest.approx(one.passes[0].smoothing)


def test_a_heavier_pass_bends_less_to_the_survey(made):
    """A mark that is a centimetre off pulls a light pass more than a heavy one."""
    mark = made.recording.marks[-1]
    position = tuple(np.add(mark.position, (0.0, 0.0, 0.01)))
    wrong = replace(
        made.recording,
        marks=(*made.recording.marks[:-1], replace(mark, position=position, sigma=0.003)),
    )
    settings = {"neighbours": False, "surface": None}
    missed = [
        run(made, wrong, weight={mark.pass_name: weight}, **settings).survey[-1].residual
        for weight in (0.1, 1.0, 10.0)
    ]
    assert missed[0] < missed[1] < missed[2]


def test_a_heavier_pass_is_surer(made):
    sigma = [
        run(made, weight={"P2": weight}).passes[1].position_sigma.mean() for weight in (0.1, 1, 10)
    ]
    assert sigma[0] > sigma[1] > sigma[2]


def test_all_weights_alike_are_more_readings_against_the_survey(made):
    first = run(made, weight={"P1": 2.0, "P2": 2.0, "P3": 2.0})
    same(run(made, weight={"*": 2.0}), first)


def told_of_weights(result):
    return [(one.pass_name, one.message) for one in result.notices if one.code == "weighted"]


def test_that_uncertainties_go_with_the_weights_is_told(made, plain):
    assert told_of_weights(plain) == []
    ((name, words),) = told_of_weights(run(made, weight={"*": 1.0, "P2": 30.0}))
    assert name == "P2"
    assert "pass P2: weighed 30 times" in words
    ((name, words),) = told_of_weights(run(made, weight={"*": 0.5}))
    assert name is None
    assert "all passes: weighed 0.5 times" in words
    assert told_of_weights(run(made, method="paper", weight={"P2": 3.0})) == []


# Refusals


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"weight": {"P1": 0.0}}, "the weight of pass P1 is 0; it must be between 0.01 and 100"),
        ({"weight": {"*": -1.0}}, "the weight of all passes is -1"),
        ({"weight": {"P1": np.nan}}, "nan"),
        ({"trim": {"P1": (-0.01, 0.0)}}, "-10 mm are to be cut off the start of pass P1"),
        ({"trim": {"P1": (0.0, np.inf)}}, "cut off the end of pass P1"),
        ({"trim": {"P1": (0.3, 0.3)}}, "leave 0 mm of a ribbon 480 mm long"),
        ({"trim": {"*": (0.44, 0.0)}}, "leave 40 mm"),
        ({"trim": {"P9": (0.1, 0.0)}}, "no pass P9 to trim; the passes are P1, P2, P3"),
        ({"weight": {"P9": 2.0}}, "no pass P9 to weigh"),
        ({"sensors_off": {"P9": ("A01",)}}, "no pass P9 to switch sensors off in"),
        ({"sensors_off": {"P1": ("A99",)}}, "no sensor A99 to switch off; ribbon GR-0001 has"),
    ],
)
def test_nonsense_is_refused(made, settings, words):
    with pytest.raises(SettingsError, match=words.replace("(", r"\(")):
        run(made, **settings)


def test_a_result_says_what_was_chosen_of_each_pass(made):
    chosen = run(made, weight={"P2": 3.0}, trim={"*": (0.01, 0.02)})
    assert [one.weight for one in chosen.passes] == [1.0, 3.0, 1.0]
    assert {one.trim for one in chosen.passes} == {(0.01, 0.02)}
    paper = run(made, weight={"P2": 3.0}, method="paper")
    assert [one.weight for one in paper.passes] == [1.0] * 3  # it weighs nothing
