"""All passes of a recording, fitted and placed: the ribbon fit with the survey inside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.calibration.model import Calibration
from georibbon.errors import FitError
from georibbon.fitting import equations
from georibbon.fitting.candidates import find_candidates, stack
from georibbon.fitting.equations import Pair, Survey
from georibbon.fitting.grid import (
    Grid,
    Shape,
    integrate_frames,
    integrate_positions,
    make_grid,
)
from georibbon.fitting.joint import (
    Adjustment,
    JointProblem,
    Shared,
    SharedSigmas,
    State,
    cost_of,
    descend,
    evaluate,
    place,
    with_survey,
)
from georibbon.fitting.neighbours import relate
from georibbon.fitting.placing import HEADING_TOLD, Curves, Placing, best_placings
from georibbon.fitting.rotations import about_z
from georibbon.fitting.screening import Screened
from georibbon.fitting.sensing import Noise, Observations, SensorArray, observe
from georibbon.fitting.smoothing import information_density, length_of_weight
from georibbon.fitting.strip import StripProblem, Strips, field_direction, sensed_vectors
from georibbon.notices import Notice
from georibbon.recording import Recording

LEAST_ACCELEROMETERS = 3
LEAST_MAGNETOMETERS = 3
# Shapes whose costs differ by less than this are not told apart (twice the log of about 150).
AMBIGUOUS_WITHIN = 10.0
# Rigid placings are rough: those this near the best are worth a full adjustment, but no more of
# them than this.
TRY_WITHIN = 60.0
MOST_TRIED = 6
NEIGHBOUR_ROUNDS = 2
KNOWN_HEADING_SIGMA = np.radians(0.5)
# What the calibration leaves at each magnetometer beside its rotation, of the local field.
OFFSET_SIGMA = 0.003
LEAST_GAUGE_SIGMA = np.radians(0.02)
LEAST_DIP_SIGMA = np.radians(0.1)
_FREE = 1e3  # radians or metres: no prior at all
_FIXED = 1e-6


@dataclass(frozen=True)
class FitSettings:
    """neighbours: whether neighbouring passes correct each other.

    smoothing: metres, by the pass's name or "*" for all others; a pass without
    one is smoothed by the evidence.
    """

    neighbours: bool = True
    smoothing: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Capture:
    """What the fit works on: a recording's passes in units, on the ribbon's grid.

    candidates are fitted to `problem`, whose noise counts what all passes
    share as if it were each pass's own.
    """

    recording: Recording
    calibration: Calibration
    grid: Grid
    array: SensorArray
    observations: Observations
    problem: StripProblem
    moved: tuple[bool, ...]


@dataclass(frozen=True, eq=False)
class CaptureFit:
    """All passes fitted and placed.

    lengths: (p,) the smoothing, metres.  ambiguous: (p,) passes of which
    another shape fits as well.
    """

    adjustment: Adjustment
    problem: JointProblem
    lengths: FloatArray
    ambiguous: tuple[bool, ...]
    notices: tuple[Notice, ...]


def prepare(recording: Recording, calibration: Calibration, screened: Screened) -> Capture:
    """The recording's readings as the fit needs them.

    Raises `FitError` where a pass has too few sensors that say something.
    """
    ribbon = recording.ribbon
    array = SensorArray.of(ribbon, calibration)
    observed = observe(ribbon, array, screened.mean, screened.sigma)
    _require_sensors(recording, array, observed)
    grid = make_grid(ribbon)
    noise = Noise()
    alone = replace(noise, contact=float(np.hypot(noise.contact, calibration.mounting_sigma)))
    vectors = sensed_vectors(array, field_direction(calibration.dip))
    problem = StripProblem(grid, array, observed, vectors, alone)
    return Capture(recording, calibration, grid, array, observed, problem, screened.moved)


def _require_sensors(recording: Recording, array: SensorArray, observed: Observations) -> None:
    for one, present in zip(recording.passes, observed.present, strict=True):
        for kind, mask, least in (
            ("accelerometers", ~array.field, LEAST_ACCELEROMETERS),
            ("magnetometers", array.field, LEAST_MAGNETOMETERS),
        ):
            count = int(np.count_nonzero(present & mask))
            if count < least:
                raise FitError(
                    f"pass {one.name}: {count} {kind} say something, at least {least} are needed; "
                    "check the ribbon and repeat the pass"
                )


def fit_alone(capture: Capture, passes: Sequence[int], settings: FitSettings) -> list[Strips]:
    """The candidates of the passes with the given numbers, each by itself."""
    names = [capture.recording.passes[k].name for k in passes]
    every = settings.smoothing.get("*", np.nan)
    lengths = np.array([settings.smoothing.get(name, every) for name in names])
    return find_candidates(capture.problem.take(list(passes)), lengths)


def fit_together(
    capture: Capture, candidates: Sequence[Strips], settings: FitSettings
) -> CaptureFit:
    """All passes with the survey, from each pass's candidates.

    Raises `FitError` where the survey does not hold the passes together.
    """
    survey = equations.read_survey(capture.recording)
    strips = stack(candidates)
    counts = [len(part.cost) for part in candidates]
    owner = np.repeat(np.arange(len(candidates), dtype=np.int64), counts)
    curves = _curves(capture.grid, strips, owner)
    plan = _Plan.of(capture, survey, curves)
    best, others = _decide(
        [
            [_adjust(capture, plan, strips, placing, settings) for placing in placings]
            for placings in (plan.placings(curves, side) for side in plan.sides)
        ]
    )
    problem, state = best.problem, best.state
    ambiguous = _differences(capture.grid, state, [other.state for other in others])
    adjustment = evaluate(problem, state)
    density = information_density(capture.problem)
    notices = [*plan.notices, *_ambiguity_notices(capture.recording, ambiguous)]
    return CaptureFit(
        adjustment,
        problem,
        length_of_weight(problem.smoothing, density),
        ambiguous,
        tuple(notices),
    )


def _curves(grid: Grid, strips: Strips, owner: IntArray) -> Curves:
    frames = integrate_frames(grid, strips.shape)
    points = integrate_positions(grid, strips.shape, frames)
    return Curves(grid.nodes, owner, strips.cost, points, frames)


@dataclass(frozen=True, eq=False)
class _Plan:
    """How the survey is used: known heading, what is assumed, and on which sides to try."""

    survey: Survey
    heading: float | None
    heading_sigma: float
    assumed: tuple[Pair, ...]
    sides: tuple[float, ...]
    notices: tuple[Notice, ...]

    @classmethod
    def of(cls, capture: Capture, survey: Survey, curves: Curves) -> "_Plan":
        """The plan for a survey: what it tells of the heading decides what must be assumed."""
        workpiece = capture.recording.workpiece
        given = None if workpiece is None else workpiece.heading
        heading, sigma = None, _FREE
        if given is not None:
            heading, sigma = float(np.radians(given)), KNOWN_HEADING_SIGMA
        if not survey.marked:
            heading, sigma = heading or 0.0, _FIXED
        assumed: tuple[Pair, ...] = ()
        notices: list[Notice] = []
        if heading is None:
            told = best_placings(curves, equations.links(survey, (), 1.0), None, TRY_WITHIN)
            if told[0].heading_sigma > HEADING_TOLD:
                assumed = equations.square_pairs(survey)
                notices.append(_heading_notice(bool(assumed)))
                if not assumed:
                    heading, sigma = 0.0, _FIXED
        if survey.loose:
            notices.append(_across_notice(capture.recording, survey.loose))
        sides = (1.0, -1.0) if survey.loose or assumed else (1.0,)
        return cls(survey, heading, sigma, assumed, sides, tuple(notices))

    def placings(self, curves: Curves, side: float) -> list[Placing]:
        """The rigid placings on one side that are worth an adjustment, best first."""
        links = equations.links(self.survey, self.assumed, side)
        return best_placings(curves, links, self.heading, TRY_WITHIN)[:MOST_TRIED]


def _heading_notice(square: bool) -> Notice:
    what = (
        "the line of marked points is taken as square to the passes"
        if square
        else "the workpiece's axes are taken as magnetic east and north"
    )
    return Notice(
        "heading-assumed",
        f"the survey does not tell the workpiece's heading, so {what}; mark a second point of "
        "one pass, or give the heading under [workpiece]",
    )


def _across_notice(recording: Recording, pairs: tuple[Pair, ...]) -> Notice:
    names = [one.name for one in recording.passes]
    which = ", ".join(dict.fromkeys(f"{names[pair.i]}-{names[pair.j]}" for pair in pairs))
    return Notice(
        "across-assumed",
        f"only distances hold {which}: the points they were measured between are taken to lie "
        "across from each other, the second pass to the left of the first where the readings "
        "don't tell; marks or a tie pass would settle it",
    )


@dataclass(frozen=True, eq=False)
class _Minimum:
    """A minimum of the full adjustment."""

    problem: JointProblem
    state: State
    cost: float


def _adjust(
    capture: Capture, plan: _Plan, strips: Strips, placing: Placing, settings: FitSettings
) -> _Minimum:
    """The full adjustment from one rigid placing."""
    problem = _joint_problem(capture, plan, strips, placing)
    chosen = strips.shape.take(placing.choice)
    start = Shape(about_z(-placing.heading) @ chosen.start, chosen.rates)
    state = descend(problem, State(start, placing.origins, problem.expected))
    if settings.neighbours:
        passes = [k for k, one in enumerate(capture.recording.passes) if one.kind == "pass"]
        for _ in range(NEIGHBOUR_ROUNDS):
            relation = relate(place(problem, state), passes)
            if relation is None:
                break
            related = with_survey(problem, relation)
            state = descend(related, state)
        else:
            problem = related
    return _Minimum(problem, state, cost_of(problem, state))


def _joint_problem(capture: Capture, plan: _Plan, strips: Strips, placing: Placing) -> JointProblem:
    survey = plan.survey
    calibration, p = capture.calibration, len(capture.recording.passes)
    n = len(capture.array.field)
    anchor_sigma = np.full(p, _FREE)
    if not survey.marked:
        anchor_sigma[0] = _FIXED
    assumptions = equations.loose_assumptions((*survey.loose, *plan.assumed))
    return JointProblem(
        grid=capture.grid,
        array=capture.array,
        observations=capture.observations,
        noise=Noise(),
        smoothing=strips.smoothing[placing.choice],
        survey=(*equations.observations(survey), *assumptions),
        anchors=np.zeros((p, 3)),
        anchor_sigma=anchor_sigma,
        expected=Shared(placing.heading, calibration.dip, np.zeros((n, 3)), np.zeros((n, 3))),
        sigmas=SharedSigmas(
            heading=plan.heading_sigma,
            dip=max(calibration.dip_sigma, LEAST_DIP_SIGMA),
            mounting=calibration.mounting_sigma,
            gauge=max(calibration.gauge_sigma, LEAST_GAUGE_SIGMA),
            offset=OFFSET_SIGMA,
        ),
    )


def _decide(sides: list[list[_Minimum]]) -> tuple[_Minimum, list[_Minimum]]:
    """The minimum to take, and the others on its side that fit about as well.

    The first side is the left: the right is taken only where it clearly fits better.
    """
    best = min(sides[0], key=lambda minimum: minimum.cost)
    side = sides[0]
    for other in sides[1:]:
        found = min(other, key=lambda minimum: minimum.cost)
        if found.cost < best.cost - AMBIGUOUS_WITHIN:
            best, side = found, other
    near = [one for one in side if one is not best and one.cost <= best.cost + AMBIGUOUS_WITHIN]
    return best, near


def _differences(grid: Grid, state: State, others: list[State]) -> tuple[bool, ...]:
    """(p,) passes whose shape is another in one of the other minima."""
    frames = integrate_frames(grid, state.shape)
    out = np.zeros(len(frames), dtype=bool)
    for other in others:
        away = np.abs(integrate_frames(grid, other.shape) - frames)
        out |= away.max(axis=(1, 2, 3)) > 0.1
    return tuple(bool(yes) for yes in out)


def _ambiguity_notices(recording: Recording, ambiguous: tuple[bool, ...]) -> list[Notice]:
    return [
        Notice(
            "ambiguous-shape",
            f"pass {one.name}: two shapes fit its readings and the survey alike; mark one more "
            "point of it, at its end or in its middle",
            one.name,
        )
        for one, yes in zip(recording.passes, ambiguous, strict=True)
        if yes
    ]
