"""A recording's CSV file that grows while the ribbon speaks.

The file is what `session.counts.parse_csv` reads: `t,` and the columns, then
one line a frame.  Lines are only ever added, and flushed to the disk.  A crash
of the computer can leave the last line cut off: it then has no line feed at its
end, and is not to be trusted.
"""

import os
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from georibbon.capture.durable_file import DurableFile
from georibbon.device.frames import LOST, Frame
from georibbon.errors import ExportError, StorageError
from georibbon.session.files import kind_of
from georibbon.session.words import counted

_BLOCK = 1 << 20  # bytes that are written and flushed together, about
_MICRO = 1_000_000  # the ribbon's clock counts microseconds: six digits tell all it knows


@dataclass
class _Block:
    """Lines, whole ones, that are not durable yet."""

    frames: int
    data: bytearray


def check_csv_place(path: Path) -> None:
    """Refuse a place where no new CSV file can be made: ExportError says why."""
    if _is_there(path):
        torn = " (its last line was cut off: remove that line before you use the file)"
        raise ExportError(
            f"{path}: this is there already{torn if _is_torn(path) else ''}, and raw data is never "
            "overwritten; give another name"
        )
    if not path.parent.is_dir():
        raise ExportError(
            f"{path}: there is no folder {path.parent}; make it or choose another place"
        )
    if not os.access(path.parent, os.W_OK):
        raise ExportError(
            f"{path}: the folder {path.parent} cannot be written to; "
            "choose a place where you may write"
        )


def _is_there(path: Path) -> bool:
    """Whether the name is taken; ExportError for one that no file can have."""
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ExportError(
            f"{path}: no file can have this name ({reason}); choose another"
        ) from error
    return True


class CsvLog:
    """The sink of a `Recorder` that writes a CSV file.

    path: a file that is not there; it is made with the first frames.  columns:
    the names of all axes.  frames: how many were taken; gone: of them, those that
    another program may have cut off.  Times count from the first frame, to the
    microsecond, and grow from line to line.  What cannot be
    written is kept in memory, without a bound, until it can.  One thread at a time.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        check_csv_place(path)
        self.path = path
        self.frames = 0
        self.gone = 0
        self._written = 0
        self._header = ",".join(("t", *columns)).encode() + b"\n"
        self._pending = deque([_Block(0, bytearray(self._header))])
        self._file: DurableFile | None = None
        self._removed = False
        self._start: float | None = None
        self._last = -1

    @property
    def durable(self) -> int:
        """How many of the frames are on the disk, in the file."""
        return 0 if self._removed else self._written

    def append(self, frames: Sequence[Frame]) -> None:
        """Take frames; they are durable after the next `sync` that does not fail."""
        if not frames:
            return
        if not self._pending or len(self._pending[-1].data) > _BLOCK:
            self._pending.append(_Block(0, bytearray()))
        block = self._pending[-1]
        for frame in frames:
            block.data += self._line(frame)
        block.frames += len(frames)
        self.frames += len(frames)

    def sync(self) -> None:
        """Write what was taken and flush it to the disk.

        Raises StorageError where it cannot be; everything is kept, and the next
        call tries again.  Where the file was removed or moved away, this says
        so, and the next call writes it anew from its first line on.  What another
        program cuts off is lost: this says so, leaves that file as it is, and all
        frames from then on go to a new one, as soon as there is a place for it.
        """
        try:
            self._see_to_the_place()
            while self._pending and self.frames:
                self._file = self._file or DurableFile(self.path)
                self._file.extend(self._pending[0].data)
                self._written += self._pending.popleft().frames
        except OSError as error:
            raise _unwritten(self.path, error) from error

    def move_to(self, path: Path) -> None:
        """Write everything, from the first line on, to another file that is not there.

        What is at the old place stays as it is, and what another program cut off
        there is lost.  Raises ExportError or StorageError, and keeps everything, as
        `sync` does.
        """
        check_csv_place(path)
        if self._file is not None:
            try:
                self._go_on_in(self._file, path)
            except OSError as error:
                raise _unwritten(path, error) from error
        self.path = path
        self.sync()

    def close(self) -> None:
        """Write what can be written and close the file; raises StorageError as `sync` does."""
        try:
            self.sync()
        finally:
            if self._file is not None:
                self._file.close()

    def _see_to_the_place(self) -> None:
        """Find out that the file was removed or cut: told once, and then it is written anew."""
        if self._file is None:
            return
        if self._removed:
            self._go_on_in(self._file, self.path)
            return
        if not self._file.whole():
            self._removed = True
            raise StorageError(
                f"{self.path}: another program has cut the file shorter while it was written, and "
                f"{counted(self._written, 'frame')} may be lost with that; those that come are "
                "kept, and are written when you have moved that file away"
            )
        if not self._file.in_place():
            self._removed = True
            raise StorageError(
                f"{self.path}: the file was removed or replaced while it was written; all frames "
                "are kept and it is written anew, so leave it where it is"
            )

    def _go_on_in(self, file: DurableFile, path: Path) -> None:
        """Go on in a copy; the file that was removed can still be read as long as it is open."""
        if file.whole():
            self._file = file.copied_to(path)
        else:
            self._file = DurableFile(path)
            self._pending.appendleft(_Block(0, bytearray(self._header)))
            self.gone, self._written = self.gone + self._written, 0
        self._removed = False
        file.close()

    def _line(self, frame: Frame) -> bytes:
        if self._start is None:
            self._start = frame.t
        self._last = max(self._last + 1, round((frame.t - self._start) * _MICRO))
        seconds, micro = divmod(self._last, _MICRO)
        counts = ["" if count == LOST else str(count) for count in frame.counts.tolist()]
        return f"{seconds}.{micro:06d},{','.join(counts)}\n".encode()


def _unwritten(path: Path, error: OSError) -> StorageError:
    return StorageError(
        f"{path}: the file cannot be written ({error.strerror or error}); all frames are kept in "
        "memory and are written as soon as that is mended"
    )


def _is_torn(path: Path) -> bool:
    """Whether a file ends in the midst of a line."""
    if kind_of(path) != "file":
        return False
    try:
        with path.open("rb") as file:
            file.seek(max(file.seek(0, os.SEEK_END) - 1, 0))
            return file.read(1) not in (b"", b"\n")
    except OSError:
        return False
