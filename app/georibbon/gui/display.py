"""Whether a window can be shown here, found out without Qt: it would end the process."""

import ctypes
import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path

PLATFORM = "QT_QPA_PLATFORM"
TRIES, PAUSE = 4, 0.1  # s

_held: list[tuple[ctypes.CDLL, int]] = []  # a connection to the display, at most


def why_no_display(environment: Mapping[str, str] = os.environ) -> str | None:
    """Why no window can be shown, in one sentence; None where it can."""
    if not sys.platform.startswith("linux") or environment.get(PLATFORM, "xcb") not in ("xcb", ""):
        return None
    if _wayland(environment):
        return None
    name = environment.get("DISPLAY", "")
    if not name:
        return "there is no display here to show the window on"
    try:
        missing = "libxcb-cursor.so.0"
        ctypes.CDLL(missing)
        missing = "libxcb.so.1"
        library = ctypes.CDLL(missing)
    except OSError:
        return f"the system's library {missing}, which windows need, is missing"
    if not _answers(library, name):
        return f"the display {name} does not answer"
    return None


def _wayland(environment: Mapping[str, str]) -> bool:
    name, folder = environment.get("WAYLAND_DISPLAY"), environment.get("XDG_RUNTIME_DIR", "")
    return bool(name) and not environment.get(PLATFORM) and (Path(folder) / name).exists()


def release() -> None:
    """Let go of the display that was asked; called as soon as the toolkit holds it."""
    while _held:
        library, connection = _held.pop()
        library.xcb_disconnect(connection)


def _answers(library: ctypes.CDLL, name: str) -> bool:
    """Whether an X server lets us in; where it does, it is held until `release`.

    A server without a screen begins anew when its last client leaves, and
    refuses all that come meanwhile: the toolkit a moment later, or us.
    """
    library.xcb_connect.restype = ctypes.c_void_p
    library.xcb_connect.argtypes = [ctypes.c_char_p, ctypes.c_void_p]
    library.xcb_connection_has_error.argtypes = [ctypes.c_void_p]
    library.xcb_disconnect.argtypes = [ctypes.c_void_p]
    release()
    for tries in range(TRIES):
        connection = library.xcb_connect(os.fsencode(name), None)
        if library.xcb_connection_has_error(connection) == 0:
            _held.append((library, connection))
            return True
        library.xcb_disconnect(connection)
        if tries + 1 < TRIES:
            time.sleep(PAUSE)
    return False
