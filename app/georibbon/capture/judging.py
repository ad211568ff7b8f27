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
# The bar is straight: nominal gains, mounting and biases of a real ribbon make a few degrees.
STRAIGHT_WITHIN = np.radians(12.0)
LEAST_GRAVITY = 0.5  # g: an accelerometer that says less tells no direction
LEAST_HEARD = 3  # sensors of a kind without which neither a pose nor a pass says anything


@dataclass(frozen=True)
class Refusal:
    """Why nothing is taken now, in one sentence with the remedy.

    code: a word for programs.  forcible: whether a person may take it all the same.
    """

    code: Literal[
        "moving", "disturbed", "short", "silent", "bent", "other-pose", "not-moved", "not-lifted",
        "nothing",
    ]  # fmt: skip
    message: str
    forcible: bool = False


def rough_ups(ribbon: Ribbon, mean: FloatArray) -> FloatArray | None:
    """(n, 3) every accelerometer's unit "up" from nominal gains: good to a few degrees.

    mean: (c,) counts, NaN where nothing was heard: such sensors are left out.
    None where fewer than three say where up is.
    """
    sensors = ribbon.indices("accelerometer")
    values = np.array([mean[ribbon.slices[i]] / ribbon.sensors[i].counts_per_unit for i in sensors])
    length = np.linalg.norm(values, axis=1)
    with np.errstate(invalid="ignore"):
        heard = length > LEAST_GRAVITY
    if heard.sum() < min(LEAST_HEARD, len(sensors)):
        return None
    return np.asarray(values[heard] / length[heard, None], dtype=np.float64)


def rough_up(ups: FloatArray) -> FloatArray:
    """(3,) the unit "up" of a straight ribbon: the median over its sensors, whatever one says."""
    up = np.median(ups, axis=0)
    return np.asarray(up / max(float(np.linalg.norm(up)), 1e-9), dtype=np.float64)


def bend(ups: FloatArray) -> float:
    """Radians by which a quarter of the sensors differ from the common "up", at least."""
    off = np.arccos(np.clip(ups @ rough_up(ups), -1.0, 1.0))
    return float(np.quantile(off, 0.75))


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
    ups = rough_ups(ribbon, mean)
    if ups is None:
        return _silent("pose")
    if bend(ups) > STRAIGHT_WITHIN:
        return Refusal(
            "bent",
            f"{pose.key} is asked on the straight bar; the sensors differ by "
            f"{np.degrees(bend(ups)):.0f}° and more: fix the ribbon straight on the bar",
            forcible=True,
        )
    up = rough_up(ups)
    return None if lies_as(pose, up) else _other_pose(pose, up)


def _other_pose(pose: PlannedPose, up: FloatArray) -> Refusal:
    roll, pitch = roll_pitch(up[None])
    found = describe(float(roll[0]), float(pitch[0]))
    wanted = describe(float(np.radians(pose.roll)), float(np.radians(pose.pitch)))
    off = f"{np.degrees(angle_off(pose, up)):.0f}°"
    shown = f"it lies {off} off that" if found == wanted else f"{found} is what gravity shows"
    return Refusal(
        "other-pose",
        f"{pose.key} is asked with {wanted}; {shown}; turn the bar, or choose the pose that it "
        "lies in",
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
