"""What goes wrong between the ribbon and its host."""

from collections.abc import Sequence

import numpy as np

from georibbon.device.packets import PacketReader


class Cable:
    """The wire: drops, damages or garbles packets, each a share drawn from a seed.

    drop, damage: shares of the frames' packets.  garbled: the host listens at
    another rate.
    """

    def __init__(self, drop: float, damage: float, seeds: Sequence[np.random.SeedSequence]) -> None:
        """With those shares.  seeds: three."""
        self.drop, self.damage, self.garbled = drop, damage, False
        self._dropping, self._damaging, self._noise = map(np.random.default_rng, seeds)

    def loses(self) -> bool:
        """Whether the next frame's packet is lost."""
        return bool(self._dropping.random() < self.drop)

    def harms(self) -> bool:
        """Whether the next frame's packet is damaged."""
        return bool(self._dropping.random() < self.damage)

    def damaged(self, packet: bytes) -> bytes:
        """A packet's bytes with some changed or its end cut off, so that it is one no more.

        The zero that ends it stays, and none comes in, so that no other packet
        is touched and a host counts one damaged packet.
        """
        while True:
            spoilt = self._spoilt(packet[:-1]) + b"\0"
            reader = PacketReader()
            if not reader.feed(spoilt) and reader.damaged == 1:
                return spoilt

    def _spoilt(self, body: bytes) -> bytes:
        rng = self._damaging
        if rng.random() < 0.2:
            return body[: int(rng.integers(1, len(body)))]
        changed = bytearray(body)
        for at in rng.integers(0, len(body), int(rng.integers(1, 5))):
            changed[at] = changed[at] % 255 + 1 if rng.random() < 0.5 else rng.integers(1, 256)
        return bytes(changed)

    def noise(self, length: int) -> bytes:
        """What a packet of so many bytes looks like at a wrong baud rate."""
        return self._noise.bytes(length)
