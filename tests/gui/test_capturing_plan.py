"""The plan's page: what is planned, what it will give, and where a capture begins."""

import threading
import wave

import pytest
from capturing_bench import Bench, true_calibration
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication

from georibbon.capture.plan import CapturePlan, PlannedLayout, read_plan, write_plan
from georibbon.gui import dialogs
from georibbon.gui.capturing import plan_page, sound
from georibbon.gui.capturing.latest import Latest
from georibbon.gui.capturing.plan_page import PlanPage, remembered_plan
from georibbon.gui.capturing.sound import Sounds, samples, write_sound
from georibbon.session.calibration_file import write_calibration
from georibbon.session.calibration_shelf import Shelf

LONG = 20_000  # ms


@pytest.fixture
def bench(qapp, tmp_path):
    assert qapp
    made = Bench.at(tmp_path)
    yield made
    made.end()


@pytest.fixture
def page(qtbot, bench):
    made = PlanPage(bench.parts, folder=bench.folder / "kept")
    qtbot.addWidget(made)
    made.resize(1100, 700)
    made.show()
    yield made
    made.end()


def wait_for_figure(page, qtbot, words="expected"):
    qtbot.waitUntil(
        lambda: words in page.figure.text() and "computing" not in page.told.text(), timeout=LONG
    )


def test_the_accuracy_follows_the_plan(page, qtbot):
    page.show_plan(CapturePlan(passes=3))
    wait_for_figure(page, qtbot)
    assert "normals" in page.told.text()
    assert "Assumed: a gently domed" in page.told.text()
    marked = page._forecast.figures.rms
    page.mark_sigma.setFocus()
    page.mark_sigma.selectAll()
    qtbot.keyClicks(page.mark_sigma, "5")
    qtbot.keyClick(page.mark_sigma, Qt.Key.Key_Return)
    assert page.plan.layout.mark_sigma == pytest.approx(0.005)
    qtbot.waitUntil(lambda: page._forecast.figures.rms > 2 * marked, timeout=LONG)
    page.marks.setCurrentIndex(0)
    wait_for_figure(page, qtbot, "no surface")
    assert "holds no pass" in page.told.text()
    page.ties.setValue(2)
    wait_for_figure(page, qtbot, "of shape expected")
    page.like.setCurrentIndex(0)
    qtbot.waitUntil(lambda: "flat panel" in page.told.text(), timeout=LONG)


def test_one_pass_gives_no_surface(page, qtbot):
    page.show_plan(CapturePlan(passes=1))
    wait_for_figure(page, qtbot, "no surface")
    assert "two passes" in page.told.text()


def test_a_plan_goes_into_a_file_and_comes_back(page, bench, monkeypatch, qtbot):
    path = bench.folder / "bonnet.toml"
    plan = CapturePlan(passes=7, ties=2, title="bonnet", layout=PlannedLayout(spacing=0.05))
    write_plan(plan, path)
    monkeypatch.setattr(plan_page, "ask_plan", lambda *_: path)
    qtbot.mouseClick(page.load, Qt.MouseButton.LeftButton)
    assert (page.passes.value(), page.ties.value()) == (7, 2)
    assert page.title.text() == "bonnet"
    assert "bonnet" in page.path.name
    other = bench.folder / "other.toml"
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: other)
    qtbot.mouseClick(page.save, Qt.MouseButton.LeftButton)
    kept = read_plan(other)
    assert (kept.passes, kept.layout.spacing) == (7, pytest.approx(0.05))
    path.write_text("passes = no")
    qtbot.mouseClick(page.load, Qt.MouseButton.LeftButton)
    assert "no plan" in page.problem.text()
    assert page.passes.value() == 7


def test_a_capture_begins_and_overwrites_nothing(page, bench, qtbot):
    page.title.setText("bonnet: 1/2")
    first = page.path
    assert first.name.startswith("bonnet 1 2 ")
    first.write_text("somebody's")
    assert page.path != first
    page._path = first
    qtbot.mouseClick(page.start, Qt.MouseButton.LeftButton)
    assert "is there already" in page.problem.text()
    assert first.read_text() == "somebody's"
    page._path = None
    page.use_calibration(true_calibration(), "mine")
    page.passes.setValue(4)
    with qtbot.waitSignal(bench.parts.capture.began, timeout=LONG):
        qtbot.mouseClick(page.start, Qt.MouseButton.LeftButton)
    capture = bench.parts.capture
    assert capture.plan.passes == 4
    assert capture.plan.poses == 0
    assert capture.session.state.title == "bonnet: 1/2"
    assert capture.calibration is not None
    assert remembered_plan(bench.parts.settings).passes == 4


def test_without_a_ribbon_nothing_begins(page, bench, qtbot):
    bench.parts.station.identity = None
    bench.parts.station.disconnected.emit()
    assert not page.start.isEnabled()
    with qtbot.waitSignal(page.wanted, timeout=LONG) as asked:
        qtbot.mouseClick(page.connect, Qt.MouseButton.LeftButton)
    assert asked.args == ["connect"]


def test_kept_calibrations_can_be_chosen(page, bench, monkeypatch, qtbot):
    calibration = true_calibration()
    words = [page.calibration.itemText(k) for k in range(page.calibration.count())]
    assert words == ["20 poses first", "16 poses first", "12 poses first"]
    Shelf(bench.folder / "kept").keep(calibration, "the workshop")
    page.entered()
    assert page.calibration.itemText(0) == "the workshop"
    path = bench.folder / "lent.json"
    write_calibration(calibration, path)
    monkeypatch.setattr(plan_page, "ask_calibration_file", lambda *_: path)
    qtbot.mouseClick(page.choose_calibration, Qt.MouseButton.LeftButton)
    assert page.calibration.currentText() == "lent"
    page.entered()
    assert page.calibration.currentText() == "lent"
    path.write_text("{")
    qtbot.mouseClick(page.choose_calibration, Qt.MouseButton.LeftButton)
    assert "lent.json" in page.problem.text()


def test_a_calibration_of_another_ribbon_is_refused(page, bench, qtbot):
    from dataclasses import replace

    other = replace(true_calibration(), ribbon_id="GR-0099")
    page.use_calibration(other, "not mine")
    with qtbot.waitSignal(bench.parts.capture.failed, timeout=LONG):
        qtbot.mouseClick(page.start, Qt.MouseButton.LeftButton)
    assert "GR-0099" in page.problem.text()


def test_remembered_nonsense_is_the_usual_plan(bench):
    bench.parts.settings.put("capture/spacing", 99.0)
    assert remembered_plan(bench.parts.settings) == CapturePlan()


def test_the_drawing_shows_what_is_planned(page):
    def seen(plan):
        page.drawing.show_plan(plan, 0.48)
        image = page.drawing.grab().toImage()
        return {QColor(image.pixel(x, y)).name() for x in range(image.width())
                for y in range(0, image.height(), 3)}  # fmt: skip

    page.drawing.resize(400, 260)
    from georibbon.gui.theme import colours_of

    of = colours_of(page.palette())
    bare = seen(CapturePlan(passes=3, layout=PlannedLayout(marks=0)))
    assert of.curves[0] in bare
    assert of.curves[1] not in bare
    assert of.curves[1] in seen(CapturePlan(passes=3, ties=1))
    assert "3 passes" in page.drawing.accessibleDescription()
    seen(CapturePlan(passes=40, ties=30, layout=PlannedLayout(spacing=2.0, distances=3)))
    seen(CapturePlan(passes=0))


# --- sounds, and work of which the newest is wanted ---


@pytest.mark.parametrize("name", ["taken", "refused", "complete"])
def test_sounds_are_short_tones_without_clicks(tmp_path, name):
    values = memoryview(samples(name)).cast("h")
    assert 0.1 < len(values) / sound.RATE < 1.0
    assert max(values) > 5000
    assert abs(values[0]) < 500
    assert abs(values[-1]) < 500
    write_sound(name, tmp_path / "s.wav")
    with wave.open(str(tmp_path / "s.wav")) as file:
        assert (file.getnchannels(), file.getnframes()) == (1, len(values))


def test_a_sound_is_played_by_what_is_there_or_beeps(bench, monkeypatch):
    beeps = []
    monkeypatch.setattr(QApplication, "beep", lambda: beeps.append(1))
    monkeypatch.setattr(sound, "PLAYERS", ())
    monkeypatch.setattr(sound.sys, "platform", "linux")
    sounds = Sounds(bench.parts)
    sounds.play("taken")
    assert not beeps  # the settings say to be silent
    bench.parts.settings.sound = True
    sounds.play("taken")
    assert len(beeps) == 1
    monkeypatch.setattr(sound, "PLAYERS", (("true",),))
    sounds.play("refused")
    assert len(beeps) == 1
    folder = sounds._files["refused"].parent
    sounds.end()
    assert not folder.exists()


def test_only_the_newest_work_is_delivered(qtbot):
    latest, done = Latest("test"), []
    latest.done.connect(done.append)
    go, stopped = threading.Event(), []

    def first(stop):
        go.wait(10.0)
        stopped.append(stop())
        return "first"

    latest.ask(first)
    latest.ask(lambda _: "second")
    with qtbot.waitSignal(latest.done, timeout=LONG):
        latest.ask(lambda _: "third")
        go.set()
    assert (done, stopped) == (["third"], [True])
    assert not latest.busy
    with qtbot.waitSignal(latest.failed, timeout=LONG) as failed:
        latest.ask(lambda _: 1 / 0)
    assert isinstance(failed.args[0], ZeroDivisionError)
    latest.ask(lambda _: "nobody's")
    latest.drop()
    qtbot.waitUntil(lambda: not latest.busy, timeout=LONG)
    assert done == ["third"]
