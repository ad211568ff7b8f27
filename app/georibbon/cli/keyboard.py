"""Lines from standard input as they come, and on a terminal single keys, without a wait.

On a terminal the keys are taken one by one, so that what is typed can be shown
beside a line that is drawn over and over, and so that one key is enough to
take: the space bar, Return or Page Down (which foot pedals send).
"""

import os
import queue
import re
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from types import ModuleType

try:
    import termios
except ImportError:  # a system without them: lines are taken as the terminal gives them
    termios = None  # type: ignore[assignment] # a module or nothing

MOST_READ = 65536  # bytes of one line
TAKING = (b" ", b"\x1b[6~")  # at the start of a line: the space bar, Page Down
_ERASE = (0x7F, 0x08)
_CLEAR = 0x15  # Ctrl-U
_END = 0x04  # Ctrl-D


class Words:
    """Lines from standard input.

    Read from the descriptor itself by a thread of its own: a thread that waits
    in Python's buffered input would keep the program from ending.  ended: no
    more will come.  on_keys: whether single keys come, from a terminal.
    """

    def __init__(self) -> None:
        self.ended = self.on_keys = False
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._rest = self._escape = b""
        self._restore: Callable[[], None] | None = None

    @property
    def typed(self) -> str:
        """What was typed of a line that is not ended yet, on a terminal."""
        return self._rest.decode(errors="replace") if self.on_keys else ""

    def start(self) -> None:
        """Begin to listen; without a standard input there are no words."""
        try:
            descriptor = sys.stdin.fileno()
        except (AttributeError, OSError, ValueError):
            self.ended = True
            return
        if termios is not None and sys.stdin.isatty() and sys.stdout.isatty():
            self._restore = key_by_key(termios, descriptor)
            self.on_keys = True
        threading.Thread(
            target=self._listen, args=(descriptor,), name="georibbon words", daemon=True
        ).start()

    def stop(self) -> None:
        """Give the terminal back as it was."""
        if self._restore is not None:
            with suppress(OSError, termios.error):  # a terminal that is gone needs nothing back
                self._restore()
            self._restore = None

    def take(self) -> list[str]:
        """The lines that came since the last time."""
        found = []
        while not self._lines.empty():
            found.append(self._lines.get())
        return found

    def feed(self, data: bytes) -> None:
        """Bytes of the input, as they came."""
        if not self.on_keys:
            self._key(data)
            return
        keys, self._escape = keys_of(self._escape + data)
        for key in keys:
            self._key(key)

    def _listen(self, descriptor: int) -> None:
        data = b"."
        while data and not self.ended:
            try:
                data = os.read(descriptor, MOST_READ)
            except OSError:
                data = b""
            self.feed(data)
        if self._rest and not self.on_keys:
            self._end_line()
        self.ended = True

    def _key(self, key: bytes) -> None:
        """Some bytes of a line; on a terminal one key."""
        if self.on_keys:
            if key in TAKING and not self._rest:
                self._end_line()
                return
            if key[:1] == b"\x1b":
                return
            if len(key) == 1 and self._edited(key[0]):
                return
            key = key.replace(b"\r", b"\n")
        *lines, self._rest = (self._rest + key).split(b"\n")
        self._rest = self._rest[:MOST_READ]
        for line in lines:
            self._lines.put(line.decode(errors="replace"))

    def _edited(self, key: int) -> bool:
        """Whether the key mends the line, rather than being a part of it."""
        if key in _ERASE:
            self._rest = self._rest.decode(errors="ignore")[:-1].encode()
        elif key == _CLEAR:
            self._rest = b""
        elif key == _END and not self._rest:
            self._lines.put("quit")
        return key in _ERASE or key in (_CLEAR, _END)

    def _end_line(self) -> None:
        self._lines.put(self._rest.decode(errors="replace"))
        self._rest = b""


_KEY = re.compile(rb"\x1b\[[0-?]*[ -/]*[@-~]|\x1bO[ -~]|[^\x1b]|\x1b(?![\[O])", re.DOTALL)
_LONGEST_ESCAPE = 32


def keys_of(data: bytes) -> tuple[list[bytes], bytes]:
    """The bytes key by key, and an escape sequence at their end that is not whole yet.

    An escape sequence, such as Page Down's, is one key.
    """
    keys: list[bytes] = []
    at = 0
    while at < len(data):
        found = _KEY.match(data, at)
        if found is None or (found.group() == b"\x1b" and found.end() == len(data)):
            if len(data) - at <= _LONGEST_ESCAPE:
                return keys, data[at:]
            found = None
        keys.append(found.group() if found else data[at : at + 1])
        at += len(keys[-1])
    return keys, b""


def key_by_key(terminal: ModuleType, descriptor: int) -> Callable[[], None]:
    """Have a terminal give every key at once and unseen; what gives it back as it was."""
    before = terminal.tcgetattr(descriptor)
    now = terminal.tcgetattr(descriptor)
    now[3] &= ~(terminal.ICANON | terminal.ECHO)
    terminal.tcsetattr(descriptor, terminal.TCSADRAIN, now)
    return lambda: terminal.tcsetattr(descriptor, terminal.TCSADRAIN, before)
