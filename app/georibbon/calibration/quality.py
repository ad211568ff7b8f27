"""How well the poses determine a calibration: predicted, from the normal matrices."""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.separable import Normals
from georibbon.ribbon import AXIS_LETTERS

# How much more than readings the bar's square faces count in the figure A: all but exact.
SQUARE = 1e4


@dataclass(frozen=True, eq=False)
class Determined:
    """theta: (n, 4) standard deviation of a row of each sensor's [K | c], worst of its axes.

    unknowns: (m,) of the poses' unknowns.  Both for readings of unit weight.
    """

    theta: FloatArray
    unknowns: FloatArray


def determined(normals: Normals, axes: FloatArray, free: int = 0) -> Determined:
    """Standard deviations from the normal matrices, for readings of standard deviation 1.

    free: how many directions of the poses' unknowns are left undetermined by
    the readings and are held (3 for the accelerometers' common rotation): the
    covariance is then the pseudo-inverse without them.  A sensor row's
    covariance is N^-1 + N^-1 C S^-1 C^T N^-1.
    """
    values, vectors = np.linalg.eigh(normals.reduced)
    kept = np.maximum(values[free:], values[-1] * 1e-15)
    root = vectors[:, free:] / np.sqrt(kept)
    inverse = np.linalg.inv(normals.sensors)
    carried = np.einsum("nab,nbkm->nkam", inverse, normals.coupling) @ root
    variance = np.diagonal(inverse, axis1=1, axis2=2)[:, None] + (carried**2).sum(axis=3)
    present = np.arange(3) < axes[:, None]
    worst = np.where(present[:, :, None], variance, 0.0).max(axis=1)
    return Determined(np.sqrt(worst), np.sqrt((root**2).sum(axis=1)))


def coverage(directions: FloatArray) -> float:
    """Three times the smallest eigenvalue of unit directions' covariance (1: evenly spread)."""
    return float(3.0 * np.linalg.eigvalsh(np.cov(directions.T, bias=True))[0])


def weakest_axis(directions: FloatArray) -> str:
    """The axis, x, y or z, along which directions (n, 3) differ least."""
    least = np.linalg.eigh(np.cov(directions.T, bias=True))[1][:, 0]
    return AXIS_LETTERS[int(np.argmax(np.abs(least)))]


def noise_of(residuals: FloatArray, weights: FloatArray, axes: FloatArray, unknowns: int) -> float:
    """One reading's standard deviation from weighted residuals and what they were fitted with."""
    present = np.arange(3) < axes[:, None]
    readings = (weights[:, :, None] * present[:, None, :]).sum()
    freedom = max(float(readings) - 4.0 * float(axes.sum()) - unknowns, 1.0)
    return float(np.sqrt((weights[:, :, None] * residuals**2).sum() / freedom))


def rms_cells(residuals: FloatArray, valid: FloatArray, axes: FloatArray) -> float:
    """Root mean square of the residuals of the cells that count."""
    number = (valid * axes[:, None]).sum()
    return float(np.sqrt((valid[:, :, None] * residuals**2).sum() / number))


@dataclass(frozen=True)
class Orientation:
    """Predicted standard deviations of a sensor's orientation, radians, rms over the sensors."""

    tilt: float
    heading: float


def orientation(
    accelerometer: FloatArray, magnetometer: FloatArray, gauge: float, bend: float, dip: float
) -> Orientation:
    """What noise, gauge and bend leave together.

    accelerometer, magnetometer: (n, 4) standard deviations of the rows [K | c]
    in units, the noise included.  A tilt has two components.  In a field of
    inclination d a heading error is the sensor's own about the vertical and tan
    d times its tilt across the meridian, so that it grows by 1 / cos d; a noise
    in the reading is seen against the horizontal field, cos d.
    """
    common = bend**2 + gauge**2
    tilt = 2.0 * (common + _row(accelerometer))
    level = np.cos(min(abs(dip), np.radians(85.0))) ** 2
    return Orientation(float(np.sqrt(tilt)), float(np.sqrt((common + _row(magnetometer)) / level)))


def _row(theta: FloatArray) -> float:
    """Mean variance of one predicted reading, for a direction that may be any."""
    return float((theta[:, :3] ** 2).mean() + (theta[:, 3] ** 2).mean())
