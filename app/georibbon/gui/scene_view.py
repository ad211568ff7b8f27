"""The 3D view as a widget."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPainter, QSurfaceFormat
from PySide6.QtWidgets import QWidget

STANDARD_VIEWS = ("iso", "front", "back", "left", "right", "top", "bottom")


def ask_for_surfaces() -> None:
    """Ask for the OpenGL surfaces that VTK draws on; before any window is made."""
    asked = QSurfaceFormat()
    asked.setRenderableType(QSurfaceFormat.RenderableType.OpenGL)
    asked.setVersion(3, 2)
    asked.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    asked.setSamples(0)
    asked.setDepthBufferSize(24)
    QSurfaceFormat.setDefaultFormat(asked)


def make_view(parent: QWidget | None = None) -> "ImageView":
    """The view that can be had here."""
    return ImageView(parent)


class ImageView(QWidget):
    """A view that draws off screen and shows the picture."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._reconstruction = None
        self._picture = QImage()

    def show_scene(self, reconstruction) -> None:
        """Show a result, or nothing."""
        self._reconstruction = reconstruction
        self.refresh()

    def refresh(self) -> None:
        """Draw anew at the next turn of the event loop."""
        self.update()

    def fit(self) -> None:
        """Move the camera so that everything is seen."""
        self.refresh()

    def standard_view(self, name: str) -> None:
        """Look from one of STANDARD_VIEWS."""
        if name not in STANDARD_VIEWS:
            raise ValueError(f"there is no view {name}")
        self.refresh()

    def set_parallel(self, parallel: bool) -> None:
        """Parallel projection, or perspective."""
        self._parallel = parallel
        self.refresh()

    def image(self) -> QImage:
        """What is seen, in device pixels."""
        self._draw()
        return self._picture

    def paintEvent(self, event) -> None:
        """Paint the picture."""
        self._draw()
        with QPainter(self) as painter:
            painter.drawImage(self.rect(), self._picture)

    def _draw(self) -> None:
        self._picture = QImage(self.size(), QImage.Format.Format_RGB32)
        self._picture.fill(Qt.GlobalColor.white)
        if self._reconstruction is not None:
            from georibbon.scene.offscreen import render

            rows = render(self._reconstruction, (self.width(), self.height()))
            height, width, _ = rows.shape
            self._picture = QImage(
                rows.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888
            ).copy()
