"""The figures of the source paper, done again with numbers.

Sprynski, Szafran, Lacolle and Biard, Surface reconstruction via geodesic
interpolation, Computer-Aided Design 40 (2008) 480-492.  The paper gives no data
with its figures, so every situation here is of the same kind with numbers of
our own.  Each is done the paper's way and by Georibbon's own default.
"""

from collections.abc import Callable
from importlib import import_module

from georibbon.paper_figures.figure import NAMES, Choice, Curve, Figure, Line, Model, Plot

__all__ = ["NAMES", "NUMBERS", "Choice", "Curve", "Figure", "Line", "Model", "Plot", "figure"]

_MODULES = {
    "two_curves": (2, 3),
    "inflections": (4, 5, 6),
    "known_surfaces": (7, 8, 9, 10, 11, 16),
    "measured_curves": (12, 13),
    "tangents": (15,),
    "captured": (17,),
}
NUMBERS: tuple[int, ...] = tuple(sorted(number for of in _MODULES.values() for number in of))
"""The figures of the paper that are done again; the others hold nothing to be computed."""


def figure(number: int) -> Figure:
    """A figure of the paper by its number, computed; some take seconds."""
    module = next(name for name, of in _MODULES.items() if number in of)
    make: Callable[[], Figure] = getattr(
        import_module(f"georibbon.paper_figures.{module}"), f"figure_{number}"
    )
    return make()
