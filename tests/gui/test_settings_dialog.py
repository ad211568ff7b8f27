"""The settings, as a person chooses them."""

from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialogButtonBox, QLabel

from georibbon.gui import dialogs
from georibbon.gui.settings import Settings
from georibbon.gui.settings_dialog import Chosen, SettingsDialog
from georibbon.gui.theme import theme_of
from georibbon.gui.units import Units


@pytest.fixture
def parts(tmp_path):
    settings = Settings(tmp_path / "settings.ini")
    settings.language = "en"
    return SimpleNamespace(settings=settings, units=Units(settings.unit))


@pytest.fixture(autouse=True)
def colours(qapp):
    """The application, with the colours it had given back."""
    before = qapp.palette()
    yield qapp
    qapp.setStyle("Fusion")
    qapp.setPalette(before)


@pytest.fixture
def dialog(parts, qtbot):
    made = SettingsDialog(parts)
    qtbot.addWidget(made)
    with qtbot.waitExposed(made):
        made.show()
    return made


def test_it_shows_what_is_kept(parts, qtbot, tmp_path):
    settings = parts.settings
    settings.theme, settings.language, settings.sound = "dark", "fr", False
    settings.folder = tmp_path
    parts.units.use("cm")
    made = SettingsDialog(parts)
    qtbot.addWidget(made)
    assert made.chosen == Chosen("dark", "cm", "fr", False, tmp_path)
    assert made.folder.text() == str(tmp_path)
    assert made.language_told.text() == ""


def test_what_is_chosen_by_the_keys_is_applied_and_kept(dialog, parts, colours, qtbot):
    with qtbot.waitSignal(dialog.theme_chosen) as chosen:
        qtbot.keyClick(dialog.theme, Qt.Key.Key_Down)
    assert chosen.args == ["dark"]
    assert theme_of(colours.palette()) == "dark"
    with qtbot.waitSignal(parts.units.changed):
        qtbot.keyClick(dialog.unit, Qt.Key.Key_End)
    assert parts.units.symbol == "in"
    qtbot.keyClick(dialog.language, Qt.Key.Key_Down)
    assert "next start" in dialog.language_told.text()
    qtbot.keyClick(dialog.sound, Qt.Key.Key_Space)
    parts.settings.save()
    again = Settings(parts.settings.path)
    assert (again.theme, again.unit, again.language, again.sound) == ("dark", "in", "fr", False)
    qtbot.keyClick(dialog.language, Qt.Key.Key_Up)
    assert dialog.language_told.text() == ""


def test_a_folder_is_chosen_and_cleared(dialog, tmp_path, monkeypatch, qtbot):
    answers = [tmp_path, None]
    monkeypatch.setattr(dialogs, "ask_folder", lambda *_: answers.pop(0))
    for _ in range(2):
        qtbot.mouseClick(dialog.choose, Qt.MouseButton.LeftButton)
        assert dialog.chosen.folder == tmp_path
    qtbot.mouseClick(dialog.clear, Qt.MouseButton.LeftButton)
    assert dialog.chosen.folder is None
    assert not dialog.clear.isEnabled()


def test_all_as_at_first(dialog, parts, colours, tmp_path, qtbot):
    parts.settings.opened(tmp_path)
    parts.settings.folder = tmp_path
    qtbot.keyClick(dialog.theme, Qt.Key.Key_Down)
    qtbot.keyClick(dialog.unit, Qt.Key.Key_End)
    qtbot.keyClick(dialog.sound, Qt.Key.Key_Space)
    restore = dialog.buttons.button(QDialogButtonBox.StandardButton.RestoreDefaults)
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert dialog.chosen == Chosen("light", "mm", parts.settings.language, True, None)
    assert theme_of(colours.palette()) == "light"
    assert parts.units.symbol == "mm"
    assert parts.settings.recent == [tmp_path]


def test_a_unit_that_is_changed_elsewhere_is_shown(dialog, parts):
    parts.units.use("cm")
    assert dialog.chosen.unit == "cm"


def test_every_field_has_its_words_and_no_two_keys_are_alike(dialog):
    labels = {one.buddy(): one.text() for one in dialog.findChildren(QLabel) if one.buddy()}
    assert {dialog.theme, dialog.unit, dialog.language, dialog.folder} == set(labels)
    texts = [*labels.values(), dialog.sound.text(), dialog.choose.text(), dialog.clear.text()]
    texts += [button.text() for button in dialog.buttons.buttons()]
    keys = [text[text.index("&") + 1].lower() for text in texts]
    assert len(set(keys)) == len(keys), texts
