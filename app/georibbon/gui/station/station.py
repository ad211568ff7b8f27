"""The station: what the window is connected to, told on the main thread.

The link has a thread of its own, and connections are made and closed in a
worker; both tell the station by queued signals, with the number of the
connection, so that nothing of an old one reaches those who watch the new one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QCoreApplication, QObject, QRunnable, Qt, QThreadPool, QTimer, Signal

from georibbon.device.telling import Change, Event, LinkState
from georibbon.errors import DeviceError, GeoribbonError
from georibbon.gui.language import tr
from georibbon.session.words import told

if TYPE_CHECKING:
    from georibbon.capture.link_diary import LinkDiary
    from georibbon.device.health import Health
    from georibbon.device.identity import Identity
    from georibbon.device.link import Link
    from georibbon.device.ring import Tap
    from georibbon.gui.station.connection import Connection, Way
    from georibbon.ribbon import Ribbon
    from georibbon.virtual import VirtualRibbon, VirtualSettings

HEALTH_EVERY = 250  # ms


class _Job(QRunnable):
    """Work in the worker thread; `done` is told the result, or the exception."""

    def __init__(self, work: Callable[[], object], done: Callable[..., None]) -> None:
        super().__init__()
        self._work, self._done = work, done

    def run(self) -> None:
        """Called by Qt in the worker thread; nothing may be raised from here."""
        try:
            result, error = self._work(), None
        except Exception as raised:
            result, error = None, raised
        self._done(result, error)


class Station(QObject):
    """The connection to one ribbon at a time; used on the main thread.

    identified(Identity): a ribbon answers for the first time, or says something
    new of itself.  changed(LinkState, reason): as the link tells it; a cable
    that was pulled is "disconnected" while the link tries on.  happened(Event).
    health_changed(Health): four times a second while there is a link.
    failed(sentence): no connection came about, and none is tried any more.
    disconnected(): there is no link any more.  fault(exception): ours.
    """

    identified = Signal(object)
    changed = Signal(object, str)
    happened = Signal(object)
    health_changed = Signal(object)
    failed = Signal(str)
    disconnected = Signal()
    fault = Signal(object)
    _made = Signal(int, object, object)
    _news = Signal(int, object)
    _closed = Signal(object, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._number = 0  # of the connection that is wanted
        self._connection: Connection | None = None
        self._identity: Identity | None = None
        self._state, self._reason = LinkState.DISCONNECTED, ""
        self._tries = self._ended = False
        self._pool = QThreadPool()
        self._pool.setMaxThreadCount(1)
        self._pulse = QTimer(self)
        self._pulse.setInterval(HEALTH_EVERY)
        self._pulse.timeout.connect(self._tell_health)
        queued = Qt.ConnectionType.QueuedConnection
        self._made.connect(self._begin, queued)
        self._news.connect(self._take, queued)
        self._closed.connect(self._after_close, queued)

    # --- what is there ---

    @property
    def link(self) -> Link | None:
        """The link; None where none is wanted, or it is being made."""
        return None if self._connection is None else self._connection.link

    @property
    def identity(self) -> Identity | None:
        """Who the ribbon is; None before it has answered, and without a link."""
        return self._identity

    @property
    def state(self) -> LinkState:
        """How it stands with the ribbon, as it was told last."""
        return self._state

    @property
    def reason(self) -> str:
        """Why it stands so, in one sentence."""
        return self._reason

    @property
    def active(self) -> bool:
        """Whether a connection is wanted: it is made, is there, or is tried again."""
        return self._tries

    @property
    def url(self) -> str | None:
        """Where the ribbon is."""
        link = self.link
        return None if link is None else link.url

    @property
    def virtual(self) -> VirtualRibbon | None:
        """The virtual ribbon, to lay it about, where it is one."""
        return None if self._connection is None else self._connection.virtual

    @property
    def diary(self) -> LinkDiary | None:
        """What a session keeps of the link; from before its start."""
        return None if self._connection is None else self._connection.diary

    def health(self) -> Health | None:
        """The link's figures of this moment."""
        link = self.link
        return None if link is None else link.health()

    def recorder(self) -> Tap:
        """A tap that gets every frame from now on; DeviceError without a ribbon."""
        link = self.link
        if link is None:
            raise DeviceError("no ribbon is connected; connect one first")
        return link.recorder()

    # --- what a person wants ---

    def connect_to(
        self,
        url: str,
        baudrate: int | None = None,
        ribbon_id: str | None = None,
        ribbon: Ribbon | None = None,
    ) -> None:
        """Connect to the ribbon at a port or socket, in the place of what is connected.

        ribbon_id, ribbon: who is expected, by name or with the sensors.
        """

        def make() -> Connection:
            from georibbon.gui.station.connection import to_port

            return to_port(url, baudrate, ribbon_id, ribbon)

        self._connect(make, tr("opening {port}", port=told(url)))

    def connect_virtual(
        self,
        settings: VirtualSettings | Callable[[], VirtualSettings] | None = None,
        way: Way = "pty",
    ) -> None:
        """Connect to a virtual ribbon that is started inside, through a real port.

        settings: or what makes them, in the worker, where that loads much.
        """

        def make() -> Connection:
            from georibbon.gui.station.connection import to_virtual

            return to_virtual(settings, way)

        self._connect(make, tr("starting the virtual ribbon"))

    def disconnect(self) -> None:
        """Let go of the ribbon, or of the try to reach one."""
        if self._leave():
            self._tell(LinkState.DISCONNECTED, tr("disconnected"))
            self.disconnected.emit()

    def end(self) -> None:
        """Close everything and wait for it; nothing is done after."""
        self._ended = True
        self._leave()
        self._pool.waitForDone()
        QCoreApplication.sendPostedEvents(self)  # what was made meanwhile is closed
        self._pool.waitForDone()

    # --- inside ---

    def _connect(self, make: Callable[[], Connection], reason: str) -> None:
        if self._ended:
            return
        if self._leave():
            self.disconnected.emit()
        self._tries = True
        self._pool.start(_Job(make, partial(self._made.emit, self._number)))
        self._tell(LinkState.OPENING, reason)

    def _leave(self) -> bool:
        """Want no connection any more; whether one was wanted."""
        wanted, connection = self._tries, self._connection
        self._number += 1
        self._tries, self._connection, self._identity = False, None, None
        self._pulse.stop()
        if connection is not None:
            self._pool.start(_Job(connection.close, self._closed.emit))
        return wanted

    def _begin(self, number: int, connection: Connection | None, error: Exception | None) -> None:
        """A connection is made: start it, unless another or none is wanted by now."""
        if number != self._number:
            if connection is not None:
                self._pool.start(_Job(connection.close, self._closed.emit))
        elif connection is None:
            self._fail(error)
        else:
            self._connection = connection
            news = partial(self._news.emit, number)
            connection.link.on_change(news)
            connection.link.on_event(news)
            connection.link.start()
            self._pulse.start()

    def _take(self, number: int, news: Change | Event) -> None:
        """The link tells something; its words may be older than what it is now."""
        link = self.link
        if link is None or number != self._number:
            return
        if isinstance(news, Event):
            self.happened.emit(news)
            return
        first, identity = self._identity is None, link.identity
        if first and identity is None and news.state is LinkState.DISCONNECTED:
            self._fail(DeviceError(_named(link.url, news.reason)))
            return
        if identity is not None and identity != self._identity:
            self._identity = identity
            self.identified.emit(identity)
        if number == self._number:  # who was told may have disconnected
            self._tell(news.state, news.reason)

    def _fail(self, error: Exception | None) -> None:
        """Nothing came of it: one sentence, and nothing is tried any more."""
        self._leave()
        if isinstance(error, GeoribbonError):
            self._tell(LinkState.DISCONNECTED, str(error))
            self.failed.emit(str(error))
        else:
            self._tell(LinkState.DISCONNECTED, tr("a fault of the program; see the log"))
            self.fault.emit(error)
        self.disconnected.emit()

    def _after_close(self, _none: None, error: Exception | None) -> None:
        if error is not None:
            self.fault.emit(error)

    def _tell(self, state: LinkState, reason: str) -> None:
        self._state, self._reason = state, reason
        self.changed.emit(state, reason)

    def _tell_health(self) -> None:
        health = self.health()
        if health is not None:
            self.health_changed.emit(health)


def _named(url: str, reason: str) -> str:
    """A reason that says which port it is about."""
    name = told(url)
    return reason if name in reason else f"{name}: {reason}"
