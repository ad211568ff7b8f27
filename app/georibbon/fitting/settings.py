"""What a person may choose of a reconstruction."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from georibbon.errors import SettingsError
from georibbon.geometry.settings import TANGENTS, SurfaceSettings, TangentRule
from georibbon.notices import Notice
from georibbon.recording import Recording

Method = Literal["ribbon", "paper"]
Trim = tuple[float, float]
METHODS: tuple[Method, ...] = ("ribbon", "paper")
EVERY = "*"
SHORTEST_SMOOTHING = 0.001  # m: a shorter one means nothing on any ribbon
LONGEST_SMOOTHING = 10.0
LEAST_WEIGHT, MOST_WEIGHT = 0.01, 100.0
LEAST_LEFT = 0.05  # m of a pass that must be left by its trims: a surface needs a curve


@dataclass(frozen=True)
class ReconstructionSettings:
    """What a person may choose.

    method: "ribbon", the fit to the readings, or "paper", from tangents as the
    source paper does.  neighbours: whether neighbouring passes correct each
    other.  tangents: how the paper's way interpolates them: "unrolled" from the
    sphere, by spherical "averages", or by "components"; the fit to the readings
    needs none.  surface: None for curves alone.  The others are by the pass's
    name, or "*" for all others:

    smoothing: metres; chosen by the evidence where nothing is given.
    sensors_off: names of sensors that are not listened to; those of "*" are
    off in every pass.  trim: metres cut off the start and the end of the curve
    and of the surface; the fit uses the whole pass.  weight: a pass counts
    against its neighbours and the survey as so many passes with the same
    readings; by itself it stays what it is.

    Raises SettingsError for what can mean nothing.
    """

    method: Method = "ribbon"
    neighbours: bool = True
    tangents: TangentRule = "unrolled"
    smoothing: Mapping[str, float] = field(default_factory=dict)
    surface: SurfaceSettings | None = field(default_factory=SurfaceSettings)
    sensors_off: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    trim: Mapping[str, Trim] = field(default_factory=dict)
    weight: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise SettingsError(
                f'the method is "{self.method}"; it must be one of {", ".join(METHODS)}'
            )
        if self.tangents not in TANGENTS:
            raise SettingsError(
                f'the tangents are "{self.tangents}"; they must be one of {", ".join(TANGENTS)}'
            )
        for name, length in self.smoothing.items():
            if not (np.isfinite(length) and SHORTEST_SMOOTHING <= length <= LONGEST_SMOOTHING):
                raise SettingsError(
                    f"the smoothing of {_told(name)} is {1e3 * length:g} mm; it must be between "
                    f"{1e3 * SHORTEST_SMOOTHING:g} and {1e3 * LONGEST_SMOOTHING:g} mm"
                )
        for name, ends in self.trim.items():
            _check_trim(name, ends)
        for name, weight in self.weight.items():
            if not (np.isfinite(weight) and LEAST_WEIGHT <= weight <= MOST_WEIGHT):
                raise SettingsError(
                    f"the weight of {_told(name)} is {weight:g}; it must be between "
                    f"{LEAST_WEIGHT:g} and {MOST_WEIGHT:g}, 1 for a pass that counts as any other"
                )

    def smoothing_of(self, name: str) -> float | None:
        """The smoothing of a pass, metres; None where the evidence is to choose."""
        return self.smoothing.get(name, self.smoothing.get(EVERY))

    def weight_of(self, name: str) -> float:
        """The weight of a pass."""
        return self.weight.get(name, self.weight.get(EVERY, 1.0))

    def trim_of(self, name: str) -> Trim:
        """What is cut off the start and the end of a pass, metres."""
        return self.trim.get(name, self.trim.get(EVERY, (0.0, 0.0)))

    def off_in(self, name: str) -> frozenset[str]:
        """The sensors that are not listened to in a pass."""
        own, every = self.sensors_off.get(name, ()), self.sensors_off.get(EVERY, ())
        return frozenset((*own, *every))


def check_settings(settings: ReconstructionSettings, recording: Recording) -> None:
    """Raise SettingsError where the settings name what the recording has not."""
    names = [one.name for one in recording.passes]
    for verb, of in (
        ("smooth", settings.smoothing),
        ("switch sensors off in", settings.sensors_off),
        ("trim", settings.trim),
        ("weigh", settings.weight),
    ):
        unknown = [name for name in of if name != EVERY and name not in names]
        if unknown:
            raise SettingsError(
                f"there is no pass {unknown[0]} to {verb}; the passes are {', '.join(names)}"
            )
    _check_sensors(settings.sensors_off.values(), recording)
    length = recording.ribbon.length
    for name in names:
        start, end = settings.trim_of(name)
        if start + end > 0 and length - start - end < LEAST_LEFT:
            raise SettingsError(
                f"the trims of pass {name}, {1e3 * start:g} and {1e3 * end:g} mm, leave "
                f"{1e3 * max(length - start - end, 0.0):g} mm of a ribbon {1e3 * length:g} mm "
                f"long; leave at least {1e3 * LEAST_LEFT:g} mm"
            )


def weight_notices(settings: ReconstructionSettings, names: Iterable[str]) -> list[Notice]:
    """That standard deviations go with the weights of the passes, those alike in all told once.

    names: of all passes.  None where every pass counts once, nor of the paper's
    way, which weighs nothing.
    """
    weights = {name: settings.weight_of(name) for name in names}
    if settings.method == "paper":
        return []
    if len(set(weights.values())) == 1:
        weights = {EVERY: next(iter(weights.values()))}
    return [
        Notice(
            "weighted",
            f"{_told(name)}: weighed {weight:g} times, so that what is stated of its uncertainty "
            "is as if it had been laid so often",
            None if name == EVERY else name,
        )
        for name, weight in weights.items()
        if weight != 1.0
    ]


def _check_sensors(off: Iterable[tuple[str, ...]], recording: Recording) -> None:
    sensors = [one.name for one in recording.ribbon.sensors]
    for names in off:
        unknown = [name for name in names if name not in sensors]
        if unknown:
            raise SettingsError(
                f"there is no sensor {unknown[0]} to switch off; ribbon {recording.ribbon.id} has "
                f"{sensors[0]} to {sensors[-1]}"
            )


def _check_trim(name: str, ends: Trim) -> None:
    for end, length in zip(("start", "end"), ends, strict=True):
        if not (np.isfinite(length) and 0.0 <= length <= LONGEST_SMOOTHING):
            raise SettingsError(
                f"{1e3 * length:g} mm are to be cut off the {end} of {_told(name)}; it must be a "
                f"length between 0 and {1e3 * LONGEST_SMOOTHING:g} mm"
            )


def _told(name: str) -> str:
    return "all passes" if name == EVERY else f"pass {name}"
