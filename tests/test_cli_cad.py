"""Surfaces for CAD programs from the command line: one spline, told and named."""

import json
import re
import signal

import pytest

from georibbon.cli import main
from refusing import refused

TOLD = re.compile(
    r"one spline within (\S+) mm and \S+° of the patches, (\d+) × (\d+) control points, read back"
)


def test_reconstruct_writes_both_formats_within_the_tolerance(small_capture, tmp_path, capsys):
    names = ("part.step", "part.IGS")
    words = [f"--surface={tmp_path / name}" for name in (*names, "part.stl")]
    words += [f"--report={tmp_path / 'part.json'}"]
    assert main(["reconstruct", str(small_capture), *words, "--unit=in", "--tolerance=0.2"]) == 0
    told = capsys.readouterr().out
    lines = {line for line in told.splitlines() if line.startswith("written: ")}
    for name in names:
        (line,) = (one for one in lines if one.startswith(f"written: {tmp_path / name} (in), "))
        found = TOLD.search(line)
        assert float(found[1]) <= 0.2
    assert f"written: {tmp_path / 'part.stl'} (in)" in lines
    assert "INCH" in (tmp_path / "part.step").read_text()
    assert "4HINCH" in (tmp_path / "part.IGS").read_text()
    assert "part.step" in (tmp_path / "part.json").read_text()
    assert {one.name for one in tmp_path.iterdir()} == {*names, "part.stl", "part.json"}


def test_curves_of_any_origin_become_a_spline_too(small_capture, tmp_path, capsys):
    curves = tmp_path / "curves.csv"
    assert main(["reconstruct", str(small_capture), f"--curves={curves}"]) == 0
    capsys.readouterr()
    path = tmp_path / "hood.stp"
    assert main(["surface", str(curves), f"--surface={path}", "--interior=c1-lines"]) == 0
    assert TOLD.search(capsys.readouterr().out)
    assert "PRODUCT('curves','curves'" in path.read_text()


def test_a_batch_writes_them_for_each(small_capture, tmp_path, capsys):
    words = [str(small_capture), "-o", str(tmp_path), "--surface=step", "--surface=iges", "--json"]
    assert main(["batch", *words]) == 0
    (one,) = json.loads(capsys.readouterr().out)["sessions"]
    assert one["status"] == "done"
    assert one["files"] == ["dome.step", "dome.iges"]
    assert (tmp_path / "dome.step").read_text().startswith("ISO-10303-21;")


@pytest.mark.usefixtures("no_work")
def test_an_interrupt_while_the_kernel_loads_is_one(small_capture, tmp_path, capsys, monkeypatch):
    def load(_path):
        signal.raise_signal(signal.SIGINT)
        loaded.append(True)

    loaded: list[bool] = []
    monkeypatch.setattr("georibbon.export.cad.require_kernel", load)
    assert main(["reconstruct", str(small_capture), f"--surface={tmp_path / 'part.step'}"]) == 130
    assert loaded == [True]  # it came to its end, undisturbed
    assert capsys.readouterr().err == "georibbon: interrupted\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("no_work")
def test_what_cannot_be_written_is_told_before_the_work(
    small_capture, tmp_path, capsys, monkeypatch
):
    step = f"--surface={tmp_path / 'part.step'}"
    told = refused(["reconstruct", small_capture, step, "--thickness=2"], capsys)
    assert "part.step: a thickness was asked for" in told
    batch = ["batch", small_capture, "-o", tmp_path / "out", "--surface=iges"]
    told = refused([*batch, "--thickness=2"], capsys)
    assert f"{tmp_path / 'out' / '*.iges'}: a thickness was asked for" in told
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    for words in (["reconstruct", small_capture, step], batch):
        told = refused(words, capsys)
        assert "STEP and IGES need the CAD kernel, which is not installed: run" in told
        assert "make cad" in told
    assert list(tmp_path.iterdir()) == []
