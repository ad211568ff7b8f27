"""What a pose is called against what gravity and the field say it was."""

from dataclasses import replace

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.poses import Attitudes
from georibbon.errors import CalibrationError
from georibbon.notices import Notice

# A pose asked for is true to a few degrees; beyond these it was another one.
WRONG = np.radians(30.0)
FACE_WITHIN = np.radians(15.0)
OPPOSITE = np.radians(120.0)
HEADING_WRONG = np.radians(50.0)
FACES = {
    0: "the upper face up",
    90: "the left edge up",
    180: "the face down",
    270: "the right edge up",
}


def face_of(roll: float) -> int:
    """The key in `FACES` of the face that is nearest to up; roll in radians."""
    return int(np.rint(np.degrees(roll) / 90.0)) % 4 * 90


def describe(roll: float, pitch: float) -> str:
    """A pose in words: which face is up and, beyond 15 degrees, which end; radians."""
    face = FACES[face_of(roll)]
    if abs(pitch) <= FACE_WITHIN:
        return face
    return f"{face} and the {'end' if pitch > 0 else 'start'} {abs(np.degrees(pitch)):.0f}° up"


def roll_pitch(up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(p,) roll and pitch, radians, of poses with "up" (p, 3) in the bar's frame."""
    return np.arctan2(up[:, 1], up[:, 2]), np.arcsin(np.clip(up[:, 0], -1.0, 1.0))


def check_labels(asked: Attitudes, up: FloatArray) -> tuple[Attitudes, list[Notice]]:
    """The labels, corrected where gravity says otherwise, with a notice for each."""
    off = np.arccos(np.clip((asked.up * up).sum(axis=1), -1.0, 1.0))
    wrong = off > WRONG
    if not wrong.any():
        return asked, []
    if (off > OPPOSITE).all():
        raise CalibrationError(
            "in every pose the accelerometers say the opposite of what its label asks for: they "
            "give gravity (-1 g on the axis that points up) where specific force (+1 g) is "
            "expected; negate their counts and read the recording again"
        )
    roll, pitch = roll_pitch(up)
    face = np.rint(roll / (0.5 * np.pi)) * 0.5 * np.pi
    flat = (np.abs(pitch) < FACE_WITHIN) & (np.abs(roll - face) < FACE_WITHIN)
    notices = [
        Notice(
            "pose-mislabelled",
            f"{name_of(asked, p)} was asked with "
            f"{describe(float(asked.roll[p]), float(asked.pitch[p]))}; "
            f"{describe(float(roll[p]), float(pitch[p]))} is what gravity shows, and is used; "
            "correct its label if it is kept",
        )
        for p in map(int, np.flatnonzero(wrong))
    ]
    corrected = replace(
        asked,
        roll=np.where(wrong, np.where(flat, face, roll), asked.roll),
        pitch=np.where(wrong, np.where(flat, 0.0, pitch), asked.pitch),
        table=asked.table & ~(wrong & ~flat),
    )
    return corrected, notices


def name_of(asked: Attitudes, p: int) -> str:
    """A pose for a sentence: its number, and its name."""
    return f"pose {asked.numbers[p]} ({asked.names[p]!r})"


def check_headings(asked: Attitudes, found: FloatArray) -> tuple[BoolArray, list[Notice]]:
    """Which headings (p,) are others than asked, up to what is common, with the notices."""
    turned = np.exp(1j * (found - asked.heading))
    # The offset common to most: the difference that lies nearest to all others.
    apart = np.abs(np.angle(turned[:, None] / turned[None, :]))
    common = turned[int(np.argmin(np.median(apart, axis=0)))]
    near = np.abs(np.angle(turned / common)) < HEADING_WRONG
    offset = np.angle(turned[near].sum())
    off = np.angle(turned * np.exp(-1j * offset))
    wrong = np.abs(off) > HEADING_WRONG
    if wrong.sum() > len(wrong) // 2:
        message = (
            f"the headings asked for agree with the field in {int((~wrong).sum())} of "
            f"{len(wrong)} poses only; those found are used; follow the plan's headings next time"
        )
        return wrong, [Notice("pose-heading-corrected", message)]
    notices = [
        Notice(
            "pose-heading-corrected",
            f"{name_of(asked, p)} was asked at heading {np.degrees(asked.heading[p]):.0f}°; "
            f"{np.degrees(asked.heading[p] + off[p]) % 360.0:.0f}° is what the field shows, "
            "and is used; correct its label if it is kept",
        )
        for p in map(int, np.flatnonzero(wrong))
    ]
    return wrong, notices
