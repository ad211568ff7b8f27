"""The cable is pulled while a pass is taken, and plugged in again, as a person sees it."""

import pytest
from killed_window import calibration_of_today
from PySide6.QtCore import Qt
from quick_ribbon import Person, quicken

from georibbon.device.telling import LinkState

FASTER = 4.0
MODIFIERS = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier


@pytest.fixture
def person(qtbot, tmp_path, monkeypatch):
    """A person at a window with a hurried virtual ribbon inside."""
    quicken(monkeypatch, FASTER)
    return Person(qtbot, tmp_path, monkeypatch)


def begin(person):
    """A capture of three passes by a calibration."""
    window = person.window
    person.click(window.start_page.buttons["connect-virtual"])
    person.wait(lambda: window.station.identity is not None)
    window.show_page("capture")
    page = window.pages.page("capture")
    page.use_calibration(calibration_of_today(), "of today")
    person.type(page.plan.title, "bonnet")
    page.plan.passes.setValue(3)
    page.plan.ties.setValue(0)
    window.hands.pause.setValue(0.0)
    person.click(page.plan.start)
    person.wait(lambda: window.capture.active)
    return page


def taken(window):
    """The names of what the session holds."""
    return [one.name for one in window.document.session.state.passes]


def asked(window):
    """What is asked for."""
    item = window.capture.current
    return None if item is None else item.key


def test_pulled_while_a_pass_is_taken_it_goes_on_when_it_is_plugged_in(person):
    window = person.window
    page = begin(person)
    view, hands = page.view, window.hands
    person.click(hands.lay_button)
    person.wait(lambda: asked(window) == "P2")
    person.click(view.auto)
    person.click(hands.lay_button)
    person.wait(lambda: hands.told.text().startswith("P2"))
    person.wait(lambda: view.ring.stillness is not None and view.ring.stillness.seconds > 0.2)

    person.press(Qt.Key.Key_U, MODIFIERS)
    person.wait(lambda: not window.station.virtual.plugged)
    person.wait(lambda: window.station.state is LinkState.DISCONNECTED)
    assert view.link_banner.isVisible()
    assert "goes on by itself" in view.link_banner.words.text()
    assert "cable out" in window.health.words
    person.click(view.auto)  # by stillness again, of which nothing is heard
    person.press(Qt.Key.Key_Space)
    person.wait(lambda: "✗" in view.refused.text())
    assert view.ring.stillness is None
    assert taken(window) == ["P1"]
    assert window.capture.active
    hands.troubles.menu().aboutToShow.emit()
    assert not hands.cable["unplug"].isEnabled()
    assert hands.cable["replug"].isEnabled()

    person.press(Qt.Key.Key_P, MODIFIERS)
    person.wait(lambda: window.station.state is LinkState.STREAMING)
    person.wait(lambda: not view.link_banner.isVisible())
    assert "streaming" in window.health.words
    person.wait(lambda: "1 reconnect" in window.health.words)  # it is told four times a second
    person.click(hands.lay_button)
    person.wait(lambda: asked(window) == "P3")
    person.click(hands.lay_button)
    person.wait(lambda: asked(window) is None)
    assert taken(window) == ["P1", "P2", "P3"]
    person.click(hands.survey)
    person.wait(lambda: window.document.reconstruction is not None)
    states = [
        event.detail["state"]
        for event in window.document.session.state.history
        if event.action == "link"
    ]
    assert states.count("disconnected") >= 1
    assert states[-1] == "streaming"
    window.close()


def test_closing_the_window_while_the_cable_is_out(person):
    window = person.window
    begin(person)
    person.click(window.hands.lay_button)
    person.wait(lambda: taken(window) == ["P1"])
    path = window.document.path
    person.press(Qt.Key.Key_U, MODIFIERS)
    person.wait(lambda: window.station.state is LinkState.DISCONNECTED)
    assert window.close()
    from georibbon.session.session import Session

    with Session.open(path) as kept:
        assert kept.recovery is None
        assert [one.name for one in kept.state.passes] == ["P1"]
