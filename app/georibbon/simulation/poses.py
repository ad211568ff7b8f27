"""The calibration poses as a careless hand does them."""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.plans import AskedPose
from georibbon.rotations import about_x, about_y, about_z, exp


def attitudes(
    plan: tuple[AskedPose, ...],
    heading_care: float,
    pitch_care: float,
    table_tilt: float,
    rng: np.random.Generator,
) -> FloatArray:
    """(p, 3, 3) the bar's true attitudes, ribbon to world, as carelessly done.

    The asked headings count from one unknown direction.  On the table the face
    lies exactly on it, and it is tilted once for all by `table_tilt` an axis.
    Cares and tilt in degrees, standard deviations.
    """
    table = exp(np.radians([*table_tilt * rng.standard_normal(2), 0.0]))
    offset = rng.uniform(0.0, 360.0)
    slips = rng.standard_normal((len(plan), 2)) * [heading_care, pitch_care]
    asked = np.reshape(plan, (-1, 4)).astype(np.float64)
    on_table = asked[:, 3] > 0
    roll = np.radians(asked[:, 0])
    heading = np.radians(asked[:, 1] + offset + slips[:, 0])
    pitch = np.radians(asked[:, 2] + np.where(on_table, 0.0, slips[:, 1]))
    found = about_z(heading) @ about_y(-pitch) @ about_x(roll)
    return np.where(on_table[:, None, None], table @ found, found)
