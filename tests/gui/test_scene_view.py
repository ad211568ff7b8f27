"""The 3D view, drawn by OpenGL in a widget and, without it, as a picture."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QKeyEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QMainWindow

import synthetic
from georibbon.errors import ExportError
from georibbon.gui import scene_view
from georibbon.gui.scene_view import (
    COLOURINGS,
    STANDARD_VIEWS,
    ImageView,
    SceneView,
    make_view,
    opengl_works,
)
from georibbon.gui.scene_words import SCENE_WORDS
from georibbon.gui.theme import palette
from georibbon.scene.colouring import PARTS, Look
from georibbon.scene.drawing import CaptureDrawing
from georibbon.scene.scene import Scene

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


# --- captures, colours, changing in place ---

TAKEN = tuple((one.name, one.kind, one.strip.points) for one in RESULT.passes)


def test_a_capture_is_shown_before_there_is_any_result(view):
    view.show_capture(CaptureDrawing(TAKEN[:2], ("P3", TAKEN[2][2]), "P2"))
    assert share(view.image()) > 0.005
    view.show_capture(None)
    base = view.palette().base().color()
    assert np.all(pixels(view.image()) == [base.red(), base.green(), base.blue()])


def test_a_capture_that_grows_stays_in_sight_until_a_hand_moves_the_camera(view, qtbot):
    view.show_capture(CaptureDrawing(TAKEN[:1]))
    view.show_capture(CaptureDrawing(TAKEN[:1], ("P2", TAKEN[1][2] + [0.0, 3.0, 0.0])))
    fitted = view.image()
    view.fit()
    assert differ(fitted, view.image()) < 0.05
    qtbot.keyClick(view, Qt.Key.Key_Left)
    turned = view._stage.scene.renderer.GetActiveCamera().GetPosition()
    view.show_capture(CaptureDrawing(TAKEN[:1], ("P2", TAKEN[1][2] + [0.0, 9.0, 0.0])))
    assert view._stage.scene.renderer.GetActiveCamera().GetPosition() == turned


def test_another_result_is_shown_in_the_scene_that_is_there(full):
    scene = full._stage.scene
    full.show_scene(synthetic.reconstruction())
    full.set_colouring("mean")
    full.show_capture(CaptureDrawing(TAKEN[:1]))
    assert full._stage.scene is scene
    full.setPalette(palette("dark"))
    assert full._stage.scene is not scene
    assert full._stage.scene.look.colouring == "mean"


@pytest.mark.parametrize("mode", [one for one in COLOURINGS if one != "uncertainty"])
def test_every_colouring_changes_the_picture_and_back(from_above, mode):
    before = from_above.image()
    from_above.set_deviation(1e-3 * RESULT.surface.mesh.vertices[:, 1], "from A")
    from_above.set_colouring(mode)
    assert from_above.colouring == mode
    assert differ(before, from_above.image()) > 0.05 or mode == "normal"  # no grid: nothing to show
    from_above.set_colouring("uncertainty")
    assert differ(before, from_above.image()) < 0.001


def test_what_there_is_not_cannot_be_asked_for(full):
    for refused in (
        lambda: full.set_colouring("rainbow"),
        lambda: full.set_shown("dragons", True),
        lambda: full.set_tool("hammer"),
        lambda: full.set_range((1.0, 1.0)),
    ):
        with pytest.raises(ValueError):  # noqa: PT011 -- four messages
            refused()


def test_a_fixed_range_stays_with_its_colouring(full, qtbot):
    automatic = full.range()
    with qtbot.waitSignal(full.recoloured):
        full.set_range((0.0, 0.01))
    assert full.range() == pytest.approx((0.0, 0.01))
    full.set_colouring("mean")
    assert full.fixed_range is None
    full.set_colouring("uncertainty")
    assert full.fixed_range == (0.0, 0.01)
    full.set_range(None)
    assert full.range() == pytest.approx(automatic)


def test_parts_can_be_hidden_and_shown(from_above):
    before = from_above.image()
    from_above.set_shown("surface", False)
    assert share(from_above.image()) < 0.6 * share(before)
    assert not from_above.is_shown("surface")
    from_above.set_shown("surface", True)
    assert differ(before, from_above.image()) < 0.001


def test_while_it_moves_edges_are_rough_and_smooth_when_it_rests(full, qtbot):
    qtbot.waitUntil(lambda: not full._altered)
    for _ in range(3):
        qtbot.keyClick(full, Qt.Key.Key_Left)
        qtbot.waitUntil(lambda: not full._altered, timeout=20000)
    renderer = full._stage.scene.renderer
    assert not renderer.GetUseFXAA()
    qtbot.waitUntil(renderer.GetUseFXAA, timeout=20000)


def test_two_views_look_from_one_place(full, qtbot):
    other = shown(ImageView(), qtbot)
    other.show_scene(RESULT)
    full.camera_moved.connect(lambda: other.copy_camera(full))
    told = []
    other.camera_moved.connect(lambda: told.append(1))
    qtbot.keyClick(full, Qt.Key.Key_Left)
    qtbot.keyClick(full, Qt.Key.Key_Plus)
    assert differ(full.image(), other.image()) < 0.02
    assert told == []


# --- pictures ---


def test_a_larger_picture_shows_the_same(full):
    one, three = full.image(), full.image(3)
    assert (three.width(), three.height()) == (3 * WIDTH, 3 * HEIGHT)
    small = three.scaled(
        WIDTH, HEIGHT, Qt.AspectRatioMode.IgnoreAspectRatio,
        Qt.TransformationMode.SmoothTransformation,
    )  # fmt: skip
    assert differ(one, small) < 0.06  # edges and letters


def test_a_transparent_picture_has_nothing_behind_the_object(full):
    image = full.image(1, transparent=True)
    opacity = image.convertToFormat(QImage.Format.Format_Alpha8)
    assert image.hasAlphaChannel()
    assert image.pixelColor(2, 2).alpha() == 0
    assert image.pixelColor(MIDDLE).alpha() == 255
    assert opacity.width() == WIDTH


def test_a_picture_that_is_too_large_is_refused_in_words(full):
    with pytest.raises(ExportError, match=r"too large to be drawn.*choose a smaller scale"):
        full.image(100)


def test_an_empty_view_is_a_picture_too(view):
    image = view.image(2, transparent=True)
    assert (image.width(), image.pixelColor(5, 5).alpha()) == (2 * WIDTH, 0)


# --- tools ---

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def from_above(qtbot):
    """A view from above, where x grows to the right and y upwards."""
    view = shown(ImageView(), qtbot)
    view.show_scene(RESULT)
    view.standard_view("top")
    view.image()
    return view


def test_a_click_with_the_point_tool_tells_of_the_place(from_above, qtbot):
    from_above.set_tool("point")
    assert from_above.cursor().shape() == Qt.CursorShape.CrossCursor
    before = from_above.image()
    with qtbot.waitSignal(from_above.picked) as told:
        qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)
    pick = told.args[0]
    assert 0.2 < pick.position[0] < 0.8
    assert abs(pick.position[1]) < 0.25
    assert pick.pass_name in {"P2", "P3", "P4", "T1"}
    assert pick.sigma > 0
    assert 0 < differ(before, from_above.image()) < 0.02  # a mark stands there


def test_two_clicks_measure_a_distance_and_cut_a_section(from_above, qtbot):
    second = MIDDLE + QPoint(60, 10)
    hints = []
    from_above.hinted.connect(hints.append)
    from_above.set_tool("distance")
    qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)
    with qtbot.waitSignal(from_above.measured) as told:
        qtbot.mouseClick(from_above, LEFT, pos=second)
    distance = told.args[0]
    assert distance.straight <= distance.along < 1.1 * distance.straight
    assert hints == ["Click the first place.", "Click the second place.", "Click the first place."]
    for upright in (True, False):
        from_above.set_upright_sections(upright)
        from_above.set_tool("section")
        qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)
        with qtbot.waitSignal(from_above.sectioned) as told:
            qtbot.mouseClick(from_above, LEFT, pos=second)
        assert told.args[0].upright is upright
        assert told.args[0].between == pytest.approx(distance.along, rel=0.02)


def test_measuring_on_at_once_loses_nothing_that_was_measured(from_above, qtbot):
    found = []
    from_above.measured.connect(lambda _: found.append("distance"))
    from_above.sectioned.connect(lambda _: found.append("section"))
    for tool in ("distance", "section", "distance"):
        from_above.set_tool(tool)
        for at in (MIDDLE, MIDDLE + QPoint(60, 10)):
            qtbot.mouseClick(from_above, LEFT, pos=at)
    from_above.set_tool("none")
    qtbot.waitUntil(lambda: len(found) == 3)
    assert found == ["distance", "section", "distance"]


def test_what_is_cleared_while_it_is_measured_does_not_come_back(from_above, qtbot):
    found, cleared = [], False
    from_above.measured.connect(found.append)
    from_above.set_tool("distance")
    for _ in range(2):
        for at in (MIDDLE, MIDDLE + QPoint(60, 10)):
            qtbot.mouseClick(from_above, LEFT, pos=at)
        if not cleared:
            from_above.clear_marks()
            cleared = True
    qtbot.waitUntil(lambda: len(found) > 0)
    from_above.tools._pool.waitForDone()
    QApplication.processEvents()
    assert len(found) == 1


def test_a_place_beside_everything_is_answered_in_words(from_above, qtbot):
    from_above.set_tool("point")
    with qtbot.waitSignal(from_above.hinted) as told:
        qtbot.mouseClick(from_above, LEFT, pos=QPoint(5, 5))
    assert "nothing there" in told.args[0]


def test_a_section_without_a_plane_is_answered_in_words(from_above, qtbot):
    from_above.set_tool("section")
    qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)
    hints = []
    from_above.hinted.connect(hints.append)
    qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)
    qtbot.waitUntil(lambda: any("determine no plane" in hint for hint in hints))


def test_with_a_tool_a_drag_still_turns_and_picks_nothing(full, qtbot):
    full.set_tool("point")
    picks = []
    full.picked.connect(picks.append)
    before = full.image()
    qtbot.mousePress(full, LEFT, pos=MIDDLE)
    qtbot.mouseMove(full, MIDDLE + QPoint(30, 10))
    qtbot.mouseMove(full, MIDDLE + QPoint(60, 20))
    qtbot.mouseRelease(full, LEFT, pos=MIDDLE + QPoint(60, 20))
    assert differ(before, full.image()) > 0.05
    assert picks == []


@pytest.mark.parametrize("key", [Qt.Key.Key_Return, Qt.Key.Key_Space])
def test_the_keys_touch_the_middle_and_escape_puts_the_tool_down(from_above, qtbot, key):
    from_above.set_tool("point")
    with qtbot.waitSignal(from_above.picked) as told:
        qtbot.keyClick(from_above, key)
    assert told.args[0].position is not None
    assert from_above._stage.scene._cross.GetVisibility()
    with qtbot.waitSignal(from_above.tool_changed) as changed:
        qtbot.keyClick(from_above, Qt.Key.Key_Escape)
    assert changed.args == ["none"]
    assert from_above.tool == "none"
    assert not from_above._stage.scene._cross.GetVisibility()
    qtbot.keyClick(from_above, key)  # for others now


def test_a_tools_keys_are_the_views_own_before_any_shortcut(full):
    for key, tool, own in (
        (Qt.Key.Key_Space, "point", True),
        (Qt.Key.Key_Space, "none", False),
        (Qt.Key.Key_A, "point", False),
    ):
        full.set_tool(tool)
        asked = QKeyEvent(QEvent.Type.ShortcutOverride, key, Qt.KeyboardModifier.NoModifier)
        asked.ignore()
        QApplication.sendEvent(full, asked)
        assert asked.isAccepted() is own


def test_another_result_takes_the_marks_away_and_without_one_nothing_is_picked(from_above, qtbot):
    from_above.set_tool("point")
    before = from_above.image()
    qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)
    assert differ(before, from_above.image()) > 0
    from_above.show_scene(synthetic.reconstruction())
    assert differ(before, from_above.image()) < 0.001
    from_above.show_scene(None)
    qtbot.mouseClick(from_above, LEFT, pos=MIDDLE)  # nothing happens


def test_every_word_in_the_scene_can_be_translated():
    said = set()

    def translate(text):
        said.add(text)
        return text

    deviation = np.full(len(RESULT.surface.mesh.vertices), np.nan)
    for mode in COLOURINGS[:5]:
        look = Look(mode, deviation=deviation, shown=frozenset(PARTS), translate=translate)
        spans = replace(RESULT.survey[0], kind="distance", passes=("P1", "P2"), at=(0.5, 0.5))
        surface = replace(RESULT.surface, shape=(61, 97))
        scene = Scene(replace(RESULT, survey=(*RESULT.survey, spans), surface=surface), look=look)
        scene.show_capture(CaptureDrawing((), TAKEN[0][::2], "P1"))
    assert said == SCENE_WORDS
