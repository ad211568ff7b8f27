"""What of a plan is done: a view of the plan and the session, with nothing of its own to forget."""

from dataclasses import dataclass
from typing import Literal

from georibbon.capture.plan import CapturePlan, PlannedPass, PlannedPose
from georibbon.session.state import SessionState

Status = Literal["open", "taken", "skipped"]


@dataclass(frozen=True)
class Item:
    """One pose, pass or tie: key, what to do in words, and how it stands.

    what: the planned pose or pass.  key: the pose's key or the pass's name.
    """

    key: str
    words: str
    what: PlannedPose | PlannedPass
    status: Status

    @property
    def is_pose(self) -> bool:
        """Whether it is a calibration pose."""
        return isinstance(self.what, PlannedPose)


def checklist(
    plan: CapturePlan, state: SessionState, asked: tuple[PlannedPass, ...] = ()
) -> tuple[Item, ...]:
    """All items in order: planned poses, planned passes and ties, what is beyond the plan.

    asked: passes beyond the plan that may not be in the session yet.
    """
    poses = {one.key for one in state.poses}
    passes = {one.name for one in state.passes}
    skipped = set(state.skipped)
    items = [
        Item(one.key, one.words, one, _status(one.key, poses, skipped))
        for one in plan.planned_poses
    ]
    planned = {one.name: one for one in plan.planned_passes}
    beyond = (*(PlannedPass(one.name, one.kind) for one in state.passes), *asked)
    for one in (planned | {one.name: one for one in beyond}).values():
        words = "lay a tie across the passes" if one.kind == "tie" else "lay a pass"
        items.append(Item(one.name, words, one, _status(one.name, passes, skipped)))
    return tuple(items)


def _status(key: str, taken: set[str], skipped: set[str]) -> Status:
    if key in taken:
        return "taken"
    return "skipped" if key in skipped else "open"


def next_open(items: tuple[Item, ...], after: str | None, poses: bool) -> str | None:
    """The next open item of a kind after a key, then from the start; None where none is left."""
    keys = [item.key for item in items]
    start = keys.index(after) + 1 if after in keys else 0
    for item in (*items[start:], *items[:start]):
        if item.status == "open" and item.is_pose == poses:
            return item.key
    return None
