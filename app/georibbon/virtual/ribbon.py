"""The virtual ribbon: a ribbon in the world, its cable, and the hands that move it."""

import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from georibbon.calibration.plans import AskedPose
from georibbon.device.frames import Frame
from georibbon.device.identity import Identity
from georibbon.errors import SettingsError
from georibbon.ribbon import Ribbon
from georibbon.session.outline import Survey
from georibbon.simulation.capture import error_streams, make_bench
from georibbon.simulation.truth import Truth
from georibbon.virtual.body import Body
from georibbon.virtual.commands import obey
from georibbon.virtual.faults import Cable
from georibbon.virtual.hands import Hands
from georibbon.virtual.places import Places
from georibbon.virtual.settings import VirtualSettings
from georibbon.virtual.wire import Sent, Wire

OWN_SEEDS = (6, 12)
"""Which of a seed's streams are the virtual ribbon's own; those before are the simulator's."""


class VirtualRibbon:
    """A virtual ribbon, used by a port (`serve_pty`, `serve_tcp`), by words and from Python.

    All moments are seconds since the ribbon came up, by `clock` and what
    `advance`, `frames` and `run` have added.  With a clock that stands still,
    the same words and calls give the same bytes.  Its methods may be called
    from any thread.
    """

    def __init__(
        self,
        settings: VirtualSettings | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """In the air, silent.  SettingsError, SurfaceError, DeviceError for what cannot be."""
        self.settings = settings = settings or VirtualSettings()
        simulation = settings.simulation
        if settings.mesh is not None:
            simulation = replace(simulation, surface=settings.mesh.path.name)
        streams = error_streams(simulation.seed)
        bench = make_bench(simulation, streams)
        self._places = Places(bench, streams, settings.mesh)
        seeds = np.random.SeedSequence(simulation.seed).spawn(OWN_SEEDS[1])[OWN_SEEDS[0] :]
        self._body = Body(bench, settings.pace, seeds[:3])
        self._body.noise = settings.noise
        self._wire = Wire(
            self._body,
            Cable(settings.drop, settings.damage, seeds[3:]),
            Identity(bench.ribbon, settings.firmware),
            settings.power_up,
            settings.first_sequence,
            self._begun,
        )
        self._hands = Hands(self._places, self._body, self._wire, settings.hold)
        self._clock, self._origin, self._ahead = clock, clock(), 0.0
        self._lock = threading.RLock()
        self._wake: Callable[[], None] = _nothing
        self._to_play = settings.play

    @property
    def ribbon(self) -> Ribbon:
        """The ribbon as it now says it is."""
        return self._wire.identity.ribbon

    @property
    def truth(self) -> Truth:
        """The true passes and sensor models, as `simulate` gives them."""
        return self._places.truth

    @property
    def passes(self) -> tuple[str, ...]:
        """The names of the passes and ties."""
        return self._places.names

    @property
    def poses(self) -> tuple[AskedPose, ...]:
        """The calibration poses: roll, heading, pitch in degrees, and whether on the table."""
        return self._places.poses

    @property
    def sent(self) -> Sent:
        """What has gone over the cable, and what has not."""
        with self._lock:
            return self._wire.sent

    @property
    def played(self) -> threading.Event:
        """Set when `poses` or `play` has come to its end."""
        return self._hands.played

    @property
    def ended(self) -> threading.Event:
        """Set by the word `quit`."""
        return self._hands.ended

    @property
    def plugged(self) -> bool:
        """Whether the cable is in."""
        return self._hands.plugged

    def survey(self) -> Survey:
        """The measured marks, distances and crossings, as `simulate` gives them."""
        return self._places.survey

    def plan_text(self) -> str:
        """A plan file (TOML) for a capture of all passes, ties and poses with the survey."""
        return self._places.plan_text()

    def do(self, text: str) -> str:
        """Carry out a command as on standard input; the answer, one line.

        Raises SettingsError for what is no command or cannot be done.
        """
        with self._lock:
            answer = obey(self._hands, text, self._catch_up())
            self._catch_up()
        self._wake()
        return answer

    # Time and frames without a port.

    def advance(self, seconds: float) -> None:
        """Let so much time go by at once."""
        with self._lock:
            self._ahead += seconds
        self._wake()

    def frames(self, count: int) -> list[Frame]:
        """The next frames at the ribbon's rate, as fast as can be; time goes on by as much.

        They do not go over the cable; `t` and `arrived` are the ribbon's seconds.
        """
        with self._lock:
            start = self._now()
            times = start + np.arange(1, count + 1) / self.ribbon.rate
            frames: list[Frame] = []
            while len(frames) < count:
                self._hands.run(times[len(frames)])
                batch = times[len(frames) :]
                batch = batch[batch < max(self._hands.due, batch[0] + 1e-9)][:MOST_AT_ONCE]
                counts = self._body.counts(batch)
                frames += [Frame(float(t), c, float(t)) for t, c in zip(batch, counts, strict=True)]
            self._ahead += count / self.ribbon.rate
            return frames

    def run(self, seconds: float) -> bytes:
        """Let time go by; what the ribbon puts on the wire in it, for a host that reads at once."""
        said = bytearray()
        with self._lock:
            end = self._now() + seconds
            while (left := end - self._now()) > 0:
                self._ahead += min(left, SLICE)
                self._catch_up()
                said += self.take_all()
        return bytes(said)

    # What a port uses.

    def attach(self, wake: Callable[[], None]) -> None:
        """Let `wake` be called, from any thread, whenever there may be something to send.

        Raises SettingsError where a port is attached already.
        """
        with self._lock:
            if self._wake is not _nothing:
                raise SettingsError("this virtual ribbon is served already; close that port first")
            self._wake = wake

    def detach(self) -> None:
        """No port any more: no host either."""
        with self._lock:
            self._wake = _nothing
            self.hang_up()

    def catch_up(self) -> float:
        """Do all that is due; the seconds until something is due again (inf: nothing)."""
        with self._lock:
            now = self._catch_up()
            return max(0.0, min(self._wire.due, self._hands.due) - now)

    def receive(self, data: bytes) -> None:
        """Take what a host sent."""
        with self._lock:
            self._wire.receive(data, self._catch_up())

    def take(self) -> bytes:
        """The next whole packet to send; b"" where there is none."""
        with self._lock:
            return self._wire.take()

    def take_all(self) -> bytes:
        """All packets that wait."""
        with self._lock:
            return b"".join(iter(self.take, b""))

    def cut(self) -> None:
        """A packet that was taken did not go out whole."""
        with self._lock:
            self._wire.cut()

    def hang_up(self) -> None:
        """The host is gone: the ribbon sends no frames until told to start again."""
        with self._lock:
            self._wire.hang_up()

    def _now(self) -> float:
        return self._clock() - self._origin + self._ahead

    def _catch_up(self) -> float:
        now = self._now()
        while self._hands.due <= now:
            moment = self._hands.due
            self._wire.make(moment)
            self._hands.run(moment)
        self._wire.make(now)
        return now

    def _begun(self) -> None:
        if self._to_play:
            self._to_play = False
            obey(self._hands, "play", self._now())


SLICE = 0.1
"""Seconds that `run` goes on at a time: less than what fills a host's buffer."""
MOST_AT_ONCE = 4096
"""Frames made at once, which bounds the memory."""


def _nothing() -> None:
    """Where no port is attached."""
