"""Looking through a session: pass after pass with its notes, and what was done when."""

import math

from PySide6.QtCore import QLocale, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QFont
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from georibbon.gui.language import N_, sentence, tr, trn
from georibbon.gui.parts import Parts
from georibbon.gui.review.calibration_choice import CalibrationChoice
from georibbon.gui.review.compare_table import WORDS as VERDICTS
from georibbon.gui.review.told import ToldLine
from georibbon.gui.review.worker import Worker
from georibbon.gui.theme import colours_of

KIND_WORDS = {
    "capture": N_("Captured"),
    "note": N_("Note"),
    "change": N_("Changed"),
    "link": N_("Link"),
    "file": N_("File"),
}
ALL, OF_PASS = "all", "pass"
FILTERS = {
    ALL: N_("Everything"),
    OF_PASS: N_("This pass"),
    "note": N_("Notes"),
    "capture": N_("What was captured"),
    "change": N_("What was changed"),
    "link": N_("News of the link"),
}
_WHEN, _WHAT, _WORDS = range(3)
_SHOWN_MOST = 500


class HistoryPanel(QWidget):
    """One pass at a time, and below it the session's events.

    pass_chosen(name): another pass is looked at.
    """

    pass_chosen = Signal(str)

    def __init__(self, parts: Parts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts = parts
        self._name: str | None = None
        self._stale = True
        self._facts: dict[object, object] = {}  # of passes' readings, by their recording and name
        self._reader = Worker(self)
        self._make_step()
        self._make_events()
        self._make_layout()
        self._connect()
        self._changed("source")

    # The parts

    def _make_step(self) -> None:
        self.previous, self.next = QPushButton(tr("◀ &Previous")), QPushButton(tr("&Next ▶"))
        self.previous.setToolTip(tr("The pass before this one"))
        self.next.setToolTip(tr("The pass after this one"))
        self.passes = QComboBox()
        self.passes.setAccessibleName(tr("Pass to look at"))
        self.verdict, self.reason = QLabel(), ToldLine()
        font = self.verdict.font()
        font.setBold(True)
        self.verdict.setFont(font)
        self.length, self.sigma, self.smoothing = QLabel(), QLabel(), QLabel()
        self.residuals, self.readings, self.left_out = QLabel(), QLabel(), QLabel()
        self.notes = ToldLine()
        for label in (self.readings, self.left_out):
            label.setWordWrap(True)

    def _make_events(self) -> None:
        self.filter = QComboBox()
        self.filter.setAccessibleName(tr("Which events are shown"))
        for key, words in FILTERS.items():
            self.filter.addItem(tr(words), key)
        self.events = QTreeWidget()
        self.events.setAccessibleName(tr("What was done"))
        self.events.setRootIsDecorated(False)
        self.events.setAlternatingRowColors(True)
        self.events.setHeaderLabels([tr("When"), tr("What"), tr("Which")])
        self.events.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.events.setWordWrap(True)
        resize = QHeaderView.ResizeMode.ResizeToContents
        self.events.header().setSectionResizeMode(_WHEN, resize)
        self.events.header().setSectionResizeMode(_WHAT, resize)
        self.note = QLineEdit()
        self.note.setPlaceholderText(tr("Write a note"))
        self.note.setAccessibleName(tr("A new note"))
        self.note_of = QComboBox()
        self.note_of.setAccessibleName(tr("What the note is about"))
        self.add = QPushButton(tr("&Add note"))
        self.told = ToldLine()
        self.calibration = CalibrationChoice(self._parts)

    def _make_layout(self) -> None:
        step = QHBoxLayout()
        step.addWidget(self.previous)
        step.addWidget(self.passes, 1)
        step.addWidget(self.next)
        card = QWidget()
        facts = QFormLayout(card)
        facts.setContentsMargins(4, 0, 4, 0)
        facts.setVerticalSpacing(3)
        facts.setRowWrapPolicy(QFormLayout.RowWrapPolicy.DontWrapRows)
        for words, part in (
            (tr("Verdict"), self.verdict), ("", self.reason), (tr("Length"), self.length),
            (tr("Uncertainty"), self.sigma), (tr("Smoothing"), self.smoothing),
            (tr("Residuals"), self.residuals), (tr("Readings"), self.readings),
            (tr("Left out"), self.left_out), (tr("Notes"), self.notes),
        ):  # fmt: skip
            facts.addRow(words, part)
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QScrollArea.Shape.NoFrame)
        scroll.setWidget(card)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        upper, lower = QWidget(), QWidget()
        column = QVBoxLayout(upper)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.calibration)
        column.addLayout(step)
        column.addWidget(scroll, 1)
        writing = QHBoxLayout()
        writing.addWidget(self.note, 1)
        writing.addWidget(self.note_of)
        writing.addWidget(self.add)
        column = QVBoxLayout(lower)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.filter)
        column.addWidget(self.events, 1)
        column.addLayout(writing)
        column.addWidget(self.told)
        parts = QSplitter(Qt.Orientation.Vertical)
        parts.setChildrenCollapsible(False)
        parts.addWidget(upper)
        parts.addWidget(lower)
        QVBoxLayout(self).addWidget(parts)

    def _connect(self) -> None:
        document = self._parts.document
        document.changed.connect(self._changed)
        document.reconstructed.connect(self._show_pass)
        self._parts.units.changed.connect(self._show_pass)
        self.previous.clicked.connect(lambda: self.step(-1))
        self.next.clicked.connect(lambda: self.step(1))
        self.passes.activated.connect(lambda at: self.choose(self.passes.itemText(at)))
        self.filter.currentIndexChanged.connect(self._show_events)
        self.events.itemActivated.connect(self._activated)
        self.add.clicked.connect(self._add_note)
        self.note.returnPressed.connect(self._add_note)
        self.note.textChanged.connect(self._can_add)
        self._reader.done.connect(self._read)
        self._reader.failed.connect(self.readings.setText)
        self._reader.fault.connect(self._parts.notifier.exception)

    # What a person asks for

    @property
    def chosen(self) -> str | None:
        """The name of the pass that is looked at."""
        return self._name

    def step(self, by: int) -> None:
        """Look at the pass so many places further on."""
        names = [one.name for one in self._parts.document.passes]
        if names:
            at = names.index(self._name) + by if self._name in names else 0
            self.choose(names[min(max(at, 0), len(names) - 1)])

    def choose(self, name: str) -> None:
        """Look at a pass."""
        if name != self._name and name in [one.name for one in self._parts.document.passes]:
            self._name = name
            self._show_pass()
            if self.filter.currentData() == OF_PASS:
                self._show_events()
            self.note_of.setCurrentIndex(max(self.note_of.findData(name), 0))
            self.pass_chosen.emit(name)

    def write_note(self) -> None:
        """Begin to write a note, where the keys are then."""
        self.note.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def _add_note(self) -> None:
        text = self.note.text().strip()
        if text and self._parts.document.note(text, self.note_of.currentData()):
            self.note.clear()

    def _can_add(self) -> None:
        self.add.setEnabled(bool(self.note.text().strip()) and self.note.isEnabled())

    def _activated(self, item: QTreeWidgetItem) -> None:
        name = item.data(0, Qt.ItemDataRole.UserRole)
        if name:
            self.choose(name)

    # What is shown

    def _changed(self, what: str) -> None:
        document = self._parts.document
        names = [one.name for one in document.passes]
        if what == "source":
            self._facts.clear()
            self._reader.forget()
        if self._name not in names:
            self._name = names[0] if names else None
        self.passes.clear()
        self.passes.addItems(names)
        of = self.note_of.currentData()
        self.note_of.clear()
        self.note_of.addItem(tr("the session"), None)
        for name in names:
            self.note_of.addItem(name, name)
        self.note_of.setCurrentIndex(max(self.note_of.findData(of), 0))
        writable = document.session is not None
        for part in (self.note, self.note_of):
            part.setEnabled(writable)
        self._can_add()
        self.told.tell(self._why_no_notes())
        self._show_pass()
        self._show_events()

    def showEvent(self, event) -> None:
        """It is seen again: what has happened meanwhile is listed."""
        super().showEvent(event)
        if self._stale:
            self._show_events()

    def _why_no_notes(self) -> str:
        document = self._parts.document
        if document.path is None or document.session is not None:
            return ""
        if document.state is None:
            return tr("A recording folder keeps no notes; import it into a session first.")
        return tr("This session can only be read, so no note can be added.")

    def _show_pass(self) -> None:
        document, units = self._parts.document, self._parts.units
        names = [one.name for one in document.passes]
        at = names.index(self._name) if self._name in names else -1
        self.passes.setCurrentIndex(at)
        self.previous.setEnabled(at > 0)
        self.next.setEnabled(0 <= at < len(names) - 1)
        result = document.reconstruction
        fitted = None
        if result is not None:
            fitted = next((one for one in result.passes if one.name == self._name), None)
        if fitted is None:
            self.verdict.setText(tr("not reconstructed yet") if at >= 0 else "")
            self.reason.tell("")
            for label in (self.length, self.sigma, self.smoothing, self.residuals, self.left_out):
                label.setText("")
        else:
            sigma = fitted.position_sigma
            rms = math.hypot(*sigma) / math.sqrt(len(sigma))
            self.verdict.setText(tr(VERDICTS[fitted.quality.verdict]))
            self._colour_verdict(fitted.quality.verdict)
            self.reason.tell(sentence(fitted.quality.reason))
            self.length.setText(units.text(float(fitted.strip.s[-1] - fitted.strip.s[0])))
            self.sigma.setText(
                tr(
                    "{rms} (1σ), at most {most}",
                    rms=units.text(rms, 1),
                    most=units.text(float(sigma.max()), 1),
                )
            )
            self.smoothing.setText(units.text(fitted.smoothing))
            self.residuals.setText(
                tr("{rms} of their standard deviations", rms=f"{fitted.residual_rms:.2f}")
            )
            ignored = ", ".join(fitted.sensors_ignored)
            self.left_out.setText(ignored or tr("no sensor"))
        self._show_notes()
        self._show_readings()

    def _colour_verdict(self, verdict: str) -> None:
        colours = colours_of(self.palette())
        words = {"good": colours.good, "acceptable": colours.fair, "redo": colours.poor}[verdict]
        self.verdict.setStyleSheet(f"color: {words}")

    def changeEvent(self, event) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == event.Type.PaletteChange and hasattr(self, "events"):
            self._show_pass()
            self._show_events()

    def _show_notes(self) -> None:
        state = self._parts.document.state
        notes = () if state is None else state.notes
        texts = [one.text for one in notes if one.pass_name == self._name and self._name]
        self.notes.tell("\n".join(f"• {text}" for text in texts) or tr("none"))

    def _show_readings(self) -> None:
        """A glance at the raw readings, made beside the window the first time."""
        recording, name = self._parts.document.recording, self._name
        captured = [] if recording is None else recording.passes
        one = next((run for run in captured if run.name == name), None)
        if one is None:
            self.readings.setText("")
            return
        facts = self._facts.get(one.readings)
        if facts is not None:
            self.readings.setText(self._facts_words(facts))
            return
        self.readings.setText("…")

        def work() -> object:
            from georibbon.session.history import readings_facts

            return one.readings, readings_facts(one.readings, recording.ribbon)

        self._reader.ask(work)

    def _read(self, found: object) -> None:
        readings, facts = found
        self._facts[readings] = facts
        self._show_readings()

    def _facts_words(self, facts) -> str:
        words = trn("{n} frame", "{n} frames", facts.frames)
        if facts.rate is not None:
            words = tr(
                "{frames} in {seconds} s ({rate} a second)",
                frames=words,
                seconds=f"{facts.seconds:.1f}",
                rate=f"{facts.rate:.0f}",
            )
        if facts.lost:
            words += "; " + trn("{n} value lost", "{n} values lost", facts.lost)
        if facts.restless is not None:
            name, moved = facts.restless
            words += "; " + tr("{axis} moved most, {moved} ‰", axis=name, moved=f"{moved:.2f}")
        return words

    def _show_events(self) -> None:
        """List what happened; only where it is seen: a long session has thousands."""
        self._stale = not self.isVisible()
        if self._stale:
            return
        self.events.clear()
        state = self._parts.document.state
        if state is None:
            return
        from georibbon.session.history import entries

        wanted = [one for one in entries(state.history) if self._is_wanted(one)]
        for entry in wanted[-_SHOWN_MOST:]:
            self.events.addTopLevelItem(self._item(entry))
        if wanted:
            self.events.scrollToBottom()

    def _is_wanted(self, entry) -> bool:
        wanted = self.filter.currentData()
        if wanted == OF_PASS:
            return entry.pass_name == self._name
        return wanted in (ALL, entry.kind)

    def _item(self, entry) -> QTreeWidgetItem:
        time = entry.local_time
        when = QLocale().toString(time, QLocale.FormatType.ShortFormat)
        of = f" ({entry.pass_name})" if entry.kind == "note" and entry.pass_name else ""
        undone = f" – {tr('taken back')}" if entry.undone else ""
        words = entry.words if entry.kind == "note" else sentence(entry.words)
        item = QTreeWidgetItem([when, tr(KIND_WORDS[entry.kind]), f"{words}{of}{undone}"])
        item.setToolTip(_WHEN, time.isoformat(" ", "milliseconds"))
        item.setToolTip(_WORDS, words)
        item.setData(0, Qt.ItemDataRole.UserRole, entry.pass_name)
        if entry.undone:
            font = QFont(self.font())
            font.setStrikeOut(True)
            item.setFont(_WORDS, font)
            for column in (_WHEN, _WHAT, _WORDS):
                item.setForeground(column, QBrush(QColor(colours_of(self.palette()).dim)))
        return item
