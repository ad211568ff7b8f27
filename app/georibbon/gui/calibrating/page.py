"""The page that calibrates a ribbon: begin, take pose after pose, keep; and the daily check."""

import datetime
import re
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QStackedWidget, QVBoxLayout, QWidget

from georibbon.calibration.calibrate import calibrate
from georibbon.calibration.change import difference
from georibbon.calibration.check import Check, check_calibration
from georibbon.calibration.directions import covered
from georibbon.calibration.expected import expected_errors
from georibbon.calibration.gates import LEAST_POSES
from georibbon.calibration.model import Calibration
from georibbon.capture.plan import CapturePlan
from georibbon.errors import GeoribbonError
from georibbon.gui.calibrating.done_view import DoneView
from georibbon.gui.calibrating.kept_list import local_time
from georibbon.gui.calibrating.posing import PosingView
from georibbon.gui.calibrating.start_view import HEMISPHERES, StartView
from georibbon.gui.calibrating.state import CHECK_KEYS, done, with_keys
from georibbon.gui.calibrating.words import told_words
from georibbon.gui.calibrating.worker import Worker
from georibbon.gui.capturing.sound import Sounds
from georibbon.gui.files import calibrations_folder
from georibbon.gui.language import N_, tr
from georibbon.gui.parts import Parts
from georibbon.session.calibration_file import write_calibration
from georibbon.session.calibration_shelf import Kept, Shelf
from georibbon.threads import one_thread

FILES = N_("Calibrations (*.json)")
SESSIONS, ENDING = "sessions", ".georibbon"
PLACE = "calibration/hemisphere"
SOUNDS = ("taken", "refused", "complete")
COUNTED = ("taken", "skipped", "removed", "undone", "redone", "held")


class CalibrationPage(QWidget):
    """The calibration wizard.

    finished(calibration): the person wants to capture with it.  connect_wanted():
    a ribbon must be connected first.  folder: where calibrations are kept, in the
    place of the user's own.
    """

    finished = Signal(object)
    connect_wanted = Signal()

    def __init__(
        self, parts: Parts, parent: QWidget | None = None, folder: Path | None = None
    ) -> None:
        super().__init__(parent)
        self._parts, self._desk = parts, parts.capture
        self.shelf = Shelf(calibrations_folder() if folder is None else folder)
        self._sounds = Sounds(parts)
        self._judge, self._reader = Worker(self), Worker(self)
        self._checked: Kept | None = None  # what a daily check is of
        self._ours = False  # whether the capture that goes on was begun here
        self._stale = False  # whether what was computed is of other poses than are taken
        self._found: Calibration | None = None
        self._kept: Kept | None = None
        self.start, self.posing, self.done = StartView(self.shelf), PosingView(parts), DoneView()
        self.stack = QStackedWidget()
        for view in (self.start, self.posing, self.done):
            self.stack.addWidget(view)
        layout = QVBoxLayout(self)
        layout.addWidget(self.stack)
        self._connect()
        self._show_start()

    def _connect(self) -> None:
        desk, start, posing, done_view = self._desk, self.start, self.posing, self.done
        desk.began.connect(self._began)
        desk.ended.connect(self._ended)
        desk.failed.connect(self._failed)
        desk.refreshed.connect(self._glance)
        desk.happened.connect(self._happened)
        desk.refused.connect(self._refused)
        desk.stood.connect(self._stood)
        self._parts.station.identified.connect(lambda _=None: self._show_ribbon())
        self._parts.station.disconnected.connect(self._show_ribbon)
        self._judge.done.connect(self._judged)
        self._reader.done.connect(self._read)
        start.begin.connect(self.begin)
        start.go_on.connect(self.go_on)
        start.connect_wanted.connect(self.connect_wanted)
        start.placed.connect(lambda key: self._parts.settings.put(PLACE, key))
        start.kept.altered.connect(self.show_kept)
        start.kept.wanted.connect(self._wanted)
        start.kept.chosen.connect(self._show_ribbon)
        posing.ending.connect(self.stop)
        posing.finish_button.clicked.connect(self._show_done)
        done_view.keep.connect(self.keep)
        done_view.export.connect(self.export)
        done_view.use.connect(self._use)
        done_view.back.connect(lambda: self.stack.setCurrentWidget(self.posing))

    # The page comes into sight and goes

    def entered(self) -> None:
        """It came into sight."""
        self.show_kept()
        if self._desk.active and self._has_poses():
            if self.stack.currentWidget() is self.start:
                self._began()
        elif not self._desk.active and self.stack.currentWidget() is self.posing:
            self._show_start()

    def left(self) -> None:
        """It goes out of sight; what is not finished goes on."""
        self._sounds.end()
        if self._ours and self._kept is not None and self._kept.calibration is self._found:
            self._desk.end()  # it is made and kept: the ribbon is free for a capture
            self._show_start()

    def end(self) -> None:
        """Wait for what is computed; nothing is done after it."""
        self._judge.end()
        self._reader.end()
        self._sounds.end()

    def closeEvent(self, event) -> None:
        """Wait for what is computed."""
        self.end()
        super().closeEvent(event)

    # What the window's actions do

    def take(self) -> None:
        """Take the pose that is asked for."""
        self._desk.take()

    def take_anyway(self) -> None:
        """Take it although something that may be overruled speaks against it."""
        self._desk.take(True)

    def skip(self) -> None:
        """Leave out the pose that is asked for."""
        self._desk.skip()

    def choose_next(self) -> None:
        """Ask for the next pose that is not taken."""
        self.posing.choose_next()

    def set_auto(self, auto: bool) -> None:
        """Take by stillness, or only when asked."""
        self._desk.set_auto(auto)

    def undo(self) -> None:
        """Take back the last change."""
        self._desk.undo()

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._desk.redo()

    def begin(self, poses: int) -> None:
        """Begin a new calibration by a plan of so many poses."""
        path = self._new_session("calibration")
        if path is not None:
            self._checked = None
            self._begin(path, CapturePlan(poses=poses, passes=0, ties=0))

    def go_on(self) -> None:
        """Go on with the calibration that was begun last."""
        path = self._begun_last()
        if path is not None and self._may_begin():
            self._checked = None
            self._begin(path, None)

    def begin_check(self) -> None:
        """Check the chosen calibration, or the ribbon's newest, by three poses."""
        kept, ribbon = self.start.kept.current, self._ribbon()
        if ribbon is not None and (kept is None or kept.calibration.ribbon_id != ribbon.id):
            kept = self.shelf.newest(ribbon.id)
        path = self._new_session("check")
        if path is not None and kept is None:
            self._tell(
                tr("No calibration of this ribbon is kept; calibrate it first, or load one.")
            )
        elif path is not None and kept is not None:
            self._checked = kept
            self._begin(path, CapturePlan(poses=20, passes=0, ties=0), kept.calibration)

    def stop(self) -> None:
        """Stop for now: what was taken is in its file, and can be gone on with."""
        if self._ours:
            self._desk.end()
        self._show_start()

    # Beginnings and ends

    def _begin(
        self, path: Path, plan: CapturePlan | None, calibration: Calibration | None = None
    ) -> None:
        self.start.told.clear()
        self._ours = True
        self._desk.begin(path, plan, calibration)

    def _tell(self, sentence: str) -> None:
        """Why something cannot begin, where a person looks now."""
        view = self.stack.currentWidget()
        if view is self.posing:
            self.posing.tell_refusal(sentence)
        elif view is self.done:
            self.done.tell(sentence)
        else:
            self.start.told.setText(sentence)

    def _may_begin(self) -> bool:
        """Whether anything can be begun now; told why where not."""
        why = ""
        if self._desk.beginning:  # a second click on the way
            return False
        if self._desk.active:
            why = tr("A capture is going on already; end it first.")
        elif self._parts.station.identity is None:
            why = tr("No ribbon is connected; connect one first.")
        if why:
            self._tell(why)
        return not why

    def _new_session(self, what: str) -> Path | None:
        """Where a new session is put; None, and told why, where none can be begun now."""
        ribbon = self._ribbon()
        if not self._may_begin() or ribbon is None:
            return None
        folder = self.shelf.folder / SESSIONS
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self._tell(f"{folder}: {error.strerror}")
            return None
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", ribbon.id)[:40]
        moment = datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H%M%S.%f")[:-3]
        return folder / f"{what} {plain} {moment}{ENDING}"

    def _begun_last(self) -> Path | None:
        """The calibration's session that was written last."""
        try:
            found = list((self.shelf.folder / SESSIONS).glob(f"calibration *{ENDING}"))
            return max(found, key=lambda path: path.stat().st_mtime, default=None)
        except OSError:
            return None

    def _has_poses(self) -> bool:
        return any(item.is_pose for item in self._desk.items)

    def _began(self) -> None:
        if not self._has_poses():
            return
        self._found = self._kept = None
        self._stale = False
        self._judge.forget()
        self.posing.start(self._checked is not None, self._title())
        self.stack.setCurrentWidget(self.posing)
        if self._checked is None:
            self._ask_quality()

    def _title(self) -> str:
        session = self._desk.session
        name = "" if session is None else session.path.name
        if self._checked is not None:
            return tr("Daily check of “{name}” – {file}", name=self._checked.name, file=name)
        return tr("Calibration – {file}", file=name)

    def _ended(self) -> None:
        self._ours = False
        self._checked = None
        self._judge.forget()
        if self.stack.currentWidget() is self.posing:
            self._show_start()

    def _failed(self, told: str) -> None:
        if self._ours:
            self._ours = False
            self._checked = None
            self.start.told.setText(told_words(told))

    # News of the capture

    def _glance(self, glance) -> None:
        if self.posing.isVisible():
            self.posing.show_glance(glance)

    def _stood(self) -> None:
        if self._desk.active and self.stack.currentWidget() is not self.start:
            self.posing.show_standing()
            self.posing.ask_for_check()
            self._compute()
            self._show_progress()

    def _compute(self) -> None:
        """What is taken has changed: compute what depends on it.

        A happening is told before the checklist shows it.
        """
        if not self._stale:
            return
        self._stale = False
        if self.posing.checking:
            self._ask_check()
        else:
            self._ask_quality()

    def _happened(self, happening) -> None:
        if not self._has_poses():
            return
        self.posing.take_news(happening)
        if self.isVisible() and happening.kind in SOUNDS and not self._incomplete(happening):
            self._sounds.play(happening.kind)
        self._stale |= happening.kind in COUNTED
        self._show_progress()

    def _incomplete(self, happening) -> bool:
        """Whether it is told complete only because no plan asks for the check's next pose."""
        return happening.kind == "complete" and self.posing.checking

    def _refused(self, told: str) -> None:
        if self.stack.currentWidget() is self.posing:
            self.posing.tell_refusal(told)

    def _show_progress(self) -> None:
        cards = self.posing.cards
        left = any(card.state in ("open", "asked", "refused") for card in cards)
        finished = self._found is not None and not left
        self.posing.quality.show_progress(done(cards), len(cards), finished)
        self.posing.finish_button.setVisible(not self.posing.checking)
        self.posing.finish_button.setEnabled(self._found is not None)

    # What is computed beside

    def _ask_quality(self) -> None:
        """Calibrate from what is taken by now, in a worker."""
        session, ribbon = self._desk.session, self._ribbon()
        if session is None or ribbon is None:
            return
        taken = done(self.posing.cards)
        if taken < LEAST_POSES:
            self._found = None
            self._judge.forget()
            self.posing.quality.show_nothing(taken)
            return
        place = self._parts.settings.get(PLACE, "")
        hemisphere = place if place in HEMISPHERES and place else None

        def work() -> Calibration:
            poses = session.recording(complete=False).poses
            with one_thread():
                return calibrate(ribbon, poses, hemisphere=hemisphere)

        self._judge.ask(work)

    def _ask_check(self) -> None:
        """Check by what is taken, once all poses of the check are."""
        session, ribbon, kept = self._desk.session, self._ribbon(), self._checked
        if session is None or ribbon is None or kept is None:
            return
        taken = done(self.posing.cards)
        if taken < len(CHECK_KEYS):
            self._judge.forget()
            self.posing.check.show_nothing(len(CHECK_KEYS) - taken, "")
            return
        names = {pose.name for pose in self.posing.planned()}

        def work() -> Check:
            poses = [one for one in session.recording(complete=False).poses if one.name in names]
            with one_thread():
                return check_calibration(ribbon, kept.calibration, poses)

        self._judge.ask(work)

    def _judged(self, result: object, error: Exception | None) -> None:
        if error is not None and not isinstance(error, GeoribbonError):
            self._parts.notifier.exception(error)
        told = told_words(str(error)) if error is not None else ""
        if self.posing.checking:
            self._show_check(result, told)
        elif isinstance(result, Calibration):
            self._show_quality(result)
        else:
            self._found = None
            self.posing.quality.show_nothing(done(self.posing.cards), told)
        self._show_progress()

    def _show_quality(self, calibration: Calibration) -> None:
        ribbon = self._ribbon()
        if ribbon is None or calibration.quality is None:
            return
        self._found = calibration
        self.posing.show_dip(calibration.dip)
        planned = self.posing.planned()
        self.posing.progress.judge(planned, calibration.notices)
        self.posing.show_standing()
        told = self._told(calibration)
        expected = expected_errors(ribbon, calibration)
        for panel in (self.posing.quality, self.done.quality):
            panel.show_quality(calibration, expected, told)
        cards = self.posing.cards
        all_good = bool(cards) and all(card.state in ("good", "skipped") for card in cards)
        if self._ours and all_good and not self._judge.busy:  # what comes next may say otherwise
            self._show_done()

    def _told(self, calibration: Calibration) -> list[str]:
        keys = {pose.name: pose.key for pose in self.posing.planned()}
        cards = self.posing.cards
        return [told_words(with_keys(one.message, keys), cards) for one in calibration.notices]

    def _show_check(self, result: object, told: str) -> None:
        if not isinstance(result, Check):
            self.posing.check.show_nothing(0, told)
            return
        planned, cards = self.posing.planned(), self.posing.cards
        keys = {pose.name: pose.key for pose in planned}
        findings = [told_words(with_keys(one.message, keys), cards) for one in result.findings]
        self.posing.check.show_check(result, findings)
        self.posing.progress.judge(planned, result.findings)
        self.posing.show_standing()
        self._sounds.play("complete")
        try:
            if self._checked is not None:
                self._checked = self.shelf.note_check(
                    self._checked, result.verdict, result.degrees, result.reason
                )
        except GeoribbonError as error:
            self.posing.tell_refusal(told_words(str(error)))

    # What is made, and what is kept

    def _show_done(self) -> None:
        calibration, ribbon = self._found, self._ribbon()
        if calibration is None or ribbon is None or calibration.quality is None:
            return
        poses = calibration.quality.poses
        self.done.quality.show_progress(poses, poses, True)
        if not self._is_kept(calibration):
            moment = datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M")
            self.done.show_name(tr("{ribbon}, {moment}", ribbon=ribbon.id, moment=moment))
            self._show_change(calibration, ribbon)
        self.done.quality.show_covered(self._covered())
        self.stack.setCurrentWidget(self.done)
        self.done.name.setFocus()

    def _covered(self):
        cards = self.posing.cards
        asked = [(c.pose.roll, c.pose.heading, c.pose.pitch, c.pose.table) for c in cards]
        return covered(asked, [card.state in ("good", "poor") for card in cards])

    def _show_change(self, calibration: Calibration, ribbon) -> None:
        """What has changed since the newest one that is kept of this ribbon."""
        last = self.shelf.newest(ribbon.id)
        if last is None:
            self.done.show_change(tr("This is the first calibration of this ribbon."), None)
            return
        since = tr("Since “{name}” of {time}:", name=last.name, time=local_time(last.made))
        try:
            self.done.show_change(since, difference(ribbon, last.calibration, calibration))
        except GeoribbonError as error:
            self.done.show_change(f"{since} {told_words(str(error))}", None)

    def keep(self, name: str) -> None:
        """Keep the calibration that was made, under a name."""
        if self._found is None:
            return
        try:
            self._kept = self.shelf.keep(self._found, name)
        except GeoribbonError as error:
            self.done.tell(told_words(str(error)))
            return
        self.done.show_kept(tr("It is kept as “{name}”, in {path}", name=self._kept.name,
                               path=self._kept.path))  # fmt: skip
        self.show_kept()

    def _use(self) -> None:
        """Capture with the calibration that was made; it is kept first."""
        calibration = self._found
        if calibration is None:
            return
        if not self._is_kept(calibration):
            self.keep(self.done.name.text())
        if self._is_kept(calibration):  # an earlier one may be, and this one not
            self._leave(calibration)

    def _is_kept(self, calibration: Calibration) -> bool:
        return self._kept is not None and self._kept.calibration is calibration

    def _leave(self, calibration: Calibration) -> None:
        if self._ours:
            self._desk.end()
        self._show_start()
        self.finished.emit(calibration)

    def _wanted(self, what: str) -> None:
        kept = self.start.kept.current
        if what == "load":
            self.load()
        elif kept is None:
            return
        elif what == "check":
            self.begin_check()
        elif what == "export":
            self.export(kept)
        else:
            self._leave(kept.calibration)

    def load(self) -> None:
        """Keep a calibration from a file."""
        path = ask_file(self, tr("Load a calibration"))
        if path is None:
            return
        try:
            kept = self.shelf.load(path)
        except GeoribbonError as error:
            self.start.kept.tell(told_words(str(error)))
            return
        self.start.kept.tell(tr("“{name}” is kept.", name=kept.name))
        self.show_kept()

    def export(self, kept: Kept | None = None) -> None:
        """Write a calibration to a file: the chosen one, or that which was made."""
        tell = self.done.tell if kept is None else self.start.kept.tell
        calibration = self._found if kept is None else kept.calibration
        if calibration is None:
            return
        name = self.done.name.text() if kept is None else kept.name
        plain = re.sub(r"[^\w .,-]+", "-", name).strip() or "calibration"
        path = ask_target(self, tr("Export the calibration"), f"{plain}.json")
        if path is None:
            return
        try:
            write_calibration(calibration, path, {"name": name})
        except GeoribbonError as error:
            tell(told_words(str(error)))
            return
        tell(tr("Written: {path}", path=path))

    def show_kept(self) -> None:
        """Read what is kept, in a worker, and show it."""
        self._reader.ask(self.shelf.look)
        self.start.show_where(self.shelf.folder, self._begun_last())

    def _read(self, result: Sequence | None, error: Exception | None) -> None:
        if error is not None:
            self._parts.notifier.exception(error)
        elif result is not None:
            self.start.kept.show_kept(*result)

    def _ribbon(self):
        """The ribbon of the capture that goes on, or that is connected."""
        session = self._desk.session
        if session is not None and session.state.ribbon is not None:
            return session.state.ribbon
        identity = self._parts.station.identity
        return None if identity is None else identity.ribbon

    def _show_start(self) -> None:
        self.start.show_place(self._parts.settings.get(PLACE, ""))
        self._show_ribbon()
        self.show_kept()
        self.stack.setCurrentWidget(self.start)

    def _show_ribbon(self) -> None:
        identity = self._parts.station.identity
        ribbon = None if identity is None else identity.ribbon
        self.start.show_ribbon(ribbon)
        self.start.go_on_button.setEnabled(ribbon is not None)
        kept = self.start.kept.current
        fits = ribbon is not None and kept is not None and kept.calibration.ribbon_id == ribbon.id
        self.start.kept.buttons["check"].setEnabled(fits)


def ask_file(parent: QWidget, title: str) -> Path | None:
    """A calibration's file that is there."""
    found, _ = QFileDialog.getOpenFileName(parent, title, "", tr(FILES))
    return Path(found) if found else None


def ask_target(parent: QWidget, title: str, proposal: str) -> Path | None:
    """A calibration's file to write."""
    found, _ = QFileDialog.getSaveFileName(parent, title, proposal, tr(FILES))
    if not found:
        return None
    path = Path(found)
    return path if path.suffix else path.with_suffix(".json")
