"""The curves along the passes, as drawn, pointed at and copied."""

import csv
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication

import synthetic
from georibbon.geometry.frames import curvatures
from georibbon.gui.curve_panel import CurvePanel
from georibbon.gui.curve_quantities import QUANTITIES
from georibbon.gui.settings import Settings
from georibbon.gui.theme import COLOURS, palette
from georibbon.gui.units import Units
from georibbon.recording import Pass, Recording
from georibbon.ribbon import Readings

RESULT = synthetic.reconstruction()
PASSES = {one.name: one for one in RESULT.passes}


def recording():
    """What the result may have been made from: every axis's count tells which it is."""
    width = len(RESULT.ribbon.columns)
    counts = np.tile(np.arange(width, dtype=np.float64), (4, 1))
    counts[0, :] += 2.0
    counts[1, :] -= 2.0
    counts[2, 3] = np.nan  # of A02x
    readings = Readings(np.arange(4) / 100, counts)
    passes = tuple(Pass(one.name, one.kind, readings) for one in RESULT.passes)
    return Recording(RESULT.ribbon, (), passes)


@pytest.fixture
def parts(tmp_path):
    """What the panel reads of the program's parts."""
    return SimpleNamespace(settings=Settings(tmp_path / "settings.ini"), units=Units())


@pytest.fixture
def panel(parts, qtbot):
    """A panel of three passes with its first plots."""
    made = CurvePanel(parts)
    qtbot.addWidget(made)
    made.resize(900, 420)
    with qtbot.waitExposed(made):
        made.show()
    made.show_passes(RESULT, ["P1", "P3", "T1"], recording())
    QApplication.processEvents()
    return made


def drawn(panel):
    """By quantity: the curves on the screen, as lists of (s, value) arrays between gaps."""
    found = {}
    for row in panel.rows:
        curves = []
        for line in row.lines:
            x, y = (np.empty(0) if part is None else part for part in line.getData())
            ends = np.nonzero(np.isnan(x))[0]
            pieces = zip(np.split(x, ends), np.split(y, ends), strict=True)
            curves += [(a[~np.isnan(a)], b[~np.isnan(a)]) for a, b in pieces]
        found[row.quantity.id] = [curve for curve in curves if len(curve[0])]
    return found


def place(panel, quantity, s, value):
    """Where a point of a plot is, in the pixels of the plots."""
    box = next(row for row in panel.rows if row.quantity.id == quantity).plot.getViewBox()
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


def test_another_unit_draws_all_anew(panel, parts):
    panel.show_cursor("P3", 0.254)
    parts.units.use("in")
    curves = drawn(panel)
    assert np.allclose(curves["sigma"][0][0], PASSES["P1"].strip.s / 0.0254)
    assert np.allclose(curves["sigma"][0][1], PASSES["P1"].position_sigma / 0.0254)
    assert np.allclose(curves["curvature"][0][1], curvatures(PASSES["P1"].strip)[0])
    assert panel.reading.text().startswith("P3 at 10.000 in")
    low, high = panel.rows[0].plot.getViewBox().viewRange()[0]
    assert low < 0 < PASSES["P1"].strip.s[-1] / 0.0254 < high < 45


def test_quantities_are_chosen_by_the_keys_and_kept(panel, qtbot, parts):
    panel.choice.setFocus()
    for row in range(panel.choice.count()):
        item = panel.choice.item(row)
        if item.data(Qt.ItemDataRole.UserRole) in ("curvature", "torsion", "magnetometer-y"):
            before = item.checkState()
            panel.choice.setCurrentRow(row)
            qtbot.keyClick(panel.choice, Qt.Key.Key_Space)
            assert item.checkState() != before
    assert panel.quantities == ["torsion", "sigma", "magnetometer-y"]
    again = CurvePanel(parts)
    qtbot.addWidget(again)
    assert again.quantities == panel.quantities


def test_every_quantity_is_drawn(panel):
    every = [one.id for one in QUANTITIES]
    panel.show_quantities(every)
    assert panel.quantities == every
    assert all(drawn(panel)[name] for name in every if name != "magnetometer-z")


def test_tangents_and_positions_are_those_of_the_strip(panel):
    panel.show_quantities(["tangent-x", "tangent-y", "tangent-z", "x", "y", "z"])
    curves = drawn(panel)
    strip = PASSES["P3"].strip
    for axis, letter in enumerate("xyz"):
        assert np.allclose(curves[f"tangent-{letter}"][1][1], strip.frames[:, axis, 0])
        assert np.allclose(curves[letter][1][1], strip.points[:, axis] * 1e3)


def test_residuals_are_stems_at_their_sensors(panel):
    panel.show_quantities(["residuals"])
    (stems,) = drawn(panel).values()
    for name, (x, y) in zip(("P1", "P3", "T1"), stems, strict=True):
        known = PASSES[name].residuals[np.isfinite(PASSES[name].residuals)]
        assert np.all(y[::2] == 0)
        assert np.allclose(y[1::2], known)
        assert np.all(x[::2] == x[1::2])
        sensors = np.repeat([1e3 * one.position for one in RESULT.ribbon.sensors], 3)
        places = sensors[np.isfinite(PASSES[name].residuals).reshape(-1)]
        assert np.abs(x[1::2] - places).max() < 12  # mm; the next sensor is 30 mm away
    assert len(np.unique(np.concatenate([x[1::2] for x, _ in stems]))) == sum(
        len(x) // 2 for x, _ in stems
    )


def test_raw_readings_are_the_means_of_the_counts(panel):
    panel.show_quantities(["accelerometer-x", "magnetometer-y", "magnetometer-z"])
    curves = drawn(panel)
    ribbon = RESULT.ribbon
    x = [i for i, name in enumerate(ribbon.columns) if name[0] == "A" and name[-1] == "x"]
    assert np.allclose(curves["accelerometer-x"][0][1], x)
    y = [i for i, name in enumerate(ribbon.columns) if name[0] == "M" and name[-1] == "y"]
    assert np.allclose(curves["magnetometer-y"][0][1], y)
    assert curves["magnetometer-z"] == []  # this ribbon's have two axes
    panel.show_passes(RESULT, ["P1"])
    assert np.isnan(drawn(panel)["accelerometer-x"][0][1]).all()
    assert "not to be had" in panel.told.text()


def test_more_passes_than_looks_are_all_drawn_with_gaps_between(panel):
    many = [replace(RESULT.passes[k % 5], name=f"Q{k}") for k in range(40)]
    panel.show_passes(replace(RESULT, passes=tuple(many)), [one.name for one in many])
    assert len(drawn(panel)["sigma"]) == 40
    assert len(panel.rows[0].lines) < 40
    assert "and 28 more" in panel.legend.text()
    assert panel.told.text() == ""


def test_very_many_points_are_thinned_and_this_is_told(panel):
    many = [replace(RESULT.passes[k % 5], name=f"Q{k}") for k in range(400)]
    panel.show_passes(replace(RESULT, passes=tuple(many)), [one.name for one in many])
    curves = drawn(panel)["sigma"]
    assert len(curves) == 400
    assert sum(len(x) for x, _ in curves) <= 20_000
    tops = sorted(float(y.max()) for _, y in curves)
    assert np.allclose(tops, sorted(1e3 * one.position_sigma.max() for one in many))
    assert "points are drawn" in panel.told.text()


def test_a_new_result_moves_the_lines_and_keeps_the_plots(panel):
    before = [(row.plot, *row.lines) for row in panel.rows]
    heights = panel.rows[1].plot.getViewBox().viewRange()[1]
    closer = [replace(one, covariance=0.9 * one.covariance) for one in RESULT.passes]
    panel.show_passes(replace(RESULT, passes=tuple(closer)), ["P1", "P3", "T1"])
    assert [(row.plot, *row.lines) for row in panel.rows] == before
    sigma = drawn(panel)["sigma"][0][1]
    assert np.allclose(sigma, 0.9**0.5 * 1e3 * PASSES["P1"].position_sigma)
    assert panel.rows[1].plot.getViewBox().viewRange()[1] == heights


def test_values_that_leave_the_plot_are_followed(panel):
    for factor in (9.0, 0.01):
        other = [replace(one, covariance=factor * one.covariance) for one in RESULT.passes]
        panel.show_passes(replace(RESULT, passes=tuple(other)), ["P1", "P3", "T1"])
        low, high = panel.rows[1].plot.getViewBox().viewRange()[1]
        values = np.concatenate([y for _, y in drawn(panel)["sigma"]])
        assert low <= values.min() < values.max() <= high
        assert values.max() - values.min() > 0.3 * (high - low)


def test_what_nobody_sees_is_drawn_when_it_is_seen(panel):
    panel.hide()
    before = drawn(panel)["sigma"][0][1].copy()
    wider = [replace(one, covariance=4 * one.covariance) for one in RESULT.passes]
    panel.show_passes(replace(RESULT, passes=tuple(wider)), ["P1", "P3", "T1"])
    assert np.allclose(drawn(panel)["sigma"][0][1], before)
    panel.show()
    assert np.allclose(drawn(panel)["sigma"][0][1], 2 * before)


def test_nothing_is_drawn_of_nothing(panel):
    panel.show_cursor("P3", 0.2)
    panel.show_passes(None, ["P1"])
    assert not any(drawn(panel).values())
    assert panel.reading.text() == ""
    panel.show_passes(RESULT, [])
    assert "no pass" in panel.legend.text()
    assert panel.as_csv() == ""
    panel.show_quantities([])
    panel.show_passes(RESULT, ["P1"])
    assert drawn(panel) == {}


def test_the_pointer_moves_the_cursor_to_the_nearest_pass(panel, qtbot):
    moved = []
    panel.cursor_moved.connect(lambda name, s: moved.append((name, s)))
    for name in ("P3", "P1"):
        value = 1e3 * float(np.interp(0.25, PASSES[name].strip.s, PASSES[name].position_sigma))
        point_at(panel, qtbot, moved, 250, value)
        assert moved[-1][0] == name
        assert moved[-1][1] == pytest.approx(0.25, abs=0.004)
        assert panel.reading.text().startswith(f"{name} at ")
        assert f"Uncertainty (1σ) {value:.2f}"[:-1] in panel.reading.text()


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
    assert panel.reading.text().startswith("P3 at 0.0 mm")
    for _ in range(5):
        qtbot.keyClick(panel, Qt.Key.Key_Down)
    assert panel.reading.text().startswith("T1 at ")


def test_the_cursor_reads_the_nearest_sensor(panel):
    panel.show_quantities(["residuals", "accelerometer-x"])
    sensor = RESULT.ribbon.sensors[4]  # A03
    panel.show_cursor("P3", sensor.position + 0.004)
    residuals = PASSES["P3"].residuals[4]
    worst = residuals[np.nanargmax(np.abs(residuals))]
    assert f"Residuals by sensor A03{'xyz'[np.nanargmax(np.abs(residuals))]} {worst:.4g} σ" in (
        panel.reading.text()
    )
    count = RESULT.ribbon.columns.index("A03x")
    assert f"Accelerometers, x A03x {count} counts" in panel.reading.text()
    panel.show_passes(RESULT, ["P3"])
    assert "Accelerometers, x – counts" in panel.reading.text()


def test_a_cursor_from_outside_is_not_told_again(panel, qtbot):
    with qtbot.assertNotEmitted(panel.cursor_moved):
        panel.show_cursor("P3", 0.3)
        panel.show_cursor("P2", 0.3)  # not shown
    assert panel.reading.text().startswith("P3 at 300.0 mm")


def test_the_cursor_stays_with_its_pass_when_others_are_chosen(panel):
    panel.show_cursor("P3", 0.3)
    panel.show_passes(RESULT, ["P2", "P3"])
    assert panel.reading.text().startswith("P3 at 300.0 mm")
    panel.show_passes(RESULT, ["P2"])
    assert panel.reading.text() == ""


def test_no_two_named_passes_look_alike(panel):
    looks = [(pen.color().name(), tuple(pen.dashPattern())) for pen in panel._looks()]
    assert len(set(looks)) == len(looks)
    assert all(pen.width() == 1 for pen in panel._looks())


def test_what_is_drawn_is_copied_as_csv(panel, qtbot):
    panel.show_quantities(["curvature", "sigma", "residuals", "accelerometer-x"])
    panel.setFocus()
    qtbot.keyClick(panel, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    rows = list(csv.reader(QGuiApplication.clipboard().text().splitlines()))
    assert rows[0] == ["pass", "arc length, mm", "Normal curvature, 1/m", "Uncertainty (1σ), mm"]
    points = sum(len(PASSES[name].strip.s) for name in ("P1", "P3", "T1"))
    second = rows[points + 1]
    assert second[:3] == ["pass", "sensor", "arc length, mm"]
    assert second[3:] == ["Residuals by sensor, σ", "Accelerometers, x, counts"]
    assert rows[1][0] == "P1"
    assert float(rows[2][1]) == pytest.approx(1e3 * PASSES["P1"].strip.s[1])
    assert float(rows[1][3]) == pytest.approx(1e3 * PASSES["P1"].position_sigma[0])
    by_axis = {(row[0], row[1]): row for row in rows[points + 2 :]}
    assert float(by_axis["P3", "A03x"][3]) == pytest.approx(PASSES["P3"].residuals[4, 0], rel=1e-6)
    assert float(by_axis["P3", "A03x"][4]) == RESULT.ribbon.columns.index("A03x")
    assert by_axis["P3", "A03y"][4] == ""
    assert ("P3", "M04x") not in by_axis  # not used, and no accelerometer


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
    box = panel.rows[0].plot.getViewBox()
    whole = box.viewRange()[0]
    box.setXRange(100, 200, padding=0)
    panel.show_passes(RESULT, ["P1", "P3"])
    assert np.allclose(box.viewRange()[0], (100, 200))  # what is looked at stays
    at = panel.plots.mapFromScene(box.sceneBoundingRect().center())
    view = panel.plots.viewport()
    qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseDClick(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=at)
    qtbot.waitUntil(lambda: np.allclose(box.viewRange()[0], whole, atol=1))


def test_titles_stand_above_the_plots_where_no_curve_runs(panel):
    panel.resize(600, 220)
    QApplication.processEvents()
    for row in panel.rows:
        title = row.title.mapRectToScene(row.title.itemRect())
        plot = row.plot.getViewBox().sceneBoundingRect()
        assert title.bottom() <= plot.top() + 1
        assert plot.height() > title.height()
        assert row.title.text


def test_many_plots_stay_as_high_as_can_be_read(panel):
    panel.resize(600, 220)
    panel.show_quantities([one.id for one in QUANTITIES])
    QApplication.processEvents()
    for row in panel.rows:
        assert row.plot.getViewBox().sceneBoundingRect().height() > 20
    assert panel.height() == 220
    assert panel.plots.height() > panel.height()
