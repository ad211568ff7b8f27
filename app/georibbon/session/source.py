"""A recording from wherever it is: a recording folder or a session file."""

from pathlib import Path

from georibbon.errors import RecordingError
from georibbon.recording import Recording
from georibbon.session.files import kind_of
from georibbon.session.folder import TOML_NAME, read_recording


def load_source(path: Path) -> Recording:
    """The recording in a folder, in the folder of a recording.toml, or in a session file.

    What is there decides, not the ending of its name.  Raises RecordingError or
    SessionError.
    """
    kind = kind_of(path)
    if kind == "folder":
        return read_recording(path)
    if kind == "file" and path.name == TOML_NAME:
        return read_recording(path.parent)
    if kind == "nothing":
        raise RecordingError(
            f"{path}: there is no such folder or file; give a recording folder or a .georibbon file"
        )
    if path.suffix.lower() in (".csv", ".toml"):
        raise RecordingError(
            f"{path}: this is one file of a recording; give the folder that holds its {TOML_NAME}"
        )
    # sqlite3 is loaded only where a session is read
    from georibbon.session.file import read_session

    return read_session(path)
