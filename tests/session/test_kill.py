"""Killed (kill -9) at random moments: what was acknowledged is there, bit for bit.

The same as `benchmarks/kill.py`, a few times.
"""

import importlib.util
import sys
from pathlib import Path

import pytest

KILLS = Path(__file__).resolve().parents[2] / "benchmarks" / "support" / "kills.py"


@pytest.fixture
def kills(monkeypatch):
    """What the benchmark kills with."""
    spec = importlib.util.spec_from_file_location("kills", KILLS)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "kills", module)
    spec.loader.exec_module(module)
    return module


def test_nothing_acknowledged_is_lost(kills, tmp_path):
    outcomes = [kills.killed(tmp_path, seed, 0.5) for seed in range(10)]
    assert [outcome.faults for outcome in outcomes] == [()] * 10
    assert sum(outcome.acknowledged for outcome in outcomes) > 1000
    assert sum(outcome.recovered for outcome in outcomes) > 3


def test_what_is_missing_would_be_found(kills, tmp_path):
    path = tmp_path / "s.georibbon"
    with kills.Session.create(path, kills.RIBBON) as session:
        session.add_pass("P1", "pass", kills.frames(1_000_001, 0, kills.PASS))
        session.add_pass("P2", "pass", kills.frames(1_000_001, 0, kills.PASS))
        stream = session.stream(100.0)
        stream.append(kills.frames(stream.part, 0, 100))
        other = session.stream(100.0)
        other.append(kills.frames(7, 0, 100))
        session.stream(100.0)
    known = {("pass", 1): 60, ("pass", 3): 60, ("stream", 3): 101, ("stream", 5): 1}
    assert kills._outcome(path, known).faults == (
        "pass 3 is missing",
        "pass P2 is not what was captured",
        "stream 3 has 100 of 101 frames",
        "stream 4 is not what was captured",
        "stream 5 is empty",
    )
    gone = kills._outcome(tmp_path / "none" / "s.georibbon", {("created", 0): 0})
    assert gone.faults == ("the file is missing",)
