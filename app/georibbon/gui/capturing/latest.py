"""Work off the main thread of which only the newest is wanted."""

import threading
from collections.abc import Callable
from contextlib import suppress

from PySide6.QtCore import QObject, Qt, Signal, Slot

Stop = Callable[[], bool]
Work = Callable[[Stop], object]


class Latest(QObject):
    """One piece of work at a time in a thread of its own; what is asked for later takes its place.

    done(result): of the newest.  failed(exception): it raised.  Both on the main
    thread.  Work is given a function that says whether it is still wanted.
    """

    done = Signal(object)
    failed = Signal(object)
    _finished = Signal(int, object, object)

    def __init__(self, name: str, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._name = name
        self._number = 0
        self._running = False
        self._waiting: Work | None = None
        self._finished.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    @property
    def busy(self) -> bool:
        """Whether a result is to come."""
        return self._running

    def ask(self, work: Work) -> None:
        """Have work done; what was asked for before is not wanted any more."""
        self._number += 1
        self._waiting = work
        if not self._running:
            self._start()

    def drop(self) -> None:
        """Nothing is wanted any more."""
        self._number += 1
        self._waiting = None

    def _start(self) -> None:
        work, self._waiting = self._waiting, None
        if work is None:
            return
        self._running = True
        number = self._number

        def run() -> None:
            result, error = None, None
            try:
                result = work(lambda: number != self._number)
            except Exception as raised:
                error = raised
            with suppress(RuntimeError):  # the window is gone meanwhile
                self._finished.emit(number, result, error)

        threading.Thread(target=run, name=self._name, daemon=True).start()

    @Slot(int, object, object)
    def _deliver(self, number: int, result: object, error: Exception | None) -> None:
        self._running = False
        if number == self._number:
            if error is None:
                self.done.emit(result)
            else:
                self.failed.emit(error)
        self._start()
