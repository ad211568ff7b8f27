"""The one thread that writes a session."""

import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TypeVar, cast

from georibbon.errors import SessionError

INTERVAL = 0.2  # seconds between transactions of a stream
AFTER_FAULT = 2.0
T = TypeVar("T")


class Writer:
    """Runs what it is given, in order, and a tick soon after each poke.

    A tick that asked to run again later is hurried by a poke without delay alone.

    tick: returns the seconds after which it wants to run again, or None.
    """

    def __init__(self, tick: Callable[[], float | None]) -> None:
        self._tick = tick
        self._changed = threading.Condition()
        self._calls: deque[_Call] = deque()
        self._due: float | None = None
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="session-writer", daemon=True)
        self._thread.start()

    def call(self, function: Callable[[], T]) -> T:
        """What a function returns, or raises, on the writer's thread.

        Raises SessionError where that has ended.
        """
        if threading.current_thread() is self._thread:
            return function()
        call = _Call(function)
        with self._changed:
            if self._stopping:
                raise SessionError("the session is closed; open it again")
            self._calls.append(call)
            self._changed.notify()
        call.done.wait()
        if call.error is not None:
            raise call.error
        return cast("T", call.result)

    def poke(self, seconds: float = INTERVAL) -> None:
        """Ask for a tick after so many seconds at the latest; never waits for it."""
        due = time.monotonic() + seconds
        with self._changed:
            if self._due is None or (not seconds and due < self._due):
                self._due = due
                self._changed.notify()

    def stop(self) -> None:
        """End the thread when what it was given is done."""
        with self._changed:
            self._stopping = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while True:
            call, ticking = self._next()
            if call is not None:
                call.run()
            elif ticking:
                self._again(self._ticked())
            else:
                return

    def _ticked(self) -> float | None:
        """A tick; a fault of the program is shown and does not end the writing."""
        try:
            return self._tick()
        except Exception:
            threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), self._thread)))
            return AFTER_FAULT

    def _again(self, seconds: float | None) -> None:
        """Have the next tick after so many seconds, where none was asked for meanwhile."""
        with self._changed:
            if seconds is not None and self._due is None:
                self._due = time.monotonic() + seconds

    def _next(self) -> tuple["_Call | None", bool]:
        """The next call; or whether a tick is due; or neither, at the end."""
        with self._changed:
            while True:
                rest = None if self._due is None else self._due - time.monotonic()
                if rest is not None and rest <= 0.0:
                    self._due = None  # a poke from now on asks for another tick
                    return None, True
                if self._calls:
                    return self._calls.popleft(), False
                if self._stopping:
                    return None, False
                self._changed.wait(rest)


class _Call:
    """A function to run, and what came of it."""

    def __init__(self, function: Callable[[], object]) -> None:
        self._function = function
        self.done = threading.Event()
        self.result: object = None
        self.error: BaseException | None = None

    def run(self) -> None:
        """Run it; what it raises goes to who asked."""
        try:
            self.result = self._function()
        except BaseException as error:
            self.error = error
        finally:
            self.done.set()
