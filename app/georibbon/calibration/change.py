"""What has changed from one calibration of a ribbon to the next."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration, SensorModel
from georibbon.calibration.serial import check_fits
from georibbon.ribbon import KINDS, Ribbon, Sensor, SensorKind
from georibbon.rotations import exp, log

# A sensor stands out when it has changed by more than this, and by so many times the median.
LEAST_CHANGE = 0.5  # degrees
STANDS_OUT = 3.0
MOST_LISTED = 4
# What is worth a word beyond what calibrations of an unchanged ribbon differ by.
COMMON_TURN, DIP = 0.3, 1.0  # degrees
STRENGTH = 1.0  # percent


@dataclass(frozen=True)
class SensorChange:
    """How one sensor's model has changed; what all share is taken out of it.

    degrees: of what it would read, rms over all directions, as an angle.  tilt,
    heading: degrees it has turned about the ribbon's x and y, and about its z.
    bias: mg, or percent of the field (hard iron).  scale: percent.  All NaN
    where one of the calibrations leaves the sensor out.
    """

    name: str
    kind: SensorKind
    degrees: float
    tilt: float
    heading: float
    bias: float
    scale: float
    stands_out: bool = False


@dataclass(frozen=True)
class Difference:
    """What has changed between two calibrations of one ribbon.

    turn: degrees, common to all sensors.  strength: percent by which the field is
    stronger in the second; dip: degrees by which it is steeper.  lost, regained:
    sensors that the first alone, that the second alone uses.  words: a sentence.
    """

    sensors: tuple[SensorChange, ...]
    turn: float
    strength: float
    dip: float
    lost: tuple[str, ...]
    regained: tuple[str, ...]
    words: str


@dataclass(frozen=True, eq=False)
class _Pair:
    """One sensor's models, with B = (1 + scale) A turn as nearly as can be."""

    sensor: Sensor
    old: SensorModel
    new: SensorModel
    turn: FloatArray
    factor: float

    @property
    def tells_up(self) -> bool:
        return self.sensor.kind == "accelerometer"


def difference(ribbon: Ribbon, old: Calibration, new: Calibration) -> Difference:
    """What has changed from `old` to `new`, two calibrations of one ribbon.

    The turn from gain A to gain B is the rotation nearest to it, from the
    singular vectors of A^T B (Schönemann 1966).  Raises CalibrationError where
    one of them is not this ribbon's.
    """
    check_fits(old, ribbon)
    check_fits(new, ribbon)
    pairs = [
        _pair(sensor, a, b)
        for sensor, a, b in zip(ribbon.sensors, old.sensors, new.sensors, strict=True)
    ]
    both = [pair for pair in pairs if pair.old.used and pair.new.used]
    heavy = [pair for pair in both if pair.tells_up]
    common = np.median([log(pair.turn) for pair in heavy or both] or [np.zeros(3)], axis=0)
    factor = float(np.median([pair.factor for pair in both if not pair.tells_up] or [1.0]))
    changes = _marked(ribbon, [_change(pair, exp(common), factor) for pair in pairs])
    lost = tuple(pair.sensor.name for pair in pairs if pair.old.used and not pair.new.used)
    regained = tuple(pair.sensor.name for pair in pairs if pair.new.used and not pair.old.used)
    turn, strength = float(np.degrees(np.linalg.norm(common))), 100.0 * (factor - 1.0)
    dip = float(np.degrees(new.dip - old.dip))
    words = _words(changes, turn, strength, dip, lost, regained)
    return Difference(tuple(changes), turn, strength, dip, lost, regained, words)


def _pair(sensor: Sensor, old: SensorModel, new: SensorModel) -> _Pair:
    u, _, vt = np.linalg.svd(old.gain.T @ new.gain)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    factor = float(((old.gain @ turn) * new.gain).sum() / (old.gain**2).sum())
    return _Pair(sensor, old, new, turn, factor)


def _change(pair: _Pair, common: FloatArray, strength: float) -> SensorChange:
    if not (pair.old.used and pair.new.used):
        nothing = math.nan
        return SensorChange(
            pair.sensor.name,
            pair.sensor.kind,
            degrees=nothing,
            tilt=nothing,
            heading=nothing,
            bias=nothing,
            scale=nothing,
        )
    factor = 1.0 if pair.tells_up else strength
    unit = float(np.linalg.norm(pair.old.gain)) / np.sqrt(len(pair.old.bias))
    gain = (pair.new.gain @ common.T / factor - pair.old.gain) / unit
    bias = float(np.linalg.norm(pair.new.bias - pair.old.bias)) / unit
    turned = np.degrees(log(pair.turn @ common.T))
    return SensorChange(
        pair.sensor.name,
        pair.sensor.kind,
        float(np.degrees(np.sqrt((gain**2).sum() / 3.0 + bias**2))),
        float(np.hypot(turned[0], turned[1])),
        abs(float(turned[2])),
        bias * (1e3 if pair.tells_up else 1e2),
        100.0 * (pair.factor / factor - 1.0),
    )


def _marked(ribbon: Ribbon, changes: Sequence[SensorChange]) -> list[SensorChange]:
    """The changes, with those that stand out among their kind marked."""
    marked = list(changes)
    for kind in KINDS:
        places = [i for i, one in enumerate(ribbon.sensors) if one.kind == kind]
        known = [changes[i].degrees for i in places if np.isfinite(changes[i].degrees)]
        if not known:
            continue
        limit = max(LEAST_CHANGE, STANDS_OUT * float(np.median(known)))
        for i in places:
            if changes[i].degrees > limit:
                marked[i] = replace(changes[i], stands_out=True)
    return marked


def _words(
    changes: Sequence[SensorChange],
    turn: float,
    strength: float,
    dip: float,
    lost: Sequence[str],
    regained: Sequence[str],
) -> str:
    out = sorted((one for one in changes if one.stands_out), key=lambda one: -one.degrees)
    others = [c.degrees for c in changes if not c.stands_out and np.isfinite(c.degrees)]
    limit = f"{np.ceil(max(others, default=0.0) * 10.0 + 1e-9) / 10.0:.1f}°"
    if not out:
        words = [f"no sensor stands out, all have changed by less than {limit}"]
    else:
        named = [f"{one.name} has changed by {one.degrees:.1f}°" for one in out[:MOST_LISTED]]
        if len(out) > MOST_LISTED:
            named.append(f"{len(out) - MOST_LISTED} more have changed")
        words = [", ".join([*named, f"all others by less than {limit}"])]
    if lost:
        words.append(f"no longer used: {', '.join(lost)}")
    if regained:
        words.append(f"used again: {', '.join(regained)}")
    if turn > COMMON_TURN:
        words.append(f"all together are turned by {turn:.1f}°: the bar or how they lie on it")
    if abs(strength) > STRENGTH:
        words.append(
            f"the field is {abs(strength):.1f} % {'stronger' if strength > 0 else 'weaker'}"
        )
    if abs(dip) > DIP:
        words.append(f"the field is {abs(dip):.1f}° {'steeper' if dip > 0 else 'flatter'}")
    return "; ".join(words)
