"""Sensors whose reading is not what their neighbours lead to expect: a magnet, iron, a knock.

A fit follows every reading a little, so its residual alone shows a disturbance
too small.  Each sensor is therefore compared with what the fit would say
without it and without its neighbours of the same kind on both sides, which a
magnet reaches as well (deleted residuals; Belsley, Kuh and Welsch 1980).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.strip import Linearised, StripProblem, robust_weights
from georibbon.ribbon import Ribbon

Grade = Literal["suspect", "bad"]

# Share of g or of the local field, and degrees, from which on a sensor is suspect or bad.
SUSPECT_SHARE, BAD_SHARE = 0.04, 0.10
SUSPECT_DEGREES, BAD_DEGREES = 4.0, 10.0
# Standard deviations, what is expected being uncertain as well.
SIGNIFICANT = 4.0
LEAST_SEEN = 0.2  # of the vector in the sensor's plane, for its direction to mean something
LEAST_MATES = 6  # sensors of a kind, for its neighbours to be left out as well


@dataclass(frozen=True)
class Disturbed:
    """A sensor that does not agree, how badly, and why.

    share: of g or of the local field, by which its reading is too long or too
    short.  degrees: by which it points elsewhere; 0 where that means nothing.
    """

    sensor: str
    grade: Grade
    reason: str
    share: float
    degrees: float


@dataclass(frozen=True, eq=False)
class Expected:
    """What n sensors should say by the fit without them and their neighbours.

    deleted: (n, 3) expected less read, in units.  size: (n,) the same in
    standard deviations, of reading and expectation together; 0 where the
    sensor says nothing.
    """

    deleted: FloatArray
    size: FloatArray


def expected_without(
    problem: StripProblem, linear: Linearised, normal: FloatArray, white: FloatArray
) -> Expected:
    """What every sensor of one pass (b = 1) should say, by the linearised fit without it.

    There are sensors of both kinds that say something.

    With the whitened residuals r and rows J of a group, its weights w and A =
    J normal^-1 J^T: the residual without the group is (I - A w)^-1 r, and its
    covariance I + A (I - w A)^-1.  normal: (1, m, m).  white: (1, n, 3, 3).
    """
    n = len(problem.array.field)
    deleted, size = np.zeros((n, 3)), np.zeros(n)
    inverse = np.linalg.inv(normal[0])
    for field in (False, True):
        mates = np.flatnonzero((problem.array.field == field) & problem.observations.present[0])
        mates = mates[np.argsort(problem.grid.sensor_nodes[mates], kind="stable")]
        found, spread = _without(linear, inverse, mates)
        deleted[mates] = np.linalg.solve(white[0, mates], found[..., None])[..., 0]
        squares = np.sum(found * np.linalg.solve(spread, found[..., None])[..., 0], axis=-1)
        # Where the group alone decides something its covariance is huge, and rounding shows.
        size[mates] = np.sqrt(np.maximum(squares, 0.0))
    return Expected(deleted, size)


def _without(
    linear: Linearised, inverse: FloatArray, mates: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Whitened deleted residuals (k, 3) of sensors in a row, and their covariances (k, 3, 3)."""
    k, m = len(mates), len(inverse)
    reach = 1 if k >= LEAST_MATES else 0
    offsets = np.array([0, *range(-reach, 0), *range(1, reach + 1)])
    places = np.arange(k)[:, None] + offsets
    there = (places >= 0) & (places < k)
    group = mates[np.clip(places, 0, k - 1)]
    rows = (linear.rows[0, group] * there[..., None, None]).reshape(k, -1, m)
    residuals = (linear.residuals[0, group] * there[..., None]).reshape(k, -1, 1)
    weights = np.repeat(robust_weights(linear.squares[0, group]), 3, axis=1)
    shared = rows @ inverse @ np.swapaxes(rows, 1, 2)
    # Hardly more than the identity where the group alone decides something: then nothing is
    # expected of it, and its covariance is huge.
    loop = (1.0 + 1e-9) * np.eye(rows.shape[1]) - shared * weights[:, None, :]
    gain = np.linalg.inv(loop)
    found = (gain @ residuals)[:, :3, 0]
    spread = np.eye(3) + (gain @ shared)[:, :3, :3]
    return found, spread


def find_disturbed(
    ribbon: Ribbon, problem: StripProblem, expected: Expected
) -> tuple[Disturbed, ...]:
    """The sensors of one pass (b = 1) that do not agree, in the ribbon's order."""
    inverse = problem.array.inverse
    values = problem.observations.values[0]
    read = (inverse @ values[..., None])[..., 0]
    due = (inverse @ (values + expected.deleted)[..., None])[..., 0]
    read_length, due_length = np.linalg.norm(read, axis=1), np.linalg.norm(due, axis=1)
    whole = problem.array.axes.all(axis=1)
    share = np.abs(read_length - np.where(whole, 1.0, due_length))
    degrees = np.degrees(
        np.arctan2(np.linalg.norm(np.cross(read, due), axis=1), np.sum(read * due, axis=1))
    )
    degrees = np.where(np.minimum(read_length, due_length) > LEAST_SEEN, degrees, 0.0)
    significant = expected.size > SIGNIFICANT
    # A 3-axis sensor's length is due from no neighbour: only its own noise excuses it.
    share = np.where(np.where(whole, share > SIGNIFICANT * _noise(problem), significant), share, 0)
    degrees = np.where(significant, degrees, 0.0)
    return _named(ribbon, problem, share * problem.observations.present[0], degrees)


def _noise(problem: StripProblem) -> FloatArray:
    """(n,) the standard deviation of one axis of each sensor, in units."""
    floor = np.where(problem.array.field, problem.noise.field, problem.noise.acceleration)
    return np.asarray(np.sqrt(np.max(problem.observations.sigma[0] ** 2, axis=1) + floor**2))


def _named(
    ribbon: Ribbon, problem: StripProblem, share: FloatArray, degrees: FloatArray
) -> tuple[Disturbed, ...]:
    out = []
    for i in np.flatnonzero((share > SUSPECT_SHARE) | (degrees > SUSPECT_DEGREES)):
        bad = share[i] > BAD_SHARE or degrees[i] > BAD_DEGREES
        grade: Grade = "bad" if bad else "suspect"
        name = ribbon.sensors[i].name
        reason = _reason(name, bool(problem.array.field[i]), float(share[i]), float(degrees[i]))
        out.append(Disturbed(name, grade, reason, float(share[i]), float(degrees[i])))
    return tuple(out)


def _reason(name: str, field: bool, share: float, degrees: float) -> str:
    parts = []
    if share > SUSPECT_SHARE:
        parts.append(f"{100 * share:.0f} % in strength")
    if degrees > SUSPECT_DEGREES:
        parts.append(f"{degrees:.0f}° in direction")
    cause = "look for a magnet or iron there" if field else "see that it lies flat and still"
    return f"{name} is off by {' and '.join(parts)} from what its neighbours tell: {cause}"


def names_of(disturbed: Sequence[Disturbed]) -> tuple[str, ...]:
    """The sensors' names."""
    return tuple(one.sensor for one in disturbed)
