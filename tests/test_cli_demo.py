"""`georibbon demo`."""

import re

import pytest

from georibbon.cli import main

RESULTS = {
    "demo.georibbon", "surface.stl", "surface.obj", "surface.png",
    "curves.csv", "report.json", "report.html",
}  # fmt: skip


@pytest.fixture(scope="module")
def demonstrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo") / "new" / "folder"
    assert main(["demo", "-o", str(folder)]) == 0
    return folder


def test_it_leaves_its_results(demonstrated):
    assert {path.name for path in demonstrated.iterdir()} == RESULTS
    assert (demonstrated / "surface.png").read_bytes().startswith(b"\x89PNG")
    assert (demonstrated / "demo.georibbon").read_bytes().startswith(b"SQLite format 3")


def test_its_session_can_be_read(demonstrated, capsys):
    capsys.readouterr()
    assert main(["info", str(demonstrated / "demo.georibbon")]) == 0
    assert "calibration poses" in capsys.readouterr().out


def test_it_tells_the_error_and_the_places_and_can_be_run_again(demonstrated, capsys):
    before = (demonstrated / "curves.csv").read_bytes()
    capsys.readouterr()
    assert main(["demo", "-o", str(demonstrated)]) == 0
    told = capsys.readouterr().out
    errors = dict(re.findall(r"  (curves|normals|surface) +([0-9.]+) (?:mm|degrees)", told))
    assert float(errors["curves"]) < 1.0
    assert float(errors["normals"]) < 0.45
    assert float(errors["surface"]) < 0.6
    assert all(str(demonstrated / name) in told for name in RESULTS)
    assert (demonstrated / "curves.csv").read_bytes() == before


def test_a_folder_that_cannot_be_made(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["demo", "-o", str(tmp_path / "file" / "demo")]) == 2
    told = capsys.readouterr().err
    assert told.startswith("georibbon: error: ")
    assert str(tmp_path / "file" / "demo") in told
