"""How well a calibration's expected errors are known themselves, and what a plan will give."""

from dataclasses import dataclass

import numpy as np

from georibbon.calibration.model import Calibration
from georibbon.ribbon import Ribbon

# Expected errors in degrees (tilt, heading) of the plans, for a usual ribbon: 32 sensors,
# magnetometers of two axes, a field 65 degrees steep, a bar straight to 0.2 degrees; measured by
# benchmarks/daily_check.py.
PLAN_ERRORS: dict[int, tuple[float, float]] = {12: (0.33, 0.54), 16: (0.29, 0.49), 20: (0.29, 0.49)}


@dataclass(frozen=True)
class Expected:
    """Expected errors of the sensors, rms, with their own standard deviations; degrees."""

    tilt: float
    tilt_sigma: float
    heading: float
    heading_sigma: float


def expected_errors(ribbon: Ribbon, calibration: Calibration) -> Expected | None:
    """What the sensors will be off, and within what: None for a calibration without a quality.

    A variance that is the sum of parts v_k, each with f_k degrees of freedom,
    scatters by the root of sum 2 v_k² / f_k (Satterthwaite 1946).  The part
    common to all sensors has two (tilt) or one (heading); the sensors' own part
    two or one for each of them.
    """
    quality = calibration.quality
    if quality is None:
        return None
    numbers = {"accelerometer": 0, "magnetometer": 0}
    for sensor, model in zip(ribbon.sensors, calibration.sensors, strict=True):
        numbers[sensor.kind] += model.used
    level = max(abs(float(np.cos(calibration.dip))), np.cos(np.radians(85.0)))
    common_tilt = 2.0 * quality.gauge**2
    common_heading = (quality.gauge / level) ** 2
    return Expected(
        quality.tilt,
        _sigma(quality.tilt, common_tilt, 2, 2 * numbers["accelerometer"]),
        quality.heading,
        _sigma(quality.heading, common_heading, 1, numbers["magnetometer"]),
    )


def _sigma(error: float, common: float, freedom: int, own_freedom: int) -> float:
    """The standard deviation of a root mean square from its parts."""
    common = min(common, error**2)
    own = error**2 - common
    variance = 2.0 * common**2 / freedom + 2.0 * own**2 / max(own_freedom, 1)
    return float(np.sqrt(variance) / (2.0 * error)) if error > 0.0 else 0.0
