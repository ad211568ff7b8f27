"""The curves in the scene: passes and ties, and what a capture shows before there is a result."""

from collections.abc import Sequence

import numpy as np
from vtkmodules.vtkCommonCore import vtkLookupTable

from georibbon.arrays import FloatArray
from georibbon.scene.buffers import Triangles
from georibbon.scene.colours import Colour
from georibbon.scene.shapes import around, tubes

# Their normals make them round; they are a few pixels thick, and of many one or two.
_SIDES, _SIDES_OF_MANY, _MANY = 6, 4, 16


class Tubes:
    """Curves of one colour as round tubes."""

    def __init__(self, colour: Colour) -> None:
        self.body = Triangles(ambient=0.3)
        self.body.actor.GetProperty().SetColor(*colour)
        self.body.actor.GetProperty().BackfaceCullingOn()  # they are closed
        self.any = False
        self._sides = _SIDES
        self._visible = True
        self._apply()

    def show(self, curves: Sequence[FloatArray], radius: float) -> None:
        """Show curves of (n, 3) points each."""
        self.any = bool(curves)
        self._sides = _SIDES if len(curves) <= _MANY else _SIDES_OF_MANY
        if curves:
            self.body.show(tubes(curves, radius, self._sides))
        self._apply()

    def colour_by(self, values: Sequence[FloatArray] | None, table: vtkLookupTable | None) -> None:
        """Colour by values (n,) of each curve; by the one colour where None."""
        flat = None if values is None or not self.any else around(values, self._sides)
        self.body.show_values(flat, table)

    def set_visible(self, visible: bool) -> None:
        """Whether they are to be seen."""
        self._visible = visible
        self._apply()

    def _apply(self) -> None:
        self.body.actor.SetVisibility(self._visible and self.any)


def whole(points: FloatArray) -> bool:
    """Whether points (n, 3) make a curve that can be drawn."""
    return len(points) > 1 and bool(np.isfinite(points).all())
