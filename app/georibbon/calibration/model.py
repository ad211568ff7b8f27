"""The calibration of a ribbon: what turns raw counts into specific force and field.

A sensor's reading in counts is ``gain @ u + bias + noise`` with u the unit
"up" vector (accelerometer, g) or the field in units of the local field
(magnetometer), both in the ribbon's frame at the sensor.  The gain of a 2-axis
magnetometer is 2 by 3 and has no inverse, so calibration is never undone: the
fit predicts counts.
"""

import math
from dataclasses import dataclass, field

from georibbon.arrays import FloatArray
from georibbon.notices import Notice

# What the bar's bend leaves in each sensor's orientation, radians about each axis.
# It is the same in every pose, so that no residual shows it: an assumption, for a
# bar straight to 0.2 degrees at every sensor.
MOUNTING_SIGMA = math.radians(0.2)


@dataclass(frozen=True, eq=False)
class SensorModel:
    """One sensor's model.

    gain: (axes, 3) float64, counts per g or per local field, columns along the
    ribbon's x, y, z; bias: (axes,) float64, counts.  used: False where the
    sensor is left out of every fit (dead, swapped axes, ...); `reason` says why.
    """

    name: str
    gain: FloatArray
    bias: FloatArray
    used: bool = True
    reason: str = ""


@dataclass(frozen=True)
class CalibrationQuality:
    """How well the poses determine the calibration (degrees unless said).

    tilt, heading: predicted standard deviation of a sensor's orientation, rms
    over the sensors, from the normal matrices and the bar's bend; gauge: of the
    rotation common to all sensors; accelerometer_mg: the worst accelerometer
    parameter for 1 mg of noise in a pose mean ("A"); magnetometer_percent: the
    worst magnetometer parameter for 0.5 % ("B"); coverage: three times the
    smallest eigenvalue of the pose directions' covariance; residuals: rms over
    poses, mg and percent of the field.
    """

    poses: int
    tilt: float
    heading: float
    gauge: float
    accelerometer_mg: float
    magnetometer_percent: float
    coverage: float
    accelerometer_residual_mg: float
    magnetometer_residual_percent: float


@dataclass(frozen=True, eq=False)
class Calibration:
    """The models of all sensors of one ribbon, in the order of its sensors.

    dip: radians, the field's inclination below the horizontal where the ribbon
    was calibrated.  quality: None for a calibration that came without it.

    What remains uncertain, standard deviations in radians: mounting_sigma, each
    sensor's own orientation about each axis (the bar's bend, MOUNTING_SIGMA);
    gauge_sigma, the rotation common to all sensors, about each axis; dip_sigma.
    """

    ribbon_id: str
    dip: float
    sensors: tuple[SensorModel, ...]
    quality: CalibrationQuality | None = None
    notices: tuple[Notice, ...] = field(default=())
    mounting_sigma: float = MOUNTING_SIGMA
    gauge_sigma: float = 0.0
    dip_sigma: float = 0.0
