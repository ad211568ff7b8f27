"""What the sensors of a pass say, in units, and how well they can say it.

A sensor at rest reads y = G R^T u + noise (in units: g, or the local field),
with u the "up" vector or the field in the world and R the ribbon's frame
there.  Its noise has three parts: of the mean of the frames; a floor for what
temperature and the calibration's own noise leave; and the contact's: a small
rotation of the sensor against the ideal ribbon, with covariance
sigma² G (|u|² I - u u^T) G^T, which is what limits a real reading.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.calibration.model import Calibration
from georibbon.ribbon import Ribbon


@dataclass(frozen=True, eq=False)
class SensorArray:
    """The n sensors of a calibrated ribbon, all as three axes (missing axes are zero rows).

    gain: (n, 3, 3) per unit.  bias: (n, 3) counts.  scale: (n,) counts a unit.
    axes: (n, 3) the axes there are.  field: (n,) True for a magnetometer.
    used: (n,) False for a sensor that the calibration leaves out.
    """

    gain: FloatArray
    bias: FloatArray
    scale: FloatArray
    axes: BoolArray
    field: BoolArray
    used: BoolArray

    @classmethod
    def of(cls, ribbon: Ribbon, calibration: Calibration) -> "SensorArray":
        """The array for a ribbon and its calibration."""
        n = len(ribbon.sensors)
        gain, bias = np.zeros((n, 3, 3)), np.zeros((n, 3))
        axes = np.zeros((n, 3), dtype=bool)
        for i, model in enumerate(calibration.sensors):
            k = len(model.bias)
            gain[i, :k], bias[i, :k], axes[i, :k] = model.gain, model.bias, True
        counts = np.sqrt(np.sum(gain**2, axis=(1, 2)) / axes.sum(axis=1))
        scale = np.where(counts > 0, counts, 1.0)
        return cls(
            gain=gain / scale[:, None, None],
            bias=bias,
            scale=scale,
            axes=axes,
            field=np.array([sensor.kind == "magnetometer" for sensor in ribbon.sensors]),
            used=np.array([model.used for model in calibration.sensors]) & (counts > 0),
        )

    @cached_property
    def inverse(self) -> FloatArray:
        """(n, 3, 3) the gains' pseudo-inverses: the vector of least length for a reading."""
        return np.asarray(np.linalg.pinv(self.gain))


@dataclass(frozen=True, eq=False)
class Observations:
    """The readings of b passes, in units.

    values, sigma: (b, n, 3) the still means without bias, and their standard
    deviation; zero on an axis that does not exist.  present: (b, n) whether
    the sensor said something in the pass and is used.
    """

    values: FloatArray
    sigma: FloatArray
    present: BoolArray

    def take(self, index: IntArray | list[int]) -> "Observations":
        """The passes of the given places in the stack."""
        return Observations(self.values[index], self.sigma[index], self.present[index])


@dataclass(frozen=True)
class Noise:
    """Standard deviations of a reading beyond its own scatter.

    contact: radians, of a sensor against the ideal ribbon, a rotation about
    each axis, new with every laying.  acceleration: g; field: of the local field: floors.
    """

    contact: float = np.radians(0.25)
    acceleration: float = 0.001
    field: float = 0.002


def observe(
    ribbon: Ribbon, array: SensorArray, means: FloatArray, sigmas: FloatArray
) -> Observations:
    """Still means (b, c) in counts, with their standard deviations, as observations.

    A sensor with a missing (NaN) axis is not present in that pass.
    """
    b, n = len(means), len(ribbon.sensors)
    values, noise = np.zeros((b, n, 3)), np.zeros((b, n, 3))
    for i, where in enumerate(ribbon.slices):
        k = where.stop - where.start
        values[:, i, :k] = (means[:, where] - array.bias[i, :k]) / array.scale[i]
        noise[:, i, :k] = sigmas[:, where] / array.scale[i]
    finite = np.isfinite(values).all(axis=2) & np.isfinite(noise).all(axis=2)
    present = finite & array.used
    values[~finite], noise[~finite] = 0.0, 0.0
    return Observations(values, noise, present)


def whitening(
    array: SensorArray, observations: Observations, noise: Noise, directions: FloatArray
) -> FloatArray:
    """(b, n, 3, 3) matrices W with W^T W the inverse of each reading's covariance.

    directions: (b, n, 3) the unit vectors u in the ribbon's frame at the
    sensors.  Zero for an absent sensor.
    """
    across = np.eye(3) - directions[..., :, None] * directions[..., None, :]
    covariance = noise.contact**2 * (array.gain @ across @ np.swapaxes(array.gain, 1, 2))
    floor = np.where(array.field, noise.field, noise.acceleration)
    variance = observations.sigma**2 + floor[:, None] ** 2
    variance = np.where(array.axes, variance, 1.0)
    for k in range(3):
        covariance[..., k, k] += variance[..., k]
    w = np.linalg.inv(np.linalg.cholesky(covariance))
    w *= observations.present[..., None, None]
    return np.asarray(w)
