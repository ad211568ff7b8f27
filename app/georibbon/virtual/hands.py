"""The hands of the virtual capture: what moves the ribbon, pulls its cable, and in which order."""

import threading
from collections.abc import Sequence
from math import inf

from georibbon.arrays import FloatArray
from georibbon.calibration.plans import AskedPose
from georibbon.errors import SettingsError
from georibbon.virtual.body import Body, Magnet
from georibbon.virtual.places import Places
from georibbon.virtual.wire import Wire

Step = str | int
"""A pass by its name, or a pose by its number, from 1."""


class Hands:
    """What moves the ribbon and pulls its cable.  All moments are the ribbon's seconds."""

    def __init__(self, places: Places, body: Body, wire: Wire, hold: float) -> None:
        """The ribbon lifted, its cable in.  hold: seconds at each place of a script."""
        self.places, self.body, self.wire = places, body, wire
        self.place = "in the air"
        self.plugged = True
        self.played, self.ended = threading.Event(), threading.Event()
        self._hold = hold
        self._last_pass: str | None = None
        self._steps: list[Step] = []
        self._next_step = self._replug_at = inf

    @property
    def due(self) -> float:
        """The moment at which something happens by itself; inf: nothing will."""
        return min(self._next_step, self._replug_at)

    @property
    def steps_left(self) -> int:
        """Places that a script has yet to go to."""
        return len(self._steps)

    def run(self, now: float) -> None:
        """Do what is due at that moment."""
        if self._replug_at <= now:
            self.plug()
        if self._next_step <= now:
            self._step(now)

    def lay(self, name: str, now: float) -> None:
        """Lay it on a pass or tie; SettingsError where there is none."""
        self._take(self.places.laid(name), name, now, self.places.magnet(name))
        self._last_pass = name

    def lay_next(self, now: float) -> None:
        """Lay it on the pass or tie after the last one; SettingsError after all."""
        names = self.places.names
        at = 0 if self._last_pass is None else names.index(self._last_pass) + 1
        if at == len(names):
            raise SettingsError(f"{names[-1]} was the last; lay any again, such as lay {names[0]}")
        self.lay(names[at], now)

    def pose(self, number: int, now: float) -> None:
        """Put it into a pose of the plan, from 1; SettingsError where there is none."""
        self._take(self.places.posed(number), f"in pose {number}", now)

    def pose_as(self, asked: AskedPose, now: float) -> None:
        """Put it into any pose; SettingsError for one that cannot be."""
        roll, heading, pitch, table = asked
        where = f"at roll {roll:g}, heading {heading:g}, pitch {pitch:g}"
        frames = self.places.posed_as(asked)
        self._take(frames, where + (" on the table" if table else ""), now)

    def lift(self, now: float) -> None:
        """Take it up."""
        self._stop()
        self.body.lift(now)
        self.place = "in the air"

    def hold(self, now: float) -> None:
        """Keep it still as it is."""
        self._stop()
        self.body.hold(now)

    def play(self, steps: Sequence[Step], now: float) -> None:
        """Go from place to place, each held still for a while; SettingsError for no place."""
        if not steps:
            raise SettingsError("no pose is planned; give the ribbon a plan of poses")
        self.played.clear()
        self._steps = list(steps)
        self._step(now)

    def unplug(self, until: float) -> None:
        """Pull the cable, until that moment; the host is gone."""
        if not self.plugged:
            raise SettingsError("the cable is out; replug first")
        self.plugged, self._replug_at = False, until
        self.wire.hang_up()

    def plug(self) -> None:
        """Put the cable back."""
        self.plugged, self._replug_at = True, inf

    def _take(
        self, frames: FloatArray, place: str, now: float, beside: Magnet | None = None
    ) -> None:
        self._stop()
        self.body.move(frames, now, beside)
        self.place = place

    def _stop(self) -> None:
        """End a script: the hands do something else now."""
        self._steps, self._next_step = [], inf

    def _step(self, now: float) -> None:
        if not self._steps:
            self._next_step = inf
            self.played.set()
            return
        step, *rest = self._steps
        if isinstance(step, int):
            self.pose(step, now)
        else:
            self.lay(step, now)
        self._steps, self._next_step = rest, self.body.still_from + self._hold
