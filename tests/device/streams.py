"""Streams of packets, and what a bad line makes of them."""

import functools
import random

from georibbon.device.packets import FRAME, MESSAGE, Packet, encode


def seeded(seed):
    """Random numbers that are the same each time."""
    return random.Random(seed)  # noqa: S311 (a test's, no secret)


@functools.cache
def pool(seed=0, size=400):
    """Packets of many kinds, with their bytes on the wire (the ending zero left out)."""
    rng = seeded(seed)
    packets = {}
    for number in range(size):
        length = rng.choice((0, 1, 20, 40, 84, 132, 132, 132, 252, 253, 254, 300))
        kind = rng.choice((FRAME, FRAME, FRAME, MESSAGE, 0x77))
        payload = rng.randbytes(length)
        if rng.random() < 0.3:
            payload = payload.replace(b"\x10", b"\0").replace(b"\x20", b"\0")
        packet = Packet(kind, number, payload)
        packets[encode(packet)[:-1]] = packet
    return packets


def stream(rng, known, size=1024):
    """About `size` bytes of whole packets."""
    wires = list(known)
    out, length = [], 0
    while length < size:
        wire = wires[int(rng.random() * len(wires))]
        out.append(wire + b"\0")
        length += len(wire) + 1
    return b"".join(out)


def flip(rng, data):
    for _ in range(rng.randrange(1, 9)):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def replace(rng, data):
    start = rng.randrange(len(data))
    count = min(rng.randrange(1, 60), len(data) - start)
    data[start : start + count] = rng.randbytes(count)


def insert(rng, data):
    start = rng.randrange(len(data))
    data[start:start] = rng.randbytes(rng.randrange(1, 40))


def delete(rng, data):
    start = rng.randrange(len(data))
    del data[start : start + rng.randrange(1, 60)]


def cut(rng, data):
    del data[rng.randrange(len(data)) :]


def duplicate(rng, data):
    start = rng.randrange(len(data))
    part = data[start : start + rng.randrange(1, 300)]
    at = rng.randrange(len(data))
    data[at:at] = part


def swap(rng, data):
    size = rng.randrange(1, 80)
    a, b = rng.randrange(len(data)), rng.randrange(len(data))
    data[a : a + size], data[b : b + size] = data[b : b + size], data[a : a + size]


MUTATIONS = (flip, replace, insert, delete, cut, duplicate, swap)


def mutate(rng, data):
    """The bytes after one to three things that lines do to them."""
    data = bytearray(data)
    for _ in range(rng.randrange(1, 4)):
        if data:
            MUTATIONS[int(rng.random() * len(MUTATIONS))](rng, data)
    return bytes(data)


def undamaged(data, known):
    """The packets that lie whole between two zeros, in their order."""
    return [known[piece] for piece in data.split(b"\0")[:-1] if piece in known]


def in_pieces(rng, data):
    """The bytes in pieces as a port gives them."""
    at = 0
    while at < len(data):
        size = rng.choice((1, 2, 7, 64, 300, 4096))
        yield data[at : at + size]
        at += size
