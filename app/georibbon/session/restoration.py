"""What can be restored of a damaged session: its journal as far as it goes, and its frames.

The journal keeps its ids, so that undoing still means what it meant: where an
event is lost, another that changes nothing stands in its place.  A pose or a
pass is kept only if every one of its frames is there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from georibbon import __version__
from georibbon.errors import SessionError
from georibbon.ribbon import Ribbon
from georibbon.session.actions import in_words
from georibbon.session.carving import Carving, Piece
from georibbon.session.chunks import Chunk, DamagedError
from georibbon.session.events import MAX_EVENTS, Event, now
from georibbon.session.fields import MAX_TEXT
from georibbon.session.joining import repacked, stretch, whole_part
from georibbon.session.sealed import sealed_events
from georibbon.session.state import MAX_PART, SessionState, fold
from georibbon.session.words import counted, told

MAX_LOST = 10_000
MAX_FOLDED = 10_000_000  # events gone through to find those that do not fit
MAX_TOLD = 1_000
_LOST = "what stood here is lost"
_KEYS = {"pose": "key", "pass": "name"}


@dataclass
class Restoration:
    """A session restored from what was found of it.

    events: of the new journal, ids without a gap; state: what follows from
    them; lost: what is not in it, a sentence each; whole: the parts of poses and
    passes with the number of their frames; streams: the other parts that are
    kept; claimed: the parts that the events told of.
    """

    carving: Carving
    events: list[Event] = field(default_factory=list)
    state: SessionState = field(default_factory=SessionState)
    lost: list[str] = field(default_factory=list)
    whole: dict[int, int] = field(default_factory=dict)
    streams: list[int] = field(default_factory=list)
    claimed: set[int] = field(default_factory=set)
    pieces: dict[int, list[Piece]] = field(default_factory=dict)

    def chunks(self) -> Iterator[Chunk]:
        """All frames, one part after the other."""
        for part in (*self.whole, *self.streams):
            yield from self.of(part)

    def of(self, part: int) -> Iterator[Chunk]:
        """The frames of a part that is kept."""
        columns = _columns(self.state.ribbon)
        pieces = self.pieces.get(part, [])
        if part in self.whole:
            yield from whole_part(self.carving, pieces, self.whole[part], columns)
        else:
            yield from repacked(stretch(self.carving, pieces, columns), part)


def restore(carving: Carving, name: str, last: int | None) -> Restoration:
    """Everything that can be kept of a session.

    name: its file's, for messages; last: the id of its last event, as the
    file's own tree has it, None where that cannot be read.  Raises SessionError
    where nothing can be kept.
    """
    made = Restoration(carving)
    if not carving.events:
        events, lost = sealed_events(carving.views.values())
        made = Restoration(replace(carving, events=events), lost=lost)
    _keep_events(made)
    if not made.events:
        raise SessionError(_nothing(carving, name))
    for piece in carving.pieces:
        made.pieces.setdefault(piece.part, []).append(piece)
    if carving.events:  # the tables of version 1 are whole or not there
        _tell_end(made, last)
    _keep_frames(made, _place_ribbon(made))
    _keep_what_fits(made)
    _keep_streams(made)
    _tell_total(made)
    _tell_rest(made)
    return made


def _nothing(carving: Carving, name: str) -> str:
    pieces = counted(len(carving.pieces), "piece")
    return (
        f"{name}: nothing of the session's journal can be read"
        + (
            f", only {pieces} of frames of which nothing says what they are"
            if carving.pieces
            else ""
        )
        + "; take a copy of it made before, or capture again"
    )


def _place_ribbon(made: Restoration) -> Ribbon | None:
    """The ribbon, which is told of again where the event that told of it first is lost."""
    ribbons = [event for event in made.events if event.action == "ribbon"]
    holding = [event.id for event in made.events if event.action in (*_KEYS, "stream", "survey")]
    if not ribbons:
        return None
    first, detail = ribbons[0].id, ribbons[0].detail
    place = next((event.id for event in made.events if event.detail.get("event") == _LOST), first)
    if place < min([first, *holding]):
        made.events[place - 1] = Event(place, made.events[place - 1].time, "ribbon", detail)
    created = Event(1, ribbons[0].time, "created", {"georibbon": __version__})
    try:
        return fold([created, Event(2, created.time, "ribbon", detail)]).ribbon
    except (SessionError, DamagedError):
        return None


def _columns(ribbon: Ribbon | None) -> int:
    return 0 if ribbon is None else len(ribbon.columns)


def _keep_events(made: Restoration) -> None:
    """All events, with others in the place of those that are lost."""
    found = {event.id: event for event in made.carving.events if event.id <= MAX_EVENTS}
    missing: list[int] = []
    expected, time = 1, next((event.time for event in found.values()), now())
    for number in sorted(found):
        if number - expected + len(missing) > MAX_LOST:
            made.lost.append(f"the events from {number} on are left out: too many before are lost")
            break
        for absent in range(expected, number):
            missing.append(absent)
            made.events.append(_blank(absent, time, _LOST))
        made.events.append(found[number])
        expected, time = number + 1, found[number].time
    if made.events and made.events[0].action != "created":
        made.events[0] = Event(1, made.events[0].time, "created", {"georibbon": __version__})
    for first, last in _runs(missing):
        made.lost.append(_lost_events(first, last))
    for number in made.carving.conflicts:
        made.lost.append(f"there are two different events {number}; the later one is kept")


def _tell_end(made: Restoration, last: int | None) -> None:
    """Say of the journal's end that it is lost, or that it may be."""
    end = made.carving.events[-1]
    if last is None:
        made.lost.append(f"whether more was done after event {end.id} ({_words(end)}) is not known")
    elif last > end.id:
        made.lost.append(_lost_events(end.id + 1, last))


def _lost_events(first: int, last: int) -> str:
    if first == last:
        return (
            f"event {first} is lost: what it did (perhaps removing or undoing something) is not "
            "known"
        )
    return (
        f"events {first}–{last} are lost: what they did (perhaps removing or undoing something) "
        "is not known"
    )


def _blank(number: int, time: str, why: str) -> Event:
    """An event that changes nothing, in the place of another."""
    return Event(number, time, "recovered", {"to": time, "frames": 0, "event": why})


def _runs(numbers: Sequence[int]) -> list[tuple[int, int]]:
    """Ascending numbers as runs of neighbours (first, last)."""
    runs: list[tuple[int, int]] = []
    for number in numbers:
        if runs and runs[-1][1] == number - 1:
            runs[-1] = (runs[-1][0], number)
        else:
            runs.append((number, number))
    return runs


def _keep_frames(made: Restoration, ribbon: Ribbon | None) -> None:
    """Poses and passes whose frames are all there; removals in the place of the others."""
    good: set[tuple[str, str]] = set()
    last = {_title(event): event.id for event in made.events}
    for i, event in enumerate(made.events):
        title, part = _title(event), event.detail.get("part")
        if event.action not in (*_KEYS, "stream"):
            continue
        if type(part) is not int or not 1 <= part <= MAX_PART or part in made.claimed:
            _leave_out(made, i)
            continue
        made.claimed.add(part)
        if title is None:
            continue
        fault = _fault(made, event, part, ribbon)
        if fault is None:
            good.add(title)
            continue
        made.events[i] = _in_place_of(event, title, title in good)
        when = "" if last[title] == event.id else f" as first captured ({event.time})"
        name = told(title[1]).strip('"')
        kept = "" if ribbon is None else _kept(made, part, len(ribbon.columns))
        made.lost.append(f"{title[0]} {name}{when}: {fault}{kept}")


def _title(event: Event) -> tuple[str, str] | None:
    """What an event captured: ("pose", its key) or ("pass", its name)."""
    key = _KEYS.get(event.action)
    return None if key is None else (event.action, str(event.detail.get(key)))


def _leave_out(made: Restoration, i: int) -> None:
    """Put an event that changes nothing in the place of one that makes no sense here."""
    event = made.events[i]
    made.events[i] = _blank(event.id, event.time, f"{_words(event)} is left out")
    if event.action != "remove":  # what it removed is not there
        made.lost.append(
            f"event {event.id} ({_words(event)}) is left out: it does not fit what is left"
        )


def _words(event: Event) -> str:
    """What an event did, short whatever it holds."""
    return told(in_words(event)).strip('"')


def _fault(made: Restoration, event: Event, part: int, ribbon: Ribbon | None) -> str | None:
    """What is wrong with the frames of a pose or a pass; what is not is whole."""
    frames = event.detail.get("frames")
    if type(frames) is not int or frames < 1:
        return "how many frames it has is not known"
    if ribbon is None:
        return "the ribbon's description is lost, without which its frames mean nothing"
    try:
        whole_part(made.carving, made.pieces.get(part, []), frames, len(ribbon.columns))
    except DamagedError as error:
        return str(error)
    made.whole[part] = frames
    return None


def _in_place_of(event: Event, title: tuple[str, str], replaced: bool) -> Event:
    """What stands where a pose or a pass was captured that cannot be kept.

    It can be undone as that could; and what was captured before under the name
    does not come back unasked.
    """
    if replaced:
        return Event(event.id, event.time, "remove", {title[0]: title[1]})
    text = f"{_words(event)} was captured here; its frames are damaged"
    return Event(event.id, event.time, "note", {"text": text})


def _kept(made: Restoration, part: int, columns: int) -> str:
    """Where the frames are that can be read of what is not whole."""
    readable = sum(piece.frames for piece in made.pieces.get(part, []) if piece.columns == columns)
    frames = counted(readable, "frame")
    return f"; {frames} of it are kept beside the passes, in part {part}" if readable else ""


def _keep_what_fits(made: Restoration) -> None:
    """The state of the events, those left out that cannot follow on what is there."""
    budget = MAX_FOLDED
    while not _folds(made.events):
        fine, bad = 1, len(made.events)
        while bad - fine > 1:
            budget -= bad
            middle = (fine + bad) // 2
            fine, bad = (middle, bad) if _folds(made.events[:middle]) else (fine, middle)
        if budget < 0:
            raise SessionError(
                "the journal makes no sense any more; take a copy of the session made before"
            )
        _leave_out(made, bad - 1)
    made.state = fold(made.events)


def _folds(events: Sequence[Event]) -> bool:
    try:
        fold(events)
    except (SessionError, DamagedError):
        return False
    return True


def _keep_streams(made: Restoration) -> None:
    """Streams, and what else can be read of frames, as streams at the end."""
    held = {event.detail["part"] for event in made.events if event.action in _KEYS}
    made.whole = {part: frames for part, frames in made.whole.items() if part in held}
    made.streams = [stream.part for stream in made.state.streams]
    ribbon = made.state.ribbon
    for part, pieces in made.pieces.items():
        if part in made.whole:
            continue
        fitting = [piece for piece in pieces if piece.columns == _columns(ribbon)]
        if ribbon is None or not fitting or not 1 <= part <= MAX_PART:
            made.lost.append(f"the frames in part {part} do not tell what they are")
        elif part not in made.streams:
            made.streams.append(part)
            _append(made, "stream", {"part": part, "rate": ribbon.rate})
            if part not in made.claimed:
                number = counted(sum(piece.frames for piece in fitting), "frame")
                made.lost.append(f"the event of part {part} is lost; its {number} are kept")


def _tell_total(made: Restoration) -> None:
    """Say of the frames between poses and passes how many are lost, or that it is not known."""
    events = made.carving.events
    parts = [event.detail.get("part") for event in events if event.action == "stream"]
    if not parts:
        return
    found = sum(chunk.frames for part in made.streams if part in parts for chunk in made.of(part))
    held = [_whole(event.detail.get("frames")) for event in events if event.action in _KEYS]
    if events[-1].action == "closed" and events[-1].id == len(events):
        lost = _whole(events[-1].detail.get("frames")) - sum(held) - found
        if lost > 0:
            made.lost.append(f"{counted(lost, 'frame')} between poses and passes are lost")
    else:
        number = counted(found, "frame")
        made.lost.append(
            f"of the frames between poses and passes {number} can be read; how many there were is "
            "not known"
        )


def _whole(value: object) -> int:
    return value if type(value) is int else 0


def _append(made: Restoration, action: str, detail: dict[str, object]) -> None:
    made.events.append(Event(len(made.events) + 1, now(), action, detail))


def _tell_rest(made: Restoration) -> None:
    """A note of what was lost, in the session itself."""
    if not made.carving.whole:
        made.lost.append("the file leads in circles; not all of it was searched")
    if len(made.lost) > MAX_TOLD:
        made.lost[MAX_TOLD:] = [f"and {len(made.lost) - MAX_TOLD} losses more"]
    text = "\n".join(["Salvaged from a damaged file.", *made.lost])
    printable = "".join(c if c.isprintable() or c == "\n" else "?" for c in text)
    _append(made, "note", {"text": printable[:MAX_TEXT]})
    _append(made, "closed", {"frames": sum(chunk.frames for chunk in made.chunks())})
    made.state = fold(made.events)
