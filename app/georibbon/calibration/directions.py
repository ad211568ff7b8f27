"""Which directions of gravity the poses cover, in the ribbon's own frame."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.gates import LEAST_COVERAGE, MISSING
from georibbon.calibration.plans import AskedPose
from georibbon.calibration.quality import coverage, weakest_axis
from georibbon.rotations import about_x, about_y, about_z
from georibbon.world import UP, field_direction

GOOD_COVERAGE = 0.55
Grade = Literal["good", "fair", "poor"]


@dataclass(frozen=True, eq=False)
class Covered:
    """How the poses that were taken cover the sphere.

    up: (p, 3) unit "up" of all planned poses, in the ribbon's frame; taken: (p,)
    which of them were taken.  figure: three times the smallest eigenvalue of the
    covariance of those taken, 0 to 1; goal: what is good, 0.55 or what all of the
    planned poses reach.  remedy: what to do for it, or "".
    """

    up: FloatArray
    taken: tuple[bool, ...]
    figure: float
    goal: float
    grade: Grade
    remedy: str


def attitude(pose: AskedPose) -> FloatArray:
    """(3, 3) Rz(heading) Ry(-pitch) Rx(roll), from the ribbon's frame to the world's."""
    roll, heading, pitch = np.radians(pose[:3])
    return np.asarray(about_z(heading) @ about_y(-pitch) @ about_x(roll))


def directions_of_gravity(poses: Sequence[AskedPose]) -> FloatArray:
    """(p, 3) unit "up" in the ribbon's frame, R^T z, of poses as they are asked for."""
    return np.array([attitude(pose).T @ UP for pose in poses]).reshape(-1, 3)


def directions_of_field(poses: Sequence[AskedPose], dip: float) -> FloatArray:
    """(p, 3) the unit field in the ribbon's frame, for a dip in radians."""
    toward = field_direction(dip)
    return np.array([attitude(pose).T @ toward for pose in poses]).reshape(-1, 3)


def covered(poses: Sequence[AskedPose], taken: Sequence[bool]) -> Covered:
    """How well the taken ones of the planned poses cover the directions of gravity.

    Good from 0.55 on, or from what the whole plan reaches; under 0.2 a
    calibration is refused.
    """
    up = directions_of_gravity(poses)
    done = up[np.asarray(taken, dtype=bool)]
    figure, goal = _figure(done), min(GOOD_COVERAGE, _figure(up))
    if figure > 0.0 and figure >= goal - 1e-9:
        return Covered(up, tuple(taken), figure, goal, "good", "")
    remedy = MISSING[weakest_axis(done)] if len(done) > 1 else ""
    grade: Grade = "fair" if figure >= LEAST_COVERAGE else "poor"
    return Covered(up, tuple(taken), figure, goal, grade, remedy)


def _figure(up: FloatArray) -> float:
    """The figure of directions (n, 3); 0 where one alone tells nothing."""
    return max(coverage(up), 0.0) if len(up) > 1 else 0.0
