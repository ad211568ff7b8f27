"""`georibbon check`: its words, its exit codes, and what it leaves behind."""

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from georibbon.cli import main
from georibbon.session.lock import Lock


@pytest.fixture(scope="module")
def made(small_capture, tmp_path_factory):
    """A session of three passes."""
    path = tmp_path_factory.mktemp("made") / "dome.georibbon"
    assert main(["import", str(small_capture), "-o", str(path)]) == 0
    return path


@pytest.fixture
def session(made, tmp_path):
    """That session in a folder of its own."""
    return Path(shutil.copy(made, tmp_path / "dome.georibbon"))


@pytest.fixture
def damaged(session):
    """The same with a piece of one pass spoiled."""
    with closing(sqlite3.connect(session)) as database, database:
        (last,) = database.execute("SELECT max(part) FROM chunk").fetchone()
        database.execute("UPDATE chunk SET digest = zeroblob(32) WHERE part = ?", (last,))
    return session


def run(words, capsys):
    """The exit code, standard output and standard error of a command."""
    capsys.readouterr()
    code = main([str(word) for word in ("check", *words)])
    told = capsys.readouterr()
    if code:
        assert told.err.startswith("georibbon: error: ")
        assert told.err.count("\n") == 1
    return code, told.out, told.err


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_session_in_order(session, tmp_path, capsys):
    before = session.read_bytes()
    code, out, err = run([session], capsys)
    assert (code, err) == (0, "")
    assert "dome.georibbon: the session is in order" in out
    assert "passes and ties" in out
    assert session.read_bytes() == before
    assert names(tmp_path) == ["dome.georibbon"]


def test_a_session_in_order_is_not_salvaged(session, tmp_path, capsys):
    code, out, _ = run([session, "--salvage", tmp_path / "t.georibbon", "--json"], capsys)
    facts = json.loads(out)
    assert code == 0
    assert (facts["verdict"], facts["salvaged"], facts["lost"]) == ("fine", None, [])
    assert names(tmp_path) == ["dome.georibbon"]


def test_a_damaged_session_is_saved_beside_it(damaged, tmp_path, capsys):
    before = damaged.read_bytes()
    code, out, err = run([damaged], capsys)
    saved = tmp_path / "dome.salvaged.georibbon"
    assert code == 2
    assert f"what can be read of it was saved in {saved}" in err
    assert "1 of 1 piece of its frames is damaged" in out
    assert f"written: {saved}" in out
    assert damaged.read_bytes() == before
    assert run([saved], capsys)[0] == 0
    assert run([damaged], capsys)[0] == 2
    assert names(tmp_path) == [
        "dome.georibbon",
        "dome.salvaged-2.georibbon",
        "dome.salvaged.georibbon",
    ]


def test_for_programs(damaged, tmp_path, capsys):
    code, out, _ = run([damaged, "--json", "--salvage", tmp_path / "t.georibbon"], capsys)
    facts = json.loads(out)
    assert code == 2
    assert facts["verdict"] == "damaged"
    assert facts["salvaged"] == str(tmp_path / "t.georibbon")
    assert len(facts["lost"]) >= 1
    assert facts["passes"] >= 2
    whole = facts["frames"]
    code, out, _ = run([tmp_path / "t.georibbon", "--json"], capsys)
    assert (code, json.loads(out)["frames"]) == (0, whole)


def test_looking_only(damaged, tmp_path, capsys):
    code, out, err = run([damaged, "--no-salvage"], capsys)
    assert code == 2
    assert "can be saved: " in out
    assert "without --no-salvage" in err
    assert names(tmp_path) == ["dome.georibbon"]


def test_where_nothing_can_be_written(damaged, capsys, monkeypatch):
    def fail(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("georibbon.session.files.tempfile.mkdtemp", fail)
    code, out, err = run([damaged], capsys)
    assert code == 2
    assert "cannot be written (Permission denied)" in err
    assert "with --salvage FILE" in err
    assert "lost:" in out
    assert names(damaged.parent) == ["dome.georibbon"]


def test_another_file_is_never_overwritten(damaged, tmp_path, capsys):
    (tmp_path / "t.georibbon").write_text("years of work")
    for target in (tmp_path / "t.georibbon", damaged):
        assert run([damaged, "--salvage", target], capsys)[0] == 2
    assert (tmp_path / "t.georibbon").read_text() == "years of work"
    code, _, err = run([damaged, "--salvage", tmp_path / "t.db"], capsys)
    assert code == 2
    assert ".georibbon" in err


def test_a_session_open_in_another_program_is_left_alone(damaged, capsys):
    lock = Lock(damaged)
    try:
        code, out, err = run([damaged], capsys)
    finally:
        lock.release()
    assert (code, out) == (2, "")
    assert "has the session open" in err


def test_what_is_no_session(tmp_path, capsys):
    (tmp_path / "picture.georibbon").write_bytes(b"\x89PNG\r\n\x1a\n" * 20)
    for name in ("missing.georibbon", "picture.georibbon", "."):
        code, out, _ = run([tmp_path / name], capsys)
        assert (code, out) == (2, "")
    assert names(tmp_path) == ["picture.georibbon"]
