"""The window, driven as a person drives it."""

import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QImage
from PySide6.QtWidgets import QApplication, QDialog, QMenu, QSpinBox

from georibbon.errors import StorageError
from georibbon.gui import dialogs
from georibbon.gui.actions import ACTIONS, Palette
from georibbon.gui.notifier import Notifier
from georibbon.gui.passes_panel import SIGMA, VERDICT
from georibbon.gui.settings import Settings
from georibbon.gui.window import MainWindow
from georibbon.reconstruction import reconstruct
from georibbon.session.session import Session
from georibbon.session.source import load

_KNOWN = {}


@pytest.fixture(autouse=True)
def remembered(monkeypatch):
    """One capture is all that is opened here: what its smoothing gives is computed once."""

    def known(recording, settings, calibration, stages):
        names = tuple(one.name for one in recording.passes)
        key = (names, tuple(sorted(settings.smoothing.items())))
        if key not in _KNOWN:
            _KNOWN[key] = reconstruct(recording, settings, calibration, stages)
        return _KNOWN[key]

    monkeypatch.setattr("georibbon.reconstruction.reconstruct", known)


@pytest.fixture
def make_window(tmp_path, qtbot):
    """Windows over one settings file."""

    def make() -> MainWindow:
        window = MainWindow(Settings(tmp_path / "settings.ini"), Notifier())
        qtbot.addWidget(window)
        window.show()
        qtbot.waitExposed(window)
        return window

    return make


@pytest.fixture
def recent(session, tmp_path):
    """A session that was opened before the window is made."""
    settings = Settings(tmp_path / "settings.ini")
    settings.opened(session)
    settings.save()
    return session


@pytest.fixture
def window(make_window):
    """A window on its start page."""
    return make_window()


@pytest.fixture
def opened(window, session, qtbot):
    """A window with a session in it."""
    wait_for_result(window, qtbot, lambda: window.open(session))
    return window


def wait_for_result(window, qtbot, act):
    with qtbot.waitSignal(window.document.reconstructed, timeout=30000):
        act()


def trigger(window, name):
    window.actions_by_id[name].trigger()


def test_every_action_has_its_words_and_a_key_of_its_own(window):
    keys = [one.shortcut for one in ACTIONS]
    assert all(keys)
    assert len(set(keys)) == len(keys)
    assert len({one.id for one in ACTIONS}) == len(ACTIONS)
    for one in ACTIONS:
        action = window.actions_by_id[one.id]
        assert action.text()
        assert action.statusTip()
        assert action.shortcut().toString()
    in_menus = {action for menu in window.findChildren(QMenu) for action in menu.actions()}
    assert set(window.actions_by_id.values()) <= in_menus


def test_the_mnemonics_of_a_menu_are_its_own(opened):
    for menu in opened.menuBar().findChildren(QMenu):
        texts = [action.text() for action in menu.actions()]
        keys = [text[text.index("&") + 1].lower() for text in texts if "&" in text]
        assert len(set(keys)) == len(keys), texts


def test_the_start_page_offers_what_there_is(make_window, recent):
    window = make_window()
    assert window.pages.currentWidget() is window.start_page
    assert all(dock.isHidden() for dock in window.docks)
    assert window.start_page.recent.item(0).text().startswith(recent.name)
    for name in ("undo", "redo", "fit", "picture", "close", "reset-smoothing"):
        assert not window.actions_by_id[name].isEnabled()
    recent.unlink()
    window.start_page.show_recent(window.settings.recent)
    assert "Nothing yet" in window.start_page.recent.item(0).text()


def test_a_session_is_seen_with_its_verdicts(opened, session):
    assert opened.pages.currentWidget() is opened.view
    assert all(dock.isVisible() for dock in (opened.docks["passes"], opened.docks["notices"]))
    panel = opened.passes_panel
    for fitted in opened.document.reconstruction.passes:
        assert panel.text(fitted.name, VERDICT) == fitted.quality.verdict
        assert float(panel.text(fitted.name, SIGMA)) > 0
        shown = panel.control(fitted.name).number.value()
        assert shown == pytest.approx(1e3 * fitted.smoothing, abs=1)
        assert fitted.quality.reason in panel.reasons.text()
    assert opened.summary.text().startswith("3 passes · ")
    assert opened.notices_panel.list.count() > 0
    assert "Georibbon" in opened.windowTitle()
    assert opened.settings.recent == [session]
    assert opened.actions_by_id["picture"].isEnabled()
    assert opened.progress.isHidden()


def test_a_capture_that_is_not_finished_is_shown_as_far_as_it_goes(
    window, session, tmp_path, qtbot
):
    with Session.open(session) as unfinished:
        for name in ("P1", "P3"):
            unfinished.do("remove", **{"pass": name})
    with qtbot.waitSignal(window.document.failed):
        window.open(session)
    assert [one.name for one in window.document.passes] == ["P2"]
    assert window.passes_panel.text("P2", VERDICT) == ""
    assert window.banner.isVisible()
    trigger(window, "undo")
    trigger(window, "undo")
    qtbot.waitUntil(lambda: not window.document.is_busy)
    assert window.banner.isHidden()
    assert window.passes_panel.text("P1", VERDICT) == "good"
    Session.create(tmp_path / "empty.georibbon").close()
    with qtbot.waitSignal(window.document.failed) as failed:
        window.open(tmp_path / "empty.georibbon")
    assert "no ribbon was connected" in failed.args[0]
    assert window.passes_panel.table.rowCount() == 0
    assert window.summary.text() == ""


def test_a_slider_moves_the_surface_and_is_undone(opened, session, qtbot):
    first = {one.name: one.smoothing for one in opened.document.reconstruction.passes}
    slider = opened.passes_panel.control("P2").slider
    slider.setSliderDown(True)
    wait_for_result(opened, qtbot, lambda: slider.setSliderPosition(300))
    assert not opened.actions_by_id["reset-smoothing"].isEnabled() or opened.document.smoothing
    wait_for_result(opened, qtbot, lambda: slider.setSliderDown(False))
    undo, redo = opened.actions_by_id["undo"], opened.actions_by_id["redo"]
    assert undo.text() == "&Undo the smoothing of pass P2"
    assert not opened.passes_panel.control("P2").back.isChecked()
    wait_for_result(opened, qtbot, undo.trigger)
    assert opened.statusBar().currentMessage() == "Undone: the smoothing of pass P2"
    assert redo.text() == "&Redo the smoothing of pass P2"
    assert opened.passes_panel.control("P2").back.isChecked()
    after = {one.name: one.smoothing for one in opened.document.reconstruction.passes}
    assert after == pytest.approx(first)
    wait_for_result(opened, qtbot, redo.trigger)
    opened.close()
    assert set(load(session).smoothing) == {"P2"}


def test_all_passes_are_smoothed_and_reset(opened, qtbot):
    panel = opened.passes_panel
    wait_for_result(opened, qtbot, lambda: panel.control("P1").number.setValue(120))
    wait_for_result(opened, qtbot, lambda: panel.control("*").number.setValue(200))
    shown = [panel.control(name).number.value() for name in ("*", "P1", "P2", "P3")]
    assert shown == [200, 120, 200, 200]
    assert panel.control("P1").back.text() == "as all"
    wait_for_result(opened, qtbot, panel.control("P1").back.click)
    assert panel.control("P1").number.value() == 200
    wait_for_result(opened, qtbot, lambda: trigger(opened, "reset-smoothing"))
    assert opened.document.smoothing == {}
    assert not opened.actions_by_id["reset-smoothing"].isEnabled()


def test_selected_passes_are_told_of(opened):
    names = []
    opened.passes_panel.chosen.connect(names.append)
    opened.passes_panel.table.selectRow(2)
    assert names == [["P2"]]
    assert opened.passes_panel.reasons.text().startswith("P2: ")
    opened.passes_panel.table.selectRow(0)
    assert opened.passes_panel.selected() == []


def test_what_goes_wrong_stands_above_the_view(opened, tmp_path, qtbot):
    with qtbot.waitSignal(opened.document.failed):
        opened.open(tmp_path / "nothing.georibbon")
    assert opened.banner.isVisible()
    assert "there is no such folder or file" in opened.banner.text.text()
    assert opened.pages.currentWidget() is opened.view
    opened.banner.details_asked.emit()
    assert opened.docks["log"].isVisible()
    assert opened.log_panel.table.topLevelItemCount() >= 2


def test_a_refused_length_goes_with_the_next_that_is_taken(opened, qtbot):
    with qtbot.waitSignal(opened.document.failed):
        opened.document.set_smoothing("P1", 50.0)
    assert opened.banner.isVisible()
    wait_for_result(opened, qtbot, lambda: trigger(opened, "undo"))
    assert opened.banner.isHidden()


def test_a_fault_is_told_and_the_window_goes_on(opened, qtbot, monkeypatch):
    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr("georibbon.reconstruction.reconstruct", broken)
    with qtbot.waitSignal(opened.document.fault):
        opened.document.set_smoothing("P1", 0.1)
    monkeypatch.undo()
    assert "a fault of the program" in opened.banner.text.text().lower()
    wait_for_result(opened, qtbot, lambda: trigger(opened, "undo"))


def test_closing_goes_back_to_the_start_page(opened, session):
    opened.docks["notices"].hide()
    trigger(opened, "close")
    assert opened.pages.currentWidget() is opened.start_page
    assert all(dock.isHidden() for dock in opened.docks)
    assert opened.windowTitle() == "Georibbon"
    assert opened.start_page.recent.item(0).data(Qt.ItemDataRole.UserRole) == session


@pytest.mark.usefixtures("recent")
def test_the_recent_are_opened_from_page_and_menu(make_window, qtbot):
    window = make_window()
    page = window.start_page
    wait_for_result(window, qtbot, lambda: page.recent.itemActivated.emit(page.recent.item(0)))
    window.recent_menu.aboutToShow.emit()
    wait_for_result(window, qtbot, window.recent_menu.actions()[0].trigger)
    window.recent_menu.actions()[-1].trigger()
    assert window.settings.recent == []


def test_files_are_asked_for_and_opened(
    window, session, small_capture, tmp_path, qtbot, monkeypatch
):
    monkeypatch.setattr(dialogs, "ask_session", lambda *_: None)
    trigger(window, "open")
    assert not window.document.is_busy
    monkeypatch.setattr(dialogs, "ask_session", lambda *_: session)
    wait_for_result(window, qtbot, lambda: trigger(window, "open"))
    monkeypatch.setattr(dialogs, "ask_folder", lambda *_: small_capture)
    wait_for_result(window, qtbot, lambda: trigger(window, "open-folder"))
    assert window.kept.text() == "opened to read only"
    target = tmp_path / "imported.georibbon"
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: target)
    wait_for_result(window, qtbot, lambda: trigger(window, "import"))
    assert window.document.path == target
    assert window.kept.text() == "changes are kept in the file"


def test_a_picture_is_written_larger_than_on_the_screen(opened, tmp_path, monkeypatch):
    def ask(path, scale=1, transparent=False):
        wanted = dialogs.Picture(path, scale, transparent)
        monkeypatch.setattr(dialogs, "ask_picture", lambda *_: wanted)

    ask(tmp_path / "one.png")
    trigger(opened, "picture")
    ask(tmp_path / "two.png", 2, True)
    trigger(opened, "picture")
    one, two = QImage(str(tmp_path / "one.png")), QImage(str(tmp_path / "two.png"))
    assert (two.width(), two.height()) == (2 * one.width(), 2 * one.height())
    assert one.pixelColor(1, 1).alpha() == 255
    assert two.pixelColor(1, 1).alpha() == 0
    for bad, why in (("part.txt", "part.txt"), ("no/part.png", "does not exist")):
        opened.banner.hide()
        ask(tmp_path / bad)
        trigger(opened, "picture")
        assert why in opened.banner.text.text()
        assert opened.banner.isVisible()


def test_a_picture_is_asked_for_with_its_size(window, tmp_path, monkeypatch):
    path = tmp_path / "part.png"
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: path)

    def fill(dialog):
        dialog.scale.setValue(3)
        dialog.transparent.setChecked(True)
        return QDialog.DialogCode.Accepted

    monkeypatch.setattr(dialogs.PictureDialog, "exec", fill)
    assert dialogs.ask_picture(window, path) == dialogs.Picture(path, 3, True)
    monkeypatch.setattr(dialogs.PictureDialog, "exec", lambda _: QDialog.DialogCode.Rejected)
    assert dialogs.ask_picture(window, path) is None


def test_the_demonstration_is_opened_where_data_is_kept(window, monkeypatch):
    asked = []
    monkeypatch.setattr(window.document, "open_demonstration", asked.append)
    window.start_page.buttons["demonstration"].click()
    assert len(asked) == 1
    assert asked[0].is_absolute()


def test_a_session_is_dropped(window, session, qtbot):
    def data(*paths):
        mime = QMimeData()
        mime.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
        return mime

    def enter(mime):
        event = QDragEnterEvent(
            QPoint(5, 5), Qt.DropAction.CopyAction, mime, Qt.MouseButton.LeftButton,
            Qt.KeyboardModifier.NoModifier,
        )  # fmt: skip
        event.ignore()
        window.dragEnterEvent(event)
        return event.isAccepted()

    assert not enter(data())
    assert not enter(data(session, session))
    one = data(session)
    assert enter(one)
    drop = QDropEvent(
        QPointF(5, 5), Qt.DropAction.CopyAction, one, Qt.MouseButton.LeftButton,
        Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    wait_for_result(window, qtbot, lambda: window.dropEvent(drop))
    assert window.document.path == session


def test_the_palette_finds_and_does(opened, qtbot):
    trigger(opened, "palette")
    palette = opened.findChild(Palette)
    qtbot.keyClicks(palette.words, "dark col")
    seen = [item for item in palette._items() if not item.isHidden()]
    assert [item.text(0) for item in seen] == ["Dark colours"]
    qtbot.keyClick(palette.words, Qt.Key.Key_Return)
    assert opened.settings.theme == "dark"
    trigger(opened, "palette")
    palette = opened.findChildren(Palette)[-1]
    qtbot.keyClicks(palette.words, "look from")
    first = palette.list.currentItem().text(0)
    qtbot.keyClick(palette.words, Qt.Key.Key_Down)
    second = palette.list.currentItem().text(0)
    qtbot.keyClick(palette.words, Qt.Key.Key_Up)
    assert palette.list.currentItem().text(0) == first != second
    palette.words.clear()
    qtbot.keyClicks(palette.words, "colour")
    assert "colour" in palette.list.currentItem().text(0).lower()
    qtbot.keyClicks(palette.words, " nothing of the kind")
    qtbot.keyClick(palette.words, Qt.Key.Key_Return)
    palette.close()
    opened.set_dark(False)


def test_the_views_are_asked_for(opened, monkeypatch):
    asked = []
    monkeypatch.setattr(opened.view, "standard_view", asked.append)
    monkeypatch.setattr(opened.view, "fit", lambda: asked.append("fit"))
    monkeypatch.setattr(opened.view, "set_parallel", asked.append)
    for one in ACTIONS:
        if one.id.startswith("view-"):
            trigger(opened, one.id)
    for name in ("fit", "parallel", "parallel"):
        trigger(opened, name)
    assert asked == ["iso", "front", "back", "right", "left", "top", "bottom", "fit", True, False]


def test_every_standard_view_is_one():
    from georibbon.gui.scene_view import STANDARD_VIEWS

    views = [one.argument for one in ACTIONS if one.slot == "view.standard_view"]
    assert set(views) == set(STANDARD_VIEWS)


def test_digits_are_typed_into_numbers_and_look_elsewhere(opened, qtbot):
    number = opened.passes_panel.control("P1").number
    assert not isinstance(number, QSpinBox)
    number.setFocus()
    number.selectAll()
    qtbot.keyClicks(number, "130")
    wait_for_result(opened, qtbot, lambda: qtbot.keyClick(number, Qt.Key.Key_Return))
    assert opened.document.smoothing == {"P1": pytest.approx(0.13)}


def test_the_layout_comes_back_and_is_reset(make_window, session, qtbot):
    one = make_window()
    wait_for_result(one, qtbot, lambda: one.open(session))
    one.docks["notices"].hide()
    one.resize(one.width(), 650)
    trigger(one, "dark")
    one.close()
    other = make_window()
    wait_for_result(other, qtbot, lambda: other.open(session))
    assert other.docks["notices"].isHidden()
    assert other.docks["passes"].isVisible()
    assert other.height() == 650
    assert other.actions_by_id["dark"].isChecked()
    trigger(other, "reset-layout")
    assert other.docks["notices"].isVisible()
    trigger(other, "dark")


def test_a_window_from_a_screen_that_is_gone_is_seen(make_window):
    one = make_window()
    one.move(50000, 50000)
    one.close()
    other = make_window()
    screens = QApplication.screens()
    assert any(one.availableGeometry().intersects(other.frameGeometry()) for one in screens)


def test_closing_asks_where_not_everything_is_written(opened, session, monkeypatch):
    real, asked = opened.document._source.session.close, []

    def full(*, discard=False):
        if not discard:
            raise StorageError("the disk is full")
        real(discard=True)

    monkeypatch.setattr(opened.document._source.session, "close", full)
    monkeypatch.setattr(dialogs, "ask_discard", lambda _, sentence: asked.append(sentence))
    assert not opened.close()
    assert opened.isVisible()
    assert opened.document.path == session
    assert opened.docks["passes"].isVisible()
    monkeypatch.setattr(dialogs, "ask_discard", lambda *_: True)
    assert opened.close()
    assert asked == ["the disk is full"]


def test_closing_in_the_midst_of_work_leaves_nothing(make_window, session):
    before = {one.name for one in threading.enumerate()}
    window = make_window()
    window.open(session)
    window.close()
    assert not window.document.is_busy
    after = {one.name for one in threading.enumerate() if not one.daemon}
    assert after <= before
    assert load(session).smoothing == {}


def test_the_log_and_the_about_box(window, monkeypatch):
    shown = []
    monkeypatch.setattr(dialogs, "show_about", shown.append)
    trigger(window, "about")
    assert shown == [window]
    trigger(window, "log")
    assert window.docks["log"].isVisible()


def test_the_icons_of_both_themes_are_there():
    from georibbon.resources import resource

    names = {one.icon for one in ACTIONS if one.icon}
    for theme in ("light", "dark"):
        assert {path.stem for path in Path(resource(f"icons/{theme}")).iterdir()} >= names
