"""Signs of a state: a colour and a shape each, so that none is told by its colour alone."""

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from georibbon.gui.theme import Colours

# Tick, dot in a ring, triangle, cross, ring, dash.
SHAPES = {
    "good": "tick", "asked": "dot", "poor": "triangle", "fair": "triangle", "usable": "triangle",
    "refused": "cross", "calibrate": "cross", "bad": "cross", "open": "ring", "skipped": "dash",
}  # fmt: skip


def colour_of(state: str, colours: Colours) -> str:
    """The colour of a state."""
    return {
        "good": colours.good,
        "asked": colours.link,
        "poor": colours.fair,
        "fair": colours.fair,
        "usable": colours.fair,
        "refused": colours.poor,
        "calibrate": colours.poor,
        "bad": colours.poor,
    }.get(state, colours.frame)


def paint_sign(painter: QPainter, area: QRectF, state: str, colours: Colours) -> None:
    """Paint a state's sign into a square."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    colour = QColor(colour_of(state, colours))
    pen = QPen(colour, area.width() / 7.0)
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    inner = area.adjusted(*(v * area.width() / 7.0 for v in (1, 1, -1, -1)))
    shape = SHAPES[state]
    if shape == "tick":
        painter.drawPolyline(_points(inner, ((0.0, 0.55), (0.38, 0.95), (1.0, 0.1))))
    elif shape == "cross":
        painter.drawLine(inner.topLeft(), inner.bottomRight())
        painter.drawLine(inner.topRight(), inner.bottomLeft())
    elif shape == "dash":
        painter.drawLine(
            QPointF(inner.left(), inner.center().y()), QPointF(inner.right(), inner.center().y())
        )
    elif shape == "triangle":
        painter.setBrush(colour)
        painter.drawPolygon(_points(inner, ((0.5, 0.05), (1.0, 0.95), (0.0, 0.95))))
    else:
        painter.drawEllipse(inner)
        if shape == "dot":
            painter.setBrush(colour)
            quarter = 0.3 * inner.width()
            painter.drawEllipse(inner.adjusted(quarter, quarter, -quarter, -quarter))
    painter.restore()


def _points(area: QRectF, shares) -> QPolygonF:
    return QPolygonF(
        [QPointF(area.left() + x * area.width(), area.top() + y * area.height()) for x, y in shares]
    )
