"""A capturing process killed (kill -9) at random moments: nothing acknowledged may be missing."""

import argparse
import tempfile
from pathlib import Path

from support.kills import killed
from support.tables import met, publish, table


def main() -> None:
    """Kill, look, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=200, help="how often (default 200)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--longest", type=float, default=1.5, help="seconds before the latest kill (default 1.5)"
    )
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        outcomes = [
            killed(Path(folder), arguments.seed * 1_000_003 + k, arguments.longest)
            for k in range(arguments.times)
        ]
    faults = [fault for outcome in outcomes for fault in outcome.faults]
    frames = sum(outcome.acknowledged for outcome in outcomes)
    recovered = sum(outcome.recovered for outcome in outcomes)
    rows = [
        ("kills", str(arguments.times), str(len(outcomes)), met(True)),
        ("of them with something to recover", "told", str(recovered), met(True)),
        ("frames acknowledged before", "told", str(frames), met(True)),
        ("files or frames not as they must be", "0", str(len(faults)), met(not faults)),
    ]
    publish("kill", [table(("kill -9", "asked", "measured", "verdict"), rows), *faults])


if __name__ == "__main__":
    main()
