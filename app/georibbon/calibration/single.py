"""One accelerometer alone, from still poses in any attitudes.

In each pose a still accelerometer reads y = gain a + bias with a a unit vector
of unknown direction: nine numbers and no more can be told, because a rotation
of the sensor changes no length.  The gain is given as the inverse of the upper
triangular U with positive diagonal for which |U (y - bias)| = 1: the sensor's z
axis is its own, its y axis lies in the plane of its own y and z (Tedaldi, Pretto
and Menegatti 2014).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from georibbon.arrays import FloatArray
from georibbon.calibration.quality import coverage, weakest_axis
from georibbon.errors import CalibrationError
from georibbon.notices import Notice

LEAST_POSES = 9
LEAST_COVERAGE, GOOD_COVERAGE = 0.2, 0.55
# How far the bias may move between the algebraic and the geometric fit, in units
# of 1 g: a large shift shows poses that do not determine it.
WORST_SHIFT, GOOD_SHIFT = 0.02, 0.004
# The standard deviation of the worst parameter for noise of 1: what poses far apart
# keep at a few units, and nine random ones put at a hundred.
WORST_SPREAD, GOOD_SPREAD = 50.0, 12.0
STEPS = 50
DAMPING = 1e-12  # of the mean diagonal: only against what the poses leave exactly open
UPPER = np.triu_indices(3)


@dataclass(frozen=True, eq=False)
class AccelerometerModel:
    """y = gain a + bias, counts; a in g, of length 1 where it stands still.

    gain: (3, 3) float64, counts per g, upper triangular.  bias: (3,) float64,
    counts.  residual_mg: rms over the poses of |gain^-1 (y - bias)| - 1, in mg;
    coverage: three times the smallest eigenvalue of the directions' covariance;
    shift: the bias' move between algebraic and geometric fit, in g; sigma: (3,)
    the bias' standard deviation, counts.
    """

    gain: FloatArray
    bias: FloatArray
    residual_mg: float
    coverage: float
    shift: float
    sigma: FloatArray
    notices: tuple[Notice, ...] = ()


def fit_accelerometer(means: ArrayLike) -> AccelerometerModel:
    """One accelerometer's model from the means of still poses, (n, 3) counts, n at least 9.

    The ellipsoid through the readings is fitted algebraically first, then
    geometrically: minimise sum (|U (y - b)| - 1)^2 by Gauss-Newton.

    Raises CalibrationError for input of another shape, for fewer than 9 poses,
    and for poses that do not cover the directions, and says which are missing.
    """
    readings = _checked(means)
    centre, scale = readings.mean(axis=0), float(readings.std(axis=0).max())
    _require_turned(len(readings), scale)
    unit = (readings - centre) / scale
    _require_space(unit)
    start = _algebraic(unit)
    upper, bias, normal = _geometric(unit, *start)
    directions = (unit - bias) @ upper.T
    lengths = np.linalg.norm(directions, axis=1)
    directions = directions / lengths[:, None]
    covered, spread = coverage(directions), _spread(normal)
    shift = float(np.linalg.norm(upper @ (bias - start[1])))
    notices = _judged(covered, shift, float(spread.max()), directions)
    squares = float(((lengths - 1.0) ** 2).sum())
    return AccelerometerModel(
        np.asarray(np.linalg.inv(upper) * scale),
        centre + bias * scale,
        1e3 * float(np.sqrt(squares / len(unit))),
        covered,
        shift,
        spread[6:] * float(np.sqrt(squares / max(len(unit) - 9, 1))) * scale,
        notices,
    )


def _require_turned(poses: int, scale: float) -> None:
    """Raises CalibrationError where all poses read the same."""
    if scale <= 0.0:
        raise CalibrationError(
            f"all {poses} poses read the same counts; turn the sensor between the poses"
        )


def _checked(means: ArrayLike) -> FloatArray:
    try:
        readings = np.asarray(means, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise CalibrationError(
            "the poses' means are no table of numbers; give (n, 3) counts, one row a pose"
        ) from error
    if readings.ndim != 2 or readings.shape[1] != 3:
        raise CalibrationError(
            f"the poses' means have the shape {readings.shape}, (n, 3) is needed; "
            "give one row a pose with the counts of x, y and z"
        )
    bad = ~np.isfinite(readings).all(axis=1)
    if bad.any():
        raise CalibrationError(
            f"row {int(np.argmax(bad)) + 1} of the poses' means holds a value that is no finite "
            "number; leave that pose out or take it again"
        )
    if len(readings) < LEAST_POSES:
        raise CalibrationError(
            f"{len(readings)} poses were given, at least {LEAST_POSES} are needed, far apart in "
            f"direction; take {LEAST_POSES - len(readings)} more"
        )
    return readings


def _design(unit: FloatArray) -> FloatArray:
    """(n, 10) the terms of a quadric: squares, products, linear, one."""
    x, y, z = unit.T
    ones = np.ones_like(x)
    return np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, x, y, z, ones], axis=1)


def _require_space(unit: FloatArray) -> None:
    """Raises CalibrationError where the readings lie in a plane, or on fewer than nine spots."""
    values = np.linalg.eigvalsh(np.cov(unit.T, bias=True))
    if values[0] < 1e-4 * values[2]:
        raise CalibrationError(
            f"all poses lie in one plane, nothing was turned towards {_axis(weakest_axis(unit))}; "
            "take poses with that axis up and down"
        )
    spots = np.unique(np.round(unit, 2), axis=0)
    if len(spots) < LEAST_POSES:
        raise CalibrationError(
            f"the {len(unit)} poses show {len(spots)} different directions only, at least "
            f"{LEAST_POSES} are needed; take poses between the axes, tilted by 30 to 60°"
        )


def _algebraic(unit: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Upper triangular U and b of the ellipsoid with the least algebraic residual."""
    q = np.linalg.svd(np.linalg.qr(_design(unit), mode="r"))[2][-1]
    matrix = np.array([[q[0], q[3], q[4]], [q[3], q[1], q[5]], [q[4], q[5], q[2]]])
    if np.trace(matrix) < 0.0:
        q, matrix = -q, -matrix
    if np.linalg.eigvalsh(matrix)[0] <= 1e-6 * np.trace(matrix):
        return np.eye(3) / np.sqrt((unit**2).sum(axis=1).mean()), np.zeros(3)
    bias = -0.5 * np.linalg.solve(matrix, q[6:9])
    size = bias @ matrix @ bias - q[9]
    return np.asarray(np.linalg.cholesky(matrix / size).T), np.asarray(bias)


def _geometric(
    unit: FloatArray, upper: FloatArray, bias: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """U, b and the (9, 9) normal matrix that minimise sum (|U (y - b)| - 1)^2."""
    normal = np.eye(9)
    for _ in range(STEPS):
        moved = unit - bias
        along = moved @ upper.T
        lengths = np.linalg.norm(along, axis=1)
        along = along / lengths[:, None]
        jacobian = np.concatenate([(along[:, UPPER[0]] * moved[:, UPPER[1]]), -along @ upper], 1)
        residual = lengths - 1.0
        cost = float(residual @ residual)
        normal = jacobian.T @ jacobian
        damped = normal + DAMPING * np.trace(normal) / 9.0 * np.eye(9)
        step = -np.linalg.solve(damped, jacobian.T @ residual)
        upper, bias = _moved(unit, upper, bias, step, cost)
        if np.abs(step).max() < 1e-12:
            break
    return upper, bias, normal


def _moved(
    unit: FloatArray, upper: FloatArray, bias: FloatArray, step: FloatArray, cost: float
) -> tuple[FloatArray, FloatArray]:
    """The step taken, halved while it makes the cost worse."""
    for _ in range(20):
        trial = upper.copy()
        trial[UPPER] += step[:6]
        lengths = np.linalg.norm((unit - bias - step[6:]) @ trial.T, axis=1)
        if ((lengths - 1.0) ** 2).sum() <= cost * (1.0 + 1e-12) + 1e-28:
            return trial, bias + step[6:]
        step = 0.5 * step
    return upper, bias


def _spread(normal: FloatArray) -> FloatArray:
    """(9,) standard deviations of U's six entries and b for unit noise, from the normal matrix."""
    values, vectors = np.linalg.eigh(normal)
    kept = np.maximum(values, values[-1] * 1e-14)
    return np.asarray(np.sqrt((vectors**2 / kept).sum(axis=1)))


def _axis(letter: str) -> str:
    return f"the sensor's {letter} axis"


def _judged(
    covered: float, shift: float, spread: float, directions: FloatArray
) -> tuple[Notice, ...]:
    """Notices for a weak fit; raises CalibrationError for one that is worth nothing."""
    poses, weakest = len(directions), _axis(weakest_axis(directions))
    _require_determined(covered, shift, spread, poses, weakest)
    doubts = (
        (
            spread > GOOD_SPREAD,
            f"the {poses} poses leave a parameter at {spread:.0f} times their noise, good is "
            f"{GOOD_SPREAD:.0f}; take more poses, far apart, between the axes",
        ),
        (
            covered < GOOD_COVERAGE,
            f"the poses differ little along {weakest} (coverage {covered:.2f}, good is "
            f"{GOOD_COVERAGE}); take more poses with that axis up and down",
        ),
        (
            shift > GOOD_SHIFT,
            f"the bias moves by {100.0 * shift:.2f} % of 1 g between the algebraic and the "
            f"geometric fit, good is {100.0 * GOOD_SHIFT:.1f} %; take more poses, far apart",
        ),
    )
    return tuple(Notice("calibration-weak", message) for weak, message in doubts if weak)


def _require_determined(
    covered: float, shift: float, spread: float, poses: int, weakest: str
) -> None:
    """Raises CalibrationError where the poses leave the model open."""
    if covered < LEAST_COVERAGE:
        raise CalibrationError(
            f"the poses hardly differ along {weakest} (coverage {covered:.2f}, at least "
            f"{LEAST_COVERAGE} is needed); take poses with that axis up and down"
        )
    if shift > WORST_SHIFT:
        raise CalibrationError(
            f"the bias moves by {100.0 * shift:.1f} % of 1 g between the algebraic and the "
            f"geometric fit, {100.0 * WORST_SHIFT:.0f} % is the most, so the poses do not "
            f"determine it; take more poses, far apart, most of all with {weakest} up and down"
        )
    if spread > WORST_SPREAD:
        raise CalibrationError(
            f"the {poses} poses leave a parameter at {spread:.0f} times their noise, "
            f"{WORST_SPREAD:.0f} times is the most; take poses between the axes, tilted by 30 to "
            f"60°, most of all towards {weakest}"
        )
