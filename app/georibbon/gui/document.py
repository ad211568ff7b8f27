"""The document: what is open, what was changed in it, and the surface of it.

Views read it and send it what a person wants; none knows another.  Reading and
reconstructing run in one worker thread, one job at a time; while one runs, the
newest of those that are asked for waits and the others are dropped.  Results
come on the main thread.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QCoreApplication, QObject, QRunnable, Qt, QThreadPool, Signal, Slot

from georibbon.errors import GeoribbonError, StorageError

if TYPE_CHECKING:
    from georibbon.gui.sources import Opened, PassEntry
    from georibbon.reconstruction import Reconstruction, Stages
    from georibbon.session.session import Session

EVERY_PASS = "*"
LEAST_PASSES = 2  # that span a surface
DEMONSTRATION = "car bonnet.georibbon"


class _Job(QRunnable):
    """Work in the worker thread; `done` is told the result, or the exception, with its number."""

    def __init__(self, number: int, work: Callable[[], object], done: Callable[..., None]) -> None:
        super().__init__()
        self._number, self._work, self._done = number, work, done

    def run(self) -> None:
        """Called by Qt in the worker thread; nothing may be raised from here."""
        try:
            result, error = self._work(), None
        except Exception as raised:
            result, error = None, raised
        self._done(self._number, result, error)


class Document(QObject):
    """One session or recording folder, its settings and its reconstruction.

    changed(what): "source" where another one is open or none is; "passes" where a
    capture has changed what it holds; "settings" where a setting or what can be
    undone has changed.  reconstructed(result).  failed(sentence): what a person
    can mend.  not_yet(sentence): why what is captured so far gives no surface.
    fault(exception): what is ours.  told(sentence): what a person must know.
    busy(whether, words).
    """

    changed = Signal(str)
    reconstructed = Signal(object)
    failed = Signal(str)
    not_yet = Signal(str)
    fault = Signal(object)
    told = Signal(str)
    busy = Signal(bool, str)
    _finished = Signal(int, object, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._source: Opened | None = None
        self._stages: list[Stages] = []  # one, as soon as there is any
        self._result: Reconstruction | None = None
        self._preview: dict[str, float | None] = {}
        self._pool = QThreadPool()
        self._pool.setMaxThreadCount(1)
        self._running: tuple[int, Callable[..., None]] | None = None
        self._waiting: tuple[Callable[[], object], Callable[..., None], str] | None = None
        self._number = 0
        self._ended = False
        self._failure: str | None = None
        self.capturing = False  # what cannot be reconstructed yet is no failure then
        self._finished.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    @property
    def path(self) -> Path | None:
        """Where what is open lies."""
        return None if self._source is None else self._source.path

    @property
    def title(self) -> str | None:
        """What is open is called, or its file's name."""
        source = self._source
        return None if source is None else source.title or source.path.name

    @property
    def keeps(self) -> bool:
        """Whether what is changed is written into the file."""
        return self._source is not None and self._source.keeps

    @property
    def session(self) -> Session | None:
        """The session that is open, where it can be written to."""
        return self._source.session if self._source is not None and self._source.keeps else None

    @property
    def passes(self) -> tuple[PassEntry, ...]:
        """The passes and ties in their order."""
        return () if self._source is None else self._source.passes

    @property
    def reconstruction(self) -> Reconstruction | None:
        """The newest result of what is open."""
        return self._result

    @property
    def smoothing(self) -> Mapping[str, float]:
        """Metres, by the pass's name or "*" for all others; what is missing is automatic."""
        if self._source is None:
            return {}
        from georibbon.gui.sources import changed

        try:
            kept = self._source.smoothing
        except GeoribbonError as error:  # a session of another program's making
            self.failed.emit(str(error))
            kept = {}
        return changed(kept, self._preview)

    @property
    def undoable(self) -> str | None:
        """What `undo` would take back, in words."""
        return None if self._source is None else self._source.undoable

    @property
    def redoable(self) -> str | None:
        """What `redo` would do again, in words."""
        return None if self._source is None else self._source.redoable

    @property
    def failure(self) -> str | None:
        """Why what is open cannot be reconstructed as it is now; None where it can."""
        return self._failure

    @property
    def is_busy(self) -> bool:
        """Whether something is being read or reconstructed."""
        return self._running is not None

    def open(self, path: Path) -> None:
        """Open a recording folder or a session in the place of what is open."""

        def work() -> Opened:
            from georibbon.gui.sources import open_source

            return open_source(path)

        here = self.path
        same = here is not None and here.resolve() == path.resolve()
        if same and not self._replace(None):  # it is written by one at a time, be it ourselves
            return
        self._ask(work, self._opened, f"reading {path.name}")

    def import_folder(self, folder: Path, target: Path) -> None:
        """Put a recording folder into a new session file, and open that."""

        def work() -> Opened:
            from georibbon.gui.sources import open_source
            from georibbon.session.file import check_place, create_session
            from georibbon.session.folder import read_recording

            check_place(target)
            create_session(target, read_recording(folder))
            return open_source(target)

        self._ask(work, self._opened, f"importing {folder.name}")

    def open_demonstration(self, folder: Path) -> None:
        """Open the demonstration's session in a folder; it is captured there the first time."""

        def work() -> Opened:
            from georibbon.gui.sources import open_source

            path = folder / DEMONSTRATION
            if not path.exists():
                from georibbon.session.file import create_session
                from georibbon.simulation import simulate
                from georibbon.simulation.demonstration import demonstration_settings

                folder.mkdir(parents=True, exist_ok=True)
                create_session(path, simulate(demonstration_settings()).recording)
            return open_source(path)

        if self.path == folder / DEMONSTRATION and not self._replace(None):
            return
        self._ask(work, self._opened, "capturing the virtual car bonnet")

    def adopt(self, session: Session) -> bool:
        """Have a session in the place of what is open; False, and nothing done, where that cannot
        be closed.
        """
        from georibbon.gui.sources import OpenedSession

        self._waiting = self._running = None
        self.busy.emit(False, "")
        source = OpenedSession(session)
        if not self._replace(source):
            return False
        for sentence in source.told:
            self.told.emit(sentence)
        return True

    def captured(self) -> None:
        """A capture has changed what the session holds: the reconstruction follows."""
        if self._source is None:
            return
        enough = sum(one.kind == "pass" for one in self.passes) >= LEAST_PASSES
        if not enough:
            self._result = None
        self.changed.emit("passes")
        if enough:
            self.reconstruct()

    def close(self, *, discard: bool = False) -> bool:
        """Let go of what is open; whether that could be done.

        It stays open where something of it cannot be written, unless that is to
        be discarded.  What is running ends by itself and is not delivered.
        """
        self._waiting = None
        self._running = None
        closed = self._replace(None, discard)
        self.busy.emit(False, "")
        return closed

    def end(self) -> None:
        """Close and wait for the worker; nothing is done after it."""
        self._ended = True
        self.close(discard=True)
        self._pool.waitForDone()
        QCoreApplication.sendPostedEvents(self)  # what was opened meanwhile is let go

    def preview_smoothing(self, name: str, metres: float | None) -> None:
        """Show a smoothing while a slider moves; nothing is kept of it."""
        if self._source is not None:
            self._preview[name] = metres
            self.reconstruct()

    def set_smoothing(self, name: str, metres: float | None) -> None:
        """Smooth a pass, or "*" for all others, by so many metres; None: automatically."""
        self._smooth({name: metres})

    def reset_smoothing(self) -> None:
        """All passes automatically, in one step of undo."""
        if self._source is not None:
            self._preview.clear()
            self._smooth(dict.fromkeys(self.smoothing))

    def _smooth(self, changes: Mapping[str, float | None]) -> None:
        source = self._source
        if source is None:
            return
        self._preview.clear()
        now = self.smoothing
        changes = {name: value for name, value in changes.items() if now.get(name) != value}
        if changes:
            self._do(lambda: source.smooth(changes))
        else:
            self.reconstruct()  # what was shown while the slider moved

    def undo(self) -> str | None:
        """Take the last step back; in words what it was."""
        source = self._source
        return None if source is None or source.undoable is None else self._do(source.undo)

    def redo(self) -> str | None:
        """Do again what was undone last; in words what it was."""
        source = self._source
        return None if source is None or source.redoable is None else self._do(source.redo)

    def _do(self, act: Callable[[], str | None]) -> str | None:
        self._preview.clear()
        words = None
        try:
            words = act()
        except StorageError as error:  # it is done, and held in memory
            self.failed.emit(str(error))
        except GeoribbonError as error:
            self.failed.emit(str(error))
            return None
        self.changed.emit("settings")
        self.reconstruct()
        return words

    def reconstruct(self) -> None:
        """Bring the reconstruction up to date, refitting what has changed."""
        source = self._source
        if source is None:
            return
        smoothing, held = dict(self.smoothing), self._stages

        def work() -> Reconstruction:
            from georibbon.reconstruction import ReconstructionSettings, Stages, reconstruct

            if not held:
                held.append(Stages())
            recording = source.recording()
            there = {EVERY_PASS, *(one.name for one in recording.passes)}
            settings = ReconstructionSettings(
                smoothing={name: value for name, value in smoothing.items() if name in there}
            )
            return reconstruct(recording, settings, source.calibration, held[0])

        self._ask(work, partial(self._reconstructed, source), "reconstructing")

    def _ask(self, work: Callable[[], object], then: Callable[..., None], words: str) -> None:
        """Have work done; `then` gets its result on the main thread."""
        if self._ended:
            return
        if self._running is not None:
            waits = self._waiting
            # A reconstruction of what is open now must not take the place of another to be opened.
            if waits is None or then == self._opened or waits[1] != self._opened:
                self._waiting = (work, then, words)
            return
        self._number += 1
        self._running = (self._number, then)
        self.busy.emit(True, words)
        self._pool.start(_Job(self._number, work, self._finished.emit))

    @Slot(int, object, object)
    def _deliver(self, number: int, result: object, error: Exception | None) -> None:
        if self._running is None or self._running[0] != number:
            self._drop(result)
            return
        then = self._running[1]
        self._running = None
        opening = self._waiting is not None and self._waiting[1] == self._opened
        if opening:  # another is to be opened: what came of this one is not wanted
            self._drop(result)
        elif isinstance(error, GeoribbonError):
            self._failure = str(error) if then != self._opened else self._failure
            quietly = self.capturing and then != self._opened
            (self.not_yet if quietly else self.failed).emit(str(error))
        elif isinstance(error, OSError) and error.strerror:
            self.failed.emit(f"{error.filename or 'a file'}: {error.strerror}")
        elif error is not None:
            self.fault.emit(error)
        else:
            then(result)
        self._next()

    def _next(self) -> None:
        if self._waiting is not None and self._running is None:
            waits, self._waiting = self._waiting, None
            self._ask(*waits)
        if self._running is None:
            self.busy.emit(False, "")

    def _drop(self, result: object) -> None:
        """Let go of a source that was opened for nobody."""
        from georibbon.gui.sources import OpenedRecording, OpenedSession, ReadOnlySession

        if isinstance(result, OpenedRecording | OpenedSession | ReadOnlySession):
            result.close(discard=True)

    def _opened(self, source: Opened) -> None:
        if not self._replace(source):
            self._drop(source)
            return
        for sentence in source.told:
            self.told.emit(sentence)
        self.reconstruct()

    def _reconstructed(self, source: Opened, result: Reconstruction) -> None:
        if source is self._source:
            self._result, self._failure = result, None
            self.reconstructed.emit(result)

    def _replace(self, source: Opened | None, discard: bool = False) -> bool:
        """Close what is open, and have another in its place; not where that cannot be written."""
        old = self._source
        if old is not None:
            self._pool.waitForDone()  # it may be read from
            try:
                old.close(discard)
            except StorageError as error:
                self.failed.emit(str(error))
                return False
        self._source = source
        self._stages, self._result, self._failure = [], None, None
        self._preview.clear()
        if self._waiting is not None and self._waiting[1] != self._opened:
            self._waiting = None
        if old is not source:
            self.changed.emit("source")
        return True
