"""The ribbon's side of the protocol: commands in, packets out, on the ribbon's own clock."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import floor, inf, isfinite

import numpy as np

from georibbon.device.frames import pack_frame
from georibbon.device.identity import Identity, write_identity
from georibbon.device.packets import DONE, FRAME, IDENTITY, MESSAGE, SEQUENCES, Packet, encode
from georibbon.session.words import told
from georibbon.virtual.body import Body
from georibbon.virtual.faults import Cable

RATES = (10.0, 20.0, 25.0, 50.0, 100.0, 200.0, 400.0)
"""Frames a second that every virtual ribbon has."""
LONGEST_LINE = 80
"""Bytes of a command; what is longer is refused."""
MOST_HELD = 4096
"""Bytes that the ribbon takes in while it is stalled."""
MOST_WAITING = 16384
"""Bytes that wait for a slow host; a frame that finds so many is dropped."""
RESERVED = 8192
"""Bytes that may wait beyond them, of answers and messages."""
LONGEST_GAP = 1.0
"""Seconds of frames made up for after the ribbon could not run; earlier ones are dropped."""


@dataclass(frozen=True)
class Sent:
    """What the ribbon has sent, and what it has not.

    packets: sequence numbers used, of any type.  frames: those of frames.
    dropped: packets lost on the cable; overrun: dropped because the host does
    not read; cut: that waited when the cable was pulled or the host left;
    damaged: that came as something else; garbled: sent at a wrong rate.  A
    host that has read everything has packets - dropped - overrun - cut -
    damaged - garbled, and of the first to the last of these all gaps are told by
    the sequence numbers.
    """

    packets: int = 0
    frames: int = 0
    dropped: int = 0
    overrun: int = 0
    cut: int = 0
    damaged: int = 0
    garbled: int = 0

    @property
    def whole(self) -> int:
        """Packets that went out undamaged."""
        lost = self.dropped + self.overrun + self.cut + self.damaged + self.garbled
        return self.packets - lost


class LineReader:
    """Cuts what a host sends into command lines; None for one that is no command.

    Lines end with a line feed, a carriage return before it is left out; empty
    ones are passed over.
    """

    def __init__(self) -> None:
        self._rest = b""
        self._skipping = False

    def feed(self, data: bytes) -> list[str | None]:
        """The lines that these bytes complete."""
        *ended, rest = (self._rest + data).split(b"\n")
        lines: list[str | None] = []
        for one in ended:
            line = one.strip(b"\r\0")
            if self._skipping or len(line) > LONGEST_LINE:
                lines.append(None)
            elif line:
                lines.append(line.decode() if line.isascii() else None)
            self._skipping = False
        self._skipping = self._skipping or len(rest) > LONGEST_LINE
        self._rest = b"" if self._skipping else rest
        return lines


class Wire:
    """The ribbon as its host sees it.

    All moments are the ribbon's own seconds since it came up.  `waiting` holds
    the packets that have not gone out yet.
    """

    def __init__(
        self,
        body: Body,
        cable: Cable,
        identity: Identity,
        power_up: int,
        first_sequence: int,
        started: Callable[[], None],
    ) -> None:
        """Silent until a command comes; `started` is called whenever frames begin."""
        self.cable = cable
        self.identity = identity
        self.streaming = False
        self.stalled_until = -inf
        self.sent = Sent()
        self.waiting: deque[bytes] = deque()
        self._body, self._started = body, started
        self._power_up, self._sequence = power_up, first_sequence
        self._reader = LineReader()
        self._held = b""
        self._begin, self._next, self._size = 0.0, 1, 0
        own = identity.ribbon.rate
        self._rates = np.array(sorted({*RATES, own}))
        write_identity(identity)  # refused now, not when a host asks

    @property
    def rate(self) -> float:
        """Frames a second."""
        return self.identity.ribbon.rate

    @property
    def due(self) -> float:
        """The moment of the next frame or the end of a stall; inf: nothing comes by itself."""
        if self.stalled_until > -inf:
            return self.stalled_until
        return self._moment(self._next) if self.streaming else inf

    def receive(self, data: bytes, now: float) -> None:
        """Take what the host sent."""
        if self.stalled_until > now:
            self._held = (self._held + data)[:MOST_HELD]
        elif self.cable.garbled:
            # Nothing is understood; its complaint is as little understood.
            self._say("unknown command")
        else:
            for line in self._reader.feed(data):
                self._obey(line, now)

    def make(self, now: float) -> None:
        """Make the frames that are due, up to and with `now`."""
        if self.stalled_until > now:
            return
        if self.stalled_until > -inf:
            self._wake(now)
        if not self.streaming:
            return
        last = floor((now - self._begin) * self.rate + 1e-6)
        first = max(self._next, last - floor(LONGEST_GAP * self.rate))
        self._pass_over(first - self._next)
        self._next = last + 1 if last >= self._next else self._next
        if first > last:
            return
        times = self._begin + np.arange(first, last + 1) / self.rate
        for moment, counts in zip(times, self._body.counts(times), strict=True):
            payload = pack_frame(self._power_up + round(1e6 * moment), counts)
            self._send(FRAME, payload)

    def message(self, text: str) -> None:
        """Tell the person something."""
        self._say(text)

    def stall(self, until: float) -> None:
        """Hang until that moment: nothing is made, no command taken, no number used."""
        self.stalled_until = until

    def hang_up(self) -> None:
        """The host is gone: no frames until the next `start`; what waits is lost."""
        self.streaming = False
        self.sent = replace(self.sent, cut=self.sent.cut + len(self.waiting))
        self.waiting.clear()
        self._size, self._held = 0, b""
        self._reader = LineReader()

    def take(self) -> bytes:
        """The next packet to go out whole, b"" where none waits."""
        if not self.waiting:
            return b""
        packet = self.waiting.popleft()
        self._size -= len(packet)
        return packet

    def cut(self) -> None:
        """A packet that was taken did not go out whole."""
        self.sent = replace(self.sent, cut=self.sent.cut + 1)

    def _moment(self, number: int) -> float:
        return self._begin + number / self.rate

    def _wake(self, now: float) -> None:
        """Go on after a stall: the frames due in it are none, then what was asked meanwhile."""
        ended, self.stalled_until = self.stalled_until, -inf
        self._next = max(self._next, floor((ended - self._begin) * self.rate) + 1)
        held, self._held = self._held, b""
        if held:
            self.receive(held, now)

    def _pass_over(self, frames: int) -> None:
        """Frames that could not be made in time: their numbers are used."""
        if frames > 0:
            self._sequence += frames
            sent = self.sent
            self.sent = replace(
                sent,
                packets=sent.packets + frames,
                frames=sent.frames + frames,
                overrun=sent.overrun + frames,
            )

    def _obey(self, line: str | None, now: float) -> None:
        words = [] if line is None else line.split()
        match words:
            case ["identify"]:
                self._send(IDENTITY, write_identity(self.identity))
            case ["start"]:
                self._done(line)
                if not self.streaming:
                    self.streaming, self._begin, self._next = True, now, 1
                    self._started()
            case ["stop"]:
                self.streaming = False
                self._done(line)
            case ["rate", value]:
                self._set_rate(line, value, now)
            case _:
                found = "no command line" if line is None else told(line)
                self._say(f"unknown command: {found}; I know identify, start, stop and rate HZ")

    def _done(self, line: str | None) -> None:
        self._send(DONE, (line or "").encode())

    def _set_rate(self, line: str | None, value: str, now: float) -> None:
        try:
            asked = float(value)
        except ValueError:
            asked = 0.0
        if not (isfinite(asked) and asked > 0):
            self._say(f"refused: {told(line)}; rate takes frames a second, such as rate 100")
            return
        nearest = float(self._rates[np.argmin(np.abs(self._rates - asked))])
        ribbon = replace(self.identity.ribbon, rate=nearest)
        self.identity = replace(self.identity, ribbon=ribbon)
        self._begin, self._next = now, 1
        self._done(line)

    def _say(self, text: str) -> None:
        self._send(MESSAGE, text.encode())

    def _send(self, kind: int, payload: bytes) -> None:
        """Number a packet and put it on the cable."""
        packet = encode(Packet(kind, self._sequence % SEQUENCES, payload))
        self._sequence += 1
        frame, cable, sent = kind == FRAME, self.cable, self.sent
        sent = replace(sent, packets=sent.packets + 1, frames=sent.frames + frame)
        # Both are drawn for every frame, so that one share does not change what the other hits.
        lost, harmed = (cable.loses(), cable.harms()) if frame else (False, False)
        if lost:
            sent, packet = replace(sent, dropped=sent.dropped + 1), b""
        elif self._size + len(packet) > (MOST_WAITING if frame else MOST_WAITING + RESERVED):
            sent, packet = replace(sent, overrun=sent.overrun + 1), b""
        elif cable.garbled:
            sent, packet = replace(sent, garbled=sent.garbled + 1), cable.noise(len(packet))
        elif harmed:
            sent, packet = replace(sent, damaged=sent.damaged + 1), cable.damaged(packet)
        self.sent = sent
        if packet:
            self.waiting.append(packet)
            self._size += len(packet)
