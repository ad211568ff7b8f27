"""Prints the Debian packages that pictures still need; prints nothing where none is missing.

Pictures are drawn off screen, on Linux through EGL and its software driver.  VTK
crashes where they are missing, so it is tried in a process of its own.
"""

import os
import subprocess
import sys

PACKAGES = "libegl1 libgl1-mesa-dri"

DRAWING = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow

window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.Render()
raise SystemExit(window.GetClassName() != "vtkEGLRenderWindow")
"""


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


if __name__ == "__main__" and sys.platform == "linux" and not drawing_works():
    print(PACKAGES)
