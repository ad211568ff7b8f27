"""Cold start: from the process's begin to the first painted, usable window.

Beside it, by turns and in fresh processes, a bare PySide6 window with an empty VTK view
and an empty pyqtgraph plot.  All is byte-compiled before.  Without a display it gives
itself one by xvfb-run; where there is none of that either, Qt's platform without a
display stands in, and the table says so.
"""

import argparse
import compileall
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from support.tables import met, publish, table

ROOT = Path(__file__).resolve().parents[1]
ASKED = 1.3

# Prints the monotonic clock as soon as the first window was painted and events are seen to again.
WATCH = """
import os, time
from PySide6.QtCore import QEvent, QObject, QTimer
class Watch(QObject):
    def eventFilter(self, watched, event):
        if event.type() == QEvent.Type.Paint and watched.isWidgetType() and watched.isWindow():
            application.removeEventFilter(self)
            QTimer.singleShot(0, done)
        return False
def done():
    print(time.monotonic(), flush=True)
    os._exit(0)
def watch(made):
    global application, watcher
    application, watcher = made, Watch()
    made.installEventFilter(watcher)
"""
OURS = (
    WATCH
    + """
from georibbon.cli import main
from georibbon.gui import app
make = app.make_application
def watched(*words):
    made = make(*words)
    watch(made)
    return made
app.make_application = watched
main([])
"""
)
BARE = (
    WATCH
    + """
import pyqtgraph
import vtkmodules.vtkInteractionStyle
import vtkmodules.vtkRenderingOpenGL2
from PySide6.QtWidgets import QApplication, QMainWindow, QSplitter
from vtkmodules.qt.QVTKRenderWindowInteractor import QVTKRenderWindowInteractor
from vtkmodules.vtkRenderingCore import vtkRenderer
made = QApplication(["bare"])
watch(made)
window, split = QMainWindow(), QSplitter()
view = QVTKRenderWindowInteractor(split)
view.GetRenderWindow().AddRenderer(vtkRenderer())
split.addWidget(view)
split.addWidget(pyqtgraph.PlotWidget())
window.setCentralWidget(split)
window.resize(1280, 800)
view.Initialize()
window.show()
made.exec()
"""
)
PLAIN = (
    WATCH
    + """
from PySide6.QtWidgets import QApplication, QMainWindow
made = QApplication(["plain"])
watch(made)
window = QMainWindow()
window.resize(1280, 800)
window.show()
made.exec()
"""
)


def once(code: str, home: Path) -> float:
    """Seconds from the begin of a process to its window."""
    environment = os.environ | {
        "HOME": str(home),
        "XDG_CONFIG_HOME": str(home),
        "XDG_DATA_HOME": str(home),
        "XDG_STATE_HOME": str(home),
    }
    begin = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment, cwd=home, capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return float(done.stdout.split()[-1]) - begin


def measure(rounds: int) -> dict[str, list[float]]:
    """Seconds of each, by turns."""
    codes = {"georibbon": OURS, "bare": BARE, "plain": PLAIN}
    found: dict[str, list[float]] = {name: [] for name in codes}
    with tempfile.TemporaryDirectory() as home:
        for code in codes.values():  # the first of each fills the machine's caches
            once(code, Path(home))
        for _ in range(rounds):
            for name, code in codes.items():
                found[name].append(once(code, Path(home)))
    return found


def report(found: dict[str, list[float]], where: str) -> list[str]:
    """The tables."""
    median = {name: statistics.median(times) for name, times in found.items()}
    words = {
        "georibbon": "`georibbon`, its start page",
        "bare": "bare PySide6 window, empty VTK view, empty plot",
        "plain": "PySide6 window with nothing in it",
    }
    ratios = [a / b for a, b in zip(found["georibbon"], found["bare"], strict=True)]
    ratio = statistics.median(ratios)
    rows = [
        [words[name], f"{median[name]:.2f} s", f"{min(times):.2f} s", f"{max(times):.2f} s"]
        for name, times in found.items()
    ]
    return [
        f"# Cold start ({where}, {len(ratios)} rounds, fresh processes by turns)",
        table(["to the first painted window", "median", "least", "most"], rows),
        table(
            ["figure", "asked", "measured", "verdict"],
            [
                [
                    "georibbon to the bare window with VTK and plot",
                    f"≤ {ASKED}", f"{ratio:.2f}", met(ratio <= ASKED),
                ]
            ],
        ),
    ]  # fmt: skip


def main() -> None:
    """Measure, print, keep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    where = "on this display"
    if not os.environ.get("DISPLAY") and sys.platform.startswith("linux"):
        screen = shutil.which("xvfb-run")
        if screen is not None:
            words = [
                screen,
                "-a",
                "-s",
                "-screen 0 1600x1200x24 -noreset",
                sys.executable,
                *sys.argv,
            ]
            os.execv(screen, words)  # noqa: S606 - itself, on a display
        os.environ["QT_QPA_PLATFORM"] = "offscreen"
        where = "without a display"
    compileall.compile_dir(ROOT / "app", quiet=1)
    publish("start", report(measure(rounds), where))


if __name__ == "__main__":
    main()
