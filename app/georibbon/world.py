"""The world's axes and the two directions that sensors know in it.

x is magnetic east, y magnetic north, z up.
"""

import numpy as np

from georibbon.arrays import FloatArray

UP = np.array([0.0, 0.0, 1.0])


def field_direction(dip: float, heading: float = 0.0) -> FloatArray:
    """(3,) the unit field, `dip` below the horizontal, in a frame turned by `heading` about z.

    Radians; the frame is turned counter-clockwise seen from above.
    """
    level = np.cos(dip)
    return np.array([level * np.sin(heading), level * np.cos(heading), -np.sin(dip)])
