"""The calibration poses as a careless hand does them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.plans import PLANS, AskedPose
from georibbon.rotations import about_x, about_y, about_z, exp
from georibbon.simulation.settings import PoseSettings
from georibbon.simulation.virtual import small_rotations


def asked_poses(settings: PoseSettings) -> tuple[AskedPose, ...]:
    """The poses that are asked for: those listed, or the plan's."""
    return settings.poses or PLANS.get(settings.plan, ())


@dataclass(frozen=True, eq=False)
class Bar:
    """The bar that the ribbon is calibrated on, and the room.

    bend: (n, 3, 3) the bar's bend at each sensor, the same in all poses.
    table: (3, 3) the table's tilt.  north: degrees, the direction from which
    the headings that are asked for count.
    """

    bend: FloatArray
    table: FloatArray
    north: float

    def attitudes(self, plan: Sequence[AskedPose], slips: FloatArray) -> FloatArray:
        """(p, n, 3, 3) the sensors' true frames, ribbon to world, in each pose.

        slips: (p, 2) degrees by which heading and pitch miss what is asked; on
        the table the face lies exactly on it.
        """
        asked = np.reshape(plan, (-1, 4)).astype(np.float64)
        on_table = asked[:, 3] > 0
        roll = np.radians(asked[:, 0])
        heading = np.radians(asked[:, 1] + self.north + slips[:, 0])
        pitch = np.radians(asked[:, 2] + np.where(on_table, 0.0, slips[:, 1]))
        found = about_z(heading) @ about_y(-pitch) @ about_x(roll)
        laid = np.where(on_table[:, None, None], self.table @ found, found)
        return np.asarray(laid[:, None] @ self.bend)


def set_bar(settings: PoseSettings, sensors: int, rng: np.random.Generator) -> Bar:
    """The bar for so many sensors, its bend, the table's tilt and the headings' zero drawn."""
    bend = small_rotations(settings.bend, sensors, rng)
    table = exp(np.radians([*settings.table_tilt * rng.standard_normal(2), 0.0]))
    return Bar(bend, table, float(rng.uniform(0.0, 360.0)))


def draw_slips(settings: PoseSettings, poses: int, rng: np.random.Generator) -> FloatArray:
    """(poses, 2) degrees by which a careless hand misses heading and pitch."""
    care = [settings.heading_care, settings.pitch_care]
    return np.asarray(rng.standard_normal((poses, 2)) * care)
