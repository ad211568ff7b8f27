"""What the residuals of an adjustment say of sensors, poses and single cells."""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.labels import name_of
from georibbon.calibration.poses import Attitudes, Block
from georibbon.calibration.separable import Adjusted, cell_residuals, median_of, robust_scale
from georibbon.notices import Notice

# A cell stands out beyond twice the scale of the robust weights, which is six
# times the median residual: noise does not reach it in a thousand calibrations.
OUT = 2.0
# A sensor stands out when its median cell does beyond this many overall medians
# (and floors): a few disturbed poses do not make a sensor bad.
SENSOR_OUT = 4.0
MOST = 0.5


@dataclass(frozen=True)
class Wording:
    """How the findings of one kind are told."""

    kind: str
    unit: str
    factor: float
    sensor: str
    pose: str


ACCELEROMETER = Wording(
    "accelerometer",
    "mg",
    1e3,
    "it is loose on the ribbon or drifts; fasten it or replace it, and calibrate again",
    "the bar was moved while it was measured; take this pose again, held still",
)
MAGNETOMETER = Wording(
    "magnetometer",
    "% of the field",
    1e2,
    "it drifts or is loose on the ribbon; let the ribbon warm up, and calibrate again",
    "steel or a current was near; take this pose again away from it",
)


def findings(
    block: Block, adjusted: Adjusted, asked: Attitudes, floor: float, words: Wording
) -> list[Notice]:
    """Notices for every sensor, pose and cell that stands out; all are already down-weighted."""
    valid = block.valid.astype(np.float64)
    cells = cell_residuals(adjusted.residuals, block.axes.astype(np.float64))
    shown = np.where(block.valid, cells, np.nan)
    out = block.valid & (cells > OUT * robust_scale(cells, valid, floor))
    limit = SENSOR_OUT * max(float(np.nanmedian(shown)), floor)
    sensors = median_of(cells, valid, 1) > limit
    others = block.valid & ~sensors[:, None]
    poses = (out & others).sum(axis=0) > MOST * np.maximum(others.sum(axis=0), 1)
    notices = [
        _sensor_notice(block.names[n], shown[n], block, words) for n in np.flatnonzero(sensors)
    ]
    notices += [
        Notice(
            "pose-disturbed",
            f"{name_of(asked, p)} disagrees with the others by "
            f"{np.nanmedian(shown[:, p]) * words.factor:.1f} {words.unit} in most {words.kind}s "
            f"and hardly counts: {words.pose}",
        )
        for p in map(int, np.flatnonzero(poses))
    ]
    single = out & ~sensors[:, None] & ~poses
    return notices + [
        _cells_notice(block, shown[:, p], single[:, p], name_of(asked, p), words)
        for p in map(int, np.flatnonzero(single.any(axis=0)))
    ]


def _sensor_notice(name: str, cells: FloatArray, block: Block, words: Wording) -> Notice:
    return Notice(
        "sensor-drifting",
        f"sensor {name} disagrees with the {len(block.names) - 1} others by "
        f"{np.nanmedian(cells) * words.factor:.1f} {words.unit} over the poses and hardly "
        f"counts: {words.sensor}",
        sensor=name,
    )


def _cells_notice(
    block: Block, cells: FloatArray, out: BoolArray, pose: str, words: Wording
) -> Notice:
    names = [block.names[n] for n in np.flatnonzero(out)]
    worst = float(np.nanmax(np.where(out, cells, np.nan))) * words.factor
    return Notice(
        "pose-cell-disturbed",
        f"{pose} disagrees with the others at {', '.join(names)} by up to {worst:.1f} "
        f"{words.unit}, which hardly count: {words.pose}",
        sensor=names[0] if len(names) == 1 else None,
    )
