"""Every action by its keys: each key does one thing, on whatever page one is."""

from PySide6.QtGui import QKeySequence
from quick_ribbon import Person

from georibbon.gui.actions import ACTIONS


def test_every_action_is_done_by_its_keys_and_by_no_others(qtbot, tmp_path, monkeypatch):
    person = Person(qtbot, tmp_path, monkeypatch)
    told, wrong = [], {}
    for name, action in person.window.actions_by_id.items():
        action.triggered.disconnect()
        action.triggered.connect(lambda _=False, name=name: told.append(name))
        action.setEnabled(True)
    for name, action in person.window.actions_by_id.items():
        told.clear()
        keys = action.shortcut()
        assert keys.count() == 1
        person.press(keys[0].key(), keys[0].keyboardModifiers())
        if told != [name]:
            wrong[name] = list(told)
    assert not wrong
    person.window.close()


def test_the_keys_of_hands_that_are_full_belong_to_no_action():
    taken = {QKeySequence(one.shortcut).toString() for one in ACTIONS}
    assert taken.isdisjoint({"Space", "PgDown", "Return", "Esc"})


def test_every_page_has_an_action():
    pages = {one.argument for one in ACTIONS if one.id.startswith("page-")}
    assert pages == {"start", "connect", "calibrate", "capture", "review"}
