"""How the poses of a calibration stand, without Qt: cards, refusals, the bar as it lies now."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from georibbon.calibration.check import CHECK_NUMBERS
from georibbon.calibration.directions import attitude
from georibbon.calibration.labels import face_of, roll_pitch
from georibbon.calibration.model import Calibration
from georibbon.capture.checklist import Item
from georibbon.capture.judging import (
    LEAST_SECONDS,
    POSE_WITHIN,
    TABLE_WITHIN,
    angle_off,
    bend,
    rough_up,
    rough_ups,
)
from georibbon.capture.ledger import Happening
from georibbon.capture.plan import PlannedPose
from georibbon.device.frames import readings_of
from georibbon.notices import Notice

CardState = Literal["open", "asked", "good", "poor", "refused", "skipped"]
CHECK_KEYS = tuple(f"pose-{number:02}" for number in CHECK_NUMBERS)
LIVE_SECONDS = 0.2  # over which the live attitude is averaged
TILTED = np.radians(15.0)
# Figures of quality in degrees: good and fair; what is beyond is poor.
TILT_GRADES, HEADING_GRADES, GAUGE_GRADES = (0.5, 1.0), (1.0, 2.0), (0.1, 0.15)
Grade = Literal["good", "fair", "poor"]
_NUMBERED = re.compile(r"pose \d+ \('([^']*)'\)|pose '([^']*)'")


@dataclass(frozen=True)
class Card:
    """One pose's card.

    number: in the plan, from 1.  reason: why it is poor or refused, else "".
    """

    key: str
    number: int
    pose: PlannedPose
    state: CardState
    reason: str = ""


@dataclass
class Progress:
    """What is known of the poses beyond the checklist: why which is refused or poor."""

    refused: dict[str, str] = field(default_factory=dict)
    poor: dict[str, str] = field(default_factory=dict)

    def take(self, happening: Happening) -> None:
        """Something happened in the capture."""
        subject, kind = happening.subject, happening.kind
        if kind == "refused":
            self.refused = {subject: happening.message} if subject else {}
        elif kind in ("taken", "chosen", "skipped", "removed", "undone", "redone", "held"):
            self.refused.clear()
            if kind == "taken" and subject is not None:
                self.poor.pop(subject, None)

    def judge(self, poses: Sequence[PlannedPose], notices: Sequence[Notice]) -> None:
        """What a calibration says of its poses."""
        keys = {one.name: one.key for one in poses}
        self.poor = {}
        for notice in notices:
            for key in named_poses(notice.message, keys):
                told = with_keys(notice.message, keys)
                self.poor[key] = f"{self.poor[key]}; {told}" if key in self.poor else told


def named_poses(message: str, keys: Mapping[str, str]) -> list[str]:
    """The keys of the poses that a sentence names."""
    names = [first or second for first, second in _NUMBERED.findall(message)]
    return [keys[name] for name in names if name in keys]


def with_keys(message: str, keys: Mapping[str, str]) -> str:
    """A sentence with poses named as their cards are, and not by their order of coming."""

    def name(found: re.Match[str]) -> str:
        return keys.get(found[1] or found[2], found[0])

    return _NUMBERED.sub(name, message)


def poses_of(items: Sequence[Item], keys: Sequence[str] = ()) -> list[Item]:
    """The items that are poses, of these keys alone where any are given."""
    return [item for item in items if item.is_pose and (not keys or item.key in keys)]


def cards(
    items: Sequence[Item], current: Item | None, progress: Progress, keys: Sequence[str] = ()
) -> tuple[Card, ...]:
    """The cards of all poses, of these keys alone where any are given."""
    found = []
    for number, item in enumerate(poses_of(items, keys), start=1):
        asked = current is not None and item.key == current.key
        state: CardState = "open"
        reason = ""
        if item.status == "taken":
            reason = progress.poor.get(item.key, "")
            state = "poor" if reason else "good"
        elif item.status == "skipped":
            state = "skipped"
        if asked and item.key in progress.refused:
            state, reason = "refused", progress.refused[item.key]
        elif asked and state in ("open", "skipped"):
            state = "asked"
        found.append(Card(item.key, number, item.what, state, reason))
    return tuple(found)


def done(found: Sequence[Card]) -> int:
    """How many of the cards are taken."""
    return sum(card.state in ("good", "poor") for card in found)


def next_open(found: Sequence[Card], after: str | None) -> str | None:
    """The key of the next card that is not taken, after one and then from the first."""
    keys = [card.key for card in found]
    start = keys.index(after) + 1 if after in keys else 0
    for card in (*found[start:], *found[:start]):
        if card.state not in ("good", "poor", "skipped") and card.key != after:
            return card.key
    return None


@dataclass(frozen=True, eq=False)
class Lying:
    """The bar as it lies now, by its accelerometers alone.

    up: (3,) unit "up" in the bar's frame.  off: degrees from the pose asked for.
    bent: degrees by which a quarter of the sensors differ from the others.
    """

    up: np.ndarray
    off: float
    within: float
    bent: float

    @property
    def matches(self) -> bool:
        """Whether it lies as it is asked, its heading aside."""
        return self.off <= self.within

    def attitude(self, heading: float) -> np.ndarray:
        """(3, 3) the attitude, with a heading in degrees, which gravity does not tell."""
        roll, pitch = (float(np.degrees(one[0])) for one in roll_pitch(self.up[None]))
        return attitude((roll, heading, pitch, False))

    @property
    def lifted(self) -> bool:
        """Whether one end is up."""
        return bool(abs(np.arcsin(np.clip(self.up[0], -1.0, 1.0))) > TILTED)


def lying(ribbon, frames, pose: PlannedPose | None) -> Lying | None:
    """The bar as the newest frames show it; None where too little is heard."""
    if not frames:
        return None
    counts = readings_of(frames).counts
    heard = np.isfinite(counts)
    total = np.where(heard, counts, 0.0).sum(axis=0)
    number = heard.sum(axis=0)
    mean = np.where(number > 0, total / np.maximum(number, 1), np.nan)
    ups = rough_ups(ribbon, mean)
    if ups is None:
        return None
    up = rough_up(ups)
    bent = float(np.degrees(bend(ups)))
    if pose is None:
        return Lying(up, 0.0, 0.0, bent)
    within = float(np.degrees(TABLE_WITHIN if pose.table else POSE_WITHIN))
    return Lying(up, float(np.degrees(angle_off(pose, up))), within, bent)


def share_still(seconds: float) -> float:
    """How much of the rest that is needed has gone by, 0 to 1."""
    return min(max(seconds / LEAST_SECONDS, 0.0), 1.0)


def grade(value: float, grades: tuple[float, float]) -> Grade:
    """How good a figure in degrees is."""
    return "good" if value <= grades[0] else "fair" if value <= grades[1] else "poor"


def suspects(calibration: Calibration) -> dict[str, str]:
    """The sensors that something is wrong with, and what."""
    found = {model.name: model.reason for model in calibration.sensors if not model.used}
    for notice in calibration.notices:
        if notice.sensor is not None:
            found[notice.sensor] = notice.message
    return found


def face_words(pose: PlannedPose) -> str:
    """The key of a pose's face: "top", "left", "under" or "right" is up."""
    return {0: "top", 90: "left", 180: "under", 270: "right"}[face_of(float(np.radians(pose.roll)))]
