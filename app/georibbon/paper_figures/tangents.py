"""Figure 15: a curve from the tangents that sensors on it tell."""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import unit
from georibbon.geometry.spherical import MakeSpline, SphericalSpline, integrate_tangents
from georibbon.geometry.spherical_averages import AverageSpline
from georibbon.geometry.tangent_splines import ComponentSpline
from georibbon.paper_figures.building import Numbers
from georibbon.paper_figures.figure import Choice, Figure, Line, Plot, Whose

SENSORS, PITCH = 16, 0.03
RADIUS, RISE = 0.06, 0.03  # m, and m a radian
LENGTH = PITCH * (SENSORS - 1)
SENSOR_ERROR = float(np.radians(0.25))
DRAWS = 40


def helix(s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points and unit tangents (n, 3) at arc lengths s (n,) of a screw line, from the origin."""
    speed = np.hypot(RADIUS, RISE)
    c, w = np.cos(s / speed), np.sin(s / speed)
    points = np.stack([RADIUS * (c - 1.0), RADIUS * w, RISE * s / speed], axis=1)
    tangents = np.stack([-RADIUS * w, RADIUS * c, np.full_like(s, RISE)], axis=1) / speed
    return points, tangents


def figure_15() -> Figure:
    """A screw line from sixteen tangents."""
    makes: list[tuple[str, Whose, str, MakeSpline]] = [
        ("spherical averages", "paper", "averages", AverageSpline),
        ("components, made unit", "other", "components", ComponentSpline),
        ("Georibbon's default: unrolled", "georibbon", "unrolled", SphericalSpline),
    ]
    return Figure(
        15,
        "A curve from its tangents",
        f"A screw line of {1e3 * RADIUS:.0f} mm radius, {LENGTH:.2f} m long, with {SENSORS} "
        f"sensors every {1e3 * PITCH:.0f} mm, each telling the tangent: exactly, and with errors "
        f"of 0.25° about both axes, {DRAWS} draws.",
        "A curve found again from the tangents at the sensors alone, by a smooth spherical curve "
        "through them and its integral.",
        "All smooth spherical curves do equally well: with exact tangents they err by a hundredth "
        "of a millimetre, and with the sensors' errors all drift alike, as these let expect. "
        "Spherical averages stand for the paper's own spherical spline here.",
        tuple(_choice(*one) for one in makes),
        ("curve_error_max_mm", "end_error_mm", "end_error_expected_mm"),
    )


def _choice(
    name: str,
    whose: Whose,
    settings: str,
    make: MakeSpline,
) -> Choice:
    knots, s = np.linspace(0.0, LENGTH, SENSORS), np.linspace(0.0, LENGTH, 301)
    points, true = helix(s)[0], helix(knots)[1]
    exact = 1e3 * np.linalg.norm(integrate_tangents(make(knots, true), s) - points, axis=1)
    random = np.random.default_rng(15)
    errors = np.stack(
        [
            1e3 * np.linalg.norm(integrate_tangents(make(knots, one), s) - points, axis=1)
            for one in (disturbed(true, random) for _ in range(DRAWS))
        ]
    )
    drift = np.sqrt(np.mean(errors**2, axis=0))
    expected = 1e3 * expected_end_error()
    verdict = "drifts as expected" if drift[-1] < 1.25 * expected else "drifts more than expected"
    numbers: Numbers = {
        "curve_error_max_mm": float(exact.max()),
        "end_error_mm": float(drift[-1]),
        "end_error_percent": 0.1 * float(drift[-1]) / LENGTH,
        "end_error_expected_mm": expected,
    }
    lines = (
        Line("exact tangents", 1e3 * s[1:], exact[1:]),
        Line("errors of 0.25° (rms of the draws)", 1e3 * s[1:], drift[1:]),
    )
    plot = Plot("along the curve, mm", "distance to the true curve, mm", lines, logarithmic=True)
    return Choice(name, whose, f"tangents {settings}", numbers, verdict, plot)


def disturbed(tangents: FloatArray, random: np.random.Generator) -> FloatArray:
    """(n, 3) unit tangents, each turned about two axes square to it by errors of 0.25°."""
    away = SENSOR_ERROR * random.normal(size=tangents.shape)
    return unit(tangents + away - np.sum(away * tangents, axis=1, keepdims=True) * tangents)


def expected_end_error() -> float:
    """Metres: sigma h sqrt(2 (n - 3/2)), the end's rms error by the sensors' errors alone.

    Each of n tangents counts over its pitch h, the outer two over half of it.
    """
    return float(SENSOR_ERROR * PITCH * np.sqrt(2.0 * (SENSORS - 1.5)))
