"""``georibbon batch``: many at once, and what is told of them."""

import csv
import json
import shutil
import signal
import subprocess
import sys

import pytest

from georibbon.cli import build_parser, main
from georibbon.cli.batch import (
    Job,
    Outcome,
    Table,
    _work,
    outcome_line,
    table_lines,
    tasks_of,
    time_words,
)
from georibbon.errors import ExportError
from waiting import wait_until


@pytest.fixture
def many(small_capture, tmp_path):
    """A folder with a recording folder, a session of it, and what is none."""
    folder = tmp_path / "many"
    folder.mkdir()
    shutil.copytree(small_capture, folder / "dome")
    assert main(["import", str(small_capture), "-o", str(folder / "part.georibbon")]) == 0
    (folder / "notes.txt").write_text("no session")
    return folder


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


def test_all_of_a_folder_is_done_and_one_bad_session_stops_no_other(many, tmp_path, capsys):
    (many / "broken.georibbon").write_text("not one")
    out = tmp_path / "out"
    words = ["batch", str(many), "-o", str(out), "--surface", "stl", "--curves", "-j", "2"]
    assert main(words) == 1
    assert {one.name for one in out.iterdir()} == {
        "dome.stl", "dome.csv", "part.stl", "part.csv", "batch.csv", "batch.json",
    }  # fmt: skip
    assert (out / "dome.csv").read_bytes() == (out / "part.csv").read_bytes()
    told = capsys.readouterr().out
    assert "3 sources: 2 done, 1 failed" in told
    assert "3 of 3" in told
    table = rows(out / "batch.csv")
    assert table["dome"]["passes"] == "3"
    assert float(table["dome"]["area_m2"]) > 0.1
    assert "no Georibbon session" in table["broken"]["message"]


def test_a_batch_writes_what_reconstruct_writes(many, tmp_path, capsys):
    out, one = tmp_path / "out", tmp_path / "one.stl"
    settings = ["--smoothing", "80", "--tolerance", "0.2", "--unit", "cm"]
    words = ["batch", str(many / "dome"), "-o", str(out), "--surface", "stl", *settings]
    assert main(words) == 0
    single = ["reconstruct", str(many / "dome"), "--surface", str(one), *settings[:4]]
    assert main(single) == 0
    # The same triangles; the header tells another unit.
    assert (out / "dome.stl").stat().st_size == one.stat().st_size
    assert b"unit: cm" in (out / "dome.stl").read_bytes()[:80]
    capsys.readouterr()


def test_what_is_there_is_kept_and_what_is_missing_is_written(many, tmp_path, capsys):
    out = tmp_path / "out"
    base = ["batch", str(many / "dome"), "-o", str(out)]
    assert main([*base, "--curves"]) == 0
    (out / "dome.csv").write_text("mine")
    assert main([*base, "--curves"]) == 0
    assert (out / "dome.csv").read_text() == "mine"
    assert main([*base, "--curves", "--surface", "ply"]) == 0
    assert (out / "dome.csv").read_text() == "mine"
    assert (out / "dome.ply").exists()
    assert main([*base, "--curves", "--overwrite"]) == 0
    assert (out / "dome.csv").read_text().startswith("pass,s,x")
    assert {one.name for one in out.glob("batch*.csv")} == {
        "batch.csv", "batch-2.csv", "batch-3.csv", "batch-4.csv",
    }  # fmt: skip
    assert rows(out / "batch-2.csv")["dome"]["status"] == "kept"
    capsys.readouterr()


def test_json_is_one_object_and_nothing_else(many, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["batch", str(many / "dome"), "-o", str(out), "--curves", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    (session,) = told["sessions"]
    assert (session["name"], session["status"]) == ("dome", "done")
    assert told == json.loads((out / "batch.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["nowhere"], "there is no recording and no session"),
        (["none*"], "there is no recording and no session"),
    ],
)
def test_sources_that_are_not_there_are_refused_before_the_work(
    words, found, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(["batch", *words, "-o", "out", "--curves"]) == 2
    assert found in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_nothing_to_write_and_words_that_mean_nothing_are_refused(many, tmp_path, capsys):
    base = ["batch", str(many), "-o", str(tmp_path / "out")]
    assert main(base) == 2
    assert "nothing is to be written" in capsys.readouterr().err
    assert main([*base, "--curves", "--jobs", "0"]) == 2
    assert main([*base, "--curves", "--calibration", str(tmp_path / "no.json")]) == 2
    assert main([*base, "--surface", "stl", "--method", "paper", "--smoothing", "9"]) == 2
    assert not (tmp_path / "out").exists()
    capsys.readouterr()


def test_a_folder_that_cannot_be_is_refused(many, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    words = ["batch", str(many), "-o", str(tmp_path / "file" / "out"), "--curves"]
    assert main(words) == 2
    assert "cannot be made" in capsys.readouterr().err


def place(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")


def names_of(folder, *words):
    return [task.name for task in tasks_of([str(folder / word) for word in words], (".stl",))]


def test_sources_of_one_name_are_told_apart_by_their_folders(tmp_path):
    place(tmp_path, "mon/part.georibbon", "tue/part.georibbon", "tue/other.georibbon")
    assert names_of(tmp_path, "mon", "tue") == ["mon-part", "other", "tue-part"]


def test_a_source_that_is_named_twice_is_done_once(tmp_path):
    place(tmp_path, "a.georibbon")
    assert names_of(tmp_path, "a.georibbon", "*.georibbon", ".") == ["a"]


def test_a_recording_is_named_as_its_folder_however_it_is_given(tmp_path):
    place(tmp_path, "dome/recording.toml")
    assert names_of(tmp_path, "dome/recording.toml") == ["dome"]
    assert names_of(tmp_path, "dome") == ["dome"]


def test_patterns_and_folders_take_only_what_looks_like_a_session(tmp_path):
    place(tmp_path, "a.georibbon", "a.txt", "b/c.georibbon")
    assert names_of(tmp_path, "*") == ["a", "c"]
    assert names_of(tmp_path, "a.txt") == ["a.txt"]
    with pytest.raises(ExportError, match="no session"):
        names_of(tmp_path, "*.txt")


def test_names_never_meet_whatever_the_folders_are_called(tmp_path):
    place(tmp_path, "x/a/p.georibbon", "y/a/p.georibbon", "a-p.georibbon", "A-P-2.georibbon")
    names = names_of(tmp_path, "x/a", "y/a", ".")
    assert len({name.lower() for name in names}) == 4


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.2, "about 5 s"), (31, "about 30 s"), (55, "about 1 min"), (130, "about 2 min"),
     (4800, "about 1 h 20 min")],
)  # fmt: skip
def test_times_are_said_as_a_person_says_them(seconds, words):
    assert time_words(seconds) == words


DONE = Outcome("dome", "dome", "done", "good", 3, 1, 0.66, 0.14, 0, 2.0)


def test_on_a_terminal_a_line_tells_how_far_it_is(capsys):
    table = Table(4, terminal=True, quiet=False)
    table.add(DONE)
    told = capsys.readouterr()
    assert "1 of 4, about 5 s left" in told.err
    assert told.out == "1 of 4  dome  good  3 passes  sigma 0.66 mm  0.1400 m²\n"
    table.show(stopping=True)
    assert "Ctrl-C ends them too" in capsys.readouterr().err


def test_without_a_terminal_it_does_not(capsys):
    table = Table(4, terminal=False, quiet=True)
    table.add(DONE)
    table.show(stopping=True)
    told = capsys.readouterr()
    assert (told.out, told.err) == ("", "")


def test_the_table_has_a_row_each_and_counts():
    lines = table_lines([DONE, Outcome("x", "x", "failed", message="why")])
    assert lines[1].split() == ["name", "verdict", "passes", "ties", "sigma", "mm", "area", "m²",
                                "notices", "s"]  # fmt: skip
    assert lines[2].split() == ["dome", "good", "3", "1", "0.66", "0.1400", "0", "2.0"]
    assert lines[3].split() == ["x", "failed", *["–"] * 6]
    assert lines[-1] == "2 sources: 1 done, 1 failed"
    assert outcome_line(Outcome("x", "x", "failed", message="why")) == "x  failed: why"


def test_a_job_that_fell_with_another_can_be_done_again(many, tmp_path):
    """Its folder is there already, with what it had written."""
    (task,) = tasks_of([str(many / "dome")], (".csv",))
    words = ["batch", str(many / "dome"), "-o", str(tmp_path), "--curves"]
    place = tmp_path / "0"
    place.mkdir()
    (place / "dome.csv").write_text("half a")
    outcome = _work(Job(task, build_parser(words).parse_args(words), place))
    assert (outcome.status, outcome.files) == ("done", ("dome.csv",))
    assert (place / "dome.csv").read_text().startswith("pass,")


def test_an_interrupt_keeps_what_is_done_and_leaves_no_litter(many, tmp_path):
    for k in range(6):
        shutil.copytree(many / "dome", many / f"again{k}")
    out = tmp_path / "out"
    words = [sys.executable, "-m", "georibbon", "batch", str(many), "-o", str(out), "--curves"]
    with subprocess.Popen([*words, "-j", "1"], stdout=subprocess.PIPE, text=True) as process:
        wait_until(lambda: list(out.glob("*.csv")), 60)
        process.send_signal(signal.SIGINT)
        told, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "stopped" in told
    table = rows(out / "batch.csv")
    assert len(table) == 8
    done = {name for name, row in table.items() if row["status"] == "done"}
    assert done
    assert {one.stem for one in out.glob("*.csv")} == done | {"batch"}
    assert not list(out.glob(".georibbon-*"))
