"""The curves in the scene: passes and ties, and what a capture shows before there is a result."""

from collections.abc import Sequence

import numpy as np
from vtkmodules.vtkCommonCore import vtkLookupTable

from georibbon.arrays import FloatArray
from georibbon.scene.buffers import Lines, Triangles
from georibbon.scene.colours import Colour
from georibbon.scene.shapes import around, tubes

# Their normals make them round; they are a few pixels thick, and of many one or two.
_SIDES, _SIDES_OF_MANY, _MANY = 6, 4, 16
_MOST = 24  # tubes of so many passes are a pixel thick; of more they would be dotted


class Tubes:
    """Curves of one colour as round tubes, or, where there are many, as lines.

    line_scale: pixels that a line one pixel wide takes on a dense screen.
    """

    def __init__(self, colour: Colour, line_scale: float = 1.0) -> None:
        self.body = Triangles(ambient=0.3)
        self.thin = Lines(colour, line_scale)
        self.thin.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self.thin.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-4.0, -4.0)
        self.body.actor.GetProperty().SetColor(*colour)
        self.body.actor.GetProperty().BackfaceCullingOn()  # they are closed
        self.any = False
        self._sides = _SIDES
        self._many = False
        self._visible = True
        self._apply()

    def show(self, curves: Sequence[FloatArray], radius: float) -> None:
        """Show curves of (n, 3) points each."""
        self.any = bool(curves)
        self._sides = _SIDES if len(curves) <= _MANY else _SIDES_OF_MANY
        self._many = len(curves) > _MOST
        if self._many:
            self.thin.show(curves)
        elif curves:
            self.body.show(tubes(curves, radius, self._sides))
        self._apply()

    def colour_by(self, values: Sequence[FloatArray] | None, table: vtkLookupTable | None) -> None:
        """Colour by values (n,) of each curve; by the one colour where None."""
        flat = None
        if values is not None and self.any:
            flat = np.concatenate(values) if self._many else around(values, self._sides)
        (self.thin if self._many else self.body).show_values(flat, table)

    def set_visible(self, visible: bool) -> None:
        """Whether they are to be seen."""
        self._visible = visible
        self._apply()

    def _apply(self) -> None:
        shown = self._visible and self.any
        self.body.actor.SetVisibility(shown and not self._many)
        self.thin.actor.SetVisibility(shown and self._many)


def whole(points: FloatArray) -> bool:
    """Whether points (n, 3) make a curve that can be drawn."""
    return len(points) > 1 and bool(np.isfinite(points).all())
