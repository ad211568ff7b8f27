"""What all passes share: the field's heading and dip, and each sensor's remaining error.

Every pass sees a sensor's error against its calibration (the bar's bend, the
calibration's own noise) alike, so several passes and a survey reveal it, and
what they don't reveal counts in the covariance of all.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.sensing import SensorArray


@dataclass(frozen=True)
class SharedSigmas:
    """Standard deviations of what all passes share.

    heading, dip: radians.  mounting: radians, each sensor's rotation against its
    calibration.  gauge: radians, the rotation common to all.  offset: each
    magnetometer axis's remaining error, in units of the field.
    """

    heading: float
    dip: float
    mounting: float
    gauge: float
    offset: float


@dataclass(frozen=True, eq=False)
class Shared:
    """What all passes share: heading and dip of the field, radians; sensor errors.

    tilt: (n, 3) radians, each sensor's small rotation in the ribbon's frame.
    offset: (n, 3) units, zero but for the axes of magnetometers.
    """

    heading: float
    dip: float
    tilt: FloatArray
    offset: FloatArray


class Layout:
    """Where the shared unknowns sit: heading, dip, tilts of sensors, offsets of magnetometers."""

    def __init__(self, array: SensorArray) -> None:
        """The layout for an array of n sensors."""
        n = len(array.field)
        magnetometers = np.flatnonzero(array.field)
        self.tilts = slice(2, 2 + 3 * n)
        self.size = 2 + 3 * n + 3 * len(magnetometers)
        self.offsets = slice(2 + 3 * n, self.size)
        self.magnetometers = magnetometers
        self.n = n

    def step(self, shared: Shared, x: FloatArray) -> Shared:
        """The shared unknowns after a step."""
        offset = shared.offset.copy()
        offset[self.magnetometers] += x[self.offsets].reshape(-1, 3)
        tilt = shared.tilt + x[self.tilts].reshape(-1, 3)
        return Shared(shared.heading + float(x[0]), shared.dip + float(x[1]), tilt, offset)

    def vector(self, shared: Shared) -> FloatArray:
        """The shared unknowns as one vector (size,)."""
        own = [shared.heading, shared.dip]
        return np.concatenate([own, shared.tilt.ravel(), shared.offset[self.magnetometers].ravel()])

    def precision(self, sigmas: SharedSigmas) -> FloatArray:
        """(size, size) the inverse of the prior covariance; tilts share the gauge's rotation."""
        out = np.zeros((self.size, self.size))
        out[0, 0], out[1, 1] = sigmas.heading**-2, sigmas.dip**-2
        within = sigmas.mounting**-2 * np.eye(self.n)
        # (a I + g 1 1^T)^-1 for each axis (Sherman and Morrison).
        ratio = sigmas.gauge**2 / sigmas.mounting**2
        within -= sigmas.mounting**-2 * ratio / (1 + self.n * ratio)
        out[self.tilts, self.tilts] = np.kron(within, np.eye(3))
        out[self.offsets, self.offsets] = sigmas.offset**-2 * np.eye(self.size - self.offsets.start)
        return out

    def spread(
        self,
        block: FloatArray,
        gradient: FloatArray,
        common: FloatArray,
        common_gradient: FloatArray,
    ) -> None:
        """Adds each sensor's own equations to those of all that is shared.

        block: (size, size) and gradient: (size,), added to in place.  common:
        (n, 8, 8) and common_gradient: (n, 8), for each sensor by heading, dip,
        its three tilts and its three offsets.
        """
        columns = np.zeros((self.n, 8), dtype=np.int64)
        columns[:, 1] = 1
        columns[:, 2:5] = 2 + np.arange(3 * self.n).reshape(-1, 3)
        columns[:, 5:] = -1
        offsets = self.offsets.start + np.arange(3 * len(self.magnetometers)).reshape(-1, 3)
        columns[self.magnetometers, 5:] = offsets
        for i in range(self.n):
            keep = columns[i] >= 0
            place = columns[i][keep]
            block[np.ix_(place, place)] += common[i][np.ix_(keep, keep)]
            gradient[place] += common_gradient[i][keep]
