"""What a virtual ribbon says: from true sensor models and frames to counts.

The one forward model of the simulator: an accelerometer reads
gain @ R^T up + bias, a magnetometer gain @ (R^T b + disturbance) + bias, with
white noise on every sample, rounded to whole counts and clipped to 16 bits.
"""

from collections.abc import Sequence

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import SensorModel
from georibbon.ribbon import Ribbon
from georibbon.world import UP

CLIP = 32767.0


def expected_counts(
    ribbon: Ribbon,
    models: Sequence[SensorModel],
    frames: FloatArray,
    field: FloatArray,
    disturbance: FloatArray | None = None,
) -> FloatArray:
    """(..., c) the noiseless readings, counts, in the order of the ribbon's columns.

    frames: (..., n, 3, 3), each sensor's frame, ribbon to world.  field: (3,)
    the unit field in the world.  disturbance: (..., n, 3) what a magnet adds to
    the field at each sensor, in the world, in units of the field; None: nothing.
    """
    extra = np.zeros((len(models), 3)) if disturbance is None else disturbance
    parts = []
    for k, (sensor, model) in enumerate(zip(ribbon.sensors, models, strict=True)):
        seen = UP if sensor.kind == "accelerometer" else field + extra[..., k, :]
        # Row vectors: (R^T seen)^T = seen^T R.
        along = (seen[..., None, :] @ frames[..., k, :, :])[..., 0, :]
        parts.append(along @ model.gain.T + model.bias)
    return np.concatenate(parts, axis=-1)


def sample_counts(
    expected: FloatArray, noise: FloatArray, frames: int, rng: np.random.Generator
) -> FloatArray:
    """(frames, c) raw counts: `expected` with white noise of `noise` (c,) counts a sample.

    expected: (c,), the same in all frames, or (frames, c).
    """
    values = expected + noise * rng.standard_normal((frames, len(noise)))
    return np.clip(np.rint(values), -CLIP, CLIP)
