"""The database of a session that is open for writing.

Used by one thread, the session's writer.  Whatever goes wrong with the place is
a StorageError; nothing that `write` was given is in the file then, or what is
there is the same and is written over.
"""

import sqlite3
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from georibbon.errors import SessionError, StorageError
from georibbon.session.chunks import Chunk, DamagedError, chunk_of
from georibbon.session.database import (
    busy,
    connect,
    fill,
    insert,
    pragma,
    read_chunks,
    read_sizes,
    reason_of,
    storage_error,
    unreadable,
)
from georibbon.session.events import Event
from georibbon.session.files import built_file, copy_rights, kind_of, sync_folder

LARGEST_LOG = 16 * 2**20
TRY_LOG = 2.0  # seconds between attempts to shorten a log that somebody reads
WAIT = 2.0  # seconds to wait for readers when closing
Cut = tuple[int, int]


def check_place(path: Path) -> None:
    """Raise SessionError where a new session cannot take this name."""
    kind = kind_of(path)
    if kind == "nothing" and path.is_symlink():
        raise SessionError(f"{path}: this is a link that leads nowhere; remove it or mend it")
    if kind not in ("file", "nothing"):
        raise SessionError(f"{path}: this is a folder or a device; give the name of a file")
    if kind == "file":
        raise SessionError(
            f"{path}: there is such a file already and its data is not overwritten; choose another "
            "name"
        )
    for ending in ("-wal", "-journal"):
        if kind_of(Path(f"{path}{ending}")) != "nothing":
            raise SessionError(
                f"{path}{ending}: the session of this name is open in another program or was not "
                "closed; close it first or give another name"
            )


def create(
    path: Path, events: Sequence[Event], chunks: Iterable[Chunk], like: Path | None = None
) -> None:
    """A new session file, whole or not at all, and durable.  Raises StorageError.

    like: the file whose owner and rights it gets, as far as that is allowed.
    """
    try:
        with built_file(path, StorageError) as built:
            database = connect(built.as_uri())
            try:
                fill(database, events, chunks)
            finally:
                database.close()
            if like is not None:
                copy_rights(like, built)
        sync_folder(path)
    except sqlite3.Error as error:
        raise StorageError(f"{path}: the session cannot be written ({error})") from error


def unmake(path: Path) -> None:
    """Remove a file just created that cannot be gone on with, and what SQLite put beside it."""
    for ending in ("", "-wal", "-shm", "-journal"):
        with suppress(OSError):
            Path(f"{path}{ending}").unlink()


class Store:
    """An open database; its lock is its opener's to hold."""

    def __init__(self, path: Path) -> None:
        """Open a file of version 2 in WAL mode.  Raises StorageError."""
        self.path = path
        self._place = path.resolve()
        self._log = Path(f"{self._place}-wal")
        self._next_try = 0.0
        self._database = connect(f"{self._place.as_uri()}?mode=rw")
        try:
            self._begin()
        except sqlite3.Error as error:
            self._database.close()
            raise storage_error(path, error, held=False) from error
        except BaseException:
            self._database.close()
            raise

    def _begin(self) -> None:
        database = self._database
        if pragma(database, "journal_mode = WAL") != "wal":
            raise StorageError(
                f"{self.path.name}: the file system offers no shared memory; choose a folder on a "
                "disk of this computer"
            )
        database.execute("PRAGMA synchronous = FULL")
        database.execute(f"PRAGMA journal_size_limit = {LARGEST_LOG}")
        self._identity = _identity(self._place)
        self._log_identity: tuple[int, int] | None = None

    @property
    def gone(self) -> bool:
        """Whether the file, or its log, was removed or replaced: then nothing reaches it."""
        if _identity(self._place) != self._identity:
            return True
        return self._log_identity is not None and _identity(self._log) != self._log_identity

    @property
    def _has_log(self) -> bool:
        """Whether the log of that name is the one that was written here."""
        return self._log_identity is not None and _identity(self._log) == self._log_identity

    def write(
        self, events: Sequence[Event], chunks: Sequence[Chunk], cuts: Sequence[Cut] = ()
    ) -> None:
        """One transaction, durable when this returns.

        cuts: (part, place): of a part, the chunks from that place on are replaced.
        Writing again what is there changes nothing.
        """
        self._check_there()
        database = self._database
        try:
            database.execute("BEGIN IMMEDIATE")
            database.executemany("DELETE FROM chunk WHERE part = ? AND place >= ?", cuts)
            insert(database, events, chunks)
            database.execute("COMMIT")
        except sqlite3.Error as error:
            self._roll_back()
            raise storage_error(self.path, error) from error
        except BaseException:
            self._roll_back()
            raise
        if self._log_identity is None:
            self._log_identity = _identity(self._log)
        self._check_there()
        self._shorten_log()

    def _check_there(self) -> None:
        if self.gone:
            raise StorageError(
                f"{self.path.name}: the file was removed or replaced by another program; save to "
                "another place (what is captured is kept in memory until then)"
            )

    def _roll_back(self) -> None:
        with suppress(sqlite3.Error):
            if self._database.in_transaction:
                self._database.execute("ROLLBACK")

    def _shorten_log(self) -> None:
        """Start the log anew where a reader has let it grow, as soon as he lets us."""
        if time.monotonic() < self._next_try:
            return
        with suppress(OSError, sqlite3.Error):
            if self._log.stat().st_size > LARGEST_LOG:
                self._next_try = time.monotonic() + TRY_LOG
                self._database.execute("PRAGMA busy_timeout = 50")
                self._database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        with suppress(sqlite3.Error):
            self._database.execute("PRAGMA busy_timeout = 5000")

    def chunks(self, part: int) -> tuple[Chunk, ...]:
        """The chunks of a part.  Raises SessionError where they cannot be read."""
        try:
            return tuple(read_chunks(self._database, part))
        except (DamagedError, sqlite3.Error) as error:
            raise unreadable(self.path, error) from error

    def readable(self, part: int) -> Iterator[Chunk | None]:
        """The chunks of a part one by one as far as they can be read; None for one that cannot."""
        try:
            query = "SELECT place FROM chunk WHERE part = ? ORDER BY place"
            places = self._database.execute(query, (part,)).fetchall()
        except sqlite3.Error:
            yield None
            return
        for (place,) in places:
            yield self._readable(part, place)

    def _readable(self, part: int, place: int) -> Chunk | None:
        try:
            query = "SELECT * FROM chunk WHERE part = ? AND place = ?"
            row = self._database.execute(query, (part, place)).fetchone()
            return None if row is None else chunk_of(row)
        except (DamagedError, sqlite3.Error):
            return None

    def sizes(self) -> dict[int, int]:
        """The number of frames in each part.  Raises SessionError where it cannot be read."""
        try:
            return read_sizes(self._database)
        except sqlite3.Error as error:
            raise unreadable(self.path, error) from error

    def close(self) -> str | None:
        """Close it as one plain file; why a reader or the disk did not allow that."""
        gone, whole, why = self.gone, False, None
        try:
            self._roll_back()
            if gone:
                whole = self._emptied_log()
                why = "it was removed or replaced by another program"
            else:
                why = self._not_plain()
        except sqlite3.Error as error:
            why = reason_of(self.path, error)
        with suppress(sqlite3.Error):
            self._database.close()
        if whole:
            self.tidy()
        return why

    def _emptied_log(self) -> bool:
        """Take what is in the log into the file, which may have got another name meanwhile.

        Only from the log that was written here: SQLite would open another's by its name.
        """
        if not self._has_log:
            return False
        row = self._database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
        return row is not None and row[0] == 0

    def tidy(self) -> None:
        """Remove the log of a file that is not there any more: beside another it would harm it."""
        if self.gone and self._has_log:
            with suppress(OSError):
                self._log.unlink()
                Path(f"{self._place}-shm").unlink(missing_ok=True)

    def _not_plain(self) -> str | None:
        """Make it one plain file; why that could not be."""
        self._database.execute(f"PRAGMA busy_timeout = {int(1000 * WAIT)}")
        self._database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        deadline = time.monotonic() + WAIT
        while True:
            why = "another program is reading it"
            try:
                if pragma(self._database, "journal_mode = DELETE") == "delete":
                    return None
            except sqlite3.OperationalError as error:
                if not busy(error):
                    why = reason_of(self.path, error)
            if time.monotonic() > deadline:
                return why
            time.sleep(0.02)


def _identity(path: Path) -> tuple[int, int] | None:
    """What tells a file from another of its name; None where there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino
