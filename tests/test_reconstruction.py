"""The one pure function: its result, its stages, its refusals."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from georibbon import reconstruction as room
from georibbon.errors import CalibrationError, FitError, SettingsError, SurfaceError
from georibbon.geometry.settings import TANGENTS
from georibbon.geometry.surface import SurfaceSettings
from georibbon.reconstruction import ReconstructionSettings, Stages, reconstruct
from georibbon.recording import Distance
from georibbon.simulation import (
    FaultSettings,
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
    score,
    simulate,
)


def simulated(**changes):
    """A small capture: 3 passes of 16 sensors on a dome."""
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
    """A capture with marks at starts and ends, and without poses."""
    return simulated()


CURVES = ReconstructionSettings(surface=None)


def run(made, settings=CURVES, stages=None, recording=None):
    return reconstruct(recording or made.recording, settings, made.truth.calibration, stages)


def counted(monkeypatch, *names):
    """Lists of the arguments of every call of functions of the module."""
    calls = {}
    for name in names:
        original, calls[name] = getattr(room, name), []

        def noted(*args, _original=original, _calls=calls[name]):
            _calls.append(args)
            return _original(*args)

        monkeypatch.setattr(room, name, noted)
    return calls


# --- the result ---


def test_from_poses_to_a_surface():
    made = simulated(poses=PoseSettings(plan=16))
    result = reconstruct(made.recording)
    errors = score(result, made.truth)
    assert not errors.aligned
    assert errors.curves.all.rms < 1.5
    assert errors.surface_rms < 1.0
    assert result.method == "ribbon"
    assert result.calibration.quality is not None
    assert result.ribbon is made.recording.ribbon


def test_every_pass_is_told_as_promised(made):
    result = run(made)
    ribbon = made.recording.ribbon
    assert [one.name for one in result.passes] == ["P1", "P2", "P3"]
    for one in result.passes:
        n = len(one.strip.s)
        assert one.kind == "pass"
        assert one.strip.points.shape == (n, 3)
        assert one.strip.frames.shape == (n, 3, 3)
        assert one.covariance.shape == (n, 3, 3)
        assert (np.linalg.eigvalsh(one.covariance) > 0).all()
        assert one.normal_sigma.shape == (n,)
        assert one.strip.s[-1] == ribbon.length
        assert 0 < one.smoothing <= ribbon.length * (1 + 1e-9)
        assert one.sensors_ignored == ()
        assert one.quality.verdict == "good"
        axes = [[k < sensor.axes for k in range(3)] for sensor in ribbon.sensors]
        np.testing.assert_array_equal(np.isfinite(one.residuals), axes)
        assert one.residual_rms == pytest.approx(np.sqrt(np.nanmean(one.residuals**2)))
    assert result.surface is None
    assert result.notices == ()


def test_the_survey_is_told_in_its_order_with_what_it_is_off():
    made = simulated(
        layout=LayoutSettings(passes=3, ties=1),
        survey=SurveySettings(kinds=("starts", "distances")),
    )
    recording = made.recording
    result = run(made)
    kinds = [one.kind for one in result.survey]
    assert kinds == ["mark"] * 3 + ["distance"] * 4 + ["crossing"] * 3
    strips = {one.name: one.strip for one in result.passes}

    def at(name, s):
        strip = strips[name]
        return np.array([np.interp(s, strip.s, x) for x in strip.points.T])

    for mark, found in zip(recording.marks, result.survey[:3], strict=True):
        assert (found.passes, found.at) == ((mark.pass_name,), (mark.at,))
        off = np.linalg.norm(at(mark.pass_name, mark.at) - mark.position)
        assert found.residual == pytest.approx(off, abs=1e-9)
        assert found.ratio == pytest.approx(off / mark.sigma, abs=1e-6)
    for distance, found in zip(recording.distances, result.survey[3:7], strict=True):
        assert (found.passes, found.at) == (distance.passes, distance.at)
        one, other = (at(*place) for place in zip(distance.passes, distance.at, strict=True))
        off = abs(np.linalg.norm(one - other) - distance.distance)
        assert found.residual == pytest.approx(off, abs=1e-9)
    for crossing, found in zip(recording.crossings, result.survey[7:], strict=True):
        one, other = (at(*place) for place in zip(crossing.passes, crossing.at, strict=True))
        # Between nodes a straight line is a little off the curve.
        assert found.residual == pytest.approx(np.linalg.norm(one - other), abs=2e-4)
        assert found.sigma == crossing.sigma
    assert result.passes[3].kind == "tie"


def test_a_mark_wrong_by_5_cm_is_named(made):
    marks = list(made.recording.marks)
    x, y, z = marks[2].position
    marks[2] = replace(marks[2], position=(x, y, z + 0.05))
    result = run(made, recording=replace(made.recording, marks=tuple(marks)))
    outliers = [one for one in result.notices if one.code == "survey-outlier"]
    assert [one.pass_name for one in outliers] == [marks[2].pass_name]
    assert "mark of P2" in outliers[0].message
    assert "measure it again" in outliers[0].message
    assert max(result.survey, key=lambda one: one.residual).passes == ("P2",)


def test_a_survey_that_contradicts_the_readings_is_refused(made):
    """Another unit, which no length betrays."""
    marks = tuple(
        replace(mark, position=tuple(np.multiply(mark.position, 0.5)))
        for mark in made.recording.marks
    )
    with pytest.raises(FitError, match=r"survey contradicts the readings.*z up, right-handed"):
        run(made, recording=replace(made.recording, marks=marks))


def test_marks_that_are_all_a_little_off_are_no_contradiction(made):
    """Named, but not refused: they were given as surer than they are."""
    marks = tuple(
        replace(mark, sigma=1e-4, position=tuple(np.multiply(mark.position, 1.02)))
        for mark in made.recording.marks
    )
    result = run(made, recording=replace(made.recording, marks=marks))
    assert [one.code for one in result.notices].count("survey-outlier") >= 3


def test_a_tie_without_a_crossing_is_left_out_and_named():
    made = simulated(layout=LayoutSettings(passes=3, ties=1))
    recording = replace(made.recording, crossings=())
    result = run(made, recording=recording)
    assert [one.name for one in result.passes] == ["P1", "P2", "P3"]
    assert [(one.code, one.pass_name) for one in result.notices] == [("tie-left-out", "T1")]


def test_a_pass_that_misses_its_marks_is_not_good(made):
    marks = list(made.recording.marks)
    x, y, z = marks[2].position
    marks[2] = replace(marks[2], position=(x, y, z + 0.05))
    result = run(made, recording=replace(made.recording, marks=tuple(marks)))
    verdicts = [one.quality.verdict for one in result.passes]
    assert verdicts == ["good", "acceptable", "good"]


def test_notices_of_all_stages_are_collected():
    made = simulated(
        survey=SurveySettings(kinds=("starts",)),
        faults=FaultSettings(dead=("A03",), magnet=0.3, magnet_on="P2"),
    )
    codes = {notice.code for notice in run(made).notices}
    assert {"sensor-dead", "field-disturbed", "heading-assumed"} <= codes


# --- settings ---


def test_the_surface_is_built_from_the_passes_without_the_ties():
    made = simulated(layout=LayoutSettings(passes=3, ties=1))
    result = run(made, ReconstructionSettings())
    assert score(result, made.truth).surface_rms < 1.5
    assert np.isfinite(result.surface.mesh.vertices).all()
    np.testing.assert_array_equal(run(made).passes[0].strip.points, result.passes[0].strip.points)


def test_one_pass_alone_spans_no_surface_but_is_a_curve(made):
    recording = replace(
        made.recording, passes=made.recording.passes[:1], marks=made.recording.marks[:2]
    )
    assert len(run(made, recording=recording).passes) == 1
    with pytest.raises(SurfaceError):
        run(made, ReconstructionSettings(), recording=recording)


def test_the_papers_way_is_less_exact_and_says_what_it_is(made):
    paper = run(made, ReconstructionSettings(method="paper", surface=None))
    assert paper.method == "paper"
    assert [one.smoothing for one in paper.passes] == [0.0] * 3
    errors = score(paper, made.truth).curves.all.rms
    assert score(run(made), made.truth).curves.all.rms < errors < 10.0
    assert "survey-outlier" not in {notice.code for notice in paper.notices}


def test_the_papers_tangents_are_interpolated_as_asked_by_that_way_alone(made, monkeypatch):
    stages = Stages()
    results = [
        run(made, ReconstructionSettings(method="paper", tangents=word, surface=None), stages)
        for word in TANGENTS
    ]
    assert [result.tangents for result in results] == list(TANGENTS)
    for one, other in combinations(results, 2):
        away = np.abs(one.passes[0].strip.points - other.passes[0].strip.points).max()
        assert 1e-9 < away < 1e-3
    run(made, CURVES, stages)
    calls = counted(monkeypatch, "fit_together")
    run(made, replace(CURVES, tangents="averages"), stages)
    assert numbers(calls) == {}


def test_tangents_that_are_none_are_refused():
    with pytest.raises(SettingsError, match="unrolled, averages, components"):
        ReconstructionSettings(tangents="guess")


def test_a_mark_wrong_by_20_cm_is_named_by_the_papers_way_too(made):
    marks = list(made.recording.marks)
    x, y, z = marks[0].position
    marks[0] = replace(marks[0], position=(x + 0.2, y, z))
    wrong = replace(made.recording, marks=tuple(marks))
    paper = run(made, ReconstructionSettings(method="paper", surface=None), recording=wrong)
    assert "survey-outlier" in {notice.code for notice in paper.notices}


def test_neighbours_change_the_curves_a_little(made):
    alone = run(made, ReconstructionSettings(neighbours=False, surface=None))
    away = [
        np.abs(one.strip.points - other.strip.points).max()
        for one, other in zip(alone.passes, run(made).passes, strict=True)
    ]
    assert 1e-5 < max(away) < 3e-3


def test_smoothing_is_set_by_name_or_for_all_others(made):
    result = run(made, ReconstructionSettings(smoothing={"P2": 0.1, "*": 0.2}, surface=None))
    np.testing.assert_allclose([one.smoothing for one in result.passes], [0.2, 0.1, 0.2])


def test_the_smoothing_of_all_others_is_called_that():
    with pytest.raises(SettingsError, match="smoothing of all passes is 0 mm"):
        ReconstructionSettings(smoothing={"*": 0.0})


@pytest.mark.parametrize("length", [0.0, 0.0005, -0.1, 10.1, np.nan, np.inf])
def test_smoothing_that_means_nothing_is_refused(length):
    with pytest.raises(SettingsError, match=r"smoothing of pass P1 is .* between 1 and 10000 mm"):
        ReconstructionSettings(smoothing={"P1": length})


def test_an_unknown_method_is_refused():
    with pytest.raises(SettingsError, match=r'the method is "best".*ribbon, paper'):
        ReconstructionSettings(method="best")


def test_smoothing_a_pass_that_is_not_there_is_refused(made):
    with pytest.raises(SettingsError, match=r"no pass P9 to smooth; the passes are P1, P2, P3"):
        run(made, ReconstructionSettings(smoothing={"P9": 0.1}))


# --- refusals ---


def test_without_poses_and_calibration_nothing_can_be_done(made):
    with pytest.raises(CalibrationError, match="no calibration poses; give a calibration file"):
        reconstruct(made.recording)


def test_a_calibration_of_another_ribbon_is_refused(made):
    other = replace(made.truth.calibration, ribbon_id="GR-9999")
    with pytest.raises(CalibrationError, match="GR-9999"):
        reconstruct(made.recording, CURVES, other)


def test_a_calibration_given_is_taken_in_the_place_of_the_poses():
    made = simulated(poses=PoseSettings(plan=16))
    result = run(made)
    assert result.calibration is made.truth.calibration


@pytest.mark.parametrize("method", ["ribbon", "paper"])
def test_passes_that_nothing_holds_are_refused(made, method):
    lost = replace(made.recording, marks=made.recording.marks[:2])
    with pytest.raises(FitError, match="P2, P3"):
        run(made, ReconstructionSettings(method=method, surface=None), recording=lost)


# --- pure, and in stages ---


def same(one, other):
    """Bit for bit, as far as numbers go."""
    for a, b in zip(one.passes, other.passes, strict=True):
        for values in ("covariance", "normal_sigma", "residuals"):
            np.testing.assert_array_equal(getattr(a, values), getattr(b, values))
        np.testing.assert_array_equal(a.strip.points, b.strip.points)
        np.testing.assert_array_equal(a.strip.frames, b.strip.frames)
        assert a.smoothing == b.smoothing
        assert a.quality == b.quality
    assert one.survey == other.survey
    assert one.notices == other.notices


@pytest.mark.parametrize("method", ["ribbon", "paper"])
def test_the_same_input_gives_the_same_result_bit_for_bit(made, method):
    settings = ReconstructionSettings(method=method)
    before = [one.readings.counts.copy() for one in made.recording.passes]
    one, other = run(made, settings), run(made, settings)
    same(one, other)
    np.testing.assert_array_equal(one.surface.mesh.vertices, other.surface.mesh.vertices)
    for was, now in zip(before, made.recording.passes, strict=True):
        np.testing.assert_array_equal(was, now.readings.counts)


STAGES = (
    "calibrate",
    "screen",
    "prepare",
    "fit_alone",
    "fit_together",
    "fit_paper",
    "build_surface",
)


def numbers(calls):
    return {name: len(args) for name, args in calls.items() if args}


def test_nothing_is_done_twice(monkeypatch):
    made = simulated(poses=PoseSettings(plan=16))
    calls, stages = counted(monkeypatch, *STAGES), Stages()
    settings = ReconstructionSettings()
    first = reconstruct(made.recording, settings, stages=stages)
    once = {name: 1 for name in STAGES if name != "fit_paper"}
    assert numbers(calls) == once
    again = reconstruct(made.recording, settings, stages=stages)
    assert numbers(calls) == once
    assert again.calibration is first.calibration
    assert again.surface is first.surface
    for a, b in zip(first.passes, again.passes, strict=True):
        assert np.shares_memory(a.strip.points, b.strip.points)


def test_smoothing_one_pass_refits_that_pass_and_the_survey_alone(made, monkeypatch):
    stages = Stages()
    run(made, ReconstructionSettings(), stages)
    calls = counted(monkeypatch, *STAGES)
    settings = ReconstructionSettings(smoothing={"P2": 0.1})
    result = run(made, settings, stages)
    assert numbers(calls) == {"fit_alone": 1, "fit_together": 1, "build_surface": 1}
    assert list(calls["fit_alone"][0][1]) == [1]
    fresh = run(made, settings)
    for a, b in zip(result.passes, fresh.passes, strict=True):
        np.testing.assert_allclose(a.strip.points, b.strip.points, atol=1e-6)
        np.testing.assert_allclose(a.covariance, b.covariance, rtol=1e-2, atol=1e-10)


def test_a_pass_laid_again_refits_that_pass_alone(made, monkeypatch):
    stages = Stages()
    run(made, stages=stages)
    calls = counted(monkeypatch, *STAGES)
    passes = list(made.recording.passes)
    passes[2] = replace(passes[2])
    run(made, stages=stages, recording=replace(made.recording, passes=tuple(passes)))
    assert [list(args[1]) for args in calls["fit_alone"]] == [[2]]


def test_a_new_mark_refits_the_survey_alone(made, monkeypatch):
    stages = Stages()
    run(made, stages=stages)
    calls = counted(monkeypatch, *STAGES)
    one, other, *_ = made.recording.marks
    apart = float(np.linalg.norm(np.subtract(one.position, made.recording.marks[2].position)))
    measured = Distance(("P1", "P2"), (0.0, 0.0), apart, 1e-3)
    result = run(made, stages=stages, recording=replace(made.recording, distances=(measured,)))
    assert "fit_alone" not in numbers(calls)
    assert "screen" not in numbers(calls)
    assert numbers(calls)["fit_together"] == 1
    assert [item.kind for item in result.survey][-1] == "distance"
    assert other.pass_name == "P1"


def test_neighbours_and_surface_change_only_what_follows(made, monkeypatch):
    stages, plain = Stages(), SurfaceSettings()
    run(made, ReconstructionSettings(surface=plain), stages)
    calls = counted(monkeypatch, *STAGES)
    run(made, ReconstructionSettings(surface=plain, neighbours=False), stages)
    assert numbers(calls) == {"fit_together": 1, "build_surface": 1}
    run(made, ReconstructionSettings(surface=SurfaceSettings(), neighbours=False), stages)
    assert numbers(calls)["fit_together"] == 1


def test_both_methods_are_held_beside_each_other(made, monkeypatch):
    stages = Stages()
    paper = ReconstructionSettings(method="paper", surface=None)
    run(made, stages=stages)
    run(made, paper, stages)
    calls = counted(monkeypatch, *STAGES)
    run(made, stages=stages)
    run(made, paper, stages)
    assert numbers(calls) == {}


def test_stages_know_equal_values_and_the_same_objects():
    stages, made_of = Stages(), []
    one, other = object(), object()

    def get(*inputs):
        return stages.get("stage", inputs, lambda: made_of.append(inputs) or len(made_of))

    assert get(one, 1.0, "a", None, (1, 2)) == 1
    assert get(one, 1.0, "a", None, (1, 2)) == 1
    assert get(other, 1.0, "a", None, (1, 2)) == 2
    assert get(other, 1, "a", None, (1, 2)) == 3
    assert get(other, 1) == 4
    assert stages.has("stage", (other, 1))
    assert not stages.has("stage", (other, 2))
    assert not stages.has("another", (other, 1))


def test_the_workpieces_heading_is_found_by_marks_and_taken_without():
    settings = SimulationSettings(surface="dome", seed=4, yaw=37.0)
    marked = reconstruct(simulate(settings).recording)
    away = marked.heading - np.radians(37.0)
    assert marked.heading_sigma is not None
    assert abs(away) < 4 * marked.heading_sigma < np.radians(2.0)
    tied = replace(settings, layout=LayoutSettings(ties=2), survey=SurveySettings(kinds=()))
    free = reconstruct(simulate(tied).recording)
    assert free.heading == pytest.approx(0.0, abs=1e-9)
    assert free.heading_sigma is None


def staggered(ties):
    """One mark on each pass, at another place on each; ties that cross them all, or none."""
    capture = simulate(
        SimulationSettings(
            surface="dome",
            seed=5,
            layout=LayoutSettings(passes=3, ties=ties),
            survey=SurveySettings(kinds=("starts", "ends")),
        )
    )
    ends = {one.pass_name: one for one in capture.recording.marks if one.at > 0}
    starts = {one.pass_name: one for one in capture.recording.marks if one.at == 0}
    marks = (starts["P1"], ends["P2"], starts["P3"])
    return replace(capture.recording, marks=marks)


def test_one_mark_a_pass_at_differing_places_tells_no_heading_and_is_refused():
    with pytest.raises(FitError, match="mark a second point of one pass"):
        reconstruct(staggered(ties=0))


def test_where_ties_hold_the_passes_a_heading_is_told_by_staggered_marks():
    found = reconstruct(staggered(ties=2))
    assert found.heading_sigma is not None
    assert all(one.ratio < 4 for one in found.survey if one.kind == "mark")
