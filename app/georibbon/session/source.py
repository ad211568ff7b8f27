"""A recording from wherever it is: a recording folder or a session file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.errors import RecordingError, SessionError
from georibbon.recording import Recording
from georibbon.session.events import EVERY_PASS
from georibbon.session.files import kind_of
from georibbon.session.folder import TOML_NAME, read_recording
from georibbon.session.words import told

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.session.state import SessionState

SMOOTHING = "smoothing"


@dataclass(frozen=True, eq=False)
class Loaded:
    """A recording, and what a session says beside it.

    calibration: what stands in for the poses, where there are none.  smoothing:
    metres, by the pass's name or "*" for all others.
    """

    recording: Recording
    calibration: "Calibration | None" = None
    smoothing: Mapping[str, float] = field(default_factory=dict)


def load_source(path: Path, complete: bool = True) -> Recording:
    """The recording in a folder, in the folder of a recording.toml, or in a session file.

    What is there decides, not the ending of its name.  complete: refuse a
    session that cannot span a surface (a folder never holds such).  Raises
    RecordingError or SessionError.
    """
    return load(path, complete).recording


def load(path: Path, complete: bool = True) -> Loaded:
    """The recording as `load_source` gives it, with the settings of a session."""
    folder = folder_of(path)
    if folder is not None:
        return Loaded(read_recording(folder))
    # sqlite3 is loaded only where a session is read
    from georibbon.session.reading import contents, read_part, reading
    from georibbon.session.restoring import recording_of

    with reading(path) as database:
        state = contents(database, path).state
        recording = recording_of(
            state, lambda part: read_part(database, part, state), path.name, complete
        )
    smoothing = smoothing_of(state, path.name)
    return Loaded(recording, None if recording.poses else state.calibration, smoothing)


def smoothing_of(state: "SessionState", name: str) -> dict[str, float]:
    """The smoothing that a session asks for, metres, by the name of a pass it has or "*".

    name: the session's, for messages.  Raises SessionError for what is no length.
    """
    names = {run.name for run in state.passes} | {EVERY_PASS}
    return {
        whose: _metres(value, whose, name)
        for (whose, key), value in state.settings.items()
        if key == SMOOTHING and whose in names
    }


def folder_of(path: Path) -> Path | None:
    """The recording folder that a path names, or None where it names a session file.

    Raises RecordingError where it is neither.
    """
    kind = kind_of(path)
    if kind == "folder":
        return path
    if kind == "file" and path.name == TOML_NAME:
        return path.parent
    if kind == "nothing":
        raise RecordingError(
            f"{path}: there is no such folder or file; give a recording folder or a .georibbon file"
        )
    if path.suffix.lower() in (".csv", ".toml"):
        raise RecordingError(
            f"{path}: this is one file of a recording; give the folder that holds its {TOML_NAME}"
        )
    return None


def _metres(value: object, whose: str, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SessionError(
            f"{name}: the smoothing of {told(whose)} is {told(value)}; a number of metres is "
            "expected"
        )
    return float(value)
