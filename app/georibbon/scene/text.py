"""How words look in the scene."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

from vtkmodules.vtkCommonCore import VTK_FONT_FILE
from vtkmodules.vtkRenderingCore import vtkTextProperty

from georibbon.scene.colours import Colour
from georibbon.scene.labels import short_name


def style(look: vtkTextProperty, size: int, colour: Colour, bold: bool = False) -> None:
    """Set a text's font, size (pixels) and colour.

    The font is the DejaVu Sans that comes with the plotting library, which the
    figures use too: VTK's own has neither Greek nor Cyrillic.
    """
    look.SetFontFamily(VTK_FONT_FILE)
    look.SetFontFile(str(_fonts() / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")))
    look.SetFontSize(size)
    look.SetColor(*colour)
    look.BoldOff()
    look.ItalicOff()
    look.ShadowOff()


def plain_label(text: str) -> str:
    """A name as a label, with no pair of signs that starts a formula."""
    return short_name(text).replace("$", "\\$")


@cache
def _fonts() -> Path:
    """The plotting library's folder of fonts, found without importing the library."""
    spec = find_spec("matplotlib")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("matplotlib is not installed")
    return Path(spec.origin).parent / "mpl-data" / "fonts" / "ttf"
