"""Two surfaces side by side: what is measured, what is shown, and that nothing is written."""

from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from georibbon.export.mesh import write_mesh
from georibbon.gui.review import compare_window
from georibbon.gui.review.compare_window import CompareWindow
from georibbon.session.mesh_file import read_triangles
from georibbon.session.session import Session


@pytest.fixture
def window(parts, session, qtbot):
    with qtbot.waitSignal(parts.document.reconstructed, timeout=20_000):
        parts.document.open(session)
    made = CompareWindow(parts)  # it deletes itself when it is closed
    with qtbot.waitExposed(made):
        made.show()
    return made


@pytest.fixture
def mesh_file(window, tmp_path):
    path = tmp_path / "part.stl"
    write_mesh(window._parts.document.reconstruction.surface.mesh, path, "mm")
    return path


def told(window, qtbot, words):
    qtbot.waitUntil(lambda: words in window.figures.text(), timeout=20_000)


def test_a_session_is_compared_with_a_recording_and_nothing_is_written(
    window, parts, small_capture, qtbot
):
    before = {path: path.stat().st_mtime_ns for path in small_capture.iterdir()}
    window.compare_with(small_capture)
    assert window.progress.isVisible()
    told(window, qtbot, "rms 0.00 mm")
    assert "100.0 % is covered" in window.figures.text()
    assert window.second_name.text() == "dome"
    assert window.first_name.text() == "dome.georibbon"
    assert window.first.colouring == "deviation"
    rows = [window.table.topLevelItem(k) for k in range(window.table.topLevelItemCount())]
    assert [row.text(0) for row in rows] == ["P1", "P2", "P3"]
    assert all(row.text(1) == row.text(4) == "✔ good" for row in rows)
    assert all(row.text(2) == row.text(5) for row in rows)
    assert not window.progress.isVisible()
    assert {path: path.stat().st_mtime_ns for path in small_capture.iterdir()} == before
    assert parts.document.undoable is None


def test_a_mesh_file_in_another_unit_is_read_anew(window, mesh_file, qtbot):
    assert not window.unit.isVisible()
    window.compare_with(mesh_file)
    told(window, qtbot, "rms 0.00 mm")
    assert window.unit.isVisible()
    assert window.second.colouring == "plain"
    assert window.table.topLevelItem(0).text(4) == "–"
    window.unit.setFocus()
    qtbot.keyClick(window.unit, Qt.Key.Key_Down)
    assert window.unit.currentText() == "cm"
    qtbot.waitUntil(
        lambda: bool(window.figures.text()) and "rms 0.00 mm" not in window.figures.text(),
        timeout=20_000,
    )


def test_laid_on_first_is_told_and_taken_back(window, mesh_file, parts, tmp_path, qtbot):
    mesh = read_triangles(mesh_file, "mm", ValueError)
    path = tmp_path / "moved.ply"
    whole = parts.document.reconstruction.surface.mesh
    up = SimpleNamespace(
        vertices=mesh.vertices + np.array([0.0, 0.0, 0.004]), triangles=mesh.triangles,
        normals=np.zeros_like(mesh.vertices), sigma=None,
    )  # fmt: skip
    assert len(whole.vertices) == len(up.vertices)
    write_mesh(up, path, "mm")
    window.compare_with(path)
    told(window, qtbot, "mean -")
    assert "Laid on first" not in window.figures.text()
    qtbot.mouseClick(window.aligned, Qt.MouseButton.LeftButton)
    told(window, qtbot, "Laid on first")
    assert "rms 0.0" in window.figures.text()
    qtbot.mouseClick(window.aligned, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "Laid on first" not in window.figures.text(), timeout=20_000)


def test_another_tolerance_is_counted_at_once(window, small_capture, qtbot):
    window.compare_with(small_capture)
    told(window, qtbot, "within 0.50 mm")
    qtbot.keyClick(window.tolerance, Qt.Key.Key_Up)
    assert "within 0.60 mm" in window.figures.text()


def test_lengths_follow_the_unit(window, small_capture, parts, qtbot):
    window.compare_with(small_capture)
    told(window, qtbot, "rms 0.00 mm")
    parts.units.use("in")
    assert "rms 0.0000 in" in window.figures.text()
    assert "1σ, in" in window.table.headerItem().text(2)


def test_colours_are_the_same_in_both_where_they_are_uncertainties(window, small_capture, qtbot):
    window.compare_with(small_capture)
    told(window, qtbot, "rms")
    qtbot.mouseClick(window.by_uncertainty, Qt.MouseButton.LeftButton)
    assert window.first.colouring == window.second.colouring == "uncertainty"
    assert window.first.fixed_range == window.second.fixed_range
    assert window.first.fixed_range is not None
    qtbot.mouseClick(window.by_deviation, Qt.MouseButton.LeftButton)
    assert window.first.colouring == "deviation"


def camera(view):
    return view._stage.scene.renderer.GetActiveCamera().GetPosition()


def test_the_views_turn_together_or_each_by_itself(window, small_capture, qtbot):
    window.compare_with(small_capture)
    told(window, qtbot, "rms")
    qtbot.keyClick(window.first, Qt.Key.Key_Left)
    assert camera(window.second) == pytest.approx(camera(window.first))
    qtbot.keyClick(window.second, Qt.Key.Key_Up)
    assert camera(window.first) == pytest.approx(camera(window.second))
    qtbot.mouseClick(window.linked, Qt.MouseButton.LeftButton)
    qtbot.keyClick(window.first, Qt.Key.Key_Left)
    assert camera(window.second) != pytest.approx(camera(window.first))


def test_what_cannot_be_read_is_told_beside(window, tmp_path, small_capture, qtbot):
    window.compare_with(small_capture)
    told(window, qtbot, "rms")
    (tmp_path / "bad.stl").write_bytes(b"no")
    window.compare_with(tmp_path / "bad.stl")
    qtbot.waitUntil(lambda: "bad.stl" in window.told.text() and "✖" in window.told.text())
    assert window.figures.text() == ""
    assert window.table.topLevelItemCount() == 0
    assert window.second_name.text() == ""


def test_without_a_place_in_common_it_says_so(window, parts, tmp_path, qtbot):
    whole = parts.document.reconstruction.surface.mesh
    far = SimpleNamespace(
        vertices=whole.vertices + 9.0, triangles=whole.triangles, normals=whole.normals, sigma=None
    )
    write_mesh(far, tmp_path / "far.stl", "mm")
    window.compare_with(tmp_path / "far.stl")
    told(window, qtbot, "no place in common")


def test_a_changed_setting_is_measured_anew(window, small_capture, parts, qtbot):
    window.compare_with(small_capture)
    told(window, qtbot, "rms 0.00 mm")
    parts.document.set_smoothing("*", 0.04)
    qtbot.waitUntil(
        lambda: bool(window.figures.text()) and "rms 0.00 mm" not in window.figures.text(),
        timeout=20_000,
    )


@pytest.mark.parametrize("which", ["session", "folder", "mesh"])
def test_every_way_to_choose_leads_there(
    window, session, small_capture, mesh_file, which, qtbot, monkeypatch
):
    paths = {"session": session, "folder": small_capture, "mesh": mesh_file}
    asked = []
    monkeypatch.setattr(
        CompareWindow, f"ask_{which}", lambda *words: asked.append(words) or paths[which]
    )
    at = ["session", "folder", "mesh"].index(which)
    window.choose.menu().actions()[at].trigger()
    told(window, qtbot, "rms 0.00 mm")
    assert asked
    monkeypatch.setattr(CompareWindow, f"ask_{which}", lambda *_: None)
    window.choose.menu().actions()[at].trigger()
    assert window.figures.text()


def test_it_closes_with_what_it_is_of(window, parts, qtbot):
    parts.document.close()
    qtbot.waitUntil(lambda: not window.isVisible())


def test_files_are_asked_for_where_what_is_open_lies(window, tmp_path, monkeypatch):
    asked = []

    def ask(_parent, _title, folder, *_filters):
        asked.append(folder)
        return (str(tmp_path / "part.stl"), "") if len(asked) == 1 else ("", "")

    monkeypatch.setattr(compare_window.QFileDialog, "getOpenFileName", ask)
    assert CompareWindow.ask_mesh(window, tmp_path) == tmp_path / "part.stl"
    assert CompareWindow.ask_mesh(window, tmp_path) is None
    assert CompareWindow.ask_session(window, tmp_path) is None
    monkeypatch.setattr(compare_window.QFileDialog, "getExistingDirectory", lambda *_: "")
    assert CompareWindow.ask_folder(window, tmp_path) is None
    assert asked == [str(tmp_path)] * 3


def test_without_a_surface_nothing_is_measured_and_it_says_so(
    window, parts, session, small_capture, qtbot
):
    window.close()
    parts.document.close()
    with Session.open(session) as changing:
        for name in ("P2", "P3"):
            changing.do("remove", **{"pass": name})
    with qtbot.waitSignal(parts.document.failed, timeout=20_000):
        parts.document.open(session)
    made = CompareWindow(parts)
    made.show()
    made.compare_with(small_capture)
    qtbot.waitUntil(lambda: "no surface yet" in made.told.text(), timeout=20_000)
    assert made.figures.text() == ""


def test_everything_has_a_name(window):
    for part in (window.first, window.second, window.table, window.progress):
        assert part.accessibleName()
    buddies = [one.buddy() for one in window.findChildren(QLabel) if one.buddy() is not None]
    assert {window.unit, window.tolerance} <= set(buddies)
