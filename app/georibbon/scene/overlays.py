"""What stands beside the object, in a column at the right: scalar bar, key, axes."""

from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkAxesActor, vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkCoordinate, vtkRenderer, vtkTextActor

from georibbon.scene.colours import Colour
from georibbon.scene.text import style

_COLUMN = 0.82  # where it begins, as a share of the width


def scalar_bar(
    table: vtkLookupTable, step: float, font_size: int, ink: Colour
) -> vtkScalarBarActor:
    """An upright scale at the right edge, ticks at whole steps, named with its unit."""
    low, high = table.GetRange()
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle("Position\nuncertainty\n1σ, mm\n")
    bar.SetNumberOfLabels(round((high - low) / step) + 1)
    bar.SetLabelFormat(" %.2f" if step < 0.1 else " %.1f")
    bar.UnconstrainedFontSizeOn()
    bar.SetMaximumNumberOfColors(256)
    bar.SetPosition(_COLUMN + 0.01, 0.42)
    bar.SetWidth(0.10)
    bar.SetHeight(0.55)
    bar.SetBarRatio(0.28)
    for look in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        style(look, font_size, ink)
    bar.GetTitleTextProperty().SetJustificationToLeft()
    return bar


def key(lines: list[tuple[str, Colour]], font_size: int) -> list[vtkTextActor]:
    """What the signs mean: one line of text each, under the scalar bar."""
    top = vtkCoordinate()
    top.SetCoordinateSystemToNormalizedViewport()
    top.SetValue(_COLUMN, 0.37)
    actors = []
    for index, (text, colour) in enumerate(lines):
        actor = vtkTextActor()
        actor.SetInput(text)
        place = actor.GetPositionCoordinate()
        place.SetReferenceCoordinate(top)
        place.SetCoordinateSystemToViewport()
        place.SetValue(0, -1.55 * font_size * (index + 0.5))
        style(actor.GetTextProperty(), font_size, colour)
        actors.append(actor)
    return actors


def axes_renderer(font_size: int, colours: tuple[Colour, Colour, Colour]) -> vtkRenderer:
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
        shaft().SetLineWidth(3)
        tip().SetColor(*colour)
        caption().GetTextActor().SetTextScaleModeToNone()
        look = caption().GetCaptionTextProperty()
        style(look, font_size, colour)
    axes.SetXAxisLabelText("x")
    axes.SetYAxisLabelText("y")
    axes.SetZAxisLabelText("z")
    renderer = vtkRenderer()
    renderer.SetViewport(_COLUMN, 0.0, 1.0, 0.2)
    renderer.InteractiveOff()
    renderer.AddActor(axes)
    return renderer
