"""Work beside the window that says what came of it in a sentence."""

from collections.abc import Callable

from PySide6.QtCore import QObject, QRunnable, Qt, QThreadPool, Signal, Slot

from georibbon.errors import GeoribbonError


class _Job(QRunnable):
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


class _Relay(QObject):
    """Takes results to the main thread; a job can tell it also when who asked is gone."""

    finished = Signal(int, object, object)


class Worker(QObject):
    """One job at a time; of those that wait the newest alone is done.

    done(result), failed(sentence): what a person can mend.  fault(exception):
    what is ours.
    """

    done = Signal(object)
    failed = Signal(str)
    fault = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._pool = QThreadPool()
        self._pool.setMaxThreadCount(1)
        self._running = 0  # the number of what is done now, and wanted
        self._number = 0
        self._ended = False
        self._waiting: Callable[[], object] | None = None
        self._relay = _Relay()
        self._relay.finished.connect(self._deliver, Qt.ConnectionType.QueuedConnection)
        self.destroyed.connect(self._pool.waitForDone)

    @property
    def is_busy(self) -> bool:
        """Whether something is being done that is wanted."""
        return bool(self._running)

    def ask(self, work: Callable[[], object]) -> None:
        """Have work done, after what is done now and in the place of what waits."""
        if self._ended:
            return
        if self._running:
            self._waiting = work
            return
        self._number += 1
        self._running = self._number
        self._pool.start(_Job(self._number, work, self._relay.finished.emit))

    def forget(self) -> None:
        """Deliver nothing of what was asked for so far."""
        self._running, self._waiting = 0, None

    def end(self) -> None:
        """Wait for what is being done, and deliver nothing of it; nothing is done after it."""
        self._ended = True
        self.forget()
        self._pool.waitForDone()

    @Slot(int, object, object)
    def _deliver(self, number: int, result: object, error: Exception | None) -> None:
        if number != self._running:
            return
        self._running = 0
        waits, self._waiting = self._waiting, None
        if waits is not None:
            self.ask(waits)
        if error is None:
            self.done.emit(result)
        elif isinstance(error, GeoribbonError):
            self.failed.emit(str(error))
        elif isinstance(error, OSError) and error.strerror:
            self.failed.emit(f"{error.filename or 'a file'}: {error.strerror}")
        else:
            self.fault.emit(error)
