"""A session: everything that is captured, in a file that survives what computers do.

What `do`, `add_pose` and `add_pass` accept is on the disk when they return.
Where it cannot be written they raise StorageError; it is held in memory then,
stands in `state` all the same, and is written as soon as the place is mended,
by `retry`, or to another place by `move_to`.
"""

import os
import sqlite3
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from georibbon.errors import GeoribbonError, SessionError, StorageError
from georibbon.recording import PassKind, Recording
from georibbon.ribbon import Readings, Ribbon
from georibbon.session import store
from georibbon.session.chunks import Chunk, DamagedError, pack
from georibbon.session.counts import check_readings
from georibbon.session.database import connect, damaged, read_sizes, version_of
from georibbon.session.events import Event, decode_detail, encode_detail, now
from georibbon.session.journal import Batch, Journal
from georibbon.session.lock import HeldError, Lock, holder, lock_file, not_lockable
from georibbon.session.migration import chunks_to_keep, migrate
from georibbon.session.place import place_warnings
from georibbon.session.reading import Contents, contents, frames_of, read_part, reading
from georibbon.session.recovery import Recovery, recovery_of
from georibbon.session.restoring import begun, recording_of
from georibbon.session.schema import VERSION
from georibbon.session.soundness import check_frames, check_wholly, has_log, left_log
from georibbon.session.state import advance, fold, parts_of
from georibbon.session.store import Store, check_place
from georibbon.session.stream import Stream
from georibbon.session.words import told
from georibbon.session.writer import Writer

_OWN = frozenset(
    ("created", "pose", "pass", "stream", "undo", "redo", "opened", "closed", "recovered", "moved")
)
Told = Callable[[str | None], None]


class Session:
    """A session file, opened by `create` or `open`; a context manager.

    path: where it is.  state: what it holds.  read_only: whether it can be
    written to.  recovery: what a crash had left, or None.  warnings: what a
    person must know of the file and its place.  Verbs may be called by any
    thread; `on_storage` callbacks come on the writer's thread and return soon.
    """

    def __init__(
        self, path: Path, found: Contents, lock: Lock | None, warnings: Sequence[str] = ()
    ) -> None:
        """Use `create` or `open`."""
        self.path = path
        self.state = found.state
        self.recovery: Recovery | None = None
        self.warnings = tuple(warnings)
        self._next_part = max(parts_of(found.events), default=0) + 1
        self._doing = threading.RLock()
        self._callbacks: list[Told] = []
        self._changed = False
        self._closed = False
        self._streams: list[Stream] = []
        self._journal: Journal | None = None
        if lock is not None:
            self._journal = Journal(Store(path), lock, self._tell)
            self._writer = Writer(self._journal.tick)

    @classmethod
    def create(cls, path: Path, ribbon: Ribbon | None = None, *, title: str | None = None) -> Self:
        """A new session, durable when this returns.

        Raises SessionError where there is such a file already or the place
        cannot be written.
        """
        check_place(path)
        time = now()
        events = tuple(
            Event(i, time, action, detail)
            for i, (action, detail) in enumerate(begun(ribbon, title), start=1)
        )
        state = fold(events, path.name)
        lock = _locked(path)
        try:
            check_place(path)  # it may have been taken before the lock was
            store.create(path, events, ())
            found = Contents(VERSION, events, state, {}, closed=False)
            try:
                session = cls(path, found, lock, place_warnings(path))
            except BaseException:
                store.unmake(path)
                raise
        except BaseException:
            lock.release()
            raise
        session._changed = True
        return session

    @classmethod
    def open(cls, path: Path, *, read_only: bool = False) -> Self:
        """A session that is there; an older version's is brought to the present one.

        It is opened read only where another program has it open, or where it may
        not be written: `warnings` says so.  Raises SessionError where it is
        missing, no session, of a newer version or damaged.
        """
        with reading(path) as database:
            version = version_of(database, path)
        if read_only:
            return cls._opened_to_read(path, ())
        left = _left(path)
        try:
            # a migrated session is a new file, which has one name
            why = _not_writable(path, one_name=version == VERSION)
            lock = Lock(path) if why is None else None
        except HeldError as error:
            why, lock = str(error), None
        except OSError as error:
            why, lock = not_lockable(path, error), None
        if lock is None:
            return cls._opened_to_read(path, (f"{why}; it is opened read only",))
        try:
            return cls._opened_to_write(path, lock, left)
        except BaseException:
            lock.release()
            raise

    @classmethod
    def _opened_to_read(cls, path: Path, warnings: Sequence[str]) -> Self:
        live = holder(path)  # who closes it while it is read had it open when it was read
        with reading(path) as database:
            found = contents(database, path)
            session = cls(path, found, None, warnings)
            if live or holder(path):
                return session
            if not found.closed or has_log(path):
                check_wholly(database, found, path)
            session.warnings += _left(path)
            if not found.closed:
                session.recovery = recovery_of(database, found, path.name)
        return session

    @classmethod
    def _opened_to_write(cls, path: Path, lock: Lock, left: Sequence[str]) -> Self:
        recovery, warnings = None, (*place_warnings(path), *left)
        old: list[Chunk] = []
        if has_log(path):  # the next connection gives up, and removes, what is behind a fault
            with reading(path) as database:
                check_wholly(database, contents(database, path), path)
        try:
            with closing(connect(f"{path.resolve().as_uri()}?mode=rw")) as database:
                found = contents(database, path)
                if not found.closed:
                    check_frames(database, found)
                    recovery = recovery_of(database, found, path.name)
                if found.version < VERSION:
                    old = chunks_to_keep(database, found)
        except DamagedError as error:
            raise damaged(path, error) from error
        except (sqlite3.Error, OverflowError, MemoryError, UnicodeError) as error:
            raise damaged(path, error) from error
        if found.version < VERSION:
            kept = migrate(path, found, old)
            warnings += (f"the session of version {found.version} is kept as {kept.name}",)
        session = cls(path, found, lock, warnings)
        if recovery is not None:
            session.recovery = recovery
            with suppress(StorageError):
                session._accept("recovered", {"to": recovery.time, "frames": recovery.frames})
        return session

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        _type: type[BaseException] | None,
        _error: BaseException | None,
        _traceback: TracebackType | None,
    ) -> None:
        try:
            self.close()
        except GeoribbonError:
            self.close(discard=True)
            raise

    @property
    def read_only(self) -> bool:
        """Whether nothing can be written to it."""
        return self._journal is None

    @property
    def storage_error(self) -> str | None:
        """Why what was accepted cannot be written, in one sentence; None where it can."""
        error = None if self._journal is None else self._journal.error
        return None if error is None else str(error)

    @property
    def held(self) -> bool:
        """Whether something that was accepted is in memory alone."""
        return self.storage_error is not None

    def on_storage(self, callback: Told) -> None:
        """Have a sentence told when the place fails, and None when it is mended.

        The callback must not call the session, which waits for it.
        """
        self._callbacks.append(callback)

    def do(self, action: str, /, **detail: object) -> Event:
        """Do one of the actions of `events`; durable when this returns.

        Raises SessionError for what cannot be meant, and StorageError where it
        cannot be written.
        """
        if action in _OWN:
            raise ValueError(f"{action} is not done by this verb")
        return self._accept(action, detail)

    def add_pose(
        self,
        key: str,
        name: str,
        roll: float,
        heading: float,
        pitch: float,
        table: bool,
        readings: Readings,
    ) -> Event:
        """Keep a pose, degrees, in place of the one with this key; as `do`.

        Raises RecordingError for readings that are none of this ribbon.
        """
        detail = {"key": key, "name": name, "roll": roll, "heading": heading}
        return self._add("pose", detail | {"pitch": pitch, "table": table}, readings)

    def add_pass(self, name: str, kind: PassKind, readings: Readings) -> Event:
        """Keep a pass or tie in place of the one of this name; as `add_pose`."""
        return self._add("pass", {"name": name, "kind": kind}, readings)

    def _add(self, action: str, detail: Mapping[str, object], readings: Readings) -> Event:
        with self._doing:
            check_readings(readings, self._columns(), f"{action} {told(detail['name'])}")
            part = self._next_part
            where = {"part": part, "frames": int(readings.t.size)}
            return self._accept(action, {**detail, **where}, tuple(pack(readings, part)))

    def undo(self) -> str | None:
        """Take the last thing back, for good if nothing else follows; in words what it was."""
        with self._doing:
            words = self.state.undoable
            if words is not None:
                self._accept("undo", {"of": self.state.done[-1]})
            return words

    def redo(self) -> str | None:
        """Do again what was undone last; in words what it was."""
        with self._doing:
            words = self.state.redoable
            if words is not None:
                self._accept("redo", {"of": self.state.undone[-1]})
            return words

    def stream(self, rate: float) -> Stream:
        """A new stream of frames between poses and passes; rate: frames per second.

        Where its beginning cannot be written it is held as its frames are.
        """
        with self._doing:
            journal, columns = self._writable(), self._columns()
            part = self._next_part
            with suppress(StorageError):
                self._accept("stream", {"part": part, "rate": rate})
            stream = Stream(part, columns, self._writer.poke)
            self._streams.append(stream)
            self._writer.call(lambda: journal.add(stream))
            return stream

    def readings(self, part: int) -> Readings:
        """The frames of a part, as far as they are durable or held.

        Raises SessionError where they cannot be read.
        """
        journal = self._journal
        try:
            if journal is None:
                with reading(self.path) as database:
                    return read_part(database, part, self.state)
            return frames_of(self._writer.call(lambda: journal.chunks(part)), self.state)
        except DamagedError as error:
            raise damaged(self.path, error) from error

    def frames_in(self, part: int) -> int:
        """How many frames a part has in the file."""
        journal = self._journal
        if journal is None:
            with reading(self.path) as database:
                return read_sizes(database).get(part, 0)
        return self._writer.call(journal.sizes).get(part, 0)

    def recording(self, complete: bool = True) -> Recording:
        """The recording captured so far, without the survey's entries that wait for a pass.

        complete: refuse, with a SessionError, what cannot span a surface.
        """
        return recording_of(self.state, self.readings, self.path.name, complete)

    def pending_survey(self) -> tuple[str, ...]:
        """The names in the survey of passes that are not captured."""
        return self.state.pending_survey

    def retry(self) -> None:
        """Write what is held to the same place.  Raises StorageError where that fails again."""
        with self._doing:
            self._writer.call(self._writable().flush)

    def move_to(self, path: Path) -> None:
        """Put everything, also what is held, into a new file and go on there.

        The old file stays as it is.  What can no longer be read of it is told in
        `warnings`.  Raises SessionError where there is such a file already or none can be made,
        and StorageError where the new place fails too; nothing has changed then.
        """
        with self._doing:
            journal = self._writable()
            check_place(path)
            changed = self._changed
            same = path.resolve() == self.path.resolve()  # where the file was removed from
            lock = journal.lock if same and journal.lock.stands else _locked(path)
            moved = Event(len(self.state.history) + 1, now(), "moved", {"from": self.path.name})
            events = (*self.state.history, moved)
            try:
                check_place(path)
                found = self._writer.call(lambda: journal.move(path, lock, events, changed))
            except BaseException:
                if lock is not journal.lock:
                    lock.release()
                raise
            self.path, self.state = path, found.state
            self.warnings = (*place_warnings(path), *found.told)
            self._changed = True

    def close(self, *, discard: bool = False) -> None:
        """Close it; one plain file is left.

        Raises StorageError, and leaves it open, where something is held that
        cannot be written; discard: close it without that.
        """
        with self._doing:
            if self._closed:
                return
            journal = self._journal
            if journal is not None:
                self._finish(journal, discard)
                why = self._writer.call(journal.close)
                self._writer.stop()
                if why is not None:
                    self.warnings += (_not_plain(self.path, why),)
            self._closed = True

    def _finish(self, journal: Journal, discard: bool) -> None:
        """Write all that waits, and that the session was closed."""
        try:
            for stream in self._streams:
                stream.close()
            self._writer.call(journal.flush)
            if self._changed:
                frames = self._frames(journal)
                self._accept("closed", {"frames": frames})
        except SessionError:
            if not discard:
                raise

    def _frames(self, journal: Journal) -> int:
        return sum(self._writer.call(journal.sizes).values())

    def _accept(
        self, action: str, detail: Mapping[str, object], chunks: tuple[Chunk, ...] = ()
    ) -> Event:
        """Make an event of an action, and write it after the note that the file was opened."""
        with self._doing:
            journal = self._writable()
            actions = [(action, decode_detail(encode_detail(detail)))]
            if not self._changed and action != "recovered":
                actions.insert(0, ("opened", {}))
            state, new = self.state, list[Event]()
            for name, values in actions:
                event = Event(len(state.history) + 1, now(), name, values)
                state = advance(state, event, self.path.name)
                new.append(event)
            self._next_part += action in ("pose", "pass", "stream")
            self._changed = True
            try:
                self._writer.call(lambda: journal.write(Batch(tuple(new), chunks)))
            finally:
                self.state = state
            return new[-1]

    def _writable(self) -> Journal:
        if self._closed:
            raise SessionError(f"{self.path.name}: the session is closed; open it again")
        if self._journal is None:
            why = "; ".join(self.warnings) or f"{self.path.name} was opened read only"
            raise SessionError(f"{why}: nothing can be changed in it")
        return self._journal

    def _columns(self) -> tuple[str, ...]:
        if self.state.ribbon is None:
            raise SessionError(f"{self.path.name}: no ribbon is known yet; connect it first")
        return self.state.ribbon.columns

    def _tell(self, sentence: str | None) -> None:
        for callback in self._callbacks:
            try:
                callback(sentence)
            except Exception:  # what was accepted is more than who is told of it
                threading.excepthook(
                    threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread()))
                )


def _locked(path: Path) -> Lock:
    """The right to write; SessionError where the folder gives none."""
    try:
        return Lock(path)
    except OSError as error:
        if os.path.lexists(lock_file(path)):
            raise SessionError(not_lockable(path, error)) from error
        raise SessionError(
            f"{path}: it cannot be written ({error.strerror or error}); choose a place where you "
            "may write"
        ) from error


def _not_writable(path: Path, one_name: bool) -> str | None:
    """Why a session must not be written to, in words; None where it may be."""
    if not os.access(path, os.W_OK):
        return f"{path.name}: the file may not be written; see to its rights"
    if one_name and path.stat().st_nlink > 1:
        return (
            f"{path.name}: the file has a second name (a hard link), by which another program "
            "could write to it at the same time; make a copy and open that"
        )
    return None


def _left(path: Path) -> tuple[str, ...]:
    """A warning where the log of a session was left behind."""
    left = left_log(path)
    return () if left is None else (f"{path.name}: {left}",)


def _not_plain(path: Path, why: str) -> str:
    return (
        f"{path.name}: {why}, so that its log stays beside it; keep the files together, or open "
        "and close it once more"
    )
