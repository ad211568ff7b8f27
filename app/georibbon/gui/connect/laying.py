"""What the hands of the virtual ribbon are told, for what a capture asks for; without Qt."""

from collections.abc import Mapping, Sequence

from georibbon.capture.checklist import Item
from georibbon.capture.plan import PlannedPose
from georibbon.session.outline import Survey, survey_tables

Tables = Mapping[str, Sequence[Mapping[str, object]]]


def laying_words(item: Item) -> str:
    """The command that lays a pose or pass as it is asked for."""
    if isinstance(item.what, PlannedPose):
        return _pose_words(item.what, item.what.roll)
    return f"lay {item.key}"


def wrong_words(item: Item, names: Sequence[str]) -> str:
    """The command that lays a pose upside down, or another pass than is asked for.

    names: the passes and ties that there are.
    """
    if isinstance(item.what, PlannedPose):
        return _pose_words(item.what, (item.what.roll + 180.0) % 360.0)
    at = names.index(item.key) if item.key in names else -1
    return f"lay {names[(at + 1) % len(names)]}"


def _pose_words(pose: PlannedPose, roll: float) -> str:
    table = ",table" if pose.table else ""
    return f"pose {roll:g},{pose.heading:g},{pose.pitch:g}{table}"


def survey_missing(
    measured: Survey, there: Tables, names: Sequence[str]
) -> list[tuple[str, dict[str, object]]]:
    """What was measured of these passes and ties and is not in the survey yet, by table."""
    missing = []
    for table, entries in survey_tables(*measured).items():
        known = [dict(entry) for entry in there.get(table, ())]
        for entry in entries:
            passes = entry.get("passes", [entry.get("pass")])
            if entry not in known and all(name in names for name in passes):
                missing.append((table, entry))
    return missing
