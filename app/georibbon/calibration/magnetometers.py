"""Stage B: the magnetometers of a bar, each pose's "up" known, its heading not.

In pose p magnetometer n reads y = S_n b_p + o_n with b_p = G_p^T h(psi_p) the
field in the bar's frame: h = (cos dip sin psi, cos dip cos psi, -sin dip), G_p
the rotation that makes the pose level.  Unknown are one heading psi_p for each
pose, the dip, S_n (2 or 3 rows) and o_n.  The mirror solution (-dip, psi + 180
degrees, -S) fits exactly as well and is told apart by the axes' nominal sign.
"""

from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.accelerometers import prior_of
from georibbon.calibration.poses import Block
from georibbon.calibration.separable import (
    Adjusted,
    Directions,
    Prior,
    Problem,
    adjust,
    cell_residuals,
    linear_fit,
    median_of,
)
from georibbon.rotations import about_z, to_up

NOISE = 5e-3  # of the field: one unit of weight
GAIN_SPREAD = 0.3
BIAS_SPREAD = 1.0
FLOOR = 1e-3
# Starting values: headings asked for are true to some 15 degrees, so that a
# reading is known to a tenth of the field at best.
START_NOISE = 0.1
START_SCALE = 0.3
OFFSETS = np.radians(np.arange(0.0, 360.0, 15.0))
DIPS = np.radians(np.arange(-75.0, 76.0, 25.0))
HEADINGS = np.radians(np.arange(0.0, 360.0, 5.0))
KEPT = 3
ROUNDS = 6
# A fit is judged, when solutions are compared, by residuals on this scale.
JUDGED = 0.02
SUSPECT = 0.01


@dataclass(frozen=True, eq=False)
class StageB:
    """The magnetometers' solution: headings (p,) and dip, radians; frames R_p (p, 3, 3)."""

    headings: FloatArray
    dip: float
    frames: FloatArray
    adjusted: Adjusted


def levelled(level: FloatArray, up: FloatArray) -> FloatArray:
    """(p, 3, 3) rotations G with G up = (0, 0, 1), each nearest to the nominal `level`.

    The nominal rotation is followed by the smallest one that takes where it
    puts "up" to the vertical.
    """
    return to_up(np.einsum("pij,pj->pi", level, up)) @ level


def field_level(headings: FloatArray, dip: FloatArray) -> FloatArray:
    """(..., 3) the field as a levelled pose at each heading sees it."""
    down = -np.sin(dip) * np.ones_like(headings)
    return np.stack([np.cos(dip) * np.sin(headings), np.cos(dip) * np.cos(headings), down], axis=-1)


def field(frames: FloatArray, headings: FloatArray, dip: FloatArray) -> FloatArray:
    """(..., p, 3) the field in the bar's frame; frames: (p, 3, 3) levelling rotations."""
    return np.asarray(np.einsum("pij,...pi->...pj", frames, field_level(headings, dip)))


def _directions(frames: FloatArray, q: FloatArray) -> Directions:
    headings, dip = q[:-1], q[-1]
    p = len(headings)
    turned = field_level(headings + 0.5 * np.pi, dip) * [1.0, 1.0, 0.0]
    dipped = field_level(headings, dip + 0.5 * np.pi)
    jacobian = np.zeros((p, 3, p + 1))
    jacobian[np.arange(p), :, np.arange(p)] = np.einsum("pij,pi->pj", frames, turned)
    jacobian[:, :, p] = np.einsum("pij,pi->pj", frames, dipped)
    return Directions(field(frames, headings, dip), jacobian)


def _move(q: FloatArray, step: FloatArray) -> FloatArray:
    # A heading or dip moves by no more than 20 degrees at once, whatever the linearisation says.
    return q + np.clip(step, -0.35, 0.35)


def _cost(residuals: FloatArray, valid: FloatArray, axes: FloatArray, scale: float) -> FloatArray:
    """(...,) Geman-McClure cost of residuals (..., n, p, 3), summed over sensors and poses."""
    squares = (cell_residuals(residuals, axes) / scale) ** 2
    return np.asarray((valid * squares / (1.0 + squares)).sum(axis=(-2, -1)))


@dataclass(frozen=True, eq=False)
class _Stage:
    """What every step of the stage needs: the problem, its start prior, the frames."""

    problem: Problem
    start: Prior
    frames: FloatArray

    def judge(self, found: Adjusted) -> float:
        """The robust cost by which solutions are compared."""
        return float(_cost(found.residuals, self.problem.valid, self.problem.axes, JUDGED))

    def pose_costs(self, theta: FloatArray, dip: FloatArray) -> FloatArray:
        """(..., h, p) robust cost of each pose at each heading of the grid."""
        grid = np.repeat(HEADINGS[:, None], len(self.frames), axis=1)
        b = field(self.frames, grid, np.asarray(dip)[..., None, None])
        predicted = np.einsum("...nkc,...hpc->...hpnk", theta[..., :3], b, optimize=True)
        wanted = np.moveaxis(self.problem.values - theta[..., None, :, 3], -3, -2)
        squares = ((wanted[..., None, :, :, :] - predicted) ** 2).sum(axis=-1) / self.problem.axes
        squares = squares / START_SCALE**2
        return np.asarray((self.problem.valid.T * squares / (1.0 + squares)).sum(axis=-1))


def _starts_from_labels(stage: _Stage, labels: FloatArray) -> list[FloatArray]:
    """The best starts q among offsets of the headings asked for and dips."""
    headings = (labels + OFFSETS[:, None])[None].repeat(len(DIPS), axis=0).reshape(-1, len(labels))
    dips = DIPS.repeat(len(OFFSETS))
    b = field(stage.frames, headings, dips[:, None])
    problem = stage.problem
    theta, residuals = linear_fit(problem.values, b, problem.valid, stage.start)
    cost = _cost(residuals, problem.valid, problem.axes, START_SCALE)
    pulled = ((theta - stage.start.theta) ** 2 * stage.start.precision).sum(axis=(-3, -2, -1))
    order = np.argsort(cost + pulled / START_SCALE**2)[:KEPT]
    return [np.append(headings[k], dips[k]) for k in order]


def _starts_without_labels(stage: _Stage) -> list[FloatArray]:
    """Starts q without any heading asked for.

    Hard iron averages out over the sensors, so the nominal sensors give each
    pose a first heading; then sensors and headings are fitted in turn.
    """
    problem = stage.problem
    middle = np.median(problem.values - np.median(problem.values, axis=1)[:, None], axis=0)
    centred = replace(problem, values=np.broadcast_to(middle, problem.values.shape))
    theta = np.broadcast_to(stage.start.theta, (len(DIPS), *stage.start.theta.shape))
    first = replace(stage, problem=centred)
    headings = HEADINGS[np.argmin(first.pose_costs(theta, DIPS), axis=1)]
    for _ in range(ROUNDS):
        b = field(stage.frames, headings, DIPS[:, None])
        theta, residuals = linear_fit(problem.values, b, problem.valid, stage.start)
        headings = HEADINGS[np.argmin(stage.pose_costs(theta, DIPS), axis=1)]
    order = np.argsort(_cost(residuals, problem.valid, problem.axes, START_SCALE))[:KEPT]
    return [np.append(headings[k], DIPS[k]) for k in order]


def _suspects(stage: _Stage, found: Adjusted) -> BoolArray:
    """(p,) bool: poses whose median cell residual stands out."""
    cells = cell_residuals(found.residuals, stage.problem.axes)
    valid = stage.problem.valid
    middle = float(np.median(cells[valid > 0.0]))
    return np.asarray(median_of(cells, valid, 0) > max(3.0 * middle, SUSPECT))


def _rescanned(stage: _Stage, found: Adjusted) -> Adjusted:
    """The solution after every standing-out pose had its heading searched anew, left out."""
    for _ in range(ROUNDS):
        poses = _suspects(stage, found)
        if not poses.any():
            return found
        problem = stage.problem
        b = problem.directions(found.q).d
        theta, _ = linear_fit(problem.values, b, problem.valid * ~poses, stage.start)
        best = HEADINGS[np.argmin(stage.pose_costs(theta, found.q[-1]), axis=0)]
        q = np.append(np.where(poses, best, found.q[:-1]), found.q[-1])
        trial = adjust(problem, q, rough=True)
        if stage.judge(trial) >= stage.judge(found) * (1.0 - 1e-6):
            return found
        found = trial
    return found


def _best(stage: _Stage, starts: list[FloatArray]) -> Adjusted:
    found = [adjust(stage.problem, q, rough=True) for q in starts]
    return _rescanned(stage, min(found, key=stage.judge))


def _upright(stage: _Stage, found: Adjusted) -> Adjusted:
    """The one of the two mirror solutions whose axes have their nominal sign."""
    agreement = np.median((found.theta[:, :, :3] * stage.start.theta[:, :, :3]).sum(axis=(1, 2)))
    if agreement >= 0.0:
        return found
    q = np.append(found.q[:-1] + np.pi, -found.q[-1])
    return replace(found, q=q, theta=found.theta * [-1.0, -1.0, -1.0, 1.0])


def fit_magnetometers(
    block: Block,
    level: FloatArray,
    up: FloatArray,
    headings: FloatArray,
    known: StageB | None = None,
) -> StageB:
    """The magnetometers, the headings and the dip.

    level: (p, 3, 3) the poses' attitudes before their heading; up: (p, 3) from
    stage A; headings: (p,) radians, as they were asked for.  known: a solution
    for nearly the same "up", from which only the adjustment is done again.
    """
    frames = levelled(level, up)
    problem = Problem(
        np.where(block.valid[:, :, None], block.values, 0.0),
        block.valid.astype(np.float64),
        block.axes.astype(np.float64),
        prior_of(block, NOISE, GAIN_SPREAD, BIAS_SPREAD),
        lambda q: _directions(frames, q),
        _move,
        FLOOR,
    )
    if known is not None:
        return _result(adjust(problem, np.append(known.headings, known.dip)), frames)
    stage = _Stage(problem, prior_of(block, START_NOISE, GAIN_SPREAD, BIAS_SPREAD), frames)
    found = _best(stage, _starts_from_labels(stage, headings))
    if _suspects(stage, found).any() or stage.judge(found) > SUSPECT * problem.valid.sum():
        other = _best(stage, _starts_without_labels(stage))
        found = min(found, other, key=stage.judge)
    return _result(_upright(stage, found), frames)


def _result(found: Adjusted, frames: FloatArray) -> StageB:
    turned = about_z(found.q[:-1])
    return StageB(found.q[:-1], float(found.q[-1]), turned @ frames, found)
