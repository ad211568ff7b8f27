"""The virtual ribbon: where its sensors sit and what is truly wrong with each."""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import SensorModel
from georibbon.ribbon import Ribbon, Sensor
from georibbon.rotations import exp
from georibbon.simulation.settings import RibbonSettings

ACCELEROMETER_COUNTS = 16384.0
MAGNETOMETER_COUNTS = 2000.0


def virtual_ribbon(settings: RibbonSettings) -> Ribbon:
    """Accelerometers and magnetometers by turns, evenly spaced, half a pitch from the ends."""
    pitch = settings.length / settings.sensors
    sensors = []
    for k in range(settings.sensors):
        position, number = round((k + 0.5) * pitch, 6), k // 2 + 1
        if k % 2 == 0:
            sensors.append(
                Sensor(f"A{number:02}", "accelerometer", 3, position, ACCELEROMETER_COUNTS)
            )
        else:
            axes = settings.magnetometer_axes
            sensors.append(
                Sensor(f"M{number:02}", "magnetometer", axes, position, MAGNETOMETER_COUNTS)
            )
    return Ribbon(settings.id, settings.length, settings.rate, tuple(sensors))


def true_models(
    ribbon: Ribbon, settings: RibbonSettings, rng: np.random.Generator
) -> tuple[SensorModel, ...]:
    """Each sensor's true model: scale, cross axes and mounting; soft iron; bias or hard iron."""
    return tuple(_model(sensor, settings, rng) for sensor in ribbon.sensors)


def _model(sensor: Sensor, settings: RibbonSettings, rng: np.random.Generator) -> SensorModel:
    mounting = small_rotations(settings.mounting, 1, rng)[0]
    shape = settings.cross_axis * rng.standard_normal((3, 3))
    np.fill_diagonal(shape, settings.scale * rng.standard_normal(3))
    if sensor.kind == "accelerometer":
        bias = settings.bias * rng.standard_normal(3)
    else:
        iron = settings.soft_iron * rng.standard_normal((3, 3)) / 2
        shape += (iron + iron.T) / 2
        bias = settings.hard_iron * rng.standard_normal(3)
    gain = sensor.counts_per_unit * (np.eye(3) + shape) @ mounting
    bias = sensor.counts_per_unit * bias
    return SensorModel(sensor.name, gain[: sensor.axes], bias[: sensor.axes])


def noise_counts(ribbon: Ribbon, settings: RibbonSettings) -> FloatArray:
    """(c,) standard deviation of a sample of each column, counts."""
    unit = {"accelerometer": settings.acceleration_noise, "magnetometer": settings.field_noise}
    return np.concatenate(
        [
            np.full(sensor.axes, sensor.counts_per_unit * unit[sensor.kind])
            for sensor in ribbon.sensors
        ]
    )


def small_rotations(degrees: float, n: int, rng: np.random.Generator) -> FloatArray:
    """(n, 3, 3) random small rotations, `degrees` standard deviation about each axis."""
    return exp(np.radians(degrees) * rng.standard_normal((n, 3)))
