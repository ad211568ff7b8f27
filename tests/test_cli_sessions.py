"""`georibbon info`, `import` and `export`."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from georibbon.cli import main
from georibbon.session.file import create_session
from georibbon.session.folder import read_recording
from georibbon.session.session import Session
from refusing import refused


@pytest.fixture
def session(small_capture, tmp_path):
    path = tmp_path / "dome.georibbon"
    assert main(["import", str(small_capture), "-o", str(path)]) == 0
    return path


def test_a_round_trip_loses_nothing(small_capture, session, tmp_path):
    back = tmp_path / "back"
    assert main(["export", str(session), "--recording", str(back)]) == 0
    before, after = read_recording(small_capture), read_recording(back)
    for name in ("ribbon", "marks", "distances", "crossings", "workpiece", "title"):
        assert getattr(before, name) == getattr(after, name)
    for old, new in zip(before.poses + before.passes, after.poses + after.passes, strict=True):
        assert old.name == new.name
        np.testing.assert_array_equal(old.readings.t, new.readings.t)
        np.testing.assert_array_equal(old.readings.counts, new.readings.counts)


def test_recording_and_session_are_told_alike(small_capture, session, capsys):
    def told(*words):
        capsys.readouterr()
        assert main(["info", *map(str, words)]) == 0
        return capsys.readouterr().out

    of_folder = told(small_capture)
    assert "GR-0001" in of_folder
    assert told(session).startswith(of_folder)
    facts = json.loads(told(small_capture, "--json"))
    of_session = json.loads(told(session, "--json"))
    assert {key: of_session[key] for key in facts} == facts
    assert of_session["frames"] == sum(run["frames"] for run in facts["poses"] + facts["passes"])


def test_poses_alone_calibrate_and_the_calibration_stands_in_for_them(
    small_capture, tmp_path, capsys
):
    recording = read_recording(small_capture)
    with Session.create(tmp_path / "poses.georibbon", recording.ribbon) as poses:
        for i, pose in enumerate(recording.poses):
            poses.add_pose(
                f"pose-{i}", pose.name, pose.roll, pose.heading, pose.pitch, pose.table,
                pose.readings,
            )  # fmt: skip
    made = tmp_path / "ribbon.json"
    assert main(["calibrate", str(tmp_path / "poses.georibbon"), "-o", str(made)]) == 0
    path = tmp_path / "passes.georibbon"
    create_session(path, replace(recording, poses=()))
    assert "no calibration poses" in refused(
        ["reconstruct", path, "--report", tmp_path / "none.json"], capsys
    )
    with Session.open(path) as session:
        session.do("calibration", document=json.loads(made.read_text(encoding="utf-8")))
        session.do("setting", **{"pass": "P2", "key": "smoothing", "value": 0.07})
        session.do("setting", **{"pass": "*", "key": "smoothing", "value": 0.09})
    for words, lengths in (
        ([], [90.0, 70.0, 90.0]),
        (["--smoothing", "P1=80"], [80.0, 70.0, 90.0]),
        (["--smoothing", "60"], [60.0, 60.0, 60.0]),
    ):
        report = tmp_path / "report.json"
        report.unlink(missing_ok=True)
        capsys.readouterr()
        arguments = ["reconstruct", str(path), "--report", str(report), *words]
        assert main(arguments) == 0
        told = capsys.readouterr().out
        assert "from the session: the calibration" in told
        assert ("from the session: the smoothing of pass P2, 70 mm" in told) == (lengths[1] == 70.0)
        passes = json.loads(report.read_text(encoding="utf-8"))["passes"]
        assert [round(one["smoothing_mm"], 6) for one in passes] == lengths
        with_poses = main([*arguments[:3], str(tmp_path / "p.json"), "--method", "paper"])
        assert with_poses == 0
        (tmp_path / "p.json").unlink()


def test_what_a_recording_has_no_place_for_is_told(session, tmp_path, capsys):
    with Session.open(session) as opened:
        stream = opened.stream(100.0)
        stream.append(opened.readings(1))
        frames = stream.frames
        opened.do("note", text="cold")
        opened.do("setting", **{"pass": "P1", "key": "smoothing", "value": 0.05})
        opened.do("remove", **{"pass": "P3"})
    assert main(["export", str(session), "--recording", str(tmp_path / "back")]) == 0
    told = capsys.readouterr().out.splitlines()[-1]
    for words in (f"{frames} frames between the passes", "1 note", "1 setting", "1 pass in the"):
        assert words in told
    assert "calibration" not in told


def test_a_smoothing_that_is_no_length_is_refused(session, tmp_path, capsys):
    with Session.open(session) as opened:
        opened.do("setting", **{"pass": "P1", "key": "smoothing", "value": "fine"})
    words = ["reconstruct", session, "--report", tmp_path / "r.json"]
    assert 'the smoothing of "P1" is "fine"' in refused(words, capsys)


def test_info_for_programs(small_capture, capsys):
    assert main(["info", str(small_capture), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["ribbon"]["accelerometers"] == facts["ribbon"]["magnetometers"] == 8
    assert [run["name"] for run in facts["passes"]] == ["P1", "P2", "P3"]
    assert facts["passes"][0]["frames"] == 40
    assert facts["survey"]["marks"] == 6


def test_sources_that_are_none(tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    (tmp_path / "picture.georibbon").write_bytes(b"\x89PNG\r\n\x1a\n" * 20)
    for name in ("missing", "missing.georibbon", "picture.georibbon"):
        assert name in refused(["info", tmp_path / name], capsys)
    assert "recording.toml" in refused(["info", tmp_path / "empty"], capsys)
    assert "recording.toml" in refused(
        ["import", tmp_path / "empty", "-o", tmp_path / "s.georibbon"], capsys
    )
    assert "missing" in refused(
        ["export", tmp_path / "missing", "--recording", tmp_path / "r"], capsys
    )
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["empty", "picture.georibbon"]


def test_a_session_is_never_overwritten(small_capture, session, capsys):
    before = session.read_bytes()
    assert str(session) in refused(["import", small_capture, "-o", session], capsys)
    assert session.read_bytes() == before


@pytest.mark.parametrize("name", ["s.db", "s", "missing/s.georibbon"])
def test_a_session_that_cannot_be_made(small_capture, tmp_path, name, capsys):
    assert name in refused(["import", small_capture, "-o", tmp_path / name], capsys)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_contents_is_not_filled(session, tmp_path, capsys):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.txt").write_text("years of work")
    assert "full" in refused(["export", session, "--recording", tmp_path / "full"], capsys)
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["thesis.txt"]


def test_a_defect_is_told_with_file_and_line_and_nothing_is_left(small_capture, tmp_path, capsys):
    broken = tmp_path / "broken"
    shutil.copytree(small_capture, broken)
    file = broken / "passes" / "p2.csv"
    lines = file.read_text(encoding="utf-8").splitlines()
    lines[4] = lines[4].replace(",", ",x", 1)
    file.write_text("\n".join(lines), encoding="utf-8")
    told = refused(["import", broken, "-o", tmp_path / "s.georibbon"], capsys)
    assert "passes/p2.csv" in told
    assert "line 5" in told
    assert [path.name for path in tmp_path.iterdir()] == ["broken"]


def test_a_sessions_settings_are_used_where_the_words_ask_for_none(session, tmp_path, capsys):
    with Session.open(session) as opened:
        for whose, key, value in (
            ("P1", "sensors_off", ["A02"]),
            ("P2", "trim", [0.05, 0.1]),
            ("*", "weight", 2),
            ("*", "surface.direction", "conormal"),
            ("*", "surface.tolerance", 0.0004),
            ("*", "colour", "blue"),
        ):
            opened.do("setting", **{"pass": whose, "key": key, "value": value})
    report = tmp_path / "report.json"
    words = ["reconstruct", str(session), f"--report={report}"]
    assert main([*words, "--weight=P2=3", "--tolerance=0.5"]) == 0
    told = capsys.readouterr().out
    for line in (
        "the switched-off sensors of pass P1, A02",
        "the trimmed ends of pass P2, 50 mm and 100 mm",
        "the weight of all passes, 2",
        "the surface's direction across, conormal",
    ):
        assert f"from the session: {line}\n" in told
    assert "tolerance" not in told
    assert "colour" not in told
    assert "pass P1: sensor A02 is switched off and has no say" in told
    lengths = [one["length_m"] for one in json.loads(report.read_text("utf-8"))["passes"]]
    assert lengths[0] - lengths[1] == pytest.approx(0.15)


def test_the_papers_way_leaves_what_is_of_the_ribbons_way(session, tmp_path, capsys):
    with Session.open(session) as opened:
        opened.do("setting", **{"pass": "P1", "key": "weight", "value": 2})
        opened.do("setting", **{"pass": "*", "key": "method", "value": "paper"})
    assert main(["reconstruct", str(session), f"--report={tmp_path / 'r.json'}"]) == 0
    told = capsys.readouterr().out
    assert "from the session: the method, paper" in told
    assert "weight" not in told


def test_tangents_go_with_the_papers_way_and_are_told_in_the_report(session, tmp_path, capsys):
    report = tmp_path / "r.json"

    def said(*words):
        assert main(["reconstruct", str(session), f"--report={report}", *words]) == 0
        return capsys.readouterr().out, json.loads(report.read_text("utf-8"))["tangents"]

    with Session.open(session) as opened:
        opened.do("setting", **{"pass": "*", "key": "tangents", "value": "averages"})
    told, tangents = said()
    assert (("from the session" in told), tangents) == (False, None)
    report.unlink()
    told, tangents = said("--method=paper")
    assert "from the session: the interpolation of the tangents, averages" in told
    assert tangents == "averages"
    report.unlink()
    told, tangents = said("--method=paper", "--tangents=components")
    assert (("from the session" in told), tangents) == (False, "components")
