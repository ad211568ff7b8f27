"""Poses as arrays: what the sensors read in each, in units, and what was asked for."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray, IntArray
from georibbon.errors import CalibrationError
from georibbon.recording import Pose
from georibbon.ribbon import KINDS, Ribbon, SensorKind
from georibbon.rotations import about_x, about_y
from georibbon.stillness import StillMeans
from georibbon.world import UP

# A pose in which fewer axes of a kind gave values is left out.
LEAST_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Attitudes:
    """The attitudes asked for, radians: R = Rz(heading) Ry(-pitch) Rx(roll), (p,) each.

    table: (p,) bool, the bar lay with a face on the one table.  numbers: the
    poses' places in the recording, counted from 1.
    """

    names: tuple[str, ...]
    roll: FloatArray
    heading: FloatArray
    pitch: FloatArray
    table: BoolArray
    numbers: tuple[int, ...]

    @property
    def level(self) -> FloatArray:
        """(p, 3, 3) Ry(-pitch) Rx(roll): the attitudes before they are turned to a heading."""
        return about_y(-self.pitch) @ about_x(self.roll)

    @property
    def up(self) -> FloatArray:
        """(p, 3) "up" in the bar's frame, as the labels have it."""
        return np.asarray(self.level.mT @ UP)


@dataclass(frozen=True, eq=False)
class Block:
    """What the sensors of one kind read in the poses.

    indices: their places among the ribbon's sensors, (n,).  values: (n, p, 3)
    float64 pose means in units (g, or local fields); 0 on an axis that the
    sensor has not.  valid: (n, p) bool, the cell has all its values.  sigma:
    (n, p) float64, the mean's standard deviation in units, rms over the axes.
    nominal: (n, 3, 3), identity rows for the axes it has.
    """

    indices: tuple[int, ...]
    names: tuple[str, ...]
    axes: IntArray
    units: FloatArray
    values: FloatArray
    valid: BoolArray
    sigma: FloatArray
    nominal: FloatArray

    def only(self, keep: BoolArray) -> "Block":
        """The block of the sensors for which `keep`, (n,) bool, is true."""
        places = np.flatnonzero(keep)
        return Block(
            tuple(self.indices[i] for i in places),
            tuple(self.names[i] for i in places),
            self.axes[keep],
            self.units[keep],
            self.values[keep],
            self.valid[keep],
            self.sigma[keep],
            self.nominal[keep],
        )


def attitudes(poses: Sequence[Pose], kept: BoolArray) -> Attitudes:
    """The attitudes asked for in the poses that are kept, (p,) bool.

    Raises CalibrationError for an angle that is no number."""
    numbers = [int(p) + 1 for p in np.flatnonzero(kept)]
    poses = [poses[number - 1] for number in numbers]
    angles = np.radians([[pose.roll, pose.heading, pose.pitch] for pose in poses])
    bad = ~np.isfinite(angles).all(axis=1)
    if bad.any():
        name = poses[int(np.argmax(bad))].name
        raise CalibrationError(
            f"pose {name!r} has a roll, heading or pitch that is no finite number of degrees; "
            "correct it in the recording"
        )
    return Attitudes(
        tuple(pose.name for pose in poses),
        angles[:, 0],
        angles[:, 1],
        angles[:, 2],
        np.array([pose.table for pose in poses], dtype=bool),
        tuple(numbers),
    )


def require_columns(ribbon: Ribbon, poses: Sequence[Pose]) -> None:
    """Raises CalibrationError where a pose's columns are not the ribbon's."""
    for pose in poses:
        columns = pose.readings.counts.shape[-1]
        if columns != len(ribbon.columns):
            raise CalibrationError(
                f"pose {pose.name!r} has {columns} columns and ribbon {ribbon.id} has "
                f"{len(ribbon.columns)}; record the pose with this ribbon"
            )


def with_values(ribbon: Ribbon, poses: Sequence[Pose]) -> BoolArray:
    """(p,) bool: the poses in which most sensors of each kind gave values.

    Counted are the axes that gave a value in any pose: a dead sensor is no
    pose's fault.
    """
    has = np.array([np.isfinite(pose.readings.counts).any(axis=0) for pose in poses])
    alive = has.any(axis=0) if len(poses) else np.zeros(0, dtype=bool)
    good = np.ones(len(poses), dtype=bool)
    for kind in KINDS:
        axes = [column for s in ribbon.sensors if s.kind == kind for column in s.columns]
        counted = alive & np.isin(ribbon.columns, axes) if len(poses) else alive
        if counted.any():
            good &= has[:, counted].mean(axis=1) >= LEAST_SHARE
    return good


def block(ribbon: Ribbon, means: Sequence[StillMeans], kind: SensorKind) -> Block:
    """The readings of the sensors of one kind, in units."""
    indices = ribbon.indices(kind)
    sensors = [ribbon.sensors[i] for i in indices]
    counts = np.array([mean.mean for mean in means])
    sigmas = np.array([mean.sigma for mean in means])
    values = np.zeros((len(indices), len(means), 3))
    variance = np.zeros_like(values)
    for n, i in enumerate(indices):
        values[n, :, : sensors[n].axes] = counts[:, ribbon.slices[i]]
        variance[n, :, : sensors[n].axes] = sigmas[:, ribbon.slices[i]] ** 2
    units = np.array([sensor.counts_per_unit for sensor in sensors])
    axes = np.array([sensor.axes for sensor in sensors], dtype=np.int64)
    valid: BoolArray = np.asarray(np.isfinite(values).all(axis=2))
    sigma = np.sqrt(variance.sum(axis=2) / axes[:, None]) / units[:, None]
    return Block(
        indices,
        tuple(sensor.name for sensor in sensors),
        axes,
        units,
        values / units[:, None, None],
        valid,
        sigma,
        np.eye(3)[None] * (np.arange(3) < axes[:, None])[:, :, None],
    )
