"""What a plan will give: laws of the forecast, and one capture that it must be true of."""

from dataclasses import replace

import numpy as np
import pytest

from georibbon.capture.forecast import Stopped, forecast, predict, usual_calibration
from georibbon.capture.laying import LEAST_LAID, LIKENESSES, MOST_LAID, lay_plan
from georibbon.capture.plan import CapturePlan, PlannedLayout
from georibbon.errors import FitError, SettingsError
from georibbon.reconstruction import ReconstructionSettings, reconstruct
from georibbon.simulation import LayoutSettings, SimulationSettings, SurveySettings, simulate
from georibbon.simulation.scoring import score
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import virtual_ribbon

RIBBON = virtual_ribbon(RibbonSettings(sensors=16, length=0.48))
CALIBRATION = usual_calibration(RIBBON)
UNMARKED = PlannedLayout(marks=0)


def rms(plan, likeness="gentle", calibration=CALIBRATION):
    return predict(RIBBON, calibration, plan, likeness).rms


@pytest.mark.parametrize("likeness", LIKENESSES)
@pytest.mark.parametrize("marks", [0, 2])
def test_more_ties_are_never_worse(likeness, marks):
    plans = [CapturePlan(passes=3, ties=n, layout=PlannedLayout(marks=marks)) for n in (1, 2, 4)]
    found = [rms(plan, likeness) for plan in plans]
    assert found == sorted(found, reverse=True)
    assert found[-1] < found[0]


@pytest.mark.parametrize(
    ("ties", "layout", "name"),
    [
        (0, PlannedLayout(), "mark_sigma"),
        (2, UNMARKED, "crossing_sigma"),
        (0, PlannedLayout(marks=0, distances=2), "distance_sigma"),
    ],
)
def test_what_is_measured_better_is_never_worse(ties, layout, name):
    sigmas = (0.002, 0.001, 0.0005, 0.0001)
    plans = [
        CapturePlan(passes=3, ties=ties, layout=replace(layout, **{name: sigma}))
        for sigma in sigmas
    ]
    found = [rms(plan) for plan in plans]
    assert found == sorted(found, reverse=True)
    assert found[-1] < 0.95 * found[0]


def test_more_marks_and_a_better_calibration_are_never_worse():
    marked = [rms(CapturePlan(passes=3, layout=PlannedLayout(marks=n))) for n in (2, 3, 5)]
    assert marked == sorted(marked, reverse=True)
    plan = CapturePlan(passes=3, ties=2, layout=UNMARKED)
    worse = replace(CALIBRATION, mounting_sigma=3 * CALIBRATION.mounting_sigma)
    assert rms(plan) < rms(plan, calibration=worse)


def test_figures_agree_with_each_other():
    told = forecast(RIBBON, CALIBRATION, CapturePlan(passes=3, ties=1), "bent")
    figures = told.figures
    assert told.sigma.shape == (3, len(told.at))
    assert figures.worst == pytest.approx(told.sigma.max())
    assert figures.rms == pytest.approx(np.sqrt(np.mean(told.sigma**2)))
    assert figures.surface < figures.rms < figures.worst
    assert 0.0 < np.degrees(figures.normal) < 1.0
    assert 0.0 < np.degrees(figures.heading) < 1.0
    assert not told.aligned
    assert told.passes == ("P1", "P2", "P3")
    assert "120°" in told.assumed


def test_what_limits_and_what_would_help_is_told():
    told = forecast(RIBBON, CALIBRATION, CapturePlan(passes=3, layout=PlannedLayout(marks=1)))
    assert told.notices  # the heading is assumed
    assert told.advice[0].words == "mark the start and the end of every pass"
    assert told.advice[0].rms < 0.5 * told.figures.rms
    fine = forecast(RIBBON, CALIBRATION, CapturePlan(passes=3))
    assert fine.limits[0].source == "survey"
    assert all(0.0 < one.share <= 1.0 for one in fine.limits)
    assert all(one.rms < 0.9 * fine.figures.rms for one in fine.advice)


def test_an_advice_that_is_followed_gives_what_it_said():
    plan = CapturePlan(passes=3, ties=1, layout=UNMARKED)
    told = {one.words: one.rms for one in forecast(RIBBON, CALIBRATION, plan).advice}
    marked = replace(plan, layout=PlannedLayout())
    assert told["mark the start and the end of every pass"] == pytest.approx(rms(marked), rel=0.05)
    assert "two ties more" in told
    assert told["two ties more"] == pytest.approx(rms(replace(plan, ties=3)), rel=0.05)


def test_a_plan_at_its_limits_has_a_forecast():
    """An advice never asks for more than can be planned."""
    finest = PlannedLayout(mark_sigma=1e-5, distance_sigma=1e-5, crossing_sigma=1e-5)
    assert forecast(RIBBON, CALIBRATION, CapturePlan(passes=2, layout=finest)).figures.rms > 0.0
    most = CapturePlan(passes=2, ties=1000)
    assert forecast(RIBBON, CALIBRATION, most, "flat").figures.rms > 0.0


def test_a_forecast_is_true_of_a_capture():
    plan = CapturePlan(passes=3, ties=2, layout=UNMARKED)
    told = forecast(RIBBON, CALIBRATION, plan, "flat").figures
    errors, angles = [], []
    for seed in (1, 2, 3):
        settings = SimulationSettings(
            surface="plane",
            seed=seed,
            ribbon=RibbonSettings(sensors=16, length=0.48),
            layout=LayoutSettings(passes=3, ties=2, spacing=0.1, heading=0.0),
            survey=SurveySettings(kinds=()),
        )
        made = simulate(settings)
        result = reconstruct(made.recording, ReconstructionSettings(surface=None))
        found = score(result, made.truth).curves.passes
        errors += [one.rms**2 for name, one in found.items() if name.startswith("P")]
        angles += [one.normal_rms**2 for name, one in found.items() if name.startswith("P")]
    ratio = 1e-3 * np.sqrt(np.mean(errors)) / told.rms
    assert 0.4 < ratio < 1.6
    # Normals go by their two components together, the forecast by one of them.
    assert 0.8 < np.radians(np.sqrt(np.mean(angles))) / told.normal < 1.8


def test_a_plan_that_gives_nothing_is_refused():
    with pytest.raises(SettingsError, match="two passes"):
        rms(CapturePlan(passes=1))
    with pytest.raises(FitError, match="holds no pass"):
        rms(CapturePlan(passes=3, layout=UNMARKED))
    with pytest.raises(SettingsError, match="flat, gentle or bent"):
        rms(CapturePlan(passes=3), "square")


def test_a_forecast_stops_when_it_is_not_wanted():
    with pytest.raises(Stopped):
        forecast(RIBBON, CALIBRATION, CapturePlan(passes=3), stop=lambda: True)


def test_a_large_plan_is_forecast_by_its_first_passes():
    laid = lay_plan(RIBBON, CapturePlan(passes=40, ties=1), "gentle")
    assert laid.pass_count == MOST_LAID
    assert f"first {MOST_LAID} passes" in laid.words
    many = virtual_ribbon(RibbonSettings(sensors=128, length=1.0))
    laid = lay_plan(many, CapturePlan(passes=5, ties=40), "flat")
    assert laid.pass_count == LEAST_LAID
    assert "12 ties only" in laid.words
    most = virtual_ribbon(RibbonSettings(sensors=256, length=2.0))
    assert "6 ties only" in lay_plan(most, CapturePlan(passes=5, ties=40), "flat").words


@pytest.mark.parametrize("likeness", LIKENESSES)
def test_a_plan_is_laid_as_it_says(likeness):
    plan = CapturePlan(passes=4, ties=2, layout=PlannedLayout(spacing=0.06, marks=3, distances=2))
    laid = lay_plan(RIBBON, plan, likeness)
    recording = laid.recording
    assert [one.name for one in recording.passes] == ["P1", "P2", "P3", "P4", "T1", "T2"]
    assert (len(recording.marks), len(recording.distances)) == (12, 6)
    assert len(recording.crossings) == 8
    middle = len(laid.grid.nodes) // 2
    apart = np.linalg.norm(np.diff(laid.points[:4, middle], axis=0), axis=1)
    assert np.allclose(apart, 0.06, atol=0.001)
    for one in recording.crossings:
        here, there = (
            laid.points[recording.passes.index(find(recording, name))] for name in one.passes
        )
        gap = np.linalg.norm(here[:, None] - there[None], axis=2).min()
        assert gap < 0.008


def find(recording, name):
    return next(one for one in recording.passes if one.name == name)
