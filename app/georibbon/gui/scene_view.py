"""The 3D view as a widget: drawn by OpenGL where Qt can have it, as a picture where not.

VTK is loaded with the first result, so that the window can show before.
"""

from __future__ import annotations

from functools import partial
from time import monotonic
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QPointF, QRect, Qt, QThread, QTimer, Signal
from PySide6.QtGui import (
    QGuiApplication,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QOffscreenSurface,
    QOpenGLContext,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QSurface,
    QSurfaceFormat,
    QWheelEvent,
)
from PySide6.QtOpenGLWidgets import QOpenGLWidget
from PySide6.QtWidgets import QWidget

from georibbon.errors import ExportError
from georibbon.gui.language import sentence, tr
from georibbon.gui.scene_tools import Tools
from georibbon.gui.theme import theme_of

if TYPE_CHECKING:
    import numpy as np

    from georibbon.gui.scene_stage import Play, Stage
    from georibbon.reconstruction import Reconstruction
    from georibbon.scene.drawing import CaptureDrawing

STANDARD_VIEWS = ("iso", "front", "back", "left", "right", "top", "bottom")
# As georibbon.scene.colouring has them, whose import would keep the window from showing.
COLOURINGS = ("uncertainty", "gaussian", "mean", "normal", "deviation", "zebra", "plain")
PARTS = ("surface", "passes", "ties", "sensors", "frames", "marks", "labels", "floor")
_HIDDEN_FIRST = frozenset({"sensors", "frames"})
_MOVING = 0.2  # s between two pictures within which something moves, and edges stay rough
_REST_MS = 150  # after the last of them the edges are smoothed
_VERSION = (3, 2)
_NO_OPENGL = (
    "offscreen",
    "minimal",
    "linuxfb",
    "vnc",
)  # Qt platforms that draw none of its widgets
_DEPTH_LESS_OR_EQUAL, _COLOUR_BUFFER = 0x0203, 0x4000  # GL_LEQUAL, GL_COLOR_BUFFER_BIT
_BUTTONS = {
    Qt.MouseButton.LeftButton: "LeftButton",
    Qt.MouseButton.MiddleButton: "MiddleButton",
    Qt.MouseButton.RightButton: "RightButton",
}
_TURNS = {
    Qt.Key.Key_Left: (-5.0, 0.0),
    Qt.Key.Key_Right: (5.0, 0.0),
    Qt.Key.Key_Up: (0.0, 5.0),
    Qt.Key.Key_Down: (0.0, -5.0),
}
_TOUCHES = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space)
_STILL = 5  # pixels by which a hand may tremble while it clicks
_ZOOMS = {
    Qt.Key.Key_Plus: 1.1,
    Qt.Key.Key_Equal: 1.1,
    Qt.Key.Key_Minus: 1 / 1.1,
}


def ask_for_surfaces() -> None:
    """Ask Qt for the OpenGL surfaces that VTK draws on; to be called before any window is made."""
    asked = QSurfaceFormat()
    asked.setRenderableType(QSurfaceFormat.RenderableType.OpenGL)
    asked.setVersion(*_VERSION)
    asked.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    asked.setSamples(0)  # by software, four samples take six times as long
    asked.setDepthBufferSize(24)
    QSurfaceFormat.setDefaultFormat(asked)


def make_view(parent: QWidget | None = None) -> SceneView | ImageView:
    """The best view that can be had here."""
    return SceneView(parent) if opengl_works() else ImageView(parent)


def opengl_works() -> bool:
    """Whether Qt's widgets can be drawn by OpenGL here, in a version that VTK can use."""
    if QGuiApplication.platformName() in _NO_OPENGL:
        return False
    context, surface = QOpenGLContext(), QOffscreenSurface()
    surface.create()
    if not (context.create() and context.makeCurrent(surface)):
        return False
    version = context.format().version()
    context.doneCurrent()
    return tuple(version) >= _VERSION


class _View:
    """What both kinds of view have in common: the mixin of a QWidget.

    camera_moved(): by hand; what is looked at changed otherwise without it.
    recoloured(): another colouring, range, unit or result is shown.  picked(Pick),
    measured(Distance), sectioned(Section): what a tool has found, of
    georibbon.scene.measuring.  tool_changed(tool): another is in the hand.
    hinted(sentence): what to do next with it, or why it found nothing.
    """

    camera_moved = Signal()
    recoloured = Signal()
    picked = Signal(object)
    measured = Signal(object)
    sectioned = Signal(object)
    tool_changed = Signal(str)
    hinted = Signal(str)

    _stage: Stage | None = None
    _reconstruction: Reconstruction | None = None
    _drawing: CaptureDrawing | None = None
    _parallel = False
    _ratio = 0.0
    _painted = -_MOVING  # when it was drawn after the last change, and how long that took
    _began = _took = 0.0
    _altered = _rough = False

    def _prepare(self) -> None:
        self._colouring = "uncertainty"
        self._ranges: dict[str, tuple[float, float]] = {}
        self._shown = frozenset(PARTS) - _HIDDEN_FIRST
        self._deviation: np.ndarray | None = None
        self._deviation_words = ""
        self._unit = ("mm", 1e-3)
        self._look = None
        self._pressed: QPointF | None = None  # where a tool may be about to touch
        self.tools = Tools(self)
        for signal, told in (
            (self.tools.picked, self.picked),
            (self.tools.measured, self.measured),
            (self.tools.sectioned, self.sectioned),
            (self.tools.hinted, self.hinted),
        ):
            signal.connect(told)
        self.tools.changed.connect(self._take_tool)
        self._resting = QTimer(self)
        self._resting.setSingleShot(True)
        self._resting.setInterval(_REST_MS)
        self._resting.timeout.connect(self._rest)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)
        self.setAccessibleName(tr("3D view"))
        self.setAccessibleDescription(
            tr(
                "Drag to turn, with Shift to move, wheel to zoom; arrow keys turn, plus and minus "
                "zoom"
            )
        )

    # --- what is shown ---

    def show_scene(self, reconstruction: Reconstruction | None) -> None:
        """Show a result, or nothing; the camera stays where it was if there was one before.

        What is shown already is changed in place as far as it can be.
        """
        self._reconstruction = reconstruction
        self._show()

    def show_capture(self, drawing: CaptureDrawing | None) -> None:
        """Show the curves of a capture that goes on, over the result where there is one."""
        self._drawing = drawing
        self._show()

    def set_colouring(self, mode: str) -> None:
        """Colour by one of COLOURINGS."""
        if mode not in COLOURINGS:
            raise ValueError(f"there is no colouring {mode}")
        self._colouring = mode
        self._restyle()

    @property
    def colouring(self) -> str:
        """What the colours stand for: one of COLOURINGS."""
        return self._colouring

    def set_range(self, fixed: tuple[float, float] | None) -> None:
        """Fix the range of the mode's colours, in its SI unit (m, 1/m, 1/m²); None: automatic."""
        if fixed is None:
            self._ranges.pop(self._colouring, None)
        elif fixed[0] < fixed[1]:
            self._ranges[self._colouring] = (float(fixed[0]), float(fixed[1]))
        else:
            raise ValueError(f"a range from {fixed[0]} to {fixed[1]} is empty")
        self._restyle()

    def range(self) -> tuple[float, float]:
        """(low, high) that the mode's colours stand for now, in its SI unit."""
        scene = None if self._stage is None else self._stage.scene
        return (0.0, 1.0) if scene is None else scene.range

    @property
    def fixed_range(self) -> tuple[float, float] | None:
        """The mode's range where it is fixed."""
        return self._ranges.get(self._colouring)

    def set_deviation(self, values: np.ndarray | None, words: str = "") -> None:
        """(n,) m, signed, of the shown mesh's vertices, NaN where there is nothing to compare with.

        words: from what, short, for the scale.  They are not shown for a mesh of
        another number of vertices.
        """
        self._deviation, self._deviation_words = values, words
        self._restyle()

    @property
    def has_deviation(self) -> bool:
        """Whether there are deviations of the mesh that is shown."""
        surface = None if self._reconstruction is None else self._reconstruction.surface
        values = self._deviation
        return (
            surface is not None and values is not None and len(values) == len(surface.mesh.vertices)
        )

    def set_shown(self, part: str, shown: bool) -> None:
        """Show one of PARTS, or hide it."""
        if part not in PARTS:
            raise ValueError(f"there is no part {part}")
        self._shown = self._shown | {part} if shown else self._shown - {part}
        self._restyle()

    def is_shown(self, part: str) -> bool:
        """Whether one of PARTS is to be seen."""
        return part in self._shown

    def set_units(self, symbol: str, metres: float) -> None:
        """The unit of length of scale and key: its symbol, and its size in metres."""
        self._unit = (symbol, metres)
        self._restyle()

    def _restyle(self) -> None:
        self._look = None
        self._show()

    def _show(self) -> None:
        """Put everything on the stage, in the colours of the theme, words in the font's size."""
        if self._reconstruction is not None or self._drawing is not None:
            self._load()
        if self._stage is not None:
            self._stage.show(self._play())
            self.tools.follow(self._stage, self._reconstruction)
            self.recoloured.emit()
        self.refresh()

    def _play(self) -> Play:
        from georibbon.gui.scene_stage import Play
        from georibbon.scene.colouring import Look

        if self._look is None:
            symbol, metres = self._unit
            self._look = Look(
                self._colouring, dict(self._ranges), self._deviation, self._deviation_words,
                self._shown, symbol, metres, tr,
            )  # fmt: skip
        font_size = round(self.fontInfo().pixelSize() * self.devicePixelRatioF())
        dark = theme_of(self.palette()) == "dark"
        ratio = self.devicePixelRatioF()
        return Play(self._reconstruction, self._drawing, self._look, font_size, ratio, dark)

    # --- drawing ---

    def refresh(self) -> None:
        """Draw anew at the next turn of the event loop, once however often it is asked."""
        self._altered = True
        self.update()

    def _fine(self) -> bool:
        """Whether the picture that is drawn now has time for smooth edges: nothing moves."""
        now = monotonic()
        if self._altered:
            self._rough = now - self._painted < max(_MOVING, 2.0 * self._took)
        self._began = now
        return not self._rough

    def _drawn(self) -> None:
        """A picture was drawn: what changes soon after it moves."""
        if self._altered:
            self._altered, self._painted = False, monotonic()
            self._took = self._painted - self._began
            if self._rough:
                self._resting.start()

    def _rest(self) -> None:
        """Nothing moves any more: draw it again, with smooth edges."""
        self._altered = self._rough = False
        self._resting.stop()
        self.update()

    def _off_screen(self, scale: int, transparent: bool) -> QImage:
        """What is seen, drawn anew in another size or without a ground."""
        ratio = self.devicePixelRatioF()
        size = (round(self.width() * ratio) * scale, round(self.height() * ratio) * scale)
        if self._stage is None or self._stage.scene is None:
            image = QImage(*size, QImage.Format.Format_RGBA8888)
            ground = self.palette().base().color()
            image.fill(Qt.GlobalColor.transparent if transparent else ground)
            return image
        return _image(self._stage.picture(size, scale, transparent), ratio)

    # --- the tools ---

    def set_tool(self, tool: str) -> None:
        """Take up "point", "distance" or "section", or "none"; Escape puts it down."""
        self.tools.choose(tool)

    @property
    def tool(self) -> str:
        """The tool in the hand."""
        return self.tools.tool

    def set_upright_sections(self, upright: bool) -> None:
        """Cut upright, or along the line of sight."""
        self.tools.upright = upright

    def clear_marks(self) -> None:
        """Take away what was pointed at and measured."""
        self.tools.clear()

    def _take_tool(self, tool: str) -> None:
        if tool == "none":
            self.unsetCursor()
        else:
            self.setCursor(Qt.CursorShape.CrossCursor)
        self.tool_changed.emit(tool)

    # --- the camera ---

    def fit(self) -> None:
        """Move the camera so that everything is seen, from the side it is on."""
        if self._stage is not None:
            self._stage.fit()

    def standard_view(self, name: str) -> None:
        """See everything from one of STANDARD_VIEWS; "iso" is the side that shows most."""
        if name not in STANDARD_VIEWS:
            raise ValueError(f"there is no view {name}")
        if self._stage is not None:
            self._stage.standard_view(name)

    def set_parallel(self, parallel: bool) -> None:
        """Draw in parallel projection, or in perspective."""
        self._parallel = parallel
        if self._stage is not None:
            self._stage.set_parallel(parallel)

    def show_cursor(self, name: str, s: float) -> None:
        """Mark a place, s metres along a pass; none where there is no such pass."""
        if self._stage is not None:
            self._stage.show_cursor(name, s)

    def copy_camera(self, other: SceneView | ImageView) -> None:
        """Look from where another view does; nothing is told of it."""
        if self._stage is not None and other._stage is not None:
            self._parallel = other._parallel
            self._stage.copy_camera(other._stage)

    def _load(self) -> None:
        """Make the stage when it is first needed."""
        if self._stage is None:
            self._stage = self._make_stage()
            self._stage.set_parallel(self._parallel)
            self._follow_size()

    def _follow_size(self) -> None:
        """Give the stage the widget's size in device pixels, and its words their size."""
        if self._stage is None:
            return
        ratio = self.devicePixelRatioF()
        self._stage.resize(round(self.width() * ratio), round(self.height() * ratio))
        if ratio != self._ratio:
            self._ratio = ratio
            self._stage.show(self._play())

    def changeEvent(self, event: QEvent) -> None:
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and self._stage is not None:
            self._show()

    # --- the hand ---

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to turn, to move or to zoom, or to touch with the tool."""
        if self.tool != "none" and event.button() == Qt.MouseButton.LeftButton:
            self._pressed = event.position()
        else:
            self._button(event.button(), "Press", event.position(), event.modifiers())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End it."""
        if self._pressed is None:
            self._button(event.button(), "Release", event.position(), event.modifiers())
        else:
            self._pressed = None
            ratio, at = self.devicePixelRatioF(), event.position()
            self.tools.click(at.x() * ratio, at.y() * ratio)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn, move or zoom."""
        if self._stage is None:
            return
        start = self._pressed
        if start is not None:
            if (event.position() - start).manhattanLength() < _STILL:
                return
            self._pressed = None  # it was no touch
            self._button(Qt.MouseButton.LeftButton, "Press", start, event.modifiers())
        self._stage.show_cross(False)
        self._point(event.position(), event.modifiers())
        self._stage.interactor.MouseMoveEvent()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom by the wheel's angle, however finely it is told."""
        if self._stage is not None and event.angleDelta().y():
            self._stage.zoom(1.1 ** (event.angleDelta().y() / 120.0))
            event.accept()

    def event(self, event: QEvent) -> bool:
        """With a tool in the hand, its keys are the view's own, not the window's."""
        own = event.type() == QEvent.Type.ShortcutOverride and self.tool != "none"
        if own and event.key() in (*_TOUCHES, Qt.Key.Key_Escape):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Turn by the arrows, zoom by plus and minus, fit by Home.

        A tool touches the middle of the view by Return or Space; Escape puts it down.
        """
        if self._stage is None:
            super().keyPressEvent(event)
            return
        aiming = self.tool != "none"
        if event.key() in _TURNS:
            self._stage.turn(*_TURNS[event.key()])
        elif event.key() in _ZOOMS:
            self._stage.zoom(_ZOOMS[event.key()])
        elif event.key() == Qt.Key.Key_Home:
            self._stage.fit()
        elif aiming and event.key() in _TOUCHES:
            self.tools.click(*self._stage.middle)
        elif aiming and event.key() == Qt.Key.Key_Escape:
            self.set_tool("none")
            return
        else:
            super().keyPressEvent(event)
            return
        self._stage.show_cross(aiming)

    def _button(
        self,
        button: Qt.MouseButton,
        what: str,
        at: QPointF,
        keys: Qt.KeyboardModifier,
    ) -> None:
        name = _BUTTONS.get(button)
        if self._stage is not None and name is not None:
            self._point(at, keys)
            getattr(self._stage.interactor, f"{name}{what}Event")()

    def _point(self, at: QPointF, keys: Qt.KeyboardModifier) -> None:
        ratio = self.devicePixelRatioF()
        self._stage.point(
            round(at.x() * ratio),
            round(at.y() * ratio),
            bool(keys & Qt.KeyboardModifier.ControlModifier),
            bool(keys & Qt.KeyboardModifier.ShiftModifier),
        )


def _image(rows: np.ndarray, ratio: float) -> QImage:
    """(height, width, 3 or 4) uint8 as an image with memory of its own."""
    height, width, depth = rows.shape
    kind = QImage.Format.Format_RGB888 if depth == 3 else QImage.Format.Format_RGBA8888
    image = QImage(rows.tobytes(), width, height, depth * width, kind).copy()
    image.setDevicePixelRatio(ratio)
    return image


class SceneView(_View, QOpenGLWidget):
    """A view that VTK draws straight into the widget's framebuffer."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._prepare()
        self._context: QOpenGLContext | None = None
        self._surface: QSurface | None = None
        self._begun = False

    def image(self, scale: int = 1, transparent: bool = False) -> QImage:
        """What is seen, in device pixels, `scale` times as many; on a ground or without one.

        Raises ExportError where so large a picture cannot be drawn here.
        """
        if scale == 1 and not transparent:
            self._rest()
            return self.grabFramebuffer()
        return self._off_screen(scale, transparent)

    def initializeGL(self) -> None:
        """A context was made: the first, or another after the widget moved to another window."""
        self._context = self.context()
        self._surface = self._context.surface()
        self._context.aboutToBeDestroyed.connect(self._release)

    def resizeGL(self, _width: int, _height: int) -> None:
        """The size changed."""
        self._follow_size()

    def paintGL(self) -> None:
        """Draw, with the context current."""
        self._follow_size()
        if self._stage is None or not self._draw():
            colour = self.palette().base().color()
            functions = self.context().functions()
            functions.glClearColor(colour.redF(), colour.greenF(), colour.blueF(), 1.0)
            functions.glClear(_COLOUR_BUFFER)

    def _draw(self) -> bool:
        window = self._stage.window
        window.SetReadyForRendering(True)
        if not self._begun:
            window.OpenGLInit()  # finds OpenGL's functions in this context
            self._begun = True
        state = window.GetState()
        state.Reset()
        state.Push()
        state.vtkglDepthFunc(_DEPTH_LESS_OR_EQUAL)  # Qt leaves another one
        drawn = self._stage.draw(self._fine())
        state.Pop()
        self._drawn()
        window.SetReadyForRendering(False)
        return drawn

    def _make_stage(self) -> Stage:
        from vtkmodules.vtkRenderingOpenGL2 import vtkGenericOpenGLRenderWindow

        from georibbon.gui.scene_stage import Stage

        window = vtkGenericOpenGLRenderWindow()
        window.SetMultiSamples(0)
        window.SetFrameBlitModeToBlitToCurrent()
        window.SetForceMaximumHardwareLineWidth(1)
        window.SetOwnContext(0)
        window.SetReadyForRendering(False)
        window.AddObserver("WindowMakeCurrentEvent", self._make_current)
        window.AddObserver("WindowIsCurrentEvent", self._tell_current)
        return Stage(window, self.refresh, self.camera_moved.emit)

    def _make_current(self, *_: object) -> None:
        # Not by the widget, which would also bind its own framebuffer in the middle of drawing.
        context = self._context
        if context is None or QOpenGLContext.currentContext() is context:
            return
        if QThread.currentThread() is self.thread():
            context.makeCurrent(self._surface)

    def _tell_current(self, window, *_: object) -> None:
        current = QOpenGLContext.currentContext()
        window.SetIsCurrent(current is not None and current is self._context)

    def _release(self) -> None:
        """The context is about to go: all that VTK made in it must go before."""
        context, self._context = self._context, None
        self._begun = False
        if self._stage is not None and context is not None:
            self.makeCurrent()
            self._stage.close()
            self.doneCurrent()


class ImageView(_View, QWidget):
    """A view that VTK draws off screen and that Qt paints as a picture."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._prepare()
        self.fault = ""

    def image(self, scale: int = 1, transparent: bool = False) -> QImage:
        """What is seen, in device pixels, `scale` times as many; on a ground or without one.

        Raises ExportError where so large a picture cannot be drawn here.
        """
        if scale != 1 or transparent:
            return self._off_screen(scale, transparent)
        self._rest()
        return self._picture()

    def _show(self) -> None:
        """Show it, or why it cannot be drawn here."""
        try:
            super()._show()
        except ExportError as error:
            self.fault = sentence(str(error))
            self.update()

    def _picture(self) -> QImage:
        self._follow_size()
        ratio = self.devicePixelRatioF()
        image = QImage(self.size() * ratio, QImage.Format.Format_RGB888)
        image.setDevicePixelRatio(ratio)
        image.fill(self.palette().base().color())
        if self._stage is not None and self._stage.draw(self._fine()):
            from georibbon.scene.offscreen import pixels

            self._drawn()
            image = _image(pixels(self._stage.window), ratio)
        return image

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the picture, or why there is none."""
        image = self._picture()
        with QPainter(self) as painter:
            painter.drawImage(0, 0, image)
            if self.fault:
                room = QRect(self.rect()).adjusted(24, 24, -24, -24)
                flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
                painter.drawText(room, flags, self.fault)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """The size changed."""
        self._follow_size()

    def _make_stage(self) -> Stage:
        from georibbon.gui.scene_stage import Stage
        from georibbon.scene.offscreen import offscreen_window

        window = offscreen_window((self.width(), self.height()))
        window.SetMultiSamples(0)
        stage = Stage(window, self.refresh, self.camera_moved.emit)
        self.destroyed.connect(partial(Stage.close, stage))
        return stage
