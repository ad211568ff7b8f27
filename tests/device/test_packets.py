"""Packets: whatever the line does, what is whole arrives and nothing else does."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from streams import in_pieces, mutate, pool, seeded, stream, undamaged

from georibbon.device.cobs import stuff
from georibbon.device.packets import (
    MOST_DECODED,
    MOST_PAYLOAD,
    MOST_STUFFED,
    Packet,
    PacketReader,
    checksum,
    encode,
)

PACKETS = st.builds(
    Packet, st.integers(0, 255), st.integers(0, 65535), st.binary(max_size=MOST_PAYLOAD)
)


@given(st.lists(PACKETS, max_size=8), st.randoms(use_true_random=False))
def test_packets_arrive_however_the_bytes_are_cut(packets, rng):
    data = b"".join(map(encode, packets))
    reader = PacketReader()
    assert [p for piece in in_pieces(rng, data) for p in reader.feed(piece)] == packets
    assert reader.damaged == 0


@given(PACKETS, st.data())
def test_one_wrong_bit_is_no_packet(packet, data):
    wire = bytearray(encode(packet))
    place = data.draw(st.integers(0, len(wire) - 2))
    wire[place] ^= 1 << data.draw(st.integers(0, 7))
    reader = PacketReader()
    # A new zero makes two pieces of it; a neighbour is not touched.
    assert reader.feed(bytes(wire) + encode(packet)) == [packet]
    assert reader.damaged >= 1


@given(st.lists(st.binary(max_size=300), max_size=20))
def test_any_bytes_are_taken_in(pieces):
    reader = PacketReader()
    found = [packet for piece in pieces for packet in reader.feed(piece)]
    whole = b"".join(pieces)
    assert len(found) + reader.damaged <= whole.count(0) + 1
    packet = Packet(2, 7, b"after")
    reader.feed(b"\0")
    assert reader.feed(encode(packet)) == [packet]


@pytest.mark.parametrize("seed", range(4))
def test_mutated_streams(seed):
    rng, known = seeded(seed), pool()
    sent = {(p.type, p.sequence, p.payload) for p in known.values()}
    for _ in range(1500):
        data = mutate(rng, stream(rng, known))
        reader = PacketReader()
        found = [p for piece in in_pieces(rng, data) for p in reader.feed(piece)]
        assert all((p.type, p.sequence, p.payload) in sent for p in found)
        assert found == undamaged(data, known)


@pytest.mark.parametrize("seed", range(4))
def test_random_streams(seed):
    rng = seeded(seed)
    packet = Packet(2, 7, b"after")
    for _ in range(1000):
        reader = PacketReader()
        # Sixteen bits of checksum let some noise through; with these seeds, none.
        assert reader.feed(rng.randbytes(1024) + b"\0") == []
        assert reader.feed(encode(packet)) == [packet]


def test_the_checksum_is_the_one_of_the_protocol():
    assert checksum(b"123456789") == 0x29B1
    crc = checksum(b"\2\1\x03\0").to_bytes(2, "little")
    assert encode(Packet(2, 0x0301, b"\0")) == stuff(b"\2\1\x03\0" + crc) + b"\0"


def test_the_longest_packet():
    packet = Packet(1, 2, b"x" * MOST_PAYLOAD)
    wire = encode(packet)
    assert len(wire) - 1 <= MOST_STUFFED
    assert PacketReader().feed(wire) == [packet]
    with pytest.raises(ValueError, match="at most 4096"):
        encode(Packet(1, 2, b"x" * (MOST_PAYLOAD + 1)))


def test_a_packet_too_long_is_counted_once_and_not_kept():
    reader = PacketReader()
    for _ in range(1000):
        assert reader.feed(b"y" * 1000) == []
    assert reader.damaged == 1
    assert len(reader._rest) <= MOST_STUFFED
    packet = Packet(2, 1, b"fine")
    assert reader.feed(b"\0" + encode(packet)) == [packet]
    assert reader.damaged == 1


def test_a_packet_too_long_in_one_piece():
    body = b"z" * (MOST_DECODED - 1)
    reader = PacketReader()
    longer = stuff(body + checksum(body).to_bytes(2, "little")) + b"\0"
    assert reader.feed(longer) == []
    assert reader.damaged == 1


def test_zeros_and_a_packet_too_short():
    reader = PacketReader()
    assert reader.feed(b"\0\0\0") == []
    assert reader.damaged == 0
    crc = checksum(b"ab").to_bytes(2, "little")
    assert reader.feed(stuff(b"ab" + crc) + b"\0") == []
    assert reader.damaged == 1


def test_what_the_line_held_is_forgotten():
    reader, packet = PacketReader(), Packet(3, 4, b"hello")
    wire = encode(packet)
    reader.feed(wire[:4])
    reader.drop()
    assert reader.feed(wire) == [packet]
    reader.feed(b"x" * 5000)
    reader.drop()
    assert reader.feed(wire) == [packet]
