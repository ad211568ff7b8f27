"""The daily check: three still poses on the bar against a calibration that was kept.

In pose p accelerometer n should read K_n a_p + c_n and magnetometer n S_n b_p +
o_n.  Each pose has its own a_p, the unit "up", and a heading; b_p follows from
them, from the field's dip and from its strength.  These few are fitted, robustly,
to all sensors together; what a sensor then still is off, as an angle, is told.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.accelerometers import FLOOR as GRAVITY_FLOOR
from georibbon.calibration.magnetometers import FLOOR as FIELD_FLOOR
from georibbon.calibration.magnetometers import field, field_level, levelled
from georibbon.calibration.model import Calibration
from georibbon.calibration.plans import PLANS, AskedPose
from georibbon.calibration.poses import Attitudes, Block, attitudes, block, require_columns
from georibbon.calibration.separable import cell_residuals, robust_weights
from georibbon.calibration.serial import check_fits
from georibbon.errors import CalibrationError
from georibbon.notices import Notice
from georibbon.recording import Pose
from georibbon.ribbon import KINDS, Ribbon, SensorKind
from georibbon.rotations import skew
from georibbon.stillness import still_means, without_railed

CheckVerdict = Literal["good", "usable", "calibrate"]

CHECK_PLAN, CHECK_NUMBERS = 20, (1, 5, 14)
CHECK_POSES: tuple[AskedPose, ...] = tuple(PLANS[CHECK_PLAN][n - 1] for n in CHECK_NUMBERS)
"""The poses of the daily check: flat, on an edge, and tilted, of the plan of 20 poses."""

GOOD, USABLE = 0.5, 1.0  # degrees
NORM_WITHIN = 0.02
DIP_WITHIN = 3.0  # degrees
LEAST_APART = np.radians(25.0)  # between two poses' "up"
LEAST_SENSORS = 3
STEPS = 40
HEADINGS = np.radians(np.arange(0.0, 360.0, 5.0))
# Of the field: what solutions are compared by, at the grid's headings and where adjusted.
ROUGH, JUDGED = 0.1, 0.02
# Where so many magnetometers of a pose are off, it is the pose and no sensor.
MOST = 0.5
# One pose alone is at fault where the others leave less than this share of what a sensor is off.
ELSEWHERE = 0.25
# A sensor that changes by less, in units, where the others change by ten times as much, is dead.
UNMOVED = 0.05
MOST_LISTED = 4


@dataclass(frozen=True)
class SensorCheck:
    """One sensor's figures.

    degrees: what its readings are off, rms over the poses, as an angle of
    gravity or of the field; NaN where it said nothing.  turned, shifted: what
    would explain it: a turn in degrees, or a bias in mg or percent of the field;
    the one that explains more is given, the other is NaN.  used: by the calibration.
    """

    name: str
    kind: SensorKind
    degrees: float
    turned: float
    shifted: float
    used: bool


@dataclass(frozen=True)
class Check:
    """What a daily check found.

    degrees: the worst sensor's; the verdict is by it and by the field.  tilt,
    heading: rms over accelerometers and over magnetometers, the second about the
    vertical.  norm: the field's strength in units of the one when it was
    calibrated; dip: degrees; dip_change: against the calibration's.  again: names
    of poses that should be taken again before anything else is done.
    """

    verdict: CheckVerdict
    reason: str
    degrees: float
    tilt: float
    heading: float
    norm: float
    dip: float
    dip_change: float
    sensors: tuple[SensorCheck, ...]
    findings: tuple[Notice, ...]
    again: tuple[str, ...] = ()

    @property
    def undisturbed(self) -> bool:
        """Whether the field is as strong and as steep as it was."""
        return abs(self.norm - 1.0) <= NORM_WITHIN and abs(self.dip_change) <= DIP_WITHIN


@dataclass(frozen=True, eq=False)
class _Group:
    """The sensors of one kind: gain (n, 3, 3), values without bias (n, p, 3), valid (n, p)."""

    block: Block
    gain: FloatArray
    values: FloatArray
    valid: BoolArray
    floor: float

    def residuals(self, directions: FloatArray) -> FloatArray:
        """(n, p, 3) what the readings are off for directions (p, 3)."""
        predicted = np.einsum("nkc,pc->npk", self.gain, directions)
        return np.where(self.valid[:, :, None], self.values - predicted, 0.0)

    def weights(self, residuals: FloatArray) -> FloatArray:
        """(n, p) robust weights."""
        axes = self.block.axes.astype(np.float64)
        cells = cell_residuals(residuals, axes)
        return robust_weights(cells, self.valid.astype(np.float64), self.floor)


def check_calibration(ribbon: Ribbon, calibration: Calibration, poses: Sequence[Pose]) -> Check:
    """The verdict on a calibration by poses taken today, usually `CHECK_POSES`.

    Under 0.5 degrees for every sensor is good, under 1 usable; the field must be
    as strong within 2 % and as steep within 3 degrees.  Raises CalibrationError
    where the calibration is of another ribbon, where the poses are fewer than
    three or too much alike, or where too few sensors say anything.
    """
    check_fits(calibration, ribbon)
    require_columns(ribbon, poses)
    asked = attitudes(poses, np.ones(len(poses), dtype=bool))
    means = [still_means(without_railed(pose.readings)[0]) for pose in poses]
    gravity, magnetic = (_group(ribbon, calibration, block(ribbon, means, k)) for k in KINDS)
    up = _ups(gravity, asked)
    q = _field(magnetic, levelled(asked.level, up), calibration.dip)
    b = _field_of(levelled(asked.level, up), q)
    both = ((gravity, gravity.residuals(up), up), (magnetic, magnetic.residuals(b), b))
    return _judge(ribbon, calibration, asked, both, q)


def _group(ribbon: Ribbon, calibration: Calibration, of: Block) -> _Group:
    gain, bias = np.zeros((len(of.names), 3, 3)), np.zeros((len(of.names), 3))
    used = np.zeros(len(of.names), dtype=bool)
    for n, i in enumerate(of.indices):
        model, axes = calibration.sensors[i], of.axes[n]
        gain[n, :axes], bias[n, :axes] = model.gain / of.units[n], model.bias / of.units[n]
        used[n] = model.used
    valid = of.valid & used[:, None]
    if (valid.sum(axis=0) < min(LEAST_SENSORS, len(of.names))).any() or not valid.any():
        kind = ribbon.sensors[of.indices[0]].kind if of.indices else "sensor"
        raise CalibrationError(
            f"too few {kind}s of the ribbon give values for a check; look at its connection"
        )
    floor = GRAVITY_FLOOR if ribbon.sensors[of.indices[0]].kind == "accelerometer" else FIELD_FLOOR
    values = np.where(valid[:, :, None], of.values - bias[:, None], 0.0)
    return _Group(of, gain, values, valid, floor)


def _ups(group: _Group, asked: Attitudes) -> FloatArray:
    """(p, 3) unit "up" in each pose, to which most accelerometers agree."""
    inverse = np.linalg.pinv(group.gain)
    seen = np.einsum("nck,npk->npc", inverse, group.values)
    up = np.nanmedian(np.where(group.valid[:, :, None], seen, np.nan), axis=0)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    _require_apart(up, asked)
    for _ in range(STEPS):
        weights = group.weights(group.residuals(up))
        normal = np.einsum("np,nkc,nkd->pcd", weights, group.gain, group.gain)
        right = np.einsum("np,nkc,npk->pc", weights, group.gain, group.values)
        moved = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
        size, up = float(np.abs(moved - up).max()), moved
        if size < 1e-10:
            break
    return up


def _require_apart(up: FloatArray, asked: Attitudes) -> None:
    """Raises CalibrationError where less than three attitudes are among the poses."""
    kept: list[int] = []
    for p in range(len(up)):
        if all(up[p] @ up[k] < np.cos(LEAST_APART) for k in kept):
            kept.append(p)
    if len(kept) < len(CHECK_POSES):
        raise CalibrationError(
            f"the check has {len(kept)} different poses of {len(asked.names)}, "
            f"{len(CHECK_POSES)} are needed; take one flat, one on an edge and one tilted"
        )


def _field_of(frames: FloatArray, q: FloatArray) -> FloatArray:
    """(p, 3) the field in the bar's frame for q = headings, dip, strength."""
    return np.asarray(q[-1] * field(frames, q[:-2], q[-2]))


def _field(group: _Group, frames: FloatArray, dip: float) -> FloatArray:
    """(p + 2,) the headings, the dip and the strength of the field.

    With two axes a pose on its edge tells a heading from its mirror image only by
    how the sensors are mounted: for each pose the other minima are tried too.
    """
    start = np.array([dip, 1.0])
    headings = HEADINGS[np.argmin(_heading_costs(group, frames, start), axis=0)]
    best = _adjusted(group, frames, np.append(headings, start))
    for p in range(len(frames)):
        costs = _heading_costs(group, frames, best[-2:])[:, p]
        minima = (costs <= np.roll(costs, 1)) & (costs < np.roll(costs, -1))
        for heading in HEADINGS[minima]:
            trial = best.copy()
            trial[p] = heading
            trial = _adjusted(group, frames, trial)
            if _cost(group, frames, trial) < _cost(group, frames, best):
                best = trial
    return np.asarray(best)


def _adjusted(group: _Group, frames: FloatArray, q: FloatArray) -> FloatArray:
    """The unknowns by Gauss-Newton with robust weights."""
    for _ in range(STEPS):
        weights = group.weights(residuals := group.residuals(_field_of(frames, q)))
        moves = np.einsum("nkc,pcm->npkm", group.gain, _jacobian(frames, q))
        normal = np.einsum("np,npka,npkb->ab", weights, moves, moves, optimize=True)
        right = np.einsum("np,npka,npk->a", weights, moves, residuals, optimize=True)
        step = np.clip(np.linalg.lstsq(normal, right, rcond=1e-12)[0], -0.2, 0.2)
        q = q + step
        if np.abs(step).max() < 1e-9:
            break
    return q


def _cost(group: _Group, frames: FloatArray, q: FloatArray) -> float:
    """Geman and McClure's cost of what the readings are off."""
    off = np.linalg.norm(group.residuals(_field_of(frames, q)), axis=2)
    return float((off**2 / (off**2 + JUDGED**2)).sum())


def _heading_costs(group: _Group, frames: FloatArray, known: FloatArray) -> FloatArray:
    """(h, p) the same cost, roughly, of each pose at each heading of a grid."""
    dip, strength = known
    grid = np.repeat(HEADINGS[:, None], len(frames), axis=1)
    b = strength * field(frames, grid, np.asarray(dip))
    predicted = np.einsum("nkc,hpc->hnpk", group.gain, b)
    off = np.linalg.norm(np.where(group.valid[:, :, None], group.values - predicted, 0.0), axis=3)
    return np.asarray((off**2 / (off**2 + ROUGH**2)).sum(axis=1))


def _jacobian(frames: FloatArray, q: FloatArray) -> FloatArray:
    """(p, 3, p + 2) how the field in the bar's frame moves with the unknowns."""
    headings, dip, strength = q[:-2], q[-2], q[-1]
    poses = np.arange(len(headings))
    out = np.zeros((len(poses), 3, len(poses) + 2))
    turned = field_level(headings + 0.5 * np.pi, dip) * [1.0, 1.0, 0.0]
    dipped = field_level(headings, dip + 0.5 * np.pi)
    out[poses, :, poses] = strength * np.einsum("pij,pi->pj", frames, turned)
    out[:, :, -2] = strength * np.einsum("pij,pi->pj", frames, dipped)
    out[:, :, -1] = field(frames, headings, dip)
    return out


def _judge(
    ribbon: Ribbon,
    calibration: Calibration,
    asked: Attitudes,
    both: Sequence[tuple[_Group, FloatArray, FloatArray]],
    q: FloatArray,
) -> Check:
    found: dict[str, SensorCheck] = {}
    findings: list[Notice] = []
    again: list[str] = []
    for group, residuals, directions in both:
        checks = _sensors(ribbon, calibration, group, residuals, directions)
        found |= {one.name: one for one in checks}
        told, repeat = _findings(group, checks, residuals, asked)
        findings += told
        again += [name for name in repeat if name not in again]
    sensors = tuple(found[sensor.name] for sensor in ribbon.sensors)
    tilt, heading = (_rms(sensors, kind) for kind in KINDS)
    worst = max((one.degrees for one in sensors if np.isfinite(one.degrees)), default=0.0)
    change = float(np.degrees(q[-2] - calibration.dip))
    level = max(float(np.cos(q[-2])), 0.05)
    if place := _place(float(q[-1]), change):
        findings.insert(0, place)
    verdict = _verdict(worst, findings)
    reason = _reason(verdict, worst, findings, asked, again)
    return Check(
        verdict, reason, worst, tilt, heading / level, float(q[-1]), float(np.degrees(q[-2])),
        change, sensors, tuple(findings), tuple(again),
    )  # fmt: skip


def _sensors(
    ribbon: Ribbon,
    calibration: Calibration,
    group: _Group,
    residuals: FloatArray,
    directions: FloatArray,
) -> list[SensorCheck]:
    checks = []
    for n, i in enumerate(group.block.indices):
        model, valid = calibration.sensors[i], group.valid[n]
        off = turned = shifted = float("nan")
        if valid.any():
            off = float(np.degrees(np.sqrt((residuals[n, valid] ** 2).sum(axis=1).mean())))
            turned, shifted = _cause(group.gain[n], residuals[n, valid], directions[valid])
        kind = ribbon.sensors[i].kind
        shifted *= 1e3 if kind == "accelerometer" else 1e2
        checks.append(SensorCheck(model.name, kind, off, turned, shifted, model.used))
    return checks


def _cause(gain: FloatArray, residuals: FloatArray, directions: FloatArray) -> tuple[float, float]:
    """What explains residuals (p, 3) better: a turn (degrees) or a bias; the other is NaN."""
    moves = (gain @ skew(directions)).reshape(-1, 3)
    turn = np.linalg.lstsq(moves, residuals.ravel(), rcond=1e-6)[0]
    bias = residuals.mean(axis=0)
    by_turn = float(((residuals.ravel() - moves @ turn) ** 2).sum())
    by_bias = float(((residuals - bias) ** 2).sum())
    if by_turn <= by_bias:
        return float(np.degrees(np.linalg.norm(turn))), float("nan")
    return float("nan"), float(np.linalg.norm(bias))


def _rms(sensors: Sequence[SensorCheck], kind: SensorKind) -> float:
    degrees = [one.degrees for one in sensors if one.kind == kind and np.isfinite(one.degrees)]
    return float(np.sqrt(np.mean(np.square(degrees))))


def _findings(
    group: _Group, checks: Sequence[SensorCheck], residuals: FloatArray, asked: Attitudes
) -> tuple[list[Notice], list[str]]:
    """What is said of sensors and poses, and the poses to take again."""
    off = np.degrees(np.linalg.norm(residuals, axis=2))
    astray = group.valid & (off > 2.0 * GOOD)
    kind = checks[0].kind
    disturbed = astray.sum(axis=0) > MOST * np.maximum(group.valid.sum(axis=0), 1)
    # Where every pose is off, it is not the poses.
    disturbed &= not disturbed.all()
    told = [_pose_notice(asked.names[p], kind) for p in np.flatnonzero(disturbed)]
    again = [asked.names[p] for p in np.flatnonzero(disturbed)]
    dead = _dead(group)
    for n, one in enumerate(checks):
        if not one.used:
            continue
        if dead[n] or not group.valid[n].any():
            told.append(_dead_notice(one))
            continue
        left = np.where(disturbed, 0.0, off[n] ** 2)
        rms = float(np.sqrt(left.sum() / max(int((group.valid[n] & ~disturbed).sum()), 1)))
        if rms <= GOOD:
            continue
        alone = int(np.argmax(left))
        if kind == "magnetometer" and left.sum() - left[alone] < ELSEWHERE * left[alone]:
            told.append(_cell_notice(one, asked.names[alone], float(off[n, alone])))
            again += [asked.names[alone]] if asked.names[alone] not in again else []
        else:
            told.append(_sensor_notice(one, rms))
    return told, again


def _dead(group: _Group) -> BoolArray:
    """(n,) the sensors that hardly change from pose to pose while most others do."""
    shown = np.where(group.valid[:, :, None], group.values, np.nan)
    heard: BoolArray = np.asarray(group.valid.any(axis=1))
    change = np.zeros(len(heard))
    change[heard] = (np.nanmax(shown[heard], axis=1) - np.nanmin(shown[heard], axis=1)).max(axis=1)
    usual = float(np.median(change[heard]))
    return heard & (change < UNMOVED) & (usual > 10.0 * UNMOVED)


def _pose_notice(pose: str, kind: SensorKind) -> Notice:
    if kind == "magnetometer":
        why = "steel or a current was near it; take it again away from them"
    else:
        why = "the bar was moved while it was measured; take it again, held still"
    return Notice("check-pose", f"pose {pose!r} disagrees with the others in most {kind}s: {why}")


def _cell_notice(one: SensorCheck, pose: str, degrees: float) -> Notice:
    return Notice(
        "check-cell",
        f"sensor {one.name} is off by {degrees:.1f}° in pose {pose!r} alone: something magnetic "
        "was near it; take this pose again away from it",
        sensor=one.name,
    )


def _dead_notice(one: SensorCheck) -> Notice:
    return Notice(
        "check-dead",
        f"sensor {one.name} says nothing that depends on the pose; look at its connection, "
        "switch it off or replace it, and calibrate again",
        sensor=one.name,
    )


def _sensor_notice(one: SensorCheck, degrees: float) -> Notice:
    if np.isfinite(one.turned):
        words = f"as if it were turned by {one.turned:.1f}°"
        remedy = "see that it is fast on the ribbon and that the ribbon is straight on the bar"
    elif one.kind == "accelerometer":
        words = f"as if its bias had changed by {one.shifted:.0f} mg"
        remedy = "let the ribbon warm up"
    else:
        words = f"as if its hard iron had changed by {one.shifted:.0f} % of the field"
        remedy = "see whether something magnetic sits on the ribbon"
    return Notice(
        "check-sensor",
        f"sensor {one.name} is off by {degrees:.1f}°, {words}; {remedy}, and calibrate again or "
        "switch it off",
        sensor=one.name,
    )


def _place(norm: float, change: float) -> Notice | None:
    """What is said of a field that is not as it was; None where it is."""
    if abs(norm - 1.0) <= NORM_WITHIN and abs(change) <= DIP_WITHIN:
        return None
    strength = f"{abs(norm - 1.0) * 100.0:.1f} % {'stronger' if norm > 1.0 else 'weaker'}"
    return Notice(
        "check-place",
        f"the field is {strength} and {abs(change):.1f}° {'steeper' if change > 0 else 'flatter'} "
        f"than when the ribbon was calibrated ({NORM_WITHIN:.0%} and {DIP_WITHIN:g}° are "
        "allowed): the place is disturbed or the ribbon has changed; check in the place where it "
        "was calibrated, away from steel and currents, or calibrate here",
    )


def _verdict(worst: float, findings: Sequence[Notice]) -> CheckVerdict:
    codes = {notice.code for notice in findings}
    if worst >= USABLE or codes & {"check-place", "check-dead"}:
        return "calibrate"
    return "usable" if worst >= GOOD else "good"


def _reason(
    verdict: CheckVerdict,
    worst: float,
    findings: Sequence[Notice],
    asked: Attitudes,
    again: Sequence[str],
) -> str:
    if again:
        which = ", ".join(again)
        return f"take again before anything else: {which}"
    names = [notice.sensor for notice in findings if notice.sensor is not None]
    if any(notice.code == "check-place" for notice in findings):
        return "the field here is not the one the ribbon was calibrated in"
    if names:
        more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
        who = ", ".join(names[:MOST_LISTED]) + more
        when = "again" if verdict == "calibrate" else "soon"
        return f"{who} off by up to {worst:.1f}°: calibrate {when}, or switch off what is named"
    return f"all sensors agree with the calibration to {worst:.2f}° over {len(asked.names)} poses"
