"""Whether Linux can draw off screen: VTK ends the process where it cannot, so ask first."""

import ctypes
from functools import cache

from georibbon.errors import ExportError

_PLATFORM_DEVICE = 0x313F  # EGL_PLATFORM_DEVICE_EXT
_MOST_DEVICES = 16


def require_egl() -> None:
    """Raise ExportError, with what to install, unless EGL has a device that starts."""
    reason = _missing()
    if reason:
        raise ExportError(
            f"a picture cannot be drawn here: {reason}, a working EGL was expected; install it, "
            "on Debian and Ubuntu with: sudo apt-get install libegl1 libgl1-mesa-dri"
        )


@cache
def _missing() -> str:
    """What is missing, in words; empty where nothing is."""
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        return "" if _starts(egl) else "no EGL device starts"
    except (OSError, AttributeError):
        return "the library libEGL.so.1 is missing or broken"


def _starts(egl: ctypes.CDLL) -> bool:
    """Whether one of EGL's devices can be initialised (EGL_EXT_platform_device)."""
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    egl.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    query = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    display_of = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not query or not display_of:
        return False
    count, devices = ctypes.c_int32(), (ctypes.c_void_p * _MOST_DEVICES)()
    query_type = ctypes.CFUNCTYPE(
        ctypes.c_uint, ctypes.c_int32, ctypes.c_void_p, ctypes.POINTER(ctypes.c_int32)
    )
    query_type(query)(_MOST_DEVICES, devices, ctypes.byref(count))
    display_type = ctypes.CFUNCTYPE(
        ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p
    )
    displays = [display_type(display_of)(_PLATFORM_DEVICE, d, None) for d in devices[: count.value]]
    return any(display and egl.eglInitialize(display, None, None) for display in displays)
