"""What stands beside the object, in a column at the right: scalar bar, key, axes."""

from collections.abc import Sequence

import numpy as np
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkAxesActor, vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkCoordinate, vtkRenderer, vtkRenderWindow, vtkTextActor

from georibbon.scene.colours import Colour
from georibbon.scene.text import style

_COLUMN = 0.82  # where it begins, as a share of the width
_KEY_TOP = 0.37  # as a share of the height
_LEADING = 1.55  # from line to line, in heights of the letters
_AXES_TOP = 0.2  # of the corner of the axes,
_AXES_REACH = 0.15  # and how far up they reach in it


class ScalarBar:
    """An upright scale at the right edge, named with its unit."""

    def __init__(self, font_size: int, ink: Colour) -> None:
        self.actor = vtkScalarBarActor()
        self.actor.UnconstrainedFontSizeOn()
        self.actor.SetMaximumNumberOfColors(256)
        self.actor.SetPosition(_COLUMN + 0.01, 0.42)
        self.actor.SetWidth(0.10)
        self.actor.SetHeight(0.55)
        self.actor.SetBarRatio(0.28)
        for look in (self.actor.GetTitleTextProperty(), self.actor.GetLabelTextProperty()):
            style(look, font_size, ink)
        self.actor.GetTitleTextProperty().SetJustificationToLeft()

    def show(self, table: vtkLookupTable, title: str, step: float) -> None:
        """Show a table with ticks at steps, or equal parts of its range."""
        low, high = table.GetRange()
        parts = max(1, round((high - low) / step))
        width = (high - low) / parts
        self.actor.SetLookupTable(table)
        self.actor.SetTitle(title)
        self.actor.SetNumberOfLabels(parts + 1)
        self.actor.SetLabelFormat(f" %.{decimals(width)}f")


def decimals(step: float) -> int:
    """How many places behind the point write multiples of a step as they are, to a thousandth."""
    if step >= 10.0:
        return 0
    first = max(1, -int(np.floor(np.log10(step) + 1e-9)))
    exact = (d for d in (first, first + 1) if abs(step * 10**d - round(step * 10**d)) < 1e-3)
    return next(exact, first + 1)


class Key:
    """What the signs mean: one line of text each, under the scalar bar."""

    def __init__(self, renderer: vtkRenderer, font_size: int) -> None:
        self._renderer, self._font_size = renderer, font_size
        self._top = vtkCoordinate()
        self._top.SetCoordinateSystemToNormalizedViewport()
        self._top.SetValue(_COLUMN, _KEY_TOP)
        self._actors: list[vtkTextActor] = []

    def show(self, lines: Sequence[tuple[str, Colour]]) -> None:
        """Show these lines, each with its colour."""
        while len(self._actors) < len(lines):
            self._actors.append(self._line(len(self._actors)))
        for index, actor in enumerate(self._actors):
            actor.SetVisibility(index < len(lines))
        for actor, (text, colour) in zip(self._actors, lines, strict=False):
            actor.SetInput(text)
            style(actor.GetTextProperty(), self._font_size, colour)

    def follow(self, window: vtkRenderWindow) -> float:
        """Stand so far from the right edge that the longest line fits a narrow picture.

        window: that the renderer is shown in.
        How high above the picture's foot the last line ends, as a share of its height.
        """
        seen = [actor for actor in self._actors if actor.GetVisibility()]
        size, widest = [0.0, 0.0], 0.0
        for actor in seen:
            actor.GetSize(self._renderer, size)
            widest = max(widest, size[0])
        width, height = (side or 1 for side in window.GetSize())
        left = min(_COLUMN, max(0.0, 1.0 - (widest + self._font_size / 2) / width))
        if left != self._top.GetValue()[0]:
            self._top.SetValue(left, _KEY_TOP)
        return _KEY_TOP - _LEADING * self._font_size * len(seen) / height

    def _line(self, index: int) -> vtkTextActor:
        actor = vtkTextActor()
        place = actor.GetPositionCoordinate()
        place.SetReferenceCoordinate(self._top)
        place.SetCoordinateSystemToViewport()
        place.SetValue(0, -_LEADING * self._font_size * (index + 0.5))
        self._renderer.AddViewProp(actor)
        return actor


def cross(font_size: int, colour: Colour) -> vtkTextActor:
    """A cross in the middle of the picture, not to be seen at first."""
    actor = vtkTextActor()
    actor.SetInput("┼")
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.GetPositionCoordinate().SetValue(0.5, 0.5)
    look = actor.GetTextProperty()
    style(look, 2 * font_size, colour)
    look.SetJustificationToCentered()
    look.SetVerticalJustificationToCentered()
    actor.VisibilityOff()
    return actor


def axes_renderer(
    font_size: int, colours: tuple[Colour, Colour, Colour], line_scale: float
) -> vtkRenderer:
    """A small renderer for the lower right corner that shows the workpiece's axes."""
    axes = vtkAxesActor()
    axes.SetConeRadius(0.3)
    axes.SetNormalizedTipLength(0.22, 0.22, 0.22)
    axes.SetNormalizedShaftLength(0.78, 0.78, 0.78)
    shafts = (axes.GetXAxisShaftProperty, axes.GetYAxisShaftProperty, axes.GetZAxisShaftProperty)
    tips = (axes.GetXAxisTipProperty, axes.GetYAxisTipProperty, axes.GetZAxisTipProperty)
    captions = (
        axes.GetXAxisCaptionActor2D,
        axes.GetYAxisCaptionActor2D,
        axes.GetZAxisCaptionActor2D,
    )
    for colour, shaft, tip, caption in zip(colours, shafts, tips, captions, strict=True):
        shaft().SetColor(*colour)
        shaft().SetLineWidth(3.0 * line_scale)
        shaft().RenderLinesAsTubesOn()
        tip().SetColor(*colour)
        caption().GetTextActor().SetTextScaleModeToNone()
        look = caption().GetCaptionTextProperty()
        style(look, font_size, colour)
    axes.SetXAxisLabelText("x")
    axes.SetYAxisLabelText("y")
    axes.SetZAxisLabelText("z")
    renderer = vtkRenderer()
    place_axes(renderer, _AXES_TOP)
    renderer.InteractiveOff()
    renderer.AddActor(axes)
    return renderer


def place_axes(renderer: vtkRenderer, free: float) -> None:
    """Put the axes into the lower right corner, or the left where they would lie over the key.

    free: how much of the height is free above the lower right corner.
    """
    right = free >= _AXES_REACH
    corner = (_COLUMN, 1.0) if right else (0.0, 1.0 - _COLUMN)
    renderer.SetViewport(corner[0], 0.0, corner[1], _AXES_TOP)
