"""The sphere of directions: two hemispheres side by side, a point for each direction of gravity.

A hemisphere is a disc by Lambert's equal-area projection: at the angle t from its middle
the radius is sqrt(1 - cos t), 1 at the rim.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from georibbon.calibration.directions import directions_of_field, directions_of_gravity
from georibbon.gui.calibrating.signs import paint_sign
from georibbon.gui.calibrating.state import Card
from georibbon.gui.calibrating.words import pose_name
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of

SAME = np.radians(3.0)
SEEN = 0.01  # radians by which the cross must move to be seen to
# The most telling of the states of poses at one point is shown.
TELLING = ("refused", "asked", "open", "skipped", "poor", "good")


@dataclass(frozen=True)
class Point:
    """One direction: the keys of its poses, in which disc (0, 1) and where in it, its state."""

    keys: tuple[str, ...]
    numbers: tuple[int, ...]
    disc: int
    place: tuple[float, float]
    state: str
    taken: int


def place_of(up) -> tuple[int, tuple[float, float]]:
    """The disc of a direction (3,), 0 with the upper face up, and its place, y upward."""
    x, y, z = (float(value) for value in up)
    level = float(np.hypot(x, y))
    radius = float(np.sqrt(max(1.0 - abs(z), 0.0)))
    share = radius / level if level > 1e-9 else 0.0
    return (0 if z >= -1e-6 else 1), (x * share, y * share)


def points_of(cards: Sequence[Card], dip: float | None = None) -> list[Point]:
    """The points of all poses, of gravity, or of a field with a dip; those at one place are one."""
    asked = [(c.pose.roll, c.pose.heading, c.pose.pitch, c.pose.table) for c in cards]
    ups = directions_of_gravity(asked) if dip is None else directions_of_field(asked, dip)
    groups: list[list[int]] = []
    for i, up in enumerate(ups):
        near = next((g for g in groups if ups[g[0]] @ up > np.cos(SAME)), None)
        if near is None:
            groups.append([i])
        else:
            near.append(i)
    found = []
    for group in groups:
        disc, place = place_of(ups[group[0]])
        states = {cards[i].state for i in group}
        state = next(one for one in TELLING if one in states)
        taken = sum(cards[i].state in ("good", "poor") for i in group)
        if taken == len(group):
            state = "poor" if "poor" in states else "good"
        keys = tuple(cards[i].key for i in group)
        numbers = tuple(cards[i].number for i in group)
        found.append(Point(keys, numbers, disc, place, state, taken))
    return found


class SphereView(QWidget):
    """The directions of gravity, or of the field, in the ribbon's frame.

    asked(key): a point was clicked.
    """

    asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.points: list[Point] = []
        self._live = None
        self.setAccessibleName(tr("Directions covered"))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(200, 116)
        self.setMouseTracking(True)

    def sizeHint(self) -> QSize:
        """Two discs."""
        return QSize(360, 190)

    def show_cards(self, cards: Sequence[Card], dip: float | None = None) -> None:
        """Show the directions of these poses: of gravity, or of a field with a dip (radians)."""
        self.points = points_of(cards, dip)
        covered = sum(point.taken == len(point.keys) for point in self.points)
        self.setAccessibleDescription(
            tr("{covered} of {all} directions are covered", covered=covered, all=len(self.points))
        )
        self.update()

    def show_live(self, up) -> None:
        """Show the direction (3,) in which gravity is now; None: not known."""
        before, self._live = self._live, up
        if up is None or before is None:
            if up is not before:
                self.update()
        elif abs(up - before).max() > SEEN:
            self.update()
        else:
            self._live = before

    def place(self, point: Point) -> QPointF:
        """Where a point is drawn."""
        return self._at(point.disc, point.place)

    def _disc(self, number: int) -> QRectF:
        line = self.fontMetrics().height()
        size = min(self.width() / 2.0 - 16.0, self.height() - 3.6 * line)
        centre = QPointF(self.width() * (0.25 + 0.5 * number), 0.5 * self.height() + 0.5 * line)
        return QRectF(centre.x() - size / 2.0, centre.y() - size / 2.0, size, size)

    def _at(self, disc: int, place) -> QPointF:
        area = self._disc(disc)
        half = area.width() / 2.0
        return area.center() + QPointF(half * place[0], -half * place[1])

    def paintEvent(self, _event) -> None:
        """The discs, the points, and a cross for the direction of now."""
        colours = colours_of(self.palette())
        with QPainter(self) as painter:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            for number, title in enumerate((tr("upper face up"), tr("face down"))):
                self._paint_disc(painter, number, title, colours)
            for point in self.points:
                self._paint_point(painter, point, colours)
            if self._live is not None:
                at = self._at(*place_of(self._live))
                painter.setPen(QPen(QColor(colours.words), 2.0))
                for along in (QPointF(9.0, 0.0), QPointF(0.0, 9.0)):
                    painter.drawLine(at - along, at + along)

    def _paint_disc(self, painter, number: int, title: str, colours) -> None:
        area = self._disc(number)
        line = self.fontMetrics().height()
        painter.setPen(QPen(QColor(colours.frame), 1.0))
        painter.setBrush(QColor(colours.base))
        painter.drawEllipse(area)
        painter.setPen(QPen(QColor(colours.frame), 0.6, Qt.PenStyle.DotLine))
        painter.drawLine(
            QPointF(area.left(), area.center().y()), QPointF(area.right(), area.center().y())
        )
        painter.drawLine(
            QPointF(area.center().x(), area.top()), QPointF(area.center().x(), area.bottom())
        )
        painter.setPen(QColor(colours.words))
        above = QRectF(area.left() - 40, area.top() - 2.4 * line, area.width() + 80, line)
        middle = Qt.AlignmentFlag.AlignCenter
        painter.drawText(above, middle, title)
        painter.setPen(QColor(colours.dim))
        painter.drawText(above.translated(0, line), middle, tr("left edge"))
        painter.drawText(above.translated(0, area.height() + 2.6 * line), middle, tr("right edge"))
        inside = QRectF(area.left() + 4, area.center().y() + 1, area.width() - 8, line)
        painter.drawText(inside, Qt.AlignmentFlag.AlignRight, tr("end"))
        painter.drawText(inside, Qt.AlignmentFlag.AlignLeft, tr("start"))

    def _paint_point(self, painter, point: Point, colours) -> None:
        at, size = self.place(point), 13.0
        area = QRectF(at.x() - size / 2.0, at.y() - size / 2.0, size, size)
        if point.state in ("asked", "refused"):
            painter.setPen(QPen(QColor(colours.link), 2.0))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(area.adjusted(-4, -4, 4, 4))
        paint_sign(painter, area, point.state, colours)
        if len(point.keys) > 1:
            painter.setPen(QColor(colours.words))
            text = tr("{taken}/{all}", taken=point.taken, all=len(point.keys))
            below = area.adjusted(-14, size + 1.0, 14, size + 1.0)
            if point.place[1] < -0.5:
                below.translate(0.0, -2.0 * size - 2.0)
            painter.drawText(below, Qt.AlignmentFlag.AlignCenter, text)

    def _near(self, place: QPointF) -> Point | None:
        for point in self.points:
            away = self.place(point) - place
            if away.x() ** 2 + away.y() ** 2 < 12.0**2:
                return point
        return None

    def mousePressEvent(self, event) -> None:
        """Ask for the first pose of a point that is not taken."""
        point = self._near(event.position())
        if point is not None and event.button() == Qt.MouseButton.LeftButton:
            self.asked.emit(point.keys[min(point.taken, len(point.keys) - 1)])

    def event(self, event) -> bool:
        """Tell which poses a point stands for."""
        if event.type() == QEvent.Type.ToolTip:
            point = self._near(QPointF(event.pos()))
            names = "" if point is None else ", ".join(map(pose_name, point.numbers))
            QToolTip.showText(event.globalPos(), names, self)
            return True
        return super().event(event)
