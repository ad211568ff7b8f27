"""All passes of a recording, fitted and placed: the ribbon fit with the survey inside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.candidates import find_candidates, refitted, stack, with_borrowed
from georibbon.fitting.capture import Capture
from georibbon.fitting.equations import loose_assumptions, observations
from georibbon.fitting.grid import (
    Grid,
    Shape,
    integrate_frames,
    integrate_positions,
)
from georibbon.fitting.joint import (
    JointProblem,
    Minimum,
    State,
    cost_of,
    descend,
    evaluate,
    place,
    with_survey,
)
from georibbon.fitting.neighbours import relate
from georibbon.fitting.placing import AMBIGUOUS_WITHIN, Curves, Placing
from georibbon.fitting.planning import FIXED, FREE, Plan, make_plan
from georibbon.fitting.result import PassesFit, of_adjustment
from georibbon.fitting.shared import Shared, SharedSigmas
from georibbon.fitting.smoothing import best_contact, information_density, length_of_weight
from georibbon.fitting.strip import (
    Strips,
)
from georibbon.notices import Notice
from georibbon.recording import Recording
from georibbon.rotations import about_z

NEIGHBOUR_ROUNDS = 2
USUAL_FACTOR = 1.2  # a contact's noise up to this much greater is usual
# What the calibration leaves at each magnetometer beside its rotation, of the local field.
OFFSET_SIGMA = 0.003
LEAST_GAUGE_SIGMA = np.radians(0.02)
LEAST_DIP_SIGMA = np.radians(0.1)


@dataclass(frozen=True)
class FitSettings:
    """neighbours: whether neighbouring passes correct each other.

    smoothing: metres, by the pass's name or "*" for all others; a pass without
    one is smoothed by the evidence.  weight: how many times a pass counts
    against the others and the survey, likewise; once without one.
    """

    neighbours: bool = True
    smoothing: Mapping[str, float] = field(default_factory=dict)
    weight: Mapping[str, float] = field(default_factory=dict)


def fit_alone(capture: Capture, passes: Sequence[int], settings: FitSettings) -> list[Strips]:
    """The candidates of the passes with the given numbers, each by itself."""
    lengths = _lengths(capture, passes, settings)
    return find_candidates(capture.problem.take(list(passes)), lengths)


def _lengths(capture: Capture, passes: Sequence[int], settings: FitSettings) -> FloatArray:
    """The smoothing lengths asked for, metres, NaN where the evidence is to choose."""
    names = [capture.recording.passes[k].name for k in passes]
    every = settings.smoothing.get("*", np.nan)
    return np.array([settings.smoothing.get(name, every) for name in names])


def fit_together(
    capture: Capture, candidates: Sequence[Strips], settings: FitSettings
) -> PassesFit:
    """All passes with the survey, from each pass's candidates.

    Raises `FitError` where the survey does not hold the passes together.
    """
    candidates = with_borrowed(capture.problem, candidates)
    capture, candidates, noted = _with_found_noise(capture, candidates, settings)
    strips = stack(candidates)
    counts = [len(part.cost) for part in candidates]
    owner = np.repeat(np.arange(len(candidates), dtype=np.int64), counts)
    curves = _curves(capture.grid, strips, owner)
    plan = make_plan(capture.recording, curves)
    best, others = _decide(
        [
            [_adjust(capture, plan, strips, placing, settings) for placing in placings]
            for placings in (plan.placings(curves, side) for side in plan.sides)
        ]
    )
    ambiguous = _differences(capture.grid, best.state, [other.state for other in others])
    return of_adjustment(
        evaluate(best.problem, best.state),
        capture.observations.present,
        length_of_weight(best.problem.smoothing, information_density(capture.problem)),
        ambiguous,
        plan.heading_sigma > FIXED,
        (*noted, *plan.notices, *_ambiguity_notices(capture.recording, ambiguous)),
        best,
    )


def _with_found_noise(
    capture: Capture, candidates: Sequence[Strips], settings: FitSettings
) -> tuple[Capture, Sequence[Strips], list[Notice]]:
    """The capture with the contact's noise as its own readings show it, its passes fitted anew.

    Where that is hardly more than usual nothing is changed.
    """
    best = stack([part.take([0]) for part in candidates])
    usual = capture.problem.noise.contact
    found = best_contact(capture.problem, best)
    if found < USUAL_FACTOR * usual:
        return capture, candidates, []
    problem = replace(capture.problem, noise=replace(capture.problem.noise, contact=found))
    changed = replace(capture, problem=problem)
    lengths = _lengths(capture, range(len(candidates)), settings)
    return changed, refitted(problem, candidates, lengths), [_noise_notice(usual, found)]


def _noise_notice(usual: float, found: float) -> Notice:
    return Notice(
        "readings-scatter",
        f"the sensors scatter by {np.degrees(found):.2f} degrees about smooth curves where "
        f"{np.degrees(usual):.2f} is usual; the standard deviations count it: see that the ribbon "
        "lies flat, and look at the calibration",
    )


def _curves(grid: Grid, strips: Strips, owner: IntArray) -> Curves:
    frames = integrate_frames(grid, strips.shape)
    points = integrate_positions(grid, strips.shape, frames)
    return Curves(grid.nodes, owner, strips.cost, points, frames)


def _adjust(
    capture: Capture, plan: Plan, strips: Strips, placing: Placing, settings: FitSettings
) -> Minimum:
    """The full adjustment from one rigid placing."""
    problem = _joint_problem(capture, plan, strips, placing, settings)
    chosen = strips.shape.take(placing.choice)
    start = Shape(about_z(-placing.heading) @ chosen.start, chosen.rates)
    firm = replace(problem, firm=True)
    state = descend(firm, State(start, placing.origins, problem.expected))
    if not settings.neighbours:
        state = descend(problem, state)
        return Minimum(problem, state, cost_of(problem, state))
    passes = [k for k, one in enumerate(capture.recording.passes) if one.kind == "pass"]
    for _ in range(NEIGHBOUR_ROUNDS):
        relation = relate(place(problem, state), passes)
        related = problem if relation is None else with_survey(problem, relation)
        state = descend(related, state)
    return Minimum(related, state, cost_of(related, state))


def _joint_problem(
    capture: Capture, plan: Plan, strips: Strips, placing: Placing, settings: FitSettings
) -> JointProblem:
    survey = plan.survey
    calibration, p = capture.calibration, len(capture.recording.passes)
    n = len(capture.array.field)
    anchor_sigma = np.full(p, FREE)
    if not survey.marked:
        anchor_sigma[0] = FIXED
    assumptions = loose_assumptions((*survey.loose, *plan.assumed))
    return JointProblem(
        grid=capture.grid,
        array=capture.array,
        observations=capture.observations,
        noise=capture.noise,
        smoothing=strips.smoothing[placing.choice],
        survey=(*observations(survey), *assumptions),
        anchors=np.zeros((p, 3)),
        anchor_sigma=anchor_sigma,
        expected=Shared(placing.heading, calibration.dip, np.zeros((n, 3)), np.zeros((n, 3))),
        sigmas=SharedSigmas(
            heading=plan.heading_sigma,
            dip=max(calibration.dip_sigma, LEAST_DIP_SIGMA),
            mounting=max(calibration.mounting_sigma, FIXED),
            gauge=max(calibration.gauge_sigma, LEAST_GAUGE_SIGMA),
            offset=OFFSET_SIGMA,
        ),
        weights=_weights(capture, settings),
    )


def _weights(capture: Capture, settings: FitSettings) -> FloatArray:
    """(p,) how many times each pass counts."""
    every = settings.weight.get("*", 1.0)
    return np.array([settings.weight.get(one.name, every) for one in capture.recording.passes])


def _decide(sides: list[list[Minimum]]) -> tuple[Minimum, list[Minimum]]:
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
