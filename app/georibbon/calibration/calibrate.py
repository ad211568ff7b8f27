"""Poses to a calibration: what is looked at, in order, and what is put together."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration import findings, gates, labels, quality, suspects
from georibbon.calibration.accelerometers import (
    BIAS_SPREAD,
    FLOOR,
    GAIN_SPREAD,
    StageA,
    directions_of,
    fit_accelerometers,
    prior_of,
    start_up,
)
from georibbon.calibration.gauge import FACE, Gauge, fit_gauge, settle
from georibbon.calibration.magnetometers import FLOOR as FIELD_FLOOR
from georibbon.calibration.magnetometers import StageB, fit_magnetometers
from georibbon.calibration.model import (
    MOUNTING_SIGMA,
    Calibration,
    CalibrationQuality,
    SensorModel,
)
from georibbon.calibration.poses import (
    Attitudes,
    Block,
    attitudes,
    block,
    require_columns,
    with_values,
)
from georibbon.calibration.separable import Tie
from georibbon.calibration.suspects import LeftOut
from georibbon.notices import Notice
from georibbon.recording import Pose
from georibbon.ribbon import KINDS, Readings, Ribbon
from georibbon.stillness import still_means, without_railed

Hemisphere = Literal["north", "south"]
# Gains are looked at, before any fit, against "up" known to some hundredths of g.
ROUGH = 0.02
# The noise of a pose mean, g, that the squareness of the faces is weighed against.
READING = 1e-4
ROUNDS = 2
# The figures A and B are for this much noise, in units of one reading's.
FIGURE_A_MG = 0.1
FIGURE_B_PERCENT = 0.5


@dataclass(frozen=True, eq=False)
class _Field:
    """What reaches the magnetometers' stage: their block, labels, and what was left out."""

    block: Block
    stage: StageB
    out: list[LeftOut]


def calibrate(
    ribbon: Ribbon, poses: Sequence[Pose], *, hemisphere: Hemisphere | None = None
) -> Calibration:
    """The models of all sensors from still poses on a straight, flat, square bar.

    hemisphere: on which side of the magnetic equator it was done; with it, a
    ribbon whose magnetometers are all reversed is refused, which no residual
    shows.  Sensors that cannot be used are left out and named; what was found
    wrong with poses and sensors is in the result's notices.

    Raises CalibrationError where the poses are too few, do not cover faces,
    headings and tilts, or leave a parameter undetermined; it says what to do.
    """
    require_columns(ribbon, poses)
    kept = with_values(ribbon, poses)
    notices = [_lost_notice(pose) for pose, fine in zip(poses, kept, strict=True) if not fine]
    gates.require_poses(int(kept.sum()))
    asked = attitudes(poses, kept)
    poses = [pose for pose, fine in zip(poses, kept, strict=True) if fine]
    accelerometers, magnetometers, out, said = _usable(ribbon, poses, asked)
    notices += said
    first = fit_accelerometers(accelerometers)
    asked, said = labels.check_labels(asked, first.up)
    notices += said
    gates.require_faces(asked)
    gates.require_coverage(quality.coverage(first.up), first.up)
    field = _field(magnetometers, first, asked)
    gauge, off = settle(field.stage.frames, asked.roll, asked.table)
    gates.require_gauge(gauge.sigma)
    first, field, gauge = _squared(accelerometers, first, field, gauge, asked, off)
    out += field.out
    notices += [item.notice() for item in out]
    notices += gates.require_dip(field.stage.dip, hemisphere)
    notices += labels.check_headings(asked, field.stage.headings)[1]
    notices += [_off_notice(asked, place, angle) for place, angle in off]
    for group, adjusted, floor, words in (
        (accelerometers, first.adjusted, FLOOR, findings.ACCELEROMETER),
        (field.block, field.stage.adjusted, FIELD_FLOOR, findings.MAGNETOMETER),
    ):
        notices += findings.findings(group, adjusted, asked, floor, words)
    figures = _figures(accelerometers, first, field, gauge)
    weak = _undetermined(accelerometers, field, figures)
    notices += [item.notice() for item in weak]
    suspect = {notice.sensor for notice in notices}
    found, dip_sigma = _quality(accelerometers, first, field, gauge, figures, suspect)
    notices += gates.weaknesses(found, asked)
    out += weak
    models = _models(accelerometers, first.adjusted.theta, gauge.rotation)
    models |= _models(field.block, field.stage.adjusted.theta, gauge.rotation)
    return Calibration(
        ribbon.id,
        field.stage.dip,
        _in_order(ribbon, models, out),
        found,
        tuple(notices),
        MOUNTING_SIGMA,
        gauge.found,
        dip_sigma,
    )


def _lost_notice(pose: Pose) -> Notice:
    return Notice(
        "pose-lost",
        f"pose {pose.name!r} lost the values of most sensors and is left out; take it again",
    )


def _without_spikes(poses: Sequence[Pose]) -> tuple[list[Readings], list[Notice]]:
    """The poses' readings without values at the end of the range; saturated axes are kept.

    An axis with more of them than `RAIL_SHARE` is judged, and named, by the sensor.
    """
    out, lost = [], 0
    for pose in poses:
        readings, railed = without_railed(pose.readings)
        few = railed & (railed.mean(axis=0) <= suspects.RAIL_SHARE)
        lost += int(few.sum())
        out.append(Readings(readings.t, np.where(few, np.nan, pose.readings.counts)))
    message = (
        f"{lost} value{'' if lost == 1 else 's'} at the end of the sensors' range in the "
        "poses are left out; if this comes back, look at the ribbon's connection"
    )
    return out, [Notice("values-saturated", message)] if lost else []


def _usable(
    ribbon: Ribbon, poses: Sequence[Pose], asked: Attitudes
) -> tuple[Block, Block, list[LeftOut], list[Notice]]:
    """The accelerometers and magnetometers that can be fitted, those left out, and notices."""
    cleaned, notices = _without_spikes(poses)
    means = [still_means(readings) for readings in cleaned]
    saturated = suspects.saturated_columns(poses)
    groups, out = [], []
    for kind in KINDS:
        group = block(ribbon, means, kind)
        expected = suspects.usual_range(group)
        if kind == "accelerometer":
            expected = np.maximum(expected, np.ptp(asked.up, axis=0))
        dead = suspects.dead_sensors(group, expected)
        group = suspects.keep(group, dead)
        group, said = suspects.without_saturated(ribbon, group, saturated)
        few = suspects.too_few_cells(group)
        group = suspects.keep(group, few)
        gates.require_sensors(group, kind)
        out += dead + few
        notices += said
        groups.append(group)
    up = start_up(groups[0])
    gains = suspects.fitted_axes(
        groups[0], up, prior_of(groups[0], ROUGH, GAIN_SPREAD, BIAS_SPREAD)
    )
    turned = suspects.wrong_axes(groups[0], gains, "accelerometer")
    group = suspects.keep(groups[0], turned)
    gates.require_sensors(group, "accelerometer")
    return group, groups[1], out + turned, notices


def _field(magnetometers: Block, first: StageA, asked: Attitudes) -> _Field:
    """The magnetometers' stage, repeated without those whose axes are not the ribbon's."""
    stage = fit_magnetometers(magnetometers, asked.level, first.up, asked.heading)
    gains = stage.adjusted.theta[:, :, :3]
    out = suspects.wrong_axes(magnetometers, gains, "magnetometer")
    if not out:
        return _Field(magnetometers, stage, out)
    left = suspects.keep(magnetometers, out)
    gates.require_sensors(left, "magnetometer")
    stage = fit_magnetometers(left, asked.level, first.up, asked.heading)
    return _Field(left, stage, out)


def _squared(
    accelerometers: Block,
    first: StageA,
    field: _Field,
    gauge: Gauge,
    asked: Attitudes,
    off: list[tuple[int, float]],
) -> tuple[StageA, _Field, Gauge]:
    """Both stages again, now that the gauge says what square faces mean for "up".

    The readings hardly tell a shear between the bar's y and z when all poses
    stand on a face; that the faces are square does.
    """
    table = asked.table.copy()
    table[[place for place, _ in off]] = False
    for _ in range(ROUNDS):
        tie = Tie(gauge.square * (READING / FACE) ** 2, gauge.target)
        first = fit_accelerometers(accelerometers, first.up, tie)
        stage = fit_magnetometers(field.block, asked.level, first.up, asked.heading, field.stage)
        field = replace(field, stage=stage)
        gauge = fit_gauge(stage.frames, asked.roll, table)
    return first, field, gauge


def _off_notice(asked: Attitudes, place: int, angle: float) -> Notice:
    return Notice(
        "pose-not-flat",
        f"{labels.name_of(asked, place)} lay {np.degrees(angle):.1f}° off the table and is not "
        "used for it; clean table and bar, and take it again",
    )


def _figures(
    accelerometers: Block, first: StageA, field: _Field, gauge: Gauge
) -> tuple[FloatArray, FloatArray]:
    """A and B of each sensor: its worst parameter, in mg and in percent of the field."""
    poses = len(first.up)
    moves = directions_of(first.up).jacobian.reshape(3 * poses, 2 * poses)
    a, b = first.adjusted.normals, field.stage.adjusted.normals
    square = replace(a, reduced=a.reduced + moves.T @ gauge.square @ moves * quality.SQUARE)
    of_a = quality.determined(square, accelerometers.axes.astype(np.float64), 3).theta
    of_b = quality.determined(b, field.block.axes.astype(np.float64)).theta
    return of_a.max(axis=1) * FIGURE_A_MG, of_b.max(axis=1) * FIGURE_B_PERCENT


def _undetermined(
    accelerometers: Block, field: _Field, figures: tuple[FloatArray, FloatArray]
) -> list[LeftOut]:
    """Single sensors that are not determined; raises CalibrationError where most are not."""
    worst = gates.WORST_ACCELEROMETER, gates.WORST_MAGNETOMETER
    gates.require_parameters(*(float(np.median(of)) for of in figures))
    out = suspects.undetermined(accelerometers.names, figures[0], worst[0], "mg")
    return out + suspects.undetermined(field.block.names, figures[1], worst[1], "% of the field")


def _worst(names: Sequence[str], figures: FloatArray, suspect: set[str | None]) -> float:
    """The worst figure of the sensors of which nothing else was said."""
    sound = [figure for name, figure in zip(names, figures, strict=True) if name not in suspect]
    return float(max(sound, default=float(np.median(figures))))


def _quality(
    block_a: Block,
    first: StageA,
    field: _Field,
    gauge: Gauge,
    figures: tuple[FloatArray, FloatArray],
    suspect: set[str | None],
) -> tuple[CalibrationQuality, float]:
    """What is told of the calibration, and the dip's standard deviation in radians."""
    a, b = first.adjusted, field.stage.adjusted
    axes_a, axes_b = block_a.axes.astype(np.float64), field.block.axes.astype(np.float64)
    poses = len(first.up)
    known_a, known_b = (
        quality.determined(a.normals, axes_a, 3),
        quality.determined(b.normals, axes_b),
    )
    noise_a = quality.noise_of(a.residuals, a.weights, axes_a, 2 * poses)
    noise_b = quality.noise_of(b.residuals, b.weights, axes_b, poses + 1)
    spread = quality.orientation(
        known_a.theta * noise_a,
        known_b.theta * noise_b,
        gauge.sigma,
        MOUNTING_SIGMA,
        field.stage.dip,
    )
    found = CalibrationQuality(
        poses,
        float(np.degrees(spread.tilt)),
        float(np.degrees(spread.heading)),
        float(np.degrees(gauge.sigma)),
        _worst(block_a.names, figures[0], suspect),
        _worst(field.block.names, figures[1], suspect),
        quality.coverage(first.up),
        1e3 * quality.rms_cells(a.residuals, block_a.valid.astype(np.float64), axes_a),
        1e2 * quality.rms_cells(b.residuals, field.block.valid.astype(np.float64), axes_b),
    )
    return found, float(known_b.unknowns[-1]) * noise_b


def _models(group: Block, theta: FloatArray, rotation: FloatArray) -> dict[str, SensorModel]:
    gains = theta[:, :, :3] @ rotation * group.units[:, None, None]
    biases = theta[:, :, 3] * group.units[:, None]
    return {
        name: SensorModel(name, np.array(gain[:axes]), np.array(bias[:axes]))
        for name, gain, bias, axes in zip(group.names, gains, biases, group.axes, strict=True)
    }


def _in_order(
    ribbon: Ribbon, models: dict[str, SensorModel], out: Sequence[LeftOut]
) -> tuple[SensorModel, ...]:
    """The models in the ribbon's order; those left out are nominal and unused."""
    for item in out:
        sensor = next(sensor for sensor in ribbon.sensors if sensor.name == item.name)
        gain = np.eye(3)[: sensor.axes] * sensor.counts_per_unit
        bias = np.zeros(sensor.axes)
        models[item.name] = SensorModel(item.name, gain, bias, used=False, reason=item.reason)
    return tuple(models[sensor.name] for sensor in ribbon.sensors)
