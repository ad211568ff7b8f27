"""From a recording to a surface: the one pure function, its settings and its result."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, TypeVar, cast

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration import calibrate, check_fits
from georibbon.calibration.model import Calibration
from georibbon.errors import CalibrationError, FitError
from georibbon.fitting.assessment import Assessment, Verdict, assess
from georibbon.fitting.capture import Capture, prepare
from georibbon.fitting.equations import observations, read_survey, without_loose_ties
from georibbon.fitting.fit import FitSettings, fit_alone, fit_together
from georibbon.fitting.paper import fit_paper
from georibbon.fitting.placing import DRIFT_SIGMA
from georibbon.fitting.result import PassesFit
from georibbon.fitting.screening import Screened, screen
from georibbon.fitting.settings import (
    LONGEST_SMOOTHING,
    METHODS,
    SHORTEST_SMOOTHING,
    Method,
    ReconstructionSettings,
    Trim,
    check_settings,
    weight_notices,
)
from georibbon.fitting.strip import Strips
from georibbon.fitting.survey import Placed
from georibbon.fitting.trimming import Curve, trimmed
from georibbon.geometry.frames import Strip
from georibbon.geometry.settings import TangentRule
from georibbon.geometry.surface import Surface, SurfaceSettings, build_surface
from georibbon.notices import Notice
from georibbon.recording import Pass, PassKind, Recording
from georibbon.ribbon import Readings, Ribbon
from georibbon.threads import one_thread

T = TypeVar("T")

__all__ = [
    "LONGEST_SMOOTHING",
    "METHODS",
    "SHORTEST_SMOOTHING",
    "FittedPass",
    "Method",
    "Quality",
    "Reconstruction",
    "ReconstructionSettings",
    "Stages",
    "SurveyResidual",
    "Whole",
    "reconstruct",
]

SurveyKind = Literal["mark", "distance", "crossing"]
SURVEY_OUTLIER = 5.0  # standard deviations
CONTRADICTION = 0.02  # m: a slip beyond what passes drift by


@dataclass(frozen=True)
class Quality:
    """The verdict on one pass, and why."""

    verdict: Verdict
    reason: str


@dataclass(frozen=True, eq=False)
class FittedPass:
    """One pass as fitted, in the workpiece frame.

    strip: n points of the curve.  covariance: (n, 3, 3) float64, m², of each
    point's position.  normal_sigma: (n,) float64, radians, standard deviation
    of each normal's direction (root of the mean of its two components'
    variances).  residuals: (sensors, 3) float64, each sensor axis's residual
    divided by its standard deviation, NaN where the sensor has no such axis or
    was not used.  residual_rms: root mean square of those that are used.
    smoothing: metres, the detail that is still followed.  sensors_ignored:
    names of those that disagree or say nothing; sensors_off: of those that were
    switched off.  Where ends are trimmed, by so many metres, the strip begins and
    ends there, its places counted from the ribbon's start as ever.  weight: how
    many times the pass counts against the others; the paper's way weighs nothing.
    """

    name: str
    kind: PassKind
    strip: Strip
    covariance: FloatArray
    normal_sigma: FloatArray
    residuals: FloatArray
    residual_rms: float
    smoothing: float
    sensors_ignored: tuple[str, ...]
    quality: Quality
    sensors_off: tuple[str, ...] = ()
    trim: Trim = (0.0, 0.0)
    weight: float = 1.0

    @property
    def position_sigma(self) -> FloatArray:
        """(n,) metres: the square root of the trace of each point's covariance."""
        return np.asarray(np.sqrt(np.trace(self.covariance, axis1=1, axis2=2)))


@dataclass(frozen=True)
class SurveyResidual:
    """One observation of the survey after the fit.

    residual: metres, measured minus fitted (norm for a position); ratio: that
    divided by the observation's standard deviation.
    """

    kind: SurveyKind
    passes: tuple[str, ...]
    at: tuple[float, ...]
    residual: float
    sigma: float
    ratio: float


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """The result: calibrated, placed, checked passes and their surface.

    All in the workpiece frame, metres.  heading: radians, the workpiece's
    rotation from magnetic axes, counter-clockwise seen from above;
    heading_sigma: its standard deviation, None where the heading was not found
    but taken.  `surface` is None where it was not asked for.  tangents: how they
    were interpolated, of the paper's way alone.
    """

    ribbon: Ribbon
    method: Method
    calibration: Calibration
    heading: float
    heading_sigma: float | None
    passes: tuple[FittedPass, ...]
    survey: tuple[SurveyResidual, ...]
    surface: Surface | None
    notices: tuple[Notice, ...]
    tangents: TangentRule = "unrolled"


class Stages:
    """Results of the stages of earlier reconstructions, kept until what they depend on changes.

    Every result is held with what it was made from, and taken again only where
    those are the same objects or equal plain values.
    """

    def __init__(self) -> None:
        self._held: dict[object, tuple[tuple[object, ...], object]] = {}

    def get(self, stage: object, of: tuple[object, ...], make: Callable[[], T]) -> T:
        """The stage's result for these inputs, made anew where they changed."""
        held = self._held.get(stage)
        if held is not None and _same(held[0], of):
            return cast("T", held[1])
        value = make()
        self.put(stage, of, value)
        return value

    def has(self, stage: object, of: tuple[object, ...]) -> bool:
        """Whether the stage's result for these inputs is held."""
        held = self._held.get(stage)
        return held is not None and _same(held[0], of)

    def latest(self, stage: object) -> object | None:
        """What is held of a stage, whatever it was made from; None where nothing is."""
        held = self._held.get(stage)
        return None if held is None else held[1]

    def put(self, stage: object, of: tuple[object, ...], value: object) -> None:
        """Holds a result."""
        self._held[stage] = (of, value)


def _same(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    plain = (bool, int, float, str, type(None), tuple, SurfaceSettings)
    return len(one) == len(other) and all(
        a is b or (isinstance(a, plain) and type(a) is type(b) and a == b)
        for a, b in zip(one, other, strict=True)
    )


def reconstruct(
    recording: Recording,
    settings: ReconstructionSettings | None = None,
    calibration: Calibration | None = None,
    stages: Stages | None = None,
) -> Reconstruction:
    """The passes of a recording, calibrated, fitted and placed, and the surface through them.

    calibration: in the place of the recording's own poses.  stages: results of
    an earlier call, used again where their inputs are the same objects, and
    brought up to date; without it every stage is done.

    Raises `CalibrationError`, `FitError` or `SurfaceError` where the input does
    not determine the result, and `SettingsError` for a pass that is not there.
    """
    with one_thread():
        return _reconstruct(
            recording, settings or ReconstructionSettings(), calibration, stages or Stages()
        )


@dataclass(frozen=True, eq=False)
class Whole:
    """A whole reconstruction with what it was made from, for those near it."""

    recording: Recording
    settings: ReconstructionSettings
    calibration: Calibration | None
    fit: PassesFit
    result: Reconstruction


def _reconstruct(
    recording: Recording,
    settings: ReconstructionSettings,
    given: Calibration | None,
    stages: Stages,
) -> Reconstruction:
    check_settings(settings, recording)
    calibration = _calibration(recording, given, stages)
    held, left_out = stages.get("held", (recording,), lambda: without_loose_ties(recording))
    heard = _heard(held, settings, stages)
    capture = _capture(heard, calibration, settings, stages)
    fit = _fit(capture, settings, stages)
    survey = _survey_residuals(heard, capture, fit)
    outliers = _outliers(survey, settings.method)
    _require_agreement(survey, outliers)
    missed = Counter(name for one in outliers for name in set(one.passes))
    assessments, notices = assess(capture, fit, missed)
    passes = tuple(
        _fitted_pass(capture, fit, p, assessment, settings)
        for p, assessment in enumerate(assessments)
    )
    result = Reconstruction(
        ribbon=recording.ribbon,
        method=settings.method,
        calibration=calibration,
        heading=fit.heading,
        heading_sigma=fit.heading_sigma,
        passes=passes,
        survey=survey,
        surface=_surface_of(passes, fit, settings, stages),
        notices=(
            *calibration.notices,
            *left_out,
            *_off_notices(heard, capture.off),
            *weight_notices(settings, (one.name for one in heard.passes)),
            *_unasked(_screened(heard, calibration, stages), heard, capture.off),
            *fit.notices,
            *notices,
            *map(_survey_notice, outliers),
        ),
        tangents=settings.tangents,
    )
    stages.put("whole", (), Whole(recording, settings, given, fit, result))
    return result


def _heard(recording: Recording, settings: ReconstructionSettings, stages: Stages) -> Recording:
    """The recording without the readings of sensors that are switched off."""
    ribbon = recording.ribbon
    passes = []
    for one in recording.passes:
        off = settings.off_in(one.name)
        silent = tuple(i for i, sensor in enumerate(ribbon.sensors) if sensor.name in off)
        silenced = partial(_silenced, ribbon, one, silent)
        passes.append(stages.get(("heard", one.name), (one, silent), silenced))
    if all(a is b for a, b in zip(passes, recording.passes, strict=True)):
        return recording
    return stages.get(
        "heard", (recording, *passes), lambda: replace(recording, passes=tuple(passes))
    )


def _silenced(ribbon: Ribbon, one: Pass, silent: tuple[int, ...]) -> Pass:
    """The pass without the readings of some sensors; itself where there are none to silence."""
    if not silent:
        return one
    counts = one.readings.counts.copy()
    for i in silent:
        counts[:, ribbon.slices[i]] = np.nan
    return replace(one, readings=Readings(one.readings.t, counts))


def _off(recording: Recording, settings: ReconstructionSettings) -> BoolArray:
    """(p, sensors) which are switched off."""
    names = [sensor.name for sensor in recording.ribbon.sensors]
    off = [settings.off_in(one.name) for one in recording.passes]
    return np.array([[name in silent for name in names] for silent in off])


def _off_notices(recording: Recording, off: BoolArray) -> list[Notice]:
    """What is switched off, those alike in all passes told once."""
    sensors = recording.ribbon.sensors
    everywhere = off.all(axis=0)
    out = []
    for name, which in (
        (None, everywhere),
        *((one.name, row & ~everywhere) for one, row in zip(recording.passes, off, strict=True)),
    ):
        names = [sensor.name for sensor, yes in zip(sensors, which, strict=True) if yes]
        if names:
            whose = "all passes" if name is None else f"pass {name}"
            many = len(names) > 1
            message = (
                f"{whose}: sensor{'s' if many else ''} {', '.join(names)} "
                f"{'are' if many else 'is'} switched off and {'have' if many else 'has'} no say"
            )
            out.append(Notice("sensor-off", message, name, None if many else names[0]))
    return out


def _unasked(screened: Screened, recording: Recording, off: BoolArray) -> list[Notice]:
    """The screening's notices but those of sensors that are switched off."""
    sensors = recording.ribbon.sensors
    silent = {
        (one.name, sensor.name)
        for one, row in zip(recording.passes, off, strict=True)
        for sensor, yes in zip(sensors, row, strict=True)
        if yes
    }
    return [one for one in screened.notices if (one.pass_name, one.sensor) not in silent]


def _calibration(recording: Recording, given: Calibration | None, stages: Stages) -> Calibration:
    if given is None:
        if not recording.poses:
            raise CalibrationError(
                "the recording holds no calibration poses; give a calibration file that was made "
                "of this ribbon"
            )
        ribbon, poses = recording.ribbon, recording.poses
        return stages.get("calibration", (ribbon, *poses), lambda: calibrate(ribbon, poses))
    check_fits(given, recording.ribbon)
    return given


def _capture(
    recording: Recording,
    calibration: Calibration,
    settings: ReconstructionSettings,
    stages: Stages,
) -> Capture:
    screened = _screened(recording, calibration, stages)
    off = _off(recording, settings)
    of = (recording, calibration)  # what is switched off makes another recording
    return stages.get("capture", of, lambda: prepare(recording, calibration, screened, off))


def _screened(recording: Recording, calibration: Calibration, stages: Stages) -> Screened:
    ribbon, passes = recording.ribbon, recording.passes
    return stages.get(
        "screened", (calibration, *passes), lambda: screen(ribbon, passes, calibration)
    )


def _fit(capture: Capture, settings: ReconstructionSettings, stages: Stages) -> PassesFit:
    if settings.method == "paper":
        word = settings.tangents
        return stages.get("paper", (capture, word), lambda: fit_paper(capture, word))
    chosen = FitSettings(settings.neighbours, settings.smoothing, settings.weight)
    candidates = _candidates(capture, chosen, stages)
    weights = tuple(settings.weight_of(one.name) for one in capture.recording.passes)
    of = (capture, settings.neighbours, weights, *candidates)
    return stages.get("ribbon", of, lambda: fit_together(capture, candidates, chosen))


def _candidates(capture: Capture, settings: FitSettings, stages: Stages) -> list[Strips]:
    """Each pass by itself; all that are missing are fitted in one go."""
    passes = capture.recording.passes
    every = settings.smoothing.get("*")
    inputs = [(one, capture.calibration, settings.smoothing.get(one.name, every)) for one in passes]
    missing = [
        k
        for k, (one, of) in enumerate(zip(passes, inputs, strict=True))
        if not stages.has(("alone", one.name), of)
    ]
    if missing:
        for k, strips in zip(missing, fit_alone(capture, missing, settings), strict=True):
            stages.put(("alone", passes[k].name), inputs[k], strips)
    return [
        stages.get(("alone", one.name), of, _never) for one, of in zip(passes, inputs, strict=True)
    ]


def _never() -> Strips:
    raise AssertionError("a stage that was just put is held")


def _fitted_pass(
    capture: Capture,
    fit: PassesFit,
    p: int,
    assessment: Assessment,
    settings: ReconstructionSettings,
) -> FittedPass:
    one = capture.recording.passes[p]
    absent = ~(fit.present[p][:, None] & capture.array.axes)
    curve = Curve(
        Strip(fit.s, fit.points[p], fit.frames[p]), fit.covariance[p], fit.normal_sigma[p]
    )
    left = trimmed(curve, settings.trim_of(one.name))
    sensors = zip(capture.recording.ribbon.sensors, capture.off[p], strict=True)
    return FittedPass(
        name=one.name,
        kind=one.kind,
        strip=left.strip,
        covariance=left.covariance,
        normal_sigma=left.normal_sigma,
        residuals=np.where(absent, np.nan, fit.residuals[p]),
        residual_rms=assessment.residual_rms,
        smoothing=float(fit.lengths[p]),
        sensors_ignored=assessment.ignored,
        quality=Quality(assessment.verdict, assessment.reason),
        sensors_off=tuple(sensor.name for sensor, silent in sensors if silent),
        trim=settings.trim_of(one.name),
        weight=1.0 if settings.method == "paper" else settings.weight_of(one.name),
    )


def _surface_of(
    passes: tuple[FittedPass, ...],
    fit: PassesFit,
    settings: ReconstructionSettings,
    stages: Stages,
) -> Surface | None:
    wanted = settings.surface
    if wanted is None:
        return None
    trims = tuple(settings.trim_of(one.name) for one in passes)
    return stages.get("surface", (fit, wanted, trims), lambda: _surface(passes, wanted))


def _surface(passes: tuple[FittedPass, ...], settings: SurfaceSettings) -> Surface:
    curves = [one for one in passes if one.kind == "pass"]
    return build_surface(
        [one.strip for one in curves],
        [one.name for one in curves],
        settings,
        [one.position_sigma for one in curves],
        [one.normal_sigma for one in curves],
        ties_of(passes),
    )


def ties_of(passes: tuple[FittedPass, ...]) -> list[tuple[str, Strip]]:
    """The curves laid across the others, with their names, as `build_surface` takes them."""
    return [(one.name, one.strip) for one in passes if one.kind == "tie"]


def _survey_residuals(
    recording: Recording, capture: Capture, fit: PassesFit
) -> tuple[SurveyResidual, ...]:
    """Every observation's residual on the fitted curves."""
    empty = np.zeros((*fit.points.shape, 0))
    placed = Placed(capture.grid, fit.points, fit.frames, empty, empty)
    # A crossing's other two residuals are of the normals, not of the place.
    ratios = [
        float(ratio)
        for part in observations(read_survey(recording))
        for ratio in np.linalg.norm(part.rows(placed).residuals[:, :3], axis=1)
    ]
    return tuple(
        SurveyResidual(kind, passes, at, ratio * sigma, sigma, ratio)
        for (kind, passes, at, sigma), ratio in zip(_observed(recording), ratios, strict=True)
    )


def _observed(
    recording: Recording,
) -> list[tuple[SurveyKind, tuple[str, ...], tuple[float, ...], float]]:
    """Kind, passes, places and sigma of all observations, in the order of their equations."""
    return [
        *(("mark", (one.pass_name,), (one.at,), one.sigma) for one in recording.marks),
        *(("distance", one.passes, one.at, one.sigma) for one in recording.distances),
        *(("crossing", one.passes, one.at, one.sigma) for one in recording.crossings),
    ]


def _outliers(survey: tuple[SurveyResidual, ...], method: Method) -> list[SurveyResidual]:
    """The observations that the curves miss by far more than they should."""
    # Curves that are only placed, not bent, by the survey miss it by their own drift.
    drift = DRIFT_SIGMA if method == "paper" else 0.0
    return [one for one in survey if one.residual > SURVEY_OUTLIER * np.hypot(one.sigma, drift)]


def _require_agreement(survey: tuple[SurveyResidual, ...], outliers: list[SurveyResidual]) -> None:
    """A survey of which most contradicts the readings grossly places nothing."""
    if len(outliers) <= max(len(survey) / 2, 2):
        return
    usual = float(np.median([one.residual for one in outliers]))
    if usual > CONTRADICTION:
        raise FitError(
            f"the survey contradicts the readings: {len(outliers)} of {len(survey)} measurements "
            f"are missed, half of them by more than {1e3 * usual:.0f} mm; look at the units "
            "(metres), the axes (z up, right-handed, the workpiece level), the order of the "
            "places along each pass and the passes' names"
        )


def _survey_notice(one: SurveyResidual) -> Notice:
    places = " and ".join(f"{at:.3f} m" for at in one.at)
    return Notice(
        "survey-outlier",
        f"the {one.kind} of {' and '.join(one.passes)} at {places} is missed by "
        f"{1e3 * one.residual:.1f} mm ({one.ratio:.0f} standard deviations); it counts for less: "
        "measure it again",
        one.passes[0],
    )
