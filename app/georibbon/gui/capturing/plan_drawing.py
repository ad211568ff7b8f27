"""The plan from above: where to lay each pass and tie, in which order and direction."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from georibbon.capture.plan import CapturePlan, places, tie_places
from georibbon.gui.language import tr, trn
from georibbon.gui.theme import colours_of
from georibbon.gui.units import Units

MOST_DRAWN = 12
MARGIN = 46.0
DISC = 11.0
MARK = 4.0


class PlanDrawing(QWidget):
    """A plan as a picture: passes from left to right, each next one to the left of the last."""

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = units
        self._plan = CapturePlan()
        self._length = 0.96
        self._asked: str | None = None
        self._taken: frozenset[str] = frozenset()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(240, 180)
        units.changed.connect(self.update)
        self._describe()

    def sizeHint(self) -> QSize:
        """Wide, as an object is."""
        return QSize(560, 340)

    def show_plan(self, plan: CapturePlan, length: float) -> None:
        """Show a plan for a ribbon of a length, metres."""
        self._plan, self._length = plan, length
        self._describe()
        self.update()

    def _describe(self) -> None:
        plan = self._plan
        words = [
            tr("Plan seen from above"),
            trn("{n} pass", "{n} passes", plan.passes),
            tr("{distance} apart", distance=self._units.text(plan.layout.spacing)),
            trn("{n} tie across them", "{n} ties across them", plan.ties),
        ]
        self.setAccessibleName(words[0])
        self.setAccessibleDescription(", ".join(words[1:]))

    # --- painting ---

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw it anew."""
        with QPainter(self) as painter:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.fillRect(self.rect(), QColor(colours_of(self.palette()).base))
            if self._plan.passes:
                self._paint(painter)

    def _paint(self, painter: QPainter) -> None:
        count = min(self._plan.passes, MOST_DRAWN)
        wide = max((count - 1) * self._plan.layout.spacing, 1e-3)
        room = QRectF(self.rect()).adjusted(MARGIN + 34, MARGIN, -MARGIN - 40, -MARGIN)
        scale = min(room.width() / self._length, room.height() / max(wide, 0.25 * self._length))
        left = room.left() + (room.width() - scale * self._length) / 2
        low = room.bottom() - (room.height() - scale * wide) / 2
        step = scale * self._plan.layout.spacing

        def at(s: float, k: float) -> QPointF:
            return QPointF(left + scale * s, low - k * step)

        self._paint_edge(painter, at(0.0, -0.35 if count > 1 else 0.0), at(0.0, count - 0.65))
        for k, fraction in enumerate(tie_places(min(self._plan.ties, MOST_DRAWN)), start=1):
            self._paint_tie(painter, at, fraction, count, f"T{k}")
        for k in range(count):
            self._paint_pass(painter, at, k)
        for k in range(count - 1):
            self._paint_distances(painter, at, k)
        if count > 1:
            self._paint_spacing(painter, at)
        self._paint_words(painter, count)

    def _paint_edge(self, painter: QPainter, low: QPointF, high: QPointF) -> None:
        """The edge where all passes begin."""
        pen = QPen(QColor(colours_of(self.palette()).dim), 1.0, Qt.PenStyle.DashDotLine)
        painter.setPen(pen)
        painter.drawLine(low + QPointF(0, 8), high - QPointF(0, 8))

    def _paint_pass(self, painter: QPainter, at, k: int) -> None:
        of = colours_of(self.palette())
        start, end = at(0.0, k), at(self._length, k)
        painter.setPen(QPen(QColor(of.curves[0]), 2.0))
        painter.drawLine(start, end)
        self._arrow(painter, start + 0.62 * (end - start), QPointF(1.0, 0.0), of.curves[0])
        for place in places(self._plan.layout.marks, self._length):
            point = at(place, k)
            painter.setPen(QPen(QColor(of.words), 1.2))
            painter.setBrush(QColor(of.base))
            painter.drawRect(QRectF(point.x() - MARK, point.y() - MARK, 2 * MARK, 2 * MARK))
        self._label(painter, start - QPointF(20.0, 0.0), f"P{k + 1}", of.curves[0])

    def _paint_tie(self, painter: QPainter, at, fraction: float, count: int, name: str) -> None:
        """A tie's middle lies on the middle pass; it runs from the first pass towards the last."""
        of = colours_of(self.palette())
        middle = (count - 1) // 2
        s = fraction * self._length
        half = self._length / 2 / self._plan.layout.spacing
        low, high = max(middle - half, -0.6), min(middle + half, count - 0.4)
        start, end = at(s, low), at(s, high)
        painter.setPen(QPen(QColor(of.curves[1]), 2.0, Qt.PenStyle.DashLine))
        painter.drawLine(start, end)
        self._arrow(painter, end, QPointF(0.0, -1.0), of.curves[1])
        self._label(painter, end - QPointF(0.0, 18.0), name, of.curves[1])
        painter.setPen(QPen(QColor(of.curves[1]), 1.4))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for k in range(count):
            if middle - half <= k <= middle + half:
                painter.drawEllipse(at(s, k), 4.5, 4.5)

    def _paint_distances(self, painter: QPainter, at, k: int) -> None:
        of = colours_of(self.palette())
        painter.setPen(QPen(QColor(of.curves[2]), 1.2, Qt.PenStyle.DotLine))
        for place in places(self._plan.layout.distances, self._length):
            shift = QPointF(9.0 if place < self._length / 2 else -9.0, 0.0)
            one, other = at(place, k) + shift, at(place, k + 1) + shift
            painter.drawLine(one, other)
            for point in (one, other):
                painter.drawLine(point - QPointF(3.0, 0.0), point + QPointF(3.0, 0.0))

    def _paint_spacing(self, painter: QPainter, at) -> None:
        """The distance between the first two passes, as a dimension beside them."""
        of = colours_of(self.palette())
        painter.setPen(QPen(QColor(of.words), 1.0))
        x = at(self._length, 0).x() + 14.0
        low, high = at(0, 0).y(), at(0, 1).y()
        painter.drawLine(QPointF(x, low), QPointF(x, high))
        for y in (low, high):
            painter.drawLine(QPointF(x - 4, y), QPointF(x + 4, y))
        words = self._units.text(self._plan.layout.spacing)
        painter.drawText(QPointF(x + 8.0, (low + high) / 2 + 5.0), words)

    def _paint_words(self, painter: QPainter, count: int) -> None:
        of = colours_of(self.palette())
        painter.setPen(QColor(of.dim))
        words = tr("all starts at the same edge; lay them in the order of their numbers")
        if count < self._plan.passes:
            words = tr("the first {n} of {all} passes", n=count, all=self._plan.passes)
        room = QRectF(self.rect()).adjusted(8, 0, -8, -6)
        painter.drawText(room, Qt.AlignmentFlag.AlignBottom | Qt.AlignmentFlag.AlignHCenter, words)
        signs = [("□", tr("mark"), of.words, self._plan.layout.marks)]
        signs += [("○", tr("crossing"), of.curves[1], self._plan.ties)]
        signs += [("┄", tr("distance"), of.curves[2], self._plan.layout.distances)]
        x = 10.0
        for sign, text, colour, there in signs:
            if there:
                painter.setPen(QColor(colour))
                painter.drawText(QPointF(x, 18.0), f"{sign} {text}")
                x += painter.fontMetrics().horizontalAdvance(f"{sign} {text}") + 16.0

    def _arrow(self, painter: QPainter, tip: QPointF, ahead: QPointF, colour: str) -> None:
        side = QPointF(-ahead.y(), ahead.x())
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colour))
        back = tip - 11.0 * ahead
        painter.drawPolygon(QPolygonF([tip, back + 5.0 * side, back - 5.0 * side]))

    def _label(self, painter: QPainter, at: QPointF, text: str, colour: str) -> None:
        font = QFont(painter.font())
        painter.save()
        font.setBold(True)
        painter.setFont(font)
        painter.setPen(QColor(colour))
        box = QRectF(at.x() - 30, at.y() - DISC, 60, 2 * DISC)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()
