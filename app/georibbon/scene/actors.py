"""Small things that several parts of the scene are made of."""

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkLookupTable

from georibbon.scene.buffers import Triangles
from georibbon.scene.colours import PLAIN_SURFACE, Colour


def look_up_table(colours: NDArray[np.uint8], blank: Colour) -> vtkLookupTable:
    """A table of (n, 3) colours; blank: the colour of what is not known."""
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colours))
    for index, (red, green, blue) in enumerate((colours / 255.0).tolist()):
        table.SetTableValue(index, red, green, blue, 1.0)
    table.SetNanColor(*blank, 1.0)
    return table


def skin() -> Triangles:
    """The surface's body, with a soft gloss."""
    body = Triangles(ambient=0.22)
    look = body.actor.GetProperty()
    look.SetColor(*PLAIN_SURFACE)
    look.SetDiffuse(0.80)
    look.SetSpecular(0.12)
    look.SetSpecularPower(25)
    return body


def solid_of(colour: Colour, ambient: float = 0.35) -> Triangles:
    """A body of one colour."""
    body = Triangles(ambient)
    body.actor.GetProperty().SetColor(*colour)
    body.actor.GetProperty().BackfaceCullingOn()  # closed bodies all
    return body
