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
    gains, biases = np.zeros((len(models), 3, 3)), np.zeros((len(models), 3))
    has = np.zeros((len(models), 3), dtype=bool)
    for k, model in enumerate(models):
        axes = len(model.bias)
        gains[k, :axes], biases[k, :axes], has[k, :axes] = model.gain, model.bias, True
    fields = field if disturbance is None else field + disturbance
    tells_up = np.array([sensor.kind == "accelerometer" for sensor in ribbon.sensors])
    seen = np.where(tells_up[:, None], UP, fields)
    own = np.einsum("...nji,...nj->...ni", frames, np.broadcast_to(seen, frames.shape[:-1]))
    counts = np.einsum("nij,...nj->...ni", gains, own) + biases
    return np.asarray(counts[..., has])


def sample_counts(
    expected: FloatArray, noise: FloatArray, frames: int, rng: np.random.Generator
) -> FloatArray:
    """(frames, c) raw counts: `expected` with white noise of `noise` (c,) counts a sample.

    expected: (c,), the same in all frames, or (frames, c).
    """
    values = expected + noise * rng.standard_normal((frames, len(noise)))
    return np.clip(np.rint(values), -CLIP, CLIP)
