"""Passes on known surfaces, for the tests of the geometry."""

from collections.abc import Sequence

import numpy as np

from georibbon.geometry.frames import Strip
from georibbon.geometry.geodesics import directions_at, geodesics
from georibbon.geometry.reference import ReferenceSurface

OFFSETS = (-0.2, -0.1, 0.0, 0.1, 0.2)


def passes(
    surface: ReferenceSurface,
    places: Sequence[tuple[float, float]],
    angles: Sequence[float] | float = 0.0,
    length: float = 0.96,
    count: int = 97,
    shifts: Sequence[float] | float = 0.0,
) -> list[Strip]:
    """Geodesics through places (u, v), turned by angles from the u direction, in their order.

    Their middles lie `shifts` metres beyond the places.
    """
    s = np.linspace(-0.5 * length, 0.5 * length, count)
    uv = np.array(places, dtype=float)
    turned = np.broadcast_to(np.asarray(angles, dtype=float), len(uv))
    own = s + np.broadcast_to(np.asarray(shifts, dtype=float), len(uv))[:, None]
    every = np.unique(own)
    strips = geodesics(surface, uv, directions_at(surface, uv, turned), every, 1e-10)
    return [cut(strip, np.searchsorted(every, s)) for strip, s in zip(strips, own, strict=True)]


def cut(strip: Strip, rows: np.ndarray) -> Strip:
    """Some points of a strip, its arc length from the first."""
    s = strip.s[rows]
    return Strip(s - s[0], strip.points[rows], strip.frames[rows])


def plane_passes(*args: float, **more: object) -> list[Strip]:
    """Passes along x on the level plane at the given y."""
    strips = []
    for y, s in zip(args, places_along(len(args), **more), strict=True):
        points = np.stack([s, np.full_like(s, y), np.zeros_like(s)], axis=1)
        strips.append(Strip(s - s[0], points, np.tile(np.eye(3), (len(s), 1, 1))))
    return strips


def sphere_passes(
    offsets: Sequence[float] = OFFSETS, radius: float = 0.6, **more: object
) -> list[Strip]:
    """Great circles over the top of a sphere, `offsets` metres apart along its equator."""
    return [
        great_circle(radius, offset / radius, s)
        for offset, s in zip(offsets, places_along(len(offsets), **more), strict=True)
    ]


def places_along(
    count: int,
    length: float = 0.96,
    nodes: int = 97,
    shifts: Sequence[float] | float = 0.0,
) -> np.ndarray:
    """(count, nodes) signed distances from the middle."""
    s = np.linspace(-0.5 * length, 0.5 * length, nodes)
    return s + np.broadcast_to(np.asarray(shifts, dtype=float), count)[:, None]


def great_circle(radius: float, tilt: float, s: np.ndarray) -> Strip:
    """The great circle in the x direction, tilted about x, in closed form."""
    across = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    ahead = np.array([1.0, 0.0, 0.0])
    sine, cosine = np.sin(s / radius)[:, None], np.cos(s / radius)[:, None]
    normals = sine * ahead + cosine * across
    tangents = cosine * ahead - sine * across
    frames = np.stack([tangents, np.cross(normals, tangents), normals], axis=2)
    return Strip(s - s[0], radius * normals, frames)


def moved(strip: Strip, turn: np.ndarray, shift: np.ndarray) -> Strip:
    """The strip moved rigidly."""
    return Strip(strip.s, strip.points @ turn.T + shift, turn @ strip.frames)


def upside_down(strip: Strip) -> Strip:
    """The strip with its normals on the other side."""
    return Strip(strip.s, strip.points, strip.frames * np.array([1.0, -1.0, -1.0]))
