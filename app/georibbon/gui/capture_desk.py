"""The capture that is going on: its engine in a thread of its own, its verbs and news for pages.

The thread takes every frame of the link, feeds the engine, and does what pages
ask for, one after the other; nothing of it waits for a window that is busy.
What pages are told comes on the main thread.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

from PySide6.QtCore import QCoreApplication, QObject, Qt, Signal, Slot

from georibbon.errors import GeoribbonError
from georibbon.gui.language import tr

if TYPE_CHECKING:
    from georibbon.calibration.model import Calibration
    from georibbon.capture.checklist import Item
    from georibbon.capture.engine import Engine, Live
    from georibbon.capture.ledger import Happening
    from georibbon.capture.plan import CapturePlan
    from georibbon.device.identity import Identity
    from georibbon.device.ring import Tap
    from georibbon.gui.document import Document
    from georibbon.gui.station.station import Station
    from georibbon.recording import PassKind
    from georibbon.ribbon import Ribbon
    from georibbon.session.session import Session

TICK = 0.02  # s, at most, from a frame or a verb to its being seen to
GLANCE = 0.04  # s from one glance to the next, at least
LONGEST_END = 10.0  # s for the thread: a calibration may be on its way
QUIET = frozenset(("chosen", "refused", "quality", "held", "saved", "link", "complete"))
Verb = Callable[["Engine"], object]


@dataclass(frozen=True, eq=False)
class Glance:
    """The newest state of the ribbon: stillness and live curve, and frames per second."""

    live: Live
    frames_per_second: float


@dataclass(frozen=True, eq=False)
class Standing:
    """How the capture stands: all items, what is asked for, and what it goes by.

    survey: as in a recording, lists of "mark", "distance" and "crossing".
    """

    plan: CapturePlan
    items: tuple[Item, ...]
    current: Item | None
    calibration: Calibration | None
    survey: Mapping[str, Sequence[Mapping[str, object]]]
    auto: bool


class _Thread(threading.Thread):
    """The engine's owner: it opens the session, and does everything with the engine."""

    def __init__(
        self, desk: CaptureDesk, make: Callable[[], Engine], tap: Tap, ribbon: Ribbon
    ) -> None:
        super().__init__(name="capture", daemon=True)
        self._desk, self._make = desk, make
        self.tap, self.ribbon = tap, ribbon
        self.diary = desk.station.diary
        self.verbs: SimpleQueue[Verb] = SimpleQueue()
        self.ending = threading.Event()
        self.unseen = False  # whether the last glance waits for a window that is busy
        self._glanced = 0.0

    def run(self) -> None:
        """Until it is told to end, and all that was asked for is done."""
        desk = self._desk
        try:
            engine = self._made()
            if engine is not None:
                engine.observe(desk._news.emit)
                desk._opened.emit(self, engine.session, self._standing(engine))
                while not self.ending.is_set():
                    self._turn(engine)
                self._obey(engine)
        except Exception as error:  # a fault of ours: the session is whole, the capture is over
            desk._broke.emit(self, error)
        finally:
            self.tap.close()

    def _made(self) -> Engine | None:
        try:
            return self._make()
        except GeoribbonError as error:
            self._desk._could_not.emit(self, str(error))
            return None

    def _turn(self, engine: Engine) -> None:
        tap = self.tap
        if tap.closed:  # the ribbon was let go of: another connection may come
            self.ending.wait(TICK)
        else:
            tap.wait(TICK)
        frames = tap.take()
        before = self._standing(engine)
        self._try(lambda: engine.feed(frames))
        for entry in self.diary.take():
            self._try(lambda: engine.link_news(entry))  # noqa: B023 - it is called at once
        self._obey(engine)
        self._tell(engine, before)
        if time.monotonic() - self._glanced >= GLANCE and not self.unseen:
            self._glanced = time.monotonic()
            self.unseen = True
            self._desk._glanced.emit(engine.refresh())

    def _obey(self, engine: Engine) -> None:
        while True:
            try:
                verb = self.verbs.get_nowait()
            except Empty:
                return
            before = self._standing(engine)
            self._try(lambda: verb(engine))  # noqa: B023 - it is called at once
            self._tell(engine, before)

    def _try(self, what: Callable[[], object]) -> None:
        try:
            what()
        except GeoribbonError as error:
            self._desk.refused.emit(str(error))

    def _tell(self, engine: Engine, before: Standing) -> None:
        now = self._standing(engine)
        if _differ(before, now):
            self._desk._stood.emit(now)

    @staticmethod
    def _standing(engine: Engine) -> Standing:
        return Standing(
            engine.plan,
            engine.items,
            engine.current,
            engine.calibration,
            engine.survey.tables(),
            engine.auto,
        )


def _differ(one: Standing, other: Standing) -> bool:
    return (
        one.calibration is not other.calibration
        or one.auto != other.auto
        or one.plan != other.plan
        or one.current != other.current
        or one.items != other.items
        or one.survey != other.survey
    )


class CaptureDesk(QObject):
    """One capture at a time, by the ribbon that the station is connected to.

    began(), ended().  failed(sentence): a capture could not begin.
    refreshed(Glance): the newest state, at most 25 a second.
    happened(Happening): what the engine tells.  refused(sentence): a verb that
    was not done.  stood(): items, what is asked for, survey, calibration or plan
    have changed.  changed(): the session holds something else than before.
    fault(exception): the capture ended by a fault of ours; the session is whole.
    """

    began = Signal()
    ended = Signal()
    failed = Signal(str)
    refreshed = Signal(object)
    happened = Signal(object)
    refused = Signal(str)
    stood = Signal()
    changed = Signal()
    fault = Signal(object)
    _could_not = Signal(object, str)
    _broke = Signal(object, object)
    _opened = Signal(object, object, object)
    _stood = Signal(object)
    _news = Signal(object)
    _glanced = Signal(object)

    def __init__(self, station: Station, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.station, self._document = station, document
        self._thread: _Thread | None = None
        self._session: Session | None = None
        self._standing: Standing | None = None
        queued = Qt.ConnectionType.QueuedConnection
        self._could_not.connect(self._not_begun, queued)
        self._broke.connect(self._broken, queued)
        self._opened.connect(self._begun, queued)
        self._stood.connect(self._take_standing, queued)
        self._news.connect(self._tell, queued)
        self._glanced.connect(self._glance, queued)
        station.identified.connect(self._take_link)

    # How it stands

    @property
    def active(self) -> bool:
        """Whether a capture is going on."""
        return self._session is not None

    @property
    def beginning(self) -> bool:
        """Whether one is about to."""
        return self._thread is not None and self._session is None

    @property
    def session(self) -> Session | None:
        """The session that is captured into."""
        return self._session

    @property
    def plan(self) -> CapturePlan | None:
        """What is planned."""
        return None if self._standing is None else self._standing.plan

    @property
    def items(self) -> tuple[Item, ...]:
        """All poses, passes and ties, and how they stand."""
        return () if self._standing is None else self._standing.items

    @property
    def current(self) -> Item | None:
        """What is asked for now."""
        return None if self._standing is None else self._standing.current

    @property
    def calibration(self) -> Calibration | None:
        """What the readings are taken by; None before there is one."""
        return None if self._standing is None else self._standing.calibration

    @property
    def survey(self) -> Mapping[str, Sequence[Mapping[str, object]]]:
        """Lists of "mark", "distance" and "crossing", as in a recording."""
        return {} if self._standing is None else self._standing.survey

    @property
    def auto(self) -> bool:
        """Whether what lies still as asked is taken by itself."""
        return self._standing is not None and self._standing.auto

    # Its beginning and its end

    def begin(
        self,
        path: Path,
        plan: CapturePlan | None = None,
        calibration: Calibration | None = None,
        auto: bool = True,
    ) -> None:
        """Capture into a new session, or go on with the one that is there or open.

        plan: the session's own, or the usual one, where None.  What becomes of it is
        told by `began` or `failed`.
        """
        identity = self.station.identity
        if self._thread is not None:
            self.failed.emit(tr("A capture is going on already; end it first."))
        elif identity is None or self.station.link is None:
            self.failed.emit(tr("No ribbon is connected; connect one first."))
        else:
            open_one = self._document.session
            here = self._document.path
            same = open_one is not None and here is not None and here.resolve() == path.resolve()
            session = open_one if same else None
            make = _engine(path, session, identity, plan, calibration, auto)
            self._thread = _Thread(self, make, self.station.recorder(), identity.ribbon)
            self._thread.start()

    def end(self) -> None:
        """End the capture; the session stays open, and can be gone on with at any time."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.ending.set()
        thread.join(LONGEST_END)
        if thread.is_alive():  # it still holds the session, which waits for it when it is closed
            self.fault.emit(
                RuntimeError(f"the capture's thread has not ended in {LONGEST_END:g} s")
            )
        QCoreApplication.sendPostedEvents(self)  # what it told until its end
        self._over()

    def _over(self) -> None:
        active = self.active
        self._session = self._standing = None
        if active:
            self.ended.emit()

    # Verbs, done one after the other in the engine's thread

    def choose(self, key: str) -> None:
        """Ask for a pose or pass next; one that was taken is repeated."""
        self._do(lambda engine: engine.choose(key))

    def add(self, name: str, kind: PassKind) -> None:
        """Ask for a further pass or tie, beyond the plan."""
        self._do(lambda engine: engine.add(name, kind))

    def take(self, force: bool = False) -> None:
        """Take what is asked for; force: although something that may be forced speaks against."""
        self._do(lambda engine: engine.take(force))

    def skip(self) -> None:
        """Leave out what is asked for now."""
        self._do(lambda engine: engine.skip())

    def remove(self, key: str) -> None:
        """Take a pose or pass out of the session again."""
        self._do(lambda engine: engine.remove(key))

    def reorder(self, names: Sequence[str]) -> None:
        """Put the passes and ties that were taken into another order."""
        self._do(lambda engine: engine.reorder(names))

    def set_plan(self, plan: CapturePlan) -> None:
        """Go on by another plan."""
        self._do(lambda engine: engine.replan(plan))

    def undo(self) -> None:
        """Take back the last change."""
        self._do(lambda engine: engine.undo())

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._do(lambda engine: engine.redo())

    def note(self, text: str) -> None:
        """Keep a note with its time."""
        self._do(lambda engine: engine.note(text))

    def set_auto(self, auto: bool) -> None:
        """Take by stillness, or only when asked."""
        self._do(lambda engine: setattr(engine, "auto", auto))

    def use_calibration(self, calibration: Calibration) -> None:
        """Use a calibration that was made before."""
        self._do(lambda engine: engine.use_calibration(calibration))

    def calibrate(self) -> None:
        """Calibrate from the poses taken so far."""
        self._do(lambda engine: engine.calibrate())

    def add_survey(self, table: str, entry: Mapping[str, object]) -> None:
        """Add a mark, distance or crossing, given as in a recording."""
        self._do(lambda engine: engine.survey.add(table, entry))

    def add_surveys(self, entries: Sequence[tuple[str, Mapping[str, object]]]) -> None:
        """Add several, each with its table, in one step of undo."""
        self._do(lambda engine: engine.survey.add_all(entries))

    def change_survey(self, table: str, number: int, entry: Mapping[str, object]) -> None:
        """Put an entry in the place of the one with a number, from 1."""
        self._do(lambda engine: engine.survey.change(table, number, entry))

    def remove_survey(self, table: str, number: int) -> None:
        """Take the entry with a number, from 1, out of a table."""
        self._do(lambda engine: engine.survey.remove(table, number))

    def save_to(self, path: Path) -> None:
        """Go on in another place, with everything that is held in memory."""
        self._do(lambda engine: engine.save_to(path))

    def save_again(self) -> None:
        """Try once more to write what is held in memory."""
        self._do(lambda engine: engine.save_again())

    def _do(self, verb: Verb) -> None:
        if self._thread is not None:
            self._thread.verbs.put(verb)
        else:
            self.refused.emit(tr("No capture is going on; begin one first."))

    # What comes of it, on the main thread

    @Slot(object, object, object)
    def _begun(self, thread: _Thread, session: Session, standing: Standing) -> None:
        if thread is not self._thread:  # it was ended before it had begun
            if session is not self._document.session:
                session.close()
            return
        if session is not self._document.session and not self._document.adopt(session):
            self.end()
            session.close()
            self.failed.emit(tr("What is open could not be closed; see what is told of it."))
            return
        self._session, self._standing = session, standing
        self.began.emit()
        self.stood.emit()
        self.changed.emit()

    @Slot(object, str)
    def _not_begun(self, thread: _Thread, sentence: str) -> None:
        if thread is self._thread:
            self.end()
            self.failed.emit(sentence)

    @Slot(object, object)
    def _broken(self, thread: _Thread, error: Exception) -> None:
        if thread is self._thread:
            self.end()
            self.fault.emit(error)

    @Slot(object)
    def _take_standing(self, standing: Standing) -> None:
        if self.active:
            self._standing = standing
            self.stood.emit()

    @Slot(object)
    def _tell(self, happening: Happening) -> None:
        if self.active:
            self.happened.emit(happening)
            if happening.kind not in QUIET:
                self.changed.emit()

    @Slot(object)
    def _glance(self, live: Live) -> None:
        if self._thread is not None:
            self._thread.unseen = False
        if self.active:
            health = self.station.health()
            rate = 0.0 if health is None else health.frames_per_second
            self.refreshed.emit(Glance(live, rate))

    @Slot(object)
    def _take_link(self, identity: Identity) -> None:
        """Another connection: its frames go into the capture that is going on."""
        thread = self._thread
        if thread is None or not thread.is_alive() or thread.diary is self.station.diary:
            return
        from georibbon.device.identity import check_same

        try:
            check_same(identity.ribbon, thread.ribbon)
        except GeoribbonError as error:
            self.refused.emit(str(error))
            return
        tap, diary = self.station.recorder(), self.station.diary

        def take_up(engine: Engine) -> None:
            engine.interrupted()
            thread.tap.close()
            thread.tap, thread.diary = tap, diary

        thread.verbs.put(take_up)


def _engine(
    path: Path,
    session: Session | None,
    identity: Identity,
    plan: CapturePlan | None,
    calibration: Calibration | None,
    auto: bool,
) -> Callable[[], Engine]:
    """How the engine is made, in its own thread; session: the one that is open already."""

    def make() -> Engine:
        from georibbon.capture.engine import Engine
        from georibbon.capture.start import go_on, open_capture

        if session is None:
            opened, chosen = open_capture(path, identity, plan)
        else:
            opened, chosen = session, go_on(session, identity, plan)
        try:
            engine = Engine(opened, chosen, auto=auto)
            if calibration is not None:
                engine.use_calibration(calibration)
        except BaseException:
            if session is None:
                opened.close()
            raise
        return engine

    return make
