"""The motion that lays one surface best onto another."""

from dataclasses import dataclass

import numpy as np

from georibbon import rotations
from georibbon.arrays import FloatArray
from georibbon.geometry.deviation import FARTHEST, deviation_from
from georibbon.geometry.nearest import TriangleLocator

_TRIED, _USED = 250, 1500  # points for choosing a start, and for the motion itself
_TRIAL_STEPS, _STEPS = 12, 40
_ALIKE = 3.0  # a dome fits nearly as well the other way round
_OUTLIER = 4.0  # of the median: what is farther away does not pull
_LEAST_OVER = 6
_PULL, _REACH = 0.1, 1e-4  # weight beside 1, and share of the size up to which it grows
_AT_REST = 1e-6  # of the size
_WEAK = 1e-5  # of the strongest: how little the surface may hold in a direction before it is left


@dataclass(frozen=True, eq=False)
class Motion:
    """A rigid motion x -> rotation x + translation; rotation (3, 3), translation (3,) metres."""

    rotation: FloatArray
    translation: FloatArray

    def applied(self, points: FloatArray) -> FloatArray:
        """The points (n, 3) where the motion carries them."""
        return points @ self.rotation.T + self.translation

    def turned(self, vectors: FloatArray) -> FloatArray:
        """The directions (n, 3) as the motion turns them."""
        return vectors @ self.rotation.T

    @property
    def angle(self) -> float:
        """Radians by which it turns."""
        return float(np.linalg.norm(rotations.log(self.rotation)))


STILL = Motion(np.eye(3), np.zeros(3))


def align(points: FloatArray, reference: TriangleLocator, middles: FloatArray) -> Motion:
    """The motion of points (n, 3) that lays them best onto the reference mesh.

    middles: (m, 3) points spread over the reference.  The least squares of the
    distances along the normals (Chen and Medioni 1992), what is far away left
    out, step by step from the best of six starts: as they are, middle onto
    middle, and principal axes onto principal axes.  What lies beyond the border
    is drawn to it a little, so that a surface that could slide along itself
    stays over the other.  The same input gives the same motion.
    """
    few = _some(points, _TRIED)
    starts = [STILL, *_starts(points, middles)]
    tried = [_followed(few, reference, start, _TRIAL_STEPS) for start in starts]
    misses = np.array([_miss(one.applied(few), reference) for one in tried])
    # Of those that fit alike the first: a surface that fits as it lies is not turned about.
    best = int(np.argmax(misses <= _ALIKE * misses.min() + 1e-6 * reference.size))
    return _followed(_some(points, _USED), reference, tried[best], _STEPS)


def _some(points: FloatArray, count: int) -> FloatArray:
    """About `count` of the points, evenly taken."""
    places = np.unique(np.linspace(0, len(points) - 1, min(count, len(points))).astype(np.int64))
    return points[places]


def _starts(points: FloatArray, middles: FloatArray) -> list[Motion]:
    here, there = points.mean(axis=0), middles.mean(axis=0)
    mine, other = _axes(points - here), _axes(middles - there)
    turns = [np.eye(3)]
    for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        flips = np.diag([*signs, signs[0] * signs[1]]).astype(np.float64)
        turns.append(other @ flips @ mine.T)
    return [Motion(turn, there - turn @ here) for turn in turns]


def _axes(points: FloatArray) -> FloatArray:
    """(3, 3) the principal axes as columns, right-handed."""
    axes = np.linalg.eigh(points.T @ points)[1][:, ::-1].copy()
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return axes


def _miss(points: FloatArray, reference: TriangleLocator) -> float:
    """How badly points lie: the root mean square distance, m; far ones count no more than that."""
    far = FARTHEST * reference.size
    distance = reference.nearest(points, far).distance
    return float(np.sqrt(np.mean(np.minimum(distance, far) ** 2)))


def _followed(points: FloatArray, reference: TriangleLocator, start: Motion, steps: int) -> Motion:
    motion = start
    for _ in range(steps):
        now = motion.applied(points)
        step = _step(now, reference)
        if step is None:
            break
        motion = Motion(step.rotation @ motion.rotation, step.applied(motion.translation[None])[0])
        if np.abs(step.applied(now) - now).max() < _AT_REST * reference.size:
            break
    return motion


def _step(points: FloatArray, reference: TriangleLocator) -> Motion | None:
    """The small motion that brings the points nearer; None where too few are over the mesh."""
    found = reference.nearest(points, FARTHEST * reference.size)
    away = deviation_from(points, found, reference)
    over = np.isfinite(away)
    if np.count_nonzero(over) < _LEAST_OVER:
        return None
    usual = float(np.median(np.abs(away[over])))
    near = over & (np.abs(np.nan_to_num(away)) <= _OUTLIER * usual + 1e-12)
    gaps = found.points - points
    middle = points.mean(axis=0)
    arms = (points - middle) / reference.size  # so that turning and moving weigh alike
    normals = reference.outward(found)[near]
    along = np.hstack([np.cross(arms[near], normals), normals])
    # Points beyond the border are drawn to it, ever so little: what slides along itself stays over.
    axes = np.eye(3)
    beyond = np.concatenate(
        [np.cross(arms[~over][:, None], axes), np.broadcast_to(axes, (*gaps[~over].shape, 3))],
        axis=2,
    )
    length = np.linalg.norm(gaps[~over], axis=1)
    reach = usual + _REACH * reference.size
    pull = _PULL * np.sqrt(np.minimum(1.0, reach / np.maximum(length, 1e-300)))
    rows = np.concatenate([along, (pull[:, None, None] * beyond).reshape(-1, 6)])
    wanted = np.concatenate(
        [np.sum(gaps[near] * normals, axis=1), (pull[:, None] * gaps[~over]).ravel()]
    )
    turn_and_shift = np.linalg.lstsq(rows, wanted, rcond=_WEAK)[0]
    rotation = rotations.exp(turn_and_shift[:3] / reference.size)
    return Motion(rotation, middle - rotation @ middle + turn_and_shift[3:])
