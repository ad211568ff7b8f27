"""The joint adjustment: all passes, the survey and what all passes share, at once.

Unknown are each pass's strip and start point, and shared by all: the heading of
the field in the workpiece frame, the field's dip, and each sensor's remaining
error against its calibration (the bar's bend, the calibration's own noise),
which every pass sees alike and which several passes and a survey therefore
reveal.  All have their standard deviations as priors, so that the covariance of
the curves counts the errors that are common to all passes, too.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.blocks import BlockMatrix, factorise
from georibbon.fitting.grid import (
    Grid,
    Shape,
    Turns,
    differentiate_frames,
    differentiate_positions,
    integrate_frames,
    integrate_positions,
)
from georibbon.fitting.sensing import Noise, Observations, SensorArray, whitening
from georibbon.fitting.shared import Layout, Shared, SharedSigmas
from georibbon.fitting.strip import (
    linear_cost,
    linear_weights,
    log_determinants,
    prior,
    robust_cost,
    robust_weights,
    roughness_cost,
    sensed_vectors,
)
from georibbon.fitting.survey import Measurement, Observation, Placed, Rows
from georibbon.rotations import skew
from georibbon.world import field_direction


@dataclass(frozen=True, eq=False)
class State:
    """All unknowns: p strips, their start points (p, 3) metres, and what is shared."""

    shape: Shape
    origin: FloatArray
    shared: Shared


@dataclass(frozen=True, eq=False)
class JointProblem:
    """All passes of a capture with their survey.

    smoothing: (p,).  survey: the observations.  anchors: (p, 3) metres, where
    the start points are expected, and anchor_sigma (p,) how surely: the gauge.
    expected: the shared unknowns' expected values.  firm: measurements that are
    missed grossly keep pulling (their cost is linear), so that a poor start
    comes home; otherwise they lose their pull, as a slip of the pen must.
    weights: (p,) or one for all; a pass's own cost, of its readings and its
    smoothing, counts so many times, as if it had been laid so often.
    """

    grid: Grid
    array: SensorArray
    observations: Observations
    noise: Noise
    smoothing: FloatArray
    survey: tuple[Observation, ...]
    anchors: FloatArray
    anchor_sigma: FloatArray
    expected: Shared
    sigmas: SharedSigmas
    firm: bool = False
    weights: FloatArray | float = 1.0

    @property
    def times(self) -> FloatArray:
        """(p,) how many times each pass counts."""
        return np.broadcast_to(self.weights, len(self.smoothing))


@dataclass(frozen=True, eq=False)
class Minimum:
    """A minimum of a joint problem; cost: to choose between minima by."""

    problem: JointProblem
    state: State
    cost: float


@dataclass(frozen=True, eq=False)
class Adjustment:
    """The minimum of the joint adjustment.

    cost: robust, with the log-determinants of the readings' covariance.
    covariance: for each pass (m + 3, m + 3), all that is shared counted in.
    squares: (p, n) each sensor's squared normalised residual.  white: (p, n,
    3, 3).  rows: the survey's observations at the minimum.
    """

    state: State
    placed: Placed
    cost: float
    covariance: list[FloatArray]
    residuals: FloatArray
    squares: FloatArray
    white: FloatArray
    rows: list[Rows]
    heading_sigma: float


@dataclass(frozen=True, eq=False)
class _Linear:
    """The linearised problem: normal matrix, gradient, cost, and the pieces for the report."""

    matrix: BlockMatrix
    gradient: list[FloatArray]
    cost: float
    residuals: FloatArray
    squares: FloatArray
    placed: Placed
    rows: list[Rows]


def _predict(
    problem: JointProblem, state: State, frames: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """World vectors (n, 3), directions (p, n, 3) in the ribbon's frame, residuals (p, n, 3)."""
    shared = state.shared
    vectors = sensed_vectors(problem.array, field_direction(shared.dip, shared.heading))
    at_sensors = frames[:, problem.grid.sensor_nodes]
    directions = (vectors[:, None, :] @ at_sensors)[:, :, 0]
    seen = directions + np.cross(directions, shared.tilt)
    predicted = (problem.array.gain @ seen[..., None])[..., 0] + shared.offset
    return vectors, directions, predicted - problem.observations.values


def whiten_all(problem: JointProblem, state: State) -> FloatArray:
    """(p, n, 3, 3) whitening matrices with the contact's noise as it acts at this state."""
    _, directions, _ = _predict(problem, state, integrate_frames(problem.grid, state.shape))
    return whitening(problem.array, problem.observations, problem.noise, directions)


def _sensor_residuals(
    problem: JointProblem, state: State, frames: FloatArray, white: FloatArray
) -> FloatArray:
    _, _, raw = _predict(problem, state, frames)
    return np.asarray((white @ raw[..., None])[..., 0])


def place(problem: JointProblem, state: State) -> Placed:
    """The curves with their derivatives."""
    turns = differentiate_frames(problem.grid, state.shape)
    return _place(problem, state, turns)


def _place(problem: JointProblem, state: State, turns: Turns) -> Placed:
    points, moves = differentiate_positions(problem.grid, state.shape, turns)
    return Placed(problem.grid, points + state.origin[:, None], turns.frames, moves, turns.delta)


def _sensor_rows(
    problem: JointProblem, state: State, turns: Turns, white: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Whitened residuals (p, n, 3), rows by strips (p, n, 3, m) and by what is shared (p, n, 3, 8).

    The shared columns are heading, dip, three of the sensor's tilt, three of its offset.
    """
    vectors, directions, raw = _predict(problem, state, turns.frames)
    residuals = (white @ raw[..., None])[..., 0]
    nodes = problem.grid.sensor_nodes
    back = np.swapaxes(turns.frames[:, nodes], -1, -2)
    gain = white @ problem.array.gain
    # seen = (I - [tilt]x) R^T u, so all derivatives by u pass through (I - [tilt]x)
    gain_tilted = gain - gain @ skew(state.shared.tilt)
    rows = (gain_tilted @ back @ skew(vectors)) @ turns.delta[:, nodes]
    heading, dip = state.shared.heading, state.shared.dip
    field = field_direction(dip, heading)
    by_heading = np.array([field[1], -field[0], 0.0])
    by_dip = np.array(
        [-np.sin(dip) * np.sin(heading), -np.sin(dip) * np.cos(heading), -np.cos(dip)]
    )
    changes = np.stack([by_heading, by_dip], axis=1) * problem.array.field[:, None, None]
    shared = np.zeros((*residuals.shape, 8))
    shared[..., :2] = gain_tilted @ back @ changes
    shared[..., 2:5] = gain @ skew(directions)
    shared[..., 5:] = white
    return residuals, rows, shared


def _linearise(problem: JointProblem, state: State, white: FloatArray, layout: Layout) -> _Linear:
    turns = differentiate_frames(problem.grid, state.shape)
    residuals, rows, shared = _sensor_rows(problem, state, turns, white)
    squares = np.sum(residuals**2, axis=-1)
    placed = _place(problem, state, turns)
    survey = [observation.rows(placed) for observation in problem.survey]
    p, m = len(rows), rows.shape[-1]
    matrix = BlockMatrix([m + 3] * p + [layout.size])
    gradient = [np.zeros(m + 3) for _ in range(p)] + [np.zeros(layout.size)]
    weights = robust_weights(squares) * problem.times[:, None]
    _add_sensors(matrix, gradient, residuals, rows, shared, weights, layout)
    _add_priors(matrix, gradient, problem, state, layout)
    for observation, part in zip(problem.survey, survey, strict=True):
        firm = problem.firm and isinstance(observation, Measurement)
        _add_rows(matrix, gradient, part, linear_weights if firm else robust_weights)
    cost = _readings_cost(problem, squares) + _survey_cost(problem, survey)
    cost += _prior_cost(problem, state, layout)
    return _Linear(matrix, gradient, cost, residuals, squares, placed, survey)


def _add_sensors(
    matrix: BlockMatrix,
    gradient: list[FloatArray],
    residuals: FloatArray,
    rows: FloatArray,
    shared: FloatArray,
    weights: FloatArray,
    layout: Layout,
) -> None:
    """Adds the readings' normal equations; each sensor touches only its own shared columns."""
    p, n, _, m = rows.shape
    root = np.sqrt(weights)[..., None]
    residuals, rows, shared = residuals * root, rows * root[..., None], shared * root[..., None]
    flat = rows.reshape(p, n * 3, m)
    own = np.swapaxes(flat, 1, 2) @ flat
    own_gradient = np.einsum("pki,pk->pi", flat, residuals.reshape(p, -1))
    cross = np.swapaxes(rows, 2, 3) @ shared
    common = np.einsum("pnka,pnkb->nab", shared, shared, optimize=True)
    common_gradient = np.einsum("pnka,pnk->na", shared, residuals, optimize=True)
    magnetic = layout.magnetometers
    last = matrix.blocks[p, p]
    for k in range(p):
        matrix.blocks[k, k][:m, :m] += own[k]
        gradient[k][:m] += own_gradient[k]
        side = np.zeros((layout.size, m + 3))
        side[:2, :m] = cross[k, :, :, :2].sum(axis=0).T
        side[layout.tilts, :m] = np.swapaxes(cross[k, :, :, 2:5], 1, 2).reshape(-1, m)
        side[layout.offsets, :m] = np.swapaxes(cross[k, magnetic, :, 5:], 1, 2).reshape(-1, m)
        matrix.add(p, k, side)
    layout.spread(last, gradient[p], common, common_gradient)


def _add_priors(
    matrix: BlockMatrix,
    gradient: list[FloatArray],
    problem: JointProblem,
    state: State,
    layout: Layout,
) -> None:
    p = len(state.origin)
    penalty = prior(problem.grid, problem.times * problem.smoothing)
    m = penalty.shape[1]
    rates = state.shape.rates.reshape(p, -1)
    for k in range(p):
        matrix.blocks[k, k][:m, :m] += penalty[k]
        gradient[k][3:m] += penalty[k, 3:, 3:] @ rates[k]
        weight = problem.anchor_sigma[k] ** -2
        matrix.blocks[k, k][m:, m:] += weight * np.eye(3)
        gradient[k][m:] += weight * (state.origin[k] - problem.anchors[k])
    precision = layout.precision(problem.sigmas)
    matrix.blocks[p, p][...] += precision
    gradient[p] += precision @ _shared_departure(problem, state, layout)


def _shared_departure(problem: JointProblem, state: State, layout: Layout) -> FloatArray:
    return layout.vector(state.shared) - layout.vector(problem.expected)


def _prior_cost(problem: JointProblem, state: State, layout: Layout) -> float:
    rough = roughness_cost(problem.grid, state.shape, problem.times * problem.smoothing)
    away = np.sum((state.origin - problem.anchors) ** 2, axis=1) / problem.anchor_sigma**2
    departure = _shared_departure(problem, state, layout)
    shared = departure @ layout.precision(problem.sigmas) @ departure
    return float(rough.sum() + away.sum() + shared)


def _readings_cost(problem: JointProblem, squares: FloatArray) -> float:
    return float((problem.times[:, None] * robust_cost(squares)).sum())


def _survey_cost(problem: JointProblem, rows: list[Rows]) -> float:
    return float(
        sum(
            (
                linear_cost(part.squares)
                if problem.firm and isinstance(observation, Measurement)
                else robust_cost(part.squares)
            ).sum()
            for observation, part in zip(problem.survey, rows, strict=True)
        )
    )


def _add_rows(
    matrix: BlockMatrix,
    gradient: list[FloatArray],
    rows: Rows,
    weigh: Callable[[FloatArray], FloatArray],
) -> None:
    """Adds the survey's equations, all observations of a pair of passes at once."""
    root = np.sqrt(weigh(rows.squares))[:, None]
    residuals, first = rows.residuals * root, rows.first * root[..., None]
    second = rows.second * root[..., None]
    pairs, group = np.unique(np.stack([rows.i, rows.j], axis=1), axis=0, return_inverse=True)
    group = group.ravel()
    for g, (i, j) in enumerate(pairs):
        members = group == g
        a = first[members].reshape(-1, first.shape[2])
        r = residuals[members].ravel()
        matrix.add(int(i), int(i), a.T @ a)
        gradient[i] += a.T @ r
        if i != j:
            b = second[members].reshape(-1, second.shape[2])
            matrix.add(int(j), int(j), b.T @ b)
            matrix.add(int(i), int(j), a.T @ b)
            gradient[j] += b.T @ r


def _moved(state: State, step: list[FloatArray], layout: Layout) -> State:
    passes = np.array(step[:-1])
    return State(
        state.shape.moved(passes[:, :-3]),
        state.origin + passes[:, -3:],
        layout.step(state.shared, step[-1]),
    )


def _cost(problem: JointProblem, state: State, white: FloatArray, layout: Layout) -> float:
    """The cost alone, without derivatives by the unknowns."""
    frames = integrate_frames(problem.grid, state.shape)
    points = integrate_positions(problem.grid, state.shape, frames) + state.origin[:, None]
    empty = np.zeros((*points.shape, 0))
    placed = Placed(problem.grid, points, frames, empty, empty)
    rows = [observation.rows(placed) for observation in problem.survey]
    squares = np.sum(_sensor_residuals(problem, state, frames, white) ** 2, axis=-1)
    cost = _readings_cost(problem, squares) + _survey_cost(problem, rows)
    return cost + _prior_cost(problem, state, layout)


def descend(
    problem: JointProblem, state: State, iterations: int = 25, tolerance: float = 1e-2
) -> State:
    """Levenberg-damped Gauss-Newton on everything at once, with the noise as at the start."""
    layout = Layout(problem.array)
    white = whiten_all(problem, state)
    damping = 1e-6
    for _ in range(iterations):
        linear = _linearise(problem, state, white, layout)
        while True:
            step = factorise(linear.matrix.damped(damping)).solve([-g for g in linear.gradient])
            gain = -sum(float(g @ x) for g, x in zip(linear.gradient, step, strict=True))
            there = _moved(state, step, layout)
            if gain < tolerance or _cost(problem, there, white, layout) <= linear.cost:
                break
            damping = max(damping, 1e-6) * 10
            if damping > 1e6:
                return state
        state = there
        damping *= 0.1
        if gain < tolerance:
            break
    return state


def cost_of(problem: JointProblem, state: State) -> float:
    """The cost at a state with the noise as it acts there, to choose between minima by.

    A measurement that is missed grossly counts linearly here: while a minimum is
    sought it must lose its pull, but the minimum that misses it is the less likely.
    """
    white = whiten_all(problem, state)
    cost = _cost(replace(problem, firm=True), state, white, Layout(problem.array))
    return cost + _volume_cost(problem, white)


def _volume_cost(problem: JointProblem, white: FloatArray) -> float:
    return float((problem.times * log_determinants(white)).sum())


def evaluate(problem: JointProblem, state: State) -> Adjustment:
    """The adjustment at its minimum, with the covariance of every pass."""
    layout = Layout(problem.array)
    white = whiten_all(problem, state)
    linear = _linearise(problem, state, white, layout)
    covariance = factorise(linear.matrix).covariance()
    p = len(state.origin)
    return Adjustment(
        state=state,
        placed=linear.placed,
        cost=linear.cost + _volume_cost(problem, white),
        covariance=[covariance[k, k] for k in range(p)],
        residuals=linear.residuals,
        squares=linear.squares,
        white=white,
        rows=linear.rows,
        heading_sigma=float(np.sqrt(covariance[p, p][0, 0])),
    )


def information(problem: JointProblem, state: State) -> tuple[BlockMatrix, Placed]:
    """The normal matrix of everything at a state, and the curves there with their derivatives.

    Blocks: each pass's strip and start point, in their order, then what is
    shared.  The inverse is the covariance of all unknowns together.
    """
    linear = _linearise(problem, state, whiten_all(problem, state), Layout(problem.array))
    return linear.matrix, linear.placed


def equations(problem: JointProblem, state: State) -> tuple[BlockMatrix, list[FloatArray]]:
    """The normal matrix and the gradient at a state, in the blocks of `information`."""
    linear = _linearise(problem, state, whiten_all(problem, state), Layout(problem.array))
    return linear.matrix, linear.gradient


def moved(problem: JointProblem, state: State, step: list[FloatArray]) -> State:
    """The state after a step of all unknowns, in the blocks of `information`."""
    return _moved(state, step, Layout(problem.array))


def residuals_at(problem: JointProblem, state: State, frames: FloatArray) -> FloatArray:
    """(p, n, 3) normalised residuals of the readings; frames: (p, nodes, 3, 3) of the state."""
    _, directions, raw = _predict(problem, state, frames)
    white = whitening(problem.array, problem.observations, problem.noise, directions)
    return np.asarray((white @ raw[..., None])[..., 0])


def with_survey(problem: JointProblem, *more: Observation) -> JointProblem:
    """The problem with more observations."""
    return replace(problem, survey=(*problem.survey, *more))
