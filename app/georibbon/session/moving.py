"""Everything that a session holds, gathered for a new file."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from georibbon.errors import GeoribbonError, StorageError
from georibbon.session.actions import in_words
from georibbon.session.chunks import Chunk
from georibbon.session.events import Event
from georibbon.session.state import SessionState, advance, fold, parts_of
from georibbon.session.store import Store
from georibbon.session.stream import Stream, Work
from georibbon.session.words import counted

Kept = Mapping[int, tuple[Chunk, ...]]


@dataclass(eq=False)
class Moved:
    """What a new file gets.

    lost: the parts that cannot be read any more, whose events are left out;
    told: a sentence for each loss.  ends: how each growing stream stands in
    the new file; known when `chunks` has come to its end.
    """

    events: tuple[Event, ...]
    state: SessionState
    lost: frozenset[int]
    told: list[str]
    store: Store
    kept: Kept
    streams: Sequence[Stream]
    ends: dict[int, Work] = field(default_factory=dict)

    def chunks(self) -> Iterator[Chunk]:
        """All chunks, one by one; StorageError where one was readable before and is no more."""
        growing = {stream.part: stream for stream in self.streams}
        for part, frames in parts_of(self.events).items():
            if part in self.kept:
                yield from self.kept[part]
            elif frames is None:
                yield from self._stream(part, growing.get(part))
            else:
                for chunk in self.store.readable(part):
                    if chunk is None:
                        raise StorageError("the session can no longer be read while it is copied")
                    yield chunk

    def _stream(self, part: int, growing: Stream | None) -> Iterator[Chunk]:
        """The chunks of a stream that can be read, in places without a gap."""
        place = failed = 0
        for chunk in self.store.readable(part):
            if growing is not None and chunk is not None and chunk.place >= growing.base:
                break
            failed += chunk is None
            if chunk is not None:
                yield replace(chunk, place=place)
                place += 1
        if growing is not None:
            yield from self._growing(growing, place)
        if failed:
            pieces = counted(failed, "piece")
            self.told.append(f"{pieces} of the frames in stream {part} could not be read any more")

    def _growing(self, stream: Stream, place: int) -> Iterator[Chunk]:
        """What of a stream is in memory: its small chunks, and the frames that wait."""
        last = None
        for last in stream.merging(place):
            yield from last.chunks[: len(last.chunks) - len(last.tail)]
        if last is not None:
            yield from last.tail
        # where nothing was in memory, the next frames follow on the places here all the same
        self.ends[stream.part] = last or Work((), (), 0, 0, place, ())


def gathered(events: Sequence[Event], store: Store, kept: Kept, streams: Sequence[Stream]) -> Moved:
    """What there is to put into a new file.

    kept: the frames of poses and passes that are in memory; the others are read
    through the open connection as far as that goes.
    """
    lost = frozenset(
        part
        for part, frames in parts_of(events).items()
        if frames is not None and part not in kept and not _whole(store, part, frames)
    )
    told = [
        f"the frames of {in_words(event)} could not be read any more"
        for event in events
        if event.detail.get("part") in lost
    ]
    left, state = without(events, lost) if lost else (tuple(events), None)
    return Moved(left, state or fold(left), lost, told, store, kept, streams)


def without(
    events: Sequence[Event], lost: frozenset[int]
) -> tuple[tuple[Event, ...], SessionState]:
    """The events without those of lost parts and what made sense with these alone, renumbered."""
    state, left, numbers = SessionState(), list[Event](), dict[object, int]()
    for event in events:
        detail = dict(event.detail)
        if detail.get("part") in lost:
            continue
        if event.action in ("undo", "redo"):
            detail["of"] = numbers.get(detail["of"])
        if event.action == "order":
            names = [run.name for run in state.passes]
            asked = detail.get("passes")
            left_names = asked if isinstance(asked, list) else []
            detail["passes"] = [name for name in left_names if name in names]
        one = Event(len(left) + 1, event.time, event.action, detail)
        try:
            state = advance(state, one)
        except GeoribbonError:
            continue
        left.append(one)
        numbers[event.id] = one.id
    return tuple(left), state


def _whole(store: Store, part: int, frames: int) -> bool:
    found = 0
    for chunk in store.readable(part):
        if chunk is None:
            return False
        found += chunk.frames
    return found == frames
