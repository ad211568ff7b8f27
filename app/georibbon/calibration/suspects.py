"""Sensors that show before any fit, or by their fitted axes, that they cannot be used."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np

from georibbon.arrays import BoolArray, FloatArray
from georibbon.calibration.poses import Block
from georibbon.calibration.separable import Prior, linear_fit
from georibbon.notices import Notice
from georibbon.recording import Pose
from georibbon.ribbon import AXIS_LETTERS, Ribbon

# An axis that moves less than this share of what the others (or the labels) say is dead.
DEAD_SHARE = 0.15
LEAST_RANGE = 0.3
RAIL_FRAMES = 10  # fewer say nothing of an axis being stuck at its end
# A cell is saturated when this share of its frames lie on the axis' very end.
RAIL_SHARE = 0.3
LEAST_CELLS = 8
SCALES = {"accelerometer": (0.7, 1.4), "magnetometer": (0.2, 5.0)}


@dataclass(frozen=True)
class LeftOut:
    """A sensor that is left out of every fit: its name, the notice's code and why."""

    name: str
    code: str
    reason: str

    def notice(self) -> Notice:
        """The notice for the person."""
        return Notice(
            self.code,
            f"sensor {self.name} is left out: {self.reason}",
            sensor=self.name,
        )


def keep(block: Block, out: Sequence[LeftOut]) -> Block:
    """The block without the sensors that are left out."""
    names = {item.name for item in out}
    return block.only(np.array([name not in names for name in block.names], dtype=bool))


def _present(block: Block) -> BoolArray:
    """(n, 3) which axes the sensors have."""
    return np.asarray(np.arange(3) < block.axes[:, None])


def _axis_text(axes: BoolArray) -> str:
    letters = [AXIS_LETTERS[k] for k in np.flatnonzero(axes)]
    if len(letters) == 1:
        return f"its {letters[0]} axis"
    return f"its {', '.join(letters[:-1])} and {letters[-1]} axes"


def dead_sensors(block: Block, expected: FloatArray) -> list[LeftOut]:
    """Sensors with an axis that gave no value, or did not move over the poses.

    expected: (3,) the range over the poses that each axis must show, in units.
    """
    finite = np.isfinite(block.values)
    values = np.where(finite, block.values, np.nan)
    present = _present(block)
    lost: BoolArray = present & (finite.sum(axis=1) < LEAST_CELLS)
    filled = np.where(lost[:, None, :] | ~present[:, None, :], 0.0, values)
    spans = np.nanmax(filled, axis=1) - np.nanmin(filled, axis=1)
    still: BoolArray = present & ~lost & (spans < DEAD_SHARE * expected) & (expected > LEAST_RANGE)
    out = []
    poses = block.values.shape[1]
    for n in np.flatnonzero((lost | still).any(axis=1)):
        found = (
            f"{_axis_text(lost[n])} gave values in fewer than {LEAST_CELLS} of {poses} poses"
            if lost[n].any()
            else f"{_axis_text(still[n])} did not move over {poses} poses"
        )
        reason = f"{found}; check its connection or replace it"
        out.append(LeftOut(block.names[n], "sensor-dead", reason))
    return out


def usual_range(block: Block) -> FloatArray:
    """(3,) the upper quartile over the sensors of each axis' range over the poses, in units.

    So that a ribbon half of which is dead still says how far an axis must move.
    """
    values = np.where(np.isfinite(block.values), block.values, np.nan)
    present = _present(block) & np.isfinite(values).any(axis=1)
    values = np.where(present[:, None, :], values, 0.0)
    spans = np.where(present, np.nanmax(values, axis=1) - np.nanmin(values, axis=1), np.nan)
    known = np.flatnonzero(present.any(axis=0))
    found = np.zeros(3)
    found[known] = np.nanquantile(spans[:, known], 0.75, axis=0)
    return found


def saturated_columns(poses: Sequence[Pose]) -> BoolArray:
    """(p, c) bool: which poses hold an axis at the end of its range.

    An axis is saturated in a pose when a good share of its frames equal, to the
    count, the highest or lowest value it ever gave, and its noise is gone.
    """
    counts = [pose.readings.counts for pose in poses]
    stacked = np.concatenate(counts)
    filled = np.isfinite(stacked).any(axis=0)
    safe = [np.where(filled, c, 0.0) for c in counts]
    top = np.nanmax(np.where(filled, stacked, 0.0), axis=0)
    bottom = np.nanmin(np.where(filled, stacked, 0.0), axis=0)
    spread = np.array([_spread(c) for c in safe])
    # Most poses may be saturated: the noise is what the liveliest fifth shows.
    noise = np.quantile(spread, 0.8, axis=0)
    railed = np.array(
        [
            np.maximum((c == top).mean(0), (c == bottom).mean(0)) * (len(c) >= RAIL_FRAMES)
            for c in safe
        ]
    )
    return np.asarray((railed > RAIL_SHARE) & (noise > 1.0) & (spread < 0.7 * noise))


def _spread(counts: FloatArray) -> FloatArray:
    """(c,) standard deviation of each column, lost values left out, 0 where all are lost."""
    present = np.isfinite(counts)
    number = np.maximum(present.sum(axis=0), 1)
    values = np.where(present, counts, 0.0)
    mean = values.sum(axis=0) / number
    return np.asarray(np.sqrt((np.where(present, counts - mean, 0.0) ** 2).sum(axis=0) / number))


def without_saturated(
    ribbon: Ribbon, block: Block, saturated: BoolArray
) -> tuple[Block, list[Notice]]:
    """The block with its saturated cells left out, and a notice for each sensor."""
    cells = np.zeros_like(block.valid)
    for n, i in enumerate(block.indices):
        cells[n] = saturated[:, ribbon.slices[i]].any(axis=1)
    notices = [
        Notice(
            "sensor-saturated",
            f"sensor {block.names[n]} reached the end of its range in {int(cells[n].sum())} of "
            f"{cells.shape[1]} poses, which are left out for it; choose a wider range for it",
            sensor=block.names[n],
        )
        for n in np.flatnonzero(cells.any(axis=1))
    ]
    return replace(block, valid=block.valid & ~cells), notices


def too_few_cells(block: Block) -> list[LeftOut]:
    """Sensors that have too few poses left to be determined."""
    numbers = block.valid.sum(axis=1)
    return [
        LeftOut(
            block.names[n],
            "sensor-dead",
            f"only {int(numbers[n])} of {block.valid.shape[1]} poses can be used, at least "
            f"{LEAST_CELLS} are needed; check its connection and its range",
        )
        for n in np.flatnonzero(numbers < LEAST_CELLS)
    ]


def undetermined(
    names: Sequence[str], figures: FloatArray, limit: float, unit: str
) -> list[LeftOut]:
    """Sensors, where most are well determined, whose own worst parameter is not."""
    return [
        LeftOut(
            names[n],
            "sensor-undetermined",
            f"too few of its readings agree, its worst parameter is known to {figures[n]:.2f} "
            f"{unit} and {limit} {unit} is needed; check its fastening and its connection",
        )
        for n in map(int, np.flatnonzero(figures > limit))
    ]


def fitted_axes(block: Block, directions: FloatArray, prior: Prior) -> FloatArray:
    """(n, 3, 3) each sensor's gain for the given shared directions, (p, 3)."""
    values = np.where(block.valid[:, :, None], block.values, 0.0)
    theta, _ = linear_fit(values, directions, block.valid.astype(np.float64), prior)
    return theta[:, :, :3]


def wrong_axes(block: Block, gains: FloatArray, kind: str) -> list[LeftOut]:
    """Sensors whose fitted axes are another signed permutation of the ribbon's than the right one.

    gains: (n, 3, 3) in units.  Also those whose gain is far from nominal.
    """
    out = []
    for name, gain, axes in zip(block.names, gains, block.axes, strict=True):
        found = _nearest_axes(gain[:axes])
        size = float(np.linalg.norm(gain) / np.sqrt(axes))
        low, high = SCALES[kind]
        if found != " ".join(f"+{letter}" for letter in AXIS_LETTERS[:axes]):
            reason = (
                f"its axes are {found} of the ribbon's instead of "
                f"{' '.join('+' + letter for letter in AXIS_LETTERS[:axes])}; "
                "correct its wiring or its mounting"
            )
            out.append(LeftOut(name, "sensor-axes-swapped", reason))
        elif not low < size < high:
            reason = (
                f"it reads {size:.2f} times what its counts_per_unit says; correct "
                "counts_per_unit or replace the sensor"
            )
            out.append(LeftOut(name, "sensor-scale", reason))
    return out


def _nearest_axes(gain: FloatArray) -> str:
    """The signed axes nearest to a gain's rows, such as "-x +y +z"."""
    rows = len(gain)
    best, text = -np.inf, ""
    for columns in permutations(range(3), rows):
        for signs in product((1.0, -1.0), repeat=rows):
            score = sum(s * gain[k, c] for k, (s, c) in enumerate(zip(signs, columns, strict=True)))
            if score > best + 1e-12:
                best = score
                text = " ".join(
                    ("+" if s > 0 else "-") + AXIS_LETTERS[c]
                    for s, c in zip(signs, columns, strict=True)
                )
    return text
