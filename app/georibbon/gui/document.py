"""The document: what is open, what was changed in it, and the surface of it.

Views read it and send it what a person wants; none knows another.  Reading and
reconstructing run in one worker thread, one job at a time; while one runs, the
newest of those that are asked for waits and the others are dropped.  Results
come on the main thread.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import (
    QCoreApplication,
    QObject,
    QRunnable,
    Qt,
    QThreadPool,
    QTimer,
    Signal,
    Slot,
)

from georibbon.errors import GeoribbonError, RecordingError, StorageError
from georibbon.gui.language import tr

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.fitting.settings import ReconstructionSettings
    from georibbon.gui.sources import Changes, Opened, PassEntry
    from georibbon.reconstruction import Reconstruction, Stages
    from georibbon.recording import Recording
    from georibbon.session.session import Session
    from georibbon.session.state import SessionState

EVERY_PASS = "*"
LEAST_PASSES = 2  # that span a surface
SMOOTHING = "smoothing"
PAUSE_MS = 300  # after which what is shown while a slider is held is done wholly
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
    undone has changed.  reconstructed(result).  previewed(result): about what it
    will be, while a slider moves: the curves and the surface's vertices, all else
    as it was.  failed(sentence): what a person can mend.  not_yet(sentence): why
    what is captured so far gives no surface.  fault(exception): what is ours.
    told(sentence): what a person must know.  busy(whether, words).
    """

    changed = Signal(str)
    reconstructed = Signal(object)
    previewed = Signal(object)
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
        self._recording: Recording | None = None
        self._preview: dict[tuple[str, str], object] = {}
        self._pause = QTimer(self)
        self._pause.setSingleShot(True)
        self._pause.setInterval(PAUSE_MS)
        self._pause.timeout.connect(self.reconstruct)
        self._told: set[str] = set()
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
    def recording(self) -> Recording | None:
        """What the newest result was made from; None before there is one."""
        return self._recording

    def captured_so_far(self) -> Callable[[], Recording]:
        """What gives all that is captured, also where it makes no surface; for a worker."""
        session = getattr(self._source, "session", None)
        if session is not None:
            return partial(session.recording, complete=False)
        if self._source is None:
            raise RecordingError(tr("nothing is open"))
        return self._source.recording

    @property
    def values(self) -> Mapping[tuple[str, str], object]:
        """What is chosen, as a session keeps it, by whose and key; previews counted in."""
        if self._source is None:
            return {}
        from georibbon.gui.sources import changed

        return changed(self._source.values, self._preview)

    @property
    def settings(self) -> ReconstructionSettings:
        """What is chosen, previews counted in; what means nothing is as where nothing is chosen."""
        from georibbon.session.settings import sound_settings

        settings, wrong = sound_settings(self.values, [one.name for one in self.passes])
        for sentence in wrong:  # a session of another program's making
            if sentence not in self._told:
                self._told.add(sentence)
                self.failed.emit(sentence)
        return settings

    @property
    def smoothing(self) -> Mapping[str, float]:
        """Metres, by the pass's name or "*" for all others; what is missing is automatic."""
        return {} if self._source is None else self.settings.smoothing

    @property
    def undoable(self) -> str | None:
        """What `undo` would take back, in words."""
        return None if self._source is None else self._source.undoable

    @property
    def redoable(self) -> str | None:
        """What `redo` would do again, in words."""
        return None if self._source is None else self._source.redoable

    @property
    def is_behind(self) -> bool:
        """Whether what is told now was begun before the last change: a newer result follows."""
        return self._waiting is not None

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
        self._ask(work, self._opened, tr("reading {name}", name=path.name))

    def import_folder(self, folder: Path, target: Path) -> None:
        """Put a recording folder into a new session file, and open that."""

        def work() -> Opened:
            from georibbon.gui.sources import open_source
            from georibbon.session.file import check_place, create_session
            from georibbon.session.folder import read_recording

            check_place(target)
            create_session(target, read_recording(folder))
            return open_source(target)

        self._ask(work, self._opened, tr("importing {name}", name=folder.name))

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
        self._ask(work, self._opened, tr("capturing the virtual car bonnet"))

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
            self._result = self._recording = self._failure = None
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

    def preview_setting(self, whose: str, key: str, value: object) -> None:
        """Show a setting of a pass, or of "*", while a slider moves; nothing is kept of it."""
        if self._source is None:
            return
        self._preview[whose, key] = value
        self._pause.start()
        self._work(_previewing, self._previewed, "")

    def set_setting(self, whose: str, key: str, value: object) -> bool:
        """Choose a setting of a pass, or of "*"; None takes it back.

        The keys and values are those of `georibbon.session.settings`.  Whether
        it means anything; if not, `failed` says why, and nothing is changed.
        """
        return self.set_settings({(whose, key): value})

    def set_settings(self, changes: Changes) -> bool:
        """Choose several settings in one step of undo, as `set_setting` does one."""
        source = self._source
        if source is None:
            return False
        from georibbon.fitting.settings import ReconstructionSettings
        from georibbon.session.settings import with_setting

        self._end_preview()
        try:
            for (whose, key), value in changes.items():
                with_setting(ReconstructionSettings(), whose, key, value)
        except GeoribbonError as error:
            self.failed.emit(str(error))
            self.reconstruct()
            return False
        now = source.values
        new = {place: _kept(value) for place, value in changes.items()}
        new = {place: value for place, value in new.items() if now.get(place) != value}
        if new:
            self._do(lambda: source.change(new))
        else:
            self.reconstruct()  # what was shown while the slider moved
        return True

    def reset_settings(self, keys: Collection[str] | None = None, whose: str | None = None) -> None:
        """Take settings back in one step of undo: those of some keys, of one pass, or all."""
        from georibbon.session.settings import KEYS  # others are another program's

        self.set_settings(
            {
                (of, key): None
                for of, key in ({} if self._source is None else self._source.values)
                if key in (KEYS if keys is None else keys) and (whose is None or of == whose)
            }
        )

    def preview_smoothing(self, name: str, metres: float | None) -> None:
        """Show a smoothing while a slider moves; nothing is kept of it."""
        self.preview_setting(name, SMOOTHING, metres)

    def set_smoothing(self, name: str, metres: float | None) -> None:
        """Smooth a pass, or "*" for all others, by so many metres; None: automatically."""
        self.set_setting(name, SMOOTHING, metres)

    def reset_smoothing(self) -> None:
        """All passes automatically, in one step of undo."""
        self.reset_settings((SMOOTHING,))

    @property
    def state(self) -> SessionState | None:
        """What the session that is open holds; None where it is none."""
        return None if self._source is None else getattr(self._source, "state", None)

    def note(self, text: str, pass_name: str | None = None) -> bool:
        """Keep a note, perhaps of one pass; undone by name.  Whether it could be kept."""
        session = self.session
        if session is None:
            return False
        detail = {} if pass_name is None else {"pass": pass_name}
        try:
            session.do("note", text=text, **detail)
        except StorageError as error:  # it is held in memory
            self.failed.emit(str(error))
        except GeoribbonError as error:
            self.failed.emit(str(error))
            return False
        self.changed.emit("settings")
        return True

    @property
    def calibration(self) -> Calibration | None:
        """What stands in for the poses of what is open; None where they are used themselves."""
        return None if self._source is None else self._source.calibration

    @property
    def has_poses(self) -> bool:
        """Whether what is open holds calibration poses of its own."""
        return self._source is not None and self._source.has_poses

    def use_calibration(self, calibration: Calibration | None) -> None:
        """Have a calibration stand in for the poses, or the poses again; undone by name.

        A session keeps it; `failed` tells where it is of another ribbon.
        """
        source = self._source
        if source is not None:
            self._do(lambda: source.use_calibration(calibration))

    def _end_preview(self) -> None:
        self._preview.clear()
        self._pause.stop()

    def undo(self) -> str | None:
        """Take the last step back; in words what it was."""
        source = self._source
        return None if source is None or source.undoable is None else self._do(source.undo)

    def redo(self) -> str | None:
        """Do again what was undone last; in words what it was."""
        source = self._source
        return None if source is None or source.redoable is None else self._do(source.redo)

    def _do(self, act: Callable[[], str | None]) -> str | None:
        self._end_preview()
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
        self._work(_reconstructing, self._reconstructed, tr("reconstructing"))

    def _work(
        self,
        way: Callable[..., Reconstruction],
        then: Callable[[Opened, tuple[Recording, Reconstruction]], None],
        words: str,
    ) -> None:
        """Have the reconstruction done one way or the other with the settings of now."""
        source = self._source
        if source is None:
            return
        _ = self.settings  # tells what in them means nothing
        values, held = dict(self.values), self._stages

        def work() -> tuple[Recording, Reconstruction]:
            from georibbon.reconstruction import Stages
            from georibbon.session.settings import sound_settings

            if not held:
                held.append(Stages())
            recording = source.recording()
            settings, _ = sound_settings(values, [one.name for one in recording.passes])
            return recording, way(recording, settings, source.calibration, held[0])

        self._ask(work, partial(then, source), words)

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
        if words:
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

    def _reconstructed(self, source: Opened, found: tuple[Recording, Reconstruction]) -> None:
        if source is self._source:
            self._recording, self._result = found  # they belong together
            self._failure = None
            self.reconstructed.emit(self._result)

    def _previewed(self, source: Opened, found: tuple[Recording, Reconstruction]) -> None:
        if source is self._source and self._preview:
            self.previewed.emit(found[1])

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
        self._recording = None
        self._told.clear()
        self._end_preview()
        if self._waiting is not None and self._waiting[1] != self._opened:
            self._waiting = None
        if old is not source:
            self.changed.emit("source")
        return True


def _reconstructing(*inputs: Any) -> Reconstruction:
    from georibbon.reconstruction import reconstruct

    return reconstruct(*inputs)


def _previewing(*inputs: Any) -> Reconstruction:
    from georibbon.reconstruction_preview import preview

    return preview(*inputs)


def _kept(value: object) -> object:
    """A value as a session keeps it."""
    return list(value) if isinstance(value, tuple) else value
