"""A file that only grows, and whose bytes are on the disk when they are said to be."""

import errno
import os
from contextlib import suppress
from io import FileIO
from pathlib import Path

from georibbon.session.files import sync_folder

_COPIED = 1 << 20  # bytes at a time


class DurableFile:
    """A new file, made at once; FileExistsError where one is there.

    path: the file; size: the bytes in it, all of them flushed to the disk.
    Every method may raise OSError, and the file is as it was before then.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.size = 0
        self._file = FileIO(path, "x+")
        sync_folder(path)

    def extend(self, data: bytes | bytearray) -> None:
        """Add bytes at the end; they are on the disk when this returns."""
        try:
            self._file.seek(self.size)
            _write_all(self._file, data)
            os.fsync(self._file.fileno())
        except OSError:
            with suppress(OSError):
                self._file.truncate(self.size)
            raise
        self.size += len(data)

    def in_place(self) -> bool:
        """Whether the path still leads to this file: it was not removed, moved or replaced."""
        try:
            return os.path.samestat(self.path.stat(), os.fstat(self._file.fileno()))
        except (FileNotFoundError, NotADirectoryError):
            return False

    def whole(self) -> bool:
        """Whether all its bytes are there: no other program has cut it shorter."""
        return os.fstat(self._file.fileno()).st_size >= self.size

    def copied_to(self, path: Path) -> "DurableFile":
        """A new file with the same bytes; this one can have been removed."""
        copy = DurableFile(path)
        try:
            while copy.size < self.size:
                self._file.seek(copy.size)
                if not (data := self._file.read(min(_COPIED, self.size - copy.size))):
                    raise OSError(errno.EIO, f"{self.path} was cut shorter by another program")
                copy.extend(data)
        except OSError:
            copy.close()
            path.unlink(missing_ok=True)
            raise
        return copy

    def close(self) -> None:
        """Close the file; it stays where it is."""
        self._file.close()


def _write_all(file: FileIO, data: bytes | bytearray) -> None:
    """Write all bytes; a disk that is nearly full takes some of them, and refuses the rest."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]
