"""Pass after pass: what is asked for, how the ribbon lies, and everything that is taken."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSplitter,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from georibbon.capture.ledger import NOT_YET
from georibbon.gui import dialogs
from georibbon.gui.calibrating.live import StillnessRing
from georibbon.gui.capturing.board import Banner, Board, VerdictBoard, Words
from georibbon.gui.capturing.model import CaptureModel, LivePicture, is_calibration
from georibbon.gui.capturing.passes_list import PassesList
from georibbon.gui.capturing.sound import Sound, Sounds
from georibbon.gui.capturing.survey_table import SurveyTable
from georibbon.gui.capturing.words import (
    beside_words,
    headline,
    hint_words,
    instruction,
    restless_words,
)
from georibbon.gui.language import sentence as spoken
from georibbon.gui.language import tr
from georibbon.gui.parts import Parts

LEAST_STILL = 1.0  # s, as the engine has it


class CapturingView(QWidget):
    """The capture that goes on.

    planned(): a person wants to see the plan.  finished(): the capture is ended.
    wanted(page): a person is led to another page.
    """

    planned = Signal()
    finished = Signal()
    wanted = Signal(str)

    def __init__(self, parts: Parts, model: CaptureModel, make_view: Callable[[], QWidget]) -> None:
        super().__init__()
        self._parts, self._model = parts, model
        self._make_view = make_view
        self.scene: QWidget | None = None
        self.plots: QWidget | None = None
        self._live: LivePicture | None = None
        self._refusal = ""
        self._uncalibrated = ""  # why the poses that were taken give no calibration
        self.sounds = Sounds(parts)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(tr("Capture, pass after pass"))
        self._make()
        self._lay_out()
        self._connect()

    # --- making ---

    def _make(self) -> None:
        self.link_banner, self.storage_banner = Banner(), Banner()
        self.try_again = self.storage_banner.add_button(tr("Try a&gain"))
        self.elsewhere = self.storage_banner.add_button(tr("&Keep elsewhere…"))
        self.ring = StillnessRing()
        self.ask = Board(tr("What is asked for"))
        self.headline, self.how = Words(2.4, bold=True), Words(1.3)
        self.lying, self.refused = Words(1.1), Words(1.15, bold=True)
        self.hints = Words(1.5, bold=True)
        self.angle, self.far = Words(1.1), Words(1.1)
        self.verdict = VerdictBoard()
        self.list = PassesList()
        self.survey = SurveyTable(self._parts, self._model)
        self.tabs = QTabWidget()
        self.curves = QSplitter(Qt.Orientation.Horizontal)
        self.take_button = _button(tr("&Take"), tr("Space, Page Down or a foot pedal"))
        self.take_button.setMinimumHeight(44)
        self.take_button.setMinimumWidth(150)
        self.force_button = _button(tr("Take any&way"), tr("Although something speaks against it"))
        self.skip_button = _button(tr("&Leave out"), tr("Choosing it later brings it back"))
        self.poses_button = _button(tr("Poses as pict&ures"), tr("Go to the calibration's page"))
        self.auto = QCheckBox(tr("Take by st&illness"))
        self.auto.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.note = QLineEdit()
        self.note.setPlaceholderText(tr("A note, kept with its time: type it and press Return"))
        self.note.setAccessibleName(tr("Note"))
        self.told = QLabel()
        self.told.setTextFormat(Qt.TextFormat.PlainText)
        self.told.setAccessibleName(tr("What happened last"))
        self.plan_button = _button(tr("&Plan…"), tr("Change how much is captured"))
        self.finish_button = _button(tr("Fi&nish"), tr("The capture can go on at any time"))
        self.again_button = _button(tr("La&y again"), tr("Ask for the chosen pass once more"))
        self.delete_button = _button(tr("&Delete"), tr("Undo brings it back"))
        self.add_pass_button = _button(tr("Add pa&ss"), tr("A further pass behind the chosen one"))
        self.add_tie_button = _button(tr("&Add tie"), tr("A further tie across the passes"))
        self.up_button = _button("▲", tr("Move the chosen pass up (Alt+Up)"))
        self.down_button = _button("▼", tr("Move the chosen pass down (Alt+Down)"))
        self.up_button.setAccessibleName(tr("Move up"))
        self.down_button.setAccessibleName(tr("Move down"))

    def _lay_out(self) -> None:
        words = QVBoxLayout()
        words.setSpacing(2)
        for one in (self.headline, self.how, self.lying, self.refused):
            words.addWidget(one)
        words.addStretch(1)
        asked = QHBoxLayout(self.ask)
        asked.addWidget(self.ring, 0, Qt.AlignmentFlag.AlignTop)
        asked.addLayout(words, 1)
        top = QHBoxLayout()
        top.addWidget(self.ask, 3)
        top.addWidget(self.verdict, 2)
        centre = QWidget()
        middle = QVBoxLayout(centre)
        middle.setContentsMargins(4, 4, 4, 4)
        middle.setSpacing(3)
        middle.addWidget(self.hints)
        middle.addWidget(self.angle)
        middle.addWidget(self.far)
        middle.addWidget(self.curves, 1)
        self.tabs.addTab(centre, tr("&Beside each other"))
        self.tabs.addTab(self.survey, tr("Su&rvey"))
        lower = QSplitter(Qt.Orientation.Horizontal)
        lower.addWidget(self.tabs)
        lower.addWidget(self._side())
        lower.setStretchFactor(0, 4)
        lower.setStretchFactor(1, 1)
        lower.setChildrenCollapsible(False)
        bottom = QHBoxLayout()
        for one in (self.take_button, self.force_button, self.skip_button, self.poses_button):
            bottom.addWidget(one)
        bottom.addWidget(self.auto)
        bottom.addWidget(self.note, 1)
        bottom.addWidget(self.plan_button)
        bottom.addWidget(self.finish_button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(10, 8, 10, 8)
        layout.addWidget(self.link_banner)
        layout.addWidget(self.storage_banner)
        layout.addLayout(top)
        layout.addWidget(lower, 1)
        layout.addWidget(self.told)
        layout.addLayout(bottom)

    def _side(self) -> QWidget:
        side = QWidget()
        grid = QGridLayout(side)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        grid.addWidget(self.list, 0, 0, 1, 3)
        for k, one in enumerate((self.again_button, self.add_pass_button, self.up_button)):
            grid.addWidget(one, 1, k)
        for k, one in enumerate((self.delete_button, self.add_tie_button, self.down_button)):
            grid.addWidget(one, 2, k)
        grid.setRowStretch(0, 1)
        side.setMinimumWidth(250)
        return side

    def _connect(self) -> None:
        capture, document, station = self._parts.capture, self._parts.document, self._parts.station
        for button, slot in (
            (self.take_button, self.take), (self.force_button, self.take_anyway),
            (self.skip_button, self.skip), (self.plan_button, self.planned.emit),
            (self.finish_button, self.finish), (self.again_button, self.lay_again),
            (self.delete_button, self.delete), (self.add_pass_button, self.add_pass),
            (self.add_tie_button, self.add_tie), (self.up_button, self.move_up),
            (self.down_button, self.move_down), (self.try_again, self.save_again),
            (self.elsewhere, self.ask_elsewhere),
        ):  # fmt: skip
            button.clicked.connect(lambda _checked=False, slot=slot: slot())
        self.poses_button.clicked.connect(lambda: self.wanted.emit("calibrate"))
        self.auto.clicked.connect(self.set_auto)
        self.note.returnPressed.connect(self.keep_note)
        self.list.asked.connect(self._choose)
        self.list.deleted.connect(self._delete)
        self.list.reordered.connect(self._reorder)
        self.list.itemSelectionChanged.connect(self._follow_selection)
        self._model.changed.connect(self.refresh)
        self._model.lived.connect(self._show_live)
        capture.refreshed.connect(self._glance)
        capture.happened.connect(self._happened)
        capture.refused.connect(self._refuse)
        capture.stood.connect(self.refresh)
        document.failed.connect(self._storage)
        document.busy.connect(lambda *_: self._storage())
        station.changed.connect(self._link)
        self._parts.units.changed.connect(self._take_unit)

    def load(self) -> None:
        """Make what takes long to load: the plots and the 3D view."""
        if self.plots is not None:
            return
        from georibbon.gui.capturing.live_plots import LivePlots

        self.plots = LivePlots(self._parts, self._model)
        self.scene = self._make_view()
        self.curves.addWidget(self.scene)
        self.curves.addWidget(self.plots)
        self.curves.setChildrenCollapsible(False)
        self.curves.setSizes([450, 430])
        self._take_unit()
        self._draw()

    # --- what a person does ---

    def take(self) -> None:
        """Take what is asked for from the still ribbon."""
        self._parts.capture.take()

    def take_anyway(self) -> None:
        """Take it although something speaks against it."""
        self._parts.capture.take(True)

    def skip(self) -> None:
        """Leave out what is asked for."""
        self._parts.capture.skip()

    def lay_again(self) -> None:
        """Ask for the chosen pass once more, or for the last one."""
        key = self.list.chosen or self.verdict.name
        if key is not None:
            self._choose(key)

    def delete(self) -> None:
        """Take the chosen pass out; undo brings it back."""
        if self.list.chosen is not None:
            self._delete(self.list.chosen)

    def add_pass(self) -> None:
        """Ask for a further pass, behind the chosen one."""
        self._add("pass", "P")

    def add_tie(self) -> None:
        """Ask for a further tie."""
        self._add("tie", "T")

    def move_up(self) -> None:
        """Move the chosen pass up."""
        self.list.move(-1)

    def move_down(self) -> None:
        """Move the chosen pass down."""
        self.list.move(1)

    def set_auto(self, auto: bool) -> None:
        """Take by stillness, or only when asked."""
        self._parts.settings.put("capture/auto", auto)
        self._parts.capture.set_auto(auto)

    def keep_note(self) -> None:
        """Keep the note that is typed."""
        text = self.note.text().strip()
        if text:
            self._parts.capture.note(text)
            self.note.clear()
        self.setFocus()

    def ask_note(self) -> None:
        """Go to the note's line."""
        self.note.setFocus()

    def undo(self) -> None:
        """Take the last change back."""
        self._parts.capture.undo()

    def redo(self) -> None:
        """Do again what was taken back."""
        self._parts.capture.redo()

    def finish(self) -> None:
        """End the capture; it can go on at any time."""
        self._parts.capture.end()
        self.finished.emit()

    def save_again(self) -> None:
        """Try once more to write what is held in memory."""
        self._parts.capture.save_again()
        self._storage()

    def ask_elsewhere(self) -> None:
        """Go on in another file."""
        session = self._parts.capture.session
        if session is None:
            return
        proposal = Path.home() / session.path.name
        path = dialogs.ask_target(self, proposal, tr("Go on in"), dialogs.SESSIONS)
        if path is not None:
            self._parts.capture.save_to(path)

    def _choose(self, key: str) -> None:
        self._parts.capture.choose(key)
        self.setFocus()

    def _delete(self, key: str) -> None:
        self._parts.capture.remove(key)

    def _add(self, kind: str, letter: str) -> None:
        names = {one.key for one in self._parts.capture.items}
        number = 1 + sum(one == kind for one in self._model.kinds.values())
        while f"{letter}{number}" in names:
            number += 1
        name, chosen = f"{letter}{number}", self.list.chosen
        if kind == "pass" and chosen in self._model.pass_order:
            self._model.stand_behind(name, chosen)
        self._parts.capture.add(name, kind)
        self.setFocus()

    def _reorder(self, keys: list[str]) -> None:
        session = self._parts.capture.session
        taken = [] if session is None else [one.name for one in session.state.passes]
        wanted = [key for key in keys if key in taken]
        if wanted != taken:
            self._parts.capture.reorder(wanted)
        else:
            self.refresh()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Space and Page Down (a foot pedal) take, wherever they mean nothing else."""
        if event.key() in (Qt.Key.Key_Space, Qt.Key.Key_PageDown):
            self.take()
        else:
            super().keyPressEvent(event)

    # --- showing ---

    def begin(self) -> None:
        """A capture goes on."""
        self._refusal = self._uncalibrated = ""
        self.told.setText("")
        self._tell_quality(self._last_taken())
        self.load()
        self._link(self._parts.station.state, "")
        self._storage()
        self.refresh()
        self.setFocus()

    def refresh(self) -> None:
        """Show how the capture stands."""
        capture, ribbon = self._parts.capture, self._model.ribbon
        if not capture.active or ribbon is None or is_calibration(capture):
            return
        item = capture.current
        self.headline.setText(headline(item))
        self.how.setText(instruction(self._model, item, self._parts.units, ribbon.length))
        self.list.show_rows(self._model.rows)
        self.auto.setChecked(capture.auto)
        for button in (self.take_button, self.skip_button):
            button.setEnabled(item is not None)
        self.poses_button.setVisible(item is not None and item.is_pose)
        self._tell_quality(self.verdict.name)
        self._follow_selection()
        self._show_refusal()
        self._draw()

    def _take_unit(self) -> None:
        units = self._parts.units
        if self.scene is not None:
            self.scene.set_units(units.symbol, units.unit.metres)
        self.refresh()

    def _tell_quality(self, name: str | None) -> None:
        self.verdict.show_quality(name, None if name is None else self._model.quality(name))

    def _last_taken(self) -> str | None:
        """The last of the passes that are there."""
        session = self._parts.capture.session
        passes = () if session is None else session.state.passes
        return passes[-1].name if passes else None

    def _follow_selection(self) -> None:
        chosen = self.list.chosen
        taken = {row.key for row in self._model.rows if row.status == "taken"}
        self.delete_button.setEnabled(chosen in taken)
        self.again_button.setEnabled(chosen is not None or self.verdict.name is not None)
        for button in (self.up_button, self.down_button):
            button.setEnabled(chosen in taken and chosen in self._model.kinds)

    def _glance(self, glance) -> None:
        live = glance.live
        self.ring.show_stillness(live.stillness)
        found = live.stillness
        disturbed = found is not None and found.state == "disturbed"
        disturbed |= live.curve is not None and bool(live.curve.disturbed)
        self.lying.say(restless_words(live), "fair" if disturbed else "words")
        still = found is not None and found.state != "moving" and found.seconds >= LEAST_STILL
        self.force_button.setEnabled(bool(self._refusal) and still)
        if found is not None and found.state == "moving" and self._refusal:
            self._refusal = ""
            self._show_refusal()

    def _show_live(self, live: LivePicture | None) -> None:
        before, self._live = self._live, live
        units = self._parts.units
        if live is None or live.beside is None:
            self.angle.setText("")
            self.far.setText("")
            calibrated = self._parts.capture.calibration is not None
            none = self._uncalibrated or tr("The live curve is shown once there is a calibration.")
            self.hints.say("" if calibrated else none, "poor" if self._uncalibrated else "words")
        else:
            angle, far = beside_words(live.beside, units)
            self.angle.setText(angle)
            self.far.setText(far)
            words = "; ".join(hint_words(hint, live.beside, units) for hint in live.hints)
            fine = tr("✓ It lies well beside {name}", name=live.beside.neighbour)
            self.hints.say(f"▲ {words}" if words else fine, "fair" if words else "good")
        if live is not None or before is not None:
            self._draw()

    def _draw(self) -> None:
        """What the 3D view shows."""
        if self.scene is None:
            return
        from georibbon.scene.drawing import CaptureDrawing

        model, live = self._model, self._live
        kinds = model.kinds
        passes = tuple(
            (name, kinds.get(name, "pass"), strip.points) for name, strip in model.placed.items()
        )
        neighbour = None if live is None or live.beside is None else live.beside.neighbour
        drawn = None if live is None else (live.name, live.strip.points)
        self.scene.show_capture(CaptureDrawing(passes, drawn, neighbour))

    def _happened(self, happening) -> None:
        self.told.setText(spoken(happening.message))
        if happening.kind in ("taken", "held") and happening.subject is not None:
            self._taken(happening.subject)
        elif happening.kind == "refused":
            self._refusal = happening.message
            self._signal("refused")
        elif happening.kind == "quality":
            failed = happening.message.startswith(NOT_YET)
            self._uncalibrated = happening.message if failed else ""
        elif happening.kind == "complete":
            self._signal("complete")
        elif happening.kind in ("removed", "undone", "redone"):
            self._tell_quality(self._last_taken())
        if happening.kind in ("chosen", "taken", "complete"):
            self._refusal = ""
        if happening.kind in ("held", "saved"):
            self._storage()
        self._show_refusal()

    def _taken(self, key: str) -> None:
        self._signal("taken")
        if key in self._model.kinds:
            self.verdict.show_quality(key, self._model.quality(key))

    def _signal(self, sound: Sound) -> None:
        """Heard and seen, where this page is."""
        if self.isVisible():
            self.ask.flash(sound != "refused")
            self.sounds.play(sound)

    def _refuse(self, sentence: str) -> None:
        self._refusal = sentence
        self._show_refusal()

    def _show_refusal(self) -> None:
        self.refused.say(f"✗ {spoken(self._refusal)}" if self._refusal else "", "poor")

    def _storage(self, *_: object) -> None:
        """What is held in memory is told as long as it is."""
        session = self._parts.capture.session
        why = None if session is None else session.storage_error
        sentence = (
            "" if why is None else tr("{why}. Nothing is lost: it is held in memory.", why=why)
        )
        self.storage_banner.tell(sentence)

    def _link(self, state, reason: str) -> None:
        """The ribbon is not heard: what to do, and that it goes on by itself."""
        lost = self._parts.capture.active and str(state) != "streaming"
        if not lost:
            self.link_banner.tell("")
            return
        words = tr("The ribbon is not heard. See to its cable; the capture goes on by itself.")
        self.link_banner.tell(f"{words} ({reason})" if reason else words)

    def end(self) -> None:
        """Nothing of it goes on."""
        self.sounds.end()


def _button(text: str, tip: str) -> QPushButton:
    """A button that a click gives no focus, so that Space goes on taking."""
    button = QPushButton(text)
    button.setToolTip(tip)
    button.setStatusTip(tip)
    button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    button.setAutoDefault(False)
    return button
