"""The scene as a picture, with or without a display."""

import sys

import numpy as np
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from georibbon.errors import ExportError
from georibbon.reconstruction import Reconstruction
from georibbon.scene.arrays import from_vtk
from georibbon.scene.egl import require_egl
from georibbon.scene.scene import Scene

# Loaded for what loading does: they register the drawing of text and of everything else.
_REGISTERED = (vtkmodules.vtkRenderingFreeType, vtkmodules.vtkRenderingOpenGL2)
_SAMPLES = 8
_FEW_PIXELS, _FEW_SAMPLES = 2_500_000, 4  # larger pictures have finer edges already
MOST_PIXELS = 64_000_000
_LONGEST_SIDE = 16_384
_LINES_OF_TEXT = 44  # that would fill the height of a picture of 16 to 10


def render(reconstruction: Reconstruction, size: tuple[int, int]) -> NDArray[np.uint8]:
    """A picture of a result, (height, width, 3) uint8, sRGB, upper row first.

    size: (width, height), pixels.  Raises ExportError where the system cannot draw.
    """
    width, height = size
    scene = Scene(reconstruction, font_size=round(min(height, width / 1.6) / _LINES_OF_TEXT))
    scene.frame(width / height)
    return drawn(scene, size)


def drawn(scene: Scene, size: tuple[int, int], transparent: bool = False) -> NDArray[np.uint8]:
    """A picture of a scene as its camera sees it, (height, width, 3) uint8, upper row first.

    transparent: with a fourth channel, opacity, and nothing behind the object.
    Raises ExportError where the system cannot draw.
    """
    window = offscreen_window(size)
    window.SetAlphaBitPlanes(int(transparent))
    if size[0] * size[1] > _FEW_PIXELS:
        window.SetMultiSamples(_FEW_SAMPLES)
    scene.renderer.SetBackgroundAlpha(0.0 if transparent else 1.0)
    try:
        scene.attach(window)
        scene.renderer.ResetCameraClippingRange()
        scene.follow()
        window.Render()
        return pixels(window, transparent)
    finally:
        window.Finalize()


def require_drawable(size: tuple[int, int]) -> None:
    """Raise ExportError for a picture of more (width, height) pixels than can be drawn."""
    width, height = size
    if max(size) > _LONGEST_SIDE or width * height > MOST_PIXELS:
        raise ExportError(
            f"a picture of {width} by {height} pixels is too large to be drawn, at most "
            f"{MOST_PIXELS / 1e6:.0f} million and {_LONGEST_SIDE} on a side are: choose a smaller "
            "scale, or make the window smaller"
        )


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


def pixels(window: vtkRenderWindow, transparent: bool = False) -> NDArray[np.uint8]:
    """What was drawn, (height, width, 3) uint8, sRGB, upper row first; a fourth for opacity."""
    width, height = window.GetSize()
    data = vtkUnsignedCharArray()
    if transparent:
        window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 1, data, 0)
    else:
        window.GetPixelData(0, 0, width - 1, height - 1, 1, data, 0)
    rows: NDArray[np.uint8] = from_vtk(data).reshape(height, width, -1)
    return rows[::-1].copy()
