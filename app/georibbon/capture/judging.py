"""Whether what is held still may be taken: each refusal with its reason and its remedy."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.labels import describe, roll_pitch
from georibbon.capture.plan import PlannedPose
from georibbon.ribbon import Ribbon
from georibbon.rotations import about_x, about_y
from georibbon.world import UP

LEAST_SECONDS = 1.0
# A pose asked for is true to a few degrees; between these two it is taken for what it is
# meant to be, beyond the second it is another one.
TABLE_WITHIN = np.radians(15.0)
POSE_WITHIN = np.radians(25.0)
LEAST_HEARD = 3  # sensors of a kind without which neither a pose nor a pass says anything


@dataclass(frozen=True)
class Refusal:
    """Why nothing is taken now, in one sentence with the remedy.

    code: a word for programs.  forcible: whether a person may take it all the same.
    """

    code: Literal["moving", "disturbed", "short", "silent", "other-pose", "not-lifted", "nothing"]
    message: str
    forcible: bool = False


def rough_up(ribbon: Ribbon, mean: FloatArray) -> FloatArray | None:
    """(3,) the unit "up" in the bar's frame from nominal gains: good to a few degrees.

    mean: (c,) counts, NaN where nothing was heard.  The median over the
    accelerometers, so that no dead one matters; None where fewer than three
    gave values or they tell no direction.
    """
    sensors = ribbon.indices("accelerometer")
    values = np.array([mean[ribbon.slices[i]] / ribbon.sensors[i].counts_per_unit for i in sensors])
    heard = np.isfinite(values).all(axis=1)
    if heard.sum() < min(LEAST_HEARD, len(sensors)):
        return None
    up = np.median(values[heard], axis=0)
    length = float(np.linalg.norm(up))
    return up / length if length > 0.5 else None


def asked_up(pose: PlannedPose) -> FloatArray:
    """(3,) "up" in the bar's frame, as the pose asks for it: (Ry(-pitch) Rx(roll))^T z."""
    level = about_y(np.radians([-pose.pitch])) @ about_x(np.radians([pose.roll]))
    return np.asarray(level[0].T @ UP)


def angle_off(pose: PlannedPose, up: FloatArray) -> float:
    """Radians between gravity and what the pose asks for."""
    return float(np.arccos(np.clip(asked_up(pose) @ up, -1.0, 1.0)))


def lies_as(pose: PlannedPose, up: FloatArray) -> bool:
    """Whether the bar lies as the pose asks, heading aside, which gravity does not tell."""
    return angle_off(pose, up) <= float(TABLE_WITHIN if pose.table else POSE_WITHIN)


def judge_pose(ribbon: Ribbon, pose: PlannedPose, mean: FloatArray) -> Refusal | None:
    """Why a still window's mean (c,) is not this pose; None where it is."""
    up = rough_up(ribbon, mean)
    if up is None:
        return _silent("pose")
    if lies_as(pose, up):
        return None
    roll, pitch = roll_pitch(up[None])
    found = describe(float(roll[0]), float(pitch[0]))
    wanted = describe(float(np.radians(pose.roll)), float(np.radians(pose.pitch)))
    return Refusal(
        "other-pose",
        f"{pose.key} is asked with {wanted}; {found} is what gravity shows; turn the bar, or "
        "choose the pose that it lies in",
        forcible=True,
    )


def judge_pass(ribbon: Ribbon, name: str, mean: FloatArray) -> Refusal | None:
    """Why a still window's mean (c,) says too little for a pass; None where it does not."""
    for kind in ("accelerometer", "magnetometer"):
        sensors = [i for i in range(len(ribbon.sensors)) if ribbon.sensors[i].kind == kind]
        heard = sum(bool(np.isfinite(mean[ribbon.slices[i]]).all()) for i in sensors)
        if heard < min(LEAST_HEARD, len(sensors)):
            return _silent(f"pass {name}")
    return None


def _silent(what: str) -> Refusal:
    return Refusal(
        "silent",
        f"too few sensors give values to take a {what}; look at the ribbon's connection",
    )
