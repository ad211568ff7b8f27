"""What is asked for beside what lies there now, how still it is, and why it is not taken."""

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from georibbon.calibration.directions import attitude
from georibbon.capture.judging import STRAIGHT_WITHIN
from georibbon.device.stillness import MOST_SPREAD
from georibbon.gui.calibrating.bar_view import BarView
from georibbon.gui.calibrating.signs import colour_of, paint_sign
from georibbon.gui.calibrating.state import LEAST_SECONDS, Card, Lying, share_still
from georibbon.gui.calibrating.words import pose_name, pose_words, told_words
from georibbon.gui.language import N_, tr
from georibbon.gui.theme import colours_of

STRAIGHT = float(np.degrees(STRAIGHT_WITHIN))
STILLNESS = {"still": N_("still"), "moving": N_("moving"), "disturbed": N_("disturbed")}
ROOM = 0.88  # of the ring's width for the word in it
SIGNS = {"still": "good", "moving": "poor", "disturbed": "bad"}


class StillnessRing(QWidget):
    """A ring that fills while the bar lies still; full: long enough."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.stillness = None
        self.setAccessibleName(tr("Stillness"))
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.setFixedSize(96, 96)

    def sizeHint(self) -> QSize:
        """A square."""
        return QSize(96, 96)

    def show_stillness(self, stillness) -> None:
        """Show a `Stillness`, or None for none."""
        if stillness != self.stillness:
            self.stillness = stillness
            self.setAccessibleDescription("" if stillness is None else told_words(stillness.reason))
            self.update()

    def paintEvent(self, _event) -> None:
        """The ring, the seconds, the word."""
        colours = colours_of(self.palette())
        area = QRectF(self.rect()).adjusted(8, 8, -8, -8)
        with QPainter(self) as painter:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(QPen(QColor(colours.frame), 3.0))
            painter.drawEllipse(area)
            found = self.stillness
            state = "moving" if found is None else found.state
            seconds = 0.0 if found is None else found.seconds
            colour = QColor(colour_of(SIGNS[state], colours))
            pen = QPen(colour, 9.0)
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawArc(area, 90 * 16, -round(360 * 16 * share_still(seconds)))
            painter.setPen(QColor(colours.words))
            words = tr("{seconds} s", seconds=f"{min(seconds, 99.0):.1f}")
            upper = area.adjusted(0, 18, 0, -area.height() / 2.0 + 4)
            painter.drawText(upper, Qt.AlignmentFlag.AlignCenter, words)
            painter.setPen(colour)
            lower = area.adjusted(0, area.height() / 2.0 - 2, 0, -12)
            word, font = tr(STILLNESS[state]), self.font()
            room = ROOM * area.width()
            needed = max(self.fontMetrics().horizontalAdvance(word), 1)
            font.setPointSizeF(min(1.0, room / needed) * font.pointSizeF())
            painter.setFont(font)
            painter.drawText(lower, Qt.AlignmentFlag.AlignCenter, word)


class Sign(QWidget):
    """A state's sign in a line of text."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.state = "open"
        self.setFixedSize(18, 18)
        self.setAccessibleName(tr("Verdict"))

    def show_state(self, state: str) -> None:
        """Show another state."""
        self.state = state
        self.update()

    def paintEvent(self, _event) -> None:
        """The sign alone."""
        with QPainter(self) as painter:
            colours = colours_of(self.palette())
            paint_sign(painter, QRectF(self.rect()).adjusted(1, 1, -1, -1), self.state, colours)


class LivePanel(QWidget):
    """The pose asked for, large; the bar as it lies; stillness; and what speaks against it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._nothing_asked = True
        self.title = QLabel()
        font = self.title.font()
        font.setPointSizeF(1.35 * font.pointSizeF())
        font.setBold(True)
        self.title.setFont(font)
        self.words = QLabel()
        self.words.setWordWrap(True)
        self.asked = BarView(tr("As it is asked"))
        self.now = BarView(tr("As it lies now"))
        self.ring = StillnessRing()
        self.match = QLabel()
        self.rest = QLabel()
        self.sign = Sign()
        self.refusal = QLabel()
        for label in (self.match, self.rest, self.refusal):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
        self.refusal.setAccessibleName(tr("Why it is not taken"))
        self.refusal.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.refusal.setMinimumHeight(2 * self.fontMetrics().lineSpacing())
        self.refusal.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._lay_out()

    def _lay_out(self) -> None:
        pictures = QHBoxLayout()
        pictures.addWidget(self.asked, 1)
        pictures.addWidget(self.now, 1)
        figures = QVBoxLayout()
        figures.addStretch()
        figures.addWidget(self.match)
        figures.addWidget(self.rest)
        figures.addStretch()
        below = QHBoxLayout()
        below.addWidget(self.ring)
        below.addLayout(figures, 1)
        told = QHBoxLayout()
        told.addWidget(self.sign, 0, Qt.AlignmentFlag.AlignTop)
        told.addWidget(self.refusal, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.title)
        layout.addWidget(self.words)
        layout.addLayout(pictures, 1)
        layout.addLayout(below)
        layout.addLayout(told)

    def show_card(self, card: Card | None, nothing: str, what_now: str = "") -> None:
        """Show what is asked for; nothing, what_now: the words where nothing is."""
        self._nothing_asked = card is None
        if card is None:
            self.title.setText(nothing)
            self.words.setText(what_now)
            self.asked.show_attitude(None, False)
            return
        pose = card.pose
        self.title.setText(pose_name(card.number))
        self.words.setText(pose_words(pose))
        turned = attitude((pose.roll, pose.heading, pose.pitch, pose.table))
        self.asked.show_attitude(turned, not pose.table)

    def tell(self, state: str, message: str) -> None:
        """A refusal, or what was done last."""
        self.sign.setVisible(bool(message))
        self.sign.show_state(state)
        self.refusal.setText(message)

    def show_live(self, lying: Lying | None, heading: float, stillness) -> None:
        """Show the bar as it lies, with the heading that is asked for, and how still it is."""
        self.ring.show_stillness(stillness)
        self._show_rest(stillness)
        if lying is None:
            self.now.show_attitude(None, False, tr("Nothing is heard."))
            self.match.setText("")
            return
        self.now.show_attitude(lying.attitude(heading), lying.lifted)
        if self._nothing_asked:
            self.match.setText("")
            return
        off = f"{lying.off:.0f}"
        if lying.bent > STRAIGHT:
            words = tr("The ribbon is bent: fix it straight on the bar.")
            self._match(words, "bad")
        elif lying.matches:
            words = tr("It lies as asked, {off}° off. Turn it to the heading by hand.", off=off)
            self._match(words, "good")
        else:
            words = tr("It lies {off}° off; turn the bar as the picture shows.", off=off)
            self._match(words, "poor")

    def _match(self, words: str, state: str) -> None:
        self.match.setText(words)
        colours = colours_of(self.palette())
        sheet = f"color: {colour_of(state, colours)}"
        if self.match.styleSheet() != sheet:
            self.match.setStyleSheet(sheet)

    def _show_rest(self, stillness) -> None:
        if stillness is None:
            self.rest.setText(tr("No frames have come yet."))
            return
        spread = tr(
            "Spread {spread} times its noise ({most} allowed), drift {drift} mg.",
            spread=f"{stillness.spread:.1f}",
            most=f"{MOST_SPREAD:g}",
            drift=f"{stillness.drift:.1f}",
        )
        needed = tr("Still for {seconds} s is needed.", seconds=f"{LEAST_SECONDS:g}")
        told = told_words(stillness.reason) if stillness.state != "still" else needed
        self.rest.setText(f"{told}\n{spread}")
