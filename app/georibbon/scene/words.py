"""Words in the scene that lie beside places of it: flat, of one size, always readable."""

from collections.abc import Sequence

import numpy as np
from vtkmodules.vtkRenderingCore import vtkCamera, vtkRenderer, vtkTextActor

from georibbon.arrays import FloatArray
from georibbon.scene.colours import Colour
from georibbon.scene.text import plain_label, style

_LEFT, _MIDDLE, _RIGHT = 0, 1, 2  # VTK_TEXT_LEFT, ...


class Words:
    """Labels, each beside a point and on the side that leads away from the object."""

    def __init__(self, renderer: vtkRenderer, font_size: int) -> None:
        self._renderer, self._font_size = renderer, font_size
        self._actors: list[vtkTextActor] = []
        self._words: dict[vtkTextActor, tuple[str, Colour]] = {}  # what each says
        self._away = np.empty((0, 3))
        self._places = np.empty((0, 3))
        self._visible = True

    def show(self, labels: Sequence[tuple[str, FloatArray, FloatArray, Colour]]) -> None:
        """Show words, each with its (3,) place, the (3,) direction away from it, and its colour."""
        while len(self._actors) < len(labels):
            actor = vtkTextActor()
            actor.GetPositionCoordinate().SetCoordinateSystemToWorld()
            self._renderer.AddViewProp(actor)
            self._actors.append(actor)
        for actor, (text, at, _, colour) in zip(self._actors, labels, strict=False):
            words = (plain_label(text), colour)
            if self._words.get(actor) != words:
                self._words[actor] = words
                actor.SetInput(words[0])
                style(actor.GetTextProperty(), self._font_size, colour, bold=True)
                actor.GetTextProperty().SetVerticalJustificationToCentered()
            actor.GetPositionCoordinate().SetValue(*at.tolist())
        self._places = np.array([at for _, at, _, _ in labels]).reshape(-1, 3)
        self._away = np.array([away for _, _, away, _ in labels]).reshape(-1, 3)
        for actor in self._actors[len(labels) :]:
            actor.VisibilityOff()

    def set_visible(self, visible: bool) -> None:
        """Whether they are to be seen."""
        self._visible = visible

    def follow(self, camera: vtkCamera) -> None:
        """Put every word on its side as the camera sees it; those behind the camera go."""
        forward = np.array(camera.GetDirectionOfProjection())
        right = np.cross(forward, camera.GetViewUp())
        right = right / (np.linalg.norm(right) or 1.0)
        before = (self._places - camera.GetPosition()) @ forward > 0.0
        for actor, along, seen in zip(self._actors, self._away @ right, before, strict=False):
            actor.SetVisibility(self._visible and bool(seen))
            look = actor.GetTextProperty()
            side = _MIDDLE if abs(along) < 0.3 else (_RIGHT if along < 0 else _LEFT)
            if look.GetJustification() != side:
                look.SetJustification(side)
