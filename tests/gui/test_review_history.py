"""Looking through a session: passes, notes, events, and the calibration that is used."""

import shutil

import pytest
from PySide6.QtCore import Qt

from georibbon.calibration import calibrate
from georibbon.gui.review import calibration_choice
from georibbon.gui.review.calibration_choice import CalibrationChoice
from georibbon.gui.review.history_panel import HistoryPanel
from georibbon.gui.theme import palette
from georibbon.session.calibration_file import write_calibration
from georibbon.session.calibration_shelf import Shelf
from georibbon.session.folder import read_recording
from georibbon.session.session import Session


@pytest.fixture(autouse=True)
def shelf(tmp_path, monkeypatch):
    """A folder of kept calibrations of its own."""
    folder = tmp_path / "calibrations"
    monkeypatch.setattr(CalibrationChoice, "kept_folder", classmethod(lambda _: folder))
    return Shelf(folder)


@pytest.fixture(scope="module")
def other(small_capture):
    recording = read_recording(small_capture)
    return calibrate(recording.ribbon, recording.poses[:1] + recording.poses[2:])


def opened(parts, path, qtbot):
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.open(path)


@pytest.fixture
def panel(parts, session, qtbot):
    made = HistoryPanel(parts)
    qtbot.addWidget(made)
    made.resize(460, 800)
    with qtbot.waitExposed(made):
        made.show()
    opened(parts, session, qtbot)
    qtbot.waitUntil(lambda: "frames in" in made.readings.text(), timeout=20_000)
    return made


def lines(panel):
    """(what, which) of the events that are shown."""
    items = [panel.events.topLevelItem(k) for k in range(panel.events.topLevelItemCount())]
    return [(item.text(1), item.text(2)) for item in items]


def chosen(box, data, qtbot):
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    for _ in range(box.findData(data)):
        qtbot.keyClick(box, Qt.Key.Key_Down)
    assert box.currentData() == data


def test_passes_are_stepped_through(panel, qtbot):
    seen = []
    panel.pass_chosen.connect(seen.append)
    assert panel.chosen == "P1"
    assert not panel.previous.isEnabled()
    qtbot.mouseClick(panel.next, Qt.MouseButton.LeftButton)
    qtbot.mouseClick(panel.next, Qt.MouseButton.LeftButton)
    assert (panel.chosen, panel.passes.currentText()) == ("P3", "P3")
    assert not panel.next.isEnabled()
    panel.step(1)  # there is none further on
    panel.step(-1)
    assert seen == ["P2", "P3", "P2"]


def test_a_pass_is_shown_with_its_quality_and_readings(panel, parts):
    fitted = parts.document.reconstruction.passes[0]
    assert panel.verdict.text() == "✔ good"
    assert panel.reason.text() == fitted.quality.reason
    assert panel.length.text() == "600.0 mm"
    assert f"{fitted.residual_rms:.2f}" in panel.residuals.text()
    assert panel.readings.text().startswith("40 frames in 0.4 s")
    assert panel.left_out.text() == "no sensor"
    assert panel.notes.text() == "none"
    parts.units.use("in")
    assert panel.length.text() == "23.622 in"


def test_events_are_listed_and_filtered(panel, parts, qtbot):
    parts.document.set_smoothing("P2", 0.09)
    parts.document.undo()
    everything = lines(panel)
    assert ("Captured", "pass P1") in everything
    assert ("Changed", "the smoothing of pass P2 – taken back") in everything
    assert everything[-1] == ("Changed", "took back the smoothing of pass P2")
    chosen(panel.filter, "capture", qtbot)
    assert {what for what, _ in lines(panel)} == {"Captured"}
    chosen(panel.filter, "pass", qtbot)
    assert lines(panel) == [("Captured", "pass P1")]
    panel.step(1)
    assert lines(panel) == [
        ("Captured", "pass P2"), ("Changed", "the smoothing of pass P2 – taken back"),
    ]  # fmt: skip
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.reconstruct()


def test_an_event_of_a_pass_leads_to_it(panel, qtbot):
    chosen(panel.filter, "capture", qtbot)
    last = panel.events.topLevelItem(panel.events.topLevelItemCount() - 1)
    assert last.text(2) == "pass P3"
    panel.events.setCurrentItem(last)
    panel.events.setFocus()
    qtbot.keyClick(panel.events, Qt.Key.Key_Return)
    assert panel.chosen == "P3"


def test_notes_are_written_shown_kept_and_undone(panel, parts, session, qtbot):
    panel.write_note()
    assert not panel.add.isEnabled()
    qtbot.keyClicks(panel.note, "the cable crossed")
    qtbot.keyClick(panel.note, Qt.Key.Key_Return)
    assert panel.note.text() == ""
    panel.step(1)
    assert panel.note_of.currentData() == "P2"
    qtbot.keyClicks(panel.note, "laid again")
    qtbot.mouseClick(panel.add, Qt.MouseButton.LeftButton)
    assert panel.notes.text() == "• laid again"
    chosen(panel.filter, "note", qtbot)
    assert lines(panel) == [("Note", "the cable crossed"), ("Note", "laid again (P2)")]
    assert parts.document.undoable == 'the note "laid again"'
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.undo()
    assert panel.notes.text() == "none"
    assert lines(panel)[1] == ("Note", "laid again (P2) – taken back")
    assert parts.document.close()
    with Session.open(session, read_only=True) as kept:
        assert [(one.text, one.pass_name) for one in kept.state.notes] == [
            ("the cable crossed", None)
        ]


def test_where_no_note_can_be_kept_it_says_why(panel, parts, small_capture, session, qtbot):
    opened(parts, small_capture, qtbot)
    assert not panel.note.isEnabled()
    assert "import it" in panel.told.text()
    assert lines(panel) == []
    assert not parts.document.note("x")
    with Session.open(session):
        opened(parts, session, qtbot)
        assert not panel.note.isEnabled()
        assert "only be read" in panel.told.text()
        assert lines(panel)


def test_nothing_is_shown_of_what_was_closed(panel, parts):
    parts.document.close()
    assert panel.passes.count() == 0
    assert panel.verdict.text() == panel.readings.text() == ""
    assert lines(panel) == []
    assert panel.chosen is None
    assert panel.told.text() == ""


def test_a_removed_pass_is_no_longer_looked_at(panel, parts, qtbot):
    panel.choose("P3")
    parts.document.session.do("remove", **{"pass": "P3"})
    parts.document.captured()
    assert panel.chosen == "P1"
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.reconstruct()


def test_it_follows_the_theme(panel):
    before = panel.verdict.styleSheet()
    panel.setPalette(palette("dark"))
    assert panel.verdict.styleSheet() not in ("", before)
    assert panel.verdict.text() == "✔ good"


# The calibration


def entries(choice):
    return [choice.itemText(k) for k in range(choice.count())]


def test_the_poses_are_used_at_first(panel):
    box = panel.calibration.choice
    assert entries(box) == ["From the poses in the session", "From a file…"]
    assert box.currentText() == "From the poses in the session"
    assert "Of 16 poses" in panel.calibration.told.text()


def test_a_kept_one_is_chosen_used_and_undone(panel, parts, session, shelf, other, qtbot):
    shelf.keep(other, "Monday")
    opened(parts, session, qtbot)
    box = panel.calibration.choice
    qtbot.waitUntil(lambda: box.count() == 3, timeout=20_000)
    assert entries(box)[1].startswith("Monday, ")
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        box.setCurrentIndex(1)
        box.activated.emit(1)
    assert box.currentText() == "Monday"
    assert "Of 15 poses" in panel.calibration.told.text()
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.undo()
    assert box.currentText() == "From the poses in the session"
    assert "Of 16 poses" in panel.calibration.told.text()
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.redo()
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        box.activated.emit(0)
    assert parts.document.calibration is None


def test_one_from_a_file_is_used(panel, parts, other, tmp_path, qtbot, monkeypatch):
    path = tmp_path / "other.json"
    write_calibration(other, path)
    monkeypatch.setattr(CalibrationChoice, "ask_file", lambda *_: path)
    box = panel.calibration.choice
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        box.activated.emit(box.count() - 1)
    assert box.currentText() == "Another one, kept in the session"
    assert "Of 15 poses" in panel.calibration.told.text()


@pytest.mark.parametrize("kind", ["no calibration", "thought better"])
def test_a_file_that_is_none_is_refused_beside(panel, parts, tmp_path, qtbot, monkeypatch, kind):
    path = tmp_path / "other.json"
    path.write_text("{")
    given = path if kind == "no calibration" else None
    monkeypatch.setattr(CalibrationChoice, "ask_file", lambda *_: given)
    panel.calibration.ask()
    if given is not None:
        qtbot.waitUntil(lambda: "other.json" in panel.calibration.told.text())
        assert panel.calibration.told.text().startswith("✖")
    assert panel.calibration.choice.currentText() == "From the poses in the session"
    assert parts.document.calibration is None


def test_those_of_other_ribbons_are_not_offered(panel, parts, session, shelf, other, qtbot):
    from dataclasses import replace

    shelf.keep(replace(other, ribbon_id="GR-9999"), "strange")
    shelf.keep(other, "fitting")
    copy = session.with_name("copy.georibbon")
    parts.document.close()
    shutil.copy(session, copy)
    opened(parts, copy, qtbot)
    box = panel.calibration.choice
    qtbot.waitUntil(lambda: box.count() == 3, timeout=20_000)
    assert entries(box)[1].startswith("fitting, ")


def test_a_file_is_asked_for(panel, tmp_path, monkeypatch):
    found = [(str(tmp_path / "a.json"), ""), ("", "")]
    monkeypatch.setattr(calibration_choice.QFileDialog, "getOpenFileName", lambda *_: found.pop(0))
    assert CalibrationChoice.ask_file(panel, tmp_path) == tmp_path / "a.json"
    assert CalibrationChoice.ask_file(panel, tmp_path) is None
