"""A figure of the paper as one picture: its choices side by side, with their main numbers."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import colors
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Sheet

from georibbon.paper_figures import Choice, Figure, Model, Plot
from georibbon.scene.colours import round_range, signed_table

DOTS_PER_INCH = 100
SMALLEST = 1e-4  # of a logarithmic plot's highest value, that is shown
ROUNDING = 1e-5  # what is less is told as such
WIDTH = 1600  # pixels, where none are asked for
LEAST_TEXT = 0.085  # inches
PANEL = 0.66  # a panel's height over its width
BELOW = 10.0  # lines of words below a panel, in units of text
COLOURS_OF = {"paper": "#8a4b08", "georibbon": "#0b5c94", "other": "#50555c"}
LINES = ("#0b5c94", "#c1440e", "#2e8b57", "#7b4fa3")
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "text.parse_math": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#e3e6ea",
    "axes.axisbelow": True,
}
# How a number is told in short.
SHORT = {
    "rms_mm": "rms {} mm",
    "max_mm": "max {} mm",
    "normal_rms_deg": "normals {}° rms",
    "normal_max_deg": "normals {}° max",
    "normal_jump_deg": "normals jump {}°",
    "tear_ratio": "tear ratio {}",
    "s_curve_tear_ratio": "S-curves: tear ratio {}",
    "self_crossing_pairs": "crossings {}",
    "fold_least": "fold {}",
    "sine_least": "least sine {}",
    "skew_greatest_deg": "skew {}°",
    "lambda_least": "λ from {}",
    "lambda_greatest": "λ to {}",
    "start_speed": "starts at {}",
    "middle_speed": "middle {}",
    "end_speed": "ends at {}",
    "line_length": "length {}",
    "geodesic_curvature_max_per_m": "geodesic curvature {} 1/m",
    "curve_error_max_mm": "exact: {} mm",
    "end_error_mm": "end {} mm",
    "end_error_expected_mm": "expected {} mm",
    "curves_rms_mm": "curves rms {} mm",
}


def picture_of(figure: Figure, width: int = WIDTH) -> bytes:
    """The figure as the bytes of a PNG so many pixels wide.

    Raises ExportError where the system cannot draw.
    """
    plan = _Plan(width / DOTS_PER_INCH, len(figure.choices), bool(figure.colours))
    scale = 1.15 * 72.0 * plan.text / 1.25
    with mpl.rc_context({**STYLE, "font.size": 1.55 * scale}):
        sheet = Sheet(figsize=(plan.inches, plan.height), dpi=DOTS_PER_INCH)
        sheet.text(
            0.012, 1.0 - 0.45 * plan.head / plan.height, f"Figure {figure.number}. {figure.title}",
            fontsize=2.3 * scale, fontweight="bold", va="center",
        )  # fmt: skip
        panels = [sheet.add_axes(plan.box(k)) for k in range(plan.count)]
        _draw_panels(sheet, panels, figure, plan.panel)
        for panel, choice in zip(panels, figure.choices, strict=True):
            _write_words(panel, choice, figure.main, scale)
        return _png(sheet)


@dataclass(frozen=True)
class _Plan:
    """Where the panels of a sheet stand, inches: so wide, so many, with a scale of colours or not.

    Three at most stand side by side, more in two rows.
    """

    inches: float
    count: int
    colours: bool

    @property
    def text(self) -> float:
        return text_unit(self.inches)

    @property
    def columns(self) -> int:
        return self.count if self.count <= 3 else (self.count + 1) // 2

    @property
    def cell(self) -> float:
        """The width that a panel has for itself."""
        return self.inches / self.columns

    @property
    def panel(self) -> tuple[float, float]:
        """A panel's width and height."""
        return self.cell - 0.016 * self.inches, PANEL * self.cell

    @property
    def head(self) -> float:
        return 4.8 * self.text

    @property
    def row(self) -> float:
        """The height of a panel with the words above and below it."""
        return (3.6 + BELOW) * self.text + PANEL * self.cell

    @property
    def height(self) -> float:
        foot = 7.5 * self.text if self.colours else self.text
        return self.head + foot + -(-self.count // self.columns) * self.row

    def box(self, k: int) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of the k-th panel, as shares of the sheet."""
        row, column = divmod(k, self.columns)
        bottom = self.height - self.head - (row + 1) * self.row + BELOW * self.text
        width, height = self.panel
        left = column * self.cell + 0.008 * self.inches
        return left / self.inches, bottom / self.height, width / self.inches, height / self.height


def text_unit(inches: float) -> float:
    """What words are measured in, inches: they grow with the picture, but stay legible."""
    return max(inches / 150.0, LEAST_TEXT)


def _draw_panels(
    sheet: Sheet, panels: list[Axes], figure: Figure, inches: tuple[float, float]
) -> None:
    models = [choice.drawing for choice in figure.choices if isinstance(choice.drawing, Model)]
    if len(models) < len(panels):
        _draw_plots(panels, figure)
        return
    from georibbon.export.paper.views import common_view, drawn_model

    size = (round(inches[0] * DOTS_PER_INCH), round(inches[1] * DOTS_PER_INCH))
    view, metres = common_view(models, figure.towards, size[0] / size[1])
    top, step = _range_of(models)
    for panel, model in zip(panels, models, strict=True):
        panel.imshow(drawn_model(model, view, metres, top, size), aspect="auto")
        panel.set_axis_off()
    if figure.colours:
        height = sheet.get_size_inches()[1]
        text = text_unit(sheet.get_size_inches()[0])
        bar = sheet.add_axes((0.25, 4.6 * text / height, 0.5, 1.2 * text / height))
        shades = mpl.cm.ScalarMappable(
            colors.Normalize(0.0, top), colors.ListedColormap(signed_table(511)[255:] / 255.0)
        )
        scale = sheet.colorbar(shades, cax=bar, orientation="horizontal", extend="max")
        scale.set_ticks(list(np.arange(0.0, top + 0.5 * step, step)))
        scale.set_label(figure.colours)


def _range_of(models: list[Model]) -> tuple[float, float]:
    """The value of the last colour, and the step of its scale, common to all models."""
    values = [
        np.concatenate([one.ravel() for one in model.values]) for model in models if model.values
    ]
    if not values:
        return 1.0, 1.0
    highest = max(float(np.percentile(one, 98.0)) for one in values)
    _, top, step = round_range(0.0, highest)
    return top, step


def _draw_plots(panels: list[Axes], figure: Figure) -> None:
    plots = [choice.drawing for choice in figure.choices if isinstance(choice.drawing, Plot)]
    highest = max(float(line.y.max()) for plot in plots for line in plot.lines)
    for k, (panel, plot) in enumerate(zip(panels, plots, strict=True)):
        box = panel.get_position()
        panel.set_position((box.x0 + 0.065, box.y0 + 0.09, box.width - 0.075, box.height - 0.11))
        for colour, line in zip(LINES, plot.lines, strict=False):
            panel.plot(line.x, line.y, color=colour, label=line.name, linewidth=1.6)
        panel.grid(True)
        panel.set(xlabel=plot.x, ylabel=plot.y if k == 0 else "")
        panel.yaxis.labelpad = 1.0
        if plot.logarithmic:
            panel.set_yscale("log")
            panel.set_ylim(SMALLEST * highest, 2.0 * highest)
            panel.yaxis.set_major_formatter("{x:g}")
        if k == 0:  # the lines are the same in all
            panel.legend(frameon=False, loc="lower right", handlelength=1.2, borderaxespad=0.2)


def _write_words(panel: Axes, choice: Choice, main: Sequence[str], scale: float) -> None:
    """The choice's name above its panel, its verdict and main numbers below."""
    figure = panel.get_figure()
    if figure is None:
        raise RuntimeError("a panel belongs to a sheet")
    colour = COLOURS_OF[choice.whose]
    panel.set_title(
        choice.name, color=colour, fontweight="bold", fontsize=1.75 * scale, pad=4.0 * scale / 4
    )
    depth = -0.33 if isinstance(choice.drawing, Plot) else -0.02
    told = numbers_told(choice, main)
    lines = [choice.verdict, ", ".join(told[:2]), ", ".join(told[2:])]
    for k, line in enumerate(lines):
        panel.annotate(
            line, (0.5, depth), xytext=(0.0, -2.2 * scale * k), xycoords="axes fraction",
            textcoords="offset points", ha="center", va="top",
            color=colour if k == 0 else "#22262c",
            fontweight="bold" if k == 0 else "normal",
        )  # fmt: skip


def numbers_told(choice: Choice, main: Sequence[str]) -> list[str]:
    """A choice's main numbers in short words, with three digits."""
    return [SHORT[key].format(told_number(choice.numbers[key])) for key in main]


def told_number(value: float) -> str:
    """A number with three digits."""
    if abs(value) < ROUNDING:
        return "0" if value == 0.0 else f"< {ROUNDING:.5f}"
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _png(sheet: Sheet) -> bytes:
    target = io.BytesIO()
    sheet.savefig(target, format="png", metadata={"Software": None}, dpi=DOTS_PER_INCH)
    return target.getvalue()
