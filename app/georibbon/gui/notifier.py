"""Whatever a person must be told, from wherever it comes: one place, without Qt underneath."""

import datetime
import sys
import threading
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Literal

from georibbon.errors import GeoribbonError
from georibbon.gui.language import sentence, tr

Level = Literal["info", "warning", "error", "fault"]
MOST_KEPT = 2000


@dataclass(frozen=True)
class Entry:
    """One thing that was told.

    fault: of the program, not of what a person did; detail: where it arose.
    """

    level: Level
    text: str
    detail: str = ""
    time: datetime.datetime = field(default_factory=lambda: datetime.datetime.now().astimezone())


class Notifier:
    """Keeps what is told and tells it on to all that listen, on the thread that told it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._entries: list[Entry] = []
        self._listeners: list[Callable[[Entry], None]] = []
        self._hooks: tuple[Any, ...] | None = None

    @property
    def entries(self) -> tuple[Entry, ...]:
        """What was told, the newest last."""
        with self._lock:
            return tuple(self._entries)

    def listen(self, listener: Callable[[Entry], None]) -> None:
        """Have everything that comes told."""
        self._listeners.append(listener)

    def leave(self, listener: Callable[[Entry], None]) -> None:
        """Have no more told."""
        with suppress(ValueError):
            self._listeners.remove(listener)

    def tell(self, level: Level, text: str, detail: str = "") -> None:
        """Tell something."""
        entry = Entry(level, sentence(text), detail)
        with self._lock:
            self._entries.append(entry)
            del self._entries[:-MOST_KEPT]
        for listener in tuple(self._listeners):
            listener(entry)

    def exception(self, error: BaseException) -> None:
        """Tell of an exception: an error that a person can mend, or a fault of the program."""
        detail = "".join(traceback.format_exception(error))
        if isinstance(error, GeoribbonError):
            self.tell("error", str(error), detail)
            return
        name = type(error).__name__
        self.tell(
            "fault",
            tr(
                "a fault of the program, not of your input: {name}: {error}; what is captured is "
                "safe in its file; please report it with the details in the log",
                name=name,
                error=error,
            ),
            detail,
        )

    def install(self) -> None:
        """Catch what nobody else does: in the main thread, in threads, and warnings."""
        self._hooks = (
            sys.excepthook, threading.excepthook, sys.unraisablehook, warnings.showwarning
        )  # fmt: skip
        sys.excepthook = lambda _type, error, _traceback: self._uncaught(error)
        sys.unraisablehook = self._unraisable
        threading.excepthook = lambda found: found.exc_value and self._uncaught(found.exc_value)
        warnings.showwarning = self._warned

    def uninstall(self) -> None:
        """As it was before `install`."""
        if self._hooks is not None:
            sys.excepthook, threading.excepthook = self._hooks[:2]
            sys.unraisablehook, warnings.showwarning = self._hooks[2:]
            self._hooks = None

    def _uncaught(self, error: BaseException) -> None:
        if isinstance(error, KeyboardInterrupt):
            sys.__excepthook__(type(error), error, error.__traceback__)
            return
        self.exception(error)
        with suppress(OSError, ValueError, AttributeError):  # there may be no standard error
            traceback.print_exception(error, file=sys.stderr)

    def _unraisable(self, found: Any) -> None:
        """What arose where nothing can be raised, as when something is let go of."""
        if found.exc_value is None:
            return
        where = "".join(traceback.format_exception(found.exc_value))
        self.tell("warning", f"{found.err_msg or ''} {found.exc_value!r}".strip(), where)

    def _warned(
        self,
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: object = None,
        line: str | None = None,
    ) -> None:
        where = warnings.formatwarning(message, category, filename, lineno, line)
        self.tell("warning", str(message), where)
