"""A result's picture as PNG."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from georibbon.export.files import PICTURE_ENDINGS, require_ending, write_whole
from georibbon.reconstruction import Reconstruction


def write_picture(
    reconstruction: Reconstruction, path: Path, size: tuple[int, int] = (1600, 1000)
) -> None:
    """Write the 3D scene of a result to a .png file of (width, height) pixels.

    Needs no display.  Raises ExportError for another ending or a place that
    cannot be written.
    """
    require_ending(path, PICTURE_ENDINGS, "a picture")
    write_whole(path, picture(reconstruction, size))


def picture(reconstruction: Reconstruction, size: tuple[int, int]) -> bytes:
    """The 3D scene of a result as the bytes of a PNG file."""
    from georibbon.scene.offscreen import render  # VTK: loaded when a picture is wanted

    return png(render(reconstruction, size))


def png(pixels: NDArray[np.uint8]) -> bytes:
    """(height, width, 3) uint8, upper row first, as the bytes of a PNG file."""
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOImage import vtkPNGWriter

    from georibbon.scene.arrays import from_vtk, to_vtk

    height, width, _ = pixels.shape
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    image.GetPointData().SetScalars(to_vtk(pixels[::-1].reshape(-1, 3)))
    writer = vtkPNGWriter()
    writer.SetInputData(image)
    writer.WriteToMemoryOn()
    writer.Write()
    data: bytes = from_vtk(writer.GetResult()).tobytes()
    return data
