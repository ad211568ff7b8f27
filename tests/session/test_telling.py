"""What is told of a session, finished or not."""

import json

import pytest
from made import RIBBON, readings, recording

from georibbon.cli import main
from georibbon.session.describe import describe
from georibbon.session.file import create_session
from georibbon.session.session import Session
from georibbon.session.source import load, load_source
from georibbon.session.telling import tell, tell_text

MARK = {"pass": "P7", "at": 0.1, "position": [0.0, 0.0, 1.0], "sigma": 0.001}


@pytest.fixture
def path(tmp_path):
    """An unfinished session with a little of everything."""
    path = tmp_path / "s.georibbon"
    with Session.create(path, RIBBON, title="a bonnet") as session:
        session.add_pose("pose-01", "roll 0", 0, 0, 0, True, readings())
        session.add_pass("P1", "pass", readings())
        stream = session.stream(50)
        stream.append(readings(30))
        stream.close()
        session.do("survey", mark=[MARK], distance=[], crossing=[])
        session.do("note", text="cold\ntoday", **{"pass": "P1"})
        session.do("skip", **{"pass": "P3"})
        session.do("setting", **{"pass": "*", "key": "smoothing", "value": 0.06})
        session.do("setting", **{"pass": "P1", "key": "smoothing", "value": 0.08})
        session.do("setting", **{"pass": "P3", "key": "smoothing", "value": 0.08})
    return path


def info(path, capsys, *words):
    capsys.readouterr()
    assert main(["info", str(path), *words]) == 0
    return capsys.readouterr().out


def test_for_programs(path, capsys):
    facts = json.loads(info(path, capsys, "--json"))
    assert facts == tell(path)
    assert facts["frames"] == 38
    assert [(one["name"], one["frames"]) for one in facts["poses"]] == [("roll 0", 4)]
    assert [(one["name"], one["frames"]) for one in facts["passes"]] == [("P1", 4)]
    assert facts["survey"] == {"marks": 1, "distances": 0, "crossings": 0}
    assert facts["pending_survey"] == ["P7"]
    assert facts["undoable"] == "the smoothing of pass P3"
    (stream,) = facts["streams"]
    assert (stream["rate"], stream["frames"]) == (50.0, 30)
    (note,) = facts["notes"]
    assert (note["text"], note["pass"]) == ("cold\ntoday", "P1")
    assert [one["id"] for one in facts["events"]] == list(range(1, len(facts["events"]) + 1))
    assert facts["events"][-1]["detail"] == {"frames": 38}
    assert (facts["open_in"], facts["recovery"]) == (None, None)
    assert (facts["version"], facts["calibrated"], facts["skipped"]) == (2, False, ["P3"])


def test_for_people(path, capsys):
    lines = info(path, capsys).splitlines()
    assert lines[0] == "a bonnet"
    for line in (
        "1 pass, 0 ties",
        "the survey waits for P7",
        "skipped: P3",
        "smoothing of all passes: 0.06",
        "smoothing of P1: 0.08",
        "38 frames in all, file version 2",
        "    today",
    ):
        assert line in lines
    assert any(line.startswith("30 frames at 50 frames/s from 20") for line in lines)
    assert any(line.startswith("note of 20") and line.endswith("(P1): cold") for line in lines)
    assert lines[-1].endswith("undoing would take back the smoothing of pass P3")


def test_a_session_with_nothing_in_it(tmp_path, capsys):
    Session.create(tmp_path / "s.georibbon").close()
    facts = tell(tmp_path / "s.georibbon")
    assert (facts["ribbon"], facts["poses"], facts["passes"]) == (None, [], [])
    assert facts["undoable"] is None
    assert info(tmp_path / "s.georibbon", capsys).startswith("no ribbon yet")


def test_a_session_that_is_open_here(path, capsys):
    with Session.open(path) as session:
        session.do("note", text="live")
        facts = tell(path)
        assert facts["notes"][-1]["text"] == "live"
        assert facts["recovery"] is None
        assert "open for writing: process" in info(path, capsys)
        session.do("note", text="still mine")
    assert [note["text"] for note in tell(path)["notes"]][1:] == ["live", "still mine"]


def test_an_imported_session_tells_what_its_recording_does(tmp_path):
    create_session(tmp_path / "s.georibbon", recording())
    facts = tell(tmp_path / "s.georibbon")
    expected = describe(recording())
    assert {key: facts[key] for key in expected} == expected
    assert "a calibration" not in tell_text(facts)


def test_poses_alone_and_settings_are_loaded(path):
    assert len(load_source(path, complete=False).poses) == 1
    loaded = load(path, complete=False)
    assert loaded.smoothing == {"*": 0.06, "P1": 0.08}
    assert loaded.calibration is None
