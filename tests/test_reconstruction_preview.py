"""A preview is about what the whole reconstruction gives, and leaves no trace in it."""

from dataclasses import replace

import numpy as np
import pytest

from georibbon import reconstruction_preview as room
from georibbon.errors import FitError, SettingsError
from georibbon.geometry.surface import SurfaceSettings
from georibbon.reconstruction import ReconstructionSettings, Stages, reconstruct
from georibbon.reconstruction_preview import preview
from georibbon.simulation import (
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
    simulate,
)

# Of a point's standard deviation: what is kept of neighbours and of the noise differs by so much.
CLOSE = 0.05
# A smoothing far beyond what the readings support bends whole passes away from them.
USEFUL = (0.04, 0.06, 0.1, 0.16, 0.24)


@pytest.fixture(scope="module")
def made():
    return simulated()


def simulated(**changes):
    """A small capture: 3 passes of 16 sensors on a dome, with its calibration."""
    usual = {
        "surface": "dome",
        "seed": 5,
        "ribbon": RibbonSettings(sensors=16, length=0.48),
        "layout": LayoutSettings(passes=3),
        "frames": 24,
        "poses": PoseSettings(plan=0),
    }
    return simulate(SimulationSettings(**{**usual, **changes}))


class Work:
    """A recording with its stages and its calibration."""

    def __init__(self, made, recording=None):
        self.recording = recording or made.recording
        self.calibration, self.stages = made.truth.calibration, Stages()

    def whole(self, **settings):
        return reconstruct(
            self.recording, ReconstructionSettings(**settings), self.calibration, self.stages
        )

    def preview(self, **settings):
        return preview(
            self.recording, ReconstructionSettings(**settings), self.calibration, self.stages
        )

    def fresh(self, **settings):
        return reconstruct(self.recording, ReconstructionSettings(**settings), self.calibration)


@pytest.fixture
def work(made):
    work = Work(made)
    work.whole()
    return work


def away(one, other):
    """How far the passes lie apart at most, in the other's standard deviations."""
    return max(
        float((np.linalg.norm(a.strip.points - b.strip.points, axis=1) / b.position_sigma).max())
        for a, b in zip(one.passes, other.passes, strict=True)
    )


def same(one, other):
    """Bit for bit."""
    for a, b in zip(one.passes, other.passes, strict=True):
        np.testing.assert_array_equal(a.strip.points, b.strip.points)
        np.testing.assert_array_equal(a.strip.frames, b.strip.frames)
        np.testing.assert_array_equal(a.covariance, b.covariance)
        np.testing.assert_array_equal(a.residuals, b.residuals)
        assert (a.smoothing, a.quality) == (b.smoothing, b.quality)
    np.testing.assert_array_equal(one.surface.mesh.vertices, other.surface.mesh.vertices)
    np.testing.assert_array_equal(one.surface.mesh.triangles, other.surface.mesh.triangles)
    assert (one.survey, one.notices) == (other.survey, other.notices)


@pytest.mark.parametrize("whose", ["P2", "*"])
def test_it_is_within_a_twentieth_of_what_is_known(work, whose):
    for length in USEFUL:
        shown = work.preview(smoothing={whose: length})
        assert away(shown, work.fresh(smoothing={whose: length})) < CLOSE


@pytest.mark.parametrize(
    "survey",
    [
        SurveySettings(kinds=("starts", "ends")),
        SurveySettings(kinds=("starts", "distances")),
    ],
)
def test_with_ties_and_other_surveys_too(survey):
    made = simulated(layout=LayoutSettings(passes=3, ties=1), survey=survey)
    work = Work(made)
    work.whole()
    for length in (0.05, 0.15):
        shown = work.preview(smoothing={"P1": length, "T1": 0.2})
        fresh = work.fresh(smoothing={"P1": length, "T1": 0.2})
        assert away(shown, fresh) < CLOSE
        assert abs(shown.heading - fresh.heading) < CLOSE * fresh.heading_sigma


def test_where_nothing_moved_it_is_what_was_there(work):
    whole = work.whole()
    shown = work.preview()
    assert away(shown, whole) < 0.01
    assert shown.survey is whole.survey
    for a, b in zip(shown.passes, whole.passes, strict=True):
        np.testing.assert_allclose(a.residuals, b.residuals, atol=1e-2)


def test_what_follows_is_that_of_no_previews_bit_for_bit(work):
    rng = np.random.default_rng(1)
    for length in np.exp(rng.uniform(np.log(0.02), np.log(0.9), 12)):
        work.preview(smoothing={str(rng.choice(["P1", "P2", "P3", "*"])): float(length)})
    same(work.whole(smoothing={"P2": 0.1}), work.fresh(smoothing={"P2": 0.1}))
    work.preview(smoothing={"P2": 0.3})
    same(work.whole(), work.fresh())


def test_the_surface_moves_on_the_same_triangles(work):
    whole = work.whole()
    shown = work.preview(smoothing={"P1": 0.05})
    assert shown.surface.mesh.triangles is whole.surface.mesh.triangles
    assert shown.surface.shape == whole.surface.shape
    fresh = work.fresh(smoothing={"P1": 0.05})
    assert shown.surface.area == pytest.approx(fresh.surface.area, rel=1e-3)
    k = shown.surface.columns[shown.surface.order.index("P1")]
    grid = shown.surface.mesh.vertices.reshape(*shown.surface.shape, 3)
    ends = grid[[0, -1], k]
    strip = shown.passes[0].strip.points[[0, -1]]
    np.testing.assert_allclose(ends[np.argsort(ends[:, 0])], strip[np.argsort(strip[:, 0])])


def test_what_is_kept_is_that_of_the_whole(work):
    whole = work.whole()
    shown = work.preview(smoothing={"P1": 0.05})
    assert shown.notices is whole.notices
    assert shown.surface.checks is whole.surface.checks
    for a, b in zip(shown.passes, whole.passes, strict=True):
        assert a.quality is b.quality
        assert a.covariance is b.covariance
    lengths = [one.smoothing for one in whole.passes]
    assert [one.smoothing for one in shown.passes] == [0.05, *lengths[1:]]


def test_it_knows_trims_weights_and_sensors_that_are_off(work):
    chosen = {
        "trim": {"P2": (0.05, 0.0)},
        "weight": {"P1": 3.0},
        "sensors_off": {"P3": ("A03",)},
        "surface": SurfaceSettings(direction="conormal"),
    }
    whole = work.whole(**chosen)
    shown = work.preview(**chosen, smoothing={"P1": 0.08})
    fresh = work.fresh(**chosen, smoothing={"P1": 0.08})
    assert away(shown, fresh) < CLOSE
    assert shown.passes[1].strip.s[0] == 0.05
    np.testing.assert_array_equal(
        np.isnan(shown.passes[2].residuals), np.isnan(whole.passes[2].residuals)
    )


@pytest.mark.parametrize("whose", ["P2", "*"])
@pytest.mark.parametrize("base", [0.001, 0.1, 10.0])
@pytest.mark.parametrize("length", [0.001, 10.0])
def test_the_farthest_jumps_end_on_the_workpiece(work, whose, base, length):
    whole = work.whole(smoothing={whose: base})
    for _ in range(3):
        shown = work.preview(smoothing={whose: length})
    for one, before in zip(shown.passes, whole.passes, strict=True):
        assert np.abs(one.strip.points - before.strip.points).max() < one.strip.s[-1]
        assert np.isfinite(one.residuals).any()


def test_what_cannot_be_led_to_is_done_wholly(work, monkeypatch):
    def beyond(*_):
        raise np.linalg.LinAlgError("not definite")

    monkeypatch.setattr(room, "follow", beyond)
    same(work.preview(smoothing={"P1": 0.1}), work.fresh(smoothing={"P1": 0.1}))


def test_a_great_way_is_gone_in_steps(work):
    """From fine to far too smooth and back again: it finds the way back."""
    first = work.preview(smoothing={"P2": 0.06})
    for length in (*np.geomspace(0.06, 1.0, 30), *np.geomspace(1.0, 0.06, 30)):
        last = work.preview(smoothing={"P2": float(length)})
    assert away(last, first) < CLOSE


@pytest.mark.parametrize(
    "settings",
    [
        {"weight": {"P1": 2.0}},
        {"trim": {"P1": (0.02, 0.0)}},
        {"sensors_off": {"P1": ("A02",)}},
        {"neighbours": False},
        {"method": "paper"},
        {"surface": None},
        {"surface": SurfaceSettings(tolerance=1e-4)},
    ],
)
def test_what_is_no_smoothing_is_done_wholly(work, settings):
    work.preview(smoothing={"P1": 0.1})
    shown = work.preview(**settings)
    whole = work.fresh(**settings)
    for a, b in zip(shown.passes, whole.passes, strict=True):
        np.testing.assert_array_equal(a.strip.points, b.strip.points)


def test_without_anything_before_it_is_the_whole(made):
    work = Work(made)
    same(work.preview(smoothing={"P1": 0.1}), work.fresh(smoothing={"P1": 0.1}))


def test_another_recording_or_calibration_is_done_wholly(work, made):
    other = replace(made.recording, marks=made.recording.marks[:-1])
    settings = ReconstructionSettings(smoothing={"P1": 0.1})
    shown = preview(other, settings, work.calibration, work.stages)
    assert len(shown.survey) == len(other.marks)
    calibration = replace(work.calibration, notices=())
    shown = preview(made.recording, settings, calibration, work.stages)
    assert shown.calibration is calibration


def test_back_to_automatic_is_chosen_by_the_evidence(work, monkeypatch):
    asked = []
    real = room.reconstruct
    monkeypatch.setattr(
        room, "reconstruct", lambda *inputs: asked.append(inputs[1]) or real(*inputs)
    )
    work.whole(smoothing={"P1": 0.1})
    shown = work.preview()
    assert len(asked) == 1
    same(shown, work.fresh())


def test_it_refuses_what_the_whole_refuses(work, made):
    with pytest.raises(SettingsError, match="P9"):
        work.preview(smoothing={"P9": 0.1})
    loose = replace(made.recording, marks=(), distances=(), crossings=())
    with pytest.raises(FitError, match="survey"):
        preview(loose, ReconstructionSettings(), work.calibration, work.stages)
