"""The health strip and the hands of the virtual ribbon, over a real port and a real capture."""

import subprocess
import sys

import pytest
from connected import SMALL, WAIT, end_parts, make_parts, stream
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QWidget

from georibbon.capture.checklist import Item
from georibbon.capture.plan import CapturePlan, PlannedPass, PlannedPose
from georibbon.device.health import Health
from georibbon.device.telling import LinkState
from georibbon.gui.connect.health_strip import NARROWEST, HealthStrip
from georibbon.gui.connect.laying import laying_words, survey_missing, wrong_words
from georibbon.gui.connect.signs import sign_icon, sign_of
from georibbon.gui.connect.virtual_hands import VirtualHands
from georibbon.gui.theme import COLOURS
from georibbon.session.outline import survey_tables
from georibbon.virtual import VirtualRibbon

LEFT = Qt.MouseButton.LeftButton
PLAN = CapturePlan(poses=12, passes=2, ties=1)
POSE = Item("pose-01", "", PlannedPose("pose-01", 270.0, 90.0, 0.0, True), "open")
TILTED = Item("pose-02", "", PlannedPose("pose-02", 90.0, 0.0, -40.0, False), "open")
PASS = Item("P1", "", PlannedPass("P1", "pass"), "open")


@pytest.fixture
def parts(tmp_path):
    made = make_parts(tmp_path)
    yield made
    end_parts(made)


# --- the strip ---


@pytest.fixture
def strip(parts, qtbot):
    """The strip in a bar that is wide enough."""
    bar = QWidget()
    QHBoxLayout(bar).addWidget(HealthStrip(parts))
    qtbot.addWidget(bar)
    bar.resize(900, 40)
    bar.show()
    qtbot.waitExposed(bar)
    yield bar.findChild(HealthStrip)
    bar.close()


def health(**changes):
    figures = dict.fromkeys(Health.__dataclass_fields__, 0)
    figures |= {"state": LinkState.STREAMING, "reason": "frames come", "frames_per_second": 99.6}
    return Health(**figures | changes)


def test_the_strip_says_how_the_connection_is(strip, parts, qtbot):
    assert strip.text() == "not connected"
    stream(qtbot, parts)
    qtbot.waitUntil(lambda: "frames/s" in strip.text(), timeout=WAIT)
    assert strip.text().startswith("GR-0001 streaming")
    assert "0 lost" in strip.text()
    assert "GR-0001 streaming" in strip.accessibleName()
    parts.station.virtual.do("drop 0.5")
    qtbot.waitUntil(lambda: parts.station.health().lost > 3, timeout=WAIT)
    qtbot.waitUntil(lambda: "0 lost" not in strip.text(), timeout=WAIT)
    parts.station.virtual.do("unplug")
    qtbot.waitUntil(lambda: "cable out" in strip.text(), timeout=WAIT)
    parts.station.virtual.do("replug")
    qtbot.waitUntil(lambda: "1 reconnect" in strip.toolTip(), timeout=WAIT)
    parts.station.disconnect()
    assert strip.text() == "not connected"


def test_a_narrow_strip_says_less_and_troubles_last(strip, parts, qtbot):
    stream(qtbot, parts)
    lengths = []
    for width in (900, 420, 280, 160, 100, NARROWEST):
        strip.setFixedWidth(width)
        strip._take(health(lost=3))
        assert strip.fontMetrics().horizontalAdvance(strip.text()) < width
        lengths.append(len(strip.text()))
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[0] > lengths[-1] == 0
    strip.setFixedWidth(230)
    strip._take(health(lost=3))
    assert "3 lost" in strip.text()
    assert "0 damaged" not in strip.text()
    assert "0 damaged" in strip.toolTip()


def test_a_press_of_mouse_or_key_asks_for_the_page(strip, qtbot):
    with qtbot.waitSignal(strip.asked, timeout=WAIT):
        qtbot.mouseClick(strip, LEFT)
    strip.setFocus()
    with qtbot.waitSignal(strip.asked, timeout=WAIT):
        qtbot.keyClick(strip, Qt.Key.Key_Space)


def test_every_state_has_a_shape_of_its_own():
    signs = {sign_of(state, known) for state in LinkState for known in (False, True)}
    assert len(signs) == 5
    shapes = set()
    for sign in signs:
        image = sign_icon(sign, COLOURS["light"]).pixmap(16, 16).toImage()
        alphas = [image.pixelColor(x, y).alpha() > 127 for x in range(16) for y in range(16)]
        assert any(alphas)
        shapes.add(tuple(alphas))  # apart from all colour
    assert len(shapes) == 5


# --- the hands ---


@pytest.fixture
def hands(parts, qtbot):
    made = VirtualHands(parts)
    qtbot.addWidget(made)
    made.show()
    qtbot.waitExposed(made)
    made.pause.setValue(0.0)
    return made


@pytest.fixture
def capturing(hands, parts, qtbot, tmp_path):
    """The hands of a small virtual ribbon in a capture that has begun."""
    stream(qtbot, parts)
    parts.capture.begin(tmp_path / "one.georibbon", PLAN)
    qtbot.waitUntil(lambda: parts.capture.current is not None, timeout=WAIT)
    return hands


def taken(parts):
    return [item.key for item in parts.capture.items if item.status == "taken"]


def test_only_a_virtual_ribbon_has_hands(hands, parts, qtbot):
    assert not hands.panel.isVisible()
    stream(qtbot, parts)
    assert hands.panel.isVisible()
    assert [hands.place.itemData(k) for k in range(hands.place.count())] == ["", "P1", "P2", "T1"]
    parts.station.disconnect()
    assert not hands.panel.isVisible()


def test_what_is_asked_for_is_laid_and_taken_and_the_same_again(capturing, parts, qtbot):
    told = []
    parts.capture.happened.connect(lambda one: told.append((one.kind, one.subject)))
    capturing.lay_button.setFocus()
    qtbot.keyClick(capturing.lay_button, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: taken(parts) == ["pose-01"], timeout=WAIT)
    parts.capture.choose("pose-01")
    qtbot.waitUntil(lambda: parts.capture.current.key == "pose-01", timeout=WAIT)
    qtbot.mouseClick(capturing.lay_button, LEFT)
    qtbot.waitUntil(lambda: told.count(("taken", "pose-01")) == 2, timeout=WAIT)


def test_it_follows_by_itself_also_what_is_chosen_again(capturing, parts, qtbot):
    told = []
    parts.capture.happened.connect(lambda one: told.append((one.kind, one.subject)))
    capturing.follow.setFocus()
    qtbot.keyClick(capturing.follow, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: taken(parts) == ["pose-01"], timeout=WAIT)
    parts.capture.choose("pose-01")
    qtbot.waitUntil(lambda: told.count(("taken", "pose-01")) == 2, timeout=WAIT)
    capturing.set_follow(False)


def test_a_wrong_face_is_refused_by_the_capture(capturing, parts, qtbot):
    told = []
    parts.capture.happened.connect(told.append)
    capturing.wrong.trigger()
    qtbot.waitUntil(lambda: any(one.kind == "refused" for one in told), timeout=WAIT)
    assert not taken(parts)


def test_the_cable_is_pulled_and_put_back_from_the_menu(capturing, parts, qtbot):
    menu = capturing.troubles.menu()
    menu.aboutToShow.emit()
    assert capturing.cable["unplug"].isEnabled()
    assert not capturing.cable["replug"].isEnabled()
    capturing.cable["unplug"].trigger()
    qtbot.waitUntil(lambda: parts.station.state is LinkState.DISCONNECTED, timeout=WAIT)
    menu.aboutToShow.emit()
    assert capturing.cable["replug"].isEnabled()
    capturing.trouble("unplug")
    assert "replug" in capturing.told.text()  # what cannot be done is told
    capturing.cable["replug"].trigger()
    qtbot.waitUntil(lambda: parts.station.state is LinkState.STREAMING, timeout=WAIT)
    capturing.lay()
    qtbot.waitUntil(lambda: taken(parts) == ["pose-01"], timeout=WAIT)


def test_a_magnet_is_put_there_and_taken_away(capturing):
    capturing.magnet.trigger()
    assert "a magnet of 0.25" in capturing.told.text()
    capturing.magnet.trigger()
    assert "no magnet" in capturing.told.text()


def test_a_place_of_ones_own_choice_is_laid_without_a_capture(hands, parts, qtbot):
    stream(qtbot, parts)
    hands.lay()
    assert "Nothing is asked for" in hands.told.text()
    hands.lay_wrongly()
    assert "Nothing is asked for" in hands.told.text()
    hands.place.setCurrentIndex(2)
    said = []
    hands.did.connect(said.append)
    hands.lay()
    qtbot.waitUntil(lambda: len(said) == 2, timeout=WAIT)
    assert said[-1].startswith("P2")
    hands.lift()
    assert "moving hands" in said[-1]


def test_a_pass_that_the_object_has_not_is_told(capturing, parts, qtbot):
    parts.capture.add("P9", "pass")
    qtbot.waitUntil(lambda: parts.capture.current.key == "P9", timeout=WAIT)
    capturing.lay()
    assert "has no P9" in capturing.told.text()


def test_what_was_measured_is_entered_once(capturing, parts, qtbot):
    measured = survey_tables(*parts.station.virtual.survey())
    count = sum(map(len, measured.values()))
    assert count > 4
    qtbot.mouseClick(capturing.survey, LEFT)
    survey = parts.capture
    qtbot.waitUntil(lambda: sum(map(len, survey.survey.values())) == count, timeout=WAIT)
    assert {name: list(survey.survey[name]) for name in measured} == measured
    capturing.enter_survey()
    assert capturing.told.text().startswith("0 ")


def test_without_a_capture_or_a_ribbon_nothing_is_entered(hands):
    hands.enter_survey()
    assert "begin one first" in hands.told.text()
    hands.lift()
    assert "No virtual ribbon" in hands.told.text()


# --- the words ---


def test_every_item_has_words_that_the_virtual_ribbon_knows():
    world = VirtualRibbon(SMALL, clock=lambda: 0.0)
    assert laying_words(POSE) == "pose 270,90,0,table"
    assert laying_words(TILTED) == "pose 90,0,-40"
    for item in (POSE, TILTED, PASS):
        assert "still" in world.do(laying_words(item))
        assert wrong_words(item, world.passes) != laying_words(item)
        assert "still" in world.do(wrong_words(item, world.passes))


def test_only_what_is_measured_of_known_passes_is_missing():
    measured = VirtualRibbon(SMALL, clock=lambda: 0.0).survey()
    tables = survey_tables(*measured)
    assert survey_missing(measured, tables, ["P1", "P2", "T1"]) == []
    first = survey_missing(measured, {}, ["P1"])
    assert {table for table, _ in first} == {"mark"}
    assert {entry["pass"] for _, entry in first} == {"P1"}


def test_what_the_window_starts_with_loads_nothing_heavy():
    modules = ("station.station", "connect.health_strip", "connect.virtual_hands")
    names = ", ".join(f"georibbon.gui.{name}" for name in modules)
    found = (
        f"import sys, {names}; print(*sorted({{'numpy', 'scipy', 'serial'}} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", found], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
