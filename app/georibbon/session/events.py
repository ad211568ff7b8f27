"""The events of a session's journal, as rows of the table `event` and as values.

The actions and their details (JSON objects; lengths in metres, angles in
degrees; the fields named as in `recording.toml` are those of its tables):

    created      {"georibbon": version}; the first event
    ribbon       the table [ribbon], and "firmware" where it is known
    title        {"title": text or null}
    workpiece    the table [workpiece]; {} for none
    plan         {"poses", "passes", "ties"}: how many are meant to be captured
    pose         {"key", "name", "roll", "heading", "pitch", "table", "part", "frames"};
                 the same key again: the pose was repeated
    pass         {"name", "kind", "part", "frames"}; the same name again: it was redone
    remove       {"pose": key} or {"pass": name}
    order        {"passes": names}: all passes and ties in another order
    skip         {"pose": key} or {"pass": name}: it will not be captured
    survey       {"mark", "distance", "crossing"}: the whole survey
    setting      {"pass": name or "*", "key", "value"}: null takes the setting back
    settings     {"changes": several such}: in one step
    calibration  {"document": a calibration file's, or null}
    note         {"text"} and perhaps {"pass": name}
    undo, redo   {"of": id}: the last event that can be, taken back or done again
    stream       {"part", "rate"}: frames between poses and passes; its chunks follow
    link         {"state", "reason", ...}: what the link to the ribbon did
    opened, closed {"frames"}, recovered {"to", "frames"}, moved {"from"}: what the file did
"""

import datetime
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from georibbon.errors import SessionError
from georibbon.session.chunks import DamagedError
from georibbon.session.words import told

UNDOABLE = frozenset(
    ("title", "workpiece", "plan", "pose", "pass", "remove", "order", "skip", "survey", "setting",
     "settings", "calibration", "note")
)  # fmt: skip
ACTIONS = UNDOABLE | frozenset(
    ("created", "ribbon", "undo", "redo", "stream", "link", "opened", "closed", "recovered",
     "moved")
)  # fmt: skip
EVERY_PASS = "*"  # stands for all passes in a setting
MAX_DETAIL = 32 * 2**20
MAX_EVENTS = 1_000_000
_LONGEST_TIME = 40
Row = tuple[object, ...]


@dataclass(frozen=True, eq=False)
class Event:
    """One thing that was done; time: UTC as ISO 8601; detail: plain JSON."""

    id: int
    time: str
    action: str
    detail: Mapping[str, object]

    @property
    def row(self) -> Row:
        """The row of the table; SessionError where the detail is no JSON or too long."""
        detail = encode_detail(self.detail)
        digest = event_digest(self.id, self.time, self.action, detail)
        return (self.id, self.time, self.action, detail, digest)


def now() -> str:
    """The present time as events tell it: UTC, ISO 8601, to the millisecond."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")


def event_digest(number: int, time: str, action: str, detail: str) -> bytes:
    """SHA-256 of a row's values; detail: the JSON text as it stands in the row."""
    text = f"{number}\n{time}\n{action}\n{detail}"
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).digest()


def encode_detail(detail: Mapping[str, object]) -> str:
    """A detail as JSON; SessionError where it is none, or too long."""
    try:
        text = json.dumps(detail, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        size = len(text.encode())
    except (TypeError, ValueError, RecursionError) as error:
        raise SessionError(
            f"the session cannot keep this value ({told(error)}); give plain numbers and texts"
        ) from error
    if size > MAX_DETAIL:
        raise SessionError(f"{size} bytes in one entry; at most {MAX_DETAIL} are kept; shorten it")
    return text


def decode_detail(text: str) -> Mapping[str, object]:
    """The detail in a row's text; DamagedError where it is none."""
    if len(text) > MAX_DETAIL:
        raise DamagedError(f"an event has more than {MAX_DETAIL} characters")
    try:
        detail = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise DamagedError("the detail of an event is no JSON") from error
    if not isinstance(detail, dict):
        raise DamagedError("the detail of an event is no JSON object")
    return detail


def event_of(row: Sequence[object]) -> Event:
    """The event in a row (id, time, action, detail, digest).

    Raises DamagedError where the row is not as it was written, or is none of
    ours; that the detail makes sense is for `state.fold` to find.
    """
    if len(row) != 5:
        raise DamagedError("an event has not the values that it should have")
    number, time, action, detail, digest = row
    if not (
        isinstance(number, int)
        and isinstance(time, str)
        and isinstance(action, str)
        and isinstance(detail, str)
    ):
        raise DamagedError("an event has values of the wrong type")
    if event_digest(number, time, action, detail) != digest:
        raise DamagedError(f"event {number} does not match its digest")
    if number < 1 or action not in ACTIONS:
        raise DamagedError(f"event {number} has the unknown action {told(action)}")
    _check_time(number, time)
    return Event(number, time, action, decode_detail(detail))


def _check_time(number: int, time: str) -> None:
    try:
        fine = len(time) <= _LONGEST_TIME and datetime.datetime.fromisoformat(time).tzinfo
    except ValueError:
        fine = None
    if not fine:
        raise DamagedError(f"event {number} has no time but {told(time)}")


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is no number")
