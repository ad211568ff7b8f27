"""What a figure of the source paper is made of: numbers with words, and what is to be drawn."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from georibbon.arrays import FloatArray

Whose = Literal["paper", "georibbon", "other"]


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve (n, 3), metres, to be drawn; bold: one that the surface is built from."""

    points: FloatArray
    bold: bool = True


@dataclass(frozen=True, eq=False)
class Model:
    """A surface in space with what lies on it.

    grids: patches of points (k, m, 3), metres; normals: their unit normals, as
    many.  values: (k, m) for each grid, what colours it (see `Figure.colours`);
    empty where it has one colour.  arrows: (n, 3) from and (n, 3) to, metres.
    """

    grids: tuple[FloatArray, ...] = ()
    normals: tuple[FloatArray, ...] = ()
    values: tuple[FloatArray, ...] = ()
    curves: tuple[Curve, ...] = ()
    arrows: tuple[FloatArray, FloatArray] | None = None


@dataclass(frozen=True, eq=False)
class Line:
    """A line of a plot: x (n,) and y (n,), with the name of what it is."""

    name: str
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True, eq=False)
class Plot:
    """A plot of lines with the names and units of its axes."""

    x: str
    y: str
    lines: tuple[Line, ...]
    logarithmic: bool = False


@dataclass(frozen=True, eq=False)
class Choice:
    """One way to do it, and what came of it.

    whose: the paper's choice, Georibbon's own default, or another's.  settings:
    the choice in the words of the command line and the code.  numbers: by names
    that end in their unit (`NAMES` says what they are).  verdict: a few words.
    """

    name: str
    whose: Whose
    settings: str
    numbers: Mapping[str, float]
    verdict: str
    drawing: Model | Plot


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure of the source paper, done again.

    situation: what is given here.  shows: what the paper shows there, in other
    words than its own.  found: what came out here.  main: the numbers that tell
    it, of those that the choices have.  towards: from the object to the camera,
    the same for all choices.  colours: what they stand for, with its unit.
    """

    number: int
    title: str
    situation: str
    shows: str
    found: str
    choices: tuple[Choice, ...]
    main: tuple[str, ...]
    towards: tuple[float, float, float] = (-0.7, -1.0, 0.95)
    colours: str = ""

    def of(self, whose: Whose) -> Choice:
        """The first of the choices that is the paper's, Georibbon's or another's."""
        return next(choice for choice in self.choices if choice.whose == whose)


NAMES = {
    "rms_mm": "rms distance to the true surface",
    "max_mm": "greatest distance to the true surface",
    "tear_ratio": "longest step along u over the usual one",
    "self_crossing_pairs": "pairs of triangles that run through each other",
    "fold_least": "least (F_u x F_v).N / |F_u| |F_v|; not above 0: folded",
    "sine_least": "least sine of the angle between F_u and F_v",
    "normal_jump_deg": "greatest turn of the normals from one sample to the next",
    "start_speed": "speed of the lines across at their start, over the chord (mean)",
    "middle_speed": "the same in their middle",
    "end_speed": "the same at their end",
    "line_length": "length of the lines across over the chord (mean)",
    "lambda_least": "least tangent length, over the chord",
    "lambda_greatest": "greatest tangent length, over the chord",
    "angle_greatest_deg": "greatest angle of a starting or arrival vector from the conormal",
    "skew_greatest_deg": "greatest angle of a chord from square to its curve",
    "unsettled_percent": "share of the lines whose minimum was not found",
    "bounded_percent": "share of the lines whose minimum lies at the bounds",
    "geodesic_curvature_max_per_m": "greatest geodesic curvature of the curves",
    "curve_error_max_mm": "greatest distance of the curve to the true one",
    "end_error_mm": "distance of the curve's end to the true one",
    "end_error_percent": "the same over the curve's length",
    "end_error_expected_mm": "the same as the errors of the sensors let expect",
    "normal_rms_deg": "rms angle of the normals to the true ones",
    "normal_max_deg": "greatest angle of the normals to the true ones",
    "s_curve_tear_ratio": "longest step over the usual one between noisy S-curves (worst of five)",
    "curves_rms_mm": "rms distance of the curves to the true ones",
    "curves_max_mm": "greatest distance of the curves to the true ones",
}
"""What each of the numbers is; the end of the name is its unit, else it has none."""
