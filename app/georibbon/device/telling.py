"""What the link tells: each change of its state with the reason, and what happens on the way."""

import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from typing import Literal, TypeVar

T = TypeVar("T")
MOST_EVENTS = 20  # of one kind, told in one second
_MORE = "the ribbon says more than is told; what else it says in this second is left out"
_MORE_NEWS = "more of this kind happens than is told; the rest of this second is left out"
EventKind = Literal["message", "restarted", "refused", "rate"]


class LinkState(StrEnum):
    """How it stands with the ribbon."""

    DISCONNECTED = "disconnected"
    OPENING = "opening"
    STREAMING = "streaming"
    STALLED = "stalled"


@dataclass(frozen=True)
class Change:
    """The link's state has changed; reason: one sentence; time: UTC, ISO 8601."""

    state: LinkState
    reason: str
    time: str


@dataclass(frozen=True)
class Event:
    """Something a person should know that changes no state.

    kind: "message" (of the ribbon's own), "restarted" (its clock or its numbers
    began anew), "refused" (another ribbon, or other sensors), "rate" (not the
    one asked for).  time: UTC, ISO 8601.
    """

    kind: EventKind
    message: str
    time: str


def now() -> str:
    """The time of day, UTC, as ISO 8601 with milliseconds."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


class Listeners:
    """Those who want to be told of changes and of events.

    Of each kind of events at most `MOST_EVENTS` a second are told, so that a ribbon
    gone mad fills no memory and no disk, and what it says hides nothing else; the
    last of them says that there were more.
    """

    def __init__(self) -> None:
        self.changes: list[Callable[[Change], None]] = []
        self.events: list[Callable[[Event], None]] = []
        self._second = -1.0
        self._told: Counter[EventKind] = Counter()

    def changed(self, state: LinkState, reason: str) -> None:
        """Tell of a change."""
        _tell(self.changes, Change(state, reason, now()))

    def happened(self, kind: EventKind, message: str) -> None:
        """Tell of an event."""
        moment = time.monotonic()
        if moment - self._second >= 1.0:
            self._second = moment
            self._told.clear()
        self._told[kind] += 1
        if self._told[kind] < MOST_EVENTS:
            _tell(self.events, Event(kind, message, now()))
        elif self._told[kind] == MOST_EVENTS:
            more = _MORE if kind == "message" else _MORE_NEWS
            _tell(self.events, Event(kind, more, now()))


def _tell(callbacks: list[Callable[[T], None]], told: T) -> None:
    """Call each; a callback's own fault is reported, and never stops the reading."""
    for callback in tuple(callbacks):
        try:
            callback(told)
        except Exception as error:  # whatever it is, frames go on
            here = threading.current_thread()
            args = (type(error), error, error.__traceback__, here)
            threading.excepthook(threading.ExceptHookArgs(args))
