"""`georibbon demo`."""

import contextlib
import io
import re

import pytest

from georibbon.cli import main
from georibbon.errors import SettingsError

RESULTS = {
    "demo.georibbon", "surface.stl", "surface.obj", "surface.png",
    "curves.csv", "report.json", "report.html",
}  # fmt: skip


@pytest.fixture(scope="module")
def demonstrated(tmp_path_factory):
    """(the folder, what was printed); the folder held results of an earlier time."""
    folder = tmp_path_factory.mktemp("demo")
    for name in ("demo.georibbon", "curves.csv"):
        (folder / name).write_text("of an earlier time")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        assert main(["demo", "-o", str(folder)]) == 0
    return folder, printed.getvalue()


def test_it_leaves_its_results(demonstrated):
    folder, _ = demonstrated
    assert {path.name for path in folder.iterdir()} == RESULTS
    assert (folder / "surface.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "demo.georibbon").read_bytes().startswith(b"SQLite format 3")
    assert (folder / "curves.csv").read_bytes().startswith(b"pass,")


def test_its_session_can_be_read(demonstrated, capsys):
    assert main(["info", str(demonstrated[0] / "demo.georibbon")]) == 0
    assert "calibration poses" in capsys.readouterr().out


def test_it_tells_the_error_and_the_places(demonstrated):
    folder, told = demonstrated
    errors = dict(re.findall(r"  (curves|normals|surface) +([0-9.]+) (?:mm|degrees)", told))
    assert float(errors["curves"]) < 1.0
    assert float(errors["normals"]) < 0.45
    assert float(errors["surface"]) < 0.6
    assert all(str(folder / name) in told for name in RESULTS)


@pytest.mark.parametrize("place", [".", "new/folder"])
def test_a_folder_that_it_made_in_vain_is_taken_away(tmp_path, monkeypatch, place):
    folder = tmp_path / "old" / place
    (tmp_path / "old").mkdir()

    def stop(*_):
        assert [path.name[:11] for path in folder.iterdir()] == [".georibbon-"] * len(RESULTS)
        raise SettingsError("stopped here")

    monkeypatch.setattr("georibbon.simulation.simulate", stop)
    assert main(["demo", "-o", str(folder)]) == 2
    assert list((tmp_path / "old").iterdir()) == []


def test_a_folder_that_cannot_be_made(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["demo", "-o", str(tmp_path / "file" / "demo")]) == 2
    told = capsys.readouterr().err
    assert told.startswith("georibbon: error: ")
    assert str(tmp_path / "file" / "demo") in told
