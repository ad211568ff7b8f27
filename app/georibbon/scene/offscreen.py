"""The scene as a picture, with or without a display."""

import sys

import numpy as np
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from georibbon.reconstruction import Reconstruction
from georibbon.scene.arrays import from_vtk
from georibbon.scene.egl import require_egl
from georibbon.scene.scene import Scene

# Loaded for what loading does: they register the drawing of text and of everything else.
_REGISTERED = (vtkmodules.vtkRenderingFreeType, vtkmodules.vtkRenderingOpenGL2)
_SAMPLES = 8
_LINES_OF_TEXT = 44  # that would fill the height of a picture of 16 to 10


def render(reconstruction: Reconstruction, size: tuple[int, int]) -> NDArray[np.uint8]:
    """A picture of a result, (height, width, 3) uint8, sRGB, upper row first.

    size: (width, height), pixels.  Raises ExportError where the system cannot draw.
    """
    width, height = size
    scene = Scene(reconstruction, font_size=round(min(height, width / 1.6) / _LINES_OF_TEXT))
    window = offscreen_window(size)
    try:
        scene.attach(window)
        scene.frame(width / height)
        window.Render()
        return pixels(window)
    finally:
        window.Finalize()


def offscreen_window(size: tuple[int, int]) -> vtkRenderWindow:
    """A render window of (width, height) pixels that never appears on a screen.

    On Linux it is asked of EGL, which draws by software where there is no
    graphics card; VTK's own choice would try an X display first and complain on
    standard error when there is none.  Raises ExportError where EGL is missing.
    """
    if sys.platform == "linux":
        require_egl()
        window: vtkRenderWindow = vtkmodules.vtkRenderingOpenGL2.vtkEGLRenderWindow()
    else:
        window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(_SAMPLES)
    window.SetSize(*size)
    return window


def pixels(window: vtkRenderWindow) -> NDArray[np.uint8]:
    """What was drawn, (height, width, 3) uint8, sRGB, upper row first."""
    width, height = window.GetSize()
    data = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, width - 1, height - 1, 1, data, 0)
    rows: NDArray[np.uint8] = from_vtk(data).reshape(height, width, 3)
    return rows[::-1].copy()
