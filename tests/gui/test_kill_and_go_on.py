"""A window that is killed in the middle of a pass, and one that goes on with its capture."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from threading import Timer

import killed_window
import pytest
from killed_window import FASTER, NOTE, PASSES
from PySide6.QtCore import Qt
from quick_ribbon import Person, quicken

DEADLINE = 60  # s for the process to come to where it is killed


def run_until_killed(folder):
    """The session's path, and every line that was told before the window was killed."""
    here = Path(killed_window.__file__)
    environment = os.environ | {"PYTHONPATH": str(here.parent), "QT_QPA_PLATFORM": "offscreen"}
    environment["XDG_DATA_HOME"] = str(folder / "data")
    told = []
    with subprocess.Popen(
        [sys.executable, str(here), str(folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=environment,
    ) as process:
        guard = Timer(DEADLINE, process.kill)
        guard.start()
        try:
            for line in process.stdout:
                told.append(line.rstrip("\n"))
                if told[-1] == "middle of P3":
                    break
        finally:
            guard.cancel()
            process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    assert told[-1] == "middle of P3"
    return Path(told[0].removeprefix("began ")), told


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("killed")
    return folder, *run_until_killed(folder)


@pytest.fixture
def person(qtbot, killed, monkeypatch):
    """A person who starts the program again."""
    quicken(monkeypatch, FASTER)
    return Person(qtbot, killed[0], monkeypatch)


def test_after_a_kill_all_that_was_told_is_there_and_the_capture_goes_on(person, killed):
    _, path, told = killed
    taken = [line.split()[1] for line in told if line.startswith("taken ")]
    frames = [int(line.partition("(")[2].split()[0]) for line in told if line.startswith("taken ")]
    assert taken == ["P1", "P2"]
    window = person.window

    recent = window.start_page.recent
    assert recent.count() == 1
    assert "was not closed" in recent.item(0).text()
    recent.setFocus()
    recent.setCurrentRow(0)
    person.press(Qt.Key.Key_Return)
    person.wait(lambda: window.document.session is not None)
    assert window.document.path == path
    words = window.banner.text.text()
    assert window.banner.isVisible()
    assert "was not closed" in words
    assert path.name[1:] in words  # it begins a sentence
    assert "2 passes and ties" in words
    state = window.document.session.state
    assert [(one.name, one.frames) for one in state.passes] == list(zip(taken, frames, strict=True))
    assert [one.text for one in state.notes] == [NOTE]
    assert len(state.marks) == sum(line.startswith("survey ") for line in told) == 2 * PASSES
    assert state.calibration is not None

    person.press(Qt.Key.Key_4, Qt.KeyboardModifier.AltModifier)
    page = window.pages.page("capture")
    assert page.plan.go_on.isVisible()
    assert not page.plan.go_on.isEnabled()
    person.press(
        Qt.Key.Key_V, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    )
    person.wait(lambda: window.station.identity is not None)
    person.press(Qt.Key.Key_4, Qt.KeyboardModifier.AltModifier)
    person.click(page.plan.go_on)
    person.wait(lambda: window.capture.active)
    person.wait(lambda: window.capture.current is not None)
    assert window.capture.current.key == "P3"
    assert window.capture.calibration is not None
    person.tick(window.hands.follow)
    person.wait(lambda: window.capture.current is None)
    person.click(page.view.finish_button)
    person.wait(lambda: window.pages.current == "review")
    person.wait(lambda: not window.document.is_busy)
    state = window.document.session.state
    names = [f"P{k}" for k in range(1, PASSES + 1)]
    assert [one.name for one in state.passes] == names
    assert [one.frames for one in state.passes[:2]] == frames
    assert [one.name for one in window.document.reconstruction.passes] == names
    window.close()
