"""What stands in a 3D view and how a hand moves it: VTK without a widget, loaded when needed."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2
from numpy.typing import NDArray
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkCamera, vtkRenderWindow
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from georibbon.arrays import FloatArray
from georibbon.reconstruction import Reconstruction
from georibbon.scene.colouring import Look
from georibbon.scene.colours import DARK, WHITE
from georibbon.scene.drawing import CaptureDrawing
from georibbon.scene.offscreen import drawn, require_drawable
from georibbon.scene.scene import Scene
from georibbon.world import UP

# Loaded for what loading does: they register the drawing of text and of everything else.
_REGISTERED = (vtkmodules.vtkRenderingFreeType, vtkmodules.vtkRenderingOpenGL2)

_REACH = 10  # pixels that a click may miss a curve by
_STEEPEST = 89.0  # degrees, of the view that the keys turn
# From the object to the camera; "iso" is the scene's own.
DIRECTIONS = {
    "front": (0.0, -1.0, 0.0),
    "back": (0.0, 1.0, 0.0),
    "left": (-1.0, 0.0, 0.0),
    "right": (1.0, 0.0, 0.0),
    "top": (0.0, 0.0, 1.0),
    "bottom": (0.0, 0.0, -1.0),
}


@dataclass(frozen=True, eq=False)
class Play:
    """What is to be seen: a result, a capture that goes on, and how.

    font_size: pixels.  density: device pixels to a pixel.  dark: whether on a
    dark ground.
    """

    result: Reconstruction | None = None
    drawing: CaptureDrawing | None = None
    look: Look = field(default_factory=Look)
    font_size: int = 14
    density: float = 1.0
    dark: bool = False

    @property
    def sizes(self) -> tuple[int, float, bool]:
        """What a scene is made for: another needs another scene."""
        return self.font_size, self.density, self.dark

    def scene(self) -> Scene:
        """A scene of it."""
        paper = DARK if self.dark else WHITE
        scene = Scene(self.result, self.font_size, None, paper, self.look, self.density)
        if self.drawing is not None:
            scene.show_capture(self.drawing)
        return scene


class Stage:
    """One render window, the scene on it, its camera and its trackball.

    changed: called when there is something to draw; nothing is drawn but by
    `draw()`, which needs the window's context current and its size set.
    moved: called when the camera was moved by hand.
    """

    def __init__(
        self,
        window: vtkRenderWindow,
        changed: Callable[[], None],
        moved: Callable[[], None] = lambda: None,
    ) -> None:
        self.window = window
        self._changed, self._told_moved = changed, moved
        self._play = Play()
        self._scene: Scene | None = None
        self._shown: Scene | None = None
        self._framed: str | None = None  # the view to return to when the size changes
        self._cursor: tuple[str, float] | None = None
        self._marks: tuple[FloatArray, list[FloatArray]] = (np.empty((0, 3)), [])
        self._crossed = False
        self._parallel = False
        self._size = (1, 1)
        self.interactor = vtkGenericRenderWindowInteractor()
        self.interactor.EnableRenderOff()
        self.interactor.SetRenderWindow(window)
        self.interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        self.interactor.Initialize()
        self.interactor.AddObserver("RenderEvent", self._moved)

    @property
    def scene(self) -> Scene | None:
        """What stands on it."""
        return self._scene

    def show(self, play: Play) -> None:
        """Put this on the stage; the camera stays where it was if there was something before.

        What stands there already is changed in place as far as it can be.
        """
        before, self._play = self._play, play
        if play.result is None:
            self._cursor = None
        if play.result is None and play.drawing is None:
            self._scene = None
        elif self._scene is None or play.sizes != before.sizes:
            self._renew(play)
        else:
            self._alter(self._scene, before, play)
        self._changed()

    def _renew(self, play: Play) -> None:
        before, scene = self._scene, play.scene()
        scene.renderer.SetBackgroundAlpha(1.0)  # else what is behind the window shines in
        self._scene = scene
        if before is None:
            self._frame("iso")
        else:
            scene.renderer.SetActiveCamera(_copied(before.renderer.GetActiveCamera()))
        self._add_signs(scene)
        scene.show_cross(self._crossed)

    def _add_signs(self, scene: Scene) -> None:
        if self._cursor is not None:
            scene.show_cursor(*self._cursor)
        scene.show_marks(*self._marks)

    def _alter(self, scene: Scene, before: Play, play: Play) -> None:
        another_size = False
        if play.look is not before.look:
            scene.apply(play.look)
        if play.result is not before.result:
            another_size = scene.update(play.result)
        if play.drawing is not before.drawing:
            another_size = scene.show_capture(play.drawing) or another_size
        if another_size and self._framed is not None:
            self._frame(self._framed)

    def resize(self, width: int, height: int) -> None:
        """The window's size in device pixels."""
        if (width, height) == self._size:
            return
        self._size = (width, height)
        self.window.SetSize(width, height)
        self.interactor.UpdateSize(width, height)
        if self._framed is not None:
            self._frame(self._framed)

    def draw(self, fine: bool = True) -> bool:
        """Draw the scene; False where there is none.  fine: with smooth edges, which takes long."""
        if self._shown is not self._scene:
            self._clear()
            if self._scene is not None:
                self._scene.attach(self.window)
            self._shown = self._scene
        if self._scene is None:
            return False
        self._scene.renderer.SetUseFXAA(fine)
        self._scene.renderer.ResetCameraClippingRange()
        self._scene.follow()
        self.window.Render()
        return True

    def picture(self, size: tuple[int, int], scale: int, transparent: bool) -> NDArray[np.uint8]:
        """What is seen, (height, width, 3 or 4) uint8, drawn anew.

        size: (width, height), pixels; scale: how many times as large words and
        lines are; transparent: with a fourth channel and nothing behind, in the
        colours for a light ground, such as a page of paper.
        Raises ExportError where it is too large.
        """
        require_drawable(size)
        play = self._play
        scene = replace(
            play,
            font_size=scale * play.font_size,
            density=scale * play.density,
            dark=play.dark and not transparent,
        ).scene()
        if self._scene is not None:
            scene.renderer.SetActiveCamera(_copied(self._scene.renderer.GetActiveCamera()))
        self._add_signs(scene)
        return drawn(scene, size, transparent)

    def fit(self) -> None:
        """Show everything, from the side that the camera is on."""
        self._frame("")
        self._changed()

    def standard_view(self, name: str) -> None:
        """Show everything from one side."""
        self._frame(name)
        self._changed()

    def set_parallel(self, parallel: bool) -> None:
        """Parallel projection, or perspective; what is at the focus keeps its size."""
        self._parallel = parallel
        if self._scene is not None:
            self._project(self._scene.renderer.GetActiveCamera())
        if self._framed is not None:
            self._frame(self._framed)
        self._changed()

    def show_cursor(self, name: str, s: float) -> None:
        """Mark a place, s metres along a pass."""
        self._cursor = (name, s)
        if self._scene is not None:
            self._scene.show_cursor(name, s)
            self._changed()

    def show_marks(self, points: FloatArray, curves: list[FloatArray]) -> None:
        """Show what is pointed at, (n, 3), and measured, curves of (n, 3) points each."""
        self._marks = (points, curves)
        if self._scene is not None:
            self._scene.show_marks(points, curves)
            self._changed()

    def show_cross(self, shown: bool) -> None:
        """Show where the middle of the view is, for those who aim with the keys."""
        if shown != self._crossed:
            self._crossed = shown
            if self._scene is not None:
                self._scene.show_cross(shown)
                self._changed()

    def line_of_sight(self, x: float, y: float) -> tuple[FloatArray, FloatArray, float]:
        """Where a line of sight enters and leaves what is drawn, (3,) m each.

        x, y: device pixels from the upper left corner.  And how many metres a few
        pixels are at what the camera looks at.
        """
        renderer = self._scene.renderer
        ends = []
        for depth in (0.0, 1.0):
            renderer.SetDisplayPoint(x, self._size[1] - 1 - y, depth)
            renderer.DisplayToWorld()
            *place, weight = renderer.GetWorldPoint()
            ends.append(np.array(place) / weight)
        camera = renderer.GetActiveCamera()
        half = camera.GetDistance() * np.tan(np.radians(camera.GetViewAngle()) / 2)
        if self._parallel:
            half = camera.GetParallelScale()
        return ends[0], ends[1], float(2.0 * half / self._size[1] * _REACH)

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of the view, device pixels from the upper left corner."""
        return 0.5 * self._size[0], 0.5 * self._size[1]

    @property
    def sight(self) -> FloatArray:
        """(3,) unit: along which the camera looks."""
        return np.array(self._scene.renderer.GetActiveCamera().GetDirectionOfProjection())

    def turn(self, across: float, upward: float) -> None:
        """Turn the camera about the object, z up in the picture: degrees."""
        if self._scene is None:
            return
        camera = self._scene.renderer.GetActiveCamera()
        x, y, z = np.subtract(camera.GetPosition(), camera.GetFocalPoint()) / camera.GetDistance()
        height = np.degrees(np.arcsin(z))
        if abs(height) > _STEEPEST:  # from the top: begin where north is up
            x, y = -np.sign(z) * np.array(camera.GetViewUp()[:2])
        turned = np.arctan2(y, x) + np.radians(across)
        height = np.radians(np.clip(height + upward, -_STEEPEST, _STEEPEST))
        direction = (
            np.cos(height) * np.cos(turned),
            np.cos(height) * np.sin(turned),
            np.sin(height),
        )
        camera.SetPosition(
            *np.add(camera.GetFocalPoint(), camera.GetDistance() * np.array(direction))
        )
        camera.SetViewUp(*UP)
        self._moved()

    def zoom(self, factor: float) -> None:
        """Come nearer by a factor above one, go away by one below."""
        if self._scene is not None:
            camera = self._scene.renderer.GetActiveCamera()
            if self._parallel:
                camera.SetParallelScale(camera.GetParallelScale() / factor)
            else:
                camera.Dolly(factor)
            self._moved()

    def point(self, x: int, y: int, control: bool, shift: bool) -> None:
        """Where the pointer is: device pixels from the upper left corner."""
        self.interactor.SetEventInformationFlipY(x, y, int(control), int(shift), "\0", 0, None)

    def copy_camera(self, other: "Stage") -> None:
        """Look from where another stage's camera stands, in its projection."""
        if self._scene is None or other.scene is None:
            return
        self._parallel, self._framed = other._parallel, None
        self._scene.renderer.GetActiveCamera().DeepCopy(other.scene.renderer.GetActiveCamera())
        self._changed()

    def close(self) -> None:
        """Give back what was taken of the graphics card, with the context current."""
        self._clear()
        self._shown = None
        self.window.Finalize()

    def _moved(self, *_: object) -> None:
        self._framed = None
        self._changed()
        self._told_moved()

    def _clear(self) -> None:
        if self._shown is not None:
            self.window.RemoveRenderer(self._shown.renderer)
            self.window.RemoveRenderer(self._shown.overlay)

    def _frame(self, name: str) -> None:
        self._framed = name
        if self._scene is None:
            return
        camera = self._scene.renderer.GetActiveCamera()
        camera.SetParallelProjection(self._parallel)
        direction = self._scene.direction
        if name == "":
            direction = np.subtract(camera.GetPosition(), camera.GetFocalPoint())
            direction /= np.linalg.norm(direction)
        elif name != "iso":
            direction = np.array(DIRECTIONS[name])
        self._scene.frame(self._size[0] / self._size[1], direction)

    def _project(self, camera: vtkCamera) -> None:
        """Change the projection without a jump in size."""
        slope = np.tan(np.radians(camera.GetViewAngle()) / 2)
        if self._parallel and not camera.GetParallelProjection():
            camera.SetParallelScale(camera.GetDistance() * slope)
        elif not self._parallel and camera.GetParallelProjection():
            camera.Dolly(camera.GetDistance() * slope / camera.GetParallelScale())
        camera.SetParallelProjection(self._parallel)


def _copied(camera: vtkCamera) -> vtkCamera:
    copy = vtkCamera()
    copy.DeepCopy(camera)
    return copy
