"""The export dialog: what will be written is seen, and is what is written."""

import importlib.util

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialogButtonBox

from georibbon.errors import GeoribbonError
from georibbon.export import choice as choices
from georibbon.gui import dialogs
from georibbon.gui.review.export_dialog import FORMATS, KINDS, SPLINES, ExportDialog
from georibbon.gui.review.worker import Worker
from georibbon.session.folder import read_recording
from georibbon.session.session import Session


@pytest.fixture
def opened(parts, session, qtbot):
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.open(session)
    return parts


def shown(parts, qtbot, kind="surface"):
    dialog = ExportDialog(parts, kind=kind)
    qtbot.addWidget(dialog)
    with qtbot.waitExposed(dialog):
        dialog.show()
    return dialog


def chosen(box, data, qtbot):
    """Choose an entry of a box with the keys."""
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    for _ in range(box.findData(data)):
        qtbot.keyClick(box, Qt.Key.Key_Down)
    assert box.currentData() == data


def write(dialog, qtbot):
    with qtbot.waitSignal(dialog.written, timeout=30_000) as done:
        qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
    return done.args[0]


def seen(dialog, qtbot, words):
    qtbot.waitUntil(lambda: words in dialog.preview.facts.text(), timeout=20_000)


def test_what_is_seen_is_what_is_written(opened, qtbot, tmp_path):
    dialog = shown(opened, qtbot)
    seen(dialog, qtbot, "an open skin")
    count = len(opened.document.reconstruction.surface.mesh.triangles)
    assert f"{count}" in dialog.preview.facts.text().replace(",", "").replace(".", "")
    path = write(dialog, qtbot)
    assert path == tmp_path / "dome.stl"
    assert path.stat().st_size == 84 + 50 * count
    assert "Written: " in dialog.told.text()
    assert dialog.told.text().startswith("✔")


def test_a_solid_is_closed_in_the_picture_and_in_the_file(opened, qtbot, tmp_path):
    dialog = shown(opened, qtbot)
    qtbot.mouseClick(dialog.solid, Qt.MouseButton.LeftButton)
    seen(dialog, qtbot, "closed (watertight)")
    chosen(dialog.unit, "in", qtbot)
    chosen(dialog.format, ".ply", qtbot)
    path = write(dialog, qtbot)
    assert path == tmp_path / "dome.ply"
    assert b"unit: in" in path.read_bytes()[:300]
    assert dialog.chosen.settings.thickness == pytest.approx(2e-3)


@pytest.mark.parametrize(("ending", "begin"), [(".step", b"ISO-10303-21;"), (".iges", b" " * 70)])
def test_a_spline_for_cad_programs_is_written_and_told(opened, qtbot, tmp_path, ending, begin):
    dialog = shown(opened, qtbot)
    qtbot.mouseClick(dialog.solid, Qt.MouseButton.LeftButton)
    assert dialog.thickness.isEnabled()
    chosen(dialog.format, ending, qtbot)
    assert not dialog.solid.isEnabled()
    assert not dialog.thickness.isEnabled()
    assert dialog.chosen.settings.thickness is None
    seen(dialog, qtbot, "an open skin")
    path = write(dialog, qtbot)
    assert path == tmp_path / f"dome{ending}"
    assert path.read_bytes().startswith(begin)
    assert "control points, read back" in dialog.told.text()
    assert "one spline within 0.0" in dialog.told.text()
    chosen(dialog.format, ".stl", qtbot)
    assert dialog.thickness.isEnabled()  # the solid is still asked for
    assert dialog.chosen.settings.thickness == pytest.approx(2e-3)


def test_the_shorter_endings_are_of_the_same_formats(opened, qtbot, tmp_path, monkeypatch):
    dialog = shown(opened, qtbot)
    for name, ending in (("a.stp", ".step"), ("b.igs", ".iges")):
        monkeypatch.setattr(dialogs, "ask_target", lambda *_, name=name: tmp_path / name)
        qtbot.mouseClick(dialog.browse, Qt.MouseButton.LeftButton)
        assert dialog.format.currentData() == ending
        assert dialog.chosen.path == tmp_path / name
        assert not dialog.solid.isEnabled()


def test_without_the_kernel_its_formats_cannot_be_chosen_and_tell_why(
    opened, qtbot, tmp_path, monkeypatch
):
    real = importlib.util.find_spec
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name, *more: None if name == "OCP" else real(name, *more)
    )
    dialog = shown(opened, qtbot)
    for ending in SPLINES:
        at = dialog.format.findData(ending)
        assert not dialog.format.model().item(at).isEnabled()
        reason = dialog.format.itemData(at, Qt.ItemDataRole.ToolTipRole)
        assert "need the CAD kernel, which is not installed: run" in reason
    dialog.place.setText(str(tmp_path / "typed.step"))
    qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "need the CAD kernel" in dialog.told.text(), timeout=20_000)
    assert list(tmp_path.glob("*.step")) == []


def test_another_tolerance_is_drawn_anew(opened, qtbot):
    dialog = shown(opened, qtbot)
    seen(dialog, qtbot, "triangles")
    before = dialog.preview.facts.text()
    for _ in range(4):
        qtbot.keyClick(dialog.tolerance, Qt.Key.Key_Down)
    assert dialog.chosen.settings.tolerance == pytest.approx(1e-5)
    qtbot.waitUntil(lambda: dialog.preview.facts.text() != before, timeout=20_000)


def test_what_cannot_be_made_is_told_beside_and_nothing_is_written(opened, qtbot, monkeypatch):
    def folded(_result, _settings):
        raise GeoribbonError("a wall 90 mm thick folds over itself")

    monkeypatch.setattr(choices, "surface_with", folded)
    dialog = shown(opened, qtbot)
    qtbot.waitUntil(lambda: "folds over itself" in dialog.told.text(), timeout=20_000)
    assert dialog.told.text().startswith("✖")
    assert dialog.preview.facts.text() == ""
    qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(dialog.write.isEnabled, timeout=20_000)
    assert "folds over itself" in dialog.told.text()
    monkeypatch.undo()
    qtbot.mouseClick(dialog.solid, Qt.MouseButton.LeftButton)
    seen(dialog, qtbot, "closed (watertight)")
    assert "folds" not in dialog.told.text()


@pytest.mark.parametrize("kind", ["curves", "report", "recording"])
def test_the_other_kinds_are_written_too(opened, qtbot, tmp_path, small_capture, kind):
    dialog = shown(opened, qtbot)
    chosen(dialog.kind, kind, qtbot)
    assert dialog.explained.text()
    assert not dialog.unit.isVisible()
    if kind == "report":
        chosen(dialog.format, ".json", qtbot)
    path = write(dialog, qtbot)
    names = {"curves": "dome.csv", "report": "dome.json", "recording": "dome-recording"}
    assert path == tmp_path / names[kind]
    if kind == "recording":
        assert len(read_recording(path).passes) == len(read_recording(small_capture).passes)
    else:
        assert path.stat().st_size > 100


def test_what_is_there_is_told_before_it_is_replaced(opened, qtbot, tmp_path):
    (tmp_path / "dome.stl").write_text("mine")
    dialog = shown(opened, qtbot)
    assert "dome.stl is there already" in dialog.told.text()
    assert dialog.write.text() == "&Replace"
    dialog.place.selectAll()
    qtbot.keyClicks(dialog.place, str(tmp_path / "other.stl"))
    assert dialog.write.text() == "W&rite"
    assert "already" not in dialog.told.text()
    chosen(dialog.format, ".obj", qtbot)
    assert write(dialog, qtbot) == tmp_path / "other.obj"
    assert (tmp_path / "dome.stl").read_text() == "mine"


def test_a_place_is_chosen_and_gives_the_format(opened, qtbot, tmp_path, monkeypatch):
    asked = []

    def ask(_parent, proposal, title, filters):
        asked.append((proposal.name, title, filters))
        return tmp_path / "elsewhere.ply"

    monkeypatch.setattr(dialogs, "ask_target", ask)
    dialog = shown(opened, qtbot)
    qtbot.mouseClick(dialog.browse, Qt.MouseButton.LeftButton)
    assert asked == [
        (
            "dome.stl",
            "Export surface",
            "Surface, as a mesh or as one spline (*.stl *.obj *.ply *.step *.iges)",
        )
    ]
    assert dialog.format.currentData() == ".ply"
    assert dialog.chosen.path == tmp_path / "elsewhere.ply"
    monkeypatch.setattr(ExportDialog, "ask_place", lambda *_: None)
    qtbot.mouseClick(dialog.browse, Qt.MouseButton.LeftButton)
    assert dialog.chosen.path == tmp_path / "elsewhere.ply"


def test_errors_of_writing_stand_in_the_dialog(opened, qtbot, tmp_path):
    dialog = shown(opened, qtbot)
    for text, told in (
        ("", "into which file"),
        (str(tmp_path / "no" / "a.stl"), "a.stl"),
        (str(tmp_path / "a.txt"), "expected .stl or .obj or .ply or .step"),
    ):
        dialog.place.setText(text)
        qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(
            lambda told=told: told in dialog.told.text() and dialog.write.isEnabled(),
            timeout=20_000,
        )
        assert dialog.told.text().startswith("✖")


def test_what_is_cancelled_leaves_nothing(opened, qtbot, tmp_path, monkeypatch):
    dialog = shown(opened, qtbot)
    whole = choices.write_surface

    def slowly(*words):
        while not dialog._cancelled:
            pass
        return whole(*words)

    monkeypatch.setattr(choices, "write_surface", slowly)
    qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
    assert dialog.progress.isVisible()
    assert not dialog.write.isEnabled()
    qtbot.mouseClick(dialog.stop, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "nothing was written" in dialog.told.text(), timeout=20_000)
    assert not list(tmp_path.glob("*.stl"))
    assert not list(tmp_path.glob(".georibbon-*"))
    assert dialog.write.isEnabled()


def test_what_gives_no_surface_is_refused_in_a_sentence(parts, session, qtbot):
    with Session.open(session) as changing:
        for name in ("P2", "P3"):
            changing.do("remove", **{"pass": name})
    with qtbot.waitSignal(parts.document.failed, timeout=20_000):
        parts.document.open(session)
    dialog = shown(parts, qtbot, "recording")
    for kind, told in (("recording", "at least 2 are needed"), ("curves", "no result to write")):
        dialog.choose_kind(kind)
        qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(lambda told=told: told in dialog.told.text(), timeout=20_000)
        qtbot.waitUntil(dialog.write.isEnabled, timeout=20_000)


def test_it_closes_with_what_it_is_of(opened, qtbot):
    dialog = shown(opened, qtbot)
    opened.document.close()
    qtbot.waitUntil(lambda: not dialog.isVisible())


def test_every_kind_has_its_words_and_every_field_its_label(opened, qtbot):
    assert set(KINDS) == set(FORMATS) == set(choices.KINDS)
    for kind, endings in FORMATS.items():
        others = {".stp", ".igs"} if kind == "surface" else set()
        assert set(endings) | others == set(choices.ENDINGS[kind])
    dialog = shown(opened, qtbot)
    for part in (dialog.kind, dialog.format, dialog.unit, dialog.tolerance):
        assert dialog.form.labelForField(part).text()
    assert dialog.thickness.accessibleName()
    assert dialog.preview.view.accessibleName()
    texts = [one.text() for one in dialog.findChild(QDialogButtonBox).buttons()]
    keys = [text[text.index("&") + 1].lower() for text in texts]
    assert len(set(keys)) == len(keys)


# The worker


@pytest.fixture
def worker(qapp):
    made = Worker(qapp)
    yield made
    made.end()
    made.deleteLater()


def test_of_what_waits_the_newest_alone_is_done(worker, qtbot):
    done = []
    worker.done.connect(done.append)
    for k in range(5):
        worker.ask(lambda k=k: k)
    qtbot.waitUntil(lambda: not worker.is_busy)
    assert done == [0, 4]


def test_errors_come_in_a_sentence_and_faults_as_they_are(worker, qtbot):
    def refuse():
        raise GeoribbonError("no")

    def missing():
        open("/nowhere/at/all")  # noqa: SIM115, PTH123 - it is not there

    def fault():
        raise KeyError("x")

    for work, signal in ((refuse, worker.failed), (missing, worker.failed), (fault, worker.fault)):
        with qtbot.waitSignal(signal) as told:
            worker.ask(work)
        assert told.args[0]
    assert not worker.is_busy


def test_what_is_forgotten_is_not_delivered(worker, qtbot):
    done = []
    worker.done.connect(done.append)
    worker.ask(lambda: 1)
    worker.forget()
    with qtbot.waitSignal(worker.done):
        worker.ask(lambda: 2)
    assert done == [2]


@pytest.mark.parametrize(
    "name", ["~nobody-of-that-name/x.stl", "x" * 300 + ".stl", "/", "..", ".stl", "no/such/x.stl"]
)
def test_names_that_cannot_be_are_refused_in_words(opened, qtbot, name):
    dialog = shown(opened, qtbot)
    dialog.place.clear()
    qtbot.keyClicks(dialog.place, name)
    qtbot.mouseClick(dialog.write, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: dialog.told.text().startswith("✖"))
    for ending in FORMATS["surface"]:
        chosen(dialog.format, ending, qtbot)  # changes the name's ending, where there is a name


def test_a_name_alone_is_one_beside_what_is_open(opened, qtbot, session):
    dialog = shown(opened, qtbot)
    dialog.place.clear()
    qtbot.keyClicks(dialog.place, "alone.stl")
    assert write(dialog, qtbot) == session.parent / "alone.stl"


def test_without_a_name_another_format_proposes_one(opened, qtbot, session):
    dialog = shown(opened, qtbot)
    dialog.place.clear()
    qtbot.keyClicks(dialog.place, "x")
    qtbot.keyClick(dialog.place, Qt.Key.Key_Backspace)
    chosen(dialog.format, ".obj", qtbot)
    assert dialog.place.text() == str(session.with_suffix(".obj"))
