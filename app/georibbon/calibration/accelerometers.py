"""Stage A: the accelerometers of a bar from its poses, the attitudes unknown.

In pose p accelerometer n reads y = K_n a_p + c_n with a_p the unit "up" vector
in the bar's frame, the same for all; unknown are a_p (two numbers each), K_n
and c_n.  Up to one common rotation, which the gauge settles.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.poses import Block
from georibbon.calibration.separable import Adjusted, Directions, Prior, Problem, Tie, adjust

NOISE = 1e-3  # g: one unit of weight
GAIN_SPREAD = 0.1
BIAS_SPREAD = 0.1  # g
FLOOR = 0.5e-3  # g: below it no residual is suspect


@dataclass(frozen=True, eq=False)
class StageA:
    """The accelerometers' solution: up (p, 3) unit, in the solution's own frame."""

    up: FloatArray
    adjusted: Adjusted


def start_up(block: Block) -> FloatArray:
    """(p, 3) "up" in each pose: the median over the sensors of the readings, normalised."""
    values = np.where(block.valid[:, :, None], block.values, np.nan)
    up = np.nanmedian(values, axis=0)
    return np.asarray(up / np.linalg.norm(up, axis=1, keepdims=True))


def tangents(up: FloatArray) -> FloatArray:
    """(p, 3, 2) two orthonormal directions square to each unit vector."""
    axis = np.eye(3)[np.argmin(np.abs(up), axis=1)]
    first = np.cross(up, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(up, first)], axis=2)


def directions_of(q: FloatArray) -> Directions:
    """The poses' "up", (3 p,) or (p, 3), and how each moves along its two tangents."""
    up = q.reshape(-1, 3)
    p = len(up)
    jacobian = np.zeros((p, 3, p, 2))
    jacobian[np.arange(p), :, np.arange(p), :] = tangents(up)
    return Directions(up, jacobian.reshape(p, 3, 2 * p))


def _move(q: FloatArray, step: FloatArray) -> FloatArray:
    up = q.reshape(-1, 3)
    up = up + np.einsum("pca,pa->pc", tangents(up), step.reshape(-1, 2))
    return np.asarray(up / np.linalg.norm(up, axis=1, keepdims=True)).ravel()


def prior_of(block: Block, noise: float, gain: float, bias: float) -> Prior:
    """The weak prior: gains about the nominal axes, no bias."""
    theta = np.concatenate([block.nominal, np.zeros((len(block.names), 3, 1))], axis=2)
    return Prior(theta, np.array([noise / gain] * 3 + [noise / bias]) ** 2)


def fit_accelerometers(
    block: Block, start: FloatArray | None = None, tie: Tie | None = None
) -> StageA:
    """The accelerometers and the poses' "up", (p, 3), from their readings.

    start: (p, 3) where to begin; without it a rough solution is found from the
    readings' median;
    tie: what is known of "up" besides.
    """
    problem = Problem(
        np.where(block.valid[:, :, None], block.values, 0.0),
        block.valid.astype(np.float64),
        block.axes.astype(np.float64),
        prior_of(block, NOISE, GAIN_SPREAD, BIAS_SPREAD),
        directions_of,
        _move,
        FLOOR,
        tie,
    )
    begin = start_up(block) if start is None else start
    adjusted = adjust(problem, begin.ravel(), rough=start is None)
    return StageA(adjusted.q.reshape(-1, 3), adjusted)
