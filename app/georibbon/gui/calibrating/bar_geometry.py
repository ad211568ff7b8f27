"""The bar on its table as flat shapes: what a picture of a pose is made of, without Qt.

World: x to the right, y away from the viewer, z up, in half lengths of the bar; a
heading of 0 lies from left to right, its start on the left.  Pictures have x to the
right and y down.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from georibbon.arrays import FloatArray

HALF = np.array([1.0, 0.2, 0.14])  # the bar's half length, width and height
TABLE = 1.32  # the radius of the compass on the table
BLOCK_AT, BLOCK_HALF = 0.72, np.array([0.14, 0.3])
CAMERA_TURN, CAMERA_RISE, CAMERA_AWAY = np.radians(-28.0), np.radians(27.0), 7.0
LIGHT = np.array([-0.45, -0.6, 0.66])
# Each face's outward normal, and the directions of its right and its top, as it is read.
FACES = {
    "top": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "under": ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
    "left": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "right": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "end": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "start": ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
}


@dataclass(frozen=True, eq=False)
class Face:
    """One face that is seen: corners (4, 2) top left, top right, bottom right, bottom left.

    shade: how much light falls on it, 0 to 1.
    """

    name: str
    corners: FloatArray
    shade: float


@dataclass(frozen=True, eq=False)
class BarPicture:
    """What is to be drawn, in this order.

    table: (n, 2) the compass' rim; ticks: (4, 2, 2) at 0, 90, 180 and 270 degrees;
    labels: (4, 2) where they are named; shadow: (m, 2); block: faces; bar: faces;
    heading: (2, 2) from the middle to where the bar's end points.
    """

    table: FloatArray
    ticks: FloatArray
    labels: FloatArray
    shadow: FloatArray
    block: tuple[Face, ...]
    bar: tuple[Face, ...]
    heading: FloatArray


def bar_picture(attitude: FloatArray, block: bool) -> BarPicture:
    """The picture of a bar with attitude (3, 3), ribbon to world, as it lies on the table.

    block: whether one end lies on a block.
    """
    corners = _corners(HALF) @ attitude.T
    lift = np.array([0.0, 0.0, -float(corners[:, 2].min())])
    around = np.linspace(0.0, 2.0 * np.pi, 41)
    rim = np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=1)
    quarters = rim[[0, 10, 20, 30]]
    floor = (corners + lift) * [1.0, 1.0, 0.0]
    ahead = attitude[:, 0] * [1.0, 1.0, 0.0]
    length = float(np.linalg.norm(ahead))
    ahead = ahead / length if length > 1e-6 else np.zeros(3)
    return BarPicture(
        project(TABLE * rim),
        np.stack([project(TABLE * quarters), project(0.93 * TABLE * quarters)], axis=1),
        project(1.13 * TABLE * quarters),
        _hull(project(floor)),
        _block(attitude, lift) if block else (),
        _faces(HALF, attitude, lift),
        project(np.stack([np.zeros(3), TABLE * ahead])),
    )


def project(points: FloatArray) -> FloatArray:
    """(n, 3) points of the world to (n, 2) of the picture, in perspective."""
    right, up, toward = _camera()
    depth = CAMERA_AWAY / (CAMERA_AWAY - points @ toward)
    return np.asarray(np.stack([points @ right, -(points @ up)], axis=-1) * depth[..., None])


def sees(normal: FloatArray, point: FloatArray) -> bool:
    """Whether a face with an outward normal at a point is seen."""
    return bool(normal @ (CAMERA_AWAY * _camera()[2] - point) > 1e-9)


@cache
def _camera() -> tuple[FloatArray, FloatArray, FloatArray]:
    """(3,) each: the picture's right, its top, and the direction from which one looks."""
    turn, rise = CAMERA_TURN, CAMERA_RISE
    right = np.array([np.cos(turn), np.sin(turn), 0.0])
    back = np.array([np.sin(turn), -np.cos(turn), 0.0])
    toward = np.cos(rise) * back + np.sin(rise) * np.array([0.0, 0.0, 1.0])
    return right, np.cross(toward, right), toward


def _corners(half: FloatArray) -> FloatArray:
    return np.array(list(product((-1.0, 1.0), repeat=3))) * half


def _faces(half: FloatArray, attitude: FloatArray, middle: FloatArray) -> tuple[Face, ...]:
    """The faces of a box that are seen."""
    found = []
    for name, (normal, right, top) in FACES.items():
        outward, across, along = (attitude @ np.array(v) for v in (normal, right, top))
        at = middle + outward * abs(np.array(normal) @ half)
        if not sees(outward, at):
            continue
        across, along = across * abs(np.array(right) @ half), along * abs(np.array(top) @ half)
        corners = at + np.array([-across + along, across + along, across - along, -across - along])
        shade = 0.5 + 0.5 * float(outward @ LIGHT)
        found.append(Face(name, project(corners), shade))
    return tuple(found)


def _block(attitude: FloatArray, lift: FloatArray) -> tuple[Face, ...]:
    """The block under the raised end: it reaches from the table to the bar's lowest edge there."""
    axis = attitude[:, 0]
    raised = 1.0 if axis[2] >= 0.0 else -1.0
    section = _corners(HALF * [0.0, 1.0, 1.0]) @ attitude.T
    under = raised * BLOCK_AT * axis + lift
    height = float(under[2] + section[:, 2].min())
    if height < 0.02:
        return ()
    flat = axis * [1.0, 1.0, 0.0]
    flat /= max(float(np.linalg.norm(flat)), 1e-9)
    turned = np.stack([flat, np.cross([0.0, 0.0, 1.0], flat), [0.0, 0.0, 1.0]], axis=1)
    middle = np.array([under[0], under[1], 0.5 * height])
    return _faces(np.append(BLOCK_HALF, 0.5 * height), turned, middle)


def _hull(points: FloatArray) -> FloatArray:
    """The corners of the convex hull of (n, 2) points, in order (Andrew 1979)."""
    ordered = sorted(map(tuple, points))
    rows = []
    for run in (ordered, ordered[::-1]):
        row: list[tuple[float, ...]] = []
        for point in run:
            while len(row) > 1 and _turn(row[-2], row[-1], point) <= 0.0:
                row.pop()
            row.append(point)
        rows += row[:-1]
    return np.array(rows)


def _turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
