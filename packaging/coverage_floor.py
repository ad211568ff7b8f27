"""Holds the core to its coverage: above 95 % of the branches of each of its rooms.

    coverage_floor.py FOLDER

Reads the coverage data that pytest left (COVERAGE_FILE), writes a browsable report
into FOLDER, prints one line a room, and exits with 1 where a room is not covered.
"""

import json
import sys
from pathlib import Path

from coverage import Coverage

ROOMS = ("geometry", "fitting", "calibration")
FLOOR = 95.0


def branches(files: dict[str, dict[str, dict[str, int]]], room: str) -> tuple[int, int]:
    """The branches of a room that the tests took, and all of them."""
    summaries = [file["summary"] for name, file in files.items() if f"georibbon/{room}/" in name]
    covered = sum(summary["covered_branches"] for summary in summaries)
    return covered, sum(summary["num_branches"] for summary in summaries)


def main(folder: Path) -> int:
    """Writes the report, prints the figures; 1 where a room is below the floor."""
    coverage = Coverage()
    coverage.load()
    coverage.html_report(directory=str(folder))
    figures = folder / "coverage.json"
    coverage.json_report(outfile=str(figures))
    files = {
        Path(name).as_posix(): file
        for name, file in json.loads(figures.read_text())["files"].items()
    }
    failed = False
    for room in ROOMS:
        covered, total = branches(files, room)
        share = 100.0 * covered / total if total else 100.0
        failed |= share <= FLOOR
        print(f"{room}: {covered} of {total} branches tested, {share:.1f} % (above {FLOOR} needed)")
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1])))
