"""Prints the Debian packages that are still needed; prints nothing where none is missing.

    missing_libraries.py run|cad|test|peers

Pictures are drawn off screen, on Linux through EGL and its software driver.  VTK
crashes where they are missing, so it is tried in a process of its own.  The window
needs the libraries that Qt loads: all of them where there is a display, and for the
tests, which bring a display of their own.  The peers draw nothing, but some of
them link to what would draw.
"""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

PICTURES = ("libegl1", "libgl1-mesa-dri")

DRAWING = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow

window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.Render()
raise SystemExit(window.GetClassName() != "vtkEGLRenderWindow")
"""

# What Qt and its plugin for X displays link to, and the packages that hold it.
WINDOW = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11-xcb.so.1": "libx11-xcb1",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxcb-sync.so.1": "libxcb-sync1",
    "libxcb-xfixes.so.0": "libxcb-xfixes0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxkbcommon.so.0": "libxkbcommon0",
}
# What Open3D and OpenCASCADE link to.
PEERS = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libexpat.so.1": "libexpat1",
    "libidn2.so.0": "libidn2-0",
    "libudev.so.1": "libudev1",
    "libusb-1.0.so.0": "libusb-1.0-0",
}
# What the CAD kernel links to, though it draws nothing here.
KERNEL = {"libGL.so.1": "libgl1", "libX11.so.6": "libx11-6", "libexpat.so.1": "libexpat1"}
FONTS = (Path("/usr/share/fonts"), Path("/usr/local/share/fonts"))

# A display without a screen, and what the script that starts it calls.
DISPLAY = {"xvfb-run": "xvfb", "Xvfb": "xvfb", "xauth": "xauth"}


def drawing_works() -> bool:
    """Whether VTK can draw off screen here."""
    run = subprocess.run(  # noqa: S603 -- our own interpreter and our own text
        [sys.executable, "-c", DRAWING],
        env=os.environ | {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    return run.returncode == 0


def loads(library: str) -> bool:
    """Whether the system finds a library, and all that it links to."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def has_fonts() -> bool:
    """Whether there is any outline font: without one Qt writes empty boxes."""
    kinds = {".ttf", ".otf", ".ttc", ".pfb"}
    return any(file.suffix in kinds for folder in FONTS for file in folder.rglob("*"))


def missing(purpose: str) -> list[str]:
    """The packages that are needed to "run", for "cad", to "test" or for "peers", each once."""
    if purpose == "cad":
        return [package for library, package in KERNEL.items() if not loads(library)]
    if purpose == "peers":
        return [package for library, package in PEERS.items() if not loads(library)]
    found = [] if drawing_works() else list(PICTURES)
    if purpose == "test" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        found += [package for library, package in WINDOW.items() if not loads(library)]
        found += [] if has_fonts() else ["fonts-dejavu-core"]
    if purpose == "test":
        found += [package for program, package in DISPLAY.items() if not shutil.which(program)]
    return list(dict.fromkeys(found))


if __name__ == "__main__" and sys.platform == "linux":
    print(*missing(sys.argv[1]), end="")
