"""`georibbon demo`."""

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from georibbon.cli import demonstration, main
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


@pytest.fixture
def started(monkeypatch):
    """What was started beside the program; nothing is."""
    words = []

    def popen(command, **_):
        words.append(command)

    monkeypatch.setattr(demonstration.subprocess, "Popen", popen)
    monkeypatch.setattr(demonstration, "_opened", [])
    for name in ("CI", "GEORIBBON_NO_WINDOW"):
        monkeypatch.delenv(name, raising=False)
    return words


@pytest.fixture
def written(monkeypatch):
    """The folders into which files would be written."""
    folders = []
    monkeypatch.setattr(demonstration, "write_files", folders.append)
    return folders


@pytest.fixture
def display(monkeypatch):
    """Whether a window would be seen: by turns None, or why not."""
    answer = [None]
    monkeypatch.setattr(demonstration, "why_unseen", lambda _: answer[0])
    return answer


@pytest.mark.usefixtures("display")
@pytest.mark.parametrize("code", [0, 3])
def test_with_a_display_the_window_opens_on_it(monkeypatch, started, written, code):
    shown = []

    class App:
        @staticmethod
        def main(**words):
            shown.append(words)
            return code

    monkeypatch.setitem(sys.modules, "georibbon.gui.app", App)
    assert main(["demo"]) == code
    assert shown == [{"demonstration": True}]
    assert (written, started) == ([], [])


OPENED = """
import sys
from georibbon.gui import app, files
def opened(self):
    print("the demonstration is opened", flush=True)
    self._window.close()
files.Files.open_demonstration = opened
sys.exit(app.main(demonstration=True))
"""


def test_the_window_opens_the_demonstration(tmp_path):
    homes = ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME")
    environment = os.environ | dict.fromkeys(homes, str(tmp_path))
    done = subprocess.run(
        [sys.executable, "-c", OPENED], env=environment | {"QT_QPA_PLATFORM": "offscreen"},
        cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert done.stdout == "the demonstration is opened\n"


def test_without_one_it_writes_files_and_says_so(display, written, started, capsys):
    display[0] = "there is no display here"
    assert main(["demo"]) == 0
    assert written == [Path("build/demo")]
    assert "there is no display here; the results are written into build/demo" in (
        capsys.readouterr().out
    )
    assert started == []


@pytest.mark.usefixtures("display")
def test_to_files_and_then_the_window_beside(written, started, tmp_path, capsys):
    assert main(["demo", "-o", str(tmp_path), "--window"]) == 0
    assert written == [tmp_path]
    ((*_, module, path),) = started
    assert (module, path) == ("georibbon", str(tmp_path / "demo.georibbon"))
    assert f"the window opens on {tmp_path / 'demo.georibbon'}" in capsys.readouterr().out
    assert main(["demo", "-o", str(tmp_path)]) == 0
    assert len(started) == 1


@pytest.mark.parametrize("name", ["CI", "GEORIBBON_NO_WINDOW", None])
def test_the_window_can_be_left_out(name, display, written, started, monkeypatch, capsys):
    if name is None:
        display[0] = "there is no display here"
    else:
        monkeypatch.setenv(name, "1")
    assert main(["demo", "--window"]) == 0
    assert written == [Path("build/demo")]
    assert started == []
    assert f"no window is opened: {display[0] or f'the environment has {name}'}" in (
        capsys.readouterr().out
    )


@pytest.mark.parametrize("platform", ["offscreen", "minimal:enable_fonts", "xcb"])
def test_a_platform_that_shows_nothing_is_no_display(platform):
    assert "no display" in demonstration.why_unseen({"QT_QPA_PLATFORM": platform})
