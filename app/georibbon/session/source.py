"""A recording from wherever it is: a recording folder or a session file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from georibbon.errors import RecordingError
from georibbon.fitting.settings import ReconstructionSettings
from georibbon.recording import Recording
from georibbon.session.files import kind_of
from georibbon.session.folder import TOML_NAME, read_recording
from georibbon.session.settings import Values, settings_of

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.session.state import SessionState

CALIBRATION, KEPT = "calibration", "kept"
"""The setting of "*", and its value where the session's calibration is chosen over its poses."""


@dataclass(frozen=True, eq=False)
class Loaded:
    """A recording, and what a session says beside it.

    calibration: what stands in for the poses, where there are none or where that
    was chosen.  values:
    the settings as they are kept (`georibbon.session.settings`); settings: what
    they say.
    """

    recording: Recording
    calibration: "Calibration | None" = None
    values: Values = field(default_factory=dict)
    settings: ReconstructionSettings = field(default_factory=ReconstructionSettings)

    @property
    def smoothing(self) -> Mapping[str, float]:
        """Metres, by the pass's name or "*" for all others."""
        return self.settings.smoothing


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
    settings = settings_of_state(state, path.name)
    calibration = calibration_of(state, state.settings)
    return Loaded(recording, calibration, dict(state.settings), settings)


def calibration_of(state: "SessionState", values: Values) -> "Calibration | None":
    """The session's calibration where it stands in for the poses: as chosen, or for want of any.

    values: the settings as they are kept; the one of CALIBRATION says whether
    it is chosen though there are poses.
    """
    chosen = values.get(("*", CALIBRATION)) == KEPT
    return state.calibration if chosen or not state.poses else None


def settings_of_state(state: "SessionState", name: str) -> ReconstructionSettings:
    """What a session's settings say of the passes it has; name: the session's, for messages.

    Raises SessionError for a value that means nothing.
    """
    return settings_of(state.settings, [run.name for run in state.passes], name)


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
