"""The page that calibrates, as a person uses it, over a virtual ribbon held by hand."""

import json
import shutil
import threading
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QLineEdit
from virtual_desk import Hands, virtual

from georibbon.calibration.model import Calibration
from georibbon.capture.plan import CapturePlan
from georibbon.gui.calibrating import page as page_module
from georibbon.gui.calibrating.cards import PoseGrid
from georibbon.gui.calibrating.page import CalibrationPage
from georibbon.gui.calibrating.state import CHECK_KEYS, Card
from georibbon.gui.theme import THEMES, apply_theme
from georibbon.rotations import exp
from georibbon.session.calibration_file import read_calibration
from georibbon.session.calibration_shelf import Shelf

LONG = 20_000  # ms
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture(scope="module")
def nearly(tmp_path_factory):
    """A session in which 11 of 12 poses are taken, all but the last."""
    folder = tmp_path_factory.mktemp("nearly")
    hands = Hands(folder, virtual(poses=12))
    hands.station.connect_ribbon()
    hands.desk.begin(folder / "s.georibbon", CapturePlan(poses=12, passes=0, ties=0))
    for number in range(1, 12):
        hands.pose(number, 1.8)
    hands.end()
    return folder / "s.georibbon"


@pytest.fixture(scope="module")
def calibration(nearly):
    """A calibration of that ribbon, from its eleven poses."""
    from georibbon.calibration import calibrate
    from georibbon.session.session import Session

    with Session.open(nearly, read_only=True) as session:
        recording = session.recording(complete=False)
    return calibrate(recording.ribbon, recording.poses)


class Bench:
    """A page, and the hands before it."""

    def __init__(self, qtbot, folder, poses=12):
        self.qtbot, self.folder = qtbot, folder / "calibrations"
        self.hands = Hands(folder, virtual(poses=poses))
        self.page = CalibrationPage(self.hands.parts, folder=self.folder)
        qtbot.addWidget(self.page)
        self.page.resize(1190, 680)
        self.page.show()
        qtbot.waitExposed(self.page)
        self.page.entered()
        self.settle()

    @property
    def posing(self):
        return self.page.posing

    def settle(self):
        self.qtbot.waitUntil(
            lambda: not (self.page._judge.busy or self.page._reader.busy), timeout=LONG
        )

    def click(self, button):
        self.qtbot.mouseClick(button, LEFT)
        self.settle()

    def key(self, key, widget=None):
        self.qtbot.keyClick(widget or self.posing, key)

    def begin(self, poses=12):
        self.hands.station.connect_ribbon()
        self.page.start.plans.button(poses).setChecked(True)
        self.click(self.page.start.begin_button)

    def go_on(self, session):
        """Go on with a copy of a session."""
        (self.folder / "sessions").mkdir(parents=True)
        shutil.copy(session, self.folder / "sessions" / "calibration x.georibbon")
        self.hands.station.connect_ribbon()
        self.page.show_kept()
        self.click(self.page.start.go_on_button)

    def keep(self, calibration, name="yesterday"):
        kept = Shelf(self.folder).keep(calibration, name)
        self.page.show_kept()
        self.settle()
        return kept

    def check(self):
        self.hands.station.connect_ribbon()
        self.page.start.kept.table.selectRow(0)
        self.click(self.page.start.kept.buttons["check"])
        for key in CHECK_KEYS:
            roll, heading, pitch, table = self.asked(key)
            words = f"pose {roll:g},{heading:g},{pitch:g}" + (",table" if table else "")
            self.hands.lift()
            self.hands.ribbon.do(words)
            self.hands.pass_time(2.0)
        self.settle()

    def asked(self, key):
        pose = next(item.what for item in self.hands.desk.items if item.key == key)
        return pose.roll, pose.heading, pose.pitch, pose.table

    def states(self):
        found = {card.key: card.state for card in self.posing.cards}
        return {key: state for key, state in found.items() if state != "open"}

    def shown(self):
        return self.page.stack.currentWidget()

    def end(self):
        self.page.end()
        self.hands.end()


@pytest.fixture
def bench(qtbot, tmp_path):
    made = Bench(qtbot, tmp_path)
    yield made
    made.end()


def altered(calibration, name, turn):
    """The calibration with one sensor turned, degrees about x, y and z."""
    models = tuple(
        replace(one, gain=one.gain @ exp(np.radians(turn))) if one.name == name else one
        for one in calibration.sensors
    )
    return replace(calibration, sensors=models)


# Beginning


def test_without_a_ribbon_nothing_begins_and_a_connection_is_asked_for(bench):
    start = bench.page.start
    assert start.ribbon.text() == "No ribbon is connected."
    assert not start.begin_button.isEnabled()
    with bench.qtbot.waitSignal(bench.page.connect_wanted):
        bench.click(start.connect_button)
    bench.page.begin(12)
    assert "connect one first" in start.told.text()
    bench.hands.station.connect_ribbon()
    assert "6 accelerometers" in start.ribbon.text()
    assert start.begin_button.isEnabled()
    assert not start.connect_button.isVisible()


def test_the_plans_tell_what_they_give(bench):
    texts = [bench.page.start.plans.button(n).text() for n in (12, 16, 20)]
    assert all(f"{n} poses" in text for n, text in zip((12, 16, 20), texts, strict=True))
    assert all("°" in text for text in texts)
    assert bench.page.start.plans.checkedId() == 20


def test_a_new_calibration_has_its_file_before_anything_is_shown(bench):
    bench.begin()
    files = list((bench.folder / "sessions").glob("calibration GR-0001 *.georibbon"))
    assert len(files) == 1
    assert bench.shown() is bench.posing
    assert len(bench.posing.cards) == 12
    assert bench.states() == {"pose-01": "asked"}
    assert bench.posing.live.title.text() == "Pose 1"
    assert files[0].name in bench.posing.title.text()


def test_what_cannot_begin_is_told_in_its_place(bench, tmp_path):
    bench.hands.station.connect_ribbon()
    (tmp_path / "calibrations").write_text("in the way")
    bench.page.begin(12)
    assert "calibrations" in bench.page.start.told.text()
    assert bench.shown() is bench.page.start


def test_a_session_that_cannot_be_opened_is_told(bench):
    (bench.folder / "sessions").mkdir(parents=True)
    (bench.folder / "sessions" / "calibration x.georibbon").write_text("no session")
    bench.hands.station.connect_ribbon()
    bench.page.show_kept()
    bench.click(bench.page.start.go_on_button)
    assert "calibration x" in bench.page.start.told.text()
    assert bench.shown() is bench.page.start


# Pose after pose


def test_a_pose_is_taken_by_stillness_and_the_next_is_asked_for(bench):
    bench.begin()
    bench.hands.pose(1)
    assert bench.states() == {"pose-01": "good", "pose-02": "asked"}
    assert bench.posing.quality.count.text() == "1 of 12 poses taken"
    assert bench.posing.live.refusal.text().startswith("Pose 1 is taken")


def test_the_bar_as_it_lies_is_shown_beside_what_is_asked(bench):
    bench.begin()
    bench.hands.ribbon.do("pose 3")
    bench.hands.pass_time(2.5)
    live = bench.posing.live
    assert "turn the bar as the picture shows" in live.match.text()
    assert live.now.attitude is not None
    assert live.ring.stillness.state == "still"
    assert "times its noise" in live.rest.text()
    bench.hands.pose(1, 0.8)
    assert "It lies as asked" in live.match.text()
    assert bench.posing.sphere._live[2] > 0.95


def test_any_order_by_click_and_one_pose_alone_is_repeated(bench):
    bench.begin()
    bench.click(bench.posing.grid.card("pose-07"))
    assert bench.states() == {"pose-07": "asked"}
    bench.hands.pose(7)
    assert bench.states()["pose-07"] == "good"
    bench.click(bench.posing.grid.card("pose-07"))
    assert bench.posing.live.title.text() == "Pose 7"
    bench.hands.pose(7)
    assert [one.subject for one in bench.hands.desk.told if one.kind == "taken"] == ["pose-07"] * 2


def test_any_order_by_keys(bench):
    bench.begin()
    first = bench.posing.grid.buttons[0]
    first.setFocus()
    for key in (Qt.Key.Key_Right, Qt.Key.Key_Down):
        bench.key(key, bench.page.focusWidget())
    bench.key(Qt.Key.Key_Return, bench.page.focusWidget())
    assert bench.states() == {"pose-06": "asked"}  # four stand side by side
    for key in (Qt.Key.Key_Home, Qt.Key.Key_Left, Qt.Key.Key_Up):  # there is no further card
        bench.key(key, bench.page.focusWidget())
    assert bench.page.focusWidget() is first
    bench.key(Qt.Key.Key_End, first)
    assert bench.page.focusWidget() is bench.posing.grid.buttons[-1]


@pytest.mark.parametrize("key", [Qt.Key.Key_Space, Qt.Key.Key_PageDown])
def test_a_key_takes_what_stillness_does_not(bench, key):
    bench.begin()
    bench.qtbot.mouseClick(bench.posing.auto, LEFT, pos=QPoint(8, bench.posing.auto.height() // 2))
    assert not bench.hands.desk.auto
    bench.hands.pose(1)
    assert bench.states() == {"pose-01": "asked"}
    bench.key(key, bench.posing.grid.buttons[3])
    assert bench.states()["pose-01"] == "good"


def test_a_refusal_stands_on_its_card_with_reason_and_remedy(bench):
    bench.begin()
    assert not bench.posing.anyway.isEnabled()
    bench.hands.pose(3)
    assert bench.states() == {"pose-01": "refused"}
    card = bench.posing.grid.card("pose-01")
    assert "refused" in card.accessibleName()
    words = bench.posing.live.refusal.text()
    assert words.startswith("Pose 1 is asked with the upper face up")
    assert "turn the bar" in words
    assert bench.posing.live.sign.state == "refused"
    bench.click(bench.posing.anyway)
    assert bench.states()["pose-01"] == "good"


def test_a_verb_that_cannot_be_done_is_told(bench):
    bench.begin()
    bench.click(bench.posing.undo_button)
    assert bench.posing.live.refusal.text() == "nothing can be undone"


def test_undo_and_redo_and_leaving_out(bench):
    bench.begin()
    bench.hands.pose(1)
    bench.click(bench.posing.undo_button)
    assert bench.states() == {"pose-01": "asked"}
    bench.click(bench.posing.redo_button)
    assert bench.states()["pose-01"] == "good"
    bench.click(bench.posing.skip_button)
    assert bench.states()["pose-02"] == "skipped"
    bench.page.choose_next()
    assert bench.states()["pose-04"] == "asked"


def test_the_pages_actions_do_as_its_buttons(bench):
    bench.begin()
    bench.page.set_auto(False)
    bench.hands.pose(1)
    bench.page.take()
    assert bench.states()["pose-01"] == "good"
    bench.page.undo()
    assert bench.states() == {"pose-01": "asked"}
    bench.page.redo()
    bench.page.skip()
    assert bench.states()["pose-02"] == "skipped"
    bench.hands.pose(1)
    bench.page.take()
    assert bench.states()["pose-03"] == "refused"
    bench.page.take_anyway()
    assert bench.states()["pose-03"] == "good"


def test_a_direction_on_the_sphere_asks_for_its_next_pose(bench):
    bench.begin()
    sphere = bench.posing.sphere
    point = next(one for one in sphere.points if "pose-04" in one.keys)
    bench.qtbot.mouseClick(sphere, LEFT, pos=sphere.place(point).toPoint())
    assert bench.states() == {"pose-04": "asked"}
    assert len(sphere.points) == 12  # every pose of this plan has a direction of its own
    assert "0 of 12" in sphere.accessibleDescription()


def test_the_fields_directions_are_shown_once_its_dip_is_known(bench, nearly):
    bench.begin()
    assert not bench.posing.what.isVisible()
    bench.click(bench.posing.stop_button)
    bench.page.shelf.folder.joinpath("sessions").rename(bench.folder / "before")
    bench.go_on(nearly)
    assert bench.posing.what.isVisible()
    gravity = [point.place for point in bench.posing.sphere.points]
    bench.posing.what.setCurrentIndex(1)
    field = [point.place for point in bench.posing.sphere.points]
    assert sum(len(point.keys) for point in bench.posing.sphere.points) == 12
    assert field != gravity


def test_stopping_keeps_what_is_taken_and_it_can_be_gone_on_with(bench):
    bench.begin()
    bench.hands.pose(1)
    bench.click(bench.posing.stop_button)
    assert not bench.hands.desk.active
    assert bench.shown() is bench.page.start
    bench.click(bench.page.start.go_on_button)
    assert bench.states() == {"pose-01": "good", "pose-02": "asked"}


def test_coming_back_to_the_page_the_poses_are_there(bench):
    bench.begin()
    bench.page.left()
    bench.page.entered()
    assert bench.shown() is bench.posing
    bench.hands.desk.end()
    assert bench.shown() is bench.page.start


def test_a_capture_of_passes_alone_is_none_of_this_page(bench, tmp_path):
    bench.hands.station.connect_ribbon()
    bench.hands.desk.begin(tmp_path / "p.georibbon", CapturePlan(poses=0, passes=2))
    bench.page.entered()
    assert bench.shown() is bench.page.start


def test_the_poses_of_a_capture_that_was_begun_elsewhere_are_shown(bench, tmp_path):
    bench.hands.station.connect_ribbon()
    bench.hands.desk.begin(tmp_path / "p.georibbon", CapturePlan(poses=12, passes=2))
    assert bench.shown() is bench.posing
    bench.click(bench.posing.stop_button)
    assert bench.hands.desk.active  # it is not ours to end
    assert bench.shown() is bench.page.start


# The figures


def test_the_figures_come_and_the_bar_is_full_only_when_all_is_done(bench, nearly):
    bench.go_on(nearly)
    quality = bench.posing.quality
    assert "±" in quality.figures["tilt"].value.text()
    assert quality.figures["tilt"].sign.state == "good"
    assert quality.figures["heading"].value.text().endswith("°")
    assert quality.progress.value() < quality.progress.maximum()
    assert bench.posing.finish_button.isEnabled()
    bench.hands.pose(12)
    bench.settle()
    assert bench.shown() is bench.page.done
    assert quality.progress.value() == quality.progress.maximum()


def test_before_the_tenth_pose_it_is_told_how_many_are_missing(bench):
    bench.begin()
    bench.hands.pose(1)
    quality = bench.posing.quality
    assert quality.told.text() == "Figures come with the 10th pose: 9 more."
    assert quality.figures["tilt"].value.text() == "–"
    assert not bench.posing.finish_button.isEnabled()


def test_a_result_of_fewer_poses_is_not_taken_for_the_end(bench, nearly, monkeypatch):
    going_on, real = threading.Event(), page_module.calibrate

    def slow(*given, **named):
        assert going_on.wait(20.0)
        return real(*given, **named)

    bench.go_on(nearly)
    monkeypatch.setattr(page_module, "calibrate", slow)
    bench.hands.pose(12)
    bench.page._show_quality(bench.page._found)  # that of the eleven poses
    assert bench.shown() is bench.posing
    going_on.set()
    bench.settle()
    assert bench.shown() is bench.page.done
    assert bench.page._found.quality.poses == 12


def test_a_wrong_hemisphere_is_refused_with_the_remedy(bench, nearly):
    place = bench.page.start.place
    place.setCurrentIndex(place.findData("south"))
    place.activated.emit(place.currentIndex())
    assert bench.hands.parts.settings.get("calibration/hemisphere", "") == "south"
    bench.go_on(nearly)
    assert "the hemisphere is wrong" in bench.posing.quality.told.text()
    assert not bench.posing.finish_button.isEnabled()
    bench.hands.pose(12)
    bench.settle()
    assert bench.shown() is bench.posing
    assert bench.posing.quality.progress.value() < bench.posing.quality.progress.maximum()


def test_a_pose_beside_steel_turns_yellow_and_is_taken_again_alone(bench, nearly):
    bench.go_on(nearly)
    bench.hands.ribbon.do("magnet 0.2 0.2 1.0")
    bench.hands.pose(12)
    if bench.states().get("pose-12") != "good":
        bench.click(bench.posing.anyway)
    bench.settle()
    assert bench.states()["pose-12"] == "poor"
    assert bench.shown() is bench.posing
    assert "steel" in bench.posing.grid.card("pose-12").toolTip()
    assert "Pose 12" in bench.posing.quality.told.text()
    bench.hands.ribbon.do("magnet off")
    bench.click(bench.posing.grid.card("pose-12"))
    bench.hands.pose(12)
    bench.settle()
    assert bench.states()["pose-12"] == "good"
    assert bench.shown() is bench.page.done


# Done


def test_what_is_made_is_named_kept_and_used(bench, nearly):
    bench.go_on(nearly)
    bench.hands.pose(12)
    bench.settle()
    done = bench.page.done
    assert "first calibration" in done.since.text()
    done.name.setText("a\tb")
    bench.click(done.keep_button)
    assert "printable" in done.told.text()
    done.name.clear()
    bench.qtbot.keyClicks(done.name, "bench 3")
    bench.key(Qt.Key.Key_Return, done.name)
    assert "It is kept as “bench 3”" in done.told.text()
    kept = Shelf(bench.folder).look()[0]
    assert [one.name for one in kept] == ["bench 3"]
    with bench.qtbot.waitSignal(bench.page.finished) as seen:
        bench.click(done.use_button)
    assert isinstance(seen.args[0], Calibration)
    assert not bench.hands.desk.active
    assert [one.name for one in bench.page.start.kept.kept] == ["bench 3"]


def test_going_away_from_a_kept_one_frees_the_ribbon(bench, nearly):
    bench.go_on(nearly)
    bench.click(bench.posing.finish_button)
    bench.page.left()
    assert bench.hands.desk.active  # nothing is kept yet
    bench.click(bench.page.done.keep_button)
    bench.page.left()
    assert not bench.hands.desk.active
    assert bench.shown() is bench.page.start


def test_using_it_keeps_it_first(bench, nearly):
    bench.go_on(nearly)
    bench.hands.pose(12)
    bench.settle()
    with bench.qtbot.waitSignal(bench.page.finished):
        bench.click(bench.page.done.use_button)
    assert len(Shelf(bench.folder).look()[0]) == 1


def test_what_cannot_be_kept_is_not_used_though_an_earlier_one_is(bench, nearly, calibration):
    bench.go_on(nearly)
    bench.hands.pose(12)
    bench.settle()
    bench.click(bench.page.done.keep_button)
    bench.page._found = calibration  # what comes of a pose that is taken again
    bench.page.done.name.setText("a\tb")
    with bench.qtbot.assertNotEmitted(bench.page.finished):
        bench.click(bench.page.done.use_button)
    assert "printable" in bench.page.done.told.text()
    assert bench.hands.desk.active


def test_what_has_changed_since_the_last_one_is_told(bench, nearly, calibration):
    bench.keep(altered(calibration, "A03", (0.0, 1.8, 0.0)))
    bench.go_on(nearly)
    bench.click(bench.posing.finish_button)
    done = bench.page.done
    assert done.since.text().startswith("Since “yesterday”")
    assert "A03 has changed by" in done.words.text()
    assert done.table.item(0, 0).text() == "A03"
    assert done.table.rowCount() == 12
    bench.click(done.back_button)
    assert bench.shown() is bench.posing


def test_a_calibration_with_other_sensors_cannot_be_compared_and_that_is_told(
    bench, nearly, calibration
):
    bench.keep(replace(calibration, sensors=calibration.sensors[:4]))
    bench.go_on(nearly)
    bench.click(bench.posing.finish_button)
    assert "4 sensors" in bench.page.done.since.text()


def test_it_is_exported_as_a_file(bench, nearly, tmp_path, monkeypatch):
    target = tmp_path / "out.json"
    monkeypatch.setattr(page_module, "ask_target", lambda *_: target)
    bench.go_on(nearly)
    bench.click(bench.posing.finish_button)
    bench.click(bench.page.done.export_button)
    assert read_calibration(target).ribbon_id == "GR-0001"
    assert str(target) in bench.page.done.told.text()
    monkeypatch.setattr(page_module, "ask_target", lambda *_: tmp_path / "no" / "out.json")
    bench.click(bench.page.done.export_button)
    assert "cannot be written" in bench.page.done.told.text()
    monkeypatch.setattr(page_module, "ask_target", lambda *_: None)
    bench.click(bench.page.done.export_button)


# The daily check


def test_an_unchanged_ribbon_is_good_and_the_check_is_written_down(bench, calibration):
    bench.keep(calibration)
    bench.check()
    check = bench.posing.check
    assert check.verdict.text() == "Good"
    assert check.sign.state == "good"
    assert check.figures["norm"].sign.state == "good"
    assert check.table.rowCount() > 0
    assert set(bench.states().values()) == {"good"}
    history = Shelf(bench.folder).look()[0][0].checks
    assert [one.verdict for one in history] == ["good"]
    assert list((bench.folder / "sessions").glob("check GR-0001 *.georibbon"))
    bench.click(bench.posing.stop_button)
    bench.settle()
    assert "good" in bench.page.start.kept.table.item(0, 5).text()


def test_a_sensor_that_has_turned_is_named(bench, calibration):
    bench.keep(altered(calibration, "A03", (0.0, 2.0, 0.0)))
    bench.check()
    check = bench.posing.check
    assert check.verdict.text() == "Calibrate again"
    assert "A03" in check.reason.text()
    assert "sensor A03 is off".lower() in check.told.text().lower()
    assert check.table.item(0, 0).text() == "A03"
    assert "turned by" in check.table.item(0, 2).text()


def test_in_the_check_the_poses_come_by_themselves_and_can_be_repeated(bench, calibration):
    bench.keep(calibration)
    bench.check()
    bench.click(bench.posing.grid.card(CHECK_KEYS[1]))
    bench.hands.lift()
    bench.hands.ribbon.do("pose 90,90,0,table")
    bench.hands.pass_time(2.0)
    bench.settle()
    assert len(Shelf(bench.folder).look()[0][0].checks) == 2
    bench.click(bench.posing.undo_button)
    bench.click(bench.posing.undo_button)
    assert bench.posing.check.verdict.text() == "No verdict yet"


def test_without_a_choice_the_ribbons_newest_is_checked(bench, calibration):
    bench.page.begin_check()
    assert "connect one first" in bench.page.start.told.text()
    bench.hands.station.connect_ribbon()
    bench.page.begin_check()
    assert "No calibration of this ribbon" in bench.page.start.told.text()
    shelf = Shelf(bench.folder)
    shelf.keep(calibration, "ours")
    shelf.keep(replace(calibration, ribbon_id="GR-9"), "another's")
    bench.page.begin_check()
    assert bench.shown() is bench.posing
    assert "“ours”" in bench.posing.title.text()
    bench.page.begin_check()  # twice: it goes on as it was
    assert "going on already" in bench.posing.live.refusal.text()
    bench.page.begin(20)
    assert bench.posing.checking
    bench.click(bench.posing.stop_button)
    assert bench.shown() is bench.page.start
    assert not bench.hands.desk.active


def test_another_ribbons_calibration_is_not_checked(bench, calibration):
    bench.keep(replace(calibration, ribbon_id="GR-9"))
    bench.hands.station.connect_ribbon()
    assert not bench.page.start.kept.buttons["check"].isEnabled()


# What is kept


def test_a_kept_one_is_renamed_where_it_stands(bench, calibration):
    bench.keep(calibration)
    kept = bench.page.start.kept
    bench.click(kept.buttons["rename"])
    editor = kept.table.findChild(QLineEdit)
    editor.selectAll()
    bench.qtbot.keyClicks(editor, "today")
    bench.qtbot.keyClick(editor, Qt.Key.Key_Return)
    shelf = Shelf(bench.folder)
    bench.qtbot.waitUntil(lambda: [one.name for one in shelf.look()[0]] == ["today"])
    bench.settle()
    kept.table.item(0, 0).setText("   ")
    assert "1 to 120" in kept.told.text()
    assert kept.table.item(0, 0).text() == "today"


def test_a_deleted_one_is_put_back(bench, calibration):
    bench.keep(calibration)
    kept = bench.page.start.kept
    bench.click(kept.buttons["delete"])
    assert kept.kept == ()
    assert kept.told.text() == "“yesterday” is deleted."
    bench.click(kept.undo)
    assert [one.name for one in kept.kept] == ["yesterday"]
    assert not kept.undo.isVisible()
    kept.put_back()  # nothing more is to be put back
    kept.kept[0].path.unlink()
    bench.click(kept.buttons["delete"])
    assert "cannot be moved" in kept.told.text()


def test_one_is_loaded_from_a_file_and_a_bad_file_is_told(
    bench, calibration, tmp_path, monkeypatch
):
    from georibbon.session.calibration_file import write_calibration

    source = tmp_path / "ribbon 7.json"
    write_calibration(calibration, source)
    kept = bench.page.start.kept
    monkeypatch.setattr(page_module, "ask_file", lambda *_: source)
    bench.click(kept.buttons["load"])
    assert [one.name for one in kept.kept] == ["ribbon 7"]
    source.write_text("no")
    bench.click(kept.buttons["load"])
    assert "not JSON" in kept.told.text()
    monkeypatch.setattr(page_module, "ask_file", lambda *_: None)
    bench.click(kept.buttons["load"])
    assert len(kept.kept) == 1


def test_a_bad_file_in_the_folder_is_told_and_stops_nothing(bench, calibration):
    bench.keep(calibration)
    (bench.folder / "bad.json").write_text(json.dumps({"format": "other"}))
    bench.page.show_kept()
    bench.settle()
    kept = bench.page.start.kept
    assert len(kept.kept) == 1
    assert "bad.json" in kept.told.text()


def test_a_kept_one_is_exported_and_used(bench, calibration, tmp_path, monkeypatch):
    bench.keep(calibration)
    kept = bench.page.start.kept
    monkeypatch.setattr(page_module, "ask_target", lambda *_: tmp_path / "out.json")
    bench.click(kept.buttons["export"])
    assert read_calibration(tmp_path / "out.json").ribbon_id == "GR-0001"
    with bench.qtbot.waitSignal(bench.page.finished) as seen:
        bench.click(kept.buttons["use"])
    assert seen.args[0].ribbon_id == "GR-0001"


def test_a_sensor_that_says_nothing_is_suspect_by_name(qtbot, tmp_path, nearly, calibration):
    off = replace(calibration.sensors[1], used=False, reason="dead")
    sensors = (calibration.sensors[0], off, *calibration.sensors[2:])
    bench = Bench(qtbot, tmp_path)
    bench.go_on(nearly)
    bench.page._show_quality(replace(calibration, sensors=sensors))
    assert "Suspect sensors: M01" in bench.posing.quality.told.text()
    bench.end()


def test_a_fault_of_the_program_is_told_as_one(bench, monkeypatch, nearly):
    def broken(*_, **__):
        raise ValueError("broken")

    monkeypatch.setattr(page_module, "calibrate", broken)
    bench.go_on(nearly)
    assert [entry.level for entry in bench.hands.notifier.entries] == ["fault"]


@pytest.mark.parametrize("theme", THEMES)
def test_every_view_can_be_painted_in_both_themes(bench, qapp, nearly, theme):
    before = qapp.palette()
    apply_theme(qapp, theme)
    try:
        bench.go_on(nearly)
        bench.hands.pose(1, 1.0)
        for view in (bench.page.start, bench.posing, bench.page.done):
            bench.page.stack.setCurrentWidget(view)
            assert not bench.page.grab().isNull()
    finally:
        qapp.setPalette(before)


@pytest.mark.parametrize(("width", "columns"), [(430, 4), (760, 5)])
def test_the_cards_stand_as_there_is_room(qtbot, width, columns):
    grid = PoseGrid()
    qtbot.addWidget(grid)
    poses = CapturePlan(poses=20).planned_poses
    grid.show_cards([Card(one.key, k, one, "open") for k, one in enumerate(poses, start=1)])
    assert grid.minimumSizeHint().width() < 430
    grid.resize(width, 560)
    grid.show()
    qtbot.waitUntil(
        lambda: sum(button.y() == grid.buttons[0].y() for button in grid.buttons) == columns,
        timeout=LONG,
    )
    grid.buttons[0].setFocus()
    qtbot.keyClick(grid.buttons[0], Qt.Key.Key_Down)
    assert grid.focusWidget() is grid.buttons[columns]
