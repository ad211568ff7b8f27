"""The program as it is started: a process of its own, on Qt's platform without a display."""

import os
import signal
import subprocess
import sys

import pytest

from georibbon.session.session import Session

ENVIRONMENT = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
# Acts as soon as a result is seen.
DRIVER = """
import sys
from pathlib import Path
from PySide6.QtCore import QTimer
from georibbon.gui import app, window
path, verb = Path(sys.argv[1]), sys.argv[2]
made = window.MainWindow.__init__
def watched(self, *words):
    made(self, *words)
    self.document.reconstructed.connect(lambda _: QTimer.singleShot(0, lambda: act(self)))
def act(self):
    if verb == "close":
        self.close()
    elif self.document.smoothing:
        print("smoothed", flush=True)
    else:
        self.document.set_smoothing("P1", 0.2)
window.MainWindow.__init__ = watched
sys.exit(app.main(path))
"""


def start(session, verb, folder):
    environment = ENVIRONMENT | {"XDG_CONFIG_HOME": str(folder), "HOME": str(folder)}
    return subprocess.Popen(
        [sys.executable, "-c", DRIVER, str(session), verb],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_it_starts_shows_and_ends(session, tmp_path):
    with start(session, "close", tmp_path) as process:
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (0, "")
    assert [line for line in err.splitlines() if "propagateSizeHints" not in line] == []
    settings = tmp_path / "Georibbon" / "Georibbon.ini"
    assert str(session) in settings.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_signal_closes_the_session(session, tmp_path, name):
    with start(session, "wait", tmp_path) as process:
        assert process.stdout.readline() == "smoothed\n"
        process.send_signal(getattr(signal, name))
        process.communicate(timeout=60)
    assert process.returncode == 0
    with Session.open(session, read_only=True) as kept:
        assert kept.recovery is None
        assert kept.state.history[-1].action == "closed"
        assert kept.state.settings == {("P1", "smoothing"): 0.2}


def test_what_was_smoothed_survives_a_kill(session, tmp_path):
    with start(session, "wait", tmp_path) as process:
        assert process.stdout.readline() == "smoothed\n"
        process.kill()
        process.communicate(timeout=60)
    with Session.open(session) as kept:
        assert kept.recovery is not None
        assert kept.state.settings == {("P1", "smoothing"): 0.2}
        assert kept.undo() == "the smoothing of pass P1"


def test_what_the_window_loads_before_it_shows_is_light():
    code = (
        "import sys, georibbon.gui.app, georibbon.gui.window\n"
        "heavy = {'scipy', 'vtkmodules', 'pyqtgraph', 'numpy', 'matplotlib'}\n"
        "print(sorted(heavy & {name.partition('.')[0] for name in sys.modules}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
