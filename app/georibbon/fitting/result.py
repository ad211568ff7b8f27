"""All passes as fitted and placed, whichever way they were fitted."""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.fitting.joint import Adjustment, Minimum
from georibbon.fitting.survey import Placed
from georibbon.notices import Notice


@dataclass(frozen=True, eq=False)
class PassesFit:
    """p passes of one ribbon at the n + 1 nodes of its grid, in the workpiece frame.

    s: (n + 1,) metres.  points: (p, n + 1, 3) metres.  frames: (p, n + 1, 3,
    3).  covariance: (p, n + 1, 3, 3) m².  normal_sigma: (p, n + 1) radians.
    residuals: (p, sensors, 3) normalised.  present: (p, sensors) whether the
    sensor was used in the pass.  lengths: (p,) smoothing, metres, 0 for none.
    ambiguous: (p,) passes of which another shape fits as well.  heading:
    radians, of the workpiece against magnetic axes; heading_sigma: None where
    it is taken, not found.  minimum: the joint adjustment's, from which others
    nearby are found; None where there was none.
    """

    s: FloatArray
    points: FloatArray
    frames: FloatArray
    covariance: FloatArray
    normal_sigma: FloatArray
    residuals: FloatArray
    present: BoolArray
    lengths: FloatArray
    ambiguous: tuple[bool, ...]
    heading: float
    heading_sigma: float | None
    notices: tuple[Notice, ...]
    minimum: Minimum | None = None


def position_covariance(placed: Placed, covariance: list[FloatArray]) -> FloatArray:
    """(p, n + 1, 3, 3) of the points, from each pass's covariance (m + 3, m + 3)."""
    p, nodes = placed.points.shape[:2]
    whole = np.broadcast_to(np.eye(3), (p, nodes, 3, 3))
    moves = np.concatenate([placed.moves, whole], axis=3)
    return _carried(moves, np.array(covariance))


def normal_sigma(placed: Placed, covariance: list[FloatArray]) -> FloatArray:
    """(p, n + 1) radians: root of the mean variance of the normal's two components."""
    m = placed.turns.shape[-1]
    turned = _carried(placed.turns, np.array([part[:m, :m] for part in covariance]))
    normal = placed.frames[..., 2]
    about = (normal[..., None, :] @ turned @ normal[..., None])[..., 0, 0]
    trace = np.trace(turned, axis1=-2, axis2=-1)
    return np.asarray(np.sqrt(0.5 * np.maximum(trace - about, 0.0)))


def _carried(derivative: FloatArray, covariance: FloatArray) -> FloatArray:
    """J C J^T at every node: (p, n, 3, m) and (p, m, m) to (p, n, 3, 3)."""
    return np.asarray((derivative @ covariance[:, None]) @ np.swapaxes(derivative, -1, -2))


def of_adjustment(
    adjustment: Adjustment,
    present: BoolArray,
    lengths: FloatArray,
    ambiguous: tuple[bool, ...],
    found: bool,
    notices: tuple[Notice, ...],
    minimum: Minimum | None = None,
) -> PassesFit:
    """The result of the joint adjustment; `found`: whether the heading is, or was taken."""
    placed = adjustment.placed
    return PassesFit(
        s=placed.grid.nodes,
        points=placed.points,
        frames=placed.frames,
        covariance=position_covariance(placed, adjustment.covariance),
        normal_sigma=normal_sigma(placed, adjustment.covariance),
        residuals=adjustment.residuals,
        present=present,
        lengths=lengths,
        ambiguous=ambiguous,
        heading=adjustment.state.shared.heading,
        heading_sigma=adjustment.heading_sigma if found else None,
        notices=notices,
        minimum=minimum,
    )
