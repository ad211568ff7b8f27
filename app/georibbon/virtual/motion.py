"""How hands move the ribbon: from one place of rest to the next, never quite steadily.

A move follows the course of least jerk (Flash and Hogan 1985, "The coordination
of arm movements"): 10 u^3 - 15 u^4 + 6 u^5.  The whole turns rigidly, each
sensor bends from its old frame into its new one, and over both lies the hands'
sway: slow swings and a tremor of 6 to 10 Hz, which dies away on arrival.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.rotations import about_y, about_z, exp, log

SECONDS = (1.0, 2.0)
"""How long a move takes, from and to."""
SETTLING = 0.5
"""Seconds from arriving to lying still."""
RISING = 0.3
"""Seconds in which the sway sets in."""
SLOW, FAST = 4, 3
SWING, TREMOR, LEAN = 4.0, 0.5, 2.0
"""Degrees about each axis: of the slow swings, of the tremor, of the swings' change along it."""
SAG = 35.0
"""Degrees by which the ends of a lifted ribbon slope."""


@dataclass(frozen=True, eq=False)
class Sway:
    """A hand's unsteadiness: a sum of sines, a little different along the ribbon.

    frequency: (k,) Hz; phase, size: (k, 3) radians.  lean: (k, 3) radians by
    which the size grows from the middle to the end.
    """

    frequency: FloatArray
    phase: FloatArray
    size: FloatArray
    lean: FloatArray

    def vectors(self, times: FloatArray, along: FloatArray) -> FloatArray:
        """(m, n, 3) rotation vectors at times (m,), seconds, of places along (n,), -1 to 1."""
        angle = 2 * np.pi * times[:, None, None] * self.frequency[:, None] + self.phase
        size = self.size + along[:, None, None] * self.lean
        return np.asarray(np.einsum("mka,nka->mna", np.sin(angle), size))


STEADY = Sway(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))


def draw_sway(rng: np.random.Generator) -> Sway:
    """A hand's unsteadiness, drawn."""
    frequency = np.concatenate([rng.uniform(0.4, 1.2, SLOW), rng.uniform(6.0, 10.0, FAST)])
    degrees = np.concatenate([np.full(SLOW, SWING / SLOW**0.5), np.full(FAST, TREMOR / FAST**0.5)])
    lean = np.concatenate([np.full(SLOW, LEAN / SLOW**0.5), np.zeros(FAST)])
    shape = (SLOW + FAST, 3)
    size, tilt = rng.standard_normal(shape), rng.standard_normal(shape)
    return Sway(
        frequency,
        rng.uniform(0.0, 2 * np.pi, shape),
        np.radians(degrees[:, None] * size),
        np.radians(lean[:, None] * tilt),
    )


@dataclass(frozen=True, eq=False)
class Motion:
    """A move from one place of rest to another, or up into swaying hands.

    begin, target: (n, 3, 3) the sensors' frames, ribbon to world.  start:
    seconds.  seconds: how long it takes; 0: the ribbon is there at once and
    still.  lifted: it does not come to rest.  swaying: the share of the sway
    that is there from the start, where hands that moved go on to the next place.
    """

    begin: FloatArray
    target: FloatArray
    start: float
    seconds: float = 0.0
    sway: Sway = STEADY
    lifted: bool = False
    swaying: float = 0.0

    @property
    def still_from(self) -> float:
        """The moment from which on the ribbon lies still; inf: it never does."""
        if self.lifted:
            return inf
        return self.start + (self.seconds + SETTLING if self.seconds > 0 else 0.0)

    @cached_property
    def _turn(self) -> tuple[FloatArray, FloatArray]:
        """Rotation vectors: of the whole (3,), in the world; of each sensor (n, 3), in its own."""
        middle = len(self.begin) // 2
        bulk = self.target[middle] @ self.begin[middle].T
        return log(bulk), log(np.swapaxes(bulk @ self.begin, 1, 2) @ self.target)

    def frames(self, times: FloatArray) -> FloatArray:
        """(m, n, 3, 3) the sensors' frames at times (m,)."""
        along = np.linspace(-1.0, 1.0, len(self.begin))
        sway = self.share(times)[:, None, None] * self.sway.vectors(times, along)
        return np.asarray(exp(sway) @ self.course(times))

    def course(self, times: FloatArray) -> FloatArray:
        """(m, n, 3, 3) the sensors' frames at times (m,) in hands that do not sway."""
        past = np.maximum(times - self.start, 0.0)
        u = least_jerk(past / self.seconds) if self.seconds > 0 else np.ones(len(times))
        bulk, bend = self._turn
        turned = exp(u[:, None] * bulk)[:, None] @ self.begin
        return np.asarray(turned @ exp(u[:, None, None] * bend))

    def share(self, times: FloatArray) -> FloatArray:
        """(m,) how much of the sway is there at times (m,), 0 to 1."""
        past = np.maximum(times - self.start, 0.0)
        calm = 1.0 if self.lifted else 1.0 - least_jerk((past - self.seconds) / SETTLING)
        return np.asarray((self.swaying + (1.0 - self.swaying) * least_jerk(past / RISING)) * calm)


def least_jerk(u: FloatArray) -> FloatArray:
    """10 u^3 - 15 u^4 + 6 u^5 of u cut to 0 to 1."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 + u * (-15.0 + 6.0 * u)))


def hanging(positions: FloatArray, length: float, heading: float) -> FloatArray:
    """(n, 3, 3) the frames of a ribbon that hangs between two hands, in an arc.

    positions: (n,) metres along it; heading: radians.
    """
    slope = np.radians(SAG) * (1.0 - 2.0 * positions / length)
    return np.asarray(about_z(heading) @ about_y(slope))
