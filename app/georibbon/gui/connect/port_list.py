"""The serial ports in a list that keeps itself up to date while it is seen."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QRunnable, Qt, QThreadPool, QTimer, Signal
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.language import N_, tr

if TYPE_CHECKING:
    from georibbon.gui.connect.port_rows import PortRow

EVERY = 1500  # ms
PORT, WHAT, USB, HINT = range(4)
TITLES = (N_("Port"), N_("What it is"), N_("USB"), N_("Hint"))
HINTS = {
    "": "",
    "connected": N_("connected here"),
    "busy": N_("in use by a program"),
    "forbidden": N_("no right to open it"),
}
TIPS = {
    "": N_("Nothing is known that stands in the way."),
    "connected": N_("This is the port of the ribbon that is connected."),
    "busy": N_("A program has it open; close that program first."),
    "forbidden": N_(
        "Your account may not open it. On Linux add yourself to the port's group, often dialout, "
        "and log in again."
    ),
}


class _Bell(QObject):
    """What a worker rings when the ports are known; it lives as long as the worker."""

    rang = Signal(object)


class _Look(QRunnable):
    """Looks for the ports in a worker thread."""

    def __init__(self, connected: str | None, tell: Callable[..., None]) -> None:
        super().__init__()
        self._connected = connected
        self._bell = _Bell()
        self._bell.rang.connect(tell, Qt.ConnectionType.QueuedConnection)

    def run(self) -> None:
        """Called by Qt in the worker thread; nothing may be raised from here."""
        from georibbon.gui.connect.port_rows import port_rows

        try:
            rows = port_rows(self._connected)
        except Exception:  # a driver's doing; the next look may fare better
            rows = ()
        with suppress(RuntimeError):  # the program has ended meanwhile, and the bell with it
            self._bell.rang.emit(rows)


class PortList(QWidget):
    """The serial ports with what is known of them.

    chosen(device): a person chose one.  activated(device): by a double click or Return.
    """

    chosen = Signal(str)
    activated = Signal(str)

    def __init__(self, connected: Callable[[], str | None], parent: QWidget | None = None) -> None:
        """connected: the port that is ours at this moment."""
        super().__init__(parent)
        self._connected = connected
        self._rows: tuple[PortRow, ...] | None = None
        self._looking = self._quiet = False
        self._wanted = ""
        self.list = QTreeWidget()
        self.list.setAccessibleName(tr("Serial ports"))
        self.list.setHeaderLabels([tr(title) for title in TITLES])
        self.list.setRootIsDecorated(False)
        self.list.setUniformRowHeights(True)
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.list.header().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.list.header().setStretchLastSection(True)
        self.told = QLabel()
        self.told.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.list, 1)
        layout.addWidget(self.told)
        self._timer = QTimer(self)
        self._timer.setInterval(EVERY)
        self._timer.timeout.connect(self.look)
        self.list.currentItemChanged.connect(self._current_changed)
        self.list.itemActivated.connect(lambda item: self.activated.emit(item.text(PORT)))
        self.setFocusProxy(self.list)
        self._say()

    @property
    def device(self) -> str:
        """The port that is chosen; also one that is not there at this moment."""
        return self._wanted

    def choose(self, device: str) -> None:
        """Mark a port as chosen, now or as soon as it is there; nothing is emitted."""
        self._wanted = device
        self._fill()

    def look(self) -> None:
        """Look for the ports, in a worker."""
        if not self._looking:
            self._looking = True
            QThreadPool.globalInstance().start(_Look(self._connected(), self._take))

    def showEvent(self, event: QShowEvent) -> None:
        """Seen: look now and then."""
        super().showEvent(event)
        self.look()
        self._timer.start()

    def hideEvent(self, event: QHideEvent) -> None:
        """Not seen: look no more."""
        super().hideEvent(event)
        self._timer.stop()

    # --- inside ---

    def _take(self, rows: tuple[PortRow, ...]) -> None:
        self._looking = False
        if rows != self._rows:
            self._rows = rows
            self._fill()
            self._say()

    def _fill(self) -> None:
        self._quiet = True
        self.list.clear()
        for row in self._rows or ():
            item = QTreeWidgetItem([row.device, row.description, row.usb, tr(HINTS[row.hint])])
            item.setToolTip(WHAT, row.description)
            item.setToolTip(HINT, tr(TIPS[row.hint]))
            self.list.addTopLevelItem(item)
            if row.device == self._wanted:
                self.list.setCurrentItem(item)
        self._quiet = False

    def _say(self) -> None:
        if self._rows is None:
            self.told.setText(tr("Looking for ports…"))
        elif not self._rows:
            self.told.setText(
                tr("There is no serial port now; plug the ribbon in and it appears here.")
            )
        self.told.setVisible(not self._rows)

    def _current_changed(self, item: QTreeWidgetItem | None) -> None:
        if item is not None and not self._quiet:
            self._wanted = item.text(PORT)
            self.chosen.emit(self._wanted)
