"""The ribbon drawn to scale, its sensors where they sit; a click chooses one."""

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from georibbon.arrays import BoolArray
from georibbon.gui.connect.words import sensor_words
from georibbon.gui.language import tr
from georibbon.gui.theme import colours_of
from georibbon.gui.units import Units
from georibbon.ribbon import Ribbon

MARGIN = 22.0  # px left and right of the ribbon
TOP, THICK = 34.0, 26.0  # px: where the ribbon begins, and how wide it is drawn
SIGN = 5.0  # px: half of a sensor's sign
HEIGHT = 112
NEAR = 24.0  # px within which a click means a sensor
STEPS = (1.0, 2.0, 5.0)  # of the ruler, times a power of ten


class RibbonDrawing(QWidget):
    """A ribbon from its start on the left to its end, with a ruler in the unit in use.

    Accelerometers are squares, magnetometers circles.  chosen(i): a person chose
    the sensor with this place in the ribbon's list, by a click or by the keys
    Left, Right, Home and End.
    """

    chosen = Signal(int)

    def __init__(self, units: Units, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._units = units
        self._ribbon: Ribbon | None = None
        self._order: list[int] = []
        self._current: int | None = None
        self._flashing: frozenset[int] = frozenset()
        self._odd: frozenset[int] = frozenset()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("The ribbon to scale"))
        self.setToolTip("")
        units.changed.connect(self.update)

    @property
    def current(self) -> int | None:
        """The sensor that is chosen."""
        return self._current

    def show_ribbon(self, ribbon: Ribbon | None) -> None:
        """Draw a ribbon, or none."""
        self._ribbon, self._current = ribbon, None
        self._flashing = self._odd = frozenset()
        sensors = () if ribbon is None else ribbon.sensors
        self._order = sorted(range(len(sensors)), key=lambda i: (sensors[i].position, i))
        self.update()

    def choose(self, sensor: int | None) -> None:
        """Mark a sensor as chosen; nothing is emitted."""
        if sensor != self._current:
            self._current = sensor
            self._describe()
            self.update()

    def flash(self, sensors: BoolArray | None, odd: BoolArray | None = None) -> None:
        """Mark (n,) sensors that were tapped, and those that something is wrong with."""
        flashing = frozenset() if sensors is None else frozenset(map(int, sensors.nonzero()[0]))
        wrong = frozenset() if odd is None else frozenset(map(int, odd.nonzero()[0]))
        if (flashing, wrong) != (self._flashing, self._odd):
            self._flashing, self._odd = flashing, wrong
            self.update()

    @property
    def flashing(self) -> frozenset[int]:
        """The sensors that were tapped a moment ago."""
        return self._flashing

    def place(self, sensor: int) -> QPointF:
        """Where a sensor is drawn, in the widget."""
        position = self._ribbon.sensors[sensor].position
        return QPointF(self._x(position), TOP + THICK / 2)

    def sizeHint(self) -> QSize:
        """As high as the drawing, and as wide as there is room."""
        return QSize(640, HEIGHT)

    def minimumSizeHint(self) -> QSize:
        """Narrow, too, it can be read."""
        return QSize(240, HEIGHT)

    # --- choosing ---

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose the sensor that is nearest to the click."""
        nearest = self._nearest(event.position())
        if nearest is not None and event.button() == Qt.MouseButton.LeftButton:
            self._take(nearest)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Tell what is under the pointer."""
        nearest = self._nearest(event.position())
        text = "" if nearest is None else sensor_words(self._ribbon.sensors[nearest], self._units)
        QToolTip.showText(event.globalPosition().toPoint(), text, self)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go along the ribbon."""
        steps = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}
        ends = {Qt.Key.Key_Home: 0, Qt.Key.Key_End: -1}
        order = self._order
        if order and event.key() in ends:
            self._take(order[ends[event.key()]])
        elif order and event.key() in steps:
            at = order.index(self._current) + steps[event.key()] if self._current in order else 0
            self._take(order[min(max(at, 0), len(order) - 1)])
        else:
            super().keyPressEvent(event)

    def _take(self, sensor: int) -> None:
        self.choose(sensor)
        self.chosen.emit(sensor)

    def _nearest(self, at: QPointF) -> int | None:
        """The sensor within reach of a point."""
        if not self._order:
            return None
        off = {i: abs(self.place(i).x() - at.x()) for i in self._order}
        nearest = min(self._order, key=off.__getitem__)
        low, high = TOP - NEAR, TOP + THICK + NEAR
        return nearest if off[nearest] <= NEAR and low <= at.y() <= high else None

    def _describe(self) -> None:
        sensor = None if self._current is None else self._ribbon.sensors[self._current]
        self.setAccessibleDescription("" if sensor is None else sensor_words(sensor, self._units))

    # --- drawing ---

    def _x(self, position: float) -> float:
        """Where a place along the ribbon, in metres, is drawn."""
        return MARGIN + position / self._ribbon.length * (self.width() - 2 * MARGIN)

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """The ribbon, its ruler and its sensors."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self._ribbon is None:
            painter.setPen(QColor(colours_of(self.palette()).dim))
            none = tr("The ribbon is drawn here as soon as one is connected.")
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, none)
        else:
            self._draw_body(painter)
            self._draw_ruler(painter)
            for sensor in self._order:
                self._draw_sensor(painter, sensor)
            self._draw_names(painter)
        if self.hasFocus():
            painter.setPen(QPen(QColor(colours_of(self.palette()).chosen), 1.0))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5))
        painter.end()

    def _draw_body(self, painter: QPainter) -> None:
        of = colours_of(self.palette())
        left, right = self._x(0.0), self._x(self._ribbon.length)
        painter.setPen(QPen(QColor(of.frame), 1.0))
        painter.setBrush(QColor(of.base))
        painter.drawRoundedRect(QRectF(left, TOP, right - left, THICK), 4.0, 4.0)
        # The start has the cable's arrow, so that nobody lays it the wrong way round.
        middle = TOP + THICK / 2
        painter.setBrush(QColor(of.words))
        painter.setPen(Qt.PenStyle.NoPen)
        arrow = [(left - 14, middle - 6), (left - 4, middle), (left - 14, middle + 6)]
        painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in arrow]))

    def _draw_ruler(self, painter: QPainter) -> None:
        """Marks at round numbers of the unit, the last with the unit itself."""
        of, unit = colours_of(self.palette()), self._units.unit
        painter.setPen(QPen(QColor(of.frame), 1.0))
        bottom = TOP + THICK
        step = _step(self._ribbon.length / unit.metres, (self.width() - 2 * MARGIN) / 56.0)
        count = int(self._ribbon.length / unit.metres / step + 1e-9)
        for k in range(count + 1):
            x = self._x(k * step * unit.metres)
            painter.setPen(QPen(QColor(of.frame), 1.0))
            painter.drawLine(QPointF(x, bottom + 2), QPointF(x, bottom + 8))
            painter.setPen(QColor(of.words))
            text = f"{k * step:g}" + (f" {unit.symbol}" if k == count else "")
            centre = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop
            painter.drawText(QRectF(x - 40, bottom + 9, 80, 18), centre, text)
        painter.setPen(QColor(of.dim))
        words = tr("■ accelerometer   ● magnetometer   ► start of the ribbon")
        where = QRectF(MARGIN, HEIGHT - 20, self.width() - 2 * MARGIN, 18)
        painter.drawText(where, Qt.AlignmentFlag.AlignLeft, words)

    def _draw_sensor(self, painter: QPainter, sensor: int) -> None:
        of, at = colours_of(self.palette()), self.place(sensor)
        flashing, chosen = sensor in self._flashing, sensor == self._current
        size = SIGN * (1.6 if flashing else 1.0)
        kind = self._ribbon.sensors[sensor].kind
        fill = of.curves[0] if kind == "accelerometer" else of.curves[1]
        if sensor in self._odd:
            fill = of.poor
        painter.setPen(QPen(QColor(of.words), 2.0) if flashing else Qt.PenStyle.NoPen)
        painter.setBrush(QColor(of.good) if flashing else QColor(fill))
        box = QRectF(at.x() - size, at.y() - size, 2 * size, 2 * size)
        if kind == "accelerometer":
            painter.drawRect(box)
        else:
            painter.drawEllipse(box)
        if sensor in self._odd:  # a shape, not a colour alone
            painter.setPen(QPen(QColor(of.base), 2.0))
            painter.drawLine(box.topLeft(), box.bottomRight())
            painter.drawLine(box.topRight(), box.bottomLeft())
        if chosen:
            painter.setPen(QPen(QColor(of.chosen), 2.0))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(box.adjusted(-3, -3, 3, 3))

    def _draw_names(self, painter: QPainter) -> None:
        """The names that have room; those that are chosen or flash come first."""
        metrics, taken = painter.fontMetrics(), []
        first = [i for i in self._order if i == self._current or i in self._flashing]
        for sensor in [*first, *(i for i in self._order if i not in first)]:
            name = self._ribbon.sensors[sensor].name
            half = metrics.horizontalAdvance(name) / 2 + 4
            x = self.place(sensor).x()
            if all(x + half < low or x - half > high for low, high in taken):
                taken.append((x - half, x + half))
                self._draw_name(painter, name, x, sensor in first)

    def _draw_name(self, painter: QPainter, name: str, x: float, bold: bool) -> None:
        font = painter.font()
        font.setBold(bold)
        painter.setFont(font)
        painter.setPen(QColor(colours_of(self.palette()).words))
        centre = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignBottom
        painter.drawText(QRectF(x - 60, 4, 120, TOP - 10), centre, name)


def _step(length: float, marks: float) -> float:
    """A round step, 1, 2 or 5 times a power of ten, that makes at most so many marks."""
    power = 10.0**-6
    while True:
        for step in STEPS:
            if length / (step * power) <= max(marks, 1.0):
                return step * power
        power *= 10.0
