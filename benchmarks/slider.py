"""How many times a second the surface follows a smoothing slider: 5 passes of 32 sensors.

Two figures, each for the slider of one pass and for that of all:

- the computation alone, from new settings to curves and surface, in time of one
  processor;
- with a display (an X server; `xvfb-run` makes one), the whole window as the
  program shows it: the slider is moved every 8 ms, as a fast mouse does, and
  counted is every painted picture of the 3D view that shows a newer surface
  than the picture before.  On a machine that does something else as well the
  processor's time of an update tells more than how many there were.

Beside them: how far a preview lies from the whole reconstruction, in mm and in
standard deviations, and how long the whole reconstruction on release takes.

    .venv/bin/python benchmarks/slider.py [--seconds S] [--no-window]
    xvfb-run -a -s "-screen 0 1600x1200x24" .venv/bin/python benchmarks/slider.py
"""

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from support.tables import met, publish, table

from georibbon.reconstruction import Reconstruction, ReconstructionSettings, Stages, reconstruct
from georibbon.reconstruction_preview import preview
from georibbon.recording import Recording
from georibbon.simulation import SimulationSettings, simulate

if TYPE_CHECKING:
    from georibbon.gui.window import MainWindow

ASKED = 30.0  # updates a second
CLOSE = 0.1  # standard deviations
FROM, TO = 0.04, 0.35  # m: from finer than the readings support to coarser
WAY = 60  # places of the slider there and back
MOVE_MS = 8
CORES = 2  # asked for
LONGEST_WAIT = 30.0
ONE, ALL = "P3", "*"
WHOSE = {ONE: "one pass", ALL: "all passes"}
HEADER = ("figure", "asked", "measured", "verdict")
Row = tuple[str, str, str, str]


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seconds", type=float, default=6.0, help="a figure of the window takes")
    parser.add_argument("--no-window", action="store_true", help="the computation alone")
    asked = parser.parse_args()
    recording = simulate(SimulationSettings()).recording
    rows = computation(recording)
    load = f", load {os.getloadavg()[0]:.1f} before" if hasattr(os, "getloadavg") else ""
    note = f"{os.cpu_count()} cores{load}."
    if asked.no_window or not has_display():
        note += " The window was not measured: there is no display, or it was not asked for."
    else:
        rows += window(recording, asked.seconds)
    publish("slider", [table(HEADER, rows), note])


def has_display() -> bool:
    """Whether a window can be shown."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY"))


def places() -> list[float]:
    """The smoothing lengths that the slider goes through, there and back again."""
    there = np.geomspace(FROM, TO, WAY)
    return [float(one) for one in (*there, *there[::-1])]


# The computation


def computation(recording: Recording) -> list[Row]:
    """Updates a second, the error and the time on release, for one pass and for all."""
    rows = []
    for whose, words in WHOSE.items():
        stages = Stages()
        reconstruct(recording, stages=stages)
        seconds = [previewed(recording, whose, one, stages)[0] for one in places()]
        rate = 1.0 / float(np.median(seconds))
        slowest = float(np.quantile(seconds, 0.95))
        rows += [
            row(f"computation, {words}: updates a second (median)", f">= {ASKED:.0f}", rate, ASKED),
            row(f"computation, {words}: ms for 95 of 100", "<= 33", 1e3 * slowest, 33.0, most=True),
        ]
        millimetres, sigmas = errors(recording, whose, stages)
        rows.append(
            (
                f"preview, {words}: farthest from the whole",
                f"<= {CLOSE:g} sigma",
                f"{sigmas:.3f} sigma, {millimetres:.4f} mm",
                met(sigmas <= CLOSE),
            )
        )
        begin = time.process_time()
        reconstruct(recording, ReconstructionSettings(smoothing={whose: TO}), stages=stages)
        whole = 1e3 * (time.process_time() - begin)
        rows.append((f"whole, {words}: ms on release", "", f"{whole:.0f}", ""))
    return rows


def row(figure: str, asked: str, measured: float, limit: float, *, most: bool = False) -> Row:
    """A line of the table."""
    fine = measured <= limit if most else measured >= limit
    return figure, asked, f"{measured:.1f}", met(fine)


def previewed(
    recording: Recording, whose: str, length: float, stages: Stages
) -> tuple[float, Reconstruction]:
    """Seconds of the processor that a preview takes, and what it shows."""
    settings = ReconstructionSettings(smoothing={whose: length})
    begin = time.process_time()
    shown = preview(recording, settings, None, stages)
    return time.process_time() - begin, shown


def errors(recording: Recording, whose: str, stages: Stages) -> tuple[float, float]:
    """How far previews lie from whole reconstructions at most: mm, standard deviations."""
    whole = Stages()
    apart, ratio = 0.0, 0.0
    for length in places()[:WAY:6]:
        _, shown = previewed(recording, whose, length, stages)
        settings = ReconstructionSettings(smoothing={whose: length})
        exact = reconstruct(recording, settings, stages=whole)
        for one, other in zip(shown.passes, exact.passes, strict=True):
            away = np.linalg.norm(one.strip.points - other.strip.points, axis=1)
            apart = max(apart, 1e3 * float(away.max()))
            ratio = max(ratio, float((away / other.position_sigma).max()))
    return apart, ratio


# The window


def window(recording: Recording, seconds: float) -> list[Row]:
    """Pictures a second that show a newer surface, while sliders of the window move."""
    from georibbon.gui.app import make_application
    from georibbon.gui.notifier import Notifier
    from georibbon.gui.settings import Settings
    from georibbon.session.file import create_session

    application = make_application()
    with tempfile.TemporaryDirectory() as folder:
        session = Path(folder) / "slider.georibbon"
        create_session(session, recording)
        from georibbon.gui.window import MainWindow

        shown = MainWindow(Settings(Path(folder) / "settings.ini"), Notifier())
        shown.show()
        wait_for(shown.document.reconstructed, lambda: shown.open(session))
        rows = []
        for whose, words in WHOSE.items():
            rate, main_thread, every = dragged(shown, whose, seconds)
            limits = 1e3 / ASKED, 1e3 * CORES / ASKED
            rows += [
                row(f"window, {words}: updates painted a second", f">= {ASKED:.0f}", rate, ASKED),
                row(
                    f"window, {words}: ms of the main thread's processor an update",
                    f"<= {limits[0]:.0f}", main_thread, limits[0], most=True,
                ),
                row(
                    f"window, {words}: ms of all threads' processors an update",
                    f"<= {limits[1]:.0f}", every, limits[1], most=True,
                ),
            ]  # fmt: skip
        shown.close()
        application.processEvents()
    return rows


def wait_for(signal: object, act: object) -> None:
    """Do something and go on when the signal has come."""
    from PySide6.QtCore import QEventLoop, QTimer

    loop = QEventLoop()
    signal.connect(loop.quit)  # type: ignore[attr-defined]  # any bound signal
    QTimer.singleShot(int(1e3 * LONGEST_WAIT), loop.quit)
    act()  # type: ignore[operator]  # any function
    loop.exec()


def dragged(shown: "MainWindow", whose: str, seconds: float) -> tuple[float, float, float]:
    """Updates a second that are painted while a slider is held and moved.

    And the processor's time of each, ms: the main thread's, and that of all threads.
    """
    from PySide6.QtCore import QEventLoop, QTimer

    slider = shown.passes_panel.control(whose).slider
    painted = painted_updates(shown)
    loop, mover = QEventLoop(), QTimer()
    steps = way_of(slider.value())
    mover.timeout.connect(lambda: slider.setSliderPosition(next(steps)))
    slider.setSliderDown(True)
    mover.start(MOVE_MS)
    begun: list[float] = []

    def begin() -> None:  # the first second loads and warms up
        painted.clear()
        begun.extend((time.thread_time(), time.process_time()))

    QTimer.singleShot(1000, begin)
    QTimer.singleShot(int(1000 * (1 + seconds)), loop.quit)
    loop.exec()
    mover.stop()
    count = len(painted)
    main_thread, every = (
        1e3 * (now - then) / max(count, 1)
        for now, then in zip((time.thread_time(), time.process_time()), begun, strict=True)
    )
    wait_for(shown.document.reconstructed, lambda: slider.setSliderDown(False))
    wait_for(shown.document.reconstructed, shown.document.reset_smoothing)
    return count / seconds, main_thread, every


def way_of(here: int) -> Iterator[int]:
    """Steps of the slider to the finest, to the coarsest and back, one after the other."""
    from georibbon.gui.smoothing import to_step

    low, high, step = to_step(FROM), to_step(TO), 1
    while True:
        here += step
        if not low <= here <= high:
            step = -1 if here > high else 1
            here = min(max(here, low), high)
        yield here


def painted_updates(shown: "MainWindow") -> list[float]:
    """Times at which a picture was painted that shows another surface than the last."""
    from PySide6.QtCore import QEvent, QObject

    times: list[float] = []
    waiting: list[object] = []

    class Watch(QObject):
        """Notes paintings after something new was shown."""

        def eventFilter(self, _watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
            if event.type() == QEvent.Type.Paint and waiting:
                waiting.clear()
                times.append(time.perf_counter())
            return False

    watch = Watch(shown)
    shown.view.installEventFilter(watch)
    shown.document.previewed.connect(waiting.append)
    return times


if __name__ == "__main__":
    main()
