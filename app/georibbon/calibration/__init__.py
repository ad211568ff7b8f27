"""From still poses on a bar to the models of a ribbon's sensors."""

from georibbon.calibration.calibrate import Hemisphere, calibrate
from georibbon.calibration.model import (
    MOUNTING_SIGMA,
    Calibration,
    CalibrationQuality,
    SensorModel,
)
from georibbon.calibration.serial import check_fits, from_dict, to_dict
from georibbon.calibration.single import AccelerometerModel, fit_accelerometer
from georibbon.errors import CalibrationError

__all__ = [
    "MOUNTING_SIGMA",
    "AccelerometerModel",
    "Calibration",
    "CalibrationError",
    "CalibrationQuality",
    "Hemisphere",
    "SensorModel",
    "calibrate",
    "check_fits",
    "fit_accelerometer",
    "from_dict",
    "to_dict",
]
