"""What lies over the picture: the scalar bar, the axes, the floor's note."""

from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkAxesActor, vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkTextActor

from georibbon.scene.colours import Colour
from georibbon.scene.text import style

_AXIS_COLOURS = ((0.75, 0.15, 0.15), (0.10, 0.50, 0.20), (0.15, 0.30, 0.75))


def scalar_bar(table: vtkLookupTable, step: float, font_size: int) -> vtkScalarBarActor:
    """An upright scale at the right edge, ticks at whole steps, named with its unit."""
    low, high = table.GetRange()
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle("Position\nuncertainty\n1σ, mm\n")
    bar.SetNumberOfLabels(round((high - low) / step) + 1)
    bar.SetLabelFormat(" %.2f" if step < 0.1 else " %.1f")
    bar.UnconstrainedFontSizeOn()
    bar.SetMaximumNumberOfColors(256)
    bar.SetPosition(0.88, 0.16)
    bar.SetWidth(0.10)
    bar.SetHeight(0.66)
    bar.SetBarRatio(0.28)
    for look in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        style(look, font_size)
    bar.GetTitleTextProperty().SetJustificationToLeft()
    return bar


def key(lines: list[tuple[str, Colour]], font_size: int) -> list[vtkTextActor]:
    """What the signs mean: one line of text each, right of the axes, the first on top."""
    actors = []
    for index, (text, colour) in enumerate(reversed(lines)):
        actor = vtkTextActor()
        actor.SetInput(text)
        actor.SetPosition(12 * font_size, (1.2 + 1.5 * index) * font_size)
        style(actor.GetTextProperty(), font_size, colour)
        actors.append(actor)
    return actors


def axes_renderer(font_size: int) -> vtkRenderer:
    """A small renderer for the lower left corner that shows the workpiece's axes."""
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
    for colour, shaft, tip, caption in zip(_AXIS_COLOURS, shafts, tips, captions, strict=True):
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
    renderer.SetViewport(0.0, 0.0, 0.16, 0.2)
    renderer.InteractiveOff()
    renderer.AddActor(axes)
    return renderer
