"""The sign of a verdict: its shape says the same as its colour."""

import math

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPixmap, QPolygonF

# Three to one and more against both palettes; the shape and the word say the same.
COLOURS = {"good": "#2f9e5b", "acceptable": "#c27c0e", "redo": "#d9434e"}
CORNERS = {"good": 24, "acceptable": 3, "redo": 4}


def verdict_icon(verdict: str) -> QIcon:
    """A disc for good, a triangle for acceptable, a square for redo."""
    size = 32
    picture = QPixmap(size, size)
    picture.fill(Qt.GlobalColor.transparent)
    corners = CORNERS[verdict]
    turn = math.pi / 4 if corners == 4 else math.pi / 2
    outline = [
        QPointF(
            size / 2 + 0.42 * size * math.cos(turn + 2 * math.pi * k / corners),
            size / 2 - 0.42 * size * math.sin(turn + 2 * math.pi * k / corners),
        )
        for k in range(corners)
    ]
    with QPainter(picture) as painter:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(COLOURS[verdict]))
        painter.drawPolygon(QPolygonF(outline))
    return QIcon(picture)
