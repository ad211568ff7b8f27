"""The capture's page as a person uses it: keys and mouse over an engine that has no port."""

import pytest
from capturing_bench import SPACING, Bench
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QComboBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QTabWidget,
    QWidget,
)

from georibbon.capture.ledger import Happening
from georibbon.capture.plan import CapturePlan, PlannedLayout
from georibbon.device.telling import LinkState
from georibbon.gui import dialogs
from georibbon.gui.capturing import plan_page
from georibbon.gui.capturing.capture_page import CapturePage
from georibbon.gui.capturing.model import Quality, merged
from georibbon.gui.theme import COLOURS, apply_theme
from georibbon.session.session import Session

LONG = 20_000  # ms
PLAN = CapturePlan(poses=0, passes=3, ties=1, layout=PlannedLayout(spacing=SPACING, marks=0))


class FakeScene(QWidget):
    """Keeps what it was told to draw."""

    def show_capture(self, drawing):
        self.drawing = drawing

    def set_units(self, symbol, metres):
        self.unit = (symbol, metres)


@pytest.fixture
def bench(qapp, tmp_path):
    assert qapp
    made = Bench.at(tmp_path)
    yield made
    made.end()


@pytest.fixture
def page(qtbot, bench, monkeypatch):
    monkeypatch.setattr(CapturePage, "make_scene", lambda _: FakeScene())
    monkeypatch.setattr(plan_page, "PAUSE", 1_000_000)  # ms: its forecasts are tested elsewhere
    made = CapturePage(bench.parts, folder=bench.folder)
    made.plan.spacing.set_metres(SPACING)
    made.plan.marks.setCurrentIndex(0)
    qtbot.addWidget(made)
    made.resize(1180, 720)
    made.show()
    yield made
    made.end()


def cell(page, key, column):
    row = page.view.list.keys.index(key)
    return page.view.list.topLevelItem(row).text(column)


def test_passes_are_asked_for_one_after_another(page, bench):
    bench.begin(PLAN)
    view = page.view
    assert page.stack.currentWidget() is view
    assert view.headline.text() == "Lay P1"
    assert "edge" in view.how.text()
    bench.lay("P1")
    assert view.headline.text() == "Lay P2"
    assert "80.0 mm to the left of P1" in view.how.text()
    assert cell(page, "P1", 1) == "taken"
    assert cell(page, "P2", 1) == "asked for"
    assert view.verdict.name == "P1"
    assert view.verdict.word.text() == "good"
    bench.lay("P2", "P3")
    assert view.headline.text() == "Lay T1"
    assert "across all passes, about 240.0 mm" in view.how.text()
    bench.lay("T1")
    assert "Everything" in view.headline.text()
    assert not view.take_button.isEnabled()


def test_the_live_curve_lies_beside_its_neighbour(page, bench):
    bench.begin(PLAN, auto=False)
    bench.lay("P1")
    page.view.take()
    bench.lay("P2")
    view = page.view
    assert "off parallel to P1" in view.angle.text()
    assert "apart" in view.far.text()
    assert view.hints.text().startswith("✓")
    drawing = view.scene.drawing
    assert [one[0] for one in drawing.passes] == ["P1"]
    assert (drawing.live[0], drawing.neighbour) == ("P2", "P1")
    line = view.plots._lines[view.plots.plan][3]
    assert len(line.xData) > 10
    assert line.yData[0] == pytest.approx(80.0, abs=0.5)
    shown = sorted(float(one.textItem.toPlainText()) for one in view.plots._way_labels)
    beside = view._live.beside
    assert shown == pytest.approx([1e3 * beside.least, 1e3 * beside.most], abs=0.06)
    bench.parts.units.use("in")
    assert view.plots._lines[view.plots.plan][3].yData[0] == pytest.approx(80.0 / 25.4, abs=0.1)


@pytest.mark.parametrize("key", [Qt.Key.Key_Space, Qt.Key.Key_PageDown])
def test_space_and_page_down_take_wherever_the_keys_are(page, bench, qtbot, key):
    bench.begin(PLAN, auto=False)
    bench.lay("P1")
    view = page.view
    view.setFocus()
    qtbot.keyClick(view, key)
    assert cell(page, "P1", 1) == "taken"
    bench.lay("P2")
    view.list.setFocus()
    qtbot.keyClick(view.list, key)
    assert cell(page, "P2", 1) == "taken"


def test_a_refusal_says_why_and_can_be_overruled(page, bench, qtbot):
    bench.begin(PLAN, auto=False)
    view = page.view
    bench.do("lift", seconds=0.5)
    view.take()
    assert view.refused.text().startswith("✗ P1 is not taken")
    assert not view.force_button.isEnabled()
    bench.lay("P1")
    assert view.refused.text() == ""
    view.take()
    view.take()  # it has not been lifted since
    assert "lay it anew" in view.refused.text()
    bench.do(seconds=1)
    bench.parts.capture.feed(bench.ribbon.frames(10))
    assert view.force_button.isEnabled()
    qtbot.mouseClick(view.force_button, Qt.MouseButton.LeftButton)
    assert cell(page, "P2", 1) == "taken"


def test_a_pass_is_deleted_and_comes_back(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1", "P2")
    view = page.view
    view.list.choose("P1")
    view.list.setFocus()
    qtbot.keyClick(view.list, Qt.Key.Key_Delete)
    assert cell(page, "P1", 1) == "open"
    assert [one.name for one in bench.parts.document.passes] == ["P2"]
    page.undo()
    assert cell(page, "P1", 1) == "taken"
    page.redo()
    assert cell(page, "P1", 1) == "asked for"


def test_a_pass_is_laid_again(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1", "P2")
    view = page.view
    view.list.choose("P1")
    qtbot.mouseClick(view.again_button, Qt.MouseButton.LeftButton)
    assert view.headline.text() == "Lay P1 again"
    bench.lay("P1")
    assert view.headline.text() == "Lay P3"
    assert sorted(one.name for one in bench.parts.document.passes) == ["P1", "P2"]


def test_a_further_pass_stands_where_it_was_added(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1", "P2", "P3")
    view = page.view
    view.list.choose("P1")
    qtbot.mouseClick(view.add_pass_button, Qt.MouseButton.LeftButton)
    assert view.headline.text() == "Lay P4"
    assert "to the left of P1" in view.how.text()
    assert view.list.keys == ["P1", "P4", "P2", "P3", "T1"]
    bench.lay("P4")
    assert [one.name for one in bench.parts.document.passes] == ["P1", "P4", "P2", "P3"]
    qtbot.mouseClick(view.add_tie_button, Qt.MouseButton.LeftButton)
    assert view.headline.text() == "Lay T2"


def test_passes_change_their_order_by_keys(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1", "P2", "P3")
    view = page.view
    view.list.choose("P3")
    view.list.setFocus()
    qtbot.keyClick(view.list, Qt.Key.Key_Up, Qt.KeyboardModifier.AltModifier)
    assert [one.name for one in bench.parts.document.passes] == ["P1", "P3", "P2"]
    assert view.list.keys[:3] == ["P1", "P3", "P2"]
    assert view.list.chosen == "P3"
    page.move_down()
    assert [one.name for one in bench.parts.document.passes] == ["P1", "P2", "P3"]


def test_passes_change_their_order_by_dragging(page, bench):
    bench.begin(PLAN)
    bench.lay("P1", "P2")
    lines = page.view.list
    before = lines.keys
    lines.insertTopLevelItem(0, lines.takeTopLevelItem(1))
    lines.dropped(before)
    assert [one.name for one in bench.parts.document.passes] == ["P2", "P1"]
    assert lines.keys == ["P2", "P1", "P3", "T1"]
    before = lines.keys
    lines.insertTopLevelItem(0, lines.takeTopLevelItem(3))  # a tie that is not taken stays
    lines.dropped(before)
    assert lines.keys == ["P2", "P1", "P3", "T1"]


def test_a_pass_is_left_out_and_a_note_is_kept(page, bench, qtbot):
    bench.begin(PLAN)
    view = page.view
    qtbot.mouseClick(view.skip_button, Qt.MouseButton.LeftButton)
    assert cell(page, "P1", 1) == "left out"
    page.ask_note()
    qtbot.keyClicks(view.note, "the edge is rough")
    qtbot.keyClick(view.note, Qt.Key.Key_Return)
    assert bench.parts.capture.session.state.notes[0].text == "the edge is rough"
    assert view.note.text() == ""


def test_a_magnet_is_told_with_the_sensors_names(page, bench):
    bench.begin(PLAN, auto=False)
    bench.lay("P1")
    bench.do("magnet 0.6", seconds=2.0)
    assert "disturbed" in page.view.lying.text()
    assert "M" in page.view.lying.text()


def test_a_lost_link_is_told_until_it_is_back(page, bench):
    bench.begin(PLAN)
    view = page.view
    assert view.link_banner.isHidden()
    bench.parts.station.tell(LinkState.STALLED, "the cable was pulled")
    assert not view.link_banner.isHidden()
    assert "goes on by itself" in view.link_banner.words.text()
    assert "the cable was pulled" in view.link_banner.words.text()
    bench.parts.station.tell(LinkState.STREAMING, "")
    assert view.link_banner.isHidden()


def test_the_capture_ends_and_goes_on(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1", "P2")
    with qtbot.waitSignal(page.finished, timeout=LONG):
        qtbot.mouseClick(page.view.finish_button, Qt.MouseButton.LeftButton)
    assert page.stack.currentWidget() is page.plan
    assert page.plan.go_on.isVisible()
    qtbot.mouseClick(page.plan.go_on, Qt.MouseButton.LeftButton)
    assert page.stack.currentWidget() is page.view
    assert page.view.headline.text() == "Lay P3"
    assert page.view.verdict.name == "P2"
    qtbot.waitUntil(lambda: sorted(page.model.placed) == ["P1", "P2"], timeout=LONG)
    assert page.view.verdict.word.text() == "good"
    assert page.plan.passes.value() == 3


def test_how_passes_are_laid_is_known_tomorrow_and_elsewhere(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1")
    qtbot.mouseClick(page.view.finish_button, Qt.MouseButton.LeftButton)
    page.plan.show_plan(CapturePlan(passes=9))  # what another machine remembers
    qtbot.mouseClick(page.plan.go_on, Qt.MouseButton.LeftButton)
    assert bench.parts.capture.plan.layout == PLAN.layout
    assert (page.plan.spacing.metres, page.plan.passes.value()) == (SPACING, 3)
    assert "80.0 mm" in page.view.how.text()


def test_the_view_has_the_unit_in_use(page, bench):
    bench.begin(PLAN)
    assert page.view.scene.unit == ("mm", 0.001)
    bench.parts.units.use("in")
    assert page.view.scene.unit == ("in", 0.0254)
    assert "3.15 in" in page.view.how.text() or "edge" in page.view.how.text()


def test_nothing_is_laid_beside_what_is_to_be_laid_again(page, bench, monkeypatch):
    bench.begin(PLAN)
    bench.lay("P1", "P2")
    judged = page.model.quality
    redo = Quality("redo", "it slipped", True)
    monkeypatch.setattr(page.model, "quality", lambda name: redo if name == "P2" else judged(name))
    bench.do("lift", seconds=0.6)
    bench.do("lay P3", seconds=0.7)
    assert "P1" in page.view.angle.text()
    monkeypatch.setattr(page.model, "quality", lambda _: redo)
    bench.do("lift", seconds=0.6)
    bench.do("lay P3", seconds=0.7)
    assert "P2" in page.view.angle.text()


def test_why_the_poses_give_no_calibration_stays_told(page, bench):
    bench.begin(PLAN)
    capture = bench.parts.capture
    monkey = "not calibrated yet: three poses are the same"
    assert page.view.hints.text() == "" or "✓" in page.view.hints.text()
    capture.engine.calibration = None
    capture.engine._fit = None
    capture.happened.emit(Happening("quality", None, monkey))
    capture.happened.emit(Happening("chosen", "P1", "P1: lay a pass"))
    bench.do("lift", seconds=0.6)
    assert page.view.hints.text() == monkey
    capture.happened.emit(Happening("quality", None, "so far 0.3°"))
    bench.do("lift", seconds=0.6)
    assert "once there is a calibration" in page.view.hints.text()


def test_a_click_on_the_box_leaves_the_keys_to_taking(page, bench, qtbot):
    bench.begin(PLAN)
    page.view.setFocus()
    qtbot.mouseClick(page.view.auto, Qt.MouseButton.LeftButton)
    assert not bench.parts.capture.auto
    assert page.focusWidget() is page.view


def test_the_plan_is_changed_while_it_goes_on(page, bench, qtbot):
    bench.begin(PLAN)
    qtbot.mouseClick(page.view.plan_button, Qt.MouseButton.LeftButton)
    assert page.stack.currentWidget() is page.plan
    page.plan.passes.setValue(4)
    page.plan.spacing.set_metres(0.06)
    qtbot.mouseClick(page.plan.start, Qt.MouseButton.LeftButton)
    assert page.stack.currentWidget() is page.view
    assert page.view.list.keys == ["P1", "P2", "P3", "P4", "T1"]
    bench.lay("P1")
    assert "60.0 mm" in page.view.how.text()


def test_the_survey_gives_residuals_and_names_an_outlier(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1", "P2", "P3", "T1")
    view = page.view
    survey = view.survey
    view.tabs.setCurrentWidget(survey)
    qtbot.mouseClick(survey.propose, Qt.MouseButton.LeftButton)
    assert survey.table.rowCount() == 3
    qtbot.waitUntil(lambda: survey.table.item(0, 10).text().startswith("fits"), timeout=LONG)
    assert float(survey.table.item(0, 9).text()) < 2.0
    qtbot.waitUntil(lambda: cell(page, "P1", 2) == "good", timeout=LONG)
    assert "with the others" in view.verdict.what.text()
    survey.table.item(1, 4).setText("300")  # a slip: it is 240
    assert bench.parts.capture.survey["crossing"][1]["at"][1] == pytest.approx(0.3)
    qtbot.waitUntil(
        lambda: any("outlier" in survey.table.item(k, 10).text() for k in range(3)), timeout=LONG
    )
    page.undo()
    assert bench.parts.capture.survey["crossing"][1]["at"][1] == pytest.approx(0.24)


def test_marks_are_typed_in_and_kept_when_they_are_whole(page, bench, qtbot):
    bench.begin(PLAN)
    bench.lay("P1")
    survey = page.view.survey
    page.view.tabs.setCurrentWidget(survey)
    bench.parts.units.use("cm")
    survey.add("mark")
    assert survey.table.item(0, 10).text() == "to be filled in"
    for column, text in ((5, "1,5"), (6, "2.5"), (7, "0")):
        assert bench.parts.capture.survey["mark"] == []
        survey.table.item(0, column).setText(text)
    assert bench.parts.capture.survey["mark"] == [
        {"pass": "P1", "at": 0.0, "position": [0.015, 0.025, 0.0], "sigma": 0.0005}
    ]
    survey.table.item(0, 5).setText("left")
    assert "no number" in survey.problem.text()
    assert survey.table.item(0, 5).text() == "1.500"
    survey.table.item(0, 1).setText("P9")
    assert "P9" in survey.problem.text()
    assert survey.table.item(0, 1).text() == "P1"
    survey.table.setCurrentCell(0, 1)
    survey.table.setFocus()
    qtbot.keyClick(survey.table, Qt.Key.Key_Delete)
    assert bench.parts.capture.survey["mark"] == []
    page.undo()
    assert len(bench.parts.capture.survey["mark"]) == 1


def test_what_cannot_be_written_is_told_and_saved_elsewhere(page, bench, qtbot, monkeypatch):
    bench.begin(PLAN)
    session = bench.parts.capture.session
    monkeypatch.setattr(Session, "storage_error", property(lambda _: "the disk is full"))
    page.view._storage()
    banner = page.view.storage_banner
    assert not banner.isHidden()
    assert "the disk is full" in banner.words.text()
    assert "Nothing is lost" in banner.words.text()
    monkeypatch.undo()
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: bench.folder / "other.georibbon")
    qtbot.mouseClick(page.view.elsewhere, Qt.MouseButton.LeftButton)
    assert session.path.name == "other.georibbon"
    qtbot.mouseClick(page.view.try_again, Qt.MouseButton.LeftButton)
    assert banner.isHidden()


def test_without_a_calibration_the_poses_come_first(page, bench):
    bench.parts.capture.begin(bench.folder / "p.georibbon", CapturePlan(poses=12, passes=2))
    view = page.view
    assert view.headline.text() == "Hold pose-01"
    assert not view.poses_button.isHidden()
    assert view.list.keys[:2] == ["pose-01", "pose-02"]
    bench.do("lift", seconds=0.7)
    bench.do("pose 1", seconds=2.5)
    assert view.headline.text() == "Hold pose-02"
    assert "calibration" in view.hints.text()


def test_a_calibration_that_goes_on_is_left_to_its_own_page(page, bench, monkeypatch):
    played = []
    monkeypatch.setattr(page.view.sounds, "play", played.append)
    bench.parts.capture.begin(bench.folder / "c.georibbon", CapturePlan(poses=12, passes=0))
    assert page.stack.currentWidget() is page.plan
    assert not page.plan.start.isEnabled()
    assert "calibration goes on" in page.plan.problem.text()
    bench.do("lift", seconds=0.7)
    bench.do("pose 1", seconds=2.5)
    page.take()
    assert played == []
    bench.parts.capture.end()
    assert page.plan.start.isEnabled()


def test_what_is_taken_and_refused_is_heard(page, bench, monkeypatch):
    played = []
    monkeypatch.setattr(page.view.sounds, "play", played.append)
    bench.begin(CapturePlan(poses=0, passes=1))
    bench.do("lift", seconds=0.5)
    page.take()
    assert played == ["refused"]
    assert page.view.ask.light == "poor"
    bench.lay("P1")
    assert played == ["refused", "taken", "complete"]
    assert page.view.ask.light == "good"


@pytest.mark.parametrize(
    ("planned", "taken", "after", "order"),
    [
        (["P1", "P2", "P3"], [], {}, ["P1", "P2", "P3"]),
        (["P1", "P2", "P3"], ["P3", "P1"], {}, ["P3", "P1", "P2"]),
        (["P1", "P2", "P3", "P4"], ["P1", "P3"], {"P4": "P1"}, ["P1", "P4", "P2", "P3"]),
        (["P1", "P2", "P3", "P4"], ["P1", "P4", "P2"], {}, ["P1", "P4", "P2", "P3"]),
    ],
)
def test_open_passes_stand_behind_those_they_are_planned_behind(planned, taken, after, order):
    assert merged(planned, taken, after) == order


def letters(widget):
    """The mnemonics of all that can be seen: of buttons, labels with a buddy, and tabs."""
    texts = [one.text() for one in widget.findChildren(QAbstractButton) if one.isVisible()]
    texts += [one.text() for one in widget.findChildren(QLabel) if one.buddy() is not None]
    for tabs in widget.findChildren(QTabWidget):
        texts += [tabs.tabText(k) for k in range(tabs.count())]
    return [text[text.index("&") + 1].lower() for text in texts if "&" in text]


def test_no_two_mnemonics_are_alike_nor_a_menus(page, bench):
    menus = set("fevh")
    planned = letters(page.plan)
    assert len(set(planned) | menus) == len(planned) + len(menus)
    bench.begin(PLAN)
    page.view.storage_banner.show()
    page.view.poses_button.show()
    for tab in range(2):
        page.view.tabs.setCurrentIndex(tab)
        found = letters(page.view)
        assert len(set(found) | menus) == len(found) + len(menus)


def test_all_that_takes_keys_or_shows_something_has_a_name(page, bench):
    bench.begin(PLAN)
    for kind in (QLineEdit, QAbstractSpinBox, QComboBox, QAbstractItemView):
        for one in page.findChildren(kind):
            inside = isinstance(one.parent(), QComboBox | QAbstractSpinBox)
            popup = one.window() is not page.window() or isinstance(one, QHeaderView)
            assert inside or popup or one.accessibleName(), one


def test_words_follow_the_theme(page, bench, qapp):
    bench.begin(PLAN)
    bench.lay("P1")
    try:
        for theme in ("dark", "light"):
            apply_theme(qapp, theme)
            qapp.processEvents()
            of = COLOURS[theme]
            text = QPalette.ColorRole.WindowText
            assert page.view.verdict.word.palette().color(text) == QColor(of.good)
            assert page.view.headline.palette().color(text) == QColor(of.words)
    finally:
        apply_theme(qapp, "light")


def test_a_calibrations_session_is_not_offered_to_go_on_with(page, bench):
    bench.parts.capture.begin(bench.folder / "c.georibbon", CapturePlan(poses=12, passes=0))
    bench.do("lift", seconds=0.7)
    bench.do("pose 1", seconds=2.5)
    bench.parts.capture.end()
    assert bench.parts.document.session.state.poses
    assert page.plan.go_on.isHidden()
    bench.begin(PLAN)
    bench.parts.capture.end()
    assert not page.plan.go_on.isHidden()


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_names_and_distances_stay_in_the_plot(page, bench, unit):
    bench.parts.units.use(unit)
    bench.begin(PLAN)
    bench.lay("P1", "P2")
    bench.do("lift", seconds=0.6)
    bench.do("lay P3", seconds=0.7)
    plots = page.view.plots
    seen = plots.plan.getViewBox().viewRange()[0]
    assert plots._labels[0].isVisible()
    assert plots._labels[0].pos().x() - seen[0] > 0.08 * (seen[1] - seen[0])
    near, far = plots._way_labels
    for label in (near, far):
        right = label.pos().x() > 0.5 * (seen[0] + seen[1])
        assert label.anchor.x() == (1.0 if right else 0.0)
