"""A desk for tests: the engine fed by hand from a virtual ribbon, without thread, port or time."""

from types import SimpleNamespace

from PySide6.QtCore import QObject, Signal

from georibbon.capture.engine import Engine
from georibbon.capture.start import open_capture
from georibbon.device.identity import Identity
from georibbon.errors import GeoribbonError
from georibbon.gui.capture_desk import Glance
from georibbon.gui.document import Document
from georibbon.gui.notifier import Notifier
from georibbon.gui.parts import Parts
from georibbon.gui.settings import Settings
from georibbon.gui.units import Units
from georibbon.simulation.settings import (
    FaultSettings,
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
)
from georibbon.virtual.ribbon import VirtualRibbon
from georibbon.virtual.settings import VirtualSettings


def virtual(seed=1, sensors=12, poses=20, dead=()):
    """A virtual ribbon whose clock stands still but for the frames that are drawn."""
    simulation = SimulationSettings(
        seed=seed,
        ribbon=RibbonSettings(sensors=sensors),
        layout=LayoutSettings(passes=2),
        poses=PoseSettings(plan=poses),
        faults=FaultSettings(dead=tuple(dead)),
    )
    return VirtualRibbon(VirtualSettings(simulation, pace=0.2), clock=lambda: 0.0)


class Station(QObject):
    """A station with a ribbon at hand; connected where it is told so."""

    identified = Signal(object)
    disconnected = Signal()

    def __init__(self, ribbon):
        super().__init__()
        self.virtual, self.identity, self.frames = ribbon, None, []
        self.link = SimpleNamespace(ring=SimpleNamespace(last=lambda n: self.frames[-n:]))

    def connect_ribbon(self):
        self.identity = Identity(self.virtual.ribbon, "1.0")
        self.identified.emit(self.identity)

    def health(self):
        return None


class Desk(QObject):
    """What `CaptureDesk` is, done at once."""

    began, ended, stood, changed = Signal(), Signal(), Signal(), Signal()
    failed, refused = Signal(str), Signal(str)
    refreshed, happened = Signal(object), Signal(object)

    def __init__(self, station):
        super().__init__()
        self.station = station
        self.engine = self.session = None
        self.told = []
        self.happened.connect(self.told.append)

    @property
    def active(self):
        return self.engine is not None

    @property
    def beginning(self):
        return False

    @property
    def items(self):
        return () if self.engine is None else self.engine.items

    @property
    def current(self):
        return None if self.engine is None else self.engine.current

    @property
    def calibration(self):
        return None if self.engine is None else self.engine.calibration

    @property
    def auto(self):
        return self.engine is not None and self.engine.auto

    def begin(self, path, plan=None, calibration=None, auto=True):
        try:
            self.session, chosen = open_capture(path, self.station.identity, plan)
        except GeoribbonError as error:
            self.failed.emit(str(error))
            return
        self.engine = Engine(self.session, chosen, auto=auto)
        if calibration is not None:
            self.engine.use_calibration(calibration)
        self.engine.observe(self.happened.emit)
        self.began.emit()
        self.stood.emit()

    def end(self):
        if self.engine is not None:
            self.session.close()
            self.engine = self.session = None
            self.ended.emit()

    def _do(self, verb):
        if self.engine is None:
            self.refused.emit("No capture is going on; begin one first.")
            return
        try:
            verb(self.engine)
        except GeoribbonError as error:
            self.refused.emit(str(error))
        self.stood.emit()

    def choose(self, key):
        self._do(lambda engine: engine.choose(key))

    def take(self, force=False):
        self._do(lambda engine: engine.take(force))

    def skip(self):
        self._do(lambda engine: engine.skip())

    def undo(self):
        self._do(lambda engine: engine.undo())

    def redo(self):
        self._do(lambda engine: engine.redo())

    def set_auto(self, auto):
        self._do(lambda engine: setattr(engine, "auto", auto))


class Hands:
    """A ribbon in the hands of a test, and the parts that a page is given."""

    def __init__(self, folder, ribbon=None):
        self.ribbon = ribbon or virtual()
        self.station = Station(self.ribbon)
        self.desk = Desk(self.station)
        self.notifier, self.document = Notifier(), Document()
        settings = Settings(folder / "settings.ini")
        settings.sound = False
        self.parts = Parts(settings, self.notifier, self.document, Units(), self.station, self.desk)

    def pass_time(self, seconds):
        """Let the frames of so many seconds come."""
        frames = self.ribbon.frames(round(seconds * self.ribbon.ribbon.rate))
        for start in range(0, len(frames), 20):
            block = frames[start : start + 20]
            self.station.frames = [*self.station.frames[-100:], *block]
            if self.desk.engine is not None:
                self.desk.engine.feed(block)
        self.desk.stood.emit()
        if self.desk.engine is not None:
            self.desk.refreshed.emit(Glance(self.desk.engine.refresh(), 100.0))

    def lift(self):
        self.ribbon.do("lift")
        self.pass_time(0.7)

    def pose(self, number, seconds=2.2):
        """Lift the bar and lay it in a pose of the plan."""
        self.lift()
        self.ribbon.do(f"pose {number}")
        self.pass_time(seconds)

    def end(self):
        self.desk.end()
        self.document.end()
