"""What a clumsy person does in the whole window: twice, too early, in the midst, and away."""

import pytest
from killed_window import calibration_of_today
from PySide6.QtCore import Qt
from quick_ribbon import Person, quicken

from georibbon.session.session import Session

FASTER = 4.0


@pytest.fixture
def person(qtbot, tmp_path, monkeypatch):
    """A person at a window with a hurried virtual ribbon inside, and all that is told."""
    quicken(monkeypatch, FASTER)
    made = Person(qtbot, tmp_path, monkeypatch)
    made.troubles = []
    made.window.notifier.listen(made.hear)
    yield made
    made.window.notifier.leave(made.hear)


@pytest.fixture(autouse=True)
def hearing(monkeypatch):
    def hear(self, entry):
        if entry.level in ("error", "fault"):
            self.troubles.append(entry.text)

    monkeypatch.setattr(Person, "hear", hear, raising=False)


def plan(person):
    """Connected, with a calibration and a small plan; the capture's page."""
    window = person.window
    person.click(window.start_page.buttons["connect-virtual"])
    person.wait(lambda: window.station.identity is not None)
    window.show_page("capture")
    page = window.pages.page("capture")
    page.use_calibration(calibration_of_today(), "of today")
    page.plan.passes.setValue(2)
    page.plan.ties.setValue(0)
    window.hands.pause.setValue(0.0)
    return page


def states(window):
    """How all that is planned stands."""
    return {item.key: item.status for item in window.capture.items}


def test_the_daily_check_from_the_menu_says_what_is_missing(person):
    window = person.window
    check = window.actions_by_id["daily-check"]
    check.trigger()
    page = window.pages.page("calibrate")
    assert window.pages.current == "calibrate"
    assert page.start.told.text() == "No ribbon is connected; connect one first."
    window.connect_virtual()
    person.wait(lambda: window.station.identity is not None)
    check.trigger()
    assert page.start.told.text().startswith("No calibration of this ribbon is kept")
    check.trigger()
    assert not window.capture.beginning
    assert person.troubles == []
    window.close()


def test_begun_twice_with_a_title_that_no_file_can_have(person):
    window = person.window
    page = plan(person)
    page.plan.title.setText("../\u202eé/\\:*?\0" + "x" * 400)
    for _ in range(3):
        page.plan.start.click()
    person.wait(lambda: window.capture.active)
    assert person.troubles == []
    assert window.document.path.parent == window.settings.folder
    assert window.document.title.startswith("../é/\\:*?x")
    for step in (window.undo, window.redo, window.undo, page.delete, page.move_up):
        step()
    window.daily_check()
    assert "going on already" in window.pages.page("calibrate").start.told.text()
    assert window.capture.active
    window.close()


def test_another_session_in_the_midst_and_back_again(person):
    window = person.window
    page = plan(person)
    page.plan.start.click()
    person.wait(lambda: window.capture.active)
    person.click(window.hands.lay_button)
    person.wait(lambda: states(window).get("P1") == "taken")
    path = window.document.path
    window.use_unit("in")
    window.set_dark(True)
    window.files.open_demonstration()
    window.open(path)
    assert len(person.troubles) == 2
    assert all("finish it" in words for words in person.troubles)
    assert window.capture.active
    person.click(page.view.finish_button)
    window.files.open_demonstration()
    window.open(path)
    person.wait(lambda: window.document.path == path and not window.document.is_busy)
    window.show_page("capture")
    page.plan.begin_again()
    page.plan.begin_again()
    person.wait(lambda: window.capture.active)
    assert states(window) == {"P1": "taken", "P2": "open"}
    window.station.disconnect()
    person.wait(page.view.link_banner.isVisible)
    person.press(
        Qt.Key.Key_V, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    )
    person.wait(lambda: window.station.identity is not None)
    window.show_page("capture")
    person.wait(lambda: not page.view.link_banner.isVisible())
    person.click(window.hands.lay_button)
    person.wait(lambda: states(window) == {"P1": "taken", "P2": "taken"})
    window.set_dark(False)
    window.close()


def test_quitting_in_the_midst_loses_nothing(person):
    window = person.window
    page = plan(person)
    page.plan.start.click()
    person.wait(lambda: window.capture.active)
    path = window.document.path
    person.click(window.hands.lay_button)
    person.wait(lambda: states(window).get("P1") == "taken")
    window.hands.lay()
    window.capture.note("the last word")
    assert window.close()
    with Session.open(path) as kept:
        assert kept.recovery is None
        assert [one.name for one in kept.state.passes] == ["P1"]
        assert [one.text for one in kept.state.notes] == ["the last word"]
    assert person.troubles == []
