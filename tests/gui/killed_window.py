"""A window in a process of its own that captures until it is killed, and tells what it has told.

Each line of its output was shown to the person before it was printed.
"""

import sys
from pathlib import Path

import pytest
from quick_ribbon import quicken

from georibbon.gui.app import make_application
from georibbon.gui.connect.choice import VirtualChoice
from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import Settings
from georibbon.gui.window import MainWindow
from georibbon.simulation.capture import error_streams, make_bench

FASTER = 5.0
PASSES = 4
MIDDLE = 0.2  # s that a ribbon has lain still in the middle of being taken
NOTE = "the second one slipped a little"


def calibration_of_today():
    """The true one of the virtual ribbon that the start page offers."""
    simulation = VirtualChoice().settings().simulation
    return make_bench(simulation, error_streams(simulation.seed)).calibration


class Capturing:
    """Everything that is asked for is laid by itself; what is taken is told."""

    def __init__(self, window: MainWindow) -> None:
        self.window = window
        window.station.identified.connect(self.begin)
        window.capture.began.connect(self.follow)
        window.capture.happened.connect(self.tell)
        window.capture.refreshed.connect(self.look)
        window.connect_virtual()

    def begin(self, _identity) -> None:
        """A capture with a calibration."""
        self.window.show_page("capture")
        page = self.window.pages.page("capture")
        page.use_calibration(calibration_of_today(), "of today")
        page.plan.title.setText("bonnet")
        page.plan.passes.setValue(PASSES)
        page.plan.ties.setValue(0)
        page.plan.start.click()

    def follow(self) -> None:
        """The hands lay it."""
        print(f"began {self.window.capture.session.path}", flush=True)
        self.window.hands.pause.setValue(0.0)
        self.window.hands.set_follow(True)

    def tell(self, happening) -> None:
        """As it is told in the window."""
        print(f"{happening.kind} {happening.message}", flush=True)
        if happening.kind == "taken" and happening.subject == "P2":
            self.window.capture.set_auto(False)  # the third one waits for a key
            self.window.capture.note(NOTE)
            self.window.hands.enter_survey()

    def look(self, glance) -> None:
        """The third pass lies still, and nobody has pressed the key yet."""
        current, still = self.window.capture.current, glance.live.stillness
        third = current is not None and current.key == "P3" and self.window.capture.survey["mark"]
        if third and still is not None and still.seconds > MIDDLE:
            print("middle of P3", flush=True)


def main(folder: Path) -> int:
    """Capture in a folder until it is killed."""
    with pytest.MonkeyPatch.context() as patch:
        quicken(patch, FASTER)
        application = make_application()
        settings = Settings(folder / "settings.ini")
        settings.folder = folder
        settings.sound = False
        window = MainWindow(settings, Notifier())
        window.show()
        capturing = Capturing(window)
        code = application.exec()
        del capturing
        return code


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
