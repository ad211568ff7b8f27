"""A hundred times unplugged and plugged in again during a recording.

The virtual ribbon streams 100 frames a second over a pseudo-terminal into a
session file; its cable is pulled and put back, over and over.  Asked: the
recording goes on each time, what was lost is counted to the packet, what was not
is in the file, and neither a thread nor a descriptor is left over.
And a stop while the port's driver hangs, in each of its calls.

    .venv/bin/python benchmarks/unplug.py [--cycles N]
"""

import argparse
import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from support.tables import met, publish, table

from georibbon.capture.link_diary import LinkDiary
from georibbon.capture.recorder import Recorder
from georibbon.capture.session_log import SessionLog
from georibbon.device.health import Health
from georibbon.device.link import Link, LinkState, LinkTiming
from georibbon.session.session import Session
from georibbon.virtual import VirtualRibbon, serve_pty

PATIENCE = 10.0  # s until a cycle counts as one that did not go on
BETWEEN = (0.02, 0.2)  # s of frames between two cycles: pulled in the middle of anything
RANDOM = np.random.default_rng(1)
NOBODYS = 1  # packet before the first identity: the answer to the link's first "stop"


@dataclass(frozen=True)
class Found:
    """What a run of cycles gave; resumed: seconds until frames came again, of each cycle."""

    resumed: list[float]
    health: Health
    sent: int
    kept: int
    grown: tuple[int, int]
    left: tuple[int, int]


def threads_and_files() -> tuple[int, int]:
    """How many threads and open files this process has."""
    return threading.active_count(), len(list(Path("/proc/self/fd").iterdir()))


def less(one: tuple[int, int], other: tuple[int, int]) -> tuple[int, int]:
    """By how many threads and files the first is more."""
    return one[0] - other[0], one[1] - other[1]


def until(condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
    """Whether a condition comes true in time."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.002)
    return True


def cycle(world: VirtualRibbon, link: Link) -> float | None:
    """Pull the cable and put it back; seconds from then to the next frame, None for never."""
    world.do("unplug")
    if not until(lambda: link.state == LinkState.DISCONNECTED):
        return None
    frames = link.health().frames
    world.do("replug")
    begin = time.monotonic()
    if not until(lambda: link.health().frames > frames and link.state == LinkState.STREAMING):
        return None
    seconds = time.monotonic() - begin
    time.sleep(float(RANDOM.uniform(*BETWEEN)))
    return seconds


def record(path: Path, cycles: int) -> Found:
    """Record over so many cycles, and count."""
    world = VirtualRibbon()
    before = threads_and_files()
    with serve_pty(world) as port:
        link = Link(port.url)
        diary, tap = LinkDiary(link), link.recorder()
        link.start()
        log = SessionLog(path, link.wait_for_identity(PATIENCE), diary)
        recorder = Recorder(tap, log)
        recorder.start()
        until(lambda: link.health().frames > 0)
        running = threads_and_files()
        resumed = [seconds for _ in range(cycles) if (seconds := cycle(world, link)) is not None]
        grown = less(threads_and_files(), running)
        world.do("stall")
        until(lambda: accounted(link.health()) == world.sent.packets, 0.5)
        health, sent = link.health(), world.sent.packets
        link.stop()
        recorder.stop()
        log.close()
    return Found(resumed, health, sent, kept_in(path), grown, less(threads_and_files(), before))


class Hanging:
    """A port whose driver hangs in one of its calls until it is let go."""

    def __init__(self, where: str) -> None:
        self.hangs, self.let_go = threading.Event(), threading.Event()
        self._where = where

    def _call(self, name: str) -> None:
        if name == self._where:
            self.hangs.set()
            self.let_go.wait()

    def open(self, _url: str, _baudrate: int) -> "Hanging":
        """Open it."""
        self._call("open")
        return self

    def read(self) -> bytes:
        """Nothing comes."""
        self._call("read")
        return b""

    def write(self, _data: bytes) -> bool:
        """It takes all."""
        self._call("write")
        return True

    def drop(self) -> None:
        """There is nothing."""
        self._call("drop")

    def close(self) -> None:
        """Close it."""
        self._call("close")


def stop_seconds(where: str) -> float:
    """How long a stop takes while the port hangs in one call."""
    port = Hanging(where)
    quick = LinkTiming(answer=0.1, tries=1)  # so that "close" is reached soon
    link = Link("hanging", open_port=port.open, list_ports=list, timing=quick).start()
    port.hangs.wait(PATIENCE)
    begin = time.monotonic()
    link.stop()
    seconds = time.monotonic() - begin
    port.let_go.set()
    return seconds


def accounted(health: Health) -> int:
    """The packets that the link knows of."""
    return health.packets + health.lost + NOBODYS


def kept_in(path: Path) -> int:
    """How many frames a session file holds."""
    with Session.open(path, read_only=True) as session:
        return sum(len(session.readings(stream.part).t) for stream in session.state.streams)


def rows(found: Found, cycles: int) -> list[list[str]]:
    """The figures, with what was asked and the verdict."""
    health, again = found.health, len(found.resumed)
    known = f"{accounted(health):,}, {health.lost:,} of them lost"
    median = statistics.median(found.resumed) if found.resumed else float("nan")
    slowest = max(found.resumed, default=float("nan"))
    same = health.reconnects == cycles
    stop = max(stop_seconds(where) for where in ("open", "read", "write", "drop", "close"))
    return [
        ["cycles after which frames came again", f"{cycles}", f"{again}", met(again == cycles)],
        ["reconnects counted", f"{cycles}", f"{health.reconnects}", met(same)],
        [
            "packets delivered or counted as lost",
            f"{found.sent:,} sent",
            known,
            met(accounted(health) == found.sent),
        ],
        [
            "frames in the session file",
            f"{health.frames:,} delivered",
            f"{found.kept:,}",
            met(found.kept == health.frames),
        ],
        ["restarts of the ribbon believed", "0", f"{health.restarts}", met(not health.restarts)],
        ["threads, descriptors more than at the start", "0, 0", *verdict(found.grown)],
        ["threads, descriptors left at the end", "0, 0", *verdict(found.left)],
        ["seconds to the first frame, median, largest", "", f"{median:.2f}, {slowest:.2f}", ""],
        ["seconds to stop, port hanging in any call", "0.2", f"{stop:.3f}", met(stop <= 0.2)],
    ]


def verdict(more: tuple[int, int]) -> tuple[str, str]:
    """Threads and descriptors in words, and whether there are no more."""
    return f"{more[0]}, {more[1]}", met(max(more) <= 0)


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--cycles", type=int, default=100)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = record(Path(folder) / "unplugged.georibbon", asked.cycles)
    header = ("figure", "asked", "measured", "verdict")
    publish("unplug", ["# Unplugged", table(header, rows(found, asked.cycles))])


if __name__ == "__main__":
    main()
