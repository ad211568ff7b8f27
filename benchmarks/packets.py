"""The packet reader under random and mutated streams of bytes.

Streams of about 1 kB, a quarter of them noise, the others whole packets to which
one to three things were done: bits flipped, bytes replaced, inserted, deleted,
cut off, repeated, swapped.  A whole packet follows each.  Asked: no exception,
every packet that stands whole between two zeros delivered, in its order, and
nothing that was not sent.

The last cannot be had for nothing: a checksum of 16 bits lets one in 65536 heavily
damaged packets through.  The figure is held against that, not against zero.

    .venv/bin/python benchmarks/packets.py [--streams N] [--seed N]
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

from support.parallel import in_parallel
from support.tables import met, publish, table

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "device"))

from streams import mutate, pool, seeded, stream, undamaged  # (the tests' own)

from georibbon.device.packets import FRAME, Packet, PacketReader

CHUNK = 5_000
SIZE = 1024
NOISE = 0.25
CHANCE = 1 / 65536


def measure(seed: int) -> Counter[str]:
    """Read a chunk of streams, and count what was seen."""
    rng, known = seeded(seed), pool()
    sent = set(known.values())
    wires = list(known)
    lengths = {len(packet.payload) for packet in sent if packet.type == FRAME}
    seen: Counter[str] = Counter()
    for _ in range(CHUNK):
        noise = rng.random() < NOISE
        data = rng.randbytes(SIZE) if noise else mutate(rng, stream(rng, known, SIZE))
        data += b"\0" + wires[int(rng.random() * len(wires))] + b"\0"
        reader = PacketReader()
        middle = int(rng.random() * len(data))
        try:
            found = reader.feed(data[:middle]) + reader.feed(data[middle:])
        except Exception:  # whatever it is, it is what this counts
            seen["exceptions"] += 1
            continue
        seen["noise" if noise else "mutated"] += 1
        seen["damaged"] += reader.damaged
        seen["delivered"] += len(found)
        count(seen, found, undamaged(data, known), sent, lengths)
    return seen


def count(
    seen: Counter[str],
    found: list[Packet],
    whole: list[Packet],
    sent: set[Packet],
    lengths: set[int],
) -> None:
    """Hold what was delivered against what stands whole in the stream."""
    seen["whole"] += len(whole)
    if found == whole:
        return
    place = 0
    for packet in found:
        if place < len(whole) and packet == whole[place]:
            place += 1
        elif packet not in sent:
            seen["strangers"] += 1
            seen["frames"] += packet.type == FRAME and len(packet.payload) in lengths
    seen["missing"] += len(whole) - place


def rows(seen: Counter[str], streams: int, seconds: float) -> list[list[str]]:
    """The figures, with what was asked and the verdict."""
    expected = seen["damaged"] * CHANCE
    most = expected + 4 * expected**0.5 + 1
    read = f"{streams:,} ({seen['noise']:,} noise, {seen['mutated']:,} mutated)"
    return [
        ["streams of 1 kB", f"{streams:,}", read, met(seen["noise"] + seen["mutated"] == streams)],
        ["exceptions", "0", f"{seen['exceptions']}", met(not seen["exceptions"])],
        [
            "packets that stand whole, not delivered",
            "0",
            f"{seen['missing']} of {seen['whole']:,}",
            met(not seen["missing"]),
        ],
        [
            "damaged packets that passed the checksum",
            f"by chance at most {expected:.0f} ± {2 * expected**0.5:.0f}",
            f"{seen['strangers']} of {seen['damaged']:,}",
            met(seen["strangers"] <= most),
        ],
        [
            "of these, frames of a length that is sent",
            "fewer",
            f"{seen['frames']}",
            met(seen["frames"] <= most),
        ],
        ["seconds", "", f"{seconds:.0f}", ""],
    ]


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--streams", type=int, default=1_000_000, help="in all, about")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    chunks = max(round(asked.streams / CHUNK), 1)
    begin = time.monotonic()
    each = in_parallel(measure, range(asked.seed * 1_000_000, asked.seed * 1_000_000 + chunks))
    seconds = time.monotonic() - begin
    seen = sum(each, Counter[str]())
    header = ("figure", "asked", "measured", "verdict")
    publish("packets", ["# Packets", table(header, rows(seen, chunks * CHUNK, seconds))])


if __name__ == "__main__":
    main()
