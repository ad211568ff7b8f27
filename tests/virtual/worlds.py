"""Virtual ribbons for the tests, on a clock that stands still unless told."""

from dataclasses import replace

import numpy as np

from georibbon.device.frames import unpack_frame
from georibbon.device.packets import FRAME, Packet, PacketReader
from georibbon.simulation import LayoutSettings, RibbonSettings, SimulationSettings
from georibbon.virtual import VirtualRibbon, VirtualSettings

SMALL = SimulationSettings(
    "saddle",
    ribbon=RibbonSettings(sensors=16, length=0.48),
    layout=LayoutSettings(passes=3, ties=1),
    frames=400,
    seed=5,
)
QUIET = replace(SMALL, ribbon=replace(SMALL.ribbon, acceleration_noise=0.0, field_noise=0.0))


def world_of(simulation: SimulationSettings = SMALL, **settings: object) -> VirtualRibbon:
    """A virtual ribbon whose time goes on only by `advance`, `frames` and `run`."""
    return VirtualRibbon(VirtualSettings(simulation, **settings), clock=lambda: 0.0)


def counts_of(world: VirtualRibbon, frames: int) -> np.ndarray:
    """(frames, c) the counts of the next frames."""
    return np.array([frame.counts for frame in world.frames(frames)], dtype=np.float64)


def packets_in(data: bytes) -> list[Packet]:
    """All packets in undamaged bytes."""
    reader = PacketReader()
    packets = reader.feed(data)
    assert reader.damaged == 0
    return packets


def said(world: VirtualRibbon, data: bytes, seconds: float = 0.0) -> list[Packet]:
    """What the ribbon answers at once, and sends in the seconds after."""
    world.receive(data)
    return packets_in(world.take_all() + world.run(seconds))


def clocks_of(packets: list[Packet], world: VirtualRibbon) -> list[int]:
    """The microseconds of the frames among packets."""
    columns = len(world.ribbon.columns)
    return [unpack_frame(p.payload, columns)[0] for p in packets if p.type == FRAME]
