"""What was done in a session, in the order in which it was done."""

from datetime import UTC, datetime

import numpy as np
import pytest

from georibbon.ribbon import Readings, Ribbon, Sensor
from georibbon.session.events import Event
from georibbon.session.history import entries, readings_facts

TIME = "2026-03-04T05:06:07.000+00:00"


def told(*actions):
    """Entries of (action, detail) pairs."""
    events = [Event(i, TIME, action, detail) for i, (action, detail) in enumerate(actions, 1)]
    return entries(events)


def run(name, kind="pass", part=1):
    return "pass", {"name": name, "kind": kind, "part": part, "frames": 5}


def test_each_event_has_its_kind_its_words_and_its_pass():
    found = told(
        ("created", {"georibbon": "1"}),
        run("P1"),
        ("note", {"text": "the cable\ncrossed", "pass": "P1"}),
        ("setting", {"pass": "*", "key": "smoothing", "value": 0.1}),
        ("link", {"state": "stalled", "reason": "no packets"}),
        ("remove", {"pass": "P1"}),
    )
    assert [one.kind for one in found] == ["file", "capture", "note", "change", "link", "capture"]
    assert [one.pass_name for one in found] == [None, "P1", "P1", None, None, "P1"]
    assert found[2].words == "the cable\ncrossed"
    assert found[3].words == "the smoothing of all passes"
    assert found[5].words == "the removal of pass P1"


def test_a_pass_that_was_redone_says_so():
    assert [one.words for one in told(run("P1"), run("P2", part=2), run("P1", part=3))] == [
        "pass P1", "pass P2", "pass P1, once more",
    ]  # fmt: skip


def test_what_was_undone_does_not_count_until_it_is_done_again():
    undone = told(run("P1"), ("undo", {"of": 1}))
    assert [one.undone for one in undone] == [True, False]
    assert undone[1].words == "took back pass P1"
    redone = told(run("P1"), ("undo", {"of": 1}), ("redo", {"of": 1}))
    assert [one.undone for one in redone] == [False, False, False]
    assert redone[2].words == "did again pass P1"


@pytest.mark.parametrize("of", [0, 9, "x", None, -1])
def test_an_undo_of_nothing_is_told_as_it_stands(of):
    assert told(("undo", {"of": of}))[0].words.startswith("undoing of event")


def test_times_are_local():
    (entry,) = told(run("P1"))
    assert entry.local_time == datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)


RIBBON = Ribbon(
    "GR-1", 1.0, 50.0,
    (Sensor("A01", "accelerometer", 3, 0.0, 1000.0), Sensor("M01", "magnetometer", 2, 0.1, 200.0)),
)  # fmt: skip


def test_the_facts_of_readings():
    counts = np.zeros((5, 5))
    counts[:, 4] = [0.0, 1.0, 0.0, 1.0, np.nan]
    counts[:, 0] = [0.0, 1.0, 0.0, 1.0, 0.0]
    found = readings_facts(Readings(np.arange(5) / 50.0, counts), RIBBON)
    assert (found.frames, found.lost) == (5, 1)
    assert found.seconds == pytest.approx(0.08)
    assert found.rate == pytest.approx(50.0)
    assert found.restless == ("M01y", pytest.approx(1e3 * 0.5 / 200.0))


def test_one_frame_has_no_rate_and_nothing_heard_is_not_restless():
    one = readings_facts(Readings(np.zeros(1), np.full((1, 5), np.nan)), RIBBON)
    assert (one.frames, one.seconds, one.rate, one.lost, one.restless) == (1, 0.0, None, 5, None)
    none = readings_facts(Readings(np.zeros(0), np.zeros((0, 5))), RIBBON)
    assert (none.frames, none.restless) == (0, None)
