"""A source is what it is, whatever its name; and what it holds is told."""

import json

import pytest
from made import recording, same

from georibbon.errors import GeoribbonError, RecordingError
from georibbon.recording import Recording
from georibbon.session.describe import describe, describe_text
from georibbon.session.file import create_session
from georibbon.session.folder import write_recording
from georibbon.session.source import load_source


@pytest.fixture
def places(tmp_path):
    """The same recording as a folder and as a session, under misleading names."""
    write_recording(recording(), tmp_path / "folder.georibbon")
    create_session(tmp_path / "session.txt", recording())
    return tmp_path


@pytest.mark.parametrize(
    "name", ["folder.georibbon", "folder.georibbon/recording.toml", "session.txt"]
)
def test_it_is_read_whatever_its_name(places, name):
    assert same(load_source(places / name), recording())


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nothing", "no such folder or file"),
        ("folder.georibbon/passes/p1.csv", "one file of a recording"),
        ("folder.georibbon/passes", "there is no recording.toml in this folder"),
        ("text.txt", "no Georibbon session"),
    ],
)
def test_what_is_no_source_is_refused(places, name, words):
    (places / "text.txt").write_text("a text")
    with pytest.raises(GeoribbonError, match=words):
        load_source(places / name)


def test_a_csv_is_told_from_a_session_of_that_name(places):
    (places / "session.txt").rename(places / "session.csv")
    with pytest.raises(RecordingError, match="one file of a recording"):
        load_source(places / "session.csv")


def test_the_facts_are_those_of_the_recording():
    facts = describe(recording())
    assert json.loads(json.dumps(facts)) == facts
    assert facts["title"] == "by hand"
    assert facts["ribbon"]["magnetometers"] == 2
    assert facts["ribbon"]["magnetometer_axes"] == [2, 3]
    assert facts["ribbon"]["sensors"][0]["counts_per_unit"] == 16384.0
    assert [pose["roll"] for pose in facts["poses"]] == [0.0, 90.0]
    assert facts["passes"][0] == {
        "name": "P1", "kind": "pass", "frames": 4, "seconds": 0.03, "lost_values": 1,
    }  # fmt: skip
    assert facts["survey"] == {"marks": 1, "distances": 1, "crossings": 1}
    assert facts["workpiece"] == {"level": True, "heading": 25.0}


def test_the_facts_in_words():
    assert describe_text(describe(recording())).split("\n") == [
        "by hand",
        "ribbon GR-0001: 0.5 m, 100 frames/s, 1 accelerometer, 2 magnetometers of 2 and 3 axes",
        "survey: 1 mark, 1 distance, 1 crossing; workpiece level, heading 25 degrees",
        "2 calibration poses",
        "  roll 0   4 frames in 0.03 s, 1 value lost",
        "  roll 90  4 frames in 0.03 s, 1 value lost",
        "2 passes, 1 tie",
        "  P1  pass  4 frames in 0.03 s, 1 value lost",
        "  P2  pass  4 frames in 0.03 s, 1 value lost",
        "  T1  tie   1 frame in 0.00 s",
    ]


def test_what_is_absent_is_told_too():
    made = recording()
    bare = Recording(made.ribbon, (), made.passes)
    facts = describe(bare)
    assert facts["title"] is None
    assert facts["workpiece"] is None
    lines = describe_text(facts).split("\n")
    assert lines[1].endswith("no workpiece frame")
    assert lines[2] == "0 calibration poses"
