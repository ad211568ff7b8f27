"""From still poses on a bar to the models of a ribbon's sensors."""

from georibbon.calibration.calibrate import calibrate
from georibbon.calibration.model import (
    Calibration,
    CalibrationQuality,
    SensorModel,
)

__all__ = ["Calibration", "CalibrationQuality", "SensorModel", "calibrate"]
