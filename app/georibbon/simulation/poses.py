"""The calibration poses: what is asked for, and what a careless hand makes of it."""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.rotations import about_x, about_y, about_z, exp

Asked = tuple[float, float, float, bool]

FACES = (0.0, 90.0, 180.0, 270.0)


def _on_table(*pairs: tuple[float, float]) -> tuple[Asked, ...]:
    return tuple((roll, heading, 0.0, True) for roll, heading in pairs)


def _tilted(*poses: tuple[float, float, float]) -> tuple[Asked, ...]:
    return tuple((roll, heading, pitch, False) for roll, heading, pitch in poses)


PLANS: dict[int, tuple[Asked, ...]] = {
    12: (
        _on_table(*((roll, heading) for roll, heading in zip(FACES, FACES, strict=True)))
        + _tilted(*((roll, (roll + 90) % 360, 40.0) for roll in FACES))
        + _tilted(*((roll, (roll + 180) % 360, -40.0) for roll in FACES))
    ),
    16: (
        _on_table(*((roll, heading) for roll in FACES for heading in (0.0, 180.0)))
        + _tilted(*((roll, 90.0, pitch) for pitch in (40.0, -40.0) for roll in FACES))
    ),
    20: (
        _on_table((0, 0), (0, 180), (0, 90), (0, 270), (90, 90), (90, 270))
        + _on_table((180, 0), (180, 180), (180, 90), (180, 270), (270, 90), (270, 270))
        + _tilted((0, 0, 40), (0, 90, -40), (90, 0, -40), (90, 90, 40))
        + _tilted((180, 0, 40), (180, 90, -40), (270, 0, -40), (270, 90, 40))
    ),
}
"""The plans by their number of poses: (roll, heading, pitch) in degrees, and whether on the table.

12 is the least that is accepted, 16 good, 20 the best that hands can do
quickly; every plan shows all four faces up and turns the bar end for end.
"""


def attitudes(
    plan: tuple[Asked, ...],
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
