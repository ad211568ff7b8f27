"""The 3D view, drawn by OpenGL in a widget and, without it, as a picture."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QWheelEvent
from PySide6.QtWidgets import QApplication, QMainWindow

import synthetic
from georibbon.errors import ExportError
from georibbon.gui import scene_view
from georibbon.gui.scene_view import STANDARD_VIEWS, ImageView, SceneView, make_view, opengl_works
from georibbon.gui.theme import palette

RESULT = synthetic.reconstruction()
WIDTH, HEIGHT = 480, 300
MIDDLE = QPoint(190, 140)


@pytest.fixture(params=[SceneView, ImageView])
def view(request, qtbot):
    """A view of either kind in a window on the screen, with nothing in it."""
    if request.param is SceneView:
        assert opengl_works(), "the OpenGL view needs a display: xvfb-run -a, as make test does"
    return shown(request.param(), qtbot)


@pytest.fixture
def full(view):
    """The view with a result in it."""
    view.show_scene(RESULT)
    return view


def shown(view, qtbot):
    window = QMainWindow()
    window.setCentralWidget(view)
    window.resize(WIDTH, HEIGHT)
    qtbot.addWidget(window)
    with qtbot.waitExposed(window):
        window.show()
    view.setFocus()
    view.window_held = window  # as long as the view
    return view


def pixels(image):
    """(height, width, 3) uint8 of an image."""
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    lines = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return lines[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()


def share(image):
    """Of the left part of a picture, where the object is: how much is neither white nor grey."""
    seen = pixels(image).astype(int)
    return float((np.ptp(seen[:, : int(0.8 * image.width())], axis=-1) > 30).mean())


def differ(one, other):
    """The share of pixels by which two pictures of one size differ clearly."""
    return float((np.abs(pixels(one).astype(int) - pixels(other)).max(axis=-1) > 40).mean())


def wheel(view, clicks):
    at = QPointF(MIDDLE)
    event = QWheelEvent(
        at, view.mapToGlobal(at), QPoint(), QPoint(0, 120 * clicks), Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(view, event)


def test_a_result_fills_the_view(full):
    image = full.image()
    assert (image.width(), image.height()) == (WIDTH, HEIGHT)
    assert 0.15 < share(image) < 0.7


def test_what_the_window_shows_is_the_image(full):
    seen = full.window().grab().toImage()
    assert differ(seen, full.image()) < 0.001


def test_the_two_kinds_show_the_same(qtbot):
    first, second = (shown(kind(), qtbot) for kind in (SceneView, ImageView))
    for one in (first, second):
        one.show_scene(RESULT)
    assert differ(first.image(), second.image()) < 0.02


def test_an_empty_view_is_plain_before_and_after(view):
    base = view.palette().base().color()
    expected = np.array([base.red(), base.green(), base.blue()])
    assert np.all(pixels(view.image()) == expected)
    view.show_scene(RESULT)
    assert share(view.image()) > 0.1
    view.show_scene(None)
    assert np.all(pixels(view.image()) == expected)


def test_it_follows_the_theme_and_the_camera_stays(full, qtbot):
    qtbot.keyClick(full, Qt.Key.Key_Left)
    light = full.image()
    full.setPalette(palette("dark"))
    dark = full.image()
    assert pixels(light)[0, 0].min() > 240
    assert pixels(dark)[0, 0].max() < 60
    assert share(dark) == pytest.approx(share(light), abs=0.05)
    full.setPalette(palette("light"))
    assert differ(light, full.image()) < 0.001


def test_the_cursor_is_a_ball_on_its_pass(full):
    full.standard_view("top")
    before = full.image()
    seen = []
    for s in (0.2, 0.7):
        full.show_cursor("P3", s)
        changed = np.abs(pixels(before).astype(int) - pixels(full.image())).max(axis=-1) > 40
        assert 5 < changed.sum() < 400
        seen.append(np.argwhere(changed).mean(axis=0))
    assert seen[1][1] - seen[0][1] > 50  # x to the right
    assert abs(seen[1][0] - seen[0][0]) < 5  # P3 runs along x
    full.show_scene(synthetic.reconstruction())
    assert differ(before, full.image()) > 0
    full.show_cursor("none of them", 0.2)
    assert differ(before, full.image()) < 0.0001


def test_every_standard_view_shows_all_from_another_side(full):
    images = []
    for name in STANDARD_VIEWS:
        full.standard_view(name)
        images.append(full.image())
        assert share(images[-1]) > 0.03
    for i, one in enumerate(images):
        assert all(differ(one, other) > 0.01 for other in images[:i])
    with pytest.raises(ValueError, match="no view askew"):
        full.standard_view("askew")


def test_parallel_and_back(full):
    before = full.image()
    full.set_parallel(True)
    parallel = full.image()
    assert differ(before, parallel) > 0.01
    assert abs(share(parallel) - share(before)) < 0.1
    full.set_parallel(False)
    assert differ(before, full.image()) < 0.001


def test_what_is_looked_at_keeps_its_size_when_the_projection_changes(full, qtbot):
    qtbot.keyClick(full, Qt.Key.Key_Plus)
    before = share(full.image())
    full.set_parallel(True)
    assert share(full.image()) == pytest.approx(before, abs=0.05)
    full.set_parallel(False)
    assert share(full.image()) == pytest.approx(before, abs=0.001)


def test_a_drag_turns_and_fit_brings_all_back(full, qtbot):
    full.repaint()
    before = full.image()
    left = Qt.MouseButton.LeftButton
    qtbot.mousePress(full, left, pos=MIDDLE)
    qtbot.mouseMove(full, MIDDLE + QPoint(30, 10))
    qtbot.mouseMove(full, MIDDLE + QPoint(60, 20))
    qtbot.mouseRelease(full, left, pos=MIDDLE + QPoint(60, 20))
    turned = full.image()
    assert differ(before, turned) > 0.05
    wheel(full, 12)
    assert share(full.image()) > share(turned) * 1.3
    full.fit()
    assert share(full.image()) < share(turned) * 1.3
    full.standard_view("iso")
    assert differ(before, full.image()) < 0.001


@pytest.mark.parametrize("parallel", [False, True])
def test_the_wheel_zooms_there_and_back(full, parallel):
    full.set_parallel(parallel)
    before = full.image()
    wheel(full, 3)
    assert share(full.image()) > share(before) * 1.3
    wheel(full, -3)
    assert differ(before, full.image()) < 0.001


def test_the_keys_turn_zoom_and_fit(full, qtbot):
    before = full.image()
    for there, back in ((Qt.Key.Key_Left, Qt.Key.Key_Right), (Qt.Key.Key_Up, Qt.Key.Key_Down)):
        qtbot.keyClick(full, there)
        assert differ(before, full.image()) > 0.01
        qtbot.keyClick(full, back)
        assert differ(before, full.image()) < 0.001
    for _ in range(8):
        qtbot.keyClick(full, Qt.Key.Key_Plus)
    assert share(full.image()) > share(before) * 1.3
    qtbot.keyClick(full, Qt.Key.Key_Home)
    assert differ(before, full.image()) < 0.001


def test_from_the_top_the_keys_turn_on_without_a_jump(full, qtbot):
    full.standard_view("top")
    before = full.image()
    qtbot.keyClick(full, Qt.Key.Key_Down)
    assert 0.005 < differ(before, full.image()) < 0.35


def test_the_camera_stays_when_the_result_changes(full, qtbot):
    qtbot.keyClick(full, Qt.Key.Key_Left)
    before = full.image()
    full.show_scene(synthetic.reconstruction())
    assert differ(before, full.image()) < 0.001


def test_a_view_that_nobody_moved_fills_the_new_size(full, qtbot):
    full.window().resize(2 * WIDTH, 2 * HEIGHT)
    qtbot.waitUntil(lambda: full.width() == 2 * WIDTH)
    assert share(full.image()) > 0.15


def test_however_often_asked_it_is_drawn_once_a_turn(full, qtbot):
    QApplication.processEvents()
    drawn = []
    full._stage.window.AddObserver("StartEvent", lambda *_: drawn.append(1))
    for _ in range(5):
        full.refresh()
        full.standard_view("top")
    assert drawn == []
    qtbot.waitUntil(lambda: len(drawn) > 0)
    QApplication.processEvents()
    assert len(drawn) == 1


def test_the_view_survives_another_window(full, qtbot):
    before = full.image()
    full.window().takeCentralWidget()
    moved = shown(full, qtbot)
    assert differ(before, moved.image()) < 0.001


def test_on_a_dense_screen_the_picture_has_all_its_pixels(qtbot):
    class Dense(ImageView):
        def devicePixelRatioF(self):  # noqa: N802 -- Qt's name
            return 2.0

    view = shown(Dense(), qtbot)
    view.show_scene(RESULT)
    image = view.image()
    assert (image.width(), image.height()) == (2 * WIDTH, 2 * HEIGHT)
    assert 0.15 < share(image) < 0.7


def test_what_draws_nothing_says_why(qtbot, monkeypatch):
    def fail(_size):
        raise ExportError("a picture cannot be drawn here: install a driver")

    monkeypatch.setattr("georibbon.scene.offscreen.offscreen_window", fail)
    view = shown(ImageView(), qtbot)
    view.show_scene(RESULT)
    assert "install a driver" in view.fault
    assert np.ptp(pixels(view.grab().toImage()).astype(int)) > 100  # there are words


@pytest.mark.parametrize(("works", "kind"), [(True, SceneView), (False, ImageView)])
def test_the_best_view_that_can_be_had_is_made(qtbot, monkeypatch, works, kind):
    monkeypatch.setattr(scene_view, "opengl_works", lambda: works)
    view = make_view()
    qtbot.addWidget(view)
    assert type(view) is kind
    assert view.accessibleName() == "3D view"


ALONE = """
import sys
from PySide6.QtWidgets import QApplication, QMainWindow
from georibbon.gui.scene_view import ask_for_surfaces, make_view
ask_for_surfaces()
app = QApplication([])
window = QMainWindow()
view = make_view()
window.setCentralWidget(view)
window.show()
heavy = {"vtkmodules", "scipy", "pyqtgraph", "numpy"} & set(sys.modules)
assert not heavy, heavy
sys.path.insert(0, "tests")
import synthetic
view.show_scene(synthetic.reconstruction())
assert not view.image().isNull()
app.processEvents()
window.close()
"""


@pytest.mark.parametrize("platform", ["offscreen", ""])
def test_a_window_shows_before_vtk_is_loaded_and_ends_in_peace(platform):
    chosen = {"QT_QPA_PLATFORM": platform} if platform else {}
    run = subprocess.run(
        [sys.executable, "-X", "dev", "-c", ALONE], check=False, capture_output=True, text=True,
        cwd=Path(__file__).parents[2], env=os.environ | chosen,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert "rror" not in run.stderr
