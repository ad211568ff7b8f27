"""The Connect page: where the ribbon is, what it says of itself, and every sensor live."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QIntValidator
from PySide6.QtWidgets import (
    QButtonGroup,
    QComboBox,
    QFormLayout,
    QFrame,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QRadioButton,
    QScrollArea,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from georibbon.device.telling import LinkState
from georibbon.gui.connect.choice import (
    BAUDRATE,
    BAUDRATES,
    BOUNDS,
    KINDS,
    Choice,
    Kind,
    keep_choice,
    kept_choice,
)
from georibbon.gui.connect.identity_card import IdentityCard
from georibbon.gui.connect.port_list import PortList
from georibbon.gui.connect.raw_view import RawView
from georibbon.gui.connect.signs import SIZE, sign_icon, sign_of
from georibbon.gui.connect.virtual_form import VirtualForm
from georibbon.gui.connect.words import clock_time, state_words
from georibbon.gui.language import N_, sentence, tr
from georibbon.gui.theme import colours_of

if TYPE_CHECKING:
    from georibbon.device.telling import Event
    from georibbon.gui.parts import Parts
    from georibbon.ribbon import Ribbon

WIDTHS = (400, 760)  # px: the choice and the ribbon, as they share the width at first
NARROWEST = 330  # px: the choice
LISTED = 120  # px: the height of the list of ports, at least
WAYS: dict[Kind, str] = {
    "virtual": N_("The virt&ual ribbon, played by the program"),
    "port": N_("A &serial port of this computer"),
    "socket": N_("A &network socket"),
}
SCHEME = "socket://"


def connect_last(parts: Parts) -> None:
    """Connect to what was chosen last, without the page."""
    _connect(parts, kept_choice(parts.settings))


def connect_virtual(parts: Parts) -> None:
    """Connect to the virtual ribbon as it was chosen last, without the page."""
    choice = replace(kept_choice(parts.settings), kind="virtual")
    keep_choice(parts.settings, choice)
    _connect(parts, choice)


def _connect(parts: Parts, choice: Choice) -> None:
    station = parts.station
    if choice.kind == "virtual":
        virtual = choice.virtual
        station.connect_virtual(virtual.settings, "tcp" if virtual.socket else "pty")
    elif choice.kind == "socket":
        station.connect_to(_url(choice.address), ribbon=_expected(parts))
    else:
        station.connect_to(choice.port, choice.baudrate, ribbon=_expected(parts))


def _url(address: str) -> str:
    """host:port, with what belongs before it."""
    return address if "://" in address else SCHEME + address


def _expected(parts: Parts) -> Ribbon | None:
    """The ribbon of the capture that is going on: no other may take its place."""
    session = parts.capture.session if parts.capture.active else None
    return None if session is None else session.state.ribbon


class ConnectPage(QWidget):
    """On the left what to connect to, on the right the ribbon.

    What was chosen last is chosen again at the next start.
    """

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts = parts
        self.ways = {kind: QRadioButton(tr(text)) for kind, text in WAYS.items()}
        self.ports = PortList(self._connected)
        self.baudrate = QComboBox()
        self.baudrate.setEditable(True)
        self.baudrate.addItems([str(rate) for rate in BAUDRATES])
        self.baudrate.setValidator(QIntValidator(*BOUNDS["baudrate"], self))
        self.baudrate.setToolTip(tr("Bits a second; 921600 unless the ribbon is set otherwise"))
        self.address = QLineEdit()
        self.address.setPlaceholderText("192.168.1.20:4000")
        self.virtual = VirtualForm()
        self.go = QPushButton(tr("C&onnect"))
        self.go.setDefault(True)
        self.stop = QPushButton(tr("&Disconnect"))
        self.sign, self.told = QLabel(), QLabel()
        self.told.setWordWrap(True)
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.told.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.told.setAccessibleName(tr("How the connection is"))
        self.said = QLabel()
        self.said.setWordWrap(True)
        self.said.setTextFormat(Qt.TextFormat.PlainText)  # it comes from outside
        self.said.setAccessibleName(tr("What was told last"))
        self.said.hide()
        self.card = IdentityCard(parts.units)
        self.raw = RawView(parts)
        self._lay_out()
        self._take_up(kept_choice(parts.settings))
        self._connect_signals()
        self._show_state()

    def choice(self) -> Choice:
        """What is chosen."""
        kind = next((kind for kind in KINDS if self.ways[kind].isChecked()), "virtual")
        text = self.baudrate.currentText()
        rate = int(text) if text.isdecimal() else BAUDRATE
        return Choice(
            kind, self.ports.device, self.address.text().strip(), rate, self.virtual.choice()
        )

    def connect_chosen(self) -> None:
        """Connect to what is chosen."""
        choice, missing = self.choice(), self._missing()
        if missing:
            self._tell(missing)
            return
        keep_choice(self._parts.settings, choice)
        _connect(self._parts, choice)

    # --- making ---

    def _lay_out(self) -> None:
        split = QSplitter(Qt.Orientation.Horizontal)
        split.setChildrenCollapsible(False)
        split.addWidget(self._choice_side())
        split.addWidget(self._ribbon_side())
        split.setStretchFactor(1, 1)
        split.setSizes(list(WIDTHS))
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(split)

    def _choice_side(self) -> QWidget:
        """What to connect to; scrolled where the window is low."""
        group = QButtonGroup(self)
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.setContentsMargins(12, 12, 8, 12)
        self._sections = {
            "virtual": self.virtual,
            "port": self._port_section(),
            "socket": self._socket_section(),
        }
        for kind, section in self._sections.items():
            group.addButton(self.ways[kind])
            column.addWidget(self.ways[kind])
            column.addWidget(_indented(section))
        column.addStretch(1)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidget(inside)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        side = QWidget()
        words = inside.minimumSizeHint().width() + area.verticalScrollBar().sizeHint().width()
        side.setMinimumWidth(max(NARROWEST, words))
        whole = QVBoxLayout(side)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(area, 1)
        whole.addLayout(self._buttons())
        return side

    def _port_section(self) -> QWidget:
        self.ports.setMinimumHeight(LISTED)
        section = QWidget()
        form = QFormLayout(section)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.ports)
        form.addRow(tr("&Baud rate"), self.baudrate)
        return section

    def _socket_section(self) -> QWidget:
        section = QWidget()
        form = QFormLayout(section)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(tr("&Address"), self.address)
        told = QLabel(
            tr("HOST:PORT of a ribbon with a network, of a serial converter, or of a virtual "
               "ribbon on this computer, such as 127.0.0.1:7000")
        )  # fmt: skip
        told.setWordWrap(True)
        form.addRow(told)
        return section

    def _buttons(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setContentsMargins(12, 4, 8, 12)
        row.addWidget(self.go)
        row.addWidget(self.stop)
        row.addStretch(1)
        return row

    def _ribbon_side(self) -> QWidget:
        side = QWidget()
        column = QVBoxLayout(side)
        column.setContentsMargins(8, 12, 12, 8)
        state = QHBoxLayout()
        state.addWidget(self.sign, 0, Qt.AlignmentFlag.AlignTop)
        state.addWidget(self.told, 1)
        column.addLayout(state)
        column.addWidget(self.said)
        box = QGroupBox(tr("What the ribbon says of itself"))
        QVBoxLayout(box).addWidget(self.card)
        column.addWidget(box)
        column.addWidget(self.raw, 1)
        return side

    def _connect_signals(self) -> None:
        station = self._parts.station
        for button in self.ways.values():
            button.toggled.connect(self._show_way)
        self.ports.chosen.connect(lambda _: self.ways["port"].setChecked(True))
        self.ports.activated.connect(lambda _: self.connect_chosen())
        self.address.returnPressed.connect(self.connect_chosen)
        self.go.clicked.connect(self.connect_chosen)
        self.stop.clicked.connect(station.disconnect)
        for signal in (station.changed, station.identified, station.disconnected):
            signal.connect(self._show_state)
        station.identified.connect(self.card.show_identity)
        station.disconnected.connect(self.card.forget)
        station.happened.connect(self._hear)
        station.identified.connect(self.said.hide)
        self.card.show_identity(station.identity)

    def _take_up(self, choice: Choice) -> None:
        """Show what was chosen last."""
        self.ways[choice.kind].setChecked(True)
        self.ports.choose(choice.port)
        self.address.setText(choice.address)
        self.baudrate.setCurrentText(str(choice.baudrate))
        self.virtual.show_choice(choice.virtual)
        self._show_way()

    # --- showing ---

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "card"):
            self._show_state()

    def _show_way(self, *_: object) -> None:
        """Only what belongs to the way that is chosen."""
        for kind, section in self._sections.items():
            section.setVisible(self.ways[kind].isChecked())

    def _show_state(self, *_: object) -> None:
        station = self._parts.station
        known = station.identity is not None
        sign = sign_icon(
            sign_of(station.state, known), colours_of(self.palette()), self.devicePixelRatioF()
        )
        self.sign.setPixmap(sign.pixmap(SIZE, SIZE))
        self.stop.setEnabled(station.active)
        self._tell(station.reason)

    def _tell(self, reason: str) -> None:
        """The state in words, and why."""
        station = self._parts.station
        words = state_words(station.state, station.identity is not None)
        plain = station.state is LinkState.DISCONNECTED and not reason
        why = tr("choose on the left where the ribbon is") if plain else sentence(reason)
        self.told.setText(tr("{state}: {why}", state=words.capitalize(), why=why))

    def _hear(self, event: Event) -> None:
        """What the ribbon says, or what else a person should know of the connection."""
        self.said.setText(
            tr("{time}: {message}", time=clock_time(event.time), message=sentence(event.message))
        )
        self.said.show()

    def _connected(self) -> str | None:
        """The port of the ribbon that is connected, where it is a real one."""
        station = self._parts.station
        return station.url if station.virtual is None else None

    def _missing(self) -> str:
        """What has to be chosen before there is anything to connect to."""
        choice = self.choice()
        if choice.kind == "port" and not choice.port:
            return tr("choose a port in the list first")
        if choice.kind == "socket" and not choice.address:
            return tr("type the address first, such as 192.168.1.20:4000")
        return self.virtual.missing if choice.kind == "virtual" else ""


def _indented(section: QWidget) -> QWidget:
    """A section under its radio button."""
    section.layout().setContentsMargins(24, 0, 0, 8)
    return section
