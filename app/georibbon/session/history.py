"""What was done in a session, as a person looks through it afterwards."""

import datetime
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.ribbon import Readings, Ribbon
from georibbon.session.actions import in_words
from georibbon.session.events import EVERY_PASS, Event

EntryKind = Literal["capture", "note", "change", "link", "file"]
ENTRY_KINDS: tuple[EntryKind, ...] = ("capture", "note", "change", "link", "file")
_KINDS: dict[str, EntryKind] = {
    **dict.fromkeys(("pose", "pass", "remove", "skip", "order"), "capture"),
    "note": "note",
    "link": "link",
    **dict.fromkeys(
        ("created", "opened", "closed", "recovered", "moved", "ribbon", "stream"), "file"
    ),
}


@dataclass(frozen=True)
class Entry:
    """One thing that was done.

    time: UTC, ISO 8601.  pass_name: of which pass, if of one.  undone: whether
    it was taken back and does not count.
    """

    id: int
    time: str
    kind: EntryKind
    words: str
    pass_name: str | None
    undone: bool

    @property
    def local_time(self) -> datetime.datetime:
        """When, in this machine's time zone."""
        return datetime.datetime.fromisoformat(self.time).astimezone()


def entries(events: Sequence[Event]) -> tuple[Entry, ...]:
    """What the events say, in their order."""
    gone: set[object] = set()
    for event in events:
        if event.action in ("undo", "redo"):
            gone ^= {event.detail.get("of")}
    seen: set[object] = set()
    made = []
    for event in events:
        words = _words(event, events)
        if event.action in ("pass", "pose"):
            name = event.detail.get("name" if event.action == "pass" else "key")
            words += ", once more" if (event.action, name) in seen else ""
            seen.add((event.action, name))
        kind = _KINDS.get(event.action, "change")
        made.append(Entry(event.id, event.time, kind, words, _pass(event), event.id in gone))
    return tuple(made)


def _words(event: Event, events: Sequence[Event]) -> str:
    """What it was; of undoing and redoing what they went over; a note in full."""
    if event.action == "note":
        return str(event.detail.get("text", ""))
    of = event.detail.get("of")
    if event.action in ("undo", "redo") and isinstance(of, int) and 1 <= of <= len(events):
        verb = "took back" if event.action == "undo" else "did again"
        return f"{verb} {in_words(events[of - 1])}"
    return in_words(event)


def _pass(event: Event) -> str | None:
    """Which pass it is about."""
    name = event.detail.get("name" if event.action == "pass" else "pass")
    return name if isinstance(name, str) and name != EVERY_PASS else None


@dataclass(frozen=True)
class ReadingsFacts:
    """What the raw readings of one pass say at a glance.

    frames; seconds from the first to the last; rate: frames a second, None for
    one frame.  lost: values that are missing.  restless: the axis that moved
    most against its own scale, and by how much: its standard deviation, in
    thousandths of 1 g or of the field; None where nothing was heard.
    """

    frames: int
    seconds: float
    rate: float | None
    lost: int
    restless: tuple[str, float] | None


def readings_facts(readings: Readings, ribbon: Ribbon) -> ReadingsFacts:
    """The facts of a pass's readings."""
    frames = len(readings.t)
    seconds = float(readings.t[-1] - readings.t[0]) if frames else 0.0
    rate = (frames - 1) / seconds if frames > 1 and seconds > 0 else None
    lost = int(np.count_nonzero(np.isnan(readings.counts)))
    scales = [sensor.counts_per_unit for sensor in ribbon.sensors for _ in sensor.columns]
    heard = np.isfinite(readings.counts).sum(axis=0) > 1
    restless = None
    if heard.any():
        moved = np.zeros(len(scales))
        moved[heard] = np.nanstd(readings.counts[:, heard], axis=0)
        moved = 1e3 * moved / np.abs(scales)
        most = int(np.argmax(moved))
        restless = (ribbon.columns[most], float(moved[most]))
    return ReadingsFacts(frames, seconds, rate, lost, restless)
