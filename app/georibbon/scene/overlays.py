"""What lies over the picture: the scalar bar, the axes, the floor's note."""

from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkAxesActor, vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkTextActor, vtkTextProperty

from georibbon.scene.colours import INK

_AXIS_COLOURS = ((0.75, 0.15, 0.15), (0.10, 0.50, 0.20), (0.15, 0.30, 0.75))


def scalar_bar(table: vtkLookupTable, step: float, font_size: int) -> vtkScalarBarActor:
    """An upright scale at the right edge, ticks at whole steps, named with its unit."""
    low, high = table.GetRange()
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle("Position\nuncertainty\n1σ, mm\n")
    bar.SetNumberOfLabels(round((high - low) / step) + 1)
    bar.SetLabelFormat("{:.2f}" if step < 0.1 else "{:.1f}")
    bar.UnconstrainedFontSizeOn()
    bar.SetMaximumNumberOfColors(256)
    bar.SetPosition(0.88, 0.16)
    bar.SetWidth(0.10)
    bar.SetHeight(0.66)
    bar.SetBarRatio(0.28)
    for look in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        _ink(look, font_size)
    bar.GetTitleTextProperty().SetJustificationToLeft()
    return bar


def note(text: str, font_size: int) -> vtkTextActor:
    """A line of small text at the lower edge, right of the axes."""
    actor = vtkTextActor()
    actor.SetInput(text)
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.SetPosition(0.17, 0.035)
    _ink(actor.GetTextProperty(), font_size)
    return actor


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
        _ink(look, font_size)
        look.SetColor(*colour)
    axes.SetXAxisLabelText("x")
    axes.SetYAxisLabelText("y")
    axes.SetZAxisLabelText("z")
    renderer = vtkRenderer()
    renderer.SetViewport(0.0, 0.0, 0.16, 0.2)
    renderer.InteractiveOff()
    renderer.AddActor(axes)
    return renderer


def _ink(look: vtkTextProperty, size: int) -> None:
    look.SetFontFamilyToArial()
    look.SetFontSize(size)
    look.SetColor(*INK)
    look.BoldOff()
    look.ItalicOff()
    look.ShadowOff()
