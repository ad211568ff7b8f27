"""How long a packet takes to become a curve on its way through link, stillness and live fit.

A process of its own plays a ribbon of 32 sensors at the end of a pseudo-terminal
in real time, two seconds moved by hand and two seconds at rest by turns.  This
process reads it through the link and brings stillness and curve up to date for
every frame that has come, as a window would for every displayed frame.  A
frame's latency is from the moment before its packet was written to the moment
when a curve that knows it is there.  Measure on a machine that does nothing else.

    .venv/bin/python benchmarks/latency.py [--seconds S] [--sensors N] [--axes 2|3] [--rate HZ]
"""

import argparse
import os
import pty
import select
import subprocess
import sys
import time
import tty
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from georibbon.calibration.model import Calibration
from georibbon.capture.live import LiveFit
from georibbon.device.frames import Frame, pack_frame, readings_of
from georibbon.device.identity import Identity, write_identity
from georibbon.device.link import Link
from georibbon.device.packets import DONE, FRAME, IDENTITY, Packet, encode
from georibbon.device.stillness import StillnessMonitor
from georibbon.fitting.grid import Shape, integrate_frames, make_grid
from georibbon.ribbon import Ribbon
from georibbon.rotations import exp
from georibbon.simulation.forward import expected_counts, sample_counts
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import noise_counts, true_models, virtual_ribbon
from georibbon.stillness import still_means
from georibbon.world import field_direction

MOST_LATENCY = 0.020  # s, of 99 frames in 100
MOST_STILLNESS = 0.001  # s a frame
PHASE = 2.0  # s moved, s at rest
LEFT_OUT = 1.0  # s in the beginning: code and memory are being loaded
AVERAGED = 5  # frames, while the ribbon moves
DIP = np.radians(62.0)


def main() -> None:
    """Play the ribbon, or measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seconds", type=float, default=30.0, help="how long it is measured")
    parser.add_argument("--sensors", type=int, default=32)
    parser.add_argument("--axes", type=int, default=2, choices=(2, 3), help="of a magnetometer")
    parser.add_argument("--rate", type=float, default=100.0, help="frames per second")
    parser.add_argument("--play", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    made = RibbonSettings(
        sensors=asked.sensors, magnetometer_axes=asked.axes, rate=asked.rate, length=0.96
    )
    if asked.play:
        play(made, asked.seconds)
    else:
        report(made, measure(made, asked.seconds))


def known(made: RibbonSettings) -> tuple[Ribbon, Calibration]:
    """The ribbon and what is known of its sensors, the same in both processes."""
    ribbon = virtual_ribbon(made)
    models = true_models(ribbon, made, np.random.default_rng(1))
    return ribbon, Calibration(ribbon.id, float(DIP), models)


# The ribbon.


def play(made: RibbonSettings, seconds: float) -> None:
    """Open a pseudo-terminal, tell its name, answer the host and send frames in real time."""
    ribbon, calibration = known(made)
    frames = list(played(made, ribbon, calibration, seconds))
    host, line = pty.openpty()
    tty.setraw(line)
    print(os.ttyname(line), flush=True)
    sequence = 0

    def send(kind: int, payload: bytes) -> None:
        nonlocal sequence
        os.write(host, encode(Packet(kind, sequence, payload)))
        sequence = (sequence + 1) % 65536

    heard = b""
    while b"start\n" not in heard:
        heard += os.read(host, 1000)
        while b"identify\n" in heard:
            heard = heard.replace(b"identify\n", b"", 1)
            send(IDENTITY, write_identity(Identity(ribbon, "latency")))
    send(DONE, b"start")
    begin = time.monotonic()
    print(repr(begin), flush=True)
    for k, counts in enumerate(frames):
        due = begin + k / made.rate
        time.sleep(max(0.0, due - time.monotonic()))
        send(FRAME, pack_frame(round((time.monotonic() - begin) * 1e6), counts))
    select.select([sys.stdin], [], [], 30.0)  # until the host has read all of it


def played(
    made: RibbonSettings, ribbon: Ribbon, calibration: Calibration, seconds: float
) -> Iterator[np.ndarray]:
    """(c,) counts of frame after frame: by turns moved by a hand, and laid down somewhere else."""
    rng = np.random.default_rng(2)
    grid = make_grid(ribbon)
    s = grid.nodes / grid.nodes[-1]
    noise, field_there = noise_counts(ribbon, made), field_direction(float(DIP))
    contact = exp(np.radians(0.25) * rng.standard_normal((len(ribbon.sensors), 3)))
    basis = np.linalg.pinv(grid.at_nodes)
    moved = 0.0
    for k in range(round(seconds * made.rate)):
        moving = (k / made.rate) % (2 * PHASE) < PHASE
        moved += moving / made.rate
        attitude = exp(np.array([0.6 * np.sin(1.1 * moved), 0.4 * np.sin(1.7 * moved), moved]))
        bent = 0.8 + 0.7 * np.sin(2.0 * moved) + 0.5 * np.cos(4.0 * s + moved)
        rates = np.stack([basis @ (0.4 * np.sin(5.0 * s + moved)), basis @ bent])
        there = integrate_frames(grid, Shape(attitude[None], rates[None]))[0, grid.sensor_nodes]
        if moving:  # a hand's unsteadiness, in its accelerations too
            there = there @ exp(0.01 * rng.standard_normal((len(there), 3)))
        said = expected_counts(ribbon, calibration.sensors, there @ contact, field_there)
        yield sample_counts(said, noise, 1, rng)[0].astype(np.int16)


# The host.


@dataclass
class Measured:
    """Of each frame: seconds of latency, processor seconds of each step, whether at rest.

    share: of one processor.
    """

    latency: list[float] = field(default_factory=list)
    stillness: list[float] = field(default_factory=list)
    fit: list[float] = field(default_factory=list)
    rest: list[bool] = field(default_factory=list)
    share: float = 0.0
    lost: int = 0


def measure(made: RibbonSettings, seconds: float) -> Measured:
    """Read what the other process plays, until it ends."""
    command = [sys.executable, __file__, "--play", f"--seconds={seconds + LEFT_OUT}"]
    command += [f"--sensors={made.sensors}", f"--axes={made.magnetometer_axes}"]
    with subprocess.Popen(
        [*command, f"--rate={made.rate}"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as ribbon:
        told = ribbon.stdout or sys.stdin
        with Link(told.readline().strip()) as link:
            found = follow(link, made, float(told.readline()), seconds + LEFT_OUT)
            found.lost = link.health().lost
        ribbon.communicate("")
    return found


def follow(link: Link, made: RibbonSettings, begin: float, seconds: float) -> Measured:
    """Stillness and curve of every frame, and how long each took."""
    ribbon, calibration = known(made)
    monitor, fit = StillnessMonitor(ribbon, calibration), LiveFit(ribbon, calibration)
    found, recent = Measured(), list[Frame]()
    tap = link.recorder()
    started, busy = time.monotonic(), time.process_time()
    expected, came = round(seconds * made.rate), 0
    while came < expected and tap.wait(2.0):
        frames = tap.take()
        came += len(frames)
        before = time.thread_time()
        told = monitor.feed(frames)
        between = time.thread_time()
        recent = [*recent, *frames][-AVERAGED:]
        means = monitor.means() or still_means(readings_of(recent))
        fit.update(means.mean, means.sigma)
        after, now = time.thread_time(), time.monotonic()
        for frame in frames:
            if frame.t > LEFT_OUT:
                found.latency.append(now - begin - frame.t)
                found.stillness.append((between - before) / len(frames))
                found.fit.append(after - between)
                found.rest.append(told.state == "still")
    found.share = (time.process_time() - busy) / (time.monotonic() - started)
    tap.close()
    return found


def report(made: RibbonSettings, found: Measured) -> None:
    """Print the table."""
    from support.tables import met, publish, table

    def row(what: str, values: list[float], most: float | None = None) -> list[str]:
        part = np.array(values)
        middle, high = np.quantile(part, [0.5, 0.99])
        cells = [what, f"{1e3 * middle:.2f}", f"{1e3 * high:.2f}", f"{1e3 * part.max():.2f}"]
        asked = "" if most is None else f"{1e3 * most:g}"
        return [*cells, asked, "" if most is None else met(bool(high <= most))]

    still = [t for t, rest in zip(found.latency, found.rest, strict=True) if rest]
    moved = [t for t, rest in zip(found.latency, found.rest, strict=True) if not rest]
    rows = [
        row("packet in to curve out", found.latency, MOST_LATENCY),
        row("of these, told as still", still),
        row("of these, told as moving", moved),
        row("stillness of a frame, processor time", found.stillness, MOST_STILLNESS),
        row("one update of the live curve, processor time", found.fit),
    ]
    header = ("milliseconds", "median", "99 in 100", "greatest", "asked of 99 in 100", "")
    head = (
        f"{made.sensors} sensors, magnetometers of {made.magnetometer_axes} axes, {made.rate:g} "
        f"frames/s, {len(found.latency)} frames, {found.lost} packets lost, {os.cpu_count()} "
        f"processors.\n\nProcessor share of link, stillness and live curve together: "
        f"{100 * found.share:.0f} % of one processor, a curve for every frame."
    )
    publish("latency", [head, table(header, rows)])


if __name__ == "__main__":
    main()
