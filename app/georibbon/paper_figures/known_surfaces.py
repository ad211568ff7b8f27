"""Figures 7 to 11 and 16: surfaces that are known, rebuilt from geodesics laid on them."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.arch import LENGTH, arch, arch_strips
from georibbon.geometry.closed_geodesics import (
    cone_distances,
    cone_geodesic,
    sphere_geodesic,
)
from georibbon.geometry.frames import Strip, cross, dot, unit
from georibbon.geometry.frenet import curvature_vectors, curve_through
from georibbon.geometry.reference import Cone, Ellipsoid, ReferenceSurface
from georibbon.geometry.settings import LengthRule, SurfaceSettings
from georibbon.geometry.spherical import interpolate_frames
from georibbon.paper_figures.building import (
    DEFAULT,
    distances,
    error_numbers,
    laid_by,
    length_numbers,
    model_of,
    shape_numbers,
    skew,
    verdict_of,
)
from georibbon.paper_figures.figure import Choice, Curve, Figure, Model, Whose
from georibbon.rotations import exp

NEAREST = 0.25  # m
MANY_BOUNDED = 50.0  # percent of the lines
COLOURS = "distance to the true surface, mm"
PITCH, SITES = 0.03, 26
SENSOR_ERROR = float(np.radians(0.25))


@cache
def arch_passes() -> tuple[Strip, ...]:
    """The five geodesics of the arch, every 4 mm; they take seconds to follow."""
    return arch_strips(samples=181)


def figure_7() -> Figure:
    """The paper's criteria for the tangent lengths."""
    truth, strips = arch(), arch_passes()[1:3]
    words: dict[str, tuple[str, LengthRule]] = {
        "criterion 1": ("the speed varies least", "criterion1"),
        "criterion 2": ("the curvature varies least", "criterion2"),
        "criterion 3": ("least torsion, by lengths", "criterion3"),
        "criterion 4": ("least torsion, by angles", "criterion4"),
    }
    choices = [
        _scored(
            f"{name}: {told}",
            "paper",
            SurfaceSettings(direction="conormal", lengths=rule, correspondence="fraction"),
            strips,
            truth,
            lengths=True,
        )
        for name, (told, rule) in words.items()
    ]
    choices.append(_scored("Georibbon's default", "georibbon", None, strips, truth, lengths=True))
    return Figure(
        7,
        "The four criteria",
        "The second and third of five geodesics over an uneven arch, a rational bicubic surface of "
        "two radians with a net of 8 by 7 points; lines across along the conormals. The true "
        "surface is known.",
        "One patch four times, its starting and arrival vectors chosen by each of the four "
        "criteria; the fourth is judged the best, and the third oscillates.",
        "The third has no minimum inside: it runs to its lower bound, a quarter of the chord, and "
        "errs most. The fourth, as printed, runs to its bounds as well; it is offered held near "
        "the angles that have no torsion at all, and is then as good as the first. Lengths of an "
        "arc, the default, take no search and are as good as either.",
        tuple(choices),
        main=("rms_mm", "max_mm", "lambda_least", "lambda_greatest"),
        towards=(-0.55, -0.75, 1.0),
        colours=COLOURS,
    )


def figure_8() -> Figure:
    """The geodesics of a cone in closed form."""
    angle = np.radians(30.0)
    choices = (
        _cone_curve("A = arctan a", "paper", angle, float(np.arctan(angle))),
        _cone_curve("A = tan a", "other", angle, float(np.tan(angle))),
        _cone_curve("A = 1 / tan a", "georibbon", angle, 1.0 / float(np.tan(angle))),
    )
    return Figure(
        8,
        "A geodesic of a cone",
        f"A cone of half angle a = 30° and the curve {NEAREST:.2f} m from its axis where it is "
        "nearest, over 2 rad about the axis, by the printed formula, its constant A read in three "
        "ways.",
        "The cone's geodesics in closed form, with a constant A printed as the tangent of a to "
        "the power of -1; the curves of figures 9 and 10 are such geodesics.",
        "The power is meant, not the inverse function: with A = 1 / tan a the curve has no "
        "geodesic curvature but rounding's, with the other readings it is no geodesic of the "
        "cone that it lies on: it bends sideways, as the arrows tell. At 45° the last two are the "
        "same, so 45° proves nothing.",
        choices,
        main=("geodesic_curvature_max_per_m",),
        towards=(-0.9, -0.5, 0.5),
    )


def _cone_curve(name: str, whose: Whose, half_angle: float, slope: float) -> Choice:
    """The curve u0 / cos(v sin a) (cos v, sin v, A) on the cone z = -A r."""
    v = np.linspace(-1.0, 1.0, 401)
    radius = NEAREST / np.cos(v * np.sin(half_angle))
    points = np.stack([-radius * np.cos(v), -radius * np.sin(v), -slope * radius], axis=1)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    tangents, bent = curvature_vectors(curve_through(s, points), s)
    normals = unit(np.stack([-np.cos(v) * slope, -np.sin(v) * slope, np.ones_like(v)], axis=1))
    aside = cross(normals, tangents)
    sideways = dot(bent, aside)
    numbers = {"geodesic_curvature_max_per_m": float(np.abs(sideways[20:-20]).max())}
    verdict = "a geodesic" if numbers["geodesic_curvature_max_per_m"] < 1e-2 else "no geodesic"
    settings = f"half angle 30°, A = {slope:.4f}"
    some = slice(20, -20, 30)
    arrows = points[some], points[some] + 0.04 * sideways[some, None] * aside[some]
    return Choice(name, whose, settings, numbers, verdict, _cone_model(slope, points, arrows))


def _cone_model(slope: float, points: FloatArray, arrows: tuple[FloatArray, FloatArray]) -> Model:
    around, radii = np.linspace(1.35, -1.35, 61), np.linspace(0.02, 0.5, 31)
    v, r = np.meshgrid(around, radii, indexing="ij")
    grid = np.stack([-r * np.cos(v), -r * np.sin(v), -slope * r], axis=-1)
    normals = unit(np.stack([-np.cos(v) * slope, -np.sin(v) * slope, np.ones_like(v)], axis=-1))
    return Model(grids=(grid,), normals=(normals,), curves=(Curve(points),), arrows=arrows)


def cone_rows(shift: float, span: float = 2.0) -> tuple[Cone, list[Strip]]:
    """Two geodesics of a cone of 30 degrees, 0.30 and 0.39 m from its axis where they are nearest.

    Each spans an angle about the axis, radians; one is shifted about it against the other.
    """
    cone, strips = Cone(30.0), []
    for nearest, side in ((0.3, -0.5), (0.39, 0.5)):
        ends = np.array([-0.5, 0.5]) * span + side * shift
        first, last = cone_distances(cone, nearest, ends).tolist()
        strips.append(cone_geodesic(cone, nearest, 0.0, np.linspace(first, last, 121)))
    return cone, strips


def sphere_rows() -> tuple[Ellipsoid, list[Strip]]:
    """Two great circles of a sphere of 0.6 m, 0.155 m apart, shifted by 88 mm along themselves."""
    radius, ahead = 0.6, np.array([1.0, 0.0, 0.0])
    strips = []
    for side in (-1.0, 1.0):
        angle = side * 0.5 * 0.155 / radius
        place = radius * np.array([0.0, np.sin(angle), np.cos(angle)])
        s = side * 0.044 + np.linspace(-0.36, 0.36, 121)
        strips.append(sphere_geodesic(radius, place, ahead, s))
    return Ellipsoid(radius, radius, radius), strips


def figure_9() -> Figure:
    """A cone from two geodesics that are level with each other."""
    truth, strips = cone_rows(0.0)
    return Figure(
        9,
        "A cone, curves level",
        "Two geodesics of a cone of half angle 30°, 0.30 and 0.39 m from its axis, over the same "
        "2 rad about it: points at equal shares of the lengths lie on one ruling.",
        "The cone rebuilt from two of its geodesics, with curves that begin and end on the same "
        "rulings.",
        "Along the chord, matched by equal shares, every line across is a ruling of the cone and "
        "the surface is exact to rounding; along the binormals it is not. The default matches "
        "points by their feet, which do not lie on rulings, and errs by micrometres.",
        _three(strips, truth),
        main=("rms_mm", "max_mm", "skew_greatest_deg"),
        towards=(0.95, -0.35, 0.5),
        colours=COLOURS,
    )


def figure_10() -> Figure:
    """The same, shifted."""
    truth, strips = cone_rows(0.2)
    return Figure(
        10,
        "A cone, curves shifted",
        "The geodesics of figure 9, shifted by 0.2 rad about the axis against each other, matched "
        "by equal shares of their lengths.",
        "With curves that do not begin on the same rulings, binormals as starting vectors distort "
        "the cone; vectors along the projected chord mend it.",
        "So it is here, by two orders of magnitude. Matching points by their feet, as the default "
        "does, mends it for either kind of vector.",
        _three(strips, truth),
        main=("rms_mm", "max_mm", "skew_greatest_deg"),
        towards=(0.95, -0.35, 0.5),
        colours=COLOURS,
    )


def figure_11() -> Figure:
    """A sphere, shifted."""
    truth, strips = sphere_rows()
    return Figure(
        11,
        "A sphere, curves shifted",
        "Two great circles of a sphere of 0.60 m radius, 0.155 m apart in their middles, 0.72 m "
        "long, shifted by 88 mm along themselves.",
        "The same on a sphere: along the projected chord the patch follows it, along the binormals "
        "it does not.",
        "With lengths of an arc and points matched by their feet the lines across are arcs of "
        "circles on the sphere, to a fraction of a micrometre.",
        _three(strips, truth),
        main=("rms_mm", "max_mm", "skew_greatest_deg"),
        towards=(-0.3, -0.8, 1.0),
        colours=COLOURS,
    )


def _three(strips: Sequence[Strip], truth: ReferenceSurface) -> tuple[Choice, ...]:
    """Along binormals, along the chord, and the default."""
    plain = SurfaceSettings(direction="conormal", lengths="unit", correspondence="fraction")
    along = SurfaceSettings(direction="chord", lengths="unit", correspondence="fraction")
    return (
        _scored("binormals, λ = 1", "paper", plain, strips, truth),
        _scored("projected chord, λ = 1", "paper", along, strips, truth),
        _scored("Georibbon's default", "georibbon", None, strips, truth),
    )


def figure_16() -> Figure:
    """A whole surface from five geodesics."""
    truth, strips = arch(), arch_passes()
    plain = SurfaceSettings(direction="conormal", lengths="unit", correspondence="fraction")
    sensed = [from_sensors(one, k) for k, one in enumerate(strips)]
    return Figure(
        16,
        "A surface through five geodesics",
        f"The uneven arch of figure 7 with all five geodesics, {LENGTH:.2f} m long, 69 mm apart "
        f"in the mean: exact, and as {SITES} sensors {1e3 * PITCH:.0f} mm apart tell them with "
        "errors of 0.25° each, their middles placed exactly.",
        "A free-form surface, geodesics followed on it by computation, and the surface rebuilt "
        "from them.",
        "Exact curves give the surface within two tenths of a millimetre whatever the choice, as "
        "far as the gaps allow; what limits a measured one is the sensors' angles.",
        (
            _scored("binormals, λ = 1", "paper", plain, strips, truth),
            _scored("Georibbon's default", "georibbon", None, strips, truth),
            _scored("default, sensors with 0.25°", "georibbon", None, sensed, truth),
        ),
        main=("rms_mm", "max_mm"),
        towards=(-0.55, -0.75, 1.0),
        colours=COLOURS,
    )


def from_sensors(strip: Strip, seed: int, sigma: float = SENSOR_ERROR) -> Strip:
    """The strip that sensors would tell of it, each frame wrong by sigma (radians) about each axis.

    Its middle lies where the strip's does.
    """
    random = np.random.default_rng(16 + seed)
    length = strip.s[-1] - strip.s[0]
    at = 0.5 * (length - PITCH * (SITES - 1)) + PITCH * np.arange(SITES)
    at = at[(at >= 0.0) & (at <= length)]
    nodes = np.array([int(np.argmin(np.abs(strip.s - strip.s[0] - one))) for one in at])
    frames = strip.frames[nodes] @ exp(sigma * random.normal(size=(len(nodes), 3)))
    found = interpolate_frames(strip.s[nodes], frames, strip.s)
    middle = len(strip.s) // 2
    moved = found.points - found.points[middle] + strip.points[middle]
    return Strip(found.s, moved, found.frames)


def _scored(
    name: str,
    whose: Whose,
    settings: SurfaceSettings | None,
    strips: Sequence[Strip],
    truth: ReferenceSurface,
    lengths: bool = False,
) -> Choice:
    built = laid_by(strips, settings)
    away = distances(built, truth)
    numbers = error_numbers(away) | shape_numbers(built)
    numbers |= length_numbers(built) if lengths else {"skew_greatest_deg": skew(built)}
    verdict = verdict_of(numbers)
    if numbers.get("bounded_percent", 0.0) > MANY_BOUNDED:
        verdict += ", at its bounds"
    drawing = model_of(built, strips, values=np.abs(away))
    return Choice(name, whose, _told(settings), numbers, verdict, drawing)


def _told(settings: SurfaceSettings | None) -> str:
    if settings is None:
        return DEFAULT
    return f"{settings.direction}, {settings.lengths}, {settings.correspondence}"
