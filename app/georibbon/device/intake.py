"""What undamaged packets bring: frames to those who take them, words to the person, counts."""

import time
from collections.abc import Sequence

from georibbon.device.frames import Frame, frame_bytes, unpack_frame
from georibbon.device.handshake import Arrival
from georibbon.device.health import Counts
from georibbon.device.identity import Identity, check_same, read_identity
from georibbon.device.packets import FRAME, IDENTITY, KNOWN, MESSAGE, Packet
from georibbon.device.ring import Outlets
from georibbon.device.telling import EventKind, Listeners
from georibbon.device.timeline import Timeline
from georibbon.errors import DeviceError

REPEATED = 10.0  # s for which a message that says the same again is only counted
MOST_MESSAGE = 300  # characters of a ribbon's message that are told
_RESTARTED = (
    "the ribbon has restarted: its clock or its packet numbers began anew; what was lost over "
    "that is not counted"
)


class Intake:
    """Takes packets in, from the first identity on; used by the link's thread alone."""

    def __init__(
        self, identity: Identity, outlets: Outlets, counts: Counts, listeners: Listeners
    ) -> None:
        self.identity = identity
        self._outlets = outlets
        self._counts = counts
        self._listeners = listeners
        self._timeline = Timeline(identity.ribbon.rate)
        self._news: list[tuple[EventKind, str]] = []
        self._refusal: DeviceError | None = None
        self._measured = False
        self._said = ""
        self._said_at = -REPEATED
        self._repeats = 0

    def reconnected(self, identity: Identity) -> None:
        """The same ribbon answers again after the port was opened again."""
        self._timeline.reconnected()
        self.accept(identity)

    def take(self, arrivals: Sequence[Arrival]) -> int:
        """Take packets in, in their order; how many frames were among them.

        Raises DeviceError for an identity that cannot be read, and OtherRibbonError
        for that of another ribbon, when all that came before has been delivered.
        """
        frames: list[Frame] = []
        with self._counts.lock:
            for arrival in arrivals:
                self._one(arrival, frames)
                if self._refusal:
                    break
            if frames:
                self._counts.delivered(len(frames), frames[-1].arrived)
            self._counts.lost = self._timeline.lost
            self._counts.restarts = self._timeline.restarts
        if frames:
            self._outlets.append(frames)
        self._tell()
        return len(frames)

    def _one(self, arrival: Arrival, frames: list[Frame]) -> None:
        """One packet: a frame is put to the others, all else to what is to be told."""
        packet = arrival.packet
        if packet.type == FRAME:
            frame = self._frame(packet, arrival.arrived)
            if frame is None:
                self._counts.damaged += 1
                return
            frames.append(frame)
        else:
            self._timeline.other(packet.sequence)
            self._other(packet)
        self._counts.packets += 1

    def _frame(self, packet: Packet, arrived: float) -> Frame | None:
        """The frame in a packet; None where its length is wrong or it came already."""
        found = unpack_frame(packet.payload, len(self.identity.ribbon.columns))
        if found is None:
            self._wrong_length(len(packet.payload))
            return None
        microseconds, counts = found
        step = self._timeline.frame(packet.sequence, microseconds, arrived)
        if step is None:
            return None
        if step.restarted:
            self._news.append(("restarted", _RESTARTED))
        return Frame(step.t, counts, arrived)

    def _wrong_length(self, found: int) -> None:
        """Tell once that frames are not as long as the identity has it: a fault of the firmware."""
        if not self._measured:
            self._measured = True
            expected = frame_bytes(len(self.identity.ribbon.columns))
            words = (
                f"a frame of {found} bytes came, {expected} are what the ribbon's identity says; "
                "such frames are dropped: see to its firmware"
            )
            self._news.append(("refused", words))

    def _message(self, text: str) -> None:
        """Tell a message of the ribbon's; what it says over and over only now and then."""
        now = time.monotonic()
        if text == self._said and now - self._said_at < REPEATED:
            self._repeats += 1
            return
        more = f" ({self._repeats + 1} times)" if text == self._said and self._repeats else ""
        self._said, self._said_at, self._repeats = text, now, 0
        self._news.append(("message", f"{text}{more}"))

    def _other(self, packet: Packet) -> None:
        if packet.type == MESSAGE:
            self._message(message_of(packet.payload))
        elif packet.type == IDENTITY:
            self._identity(packet.payload)
        elif packet.type not in KNOWN:
            self._counts.unknown += 1

    def _identity(self, payload: bytes) -> None:
        """An identity while frames flow: an answer to asking again, or a new rate."""
        try:
            identity = read_identity(payload)
            check_same(identity.ribbon, self.identity.ribbon)
        except DeviceError as error:
            self._refusal = error
        else:
            self.accept(identity)

    def accept(self, identity: Identity) -> None:
        """What the ribbon says of itself holds from here on, its rate too."""
        self.identity = identity
        self._timeline.rate = identity.ribbon.rate

    def _tell(self) -> None:
        """Tell what is new, with no lock held."""
        news, self._news = self._news, []
        for kind, message in news:
            self._listeners.happened(kind, message)
        refusal, self._refusal = self._refusal, None
        if refusal:
            raise refusal


def message_of(payload: bytes) -> str:
    """A ribbon's message as one short line that can be printed."""
    text = payload.decode("utf-8", "replace")[:MOST_MESSAGE]
    return "".join(c if c.isprintable() else " " for c in text).strip() or "(an empty message)"
