"""From a recording to a surface: the one pure function, its settings and its result."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeVar, cast

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration import calibrate, check_fits
from georibbon.calibration.model import Calibration
from georibbon.errors import CalibrationError, FitError, SettingsError
from georibbon.fitting.assessment import Assessment, Verdict, assess
from georibbon.fitting.capture import Capture, prepare
from georibbon.fitting.equations import observations, read_survey, without_loose_ties
from georibbon.fitting.fit import FitSettings, fit_alone, fit_together
from georibbon.fitting.paper import fit_paper
from georibbon.fitting.placing import DRIFT_SIGMA
from georibbon.fitting.result import PassesFit
from georibbon.fitting.screening import Screened, screen
from georibbon.fitting.strip import Strips
from georibbon.fitting.survey import Placed
from georibbon.geometry.frames import Strip
from georibbon.geometry.surface import Surface, SurfaceSettings, build_surface
from georibbon.notices import Notice
from georibbon.recording import PassKind, Recording
from georibbon.ribbon import Ribbon
from georibbon.threads import one_thread

T = TypeVar("T")

Method = Literal["ribbon", "paper"]
SurveyKind = Literal["mark", "distance", "crossing"]
METHODS: tuple[Method, ...] = ("ribbon", "paper")
SURVEY_OUTLIER = 5.0  # standard deviations
CONTRADICTION = 0.02  # m: a slip beyond what passes drift by
SHORTEST_SMOOTHING = 0.001  # m: a shorter one means nothing on any ribbon
LONGEST_SMOOTHING = 10.0


@dataclass(frozen=True)
class ReconstructionSettings:
    """What a person may choose.

    method: "ribbon", the fit to the readings, or "paper", from tangents as the
    source paper does.  neighbours: whether neighbouring passes correct each
    other.  smoothing: metres, by the pass's name or "*" for all others; chosen
    by the evidence where nothing is given.  surface: None for curves alone.
    """

    method: Method = "ribbon"
    neighbours: bool = True
    smoothing: Mapping[str, float] = field(default_factory=dict)
    surface: SurfaceSettings | None = field(default_factory=SurfaceSettings)

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise SettingsError(
                f'the method is "{self.method}"; it must be one of {", ".join(METHODS)}'
            )
        for name, length in self.smoothing.items():
            if not (np.isfinite(length) and SHORTEST_SMOOTHING <= length <= LONGEST_SMOOTHING):
                which = "all passes" if name == "*" else f"pass {name}"
                raise SettingsError(
                    f"the smoothing of {which} is {1e3 * length:g} mm; it must be between "
                    f"{1e3 * SHORTEST_SMOOTHING:g} and {1e3 * LONGEST_SMOOTHING:g} mm"
                )


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
    names.
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
    but taken.  `surface` is None where it was not asked for.
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


def _reconstruct(
    recording: Recording,
    settings: ReconstructionSettings,
    calibration: Calibration | None,
    stages: Stages,
) -> Reconstruction:
    _check_names(recording, settings)
    calibration = _calibration(recording, calibration, stages)
    recording, left_out = stages.get("held", (recording,), lambda: without_loose_ties(recording))
    capture = _capture(recording, calibration, stages)
    fit = _fit(capture, settings, stages)
    survey = _survey_residuals(recording, capture, fit)
    outliers = _outliers(survey, settings.method)
    _require_agreement(survey, outliers)
    missed = Counter(name for one in outliers for name in set(one.passes))
    assessments, notices = assess(capture, fit, missed)
    passes = tuple(
        _fitted_pass(capture, fit, p, assessment) for p, assessment in enumerate(assessments)
    )
    wanted = settings.surface
    surface = None
    if wanted is not None:
        surface = stages.get("surface", (fit, wanted), lambda: _surface(passes, wanted))
    screened = _screened(recording, calibration, stages)
    return Reconstruction(
        ribbon=recording.ribbon,
        method=settings.method,
        calibration=calibration,
        heading=fit.heading,
        heading_sigma=fit.heading_sigma,
        passes=passes,
        survey=survey,
        surface=surface,
        notices=(
            *calibration.notices,
            *left_out,
            *screened.notices,
            *fit.notices,
            *notices,
            *map(_survey_notice, outliers),
        ),
    )


def _check_names(recording: Recording, settings: ReconstructionSettings) -> None:
    names = [one.name for one in recording.passes]
    unknown = [name for name in settings.smoothing if name != "*" and name not in names]
    if unknown:
        raise SettingsError(
            f"there is no pass {unknown[0]} to smooth; the passes are {', '.join(names)}"
        )


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


def _capture(recording: Recording, calibration: Calibration, stages: Stages) -> Capture:
    screened = _screened(recording, calibration, stages)
    of = (recording, calibration)
    return stages.get("capture", of, lambda: prepare(recording, calibration, screened))


def _screened(recording: Recording, calibration: Calibration, stages: Stages) -> Screened:
    ribbon, passes = recording.ribbon, recording.passes
    return stages.get(
        "screened", (calibration, *passes), lambda: screen(ribbon, passes, calibration)
    )


def _fit(capture: Capture, settings: ReconstructionSettings, stages: Stages) -> PassesFit:
    if settings.method == "paper":
        return stages.get("paper", (capture,), lambda: fit_paper(capture))
    chosen = FitSettings(settings.neighbours, settings.smoothing)
    candidates = _candidates(capture, chosen, stages)
    of = (capture, settings.neighbours, *candidates)
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


def _fitted_pass(capture: Capture, fit: PassesFit, p: int, assessment: Assessment) -> FittedPass:
    one = capture.recording.passes[p]
    absent = ~(fit.present[p][:, None] & capture.array.axes)
    return FittedPass(
        name=one.name,
        kind=one.kind,
        strip=Strip(fit.s, fit.points[p], fit.frames[p]),
        covariance=fit.covariance[p],
        normal_sigma=fit.normal_sigma[p],
        residuals=np.where(absent, np.nan, fit.residuals[p]),
        residual_rms=assessment.residual_rms,
        smoothing=float(fit.lengths[p]),
        sensors_ignored=assessment.ignored,
        quality=Quality(assessment.verdict, assessment.reason),
    )


def _surface(passes: tuple[FittedPass, ...], settings: SurfaceSettings) -> Surface:
    curves = [one for one in passes if one.kind == "pass"]
    return build_surface(
        [one.strip for one in curves],
        [one.name for one in curves],
        settings,
        [one.position_sigma for one in curves],
        [one.normal_sigma for one in curves],
    )


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
