"""Where the camera stands so that everything is seen, as large as it fits."""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.world import UP

# From where a person would look first, best first; the last four look from underneath.
_DIRECTIONS = np.array(
    [[x, y, z] for z in (0.95, -0.95) for x, y in ((-0.7, -1), (0.7, -1), (-0.7, 1), (0.7, 1))]
)
_NORTH = np.array([0.0, 1.0, 0.0])
_VERTICAL = 1e-6  # radians from looking along z
_ANGLE = np.radians(24.0)  # the full vertical one: a moderate telephoto, with little distortion


@dataclass(frozen=True, eq=False)
class View:
    """Where the camera stands and how it is turned.

    position, focus: (3,) metres; up: (3,) unit; angle: radians, the full vertical
    one.  half_height: metres, what a parallel projection shows above the focus.
    """

    position: FloatArray
    focus: FloatArray
    up: FloatArray
    angle: float
    half_height: float


@dataclass(frozen=True)
class Region:
    """The part of the picture to fill: shares of its half width and height from the middle."""

    left: float = 0.9
    right: float = 0.9
    bottom: float = 0.9
    top: float = 0.9


def view_direction(normals: FloatArray) -> FloatArray:
    """(3,) unit vector from the object to the camera, on the side the normals point to.

    normals: (n, 3) outward unit normals.  One of eight fixed directions, z up in
    the picture; among equally good ones the earlier.
    """
    directions = _DIRECTIONS / np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)
    mean = normals.mean(axis=0)
    preference = -0.1 * np.arange(len(directions))
    chosen: FloatArray = directions[int(np.argmax(directions @ mean + preference))]
    return chosen


def fit_view(
    points: FloatArray,
    direction: FloatArray,
    aspect: float,
    region: Region,
    parallel: bool = False,
) -> View:
    """The nearest view along `direction` from which all points lie in the region.

    points: (n, 3) metres; aspect: width over height of the picture; parallel:
    whether lines that are parallel are drawn so.  z is up in the picture, and
    y where the camera looks along z.  In camera
    axes (right r, up u, towards the camera w) a point at distance D - w in front
    of the camera is inside the right edge when r - c <= a (D - w), with a the
    tangent of that edge; so for each pair of opposite edges max(r + a w) - c <= a D
    and max(-r + b w) + c <= b D, whose sum gives the smallest D.
    In parallel projection w plays no part; D is then the distance at which the
    perspective would show the focus as large, and the camera stands as far off
    that nothing is behind it.
    """
    right = np.cross(UP, direction)
    if np.linalg.norm(right) < _VERTICAL:
        right = np.cross(_NORTH, direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    origin = points.mean(axis=0)
    r, u, w = ((points - origin) @ np.column_stack((right, up, direction))).T
    half = np.tan(_ANGLE / 2)
    nearest = float(w.max())
    if parallel:
        w = np.zeros_like(w)
    across = _Edges(r, w, half * aspect * region.left, half * aspect * region.right)
    upward = _Edges(u, w, half * region.bottom, half * region.top)
    distance = max(across.distance, upward.distance)
    focus = origin + across.centre(distance) * right + upward.centre(distance) * up
    away = max(distance, 2.0 * nearest) if parallel else distance
    half_height = float(half * distance)
    return View(focus + away * direction, focus, up, float(_ANGLE), half_height)


class _Edges:
    """Two opposite edges of the picture and what they ask of the camera."""

    def __init__(self, along: FloatArray, depth: FloatArray, low: float, high: float) -> None:
        self.low, self.high = low, high
        self.below = float(np.max(-along + low * depth))
        self.above = float(np.max(along + high * depth))

    @property
    def distance(self) -> float:
        """The smallest distance at which both edges can be kept."""
        return (self.below + self.above) / (self.low + self.high)

    def centre(self, distance: float) -> float:
        """The middle of the shifts that keep both edges from this distance."""
        return 0.5 * (self.above - self.high * distance + self.low * distance - self.below)
