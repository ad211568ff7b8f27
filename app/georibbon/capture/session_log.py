"""Frames, and what happened to the link, into a session file of their own."""

import itertools
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from georibbon.capture.link_diary import LinkDiary
from georibbon.device.frames import Frame
from georibbon.device.identity import Identity
from georibbon.errors import SessionError, StorageError
from georibbon.session.outline import ribbon_table
from georibbon.session.session import Session

_REMOVED = (
    "the file was removed or replaced while it was written; all frames are kept and it is written "
    "anew"
)


class SessionLog:
    """The sink of a `Recorder` that makes a session of plain logging.

    path: a file that is not there.  identity: the ribbon that is recorded.
    diary: of its link, from before it was started.  One thread at a time;
    SessionError where the session cannot be made.
    """

    gone = 0
    """Frames lost of those that were written: none, a file that is taken away is written anew."""

    def __init__(self, path: Path, identity: Identity, diary: LinkDiary) -> None:
        self._session = Session.create(path)
        self._diary = diary
        self._missing = False
        try:
            self._file = path.stat()
            table = ribbon_table(identity.ribbon)
            self._session.do("ribbon", **table, firmware=identity.firmware)
            self._stream = self._session.stream(identity.ribbon.rate)
        except BaseException:
            self._session.close(discard=True)
            raise

    @property
    def path(self) -> Path:
        """Where the session is."""
        return self._session.path

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a person must know of the file and its place."""
        return self._session.warnings

    @property
    def durable(self) -> int:
        """How many of the frames are on the disk, in the file."""
        return 0 if self._missing else self._stream.durable

    def append(self, frames: Sequence[Frame]) -> None:
        """Take frames."""
        self._stream.append(frames)

    def sync(self) -> None:
        """Write the frames and the diary.

        Raises StorageError where they cannot be written; everything is kept, and
        the next calls try again.  Where the file was removed or replaced, they
        write it anew, under another name where its own is taken.
        """
        if self._session.held or self._missing:
            self._mend()
        self._write_diary(last=False)
        self._stream.flush()
        self._missing = not self._in_place()  # the session finds out when it writes next
        if self._missing or self._session.storage_error is not None:
            raise StorageError(self._session.storage_error or f"{self.path}: {_REMOVED}")

    def move_to(self, path: Path) -> None:
        """Go on in another file, with everything; raises SessionError, or StorageError."""
        self._session.move_to(path)
        self._file = path.stat()
        self._missing = False

    def close(self) -> None:
        """Close the session; StorageError where something could not be written, and is lost."""
        self._write_diary(last=True)
        try:
            self._session.close()
        except StorageError:
            self._session.close(discard=True)
            raise

    def _mend(self) -> None:
        if self._in_place():
            self._session.retry()
            return
        try:
            self.move_to(self.path)
        except SessionError:  # something has its name, or what SQLite left beside it
            self._move_beside()

    def _move_beside(self) -> None:
        path = self.path
        names = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
        try:
            self.move_to(next(name for name in names if not os.path.lexists(name)))
        except SessionError as error:
            raise StorageError(str(error)) from error

    def _in_place(self) -> bool:
        """Whether the path still leads to the file: it was not removed, moved or replaced."""
        try:
            return os.path.samestat(self.path.stat(), self._file)
        except OSError:
            return False

    def _write_diary(self, *, last: bool) -> None:
        for entry in self._diary.take(last=last):
            with suppress(StorageError):  # the session holds it, and says so
                self._session.do("link", **entry)
