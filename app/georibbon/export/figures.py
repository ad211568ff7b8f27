"""The report's drawings: plan and profiles of the passes, residuals by sensor.

Drawn on figures of their own, never through the plotting library's global state,
and returned as SVG or PNG that is the same for the same result.
"""

import io
from itertools import cycle
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib import colors, font_manager
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from georibbon.arrays import FloatArray
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.ribbon import SensorKind
from georibbon.scene.colours import quantity_table, round_range
from georibbon.scene.labels import short_name

Form = Literal["svg", "png"]

_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "georibbon",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "axes.axisbelow": True,
    "text.parse_math": False,  # a name with two dollar signs is a name
}
_COLOURS = ("#1b6ca8", "#c1440e", "#2e8b57", "#7b4fa3", "#8a6d1a", "#404854")
# Each next line differs in both, so that passes that lie on one another are both seen.
_STYLES = ("-", (0, (6, 2)), (0, (2, 2)), (0, (8, 2, 2, 2)))
_LINES = [(_COLOURS[i % 6], _STYLES[i % 4]) for i in range(12)]
_MOST_NAMED = len(_LINES)
# More lines than can be told apart: all alike, and as a picture, not to fill the file with paths.
_ONE_OF_MANY: dict[str, Any] = {
    "color": "#1b6ca8",
    "alpha": 0.5,
    "linewidth": 0.5,
    "rasterized": True,
}
_RESIDUAL_LIMIT = 4.0
_DOTS_PER_INCH = 200
_PAGE_WIDTH = 7.3  # inches between the margins of an A4 page


def plan_figure(reconstruction: Reconstruction, form: Form = "svg") -> bytes:
    """The passes seen from above, coloured by their uncertainty."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(_PAGE_WIDTH, 3.4), layout="constrained")
        _draw_plan(figure, figure.subplots(), reconstruction.passes)
        return _drawn(figure, form)


def profiles_figure(reconstruction: Reconstruction, form: Form = "svg") -> bytes:
    """Height and uncertainty along each pass."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(_PAGE_WIDTH, 4.0), layout="constrained")
        profile, uncertainty = figure.subplots(2, 1, sharex=True)
        _draw_profiles(profile, uncertainty, reconstruction.passes)
        return _drawn(figure, form)


def residuals_figure(reconstruction: Reconstruction, form: Form = "svg") -> bytes:
    """Every residual of every sensor axis on every pass, one panel a kind."""
    rows = len(reconstruction.passes)
    with mpl.rc_context({**_STYLE, "axes.grid": False}):
        panel = 0.5 + min(0.24 * rows, 4.0)
        figure = Figure(figsize=(_PAGE_WIDTH, 0.4 + 2 * panel), layout="constrained")
        kinds: tuple[SensorKind, SensorKind] = ("accelerometer", "magnetometer")
        axes = figure.subplots(2, 1, squeeze=False)[:, 0]
        for axis, kind in zip(axes, kinds, strict=True):
            image = _draw_residuals(axis, reconstruction, kind)
        bar = figure.colorbar(image, ax=list(axes), extend="both", aspect=30, pad=0.01)
        bar.set_label("residual / its standard deviation")
        return _drawn(figure, form)


def deviation_figure(values: FloatArray, form: Form = "svg") -> bytes:
    """How often each deviation (n,), metres, NaN left out, occurs."""
    found = values[np.isfinite(values)] * 1e3
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(_PAGE_WIDTH, 2.2), layout="constrained")
        axis = figure.subplots()
        axis.hist(found, bins=60, color=_COLOURS[0])
        axis.axvline(0.0, color=_COLOURS[5], linewidth=0.8)
        axis.set(xlabel="deviation, mm", ylabel="places")
        axis.set_title("How often each deviation occurs", loc="left", fontweight="bold")
        return _drawn(figure, form)


def name_label(name: str) -> str:
    """A name that can be drawn: short, on one line, unknown signs as a box."""
    known = font_manager.get_font(font_manager.findfont("DejaVu Sans")).get_charmap()
    return "".join(c if ord(c) in known else "□" for c in short_name(name))


def _draw_plan(figure: Figure, plan: Axes, passes: tuple[FittedPass, ...]) -> None:
    values = np.concatenate([fitted.position_sigma for fitted in passes]) * 1e3
    low, high, _ = round_range(float(values.min()), float(values.max()))
    shades = colors.ListedColormap(quantity_table() / 255.0)
    for fitted in passes:
        points = fitted.strip.points[:, :2] * 1e3
        pieces = np.stack((points[:-1], points[1:]), axis=1)
        lines = LineCollection(
            list(pieces),
            cmap=shades,
            norm=colors.Normalize(low, high),
            linewidths=(2.6 if fitted.kind == "pass" else 1.6) * min(1.0, 24 / len(passes)),
            capstyle="round",
            rasterized=len(passes) > _MOST_NAMED,
        )
        sigma = fitted.position_sigma * 1e3
        lines.set_array(0.5 * (sigma[:-1] + sigma[1:]))
        plan.add_collection(lines)
    plan.set_aspect("equal", adjustable="datalim")
    plan.autoscale_view()
    plan.margins(0.08)
    if len(passes) <= _MOST_NAMED:
        _name_starts(plan, passes)
    plan.set(xlabel="x, mm", ylabel="y, mm")
    plan.set_title("Plan: passes seen from above", loc="left", fontweight="bold")
    bar = figure.colorbar(plan.collections[0], ax=plan, aspect=25, pad=0.01)
    bar.set_label("position uncertainty 1σ, mm")


def _name_starts(plan: Axes, passes: tuple[FittedPass, ...]) -> None:
    """The passes' names before their starts, with room for the longest beside the axis."""
    plan.margins(x=0.06 + 0.017 * max(len(name_label(fitted.name)) for fitted in passes))
    for fitted in passes:
        away = -fitted.strip.tangents[0][:2]
        plan.annotate(
            name_label(fitted.name),
            tuple(fitted.strip.points[0, :2] * 1e3),
            xytext=tuple(9 * away),
            textcoords="offset points",
            ha="right" if away[0] < -0.5 else "center",
            va="center",
        )


def _draw_profiles(profile: Axes, uncertainty: Axes, passes: tuple[FittedPass, ...]) -> None:
    looks = cycle(_LINES)
    for fitted, (colour, style) in zip(passes, looks, strict=False):
        s, z = fitted.strip.s * 1e3, fitted.strip.points[:, 2] * 1e3
        up = np.sqrt(fitted.covariance[:, 2, 2]) * 1e3
        look: dict[str, Any] = {"color": colour, "linestyle": style, "linewidth": 1.1}
        if len(passes) > _MOST_NAMED:
            look = _ONE_OF_MANY
        band: dict[str, Any] = {"color": look["color"], "rasterized": len(passes) > _MOST_NAMED}
        profile.fill_between(s, z - up, z + up, alpha=0.25, linewidth=0, **band)
        profile.plot(s, z, **look)
        uncertainty.plot(s, fitted.position_sigma * 1e3, **look)
    if len(passes) <= _MOST_NAMED:
        profile.legend(
            profile.lines,
            [name_label(fitted.name) for fitted in passes],
            loc="center left",
            bbox_to_anchor=(1.0, 0.5),
            frameon=False,
        )
    profile.set(ylabel="height z, mm")
    profile.set_title("Profiles: height along each pass, band ±1σ", loc="left", fontweight="bold")
    uncertainty.set(xlabel="along the ribbon, mm", ylabel="uncertainty 1σ, mm")
    uncertainty.set_ylim(bottom=0)
    uncertainty.set_title("Position uncertainty along each pass", loc="left", fontweight="bold")


def _draw_residuals(axis: Axes, reconstruction: Reconstruction, kind: SensorKind) -> Any:
    ribbon = reconstruction.ribbon
    places = ribbon.indices(kind)
    axes = max((ribbon.sensors[i].axes for i in places), default=1)
    values = np.array(
        [fitted.residuals[list(places), :axes].ravel() for fitted in reconstruction.passes]
    )
    shades = mpl.colormaps["RdBu_r"].with_extremes(bad="#8c9299")
    image = axis.imshow(
        np.ma.masked_invalid(values),
        aspect="auto",
        interpolation="nearest",
        cmap=shades,
        vmin=-_RESIDUAL_LIMIT,
        vmax=_RESIDUAL_LIMIT,
    )
    rows, columns = np.nonzero(np.abs(np.nan_to_num(values)) > _RESIDUAL_LIMIT)
    axis.plot(columns, rows, "x", color="black", markersize=4)
    _name_axes(axis, reconstruction, places, axes)
    letters = ", ".join("xyz"[:axes])
    axis.set_title(f"{kind.capitalize()}s, axes {letters}", loc="left", fontweight="bold")
    return image


def _name_axes(
    axis: Axes, reconstruction: Reconstruction, places: tuple[int, ...], axes: int
) -> None:
    """Sensor names under the columns and pass names beside the rows, as many as fit."""
    names = [reconstruction.ribbon.sensors[i].name for i in places]
    every = -(-len(names) // 32)
    at = np.arange(len(names)) * axes + (axes - 1) / 2
    axis.set_xticks(at[::every], [name_label(n) for n in names[::every]], rotation=90)
    axis.set_xticks(np.arange(1, len(names)) * axes - 0.5, minor=True)
    axis.grid(which="minor", axis="x", color="white", linewidth=1.2)
    axis.tick_params(which="both", length=0)
    rows = [name_label(fitted.name) for fitted in reconstruction.passes]
    fewer = -(-len(rows) // 24)
    axis.set_yticks(np.arange(len(rows))[::fewer], rows[::fewer])
    for spine in axis.spines.values():
        spine.set_visible(False)


def _drawn(figure: Figure, form: Form) -> bytes:
    target = io.BytesIO()
    # Neither the time nor the library's version: the same result gives the same bytes.
    metadata = {"Date": None} if form == "svg" else {"Software": None}
    figure.savefig(target, format=form, metadata=metadata, dpi=_DOTS_PER_INCH)
    return target.getvalue()
