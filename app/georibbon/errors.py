"""Errors that a person caused and can mend.

Every one says what was found, what was expected and what to do next, in one
sentence; the command line prints it on standard error and exits with 2, the
window shows it beside its cause.  Anything else that is raised is a fault of
the program.
"""


class GeoribbonError(Exception):
    """The input is at fault; the message is written for the person."""


class RecordingError(GeoribbonError):
    """A recording folder, or what it holds, is not as the format says."""


class SessionError(GeoribbonError):
    """A session file cannot be read or written."""


class CalibrationError(GeoribbonError):
    """The poses cannot give a calibration, or a calibration does not fit the ribbon."""


class FitError(GeoribbonError):
    """Readings or survey do not determine the passes."""


class SurfaceError(GeoribbonError):
    """The passes do not span a surface."""


class ExportError(GeoribbonError):
    """A result cannot be written where or as it was asked."""


class CurvesError(GeoribbonError):
    """A file of curves is not as its format says."""


class SettingsError(GeoribbonError):
    """A setting has a value that means nothing."""


class DeviceError(GeoribbonError):
    """A port, or what answers there, is not as a ribbon should be."""


class StorageError(SessionError):
    """A session cannot be written where it is; what it should hold is kept in memory."""
