"""Work beside the window, one job at a time; of those that wait the newest alone is done."""

from collections.abc import Callable
from contextlib import suppress

from PySide6.QtCore import QCoreApplication, QObject, QRunnable, Qt, QThreadPool, Signal, Slot


class _Job(QRunnable):
    def __init__(self, work: Callable[[], object], done: Callable[..., None]) -> None:
        super().__init__()
        self._work, self._done = work, done

    def run(self) -> None:
        """Called by Qt in the worker thread; nothing may be raised from here."""
        try:
            result, error = self._work(), None
        except Exception as raised:
            result, error = None, raised
        with suppress(RuntimeError):  # it may be gone that wanted to know
            self._done(result, error)


class Worker(QObject):
    """Does work in a thread.

    done(result, error): on the main thread; error: what it raised, or None.
    """

    done = Signal(object, object)
    _finished = Signal(object, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._pool = QThreadPool()
        self._pool.setMaxThreadCount(1)
        self._busy = self._ended = False
        self._waiting: Callable[[], object] | None = None
        self._unwanted = False
        self._finished.connect(self._deliver, Qt.ConnectionType.QueuedConnection)
        self.destroyed.connect(self._pool.waitForDone)

    @property
    def busy(self) -> bool:
        """Whether something is being done."""
        return self._busy

    def ask(self, work: Callable[[], object]) -> None:
        """Have work done, after what is being done now."""
        if self._busy:
            self._waiting = work
        elif not self._ended:
            self._busy = True
            self._pool.start(_Job(work, self._finished.emit))

    def forget(self) -> None:
        """Deliver nothing of what is asked for up to now."""
        self._waiting = None
        self._unwanted = self._busy

    def end(self) -> None:
        """Wait for what is being done, and deliver nothing more."""
        self._ended = True
        self.forget()
        self._pool.waitForDone()
        QCoreApplication.sendPostedEvents(self)

    @Slot(object, object)
    def _deliver(self, result: object, error: object) -> None:
        self._busy = False
        waits, self._waiting = self._waiting, None
        forgotten, self._unwanted = self._unwanted, False
        if waits is not None:
            self.ask(waits)
        if not forgotten:
            self.done.emit(result, error)
