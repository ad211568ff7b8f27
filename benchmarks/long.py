"""Hours of capture in accelerated time: is memory flat, and how large does the file get?"""

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from support.kills import RIBBON, frames
from support.tables import met, publish, table

from georibbon.ribbon import Readings
from georibbon.session.session import Session

SECOND = 100  # frames
PASS_EVERY = 600  # seconds
PASS = 300  # frames
WARM = 0.1  # of the whole time


@dataclass(frozen=True)
class Figures:
    """Bytes resident after the warm-up and at the end, of the file and raw; seconds it took."""

    warm: int
    end: int
    file: int
    raw: int
    seconds: float


def main() -> None:
    """Capture, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=8.0, help="to be captured (default 8)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = capture(Path(folder) / "long.georibbon", round(3600 * arguments.hours))
    growth, size = found.end / found.warm - 1.0, found.file / found.raw - 1.0
    rows = [
        ("memory after a tenth", "", f"{found.warm / 2**20:.1f} MiB", ""),
        ("memory at the end", "flat within 5 %", f"{100 * growth:+.1f} %", met(growth <= 0.05)),
        ("raw bytes", "", f"{found.raw / 2**20:.1f} MiB", ""),
        ("file", "within 10 %", f"{100 * size:+.1f} %", met(abs(size) <= 0.10)),
        ("time it took", "", f"{found.seconds:.0f} s", ""),
    ]
    head = f"{arguments.hours:g} h, 100 frames/s, {len(RIBBON.sensors)} sensors"
    publish("long", [table((head, "asked", "measured", "verdict"), rows)])


def capture(path: Path, seconds: int) -> Figures:
    """A stream of so many seconds, with a pass now and then."""
    begun, warm, passes = time.monotonic(), 0, 0
    made = frames(1, 0, SECOND)
    with Session.create(path, RIBBON) as session:
        stream = session.stream(RIBBON.rate)
        for second in range(seconds):
            stream.append(Readings(made.t + second, made.counts))
            stream.flush()
            if second % PASS_EVERY == PASS_EVERY - 1:
                passes += 1
                session.add_pass(f"P{passes}", "pass", frames(2, 0, PASS))
            if second == int(WARM * seconds):
                warm = resident()
        end = resident()
    raw = (seconds * SECOND + passes * PASS) * (4 + 2 * len(RIBBON.columns))
    return Figures(warm, end, path.stat().st_size, raw, time.monotonic() - begun)


def resident() -> int:
    """Bytes of this process in memory."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").split("\n"):
        if line.startswith("VmRSS:"):
            return 1024 * int(line.split()[1])
    raise SystemExit("this script reads /proc, which only Linux has")


if __name__ == "__main__":
    main()
