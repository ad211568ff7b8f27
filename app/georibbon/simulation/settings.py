"""Every property of a virtual capture."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any, Literal

from georibbon.calibration.plans import PLANS
from georibbon.errors import SettingsError

SurveyKind = Literal["starts", "ends", "distances"]
SURVEY_KINDS: tuple[SurveyKind, ...] = ("starts", "ends", "distances")


def _within(what: str, value: float, least: float, most: float) -> None:
    if not (isfinite(value) and least <= value <= most):
        raise SettingsError(f"{what} is {value:g}; give a value from {least:g} to {most:g}")


@dataclass(frozen=True)
class RibbonSettings:
    """The virtual ribbon and what is wrong with it; magnitudes are standard deviations.

    sensors: in all, accelerometers and magnetometers alternating, the first an
    accelerometer.  length: metres.  rate: frames a second.  acceleration_noise:
    g a sample; field_noise: of the local field a sample.  bias: g; scale,
    cross_axis: of the gain; mounting: degrees an axis; hard_iron, soft_iron:
    of the local field.
    """

    id: str = "GR-0001"
    sensors: int = 32
    length: float = 0.96
    magnetometer_axes: int = 2
    rate: float = 100.0
    acceleration_noise: float = 0.001
    field_noise: float = 0.005
    bias: float = 0.03
    scale: float = 0.02
    cross_axis: float = 0.01
    mounting: float = 2.0
    hard_iron: float = 0.3
    soft_iron: float = 0.1

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        _within("sensors", self.sensors, 4, 256)
        if self.magnetometer_axes not in (2, 3):
            raise SettingsError(f"magnetometer axes are {self.magnetometer_axes}; give 2 or 3")
        _within("the ribbon's length (m)", self.length, 0.1, 20.0)
        _within("the rate (frames per second)", self.rate, 1.0, 10000.0)
        for name in ("acceleration_noise", "field_noise", "bias", "scale", "cross_axis"):
            _within(name, getattr(self, name), 0.0, 0.5)
        _within("mounting (degrees)", self.mounting, 0.0, 30.0)
        _within("hard_iron", self.hard_iron, 0.0, 5.0)
        _within("soft_iron", self.soft_iron, 0.0, 0.5)


@dataclass(frozen=True)
class PoseSettings:
    """The calibration on the bar.

    plan: the number of poses of a known plan, 0 for none; or `poses`, a list
    of (roll, heading, pitch, on the table) in degrees, in its place.
    heading_care, pitch_care: degrees, standard deviations of what was done
    from what was asked.  bend: degrees an axis at each sensor, the same in all
    poses.  table_tilt: degrees an axis.
    """

    plan: int = 16
    poses: tuple[tuple[float, float, float, bool], ...] = ()
    heading_care: float = 10.0
    pitch_care: float = 3.0
    bend: float = 0.2
    table_tilt: float = 0.5

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        if self.plan != 0 and self.plan not in PLANS:
            known = ", ".join(str(number) for number in PLANS)
            raise SettingsError(f"there is no plan of {self.plan} poses; choose {known}, or 0")
        for name in ("heading_care", "pitch_care", "bend", "table_tilt"):
            _within(f"{name} (degrees)", getattr(self, name), 0.0, 90.0)


@dataclass(frozen=True)
class LayoutSettings:
    """How the passes lie; None: the surface's own default.

    start: (u, v) of the middle of the passes; heading: degrees of the passes
    from the surface's u direction about its normal; spacing: metres between
    neighbouring passes in their middles.  fan: degrees between neighbouring
    passes, by turns one way and the other, or ("spread") ever further.
    tie_places: where the ties cross the middle pass, as fractions of the
    ribbon; empty: spread evenly.  contact: degrees an axis, at each sensor of
    each pass.
    """

    passes: int = 5
    start: tuple[float, float] | None = None
    heading: float | None = None
    spacing: float | None = None
    fan: float = 0.0
    fan_kind: Literal["alternate", "spread"] = "alternate"
    ties: int = 0
    tie_places: tuple[float, ...] = ()
    contact: float = 0.25

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        _within("the number of passes", self.passes, 2, 1000)
        _within("the number of ties", self.ties, 0, 100)
        for value in self.start or ():
            _within("a coordinate of the start", value, -1000.0, 1000.0)
        if self.spacing is not None:
            _within("spacing (m)", self.spacing, 0.001, 2.0)
        _within("heading (degrees)", self.heading or 0.0, -360.0, 360.0)
        _within("fan (degrees)", self.fan, -45.0, 45.0)
        _within("contact (degrees)", self.contact, 0.0, 30.0)
        if self.fan_kind not in ("alternate", "spread"):
            raise SettingsError(f"fan_kind is {self.fan_kind!r}; give 'alternate' or 'spread'")
        if self.tie_places and len(self.tie_places) != self.ties:
            raise SettingsError(
                f"{len(self.tie_places)} tie places are given for {self.ties} ties; give one each"
            )
        for place in self.tie_places:
            _within("a tie's place (fraction of the ribbon)", place, 0.0, 1.0)


@dataclass(frozen=True)
class SurveySettings:
    """What is measured besides the passes; sigmas in metres.

    kinds: any of "starts" and "ends" (their positions are marked) and
    "distances" (between neighbouring starts and ends).  Crossings are recorded
    wherever a tie meets a pass.
    """

    kinds: tuple[SurveyKind, ...] = ("starts", "ends")
    mark_sigma: float = 0.0005
    distance_sigma: float = 0.0005
    crossing_sigma: float = 0.001

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        for kind in self.kinds:
            if kind not in SURVEY_KINDS:
                raise SettingsError(
                    f"there is no survey kind {kind!r}; choose from {', '.join(SURVEY_KINDS)}"
                )
        for name in ("mark_sigma", "distance_sigma", "crossing_sigma"):
            _within(f"{name} (m)", getattr(self, name), 1e-6, 0.1)


@dataclass(frozen=True)
class FaultSettings:
    """What has gone wrong.

    dead: names of sensors that say nothing but 0.  magnet: the strongest
    disturbance, of the local field, `magnet_place` metres along the pass
    `magnet_on`; it falls off over `magnet_reach` metres.  lost: the share of
    values that are lost.
    """

    dead: tuple[str, ...] = ()
    magnet: float = 0.0
    magnet_on: str = "P2"
    magnet_place: float | None = None
    magnet_reach: float = 0.12
    lost: float = 0.0

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        _within("the magnet (of the field)", self.magnet, 0.0, 10.0)
        _within("magnet_reach (m)", self.magnet_reach, 0.01, 10.0)
        _within("the share of lost values", self.lost, 0.0, 0.9)


@dataclass(frozen=True)
class SimulationSettings:
    """A virtual capture: surface, place, ribbon, poses, passes, survey, faults, seed.

    parameters: of the surface, by name, where they differ from its defaults.
    dip: degrees, the field below the horizontal.  yaw: degrees, world =
    Rz(yaw) workpiece; None: drawn from the seed.  tell_heading: the recording
    says it.  frames: in each file.
    """

    surface: str = "bonnet"
    parameters: Mapping[str, float] = field(default_factory=dict)
    seed: int = 1
    ribbon: RibbonSettings = RibbonSettings()
    poses: PoseSettings = PoseSettings()
    layout: LayoutSettings = LayoutSettings()
    survey: SurveySettings = SurveySettings()
    faults: FaultSettings = FaultSettings()
    dip: float = 62.0
    yaw: float | None = None
    tell_heading: bool = False
    frames: int = 100
    title: str | None = None

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        _within("the dip (degrees)", self.dip, -89.0, 89.0)
        _within("the yaw (degrees)", self.yaw or 0.0, -360.0, 360.0)
        _within("frames in each file", self.frames, 2, 100000)
        _within("the seed", self.seed, 0, 2**63)


def changed(settings: SimulationSettings, values: Mapping[str, object]) -> SimulationSettings:
    """The settings with some changed, by their dotted names; each room's all at once."""
    own: dict[str, Any] = {}
    rooms: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        room, _, key = name.rpartition(".")
        (rooms.setdefault(room, {}) if room else own)[key] = value
    for room, changes in rooms.items():
        own[room] = replace(getattr(settings, room), **changes)
    return replace(settings, **own)
