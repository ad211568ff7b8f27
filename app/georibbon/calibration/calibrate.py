"""Poses to a calibration."""

from collections.abc import Sequence

import numpy as np

from georibbon.calibration.accelerometers import fit_accelerometers
from georibbon.calibration.gauge import fit_gauge
from georibbon.calibration.magnetometers import fit_magnetometers
from georibbon.calibration.model import Calibration, SensorModel
from georibbon.calibration.poses import Block, attitudes, block, pose_means
from georibbon.recording import Pose
from georibbon.ribbon import FloatArray, Ribbon


def calibrate(ribbon: Ribbon, poses: Sequence[Pose]) -> Calibration:
    """The models of all sensors from still poses on a straight, square bar.

    Raises CalibrationError where the poses cannot give a calibration.
    """
    asked = attitudes(poses)
    means = pose_means(ribbon, poses)
    accelerometers = block(ribbon, means, "accelerometer")
    magnetometers = block(ribbon, means, "magnetometer")
    first = fit_accelerometers(accelerometers)
    second = fit_magnetometers(magnetometers, asked.level, first.up, asked.heading)
    gauge = fit_gauge(second.frames, asked.roll, asked.table)
    models: dict[str, SensorModel] = {}
    for group, theta in (
        (accelerometers, first.adjusted.theta),
        (magnetometers, second.adjusted.theta),
    ):
        models |= _models(group, theta, gauge.rotation)
    return Calibration(
        ribbon.id,
        second.dip,
        tuple(models[sensor.name] for sensor in ribbon.sensors),
        gauge_sigma=gauge.sigma,
    )


def _models(group: Block, theta: FloatArray, rotation: FloatArray) -> dict[str, SensorModel]:
    gains = theta[:, :, :3] @ rotation * group.units[:, None, None]
    biases = theta[:, :, 3] * group.units[:, None]
    return {
        name: SensorModel(name, np.array(gain[:axes]), np.array(bias[:axes]))
        for name, gain, bias, axes in zip(group.names, gains, biases, group.axes, strict=True)
    }
