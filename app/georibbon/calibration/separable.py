"""Adjustment of readings that are linear in a direction which all sensors share.

Sensor n reads, in pose p, y_np = K_n d_p + c_n with d_p(q) a direction that is
the same for every sensor, q the few unknowns of the poses.  The sensors' own
unknowns are linear and are eliminated: for a given q they follow from n small
normal matrices, and Gauss-Newton runs on q alone with their Schur complement
(variable projection; Golub and Pereyra 1973; Kaufman 1975).

Every (sensor, pose) cell carries one weight, Geman and McClure's (1987), so
that a disturbed pose, sensor or cell does not pull the rest.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray

STEPS = 60
ROUGH = 1e-4
CONVERGED = 1e-10
# Damping of Gauss-Newton in units of the mean diagonal: only against the exactly
# undetermined directions (a rotation common to all), far below what is determined.
DAMPING = 1e-9


@dataclass(frozen=True, eq=False)
class Prior:
    """Where the sensors' unknowns are held, and how loosely.

    theta: (n, 3, 4) gains and biases [K | c]; precision: (4,) of each column in
    units of one reading's.
    """

    theta: FloatArray
    precision: FloatArray


@dataclass(frozen=True, eq=False)
class Directions:
    """Where the shared directions stand and how they move: d (p, 3), jacobian (p, 3, m)."""

    d: FloatArray
    jacobian: FloatArray


@dataclass(frozen=True, eq=False)
class Normals:
    """The normal matrices at a solution, in units of one reading's precision.

    sensors: (n, 4, 4), one for each sensor and the same for its three axes;
    coupling: (n, 4, 3, m) between them and the poses' unknowns; reduced: (m, m).
    """

    sensors: FloatArray
    coupling: FloatArray
    reduced: FloatArray


@dataclass(frozen=True, eq=False)
class Adjusted:
    """A solution: q, theta (n, 3, 4), residuals (n, p, 3), weights (n, p), cost, normals."""

    q: FloatArray
    theta: FloatArray
    residuals: FloatArray
    weights: FloatArray
    cost: float
    normals: Normals


@dataclass(frozen=True, eq=False)
class Tie:
    """What is known of the shared directions besides the readings.

    information: (3 p, 3 p) in units of one reading's precision, on their
    offsets from target: (p, 3).
    """

    information: FloatArray
    target: FloatArray

    def cost(self, d: FloatArray) -> float:
        """The share of the directions d (p, 3) in the cost."""
        offset = (d - self.target).ravel()
        return float(offset @ self.information @ offset)


@dataclass(frozen=True, eq=False)
class Problem:
    """Readings (n, p, 3), which cells count (n, p), axes of each sensor (n,), and the model.

    directions(q) gives the shared directions, move(q, step) the unknowns moved.
    floor: the least scale of a cell's residual for the robust weights.
    """

    values: FloatArray
    valid: FloatArray
    axes: FloatArray
    prior: Prior
    directions: Callable[[FloatArray], Directions]
    move: Callable[[FloatArray, FloatArray], FloatArray]
    floor: float
    tie: Tie | None = None


def design(d: FloatArray) -> FloatArray:
    """(..., p, 4) rows [d, 1] of the linear part."""
    return np.concatenate([d, np.ones((*d.shape[:-1], 1))], axis=-1)


def sensor_normals(d: FloatArray, weights: FloatArray, precision: FloatArray) -> FloatArray:
    """(..., n, 4, 4) normal matrices of the sensors' unknowns, their prior included."""
    rows = design(d)[..., None, :, :]
    return np.asarray((rows * weights[:, :, None]).mT @ rows + np.diag(precision))


def linear_fit(
    values: FloatArray, d: FloatArray, weights: FloatArray, prior: Prior
) -> tuple[FloatArray, FloatArray]:
    """The sensors' unknowns for given directions.

    d: (..., p, 3), any number of trials at once; values: (n, p, 3); weights:
    (n, p).  Returns theta (..., n, 3, 4) and residuals (..., n, p, 3).
    """
    rows = design(d)[..., None, :, :]
    normal = sensor_normals(d, weights, prior.precision)
    right = rows.mT @ (weights[:, :, None] * values)
    right = right + prior.precision[:, None] * prior.theta.mT
    theta = np.linalg.solve(normal, right).mT
    return np.asarray(theta), np.asarray(values - rows @ theta.mT)


def cell_residuals(residuals: FloatArray, axes: FloatArray) -> FloatArray:
    """(..., n, p) root mean square residual of each cell over the axes that it has."""
    return np.asarray(np.sqrt((residuals**2).sum(axis=-1) / axes[:, None]))


def median_of(cells: FloatArray, valid: FloatArray, axis: int) -> FloatArray:
    """The median along an axis of the cells that count, 0 where none does."""
    shown = np.where(valid > 0.0, cells, np.nan)
    empty = np.isnan(shown).all(axis=axis, keepdims=True)
    return np.asarray(np.nanmedian(np.where(empty, 0.0, shown), axis=axis))


def robust_scale(cells: FloatArray, valid: FloatArray, floor: float) -> float:
    """Three times the median cell residual, and no less than three times the floor."""
    used = cells[valid > 0.0]
    return 3.0 * max(float(np.median(used)) if used.size else 0.0, floor)


def robust_weights(cells: FloatArray, valid: FloatArray, floor: float) -> FloatArray:
    """(n, p) Geman-McClure weights 1 / (1 + (e / scale)^2)^2; 0 where a cell does not count."""
    scale = robust_scale(cells, valid, floor)
    return valid / (1.0 + (cells / scale) ** 2) ** 2


def normals(
    theta: FloatArray, at: Directions, weights: FloatArray, prior: Prior, tie: Tie | None = None
) -> Normals:
    """The normal matrices with the sensors' unknowns eliminated (Schur complement)."""
    root = np.sqrt(weights)
    moved = np.einsum("nkc,pcm->npkm", theta[:, :, :3], at.jacobian) * root[:, :, None, None]
    n, p, _, m = moved.shape
    rows = design(at.d) * root[:, :, None]
    coupling = rows.mT @ moved.reshape(n, p, 3 * m)
    sensors = sensor_normals(at.d, weights, prior.precision)
    white = np.linalg.solve(np.linalg.cholesky(sensors), coupling).reshape(n * 4 * 3, m)
    flat = moved.reshape(n * p * 3, m)
    reduced = flat.T @ flat - white.T @ white
    if tie is not None:
        moves = at.jacobian.reshape(3 * p, m)
        reduced = reduced + moves.T @ tie.information @ moves
    return Normals(sensors, coupling.reshape(n, 4, 3, m), reduced)


def _step(problem: Problem, now: Adjusted, at: Directions, prior: Prior) -> FloatArray:
    """The Gauss-Newton step of q for the weights as they are."""
    matrix = normals(now.theta, at, now.weights, prior, problem.tie).reduced
    pull = np.einsum("nkc,np,npk->pc", now.theta[:, :, :3], now.weights, now.residuals)
    if problem.tie is not None:
        offset = (at.d - problem.tie.target).ravel()
        pull = pull - (problem.tie.information @ offset).reshape(pull.shape)
    gradient = np.einsum("pc,pcm->m", pull, at.jacobian)
    damping = DAMPING * max(float(np.trace(matrix)) / len(gradient), 1e-30)
    return np.linalg.solve(matrix + damping * np.eye(len(gradient)), gradient)


def _at(problem: Problem, q: FloatArray, weights: FloatArray, prior: Prior) -> Adjusted:
    """The solution's state at q: sensors solved for, weighted cost with the prior's share."""
    d = problem.directions(q).d
    theta, residuals = linear_fit(problem.values, d, weights, prior)
    pulled = ((theta - prior.theta) ** 2 * prior.precision).sum()
    pulled = pulled + (problem.tie.cost(d) if problem.tie is not None else 0.0)
    cost = float((weights[:, :, None] * residuals**2).sum() + pulled)
    return Adjusted(q, theta, residuals, weights, cost, _NO_NORMALS)


_NO_NORMALS = Normals(np.empty((0, 4, 4)), np.empty((0, 4, 3, 0)), np.empty((0, 0)))


def adjust(problem: Problem, q: FloatArray, *, rough: bool = False) -> Adjusted:
    """Gauss-Newton on the poses' unknowns from `q`, the sensors eliminated.

    rough: the sensors are pulled towards their prior, which keeps a bad start
    from running away, and a tenth of a milliradian is enough.  Otherwise the
    prior follows the solution, so that it damps and does not bias.
    """
    prior = problem.prior
    now = _at(problem, q, problem.valid, prior)
    for _ in range(STEPS):
        cells = cell_residuals(now.residuals, problem.axes)
        weights = robust_weights(cells, problem.valid, problem.floor)
        if not rough:
            prior = replace(prior, theta=now.theta)
        now = _at(problem, now.q, weights, prior)
        at = problem.directions(now.q)
        now, size = _descend(problem, now, _step(problem, now, at, prior), prior)
        if size < (ROUGH if rough else CONVERGED):
            break
    found = normals(now.theta, problem.directions(now.q), now.weights, problem.prior, problem.tie)
    return replace(now, normals=found)


def _descend(
    problem: Problem, now: Adjusted, step: FloatArray, prior: Prior
) -> tuple[Adjusted, float]:
    """The step taken, halved while it makes the cost worse, and its size."""
    for _ in range(8):
        moved = _at(problem, problem.move(now.q, step), now.weights, prior)
        if moved.cost <= now.cost * (1.0 + 1e-9) + 1e-24:
            return moved, float(np.abs(step).max())
        step = 0.5 * step
    return now, 0.0
