"""Whole session files: a recording put into one, and taken out of one.

What is in the file is described in `schema`.  It is read as something that
anybody may have sent: read only, with the schema compared word for word, every
row against its digest, every value against the same checks as a recording
folder's.
"""

from pathlib import Path

from georibbon.recording import Recording
from georibbon.session.reading import contents, read_part, reading
from georibbon.session.restoring import journal_of, recording_of
from georibbon.session.store import check_place, create

__all__ = ["check_place", "create_session", "read_session"]


def create_session(path: Path, recording: Recording) -> None:
    """Write a recording into a new session file.

    It is written beside and renamed when whole.  Raises SessionError where a
    file is there already, or the place cannot be written; RecordingError where
    the recording cannot be meant.
    """
    check_place(path)
    create(path, *journal_of(recording))


def read_session(path: Path, complete: bool = True) -> Recording:
    """The recording in a session file of any version; the file is opened read only.

    complete: refuse a session that cannot span a surface yet.  Raises
    SessionError, one sentence, for a file that is missing, no session, of a
    newer version, damaged in any place, or that holds what cannot be meant.
    """
    with reading(path) as database:
        found = contents(database, path)
        return recording_of(
            found.state,
            lambda part: read_part(database, part, found.state),
            path.name,
            complete,
        )
