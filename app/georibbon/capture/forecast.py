"""What accuracy a plan will give, computed before the first pass is laid.

The planned passes and ties are laid on an assumed surface, and the joint
adjustment is linearised there: with the readings' noise, what the calibration
leaves uncertain, the survey's standard deviations and what would be assumed,
the inverse of its normal matrix is the covariance of every point.  A network
can be designed so because a covariance needs no measurements (Grafarend and
Sansò, Optimization and Design of Geodetic Networks, 1985); only the smoothing
is chosen by readings that are drawn once.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from georibbon.arrays import FloatArray, IntArray
from georibbon.calibration.model import MOUNTING_SIGMA, Calibration, SensorModel
from georibbon.capture.laying import Laid, Likeness, lay_plan
from georibbon.capture.plan import LEAST_SIGMA, MOST_PLANNED, CapturePlan
from georibbon.errors import FitError, SettingsError
from georibbon.fitting import equations
from georibbon.fitting.blocks import BlockMatrix
from georibbon.fitting.fit import LEAST_DIP_SIGMA, LEAST_GAUGE_SIGMA, OFFSET_SIGMA
from georibbon.fitting.joint import JointProblem, State, information, place, with_survey
from georibbon.fitting.neighbours import relate
from georibbon.fitting.placing import Curves
from georibbon.fitting.planning import FIXED, FREE, Plan, make_plan
from georibbon.fitting.sensing import Noise, Observations, SensorArray
from georibbon.fitting.shared import Shared, SharedSigmas
from georibbon.fitting.smoothing import best_lengths, information_density, weight_of_length
from georibbon.fitting.strip import StripProblem, evaluate, sensed_vectors, whiten
from georibbon.fitting.survey import sample
from georibbon.ribbon import Ribbon
from georibbon.rotations import about_z, exp, skew
from georibbon.threads import one_thread
from georibbon.world import field_direction

Source = Literal["calibration", "contact", "survey", "heading"]

USUAL_DIP = float(np.radians(62.0))
# What calibrations from so many poses leave in the rotation common to all sensors, radians.
USUAL_GAUGE = {12: 0.0017, 16: 0.0009, 20: 0.0009}  # 0.10 and 0.05 degrees
USUAL_DIP_SIGMA = float(np.radians(0.1))
HEADING = float(np.radians(25.0))  # of the passes against magnetic axes: none that is special
SAMPLED = 0.05  # m between the points that are looked at
NEARLY_NONE = 0.05  # share of a source of error that is left where it is taken away
WORTH = 0.1  # share by which an advice must better the rms to be given
LEAST_SHARE = 0.05
MOST_ADVICE = 3


class Stopped(Exception):  # noqa: N818 - it is no error
    """A forecast was not wanted any more."""


@dataclass(frozen=True)
class Figures:
    """Predicted standard deviations over all points of the passes.

    rms, worst: metres, of the position (root of the trace).  surface: metres,
    rms of the position square to the surface.  normal: radians, rms of the
    normal's direction.  heading: radians, of the workpiece's heading; None
    where it is taken or there are no marks.
    """

    rms: float
    worst: float
    surface: float
    normal: float
    heading: float | None


@dataclass(frozen=True)
class Limit:
    """A source of error, and the share of the position's variance that goes with it, 0 to 1."""

    source: Source
    share: float
    words: str


@dataclass(frozen=True)
class Advice:
    """What would better the plan, and the rms (m) that it would then have."""

    words: str
    rms: float


@dataclass(frozen=True, eq=False)
class Forecast:
    """What a plan will give.

    aligned: without marks, the figures are of the shape, after the best rigid
    motion.  assumed: on what, in words.  sigma: by the pass's name (k,) m, at
    the fractions `at` (k,) of the ribbon.  limits: the greatest first.  notices:
    what the fit will have to assume, in sentences.
    """

    figures: Figures
    aligned: bool
    likeness: Likeness
    assumed: str
    passes: tuple[str, ...]
    at: FloatArray
    sigma: FloatArray
    limits: tuple[Limit, ...]
    advice: tuple[Advice, ...]
    notices: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Network:
    """The linearised adjustment of what was laid.  pass_count: the passes before the ties."""

    problem: JointProblem
    state: State
    plan: Plan
    pass_count: int


def usual_calibration(ribbon: Ribbon, poses: int = 20) -> Calibration:
    """What a calibration from so many poses will be like, before any was taken.

    Nominal gains, and the uncertainty that such poses leave.
    """
    models = tuple(
        SensorModel(
            sensor.name,
            sensor.counts_per_unit * np.eye(3)[: sensor.axes],
            np.zeros(sensor.axes),
        )
        for sensor in ribbon.sensors
    )
    return Calibration(
        ribbon.id,
        USUAL_DIP,
        models,
        mounting_sigma=MOUNTING_SIGMA,
        gauge_sigma=USUAL_GAUGE.get(poses, USUAL_GAUGE[12]),
        dip_sigma=USUAL_DIP_SIGMA,
    )


def forecast(
    ribbon: Ribbon,
    calibration: Calibration,
    plan: CapturePlan,
    likeness: Likeness = "gentle",
    stop: Callable[[], bool] = lambda: False,
) -> Forecast:
    """The accuracy that a plan will give on a surface of a kind.

    stop: asked now and then; where it says so, `Stopped` is raised.  Raises
    SettingsError for a plan of fewer than two passes, FitError where its survey
    does not hold the passes together.
    """
    with one_thread():
        laid, smoothing, network = _planned(ribbon, calibration, plan, likeness)
        figures, at, sigma = _figures(network)
        _look(stop)
        limits = _limits(ribbon, calibration, laid, smoothing, figures, stop)
        advice = _advice(ribbon, calibration, plan, likeness, smoothing, figures, stop)
    return Forecast(
        figures=figures,
        aligned=not laid.recording.marks,
        likeness=likeness,
        assumed=laid.words,
        passes=tuple(one.name for one in laid.recording.passes[: laid.pass_count]),
        at=at,
        sigma=sigma,
        limits=limits,
        advice=advice,
        notices=tuple(notice.message for notice in network.plan.notices),
    )


def predict(
    ribbon: Ribbon, calibration: Calibration, plan: CapturePlan, likeness: Likeness = "gentle"
) -> Figures:
    """The figures alone; raises as `forecast`."""
    with one_thread():
        return _figures(_planned(ribbon, calibration, plan, likeness)[2])[0]


def _planned(
    ribbon: Ribbon, calibration: Calibration, plan: CapturePlan, likeness: Likeness
) -> tuple[Laid, float, _Network]:
    """The plan as laid, its usual smoothing, and its adjustment."""
    if plan.passes < 2:
        raise SettingsError(
            f"a plan of {plan.passes} passes gives no surface; plan two passes or more"
        )
    laid = lay_plan(ribbon, plan, likeness)
    smoothing = _usual_smoothing(ribbon, calibration, laid)
    return laid, smoothing, _network(ribbon, calibration, laid, smoothing)


def _look(stop: Callable[[], bool]) -> None:
    if stop():
        raise Stopped


def _sensors(
    ribbon: Ribbon, calibration: Calibration, laid: Laid, tilt: FloatArray | None = None
) -> Observations:
    """What the sensors would say without noise; tilt: (p, n, 3) radians, of each sensor's seat."""
    array = SensorArray.of(ribbon, calibration)
    frames = about_z(HEADING) @ laid.frames[:, laid.grid.sensor_nodes]
    if tilt is not None:
        frames = frames @ exp(tilt.reshape(-1, 3)).reshape(frames.shape)
    vectors = sensed_vectors(array, field_direction(calibration.dip))
    seen = (vectors[:, None, :] @ frames)[:, :, 0]
    values = (array.gain @ seen[..., None])[..., 0]
    present = np.broadcast_to(array.used, values.shape[:2]).copy()
    return Observations(values, np.zeros_like(values), present)


def _usual_smoothing(ribbon: Ribbon, calibration: Calibration, laid: Laid) -> float:
    """The weight that the evidence will choose on such passes, the median over them."""
    array = SensorArray.of(ribbon, calibration)
    p, n = laid.pass_count, len(ribbon.sensors)
    usual = Noise()
    contact = float(np.hypot(usual.contact, calibration.mounting_sigma))
    tilt = np.zeros((len(laid.frames), n, 3))
    tilt[:p] = contact * np.random.default_rng(0).standard_normal((p, n, 3))
    observed = _sensors(ribbon, calibration, laid, tilt).take(list(range(p)))
    vectors = sensed_vectors(array, field_direction(calibration.dip))
    problem = StripProblem(laid.grid, array, observed, vectors, replace(usual, contact=contact))
    shape = replace(laid.shape, start=about_z(HEADING) @ laid.shape.start).take(list(range(p)))
    strips = evaluate(problem, shape, np.zeros(p), whiten(problem, shape))
    length = float(np.median(best_lengths(problem, strips)))
    return float(weight_of_length(length, information_density(problem)))


def _network(
    ribbon: Ribbon,
    calibration: Calibration,
    laid: Laid,
    smoothing: float,
    noise: Noise | None = None,
) -> _Network:
    """The adjustment at the truth: nothing is missed, so every weight is whole.

    Raises FitError where the survey does not hold the passes together.
    """
    p, n = len(laid.frames), len(ribbon.sensors)
    curves = Curves(
        laid.grid.nodes,
        np.arange(p, dtype=np.int64),
        np.zeros(p),
        (laid.points - laid.origins[:, None]) @ about_z(HEADING).T,
        about_z(HEADING) @ laid.frames,
    )
    plan = make_plan(laid.recording, curves)
    known = plan.heading is not None
    anchor_sigma = np.full(p, FREE)
    if not plan.survey.marked:
        anchor_sigma[0] = FIXED
    shared = Shared(HEADING, calibration.dip, np.zeros((n, 3)), np.zeros((n, 3)))
    problem = JointProblem(
        grid=laid.grid,
        array=SensorArray.of(ribbon, calibration),
        observations=_sensors(ribbon, calibration, laid),
        noise=noise or Noise(),
        smoothing=np.full(p, smoothing),
        survey=(
            *equations.observations(plan.survey),
            *equations.loose_assumptions((*plan.survey.loose, *plan.assumed)),
        ),
        anchors=laid.origins.copy(),
        anchor_sigma=anchor_sigma,
        expected=shared,
        sigmas=SharedSigmas(
            heading=plan.heading_sigma if known else FREE,
            dip=max(calibration.dip_sigma, LEAST_DIP_SIGMA),
            mounting=max(calibration.mounting_sigma, FIXED),
            gauge=max(calibration.gauge_sigma, LEAST_GAUGE_SIGMA),
            offset=OFFSET_SIGMA,
        ),
    )
    state = State(laid.shape, laid.origins, shared)
    relation = relate(place(problem, state), list(range(laid.pass_count)))
    related = problem if relation is None else with_survey(problem, relation)
    return _Network(related, state, plan, laid.pass_count)


def _figures(network: _Network) -> tuple[Figures, FloatArray, FloatArray]:
    """The figures, the places (k,) as fractions, and each pass's sigma there (p, k) metres."""
    matrix, placed = information(network.problem, network.state)
    length = float(placed.grid.nodes[-1])
    count = max(5, round(length / SAMPLED) + 1)
    at = np.linspace(0.0, length, count)
    p = network.pass_count
    which = np.repeat(np.arange(p, dtype=np.int64), count)
    points = sample(placed, which, np.tile(at, p))
    root = _root(matrix)
    moves = _spread(which, points.moves, root)
    turns = _spread(which, points.turns, root)
    if not network.plan.survey.marked:
        moves, turns = _aligned(points.points, moves, turns)
    variance = np.sum(moves**2, axis=(1, 2))
    normals = points.frames[:, :, 2]
    square = np.sum(np.sum(moves * normals[:, :, None], axis=1) ** 2, axis=1)
    lean = np.cross(turns, normals[:, :, None], axis=1)
    about = np.sum(lean**2, axis=(1, 2))
    heading = None
    if network.plan.survey.marked:
        row = np.zeros((1, sum(matrix.sizes)))
        row[0, sum(matrix.sizes[:-1])] = 1.0
        heading = float(np.linalg.norm(solve_triangular(root, row.T, lower=True)))
    figures = Figures(
        rms=float(np.sqrt(variance.mean())),
        worst=float(np.sqrt(variance.max())),
        surface=float(np.sqrt(square.mean())),
        normal=float(np.sqrt(0.5 * about.mean())),
        heading=heading,
    )
    return figures, at / length, np.sqrt(variance).reshape(p, count)


def _root(matrix: BlockMatrix) -> FloatArray:
    """(m, m) the lower Cholesky factor of the whole matrix."""
    ends = np.concatenate([[0], np.cumsum(matrix.sizes)])
    whole = np.zeros((ends[-1], ends[-1]))
    for (i, j), block in matrix.blocks.items():
        whole[ends[i] : ends[i + 1], ends[j] : ends[j + 1]] = block
    return np.asarray(cholesky(whole, lower=True, check_finite=False))


def _spread(which: IntArray, rows: FloatArray, root: FloatArray) -> FloatArray:
    """(k, 3, m) Y with Y Y^T the covariance of all k points' (3,) values together.

    rows: (k, 3, own) derivatives by the unknowns of each point's pass `which`.
    """
    own = rows.shape[2]
    whole = np.zeros((len(rows), 3, len(root)))
    for k, p in enumerate(which):
        whole[k, :, own * p : own * (p + 1)] = rows[k]
    flat = solve_triangular(root, whole.reshape(-1, len(root)).T, lower=True, check_finite=False)
    return np.asarray(flat.T.reshape(whole.shape))


def _aligned(
    points: FloatArray, moves: FloatArray, turns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Moves and turns (k, 3, m) without the rigid motion that fits the moves best."""
    k = len(points)
    about = points - points.mean(axis=0)
    rigid = np.concatenate([np.broadcast_to(np.eye(3), (k, 3, 3)), -skew(about)], axis=2)
    motion, *_ = np.linalg.lstsq(rigid.reshape(-1, 6), moves.reshape(3 * k, -1), rcond=None)
    return moves - rigid @ motion, turns - motion[3:]


def _limits(
    ribbon: Ribbon,
    calibration: Calibration,
    laid: Laid,
    smoothing: float,
    figures: Figures,
    stop: Callable[[], bool],
) -> tuple[Limit, ...]:
    """What the variance goes back to: each source taken away in turn, the others left."""
    out = []
    for source, words, make in _without(ribbon, calibration, laid, smoothing):
        _look(stop)
        left = _figures(make())[0].rms
        out.append(Limit(source, max(0.0, 1.0 - (left / figures.rms) ** 2), words))
    kept = [one for one in out if one.share >= LEAST_SHARE]
    return tuple(sorted(kept, key=lambda one: -one.share))


def _without(
    ribbon: Ribbon, calibration: Calibration, laid: Laid, smoothing: float
) -> list[tuple[Source, str, Callable[[], _Network]]]:
    """Each source of error in words, and what makes the adjustment that hardly has it."""
    usual = Noise()
    quiet = Noise(*(NEARLY_NONE * one for one in (usual.contact, usual.acceleration, usual.field)))
    sure = replace(
        calibration,
        mounting_sigma=NEARLY_NONE * calibration.mounting_sigma,
        gauge_sigma=NEARLY_NONE * calibration.gauge_sigma,
    )
    exact = laid.measured(NEARLY_NONE)
    sources: list[tuple[Source, str, Callable[[], _Network]]] = [
        (
            "calibration",
            "what the calibration leaves uncertain",
            lambda: _network(ribbon, sure, laid, smoothing),
        ),
        (
            "contact",
            "how flat the ribbon lies, and its noise",
            lambda: _network(ribbon, calibration, laid, smoothing, quiet),
        ),
        (
            "survey",
            "how well marks, distances and crossings are measured",
            lambda: _network(ribbon, calibration, exact, smoothing),
        ),
    ]
    if laid.recording.marks:
        told = laid.with_heading(HEADING)
        words = "the workpiece's heading, which the survey tells badly"
        sources.append(("heading", words, lambda: _network(ribbon, calibration, told, smoothing)))
    return sources


def _advice(
    ribbon: Ribbon,
    calibration: Calibration,
    plan: CapturePlan,
    likeness: Likeness,
    smoothing: float,
    figures: Figures,
    stop: Callable[[], bool],
) -> tuple[Advice, ...]:
    """Changes of the plan that better it worth while, the best first."""
    layout, marked = plan.layout, plan.layout.marks > 0
    out = []
    for words, other in _changes(plan):
        _look(stop)
        better = lay_plan(ribbon, other, likeness)
        # Marks put the figures into another frame: there is nothing to compare with.
        if bool(better.recording.marks) != marked and not plan.ties and not layout.distances:
            continue
        try:
            rms = _figures(_network(ribbon, calibration, better, smoothing))[0].rms
        except FitError:
            continue
        if rms <= (1.0 - WORTH) * figures.rms:
            out.append(Advice(words, rms))
    return tuple(sorted(out, key=lambda one: one.rms)[:MOST_ADVICE])


def _changes(plan: CapturePlan) -> list[tuple[str, CapturePlan]]:
    """What might better a plan, in words, and the plan that it would be."""
    layout = plan.layout

    def laid(**changes: Any) -> CapturePlan:
        return replace(plan, layout=replace(layout, **changes))

    tried = [("two ties more", replace(plan, ties=min(plan.ties + 2, MOST_PLANNED)))]
    if layout.marks < 2:
        tried.append(("mark the start and the end of every pass", laid(marks=2)))
    elif layout.marks < 4:
        tried.append(("mark one more point of every pass", laid(marks=layout.marks + 1)))
    if layout.distances < 2 and not layout.marks:
        words = "measure the distances between neighbouring starts and ends"
        tried.append((words, laid(distances=2)))
    sigmas = ("mark_sigma", "distance_sigma", "crossing_sigma")
    finer = laid(**{name: max(0.5 * getattr(layout, name), LEAST_SIGMA) for name in sigmas})
    return [*tried, ("measure marks, distances and crossings twice as well", finer)]
