"""How smooth a strip is: chosen by the evidence, told as a length.

The weight l of the roughness integral is the inverse variance of a random walk
of the rates' slopes.  Its evidence (Laplace's approximation) is

    cost(l) + log det(H(l)) - rank log(l),       H = J^T W J + l P,

to be minimised.  For people it is a length: a cubic-spline-like filter whose
penalty is the third derivative of the orientation passes half of a wave of
length c where l = density (c / 2 pi)^6, density being the readings'
information on the orientation per metre.
"""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.grid import Grid
from georibbon.fitting.strip import (
    StripProblem,
    Strips,
    linearise,
    normal_equations,
    prior,
    robust_weights,
    whiten,
)

_TRIED = 24


def information_density(problem: StripProblem) -> float:
    """The readings' information on the orientation, 1/(rad² m), mean over the three axes.

    An accelerometer tells two rotations, a 3-axis magnetometer two, a 2-axis
    one four thirds on average.
    """
    array, noise = problem.array, problem.noise
    told = np.where(array.axes.sum(axis=1) == 2, 4 / 3, 2.0)
    floor = np.where(array.field, noise.field, noise.acceleration)
    total = np.sum((told / (noise.contact**2 + floor**2))[array.used])
    return float(total / (3 * problem.grid.nodes[-1]))


def weight_of_length(length: FloatArray | float, density: float) -> FloatArray:
    """The roughness weight for a length in metres."""
    return np.asarray(density * (np.asarray(length) / (2 * np.pi)) ** 6)


def length_of_weight(weight: FloatArray | float, density: float) -> FloatArray:
    """The length in metres for a roughness weight."""
    return np.asarray(2 * np.pi * (np.asarray(weight) / density) ** (1 / 6))


def length_range(grid: Grid) -> tuple[float, float]:
    """The lengths that mean something: from a spline interval to the whole ribbon."""
    length = float(grid.nodes[-1])
    return length / (grid.coefficients - 3), length


def best_lengths(problem: StripProblem, strips: Strips) -> FloatArray:
    """(b,) lengths of greatest evidence, metres, the readings linearised at the given strips."""
    density = information_density(problem)
    low, high = length_range(problem.grid)
    lengths = np.geomspace(low, high, _TRIED)
    evidence = _evidence(problem, strips, weight_of_length(lengths, density))
    return np.array([_minimum(np.log(lengths), row) for row in evidence])


def _evidence(problem: StripProblem, strips: Strips, weights: FloatArray) -> FloatArray:
    """(b, k) minus twice the log evidence, up to a constant, for each weight (k,)."""
    linear = linearise(problem, strips.shape, whiten(problem, strips.shape))
    normal, gradient = normal_equations(linear, robust_weights(linear.squares))
    penalty = prior(problem.grid, np.ones(1))[0]
    b, m = gradient.shape
    here = np.zeros((b, m))
    here[:, 3:] = strips.shape.rates.reshape(b, -1)
    pulled = here @ penalty
    hessian = normal[:, None] + weights[:, None, None] * penalty
    slope = gradient[:, None] + weights[:, None] * pulled[:, None]
    step = np.linalg.solve(hessian, slope[..., None])[..., 0]
    cost = weights * np.sum(here * pulled, axis=1)[:, None] - np.sum(slope * step, axis=-1)
    rank = 2 * (problem.grid.coefficients - 2)
    return np.asarray(cost + np.linalg.slogdet(hessian)[1] - rank * np.log(weights))


def _minimum(log_lengths: FloatArray, values: FloatArray) -> float:
    """The place of the least value, by a parabola through it and its neighbours."""
    k = int(np.argmin(values))
    if k in (0, len(values) - 1):
        return float(np.exp(log_lengths[k]))
    before, at, after = values[k - 1 : k + 2]
    curvature = before - 2 * at + after
    shift = 0.5 * (before - after) / curvature if curvature > 0 else 0.0
    return float(np.exp(log_lengths[k] + shift * (log_lengths[1] - log_lengths[0])))
