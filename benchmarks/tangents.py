"""Curves from the tangents at a few places: how near they come, and what noise does to their ends.

Three curves whose frames are known are found again from 8 to 64 of their
tangents, evenly spaced, in each way that can be chosen; beside them great arcs
from tangent to tangent, and SciPy's spline of whole frames.  Then errors are
added to 16 tangents of the screw line, and the curve's end is compared with
what theory lets expect: sigma h sqrt(2 (n - 1.5)), h the distance of n sensors.

    .venv/bin/python benchmarks/tangents.py [--trials N]
"""

import argparse
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import lcm

import numpy as np
from scipy.spatial.transform import Rotation, RotationSpline
from support.tables import met, publish, table

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import Strip, arc_angles, frames_from, unit
from georibbon.geometry.geodesics import geodesic
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.spherical import GAUSS_POINTS, GAUSS_WEIGHTS, integrate_tangents
from georibbon.geometry.tangent_splines import SPLINES

COUNTS = (8, 16, 32, 64)
STEPS = lcm(*(count - 1 for count in COUNTS))  # of the exact curves: all sensors lie on them
SHOWN = 45  # steps between the places where curves are compared
LEAST_ORDER = 3.5
SIGMAS = (0.1, 0.25, 0.5, 1.0, 2.0)  # degrees
WITHIN = 0.13
SENSORS, PITCH = 16, 0.03

Make = Callable[[Strip], FloatArray]


def from_tangents(
    angles: Callable[[FloatArray], tuple[FloatArray, FloatArray]], s: FloatArray
) -> Strip:
    """The curve whose heading and slope, radians, are given by arc length; its exact integral."""

    def tangents(at: FloatArray) -> FloatArray:
        heading, slope = angles(at)
        level = np.cos(slope)
        return np.stack([level * np.cos(heading), level * np.sin(heading), np.sin(slope)], axis=-1)

    half, middle = 0.5 * np.diff(s)[:, None], 0.5 * (s[:-1] + s[1:])[:, None]
    steps = np.einsum("g,kgi->ki", GAUSS_WEIGHTS, tangents(middle + half * GAUSS_POINTS)) * half
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    upright = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    return Strip(s, points, frames_from(tangents(s), upright))


def screw_line(s: FloatArray) -> Strip:
    """A screw line of 150 mm radius that rises by 18 degrees."""
    slope = np.radians(18.0)
    return from_tangents(lambda at: (at * np.cos(slope) / 0.15, 0 * at + slope), s)


def bends(s: FloatArray) -> Strip:
    """Two bends each way within 0.90 m, up to 50 degrees aside and 10 up and down."""
    turn = 2 * np.pi / 0.45
    return from_tangents(
        lambda at: (np.radians(50.0) * np.sin(turn * at), np.radians(10.0) * np.cos(turn * at)), s
    )


def bonnet(s: FloatArray) -> Strip:
    """A geodesic over a rippled bonnet."""
    return geodesic(Bonnet(), (-0.4, 0.3), (1.0, 0.2, 0.0), s)


CURVES: Mapping[str, tuple[Callable[[FloatArray], Strip], float]] = {
    "screw line": (screw_line, 0.45),
    "bonnet": (bonnet, 0.90),
    "bends": (bends, 0.90),
}


@dataclass(frozen=True)
class GreatArcs:
    """Unit tangents along great arcs from sample to sample."""

    s: FloatArray
    tangents: FloatArray

    def __call__(self, s: FloatArray) -> FloatArray:
        """(k, 3) unit tangents at s (k,)."""
        k = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        here, there = self.tangents[k], self.tangents[k + 1]
        share = ((s - self.s[k]) / (self.s[k + 1] - self.s[k]))[:, None]
        angle = np.maximum(arc_angles(here, there), 1e-12)[:, None]
        return unit(np.sin((1 - share) * angle) * here + np.sin(share * angle) * there)


@dataclass(frozen=True)
class OfFrames:
    """Unit tangents of SciPy's spline of whole frames."""

    s: FloatArray
    spline: RotationSpline

    def __call__(self, s: FloatArray) -> FloatArray:
        """(k, 3) unit tangents at s (k,)."""
        return np.asarray(self.spline(s).as_matrix()[:, :, 0])


def ways(s: FloatArray) -> dict[str, Make]:
    """Every way from some frames to the curve at s."""

    def chosen(word: str) -> Make:
        made = SPLINES[word]
        return lambda some: integrate_tangents(made(some.s, some.tangents), s)

    return {
        **{word: chosen(word) for word in SPLINES},
        "great arcs": lambda some: integrate_tangents(GreatArcs(some.s, some.tangents), s),
        "SciPy, frames": lambda some: integrate_tangents(
            OfFrames(some.s, RotationSpline(some.s, Rotation.from_matrix(some.frames))), s
        ),
    }


def accuracy_table() -> str:
    """Greatest errors of position by way, curve and number of sensors; orders; times."""
    lines = []
    for name, (curve, length) in CURVES.items():
        exact = curve(np.linspace(0.0, length, STEPS + 1))
        s, truth = exact.s[::SHOWN], exact.points[::SHOWN] - exact.points[0]
        for word, make in ways(s).items():
            errors = []
            for count in COUNTS:
                some = sampled(exact, count)
                errors.append(1e3 * np.linalg.norm(make(some) - truth, axis=1).max())
            order = float(np.log(errors[1] / errors[3]) / np.log(63 / 15))
            asked = word in SPLINES
            lines.append(
                [
                    f"{name}, {length:.2f} m: {word}",
                    *(f"{error:.2g}" for error in errors),
                    f"{order:.1f}",
                    f"{LEAST_ORDER}" if asked else "-",
                    met(order >= LEAST_ORDER) if asked else "-",
                    f"{best_time(make, sampled(exact, 16)):.1f}",
                ]
            )
    header = [
        "greatest error, mm",
        *(f"{count} sensors" for count in COUNTS),
        "order",
        "asked",
        "verdict",
        "ms (16)",
    ]
    return "## Exact tangents\n\n" + table(header, lines)


def sampled(exact: Strip, count: int) -> Strip:
    """Some of the curve's frames, evenly spaced from end to end."""
    every = slice(None, None, STEPS // (count - 1))
    return Strip(exact.s[every], exact.points[every], exact.frames[every])


def best_time(make: Make, some: Strip) -> float:
    """Milliseconds, the least of several runs."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        make(some)
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def noise_table(trials: int) -> str:
    """Errors of the curve's end from tangents with errors, against what is expected."""
    length = PITCH * (SENSORS - 1)
    exact = screw_line(np.linspace(0.0, length, STEPS + 1))
    some, end = sampled(exact, SENSORS), exact.points[-1] - exact.points[0]
    ends, lines = np.array([0.0, length]), []
    for sigma in SIGMAS:
        expected = 1e3 * np.radians(sigma) * PITCH * np.sqrt(2 * (SENSORS - 1.5))
        random = np.random.default_rng(15)
        draws = [disturbed(some, np.radians(sigma), random) for _ in range(trials)]
        for word in SPLINES:
            made = SPLINES[word]
            away = [integrate_tangents(made(some.s, one), ends)[1] - end for one in draws]
            found = 1e3 * float(np.sqrt(np.mean(np.sum(np.square(away), axis=1))))
            lines.append(
                [
                    f"{sigma:g}°: {word}",
                    f"{expected:.3f} ± {WITHIN:.0%}",
                    f"{found:.3f}",
                    f"{0.1 * found / length:.2f} %",
                    met(abs(found / expected - 1) <= WITHIN),
                ]
            )
    header = [
        "error a sensor and axis",
        "expected at the end, mm",
        "found, mm",
        "of length",
        "verdict",
    ]
    return (
        f"## Tangents with errors\n\n{SENSORS} sensors, {1e3 * PITCH:.0f} mm apart, {trials} draws "
        "of errors; root of the mean square.\n\n" + table(header, lines)
    )


def disturbed(some: Strip, sigma: float, random: np.random.Generator) -> FloatArray:
    """The tangents, each turned about its conormal and its normal by random angles."""
    turns = sigma * random.standard_normal((len(some.s), 2, 1))
    aside = turns[:, 0] * some.conormals + turns[:, 1] * some.normals
    return unit(some.tangents + aside)


def main() -> None:
    """Measure, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--trials", type=int, default=200, help="draws of errors (default 200)")
    asked = parser.parse_args()
    publish("tangents", ["# Curves from tangents", accuracy_table(), noise_table(asked.trials)])


if __name__ == "__main__":
    main()
