"""The Connect page, driven as a person drives it, over real ports."""

import pytest
from connected import SMALL, WAIT, end_parts, make_parts, stream
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QWidget

from georibbon.device.telling import LinkState
from georibbon.gui.connect import port_list, port_rows, virtual_form
from georibbon.gui.connect.choice import Choice, VirtualChoice, keep_choice, kept_choice
from georibbon.gui.connect.page import ConnectPage, connect_last, connect_virtual
from georibbon.gui.connect.port_rows import PortRow
from georibbon.gui.connect.sensor_table import NAME, PLACE, STATE, X
from georibbon.gui.theme import apply_theme, theme_of
from georibbon.virtual import VirtualRibbon, serve_pty, serve_tcp

LEFT = Qt.MouseButton.LeftButton
KEPT = Choice(virtual=VirtualChoice(surface="dome", passes=2, ties=0, pace=0.0))
PORTS = (
    PortRow("/dev/ttyUSB7", "a converter", "0403:6001, A50285BI", ""),
    PortRow("/dev/ttyS0", "no description", "", "forbidden"),
)


@pytest.fixture
def parts(tmp_path):
    made = make_parts(tmp_path)
    keep_choice(made.settings, KEPT)
    yield made
    end_parts(made)


@pytest.fixture
def page(parts, qtbot, monkeypatch):
    """The page with two ports that are listed."""
    monkeypatch.setattr(port_rows, "port_rows", lambda _connected: PORTS)
    made = ConnectPage(parts)
    qtbot.addWidget(made)
    made.resize(1200, 820)
    made.show()
    qtbot.waitExposed(made)
    return made


def click(qtbot, button):
    qtbot.mouseClick(button, LEFT)


def streaming(qtbot, parts):
    qtbot.waitUntil(lambda: parts.station.state is LinkState.STREAMING, timeout=WAIT)


def test_the_virtual_ribbon_is_there_and_connected_by_one_click(page, parts, qtbot):
    assert page.ways["virtual"].isChecked()
    assert not page.stop.isEnabled()
    click(qtbot, page.go)
    streaming(qtbot, parts)
    assert parts.station.virtual.passes == ("P1", "P2")
    assert page.card.labels["Name"].text() == "GR-0001"
    assert "16 accelerometers" in page.card.labels["Sensors"].text()
    assert page.card.labels["Length"].text() == "960.0 mm"
    assert page.told.text().startswith("Streaming")
    parts.units.use("in")
    assert page.card.labels["Length"].text() == "37.795 in"
    click(qtbot, page.stop)
    assert parts.station.state is LinkState.DISCONNECTED
    assert page.card.labels == {}
    assert page.told.text().startswith("Not connected")


def test_the_choices_of_the_virtual_ribbon_hold_for_the_next_start(page, parts, qtbot):
    form = page.virtual
    form.object.setFocus()
    qtbot.keyClicks(form.object, "sad")  # as one chooses by typing
    form.passes.setValue(3)
    form.drop.setValue(5.0)
    form.way.setCurrentIndex(1)
    click(qtbot, page.go)
    streaming(qtbot, parts)
    assert parts.station.url.startswith("socket://")
    assert parts.station.virtual.settings.simulation.surface == "saddle"
    assert parts.station.virtual.settings.drop == 0.05
    again = ConnectPage(parts)
    qtbot.addWidget(again)
    assert again.choice() == page.choice()
    assert kept_choice(parts.settings).virtual.passes == 3


def test_a_mesh_is_asked_for_and_its_absence_told(page, parts, qtbot, monkeypatch, tmp_path):
    form = page.virtual
    form.object.setCurrentIndex(form.object.count() - 1)
    click(qtbot, page.go)
    assert "mesh file" in page.told.text()
    assert not parts.station.active
    none = tmp_path / "none.stl"
    monkeypatch.setattr(virtual_form, "ask_mesh", lambda *_: str(none))
    click(qtbot, form.browse)
    with qtbot.waitSignal(parts.station.failed, timeout=WAIT):
        click(qtbot, page.go)
    assert "none.stl" in page.told.text()


def test_ports_are_listed_with_what_is_known_and_chosen(page, parts, qtbot):
    page.ways["port"].setChecked(True)
    listed = page.ports.list
    qtbot.waitUntil(lambda: listed.topLevelItemCount() == 2, timeout=WAIT)
    first, second = listed.topLevelItem(0), listed.topLevelItem(1)
    assert [first.text(k) for k in range(4)] == ["/dev/ttyUSB7", "a converter",
                                                 "0403:6001, A50285BI", ""]  # fmt: skip
    assert "no right" in second.text(port_list.HINT)
    assert "dialout" in second.toolTip(port_list.HINT)
    where = listed.visualItemRect(first).center()
    qtbot.mouseClick(listed.viewport(), LEFT, pos=where)
    assert page.choice().port == "/dev/ttyUSB7"
    with qtbot.waitSignal(parts.station.failed, timeout=WAIT) as told:
        click(qtbot, page.go)
    assert "/dev/ttyUSB7" in told.args[0]
    assert "/dev/ttyUSB7" in page.told.text()


def test_the_list_follows_what_is_plugged_in(page, qtbot, monkeypatch):
    monkeypatch.setattr(port_list, "EVERY", 10)
    page.ways["port"].setChecked(True)
    listed = page.ports.list
    qtbot.waitUntil(lambda: listed.topLevelItemCount() == 2, timeout=WAIT)
    page.ports.choose("/dev/ttyUSB7")
    monkeypatch.setattr(port_rows, "port_rows", lambda _connected: ())
    page.ports.look()
    qtbot.waitUntil(lambda: listed.topLevelItemCount() == 0, timeout=WAIT)
    assert page.ports.told.isVisible()
    monkeypatch.setattr(port_rows, "port_rows", lambda _connected: PORTS)
    page.ports.look()
    qtbot.waitUntil(lambda: listed.topLevelItemCount() == 2, timeout=WAIT)
    assert listed.currentItem().text(0) == "/dev/ttyUSB7"  # what was chosen is chosen still


def test_without_a_port_or_an_address_it_is_asked_for(page, parts, qtbot):
    for way, word in (("port", "choose a port"), ("socket", "type the address")):
        page.ways[way].setChecked(True)
        click(qtbot, page.go)
        assert word in page.told.text()
        assert not parts.station.active


def test_a_socket_is_connected_to_by_keys_alone(page, parts, qtbot):
    with serve_tcp(VirtualRibbon(SMALL)) as port:
        qtbot.keyClick(page.ways["socket"], Qt.Key.Key_Space)
        assert page.ways["socket"].isChecked()
        page.address.setFocus()
        qtbot.keyClicks(page.address, port.url.removeprefix("socket://"))
        qtbot.keyClick(page.address, Qt.Key.Key_Return)
        streaming(qtbot, parts)
        assert parts.station.virtual is None
        parts.station.end()


def test_what_the_ribbon_says_is_shown_as_plain_text(page, parts, qtbot):
    stream(qtbot, parts)
    assert not page.said.isVisible()
    parts.station.virtual.do("message <b>low</b> battery")
    qtbot.waitUntil(page.said.isVisible, timeout=WAIT)
    assert page.said.text().endswith(": <b>low</b> battery")
    assert page.said.textFormat() == Qt.TextFormat.PlainText


def test_a_wrong_baud_rate_is_no_fault(page):
    page.baudrate.setEditText("")
    assert page.choice().baudrate == 921600
    page.baudrate.setEditText("115200")
    assert page.choice().baudrate == 115200


def test_what_was_connected_last_is_connected_without_the_page(parts, qtbot):
    world = VirtualRibbon(SMALL)
    with serve_pty(world) as port:
        keep_choice(parts.settings, Choice("port", port.url))
        connect_last(parts)
        streaming(qtbot, parts)
        assert parts.station.url == port.url
        connect_virtual(parts)
        qtbot.waitUntil(lambda: parts.station.virtual is not None, timeout=WAIT)
        assert kept_choice(parts.settings).kind == "virtual"
        parts.station.end()


def test_everything_is_reached_by_tab_and_named(page):
    focus = [
        one
        for one in page.findChildren(QWidget)
        if one.focusPolicy() & Qt.FocusPolicy.TabFocus and one.isVisible()
    ]
    seen, one = set(), page.ways["virtual"]
    for _ in range(200):
        one = one.nextInFocusChain()
        seen.add(one)
    assert set(focus) <= seen
    for view in (page.raw.table, page.raw.drawing, page.ports.list):
        assert view.accessibleName()


# --- the raw view ---


@pytest.fixture
def raw(page, parts, qtbot):
    """The raw view of a small ribbon that streams."""
    stream(qtbot, parts)
    view = page.raw
    qtbot.waitUntil(lambda: view.table.sensors.state is not None, timeout=WAIT)
    return view


def test_every_sensor_is_in_the_table_with_its_newest_values(raw, parts, qtbot):
    model = raw.table.sensors
    assert model.rowCount() == 8
    assert model.text(0, NAME) == "A01"
    assert model.text(0, PLACE) == "15.0 mm"
    assert model.text(0, STATE) == "ok"
    assert model.text(1, X + 2) == ""  # a magnetometer of two axes has no z
    before = model.state
    qtbot.waitUntil(lambda: model.state is not before, timeout=WAIT)
    parts.station.virtual.do("dead A02")
    qtbot.waitUntil(lambda: model.text(2, STATE) == "stuck", timeout=WAIT)
    assert model.text(2, X) == "+0.000"


def test_a_click_on_the_drawing_says_where_the_sensor_sits(raw, parts, qtbot):
    qtbot.mouseClick(raw.drawing, LEFT, pos=raw.drawing.place(3).toPoint() + QPoint(2, 1))
    assert raw.chosen == 3
    assert raw.where.text().startswith("M02: magnetometer, 105.0 mm")
    assert raw.table.currentIndex().row() == 3
    assert raw.drawing.accessibleDescription() == raw.where.text()
    parts.units.use("in")
    assert "4.134 in" in raw.where.text()


def test_a_click_on_nothing_chooses_nothing(raw, qtbot):
    raw.choose(2)
    qtbot.mouseClick(raw.drawing, LEFT, pos=QPoint(raw.drawing.width() // 2, 2))
    assert raw.chosen == 2


def test_a_row_of_the_table_is_chosen_in_the_drawing(raw, qtbot):
    index = raw.table.model().index(4, 0)
    where = raw.table.visualRect(index).center()
    qtbot.mouseClick(raw.table.viewport(), LEFT, pos=where)
    assert raw.drawing.current == 4
    qtbot.keyClick(raw.table, Qt.Key.Key_Down)
    assert raw.drawing.current == 5


def test_the_keys_go_along_the_ribbon(raw, qtbot):
    drawing = raw.drawing
    drawing.setFocus()
    for key, expected in (
        (Qt.Key.Key_End, 7),
        (Qt.Key.Key_Right, 7),
        (Qt.Key.Key_Left, 6),
        (Qt.Key.Key_Home, 0),
        (Qt.Key.Key_Left, 0),
        (Qt.Key.Key_Right, 1),
    ):
        qtbot.keyClick(drawing, key)
        assert raw.chosen == expected


def test_a_magnet_at_a_sensor_makes_it_flash(raw, parts, qtbot):
    parts.station.virtual.do("lay P1")
    place = parts.station.identity.ribbon.sensors[5].position
    readings = raw._readings
    qtbot.waitUntil(lambda: readings.values(5, 0.6)[0].size > 40, timeout=WAIT)
    qtbot.waitUntil(lambda: raw.table.sensors.state.noise.max() < 0.02, timeout=WAIT)
    parts.station.virtual.do(f"magnet 1 {place} 0.01")
    qtbot.waitUntil(lambda: raw.drawing.flashing == {5}, timeout=WAIT)
    assert raw.table.sensors.text(5, STATE) == "tapped"
    qtbot.waitUntil(lambda: not raw.drawing.flashing, timeout=WAIT)


def test_the_plot_shows_the_chosen_sensor(raw, qtbot):
    qtbot.waitUntil(lambda: raw.plot is not None, timeout=WAIT)
    raw.choose(1)
    assert "M01x" in raw.plot.told.text()
    assert "M01z" not in raw.plot.told.text()
    qtbot.waitUntil(lambda: len(raw.plot.lines[0].getData()[0]) > 5, timeout=WAIT)
    assert raw.plot.lines[0].getData()[0][-1] == 0.0
    raw.choose(0)
    assert "A01z" in raw.plot.told.text()


def test_nothing_runs_while_it_is_not_seen(raw, page, qtbot):
    page.hide()
    assert not raw._timer.isActive()
    page.show()
    qtbot.waitUntil(raw._timer.isActive, timeout=WAIT)


def test_when_no_frames_come_that_is_told(raw, parts, qtbot):
    assert "flashes" in raw.hint.text()
    parts.station.virtual.do("unplug")
    qtbot.waitUntil(lambda: "last values" in raw.hint.text(), timeout=WAIT)
    parts.station.virtual.do("replug")
    qtbot.waitUntil(lambda: "flashes" in raw.hint.text(), timeout=WAIT)
    parts.station.disconnect()
    assert "last values" in raw.hint.text()
    assert raw.table.sensors.rowCount() == 8  # to be looked at


def test_it_is_painted_in_both_themes(raw, page, qtbot):
    raw.choose(1)
    pictures = []
    for theme in ("light", "dark"):
        apply_theme(QApplication.instance(), theme)
        qtbot.waitUntil(lambda: theme_of(page.palette()) == theme, timeout=WAIT)  # noqa: B023
        pictures.append(page.grab().toImage())
    assert pictures[0] != pictures[1]
    apply_theme(QApplication.instance(), "light")
