"""The curves that figures are given: exact, with the frames that one reads off them."""

from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_simpson

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import Strip, cross, dot, unit


class Jet(NamedTuple):
    """A curve at n parameters t (n,): its points and first two derivatives by t, (n, 3) each."""

    t: FloatArray
    points: FloatArray
    first: FloatArray
    second: FloatArray


def half_ellipse(across: float, along: float, up: float, count: int = 121) -> Jet:
    """The upper half of an ellipse in the plane y = across, its half axes along x and z, metres."""
    t = np.linspace(0.0, np.pi, count)
    c, s, zero = np.cos(t), np.sin(t), np.zeros(count)
    return Jet(
        t,
        np.stack([-along * c, across + zero, up * s], axis=1),
        np.stack([along * s, zero, up * c], axis=1),
        np.stack([along * c, zero, -up * s], axis=1),
    )


def twisted_arc(across: float, lean: float, twist: float, count: int = 121) -> Jet:
    """An arc of a circle of 0.3 m that leans (radians) to the side and leaves its plane.

    twist: metres, by which it runs off across, in proportion to the third power of the angle.
    """
    t, radius = np.linspace(-0.9, 0.9, count), 0.3
    c, s = np.cos(t), np.sin(t)
    up = np.array([0.0, np.sin(lean), np.cos(lean)])
    ahead, side = np.array([1.0, 0.0, 0.0]), np.array([0.0, np.cos(lean), -np.sin(lean)])
    return Jet(
        t,
        np.array([0.0, across, 0.0])
        + radius * (np.outer(s, ahead) + np.outer(c, up))
        + twist * np.outer(t**3, side),
        radius * (np.outer(c, ahead) - np.outer(s, up)) + 3.0 * twist * np.outer(t**2, side),
        -radius * (np.outer(s, ahead) + np.outer(c, up)) + 6.0 * twist * np.outer(t, side),
    )


def waved(across: float, height: float, shift: float = 0.0, count: int = 180) -> Jet:
    """An S in the plane y = across: most of a wave of 0.6 m, so high; shift: radians of phase."""
    t = np.linspace(-0.26, 0.26, count)
    k, zero = 2.0 * np.pi / 0.6, np.zeros(count)
    phase = k * t + shift
    return Jet(
        t,
        np.stack([t, across + zero, height * np.sin(phase)], axis=1),
        np.stack([zero + 1.0, zero, height * k * np.cos(phase)], axis=1),
        np.stack([zero, zero, -height * k * k * np.sin(phase)], axis=1),
    )


def screw(radius: float, length: float, turns: float, count: int = 181) -> Jet:
    """A slender screw about the x axis, metres; its binormal turns about it as often."""
    t = np.linspace(-0.5, 0.5, count)
    k, zero = 2.0 * np.pi * turns, np.zeros(count)
    c, s = np.cos(k * t), np.sin(k * t)
    return Jet(
        t,
        np.stack([length * t, radius * s, radius * c], axis=1),
        np.stack([zero + length, radius * k * c, -radius * k * s], axis=1),
        np.stack([zero, -radius * k * k * s, -radius * k * k * c], axis=1),
    )


def flat_arc(across: float, length: float, radius: float, count: int = 181) -> Jet:
    """An arc over the x axis in the plane y = across, so long, metres."""
    t = np.linspace(-0.5, 0.5, count) * length / radius
    c, s, zero = np.cos(t), np.sin(t), np.zeros(count)
    return Jet(
        t,
        radius * np.stack([s, across / radius + zero, c - 1.0], axis=1),
        radius * np.stack([c, zero, -s], axis=1),
        radius * np.stack([-s, zero, -c], axis=1),
    )


def binormals(jet: Jet) -> FloatArray:
    """(n, 3) the unit binormals f' x f'' of a curve, as they come: they jump at an inflection."""
    return unit(cross(jet.first, jet.second))


def towards(vectors: FloatArray, ahead: FloatArray) -> FloatArray:
    """(n, 3) the same vectors, each turned round where it points away from `ahead` (n, 3)."""
    turned: FloatArray = np.where(dot(vectors, ahead) < 0.0, -1.0, 1.0)[:, None] * vectors
    return turned


def strip_along(jet: Jet, conormals: FloatArray) -> Strip:
    """The curve with these unit conormals (n, 3) and the normals N = tau x V."""
    speed = np.sqrt(dot(jet.first, jet.first))
    s = cumulative_simpson(speed, x=jet.t, initial=0.0)
    tangents = unit(jet.first)
    normals = cross(tangents, conormals)
    return Strip(s, jet.points, np.stack([tangents, conormals, normals], axis=-1))
