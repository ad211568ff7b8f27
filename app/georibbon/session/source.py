"""A recording from wherever it is: a recording folder or a session file."""

from pathlib import Path

from georibbon.errors import RecordingError
from georibbon.recording import Recording
from georibbon.session.folder import TOML_NAME, read_recording


def load_source(path: Path) -> Recording:
    """The recording in a folder, in the folder of a recording.toml, or in a session file.

    What is there decides, not the ending of its name.  Raises RecordingError or
    SessionError.
    """
    if path.is_dir():
        return read_recording(path)
    if path.name == TOML_NAME and path.is_file():
        return read_recording(path.parent)
    if not path.exists():
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
