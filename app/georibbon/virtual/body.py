"""The virtual ribbon as a thing in the world: where its sensors are, and what they say."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.device.frames import LOST, Counts
from georibbon.simulation.capture import Bench, magnet_field, spoil
from georibbon.simulation.forward import expected_counts, sample_counts
from georibbon.simulation.virtual import noise_counts
from georibbon.virtual.motion import SECONDS, STEADY, Motion, draw_sway, hanging


@dataclass(frozen=True)
class Magnet:
    """A magnet beside the ribbon, or passing along it.

    share: its greatest, of the field; place, reach: metres along the ribbon.
    speed: metres a second from `place` at the moment `start`; 0: it stays.
    until: the moment at which it has passed.
    """

    share: float
    place: float
    reach: float
    start: float = 0.0
    speed: float = 0.0
    until: float = inf

    def field(self, positions: FloatArray, times: FloatArray) -> FloatArray:
        """(m, n, 3) what it adds at positions (n,) and times (m,), in units of the field."""
        places = self.place + self.speed * (times - self.start)
        share = np.where(times < self.until, 1.0, 0.0)[:, None, None]
        return share * magnet_field(positions, self.share, places, self.reach)


class Body:
    """The ribbon's place, its motion, what disturbs it, and its counts at any moment.

    Moments never go back: what happened before the present motion is forgotten.
    """

    def __init__(self, bench: Bench, pace: float, seeds: Sequence[np.random.SeedSequence]) -> None:
        """Lifted, in the hands.  seeds: three."""
        self.bench = bench
        self.dead = set(bench.settings.faults.dead)
        self.noise = 1.0
        self._pace = pace
        self._hand, self._noise, self._loss = (np.random.default_rng(seed) for seed in seeds)
        self._spread = noise_counts(bench.ribbon, bench.settings.ribbon)
        self._magnet: Magnet | None = None
        self._beside: Magnet | None = None
        self._expected: FloatArray | None = None
        self._air = hanging(bench.positions, bench.ribbon.length, self._hand.uniform(-np.pi, np.pi))
        sway = draw_sway(self._hand)
        # Long in the air when its power comes up.
        self._motion = Motion(self._air, self._air, -10.0, sway=sway, lifted=True)

    @property
    def still_from(self) -> float:
        """The moment from which on it lies still; inf: in moving hands."""
        return self._motion.still_from

    def move(self, frames: FloatArray, now: float, beside: Magnet | None = None) -> None:
        """Take it to where its sensors have these frames (n, 3, 3), ribbon to world.

        beside: a magnet that is there.
        """
        self._begin(now, frames, lifted=False)
        self._beside = beside

    def lift(self, now: float) -> None:
        """Take it up into the hands."""
        self._begin(now, self._air, lifted=True)
        self._beside = None

    def hold(self, now: float) -> None:
        """Keep it still as it is."""
        here = self._motion.frames(np.array([now]))[0]
        self._motion = Motion(here, here, now)
        self._expected = None

    def put(self, magnet: Magnet | None) -> None:
        """Put a magnet beside it, or take it away."""
        self._magnet = magnet
        self._expected = None

    def _begin(self, now: float, target: FloatArray, lifted: bool) -> None:
        before, moment = self._motion, np.array([now])
        swaying = 0.0 if before.sway is STEADY else float(before.share(moment)[0])
        seconds = float(self._hand.uniform(*SECONDS)) * self._pace
        # Drawn always, so that what comes later does not depend on when this was.
        drawn = draw_sway(self._hand)
        sway = before.sway if swaying > 0 else drawn
        if seconds == 0 and not lifted:
            sway = STEADY
        here = before.course(moment)[0]
        self._motion = Motion(here, target, now, seconds, sway, lifted, swaying)
        self._expected = None

    def counts(self, times: FloatArray) -> Counts:
        """(m, c) what it says at times (m,), ascending; `LOST` for a lost value."""
        expected = self._expected_at(times)
        spread = self.noise * self._spread
        counts = sample_counts(expected, spread, len(times), self._noise)
        lost = self.bench.settings.faults.lost
        spoil(counts, self.bench.ribbon, self.dead, lost, self._loss)
        return np.where(np.isnan(counts), LOST, counts).astype(np.int16)

    def _expected_at(self, times: FloatArray) -> FloatArray:
        """(m, c), or (c,) where it is still and nothing passes."""
        passing = self._magnet is not None and times[0] < self._magnet.until < inf
        if times[0] < self.still_from or passing:
            # A move that ends among these moments goes on as rest: its frames are the target's.
            return self._seen(times)
        if self._expected is None:
            self._expected = self._seen(times[:1])[0]
        return self._expected

    def _seen(self, times: FloatArray) -> FloatArray:
        bench = self.bench
        magnets = [one for one in (self._magnet, self._beside) if one is not None]
        extra = np.sum([one.field(bench.positions, times) for one in magnets], axis=0)
        frames = self._motion.frames(times)
        disturbance = extra if magnets else None
        return expected_counts(bench.ribbon, bench.models, frames, bench.field, disturbance)
