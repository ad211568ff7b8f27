"""The ribbon: what sits where on it, and what it said."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray

SensorKind = Literal["accelerometer", "magnetometer"]
KINDS: tuple[SensorKind, ...] = ("accelerometer", "magnetometer")
AXIS_LETTERS = "xyz"


@dataclass(frozen=True)
class Sensor:
    """One sensor of a ribbon.

    axes: 3, or 2 for a magnetometer that measures along the ribbon (x) and
    across it (y) only.  position: metres from the ribbon's start.
    counts_per_unit: nominal counts for 1 g (accelerometer, specific force) or
    for the undisturbed local field (magnetometer).
    """

    name: str
    kind: SensorKind
    axes: int
    position: float
    counts_per_unit: float

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the sensor's columns, such as ("A01x", "A01y", "A01z")."""
        return tuple(self.name + letter for letter in AXIS_LETTERS[: self.axes])


@dataclass(frozen=True)
class Ribbon:
    """A ribbon's identity and its sensors, in the order of the columns.

    length: metres; rate: frames per second.
    """

    id: str
    length: float
    rate: float
    sensors: tuple[Sensor, ...]

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """The names of all axes, in the order in which every frame holds them."""
        return tuple(column for sensor in self.sensors for column in sensor.columns)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """For each sensor the slice of its axes among the columns."""
        ends = np.cumsum([sensor.axes for sensor in self.sensors])
        return tuple(
            slice(int(end) - sensor.axes, int(end))
            for sensor, end in zip(self.sensors, ends, strict=True)
        )

    def indices(self, kind: SensorKind) -> tuple[int, ...]:
        """The places, among the sensors, of those of one kind."""
        return tuple(i for i, sensor in enumerate(self.sensors) if sensor.kind == kind)


@dataclass(frozen=True, eq=False)
class Readings:
    """The frames of one recording file.

    t: (m,) float64, seconds from the file's start.
    counts: (m, c) float64, raw counts, one column an axis in the order of
    `Ribbon.columns`; NaN where a value was lost.
    """

    t: FloatArray
    counts: FloatArray
