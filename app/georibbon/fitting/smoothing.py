"""How smooth a strip is: chosen by the evidence, told as a length.

The weight l of the roughness integral is the inverse variance of a random walk
of the rates' slopes.  Its evidence (Laplace's approximation) is

    cost(l) + log det(H(l)) - rank log(l),       H = J^T W J + l P,

to be minimised.  For people it is a length: a cubic-spline-like filter whose
penalty is the third derivative of the orientation passes half of a wave of
length c where l = density (c / 2 pi)^6, density being the readings'
information on the orientation per metre.
"""

from dataclasses import replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.grid import Grid
from georibbon.fitting.strip import (
    StripProblem,
    Strips,
    linearise,
    log_determinants,
    normal_equations,
    prior,
    robust_cost,
    robust_weights,
    whiten,
)

_TRIED = 24
MOST_FACTOR = 6.0  # times the usual: how great the contact's noise may be
_FACTORS_TRIED = 9
_FACTOR_SPREAD = 0.5
_ODD = 4.0  # times the median residual of a pass


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
    lengths = np.geomspace(*length_range(problem.grid), _TRIED)
    tried = evidence(problem, strips, weight_of_length(lengths, density))
    return np.array([np.exp(_minimum(np.log(lengths), row)) for row in tried])


def best_contact(problem: StripProblem, strips: Strips) -> float:
    """The contact's noise, radians, of greatest evidence over all b strips together.

    For each noise that is tried every strip takes the smoothing that suits it
    best, so that roughness is not mistaken for noise.  A weak prior (a factor
    of 1.65, one standard deviation) keeps few readings from telling much, and a
    noise less than usual is not believed: there are errors that fit well.
    """
    factors = np.geomspace(1.0, MOST_FACTOR, _FACTORS_TRIED)
    lengths = np.geomspace(*length_range(problem.grid), _TRIED)
    costs = (np.log(factors) / _FACTOR_SPREAD) ** 2
    problem = _without_odd_sensors(problem, strips)
    for k, factor in enumerate(factors):
        noise = replace(problem.noise, contact=factor * problem.noise.contact)
        scaled = replace(problem, noise=noise)
        weights = weight_of_length(lengths, information_density(scaled))
        costs[k] += evidence(scaled, strips, weights).min(axis=1).sum()
    return problem.noise.contact * float(np.exp(_minimum(np.log(factors), costs)))


def _without_odd_sensors(problem: StripProblem, strips: Strips) -> StripProblem:
    """The problem without sensors far worse than most of their pass: that is no contact's noise."""
    size, present = np.sqrt(strips.squares), problem.observations.present
    usual = np.array([np.median(row[there]) for row, there in zip(size, present, strict=True)])
    kept = present & (size <= _ODD * np.maximum(usual, 1.0)[:, None])
    return replace(problem, observations=replace(problem.observations, present=kept))


def evidence(problem: StripProblem, strips: Strips, weights: FloatArray) -> FloatArray:
    """(b, k) minus twice the log evidence, up to a constant, for each weight (k,)."""
    white = whiten(problem, strips.shape)
    linear = linearise(problem, strips.shape, white)
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
    readings = robust_cost(linear.squares).sum(axis=1) + log_determinants(white)
    total = readings[:, None] + cost + np.linalg.slogdet(hessian)[1] - rank * np.log(weights)
    return np.asarray(total)


def _minimum(places: FloatArray, values: FloatArray) -> float:
    """The place of the least value among evenly spaced ones, by a parabola about it."""
    k = int(np.argmin(values))
    if k in (0, len(values) - 1):
        return float(places[k])
    before, at, after = values[k - 1 : k + 2]
    curvature = before - 2 * at + after
    shift = 0.5 * (before - after) / curvature if curvature > 0 else 0.0
    return float(places[k] + shift * (places[1] - places[0]))
