"""One writer a session: a lock file beside it, which the kernel frees when its owner dies.

Who holds the lock is written in the file for people; that it is held is known
from the lock alone.
"""

import errno
import json
import os
import stat
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

from georibbon.errors import SessionError
from georibbon.session.events import now
from georibbon.session.words import told

ENDING = ".lock"
_TRIES = 5  # a reader that looks whether it is held holds it for a moment
_PAUSE = 0.02
_MOST = 1000
_BEGIN = b'{"process"'
# A link with the name of a lock file would lead to a file that is none; a pipe would wait.
_PLAIN = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
_here: list[Path] = []
_here_lock = threading.Lock()

if sys.platform == "win32":
    import msvcrt

    _FAR = 2**30  # beyond what is written: Windows lets nobody read locked bytes

    def _take(descriptor: int) -> None:
        os.lseek(descriptor, _FAR, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)

    _look = _take
else:
    import fcntl

    def _take(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _look(descriptor: int) -> None:
        """Fail where somebody has the lock; who else looks does not disturb."""
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)


class HeldError(SessionError):
    """Another program has the session open."""


class Lock:
    """The right to write to a session, from its making until `release`."""

    def __init__(self, path: Path) -> None:
        """Take the right; HeldError says who has it, OSError why no file can be locked there."""
        self.session = path.resolve()
        self._file = lock_file(path)
        self._descriptor = _acquired(self._file, path)
        self._held = True
        with suppress(OSError):  # on a full disk the lock holds all the same
            os.ftruncate(self._descriptor, 0)
            os.lseek(self._descriptor, 0, os.SEEK_SET)
            os.write(self._descriptor, _told_owner())
        with _here_lock:
            _here.append(self.session)

    @property
    def stands(self) -> bool:
        """Whether it locks: its file may have been removed, and another be made."""
        return _still(self._descriptor, self._file)

    def release(self) -> None:
        """Give the right back and remove the lock file; once is enough."""
        if not self._held:
            return
        self._held = False
        ours = self.stands
        with _here_lock:
            _here.remove(self.session)
        if sys.platform == "win32":
            os.close(self._descriptor)  # Windows removes no open file
            if ours:
                _remove(self._file)
        else:
            if ours:
                _remove(self._file)
            os.close(self._descriptor)


def lock_file(path: Path) -> Path:
    """The lock file of a session."""
    resolved = path.resolve()
    return resolved.with_name(resolved.name + ENDING)


def open_here(path: Path) -> bool:
    """Whether this process has the session open for writing.

    Then its file must not be opened but by SQLite: closing any other descriptor
    of it would drop SQLite's own locks.
    """
    with _here_lock:
        return path.resolve() in _here


def head(path: Path, count: int) -> bytes | None:
    """The first bytes of a session; None where this process has it open for writing.

    Raises OSError where it cannot be read.
    """
    with _here_lock:  # nothing here begins to write while the descriptor is open
        if path.resolve() in _here:
            return None
        with path.open("rb") as file:
            return file.read(count)


def holder(path: Path) -> str | None:
    """Who has a session open for writing, in words; None where nobody has."""
    file = lock_file(path)
    try:
        return _holder(file)
    except PermissionError:
        return f"another user's program, or one that was broken off ({file.name} tells no more),"


def _holder(file: Path) -> str | None:
    """Who has locked a file; PermissionError where that cannot even be looked at."""
    try:
        descriptor = _opened(file)
    except PermissionError:
        raise
    except OSError:
        return None
    try:
        _look(descriptor)
    except OSError:
        return _owner(descriptor)
    finally:
        os.close(descriptor)
    return None


def not_lockable(path: Path, error: OSError) -> str:
    """Why a session cannot be locked, in words with the remedy."""
    file, reason = lock_file(path), error.strerror or error
    with suppress(PermissionError):
        owner = _holder(file)
        if owner is not None:
            return f"{path.name}: {owner} has the session open; close it there to write"
    if os.path.lexists(file):
        return (
            f"{path.name}: {file.name} beside it cannot be used ({reason}); remove it if no "
            "program has the session open"
        )
    return f"{path.name}: file or folder may not be written ({reason})"


def _opened(file: Path) -> int:
    """A descriptor of a lock file to look at; another user's may only be read."""
    try:
        return os.open(file, os.O_RDWR | _PLAIN)
    except PermissionError:
        return os.open(file, os.O_RDONLY | _PLAIN)


def _acquired(file: Path, path: Path) -> int:
    """The descriptor of the locked lock file."""
    owner = ""
    for attempt in range(_TRIES):
        if attempt:
            time.sleep(_PAUSE)
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT | _PLAIN, 0o666)
        try:
            _refuse_foreign(descriptor)
            if _taken(descriptor) and _still(descriptor, file):
                _refuse_unknown(descriptor)
                return descriptor
            owner = _owner(descriptor)
        except OSError:
            os.close(descriptor)
            raise
        os.close(descriptor)
    raise HeldError(f"{path.name}: {owner} has the session open; close it there to write")


def _taken(descriptor: int) -> bool:
    """Whether the lock could be taken; OSError where there are none."""
    try:
        _take(descriptor)
    except (BlockingIOError, PermissionError):
        return False
    return True


def _refuse_foreign(descriptor: int) -> None:
    """OSError where what has the name of a lock file was not made as one."""
    found = os.fstat(descriptor)
    if not stat.S_ISREG(found.st_mode) or found.st_nlink > 1 or found.st_size > _MOST:
        raise OSError(errno.EEXIST, "it is no lock file of ours")


def _refuse_unknown(descriptor: int) -> None:
    """OSError where a file that is locked now holds what we never wrote: it is somebody's."""
    text = os.read(descriptor, _MOST).strip(b"\0")  # zeros are left by a failure of the power
    if text and not text.startswith(_BEGIN):
        raise OSError(errno.EEXIST, "it is no lock file of ours")


def _still(descriptor: int, file: Path) -> bool:
    """Whether the locked file is the one that has the name: its last owner may have removed it."""
    try:
        return os.path.samestat(os.fstat(descriptor), file.stat())
    except OSError:
        return False


def _told_owner() -> bytes:
    return json.dumps({"process": os.getpid(), "since": now()}).encode()


def _owner(descriptor: int) -> str:
    """The owner that the lock file names."""
    try:
        os.lseek(descriptor, 0, os.SEEK_SET)
        found = json.loads(os.read(descriptor, _MOST))
        return f"process {int(found['process'])}, since {told(found['since'])[1:-1]},"
    except (OSError, ValueError, KeyError, TypeError, OverflowError, RecursionError):
        return "another program"


def _remove(file: Path) -> None:
    try:
        file.unlink(missing_ok=True)
    except OSError:
        return  # a lock file that stays locks nobody out
