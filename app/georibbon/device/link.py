"""The link to a ribbon: a thread that opens the port, reads it, and begins again when it must."""

import math
import threading
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Self

from georibbon.device import ports
from georibbon.device.handshake import Arrival, Handshake, LinkTiming, Wire
from georibbon.device.health import Counts, Health
from georibbon.device.identity import MOST_RATE, Identity, OtherRibbonError, check_same
from georibbon.device.intake import Intake, message_of
from georibbon.device.packets import IDENTITY, MESSAGE
from georibbon.device.ports import BAUDRATE, Finder, ListPorts, OpenPort, Port
from georibbon.device.ring import Outlets, Ring, Tap
from georibbon.device.telling import Change, Event, LinkState, Listeners
from georibbon.errors import DeviceError
from georibbon.ribbon import Ribbon
from georibbon.session.words import told

__all__ = ["Change", "Event", "Health", "Link", "LinkState", "LinkTiming"]

CAPACITY = 6_000  # frames in the ring: a minute at 100 frames/s
_STOPPED = "the link was stopped"
_MOST_BAUDRATE = 50_000_000


class Link:
    """Frames from a ribbon at the end of a cable, for as long as one asks for them.

    url: a serial port's name, or socket://host:port.  rate: frames per second to
    ask for; the ribbon's own without it.  ribbon_id, ribbon: who is expected, by
    its name, or with its sensors; without them the first that answers is, from
    then on.  capacity: frames that `ring` holds.

    One thread of its own reads and writes the port.  It begins with `start` and
    tries for ever, also after the cable was pulled, until `stop`; where a fault of
    the program ends it, the ring and the taps get no more and the taps are closed.
    Callbacks are called in that thread, one at a time: they should return at once.
    Only the last, that the link was stopped, is told in the thread that calls
    `stop`; where the link's thread has not ended by then (it hangs in the port's
    driver or in a callback), it may be in another callback at that time.

    Raises DeviceError for a url or a rate that means nothing.
    """

    def __init__(
        self,
        url: str,
        *,
        rate: float | None = None,
        ribbon_id: str | None = None,
        ribbon: Ribbon | None = None,
        baudrate: int = BAUDRATE,
        capacity: int = CAPACITY,
        timing: LinkTiming | None = None,
        open_port: OpenPort = ports.open_port,
        list_ports: ListPorts = ports.list_ports,
    ) -> None:
        ports.check_url(url)
        _check_numbers(rate, baudrate)
        self.url = url
        self._rate = rate
        self._expected: Ribbon | str | None = ribbon if ribbon is not None else ribbon_id
        self._baudrate = baudrate
        self._timing = timing or LinkTiming()
        self._open_port = open_port
        self._finder = Finder(url, list_ports)
        self._listeners = Listeners()
        self._counts = Counts()
        self._outlets = Outlets(capacity)
        self._intake: Intake | None = None
        self._changed = threading.Condition()
        self._state, self._reason = LinkState.DISCONNECTED, "the link is not started"
        self._failure: str | None = None
        self._connected = False
        self._answers = 0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"link {url}", daemon=True)

    # What anyone may ask, from any thread.

    @property
    def ring(self) -> Ring:
        """The last frames, for displays."""
        return self._outlets.ring

    @property
    def identity(self) -> Identity | None:
        """Who the ribbon is; None before it has answered for the first time."""
        intake = self._intake
        return None if intake is None else intake.identity

    @property
    def state(self) -> LinkState:
        """How it stands with the ribbon."""
        return self._state

    def health(self) -> Health:
        """The figures of this moment."""
        with self._changed:
            state, reason = self._state, self._reason
        return self._counts.health(state, reason)

    def on_change(self, callback: Callable[[Change], None]) -> None:
        """Call back for every change of the state, with its reason."""
        self._listeners.changes.append(callback)

    def on_event(self, callback: Callable[[Event], None]) -> None:
        """Call back for the ribbon's messages and for what else a person should know."""
        self._listeners.events.append(callback)

    def recorder(self) -> Tap:
        """A tap that gets every frame from now on and drops none; close it when done."""
        return self._outlets.tap()

    def wait_for_identity(self, timeout: float) -> Identity:
        """Who the ribbon is, as soon as it has answered.

        Raises DeviceError with the reason when a try has failed (the port cannot
        be opened, nothing answers, what comes is no packet, another ribbon than
        expected), or after `timeout` seconds; the link goes on trying.
        """
        with self._changed:
            self._changed.wait_for(
                lambda: self._connected or self._failure or self._stopping.is_set(), timeout
            )
            if self._connected and self._intake is not None:
                return self._intake.identity
            reason = self._failure or self._reason
        name = told(self.url)
        raise DeviceError(reason if name in reason else f"{name}: {reason}")

    # Start and stop.

    def start(self) -> Self:
        """Begin, once; gives the link itself."""
        self._thread.start()
        return self

    def stop(self) -> None:
        """End for good, within 200 ms.

        A thread that hangs in the port's driver is left alone; it closes the port
        and ends as soon as the driver returns.
        """
        self._stopping.set()
        with self._changed:
            self._changed.notify_all()
        thread = self._thread
        if thread.is_alive() and thread is not threading.current_thread():
            thread.join(self._timing.stop)
        self._mark(LinkState.DISCONNECTED, _STOPPED, last=True)
        self._outlets.close()

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    # The link's thread.

    def _run(self) -> None:
        try:
            wait = self._timing.retry_first
            while not self._stopping.is_set():
                if self._attempt():
                    wait = self._timing.retry_first
                self._stopping.wait(wait)
                wait = min(2.0 * wait, self._timing.retry_last)
        except Exception:
            self._fail("a fault of the program ended the link; please report it")
            self._outlets.close()
            raise

    def _attempt(self) -> bool:
        """One try: open, ask, read until the port goes; whether the ribbon answered."""
        before = self._answers
        if self._failure is None:
            self._mark(LinkState.OPENING, f"opening {told(self.url)}")
        try:
            name, port = self._open()
            try:
                self._converse(name, Wire(port, self._counts))
            finally:
                port.close()
                if self._answers == before:
                    self._finder.silent()
        except OtherRibbonError as error:
            if str(error) != self._failure:
                self._listeners.happened("refused", str(error))
            self._fail(str(error))
        except (DeviceError, OSError) as error:
            self._fail(str(error))
        return self._answers != before

    def _open(self) -> tuple[str, Port]:
        """The first port that opens among the names the device may have, and that name."""
        *others, last = self._finder.names()
        for name in others:
            try:
                return name, self._open_port(name, self._baudrate)
            except (DeviceError, OSError):
                continue
        return last, self._open_port(last, self._baudrate)

    def _converse(self, name: str, wire: Wire) -> None:
        """Ask who is there, and read what it sends until told to stop."""
        if self._stopping.is_set():
            return
        wire.drop()
        handshake = Handshake(wire, self._timing, self._stopping)
        identity = self._ask(handshake)
        if identity is None:
            return
        self._finder.opened(name)
        intake = self._answered(identity)
        wire.trusted = True
        self._take_held(intake, handshake.held)
        intake.accept(identity)
        self._stream(intake, wire)

    def _ask(self, handshake: Handshake) -> Identity | None:
        """Who answers, checked, at the rate asked for; None where told to stop."""
        identity = handshake.identify("stop")
        if identity is None:
            return None
        check_same(identity.ribbon, self._expected)
        if self._rate is None or _same_rate(identity, self._rate):
            return identity
        changed = handshake.identify(f"rate {self._rate:g}")
        if changed is None:
            return None
        check_same(changed.ribbon, identity.ribbon)
        if not _same_rate(changed, self._rate):
            nearest = f"{self._rate:g} frames/s were asked for; the ribbon sends "
            self._listeners.happened("rate", f"{nearest}{changed.ribbon.rate:g}")
        return changed

    def _answered(self, identity: Identity) -> Intake:
        """The ribbon that was waited for is there; who takes in what it sends."""
        self._answers += 1
        intake = self._intake
        if intake is None:
            intake = Intake(identity, self._outlets, self._counts, self._listeners)
        else:
            intake.reconnected(identity)
            self._counts.reconnects += 1
        self._intake = intake
        self._expected = identity.ribbon
        with self._changed:
            self._connected, self._failure = True, None
        ribbon = f"{told(identity.ribbon.id)} (firmware {identity.firmware})"
        self._mark(LinkState.OPENING, f"the ribbon {ribbon} answers")
        return intake

    def _take_held(self, intake: Intake, held: Sequence[Arrival]) -> None:
        """What came with the identity.

        What came before the first identity of all belongs to nobody, words to the
        person aside; over a reconnect all of it is the ribbon's.
        """
        begin = 0
        if self._answers == 1:
            kinds = [arrival.packet.type for arrival in held]
            begin = kinds.index(IDENTITY) if IDENTITY in kinds else len(held)
        for arrival in held[:begin]:
            if arrival.packet.type == MESSAGE:
                self._listeners.happened("message", message_of(arrival.packet.payload))
        intake.take(held[begin:])

    def _stream(self, intake: Intake, wire: Wire) -> None:
        """Read until told to stop; ask again whenever frames stay away."""
        wire.send("start")
        heard, last = wire.bytes, time.monotonic()
        asked = last
        while not self._stopping.is_set():
            frames = intake.take(wire.read())
            moment = time.monotonic()
            if frames:
                heard, last, asked = wire.bytes, moment, moment
                if self._state != LinkState.STREAMING:
                    self._mark(LinkState.STREAMING, "frames come")
            elif moment - asked > self._patience():
                asked = moment
                came = "bytes come, but no frames" if wire.bytes > heard else "nothing comes"
                self._stalled(f"no frame for {moment - last:.1f} s: {came}; asking again")
                wire.send("identify", "start")
        wire.send("stop")

    def _patience(self) -> float:
        """Seconds without a frame until frames stay away; a slow ribbon has three frames' time."""
        identity = self.identity
        return max(self._timing.stall, 3.0 / identity.ribbon.rate if identity else 0.0)

    def _stalled(self, reason: str) -> None:
        """Tell it, once."""
        if self._state != LinkState.STALLED:
            self._counts.stalls += 1
            self._mark(LinkState.STALLED, reason)

    def _fail(self, reason: str) -> None:
        """The try has come to nothing, or the port is gone."""
        with self._changed:
            self._connected, self._failure = False, reason
        self._mark(LinkState.DISCONNECTED, reason)

    def _mark(self, state: LinkState, reason: str, last: bool = False) -> None:
        """Change the state, and tell it, unless nothing changed or the link was stopped."""
        with self._changed:
            same = (state, reason) == (self._state, self._reason)
            if same or (self._stopping.is_set() and not last):
                return
            self._state, self._reason = state, reason
            self._changed.notify_all()
        self._listeners.changed(state, reason)


def _same_rate(identity: Identity, rate: float) -> bool:
    return math.isclose(identity.ribbon.rate, rate, rel_tol=1e-6)


def _check_numbers(rate: float | None, baudrate: int) -> None:
    if rate is not None and not 0.0 < rate <= MOST_RATE:
        raise DeviceError(
            f"a rate of {told(rate)} frames per second; more than 0, at most {MOST_RATE:g}, is "
            "expected"
        )
    if not 0 < baudrate <= _MOST_BAUDRATE:
        raise DeviceError(f"a baud rate of {told(baudrate)}; such as {BAUDRATE} is expected")
