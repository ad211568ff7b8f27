"""Session files of older versions made into the present one, the old file kept beside."""

import os
import shutil
import sqlite3
from collections.abc import Iterable
from pathlib import Path

from georibbon.errors import SessionError
from georibbon.session.chunks import Chunk
from georibbon.session.database import pragma, read_chunks
from georibbon.session.files import built_file, copy_rights, sync_folder
from georibbon.session.reading import Contents
from georibbon.session.state import parts_of
from georibbon.session.store import create

MOST_COPIES = 1000


def chunks_to_keep(database: sqlite3.Connection, found: Contents) -> list[Chunk]:
    """All frames of an old file, checked, through a connection in no transaction."""
    pragma(database, "journal_mode = DELETE")  # all of it in the one file that is kept
    return [chunk for part in parts_of(found.events) for chunk in read_chunks(database, part)]


def migrate(path: Path, found: Contents, chunks: Iterable[Chunk]) -> Path:
    """Bring a session to the present version; where the old file is kept.

    No connection to it is open.  The old file is kept as
    NAME.version-N.georibbon, or under the next name that is free, before the
    new one takes its name: at any moment there is a whole session at `path`.
    Raises SessionError where the folder cannot be written.
    """
    place = path.resolve()
    old = _kept(place, found.version)
    try:
        create(place, found.events, chunks, like=place)
    except BaseException:
        old.unlink(missing_ok=True)
        raise
    return old


def _kept(place: Path, version: int) -> Path:
    """A copy of a file beside it, durable, under a name that was free."""
    for number in range(1, MOST_COPIES):
        again = "" if number == 1 else f"-{number}"
        copy = place.with_name(f"{place.stem}.version-{version}{again}{place.suffix}")
        if not os.path.lexists(copy):
            _keep(place, copy)
            sync_folder(copy)
            return copy
    raise SessionError(f"{place.name}: there are {MOST_COPIES} copies beside it; remove some")


def _keep(place: Path, copy: Path) -> None:
    """Another name for the file; where the file system has no such, a copy, whole or none."""
    try:
        copy.hardlink_to(place)
    except OSError:
        with built_file(copy, SessionError) as built:
            shutil.copyfile(place, built)
            copy_rights(place, built)
            with built.open("rb+") as file:
                os.fsync(file.fileno())
