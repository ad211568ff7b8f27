"""What a virtual ribbon is made with."""

from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Literal

from georibbon.errors import SettingsError
from georibbon.session.words import told
from georibbon.simulation import SimulationSettings

Unit = Literal["mm", "m"]
UNITS: dict[Unit, float] = {"mm": 0.001, "m": 1.0}
"""Metres in the unit of a mesh file, which names none itself."""


@dataclass(frozen=True)
class MeshSettings:
    """A mesh file in place of a reference surface; unit: of its coordinates."""

    path: Path
    unit: Unit = "mm"

    def __post_init__(self) -> None:
        """Refuse an unknown unit, with a `SettingsError`."""
        if self.unit not in UNITS:
            raise SettingsError(f"the unit is {told(self.unit)}; give {' or '.join(UNITS)}")


def check_number(what: str, value: float, least: float, most: float) -> float:
    """The value; `SettingsError` where it is not from `least` to `most`."""
    if not (isfinite(value) and least <= value <= most):
        raise SettingsError(f"{what} is {value:g}; give a value from {least:g} to {most:g}")
    return value


@dataclass(frozen=True)
class VirtualSettings:
    """A virtual ribbon, where it is laid and what its cable does.

    simulation: surface, ribbon, poses, passes, survey, faults and seed, as
    `simulate` takes them; its `frames` means nothing here.  mesh: in place of
    the surface.  firmware: what it says.  hold: seconds that `poses` and `play`
    hold each place, still.  pace: how many times as long as an ordinary hand
    a move takes; 0: it is there at once.  drop, damage: shares of the frames'
    packets that are lost or damaged on the wire; noise: how many times as
    large as the sensors' own.  power_up, first_sequence: where the clock
    (microseconds) and the sequence numbers begin.  play: the whole session is
    played as soon as a host starts the frames.
    """

    simulation: SimulationSettings = field(default_factory=SimulationSettings)
    mesh: MeshSettings | None = None
    firmware: str = "1.0.0"
    hold: float = 3.0
    pace: float = 1.0
    drop: float = 0.0
    damage: float = 0.0
    noise: float = 1.0
    power_up: int = 0
    first_sequence: int = 0
    play: bool = False

    def __post_init__(self) -> None:
        """Refuse values that mean nothing, with a `SettingsError`."""
        check_number("hold (s)", self.hold, 0.1, 3600.0)
        check_number("pace", self.pace, 0.0, 100.0)
        check_number("the share of dropped packets", self.drop, 0.0, 1.0)
        check_number("the share of damaged packets", self.damage, 0.0, 1.0)
        check_number("the factor of the noise", self.noise, 0.0, 1000.0)
        check_number("the clock at power-up (µs)", self.power_up, 0, 2**32 - 1)
        check_number("the first sequence number", self.first_sequence, 0, 65535)
        if not self.firmware or not self.firmware.isprintable() or len(self.firmware) > 60:
            raise SettingsError(
                f"the firmware is {told(self.firmware)}; give at most 60 printable signs"
            )
