"""Pose after pose: the cards, what is asked beside what lies there, and how good it is by now."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from georibbon.calibration.directions import covered
from georibbon.gui.calibrating.cards import PoseGrid
from georibbon.gui.calibrating.check_panel import CheckPanel
from georibbon.gui.calibrating.live import LivePanel
from georibbon.gui.calibrating.quality import QualityPanel
from georibbon.gui.calibrating.sphere import SphereView
from georibbon.gui.calibrating.state import (
    CHECK_KEYS,
    LIVE_SECONDS,
    Card,
    Progress,
    cards,
    done,
    lying,
    next_open,
    poses_of,
)
from georibbon.gui.calibrating.words import pose_name, told_words
from georibbon.gui.language import tr
from georibbon.gui.parts import Parts

TAKING = (Qt.Key.Key_Space, Qt.Key.Key_PageDown)


class PosingView(QWidget):
    """The poses while they are taken.  ending(): the person stops for now."""

    ending = Signal()

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts, self._desk = parts, parts.capture
        self._keys: tuple[str, ...] = ()
        self._stillness = None
        self.progress = Progress()
        self.cards: tuple[Card, ...] = ()
        self.grid, self.live, self.sphere = PoseGrid(), LivePanel(), SphereView()
        self.quality, self.check = QualityPanel(), CheckPanel()
        self.title = QLabel()
        self.take_button = _button(tr("&Take"), tr("Take this pose now (Space or Page Down)"))
        self.anyway = _button(
            tr("Take any&way"), tr("Take it although something speaks against it")
        )
        self.skip_button = _button(tr("&Leave out"), tr("Go on without this pose"))
        self.undo_button = _button(tr("&Undo"), tr("Take back the last change"))
        self.redo_button = _button(tr("&Redo"), tr("Do again what was taken back last"))
        self.stop_button = _button(tr("&Stop for now"), tr("What is taken is kept; go on any time"))
        self.finish_button = _button(tr("&Finish…"), tr("See how good it is, name it and keep it"))
        self.finish_button.setEnabled(False)
        self.auto = QCheckBox(tr("Take by &stillness"))
        self.auto.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.auto.setToolTip(tr("What lies still as asked is taken by itself"))
        self.what = QComboBox()
        self.what.addItems([tr("Directions of gravity"), tr("Directions of the field")])
        self.what.setAccessibleName(tr("Which directions are shown"))
        self.what.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self._dip: float | None = None
        self._connect()
        self._lay_out()

    def _connect(self) -> None:
        for button, slot in (
            (self.take_button, self.take),
            (self.anyway, self.take_anyway),
            (self.skip_button, self._desk.skip),
            (self.undo_button, self._desk.undo),
            (self.redo_button, self._desk.redo),
            (self.stop_button, self.ending.emit),
        ):
            button.clicked.connect(lambda _=False, slot=slot: slot())
        self.auto.clicked.connect(self._desk.set_auto)
        self.grid.asked.connect(self._desk.choose)
        self.sphere.asked.connect(self._desk.choose)
        self.what.currentIndexChanged.connect(self.show_standing)

    def _lay_out(self) -> None:
        top = QHBoxLayout()
        top.addWidget(self.title, 1)
        for one in (self.undo_button, self.redo_button, self.finish_button, self.stop_button):
            top.addWidget(one)
        left, right = QWidget(), QWidget()
        column = QVBoxLayout(left)
        column.setContentsMargins(0, 0, 6, 0)
        column.addWidget(self.grid, 2)
        column.addWidget(self.check, 3)
        directions = QVBoxLayout()
        directions.addWidget(self.what, 0, Qt.AlignmentFlag.AlignLeft)
        directions.addWidget(self.sphere, 1)
        figures = QHBoxLayout()
        figures.addLayout(directions, 1)
        figures.addWidget(self.quality, 1)
        buttons = QHBoxLayout()
        buttons.addWidget(self.auto, 1)
        for one in (self.take_button, self.anyway, self.skip_button):
            buttons.addWidget(one)
        column = QVBoxLayout(right)
        column.setContentsMargins(6, 0, 0, 0)
        column.addWidget(self.live, 5)
        column.addLayout(buttons)
        column.addLayout(figures, 3)
        split = QSplitter(Qt.Orientation.Horizontal)
        split.setChildrenCollapsible(False)
        split.addWidget(left)
        split.addWidget(right)
        split.setSizes([10_000, 11_000])  # both have nearly half of what there is
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(top)
        layout.addWidget(split, 1)

    @property
    def checking(self) -> bool:
        """Whether these are the poses of a daily check."""
        return bool(self._keys)

    def start(self, checking: bool, title: str) -> None:
        """A capture has begun: show its poses, all or those of the daily check."""
        self._keys = CHECK_KEYS if checking else ()
        self.progress = Progress()
        self._stillness = None
        self.title.setText(title)
        self.check.setVisible(checking)
        self.quality.setVisible(not checking)
        if checking:
            self.check.show_nothing(len(self._keys), "")
        else:
            self.quality.show_nothing(0)
        self.live.tell("open", "")
        self.show_dip(None)
        self.show_standing()
        if self.grid.buttons:
            self.grid.buttons[0].setFocus(Qt.FocusReason.OtherFocusReason)

    def show_standing(self) -> None:
        """Show how all poses stand."""
        desk = self._desk
        self.cards = cards(desk.items, desk.current, self.progress, self._keys)
        self.grid.show_cards(self.cards)
        field = self.what.currentIndex() == 1
        self.sphere.show_cards(self.cards, self._dip if field else None)
        asked = self.asked
        self.live.show_card(
            asked, tr("All poses are taken") if self.cards else "", self._what_now()
        )
        for one in (self.take_button, self.skip_button):
            one.setEnabled(asked is not None)
        self.anyway.setEnabled(asked is not None and bool(self.progress.refused))
        self.auto.setChecked(desk.auto)
        poses = [(c.pose.roll, c.pose.heading, c.pose.pitch, c.pose.table) for c in self.cards]
        taken = [card.state in ("good", "poor") for card in self.cards]
        if poses:
            self.quality.show_covered(covered(poses, taken))
        self.quality.show_progress(done(self.cards), len(self.cards), False)

    def _what_now(self) -> str:
        """What can be done where nothing is asked for."""
        poor = [pose_name(card.number) for card in self.cards if card.state == "poor"]
        if poor:
            return tr("Poor: {poses}. Click a card to take its pose again.", poses=", ".join(poor))
        return tr("Click a card to take its pose again.") if self.cards else ""

    def show_dip(self, dip: float | None) -> None:
        """Take up the field's dip, radians; without it nobody knows where the field pointed."""
        self._dip = dip
        self.what.setVisible(dip is not None)
        if dip is None:
            self.what.setCurrentIndex(0)

    @property
    def asked(self) -> Card | None:
        """The card of the pose that is asked for."""
        current = self._desk.current
        key = None if current is None else current.key
        return next((card for card in self.cards if card.key == key), None)

    def take_news(self, happening) -> None:
        """Something happened in the capture."""
        self.progress.take(happening)
        self.show_standing()
        kind = happening.kind
        if kind == "refused":
            self.live.tell("refused", told_words(happening.message, self.cards))
        elif kind in ("taken", "skipped", "removed", "undone", "redone", "held", "saved"):
            state = "bad" if kind == "held" else "good"
            self.live.tell(state, told_words(happening.message, self.cards))

    def ask_for_check(self) -> None:
        """Have the next pose of the daily check asked for, which no plan does by itself."""
        if not self._keys or self.asked is not None:
            return
        following = next_open(self.cards, None)
        if following is not None:
            self._desk.choose(following)

    def tell_refusal(self, told: str) -> None:
        """A verb was not done."""
        self.live.tell("refused", told_words(told, self.cards))

    def show_glance(self, glance) -> None:
        """Show the newest state of the ribbon."""
        self._stillness = glance.live.stillness
        asked = self.asked
        station = self._parts.station
        link, identity = station.link, station.identity
        found = None
        if link is not None and identity is not None:
            frames = link.ring.last(max(1, round(LIVE_SECONDS * identity.ribbon.rate)))
            found = lying(identity.ribbon, frames, None if asked is None else asked.pose)
        heading = 0.0 if asked is None else asked.pose.heading
        self.live.show_live(found, heading, self._stillness)
        shown = found is not None and self.what.currentIndex() == 0
        self.sphere.show_live(found.up if shown else None)

    def take(self) -> None:
        """Take the pose that is asked for."""
        self._desk.take()

    def take_anyway(self) -> None:
        """Take it although something that may be overruled speaks against it."""
        self._desk.take(True)

    def choose_next(self) -> None:
        """Ask for the next pose that is not taken."""
        asked = self.asked
        following = next_open(self.cards, None if asked is None else asked.key)
        if following is not None:
            self._desk.choose(following)

    def keyPressEvent(self, event) -> None:
        """Space or Page Down, a pedal's key, takes, wherever the keys are but on a button."""
        if event.key() in TAKING:
            if not event.isAutoRepeat():
                self.take()
        else:
            super().keyPressEvent(event)

    def planned(self):
        """The planned poses that are shown."""
        return [item.what for item in poses_of(self._desk.items, self._keys)]


def _button(text: str, tip: str) -> QPushButton:
    """A button that a click does not give the keys to: Space goes on taking."""
    button = QPushButton(text)
    button.setToolTip(tip)
    button.setStatusTip(tip)
    button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    return button
