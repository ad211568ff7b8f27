"""The ribbon fit of single passes: orientations and rates from the readings themselves.

Minimises, over R(0) and the spline coefficients of twist and bending,

    sum over sensors rho(|W (G R^T u - y)|²) + smoothing * integral(twist''² + bending''²) ds

by Gauss-Newton with Levenberg damping, for a stack of passes at once.  rho is
quadratic up to the robust limit and logarithmic beyond it, so that a sensor
that disagrees loses its say but never its name.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.grid import Grid, Shape, Turns, differentiate_frames, integrate_frames
from georibbon.fitting.sensing import Noise, Observations, SensorArray, whitening
from georibbon.rotations import skew
from georibbon.world import UP

# A sensor counts fully up to this many standard deviations (3 % of good three-axis sensors exceed
# it); beyond, its weight falls with the square, so that its pull falls too.
ROBUST_LIMIT = 3.0


@dataclass(frozen=True, eq=False)
class Strips:
    """A stack of b fitted strips.

    shape: their unknowns.  cost: (b,) the minimum, the log-determinant of the
    readings' covariance included so that costs of different minima compare.
    normal: (b, m, m) J^T W J + prior at the minimum.  squares: (b, n) each
    sensor's squared normalised residual.  smoothing: (b,).
    """

    shape: Shape
    cost: FloatArray
    normal: FloatArray
    squares: FloatArray
    smoothing: FloatArray

    def take(self, index: IntArray | list[int]) -> "Strips":
        """The strips of the given places in the stack."""
        return Strips(
            self.shape.take(index),
            self.cost[index],
            self.normal[index],
            self.squares[index],
            self.smoothing[index],
        )


@dataclass(frozen=True, eq=False)
class StripProblem:
    """What is known of b passes: grid, sensors, readings, field and the noise model.

    vectors: (n, 3) for each sensor the world's unit vector that it measures.
    """

    grid: Grid
    array: SensorArray
    observations: Observations
    vectors: FloatArray
    noise: Noise

    def take(self, index: IntArray | list[int]) -> "StripProblem":
        """The problem of the given passes alone."""
        observations = self.observations.take(index)
        return StripProblem(self.grid, self.array, observations, self.vectors, self.noise)


def sensed_vectors(array: SensorArray, field: FloatArray) -> FloatArray:
    """(n, 3) up for accelerometers, the field for magnetometers."""
    return np.where(array.field[:, None], field, UP)


def prior(grid: Grid, smoothing: FloatArray) -> FloatArray:
    """(b, m, m) the smoothing as a quadratic form in the unknowns."""
    k = grid.coefficients
    out = np.zeros((len(smoothing), grid.unknowns, grid.unknowns))
    out[:, 3 : 3 + k, 3 : 3 + k] = smoothing[:, None, None] * grid.roughness
    out[:, 3 + k :, 3 + k :] = out[:, 3 : 3 + k, 3 : 3 + k]
    return out


def predict(problem: StripProblem, frames: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Vectors in the ribbon's frame at the sensors and residuals G u - y, (b, n, 3) each."""
    at_sensors = frames[:, problem.grid.sensor_nodes]
    directions = (problem.vectors[:, None, :] @ at_sensors)[:, :, 0]
    predicted = (problem.array.gain @ directions[..., None])[..., 0]
    return directions, predicted - problem.observations.values


def whiten(problem: StripProblem, shape: Shape) -> FloatArray:
    """The whitening matrices with the contact's noise as it acts at these frames."""
    directions, _ = predict(problem, integrate_frames(problem.grid, shape))
    return whitening(problem.array, problem.observations, problem.noise, directions)


def whitened_residuals(problem: StripProblem, frames: FloatArray) -> FloatArray:
    """(b, n, 3) normalised residuals at given frames (b, nodes, 3, 3)."""
    directions, residuals = predict(problem, frames)
    white = whitening(problem.array, problem.observations, problem.noise, directions)
    return np.asarray((white @ residuals[..., None])[..., 0])


def robust_cost(squares: FloatArray) -> FloatArray:
    """rho: the square up to the limit, limit² (1 + log(square / limit²)) beyond it."""
    limit = ROBUST_LIMIT**2
    return np.where(
        squares <= limit, squares, limit * (1 + np.log(np.maximum(squares, limit) / limit))
    )


def linear_cost(squares: FloatArray) -> FloatArray:
    """The square up to the limit, and linear in its root beyond it (Huber)."""
    root = np.sqrt(squares)
    return np.where(root <= ROBUST_LIMIT, squares, ROBUST_LIMIT * (2 * root - ROBUST_LIMIT))


def linear_weights(squares: FloatArray) -> FloatArray:
    """The linear cost's derivative by the square: 1 up to the limit, limit / root beyond it."""
    return ROBUST_LIMIT / np.sqrt(np.maximum(squares, ROBUST_LIMIT**2))


def robust_weights(squares: FloatArray) -> FloatArray:
    """rho's derivative by the square: 1 up to the limit, limit² / square beyond it."""
    limit = ROBUST_LIMIT**2
    return limit / np.maximum(squares, limit)


def squared_residuals(problem: StripProblem, frames: FloatArray, white: FloatArray) -> FloatArray:
    """(b, n) squared normalised residuals."""
    _, residuals = predict(problem, frames)
    return np.asarray(np.sum((white @ residuals[..., None])[..., 0] ** 2, axis=-1))


def roughness_cost(grid: Grid, shape: Shape, smoothing: FloatArray) -> FloatArray:
    """(b,) the smoothing's share of the cost."""
    rough = np.einsum("bck,kl,bcl->b", shape.rates, grid.roughness, shape.rates)
    return np.asarray(smoothing * rough)


def log_determinants(white: FloatArray) -> FloatArray:
    """(b,) the log-determinant of the covariance of all present readings."""
    diagonal = np.abs(np.diagonal(white, axis1=-2, axis2=-1))
    logs = np.log(np.where(diagonal > 0, diagonal, 1.0))
    return np.asarray(-2.0 * logs.sum(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class Linearised:
    """Residuals and derivatives of the readings at one shape of each strip.

    turns: the frames and their derivatives.  residuals: (b, n, 3) whitened.
    rows: (b, n, 3, m) their derivatives by the unknowns.  squares: (b, n).
    """

    turns: Turns
    residuals: FloatArray
    rows: FloatArray
    squares: FloatArray


def linearise(problem: StripProblem, shape: Shape, white: FloatArray) -> Linearised:
    """Readings and exact derivatives: d(R^T u) = R^T [u]x delta for a turn delta in the world."""
    turns = differentiate_frames(problem.grid, shape)
    _, raw = predict(problem, turns.frames)
    residuals = (white @ raw[..., None])[..., 0]
    nodes = problem.grid.sensor_nodes
    inward = np.swapaxes(turns.frames[:, nodes], -1, -2) @ skew(problem.vectors)
    rows = (white @ problem.array.gain @ inward) @ turns.delta[:, nodes]
    return Linearised(turns, residuals, rows, np.sum(residuals**2, axis=-1))


def normal_equations(linear: Linearised, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """J^T W J (b, m, m) and J^T W r (b, m), with a weight (b, n) for each sensor."""
    b, m = len(weights), linear.rows.shape[-1]
    root = np.sqrt(weights)[..., None]
    rows = (root[..., None] * linear.rows).reshape(b, -1, m)
    residuals = (root * linear.residuals).reshape(b, -1, 1)
    transposed = np.swapaxes(rows, 1, 2)
    return transposed @ rows, (transposed @ residuals)[..., 0]


def fit_strips(
    problem: StripProblem, start: Shape, smoothing: FloatArray, iterations: int = 30
) -> Strips:
    """Fits b passes from b starts.

    smoothing: (b,) the weight of the integral.  The whitening is brought up to
    date once the first minimum is near, and the fit continued there.
    """
    white = whiten(problem, start)
    shape = _descend(problem, start, smoothing, white, iterations, tolerance=1e-1)
    white = whiten(problem, shape)
    shape = _descend(problem, shape, smoothing, white, iterations, tolerance=1e-4)
    return evaluate(problem, shape, smoothing, white)


def follow_shape(
    problem: StripProblem, start: Shape, smoothing: FloatArray, iterations: int
) -> Shape:
    """The minimum that shapes nearby lead to, in less than half the time of a fit.

    The whitening is that of the start, and the last step is not checked.
    """
    white = whiten(problem, start)
    return _descend(problem, start, smoothing, white, iterations, tolerance=1e-1)


def evaluate(
    problem: StripProblem, shape: Shape, smoothing: FloatArray, white: FloatArray
) -> Strips:
    """The strips at given shapes: costs, normal matrices, residuals."""
    return summarise(problem, shape, smoothing, white, linearise(problem, shape, white))


def summarise(
    problem: StripProblem,
    shape: Shape,
    smoothing: FloatArray,
    white: FloatArray,
    linear: Linearised,
) -> Strips:
    """The strips at given shapes, where they are linearised already."""
    normal, _ = normal_equations(linear, robust_weights(linear.squares))
    cost = robust_cost(linear.squares).sum(axis=1) + roughness_cost(problem.grid, shape, smoothing)
    return Strips(
        shape,
        cost + log_determinants(white),
        normal + prior(problem.grid, smoothing),
        linear.squares,
        smoothing,
    )


def _descend(
    problem: StripProblem,
    start: Shape,
    smoothing: FloatArray,
    white: FloatArray,
    iterations: int,
    tolerance: float,
) -> Shape:
    """Levenberg-damped Gauss-Newton; each strip stops when its predicted gain is small."""
    start_frames, rates = start.start.copy(), start.rates.copy()
    active = np.arange(len(smoothing))
    damping = np.full(len(smoothing), 1e-4)
    penalty = prior(problem.grid, smoothing)
    for _ in range(iterations):
        part, here = problem.take(active), Shape(start_frames[active], rates[active])
        linear = linearise(part, here, white[active])
        normal, gradient = normal_equations(linear, robust_weights(linear.squares))
        normal += penalty[active]
        gradient[:, 3:] += np.einsum(
            "bij,bj->bi", penalty[active][:, 3:, 3:], here.rates.reshape(len(active), -1)
        )
        step, gain = _damped_step(normal, gradient, damping[active])
        there = here.moved(step)
        frames = integrate_frames(problem.grid, there)
        before = robust_cost(linear.squares).sum(axis=1) + roughness_cost(
            problem.grid, here, smoothing[active]
        )
        squares = squared_residuals(part, frames, white[active])
        after = robust_cost(squares).sum(axis=1) + roughness_cost(
            problem.grid, there, smoothing[active]
        )
        better = after <= before + 1e-9
        start_frames[active[better]] = there.start[better]
        rates[active[better]] = there.rates[better]
        damping[active] = np.where(better, damping[active] * 0.1, damping[active] * 10)
        done = (gain < tolerance) | (~better & (damping[active] > 1e3))
        active = active[~done]
        if len(active) == 0:
            break
    return Shape(start_frames, rates)


def _damped_step(
    normal: FloatArray, gradient: FloatArray, damping: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The step -(H + damping diag H)^-1 g and the gain that the linear model predicts for it."""
    diagonal = np.diagonal(normal, axis1=1, axis2=2)
    damped = normal + (damping[:, None] * diagonal)[..., None] * np.eye(normal.shape[1])
    step = -np.linalg.solve(damped, gradient[..., None])[..., 0]
    return np.asarray(step, dtype=np.float64), -np.sum(gradient * step, axis=1)
