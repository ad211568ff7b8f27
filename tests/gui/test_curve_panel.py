"""The curves along the passes, as drawn and as pointed at."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication

import synthetic
from georibbon.geometry.frames import curvatures
from georibbon.gui.curve_panel import QUANTITIES, CurvePanel
from georibbon.gui.theme import COLOURS, palette

RESULT = synthetic.reconstruction()
PASSES = {one.name: one for one in RESULT.passes}


@pytest.fixture
def panel(qtbot):
    """A panel of three passes with its first plots."""
    made = CurvePanel()
    qtbot.addWidget(made)
    made.resize(700, 420)
    with qtbot.waitExposed(made):
        made.show()
    made.show_passes(RESULT, ["P1", "P3", "T1"])
    QApplication.processEvents()
    return made


def drawn(panel):
    """By quantity: the curves on the screen, as lists of (s, value) arrays between gaps."""
    found = {}
    for row in panel._rows:
        curves = []
        for line in row.lines:
            x, y = (np.empty(0) if part is None else part for part in line.getData())
            ends = np.nonzero(np.isnan(x))[0]
            pieces = zip(np.split(x, ends), np.split(y, ends), strict=True)
            curves += [(a[~np.isnan(a)], b[~np.isnan(b)]) for a, b in pieces]
        found[row.quantity.id] = [curve for curve in curves if len(curve[0])]
    return found


def place(panel, quantity, s, value):
    """Where a point of a plot is, in the pixels of the plots."""
    box = next(row for row in panel._rows if row.quantity.id == quantity).plot.getViewBox()
    at = box.mapViewToScene(QPointF(s, value))
    return panel.plots.mapFromScene(at)


def point_at(panel, qtbot, moved, s, value):
    """Point until the plots have noticed: of moves in quick succession they skip some."""
    at, before = place(panel, "sigma", s, value), len(moved)

    def noticed():
        qtbot.mouseMove(panel.plots.viewport(), at - QPoint(1, 0))
        qtbot.mouseMove(panel.plots.viewport(), at)
        return len(moved) > before

    qtbot.waitUntil(noticed)


def test_the_chosen_passes_are_drawn_in_their_units(panel):
    curves = drawn(panel)
    assert set(curves) == {"curvature", "sigma"}
    for name, curve in zip(("P1", "P3", "T1"), curves["sigma"], strict=True):
        assert np.allclose(curve[0], PASSES[name].strip.s * 1e3)
        assert np.allclose(curve[1], PASSES[name].position_sigma * 1e3)
    for name, curve in zip(("P1", "P3", "T1"), curves["curvature"], strict=True):
        assert np.allclose(curve[1], curvatures(PASSES[name].strip)[0])


def test_every_quantity_can_be_chosen_by_its_box(panel, qtbot):
    for quantity in QUANTITIES:
        box = panel.buttons[quantity.id]
        if not box.isChecked():
            qtbot.mouseClick(box, Qt.MouseButton.LeftButton, pos=QPoint(8, box.height() // 2))
        assert box.isChecked()
        assert box.statusTip()
    assert list(drawn(panel)) == [one.id for one in QUANTITIES]
    panel.show_quantities(["z"])
    (z,) = drawn(panel).values()
    assert np.allclose(z[1][1], PASSES["P3"].strip.points[:, 2] * 1e3)
    panel.show_quantities([])
    assert drawn(panel) == {}


def test_more_passes_than_looks_are_all_drawn_with_gaps_between(panel):
    many = [replace(RESULT.passes[k % 5], name=f"Q{k}") for k in range(40)]
    panel.show_passes(replace(RESULT, passes=tuple(many)), [one.name for one in many])
    assert len(drawn(panel)["sigma"]) == 40
    assert len(panel._rows[0].lines) < 40
    assert "and 28 more" in panel.legend.text()


def test_a_new_result_moves_the_lines_and_keeps_the_plots(panel):
    before = [row.plot for row in panel._rows]
    wider = [replace(one, covariance=4 * one.covariance) for one in RESULT.passes]
    panel.show_passes(replace(RESULT, passes=tuple(wider)), ["P1", "P3", "T1"])
    assert [row.plot for row in panel._rows] == before
    assert np.allclose(drawn(panel)["sigma"][0][1], 2e3 * PASSES["P1"].position_sigma)


def test_nothing_is_drawn_of_nothing(panel):
    panel.show_cursor("P3", 0.2)
    panel.show_passes(None, ["P1"])
    assert not any(drawn(panel).values())
    assert panel.reading.text() == ""
    panel.show_passes(RESULT, [])
    assert "no pass" in panel.legend.text()


def test_the_pointer_moves_the_cursor_to_the_nearest_pass(panel, qtbot):
    moved = []
    panel.cursor_moved.connect(lambda name, s: moved.append((name, s)))
    for name in ("P3", "P1"):
        value = 1e3 * float(np.interp(0.25, PASSES[name].strip.s, PASSES[name].position_sigma))
        point_at(panel, qtbot, moved, 250, value)
        assert moved[-1][0] == name
        assert moved[-1][1] == pytest.approx(0.25, abs=0.004)
        assert panel.reading.text().startswith(f"{name} at ")
        assert f"uncertainty (1σ) {value:.2f}"[:-1] in panel.reading.text()


def test_the_keys_move_the_cursor_and_stay_on_the_pass(panel, qtbot):
    panel.show_cursor("P1", 0.1)
    length = float(PASSES["P1"].strip.s[-1])
    with qtbot.waitSignal(panel.cursor_moved) as along:
        qtbot.keyClick(panel, Qt.Key.Key_Right)
    assert along.args == ["P1", pytest.approx(0.1 + 0.01 * length)]
    with qtbot.waitSignal(panel.cursor_moved) as across:
        qtbot.keyClick(panel, Qt.Key.Key_Down)
    assert across.args[0] == "P3"
    for _ in range(150):
        qtbot.keyClick(panel, Qt.Key.Key_Left)
    assert panel.reading.text().startswith("P3 at 0 mm")
    for _ in range(5):
        qtbot.keyClick(panel, Qt.Key.Key_Down)
    assert panel.reading.text().startswith("T1 at ")


def test_a_cursor_from_outside_is_not_told_again(panel, qtbot):
    with qtbot.assertNotEmitted(panel.cursor_moved):
        panel.show_cursor("P3", 0.3)
        panel.show_cursor("P2", 0.3)  # not shown
    assert panel.reading.text().startswith("P3 at 300 mm")


def test_the_cursor_stays_with_its_pass_when_others_are_chosen(panel):
    panel.show_cursor("P3", 0.3)
    panel.show_passes(RESULT, ["P2", "P3"])
    assert panel.reading.text().startswith("P3 at 300 mm")
    panel.show_passes(RESULT, ["P2"])
    assert panel.reading.text() == ""


def test_no_two_named_passes_look_alike(panel):
    looks = [(pen.color().name(), tuple(pen.dashPattern())) for pen in panel._looks()]
    assert len(set(looks)) == len(looks)
    assert all(pen.width() == 1 for pen in panel._looks())


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_the_plots_follow_the_theme(panel, theme):
    panel.setPalette(palette(theme))
    image = panel.plots.grab().toImage()
    assert image.pixelColor(2, 2).name() == COLOURS[theme].base
    assert panel.palette().color(QPalette.ColorRole.Base).name() == COLOURS[theme].base
    seen = {
        image.pixelColor(x, y).name()
        for x in range(0, image.width()) for y in range(0, image.height(), 3)
    }  # fmt: skip
    assert COLOURS[theme].curves[0] in seen


def test_names_are_words_not_markup(panel):
    odd = replace(RESULT.passes[0], name="<b>x&y</b>")
    panel.show_passes(replace(RESULT, passes=(odd,)), [odd.name])
    assert "&lt;b>x&amp;y&lt;/b>" in panel.legend.text()


def test_a_double_click_shows_everything_again(panel, qtbot):
    box = panel._rows[0].plot.getViewBox()
    whole = box.viewRange()[0]
    box.setXRange(100, 200, padding=0)
    at = panel.plots.mapFromScene(box.sceneBoundingRect().center())
    view = panel.plots.viewport()
    qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseDClick(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.waitUntil(lambda: np.allclose(box.viewRange()[0], whole, atol=1))
