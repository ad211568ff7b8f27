"""A capture without a port, a thread or real time: the engine on a virtual ribbon, under a page."""

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from georibbon.calibration.model import Calibration
from georibbon.capture.engine import Engine
from georibbon.capture.start import go_on, open_capture
from georibbon.device.identity import Identity
from georibbon.device.telling import LinkState
from georibbon.errors import GeoribbonError
from georibbon.gui.capture_desk import QUIET, Glance
from georibbon.gui.document import Document
from georibbon.gui.notifier import Notifier
from georibbon.gui.parts import Parts
from georibbon.gui.settings import Settings
from georibbon.gui.units import Units
from georibbon.simulation.capture import error_streams, make_bench
from georibbon.simulation.settings import (
    LayoutSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
)
from georibbon.virtual.ribbon import VirtualRibbon
from georibbon.virtual.settings import VirtualSettings

SPACING = 0.08
SIMULATION = SimulationSettings(
    surface="dome",
    ribbon=RibbonSettings(sensors=12, length=0.48, rate=50.0),
    layout=LayoutSettings(passes=4, ties=2, spacing=SPACING),
    survey=SurveySettings(kinds=()),
)


def virtual_ribbon() -> VirtualRibbon:
    """Its clock stands still but for the frames that are drawn."""
    return VirtualRibbon(VirtualSettings(SIMULATION, pace=0.1), clock=lambda: 0.0)


def true_calibration() -> Calibration:
    """The virtual ribbon's own models."""
    return make_bench(SIMULATION, error_streams(SIMULATION.seed)).calibration


class FakeStation(QObject):
    """A link that is always there, until a test says otherwise."""

    identified = Signal(object)
    disconnected = Signal()
    changed = Signal(object, str)

    def __init__(self, ribbon: VirtualRibbon) -> None:
        super().__init__()
        self.identity: Identity | None = Identity(ribbon.ribbon, "1.0")
        self.state = LinkState.STREAMING

    def tell(self, state: LinkState, reason: str) -> None:
        """The link is otherwise."""
        self.state = state
        self.changed.emit(state, reason)


class FakeDesk(QObject):
    """As the capture desk, all in the test's own thread."""

    began = Signal()
    ended = Signal()
    failed = Signal(str)
    refreshed = Signal(object)
    happened = Signal(object)
    refused = Signal(str)
    stood = Signal()
    changed = Signal()
    fault = Signal(object)

    def __init__(self, station: FakeStation, document: Document) -> None:
        super().__init__()
        self.station, self.document = station, document
        self.engine: Engine | None = None
        self.done: list[str] = []

    active = property(lambda self: self.engine is not None)
    beginning = False
    session = property(lambda self: self.engine.session if self.engine else None)
    plan = property(lambda self: self.engine.plan if self.engine else None)
    items = property(lambda self: self.engine.items if self.engine else ())
    current = property(lambda self: self.engine.current if self.engine else None)
    calibration = property(lambda self: self.engine.calibration if self.engine else None)
    survey = property(lambda self: self.engine.survey.tables() if self.engine else {})
    auto = property(lambda self: bool(self.engine and self.engine.auto))

    def begin(self, path, plan=None, calibration=None, auto=True):
        """At once."""
        session = self.document.session
        try:
            if session is not None and session.path == path:
                plan = go_on(session, self.station.identity, plan)
            else:
                session, plan = open_capture(path, self.station.identity, plan)
            self.engine = Engine(session, plan, auto=auto)
            self.engine.observe(self._tell)
            if calibration is not None:
                self.engine.use_calibration(calibration)
        except GeoribbonError as error:
            self.engine = None
            if session is not self.document.session:
                session.close()
            self.failed.emit(str(error))
            return
        if session is not self.document.session:
            assert self.document.adopt(session)
        self.began.emit()
        self.stood.emit()
        self.changed.emit()

    def end(self):
        """The session stays open in the document."""
        self.engine = None
        self.ended.emit()

    def __getattr__(self, name):
        verbs = {"choose", "add", "take", "skip", "remove", "reorder", "undo", "redo", "note",
                 "use_calibration", "calibrate", "save_to", "save_again"}  # fmt: skip
        if name not in verbs:
            raise AttributeError(name)
        return lambda *args: self._do(name, lambda: getattr(self.engine, name)(*args))

    def set_plan(self, plan):
        """Go on by another plan."""
        self._do("set_plan", lambda: self.engine.replan(plan))

    def set_auto(self, auto):
        """By stillness or by hand."""
        self._do("set_auto", lambda: setattr(self.engine, "auto", auto))

    def add_survey(self, table, entry):
        """One entry."""
        self._do("add_survey", lambda: self.engine.survey.add(table, entry))

    def add_surveys(self, entries):
        """Several."""
        self._do("add_surveys", lambda: self.engine.survey.add_all(entries))

    def change_survey(self, table, number, entry):
        """One corrected."""
        self._do("change_survey", lambda: self.engine.survey.change(table, number, entry))

    def remove_survey(self, table, number):
        """One taken out."""
        self._do("remove_survey", lambda: self.engine.survey.remove(table, number))

    def _do(self, name, verb):
        self.done.append(name)
        try:
            verb()
        except GeoribbonError as error:
            self.refused.emit(str(error))
        self.stood.emit()

    def _tell(self, happening):
        self.happened.emit(happening)
        if happening.kind not in QUIET:
            self.changed.emit()

    def feed(self, frames):
        """Frames come, in blocks, and a glance after them."""
        for start in range(0, len(frames), 10):
            self.engine.feed(frames[start : start + 10])
        self.stood.emit()
        self.refreshed.emit(Glance(self.engine.refresh(), 100.0))


@dataclass(eq=False)
class Bench:
    """Everything below a page, and a hand on the ribbon."""

    parts: Parts
    ribbon: VirtualRibbon
    folder: Path

    @classmethod
    def at(cls, folder: Path) -> "Bench":
        """A bench whose files lie in a folder."""
        ribbon = virtual_ribbon()
        document, station = Document(), FakeStation(ribbon)
        desk = FakeDesk(station, document)
        settings = Settings(folder / "settings.ini")
        settings.sound = False
        settings.folder = folder
        desk.changed.connect(document.captured)
        return cls(Parts(settings, Notifier(), document, Units(), station, desk), ribbon, folder)

    def begin(self, plan, name="s.georibbon", auto=True):
        """A capture by a plan, calibrated."""
        self.parts.capture.begin(self.folder / name, plan, true_calibration(), auto)

    def do(self, *words, seconds=1.5):
        """Say words to the ribbon, each with its time."""
        for word in words:
            self.ribbon.do(word)
            frames = self.ribbon.frames(round(seconds * self.ribbon.ribbon.rate))
            self.parts.capture.feed(frames)

    def lay(self, *names):
        """Lay passes, one after another, each taken up and held still."""
        for name in names:
            self.do("lift", seconds=0.6)
            self.do(f"lay {name}", seconds=2.2)

    def end(self):
        """Nothing of it goes on."""
        if self.parts.capture.active:
            self.parts.capture.end()
        self.parts.document.end()
