"""The hands of the virtual ribbon: they lay what the capture asks for, and make troubles to try."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QMenu,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from georibbon.errors import GeoribbonError
from georibbon.gui.language import N_, tr
from georibbon.gui.language import sentence as spoken

if TYPE_CHECKING:
    from georibbon.capture.ledger import Happening
    from georibbon.gui.parts import Parts
    from georibbon.virtual import VirtualRibbon

# In the air for a moment before it is laid: what lies where it lay is not taken again.
IN_THE_AIR = 200  # ms
PAUSE, LONGEST_PAUSE = 0.5, 10.0  # s from what is asked for to its being laid
ASKED = ""  # the place's entry that means what is asked for
MAGNET = N_("A &magnet near it")
TROUBLES = (
    ("magnet pass", N_("A magnet &passes by")),
    ("stall", N_("It &hangs for three seconds")),
    ("unplug", N_("P&ull the cable")),
    ("replug", N_("Plug the &cable in again")),
)


class VirtualHands(QWidget):
    """Lays the virtual ribbon; empty while another ribbon or none is connected.

    One is enough for the whole window: it goes on following while it is not
    seen.  did(sentence): what the hands did, or why they could not.
    """

    did = Signal(str)

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._station, self._capture = parts.station, parts.capture
        self._followed: str | None = None  # the item that was laid by itself last
        self._words = ""  # to be laid as soon as it has been in the air
        self.panel = QFrame(self)
        self.lay_button = QPushButton(tr("La&y"))
        self.lift_button = QPushButton(tr("L&ift"))
        self.place = QComboBox()
        self.follow = QCheckBox(tr("F&ollow by itself"))
        self.pause = QDoubleSpinBox()
        self.survey = QPushButton(tr("Enter the s&urvey"))
        self.troubles = QToolButton()
        self.told = QLabel()
        self._name_all()
        self._lay_out()
        self._air, self._wait = QTimer(self), QTimer(self)
        for timer in (self._air, self._wait):
            timer.setSingleShot(True)
        self._connect()
        self._show()

    # --- what a person wants; also for the table of actions ---

    def lay(self) -> None:
        """Lay what the capture asks for, or what is chosen in the list of places."""
        from georibbon.gui.connect.laying import laying_words

        place, item = self.place.currentData(), self._capture.current
        if place != ASKED:
            self._begin(f"lay {place}")
        elif item is None:
            self._tell(tr("Nothing is asked for; begin a capture, or choose a place."))
        else:
            self._begin(laying_words(item))

    def lay_wrongly(self) -> None:
        """Lay a pose upside down, or another pass than is asked for."""
        from georibbon.gui.connect.laying import wrong_words

        virtual, item = self._station.virtual, self._capture.current
        if virtual is None or item is None:
            self._tell(tr("Nothing is asked for; begin a capture first."))
        else:
            self._begin(wrong_words(item, virtual.passes))

    def lift(self) -> None:
        """Take it up into the hands."""
        self._air.stop()
        self._do("lift")

    def set_follow(self, follow: bool) -> None:
        """Lay by itself whatever is asked for, or not."""
        self.follow.setChecked(follow)

    def trouble(self, words: str) -> None:
        """Make a trouble: a command of the virtual ribbon's."""
        self._do(words)

    def enter_survey(self) -> None:
        """Enter what was measured of the passes: what a person would measure and type in."""
        from georibbon.gui.connect.laying import survey_missing

        virtual, capture = self._station.virtual, self._capture
        if virtual is None or not capture.active:
            self._tell(tr("The survey belongs to a capture; begin one first."))
            return
        names = [item.key for item in capture.items if not item.is_pose]
        missing = survey_missing(virtual.survey(), capture.survey, names)
        for table, entry in missing:
            capture.add_survey(table, entry)
        self._tell(tr("{n} measurements are entered.", n=len(missing)))

    # --- making ---

    def _name_all(self) -> None:
        self.panel.setFrameShape(QFrame.Shape.StyledPanel)
        self.panel.setAccessibleName(tr("The hands of the virtual ribbon"))
        self.lay_button.setToolTip(
            tr("The hands lay the ribbon as the capture asks for it, or there")
        )
        self.lift_button.setToolTip(tr("The hands take the ribbon up"))
        self.place.setAccessibleName(tr("Where it is laid"))
        self.place.setToolTip(tr("Where the button lays it"))
        self.follow.setToolTip(tr("Every pose and pass is laid as soon as it is asked for"))
        self.pause.setRange(0.0, LONGEST_PAUSE)
        self.pause.setSingleStep(PAUSE)
        self.pause.setDecimals(1)
        self.pause.setValue(PAUSE)
        self.pause.setSuffix(tr(" s"))
        self.pause.setPrefix(tr("after "))
        self.pause.setAccessibleName(tr("Seconds until it is laid by itself"))
        self.pause.setToolTip(tr("How long the hands wait before they lay what is asked for"))
        self.survey.setToolTip(tr("The marks, distances and crossings that you would measure"))
        self.troubles.setText(tr("Trou&bles") + "   ")  # room for the arrow
        self.troubles.setToolTip(tr("What may go wrong, to see what the program does"))
        self.troubles.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.troubles.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.troubles.setMenu(self._menu())
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.told.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.told.setAccessibleName(tr("What the hands did"))

    def _menu(self) -> QMenu:
        menu = QMenu(self)
        self.magnet = menu.addAction(tr(MAGNET))
        self.magnet.setCheckable(True)
        self.magnet.triggered.connect(self._put_magnet)
        self.wrong = menu.addAction(tr("A &wrong face, or another pass"))
        self.wrong.triggered.connect(self.lay_wrongly)
        self.cable: dict[str, QAction] = {}
        for words, text in TROUBLES:
            action = menu.addAction(tr(text))
            action.triggered.connect(lambda _=False, words=words: self.trouble(words))
            self.cable[words] = action
        menu.aboutToShow.connect(self._show_cable)
        return menu

    def _lay_out(self) -> None:
        row = QHBoxLayout(self.panel)
        row.setContentsMargins(8, 4, 8, 4)
        title = QLabel(tr("Virtual hands"))
        widgets = (title, self.lay_button, self.place, self.lift_button, self.follow, self.pause,
                   self.survey, self.troubles)  # fmt: skip
        for widget in widgets:
            row.addWidget(widget)
        row.addWidget(self.told, 1)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(self.panel)

    def _connect(self) -> None:
        self.lay_button.clicked.connect(self.lay)
        self.lift_button.clicked.connect(self.lift)
        self.survey.clicked.connect(self.enter_survey)
        self.follow.toggled.connect(self._follow_toggled)
        self._air.timeout.connect(self._put_down)
        self._wait.timeout.connect(self._follow_now)
        for signal in (self._station.changed, self._station.disconnected):
            signal.connect(self._show)
        self._station.identified.connect(self._new_ribbon)
        self._capture.stood.connect(self._consider)
        self._capture.began.connect(self._ask_anew)
        self._capture.ended.connect(self._show)
        self._capture.happened.connect(self._heard)
        self._new_ribbon()

    # --- inside ---

    def _show(self, *_: object) -> None:
        """Only a virtual ribbon has virtual hands."""
        virtual = self._station.virtual
        self.panel.setVisible(virtual is not None)
        self.survey.setEnabled(self._capture.active)
        if virtual is None:
            self._air.stop()
            self._wait.stop()

    def _new_ribbon(self, *_: object) -> None:
        virtual: VirtualRibbon | None = self._station.virtual
        self.place.clear()
        self.place.addItem(tr("what is asked for"), ASKED)
        for name in () if virtual is None else virtual.passes:
            self.place.addItem(name, name)
        self.magnet.setChecked(False)
        self._show()
        self._ask_anew()

    def _show_cable(self) -> None:
        """One can pull only what is in."""
        virtual = self._station.virtual
        plugged = virtual is not None and virtual.plugged
        self.cable["unplug"].setEnabled(plugged)
        self.cable["replug"].setEnabled(not plugged)

    def _put_magnet(self, there: bool) -> None:
        self._do("magnet 0.25" if there else "magnet off")

    def _begin(self, words: str) -> None:
        """Up into the air for a moment, then down: it has moved then, wherever it lay before."""
        virtual, name = self._station.virtual, words.removeprefix("lay ")
        if virtual is not None and name != words and name not in virtual.passes:
            self._tell(
                tr("The virtual ribbon's object has no {name}; choose more passes or ties on the "
                   "Connect page, and connect again.", name=name)
            )  # fmt: skip
        elif self._do("lift"):
            self._words = words
            self._air.start(IN_THE_AIR)

    def _put_down(self) -> None:
        self._do(self._words)

    def _do(self, words: str) -> bool:
        """Have a command carried out; whether it could be."""
        virtual = self._station.virtual
        if virtual is None:
            self._tell(tr("No virtual ribbon is connected."))
            return False
        try:
            self._tell(virtual.do(words))
        except GeoribbonError as error:
            self._tell(str(error))
            return False
        return True

    def _tell(self, sentence: str) -> None:
        self.told.setText(spoken(sentence))
        self.told.setToolTip(spoken(sentence))
        self.did.emit(sentence)

    # --- following ---

    def _follow_toggled(self, _follow: bool) -> None:
        self._ask_anew()

    def _heard(self, happening: Happening) -> None:
        """What is asked for again, though it is the same, is laid again."""
        if happening.kind == "chosen":
            self._ask_anew()

    def _ask_anew(self) -> None:
        self._followed = None
        self._consider()

    def _consider(self) -> None:
        """Lay what is asked for after the pause, unless it was laid already."""
        self._show()
        item = self._capture.current
        if not self.follow.isChecked() or self._station.virtual is None or item is None:
            self._wait.stop()
        elif item.key != self._followed:
            self._wait.start(round(1000 * self.pause.value()))

    def _follow_now(self) -> None:
        from georibbon.gui.connect.laying import laying_words

        item = self._capture.current
        if item is not None:
            self._followed = item.key
            self._begin(laying_words(item))
