"""Surfaces compared, made anew and moved: for the page, for the window, for files."""

from dataclasses import replace

import numpy as np
import pytest

import synthetic
from georibbon import rotations
from georibbon.errors import ExportError, SurfaceError
from georibbon.export import choice as choices
from georibbon.export.choice import CancelledError, Choice, mesh_of, write
from georibbon.export.comparison import (
    Other,
    compare,
    comparison_data,
    is_mesh_file,
    other_of,
    pass_pairs,
    read_other,
    with_tolerance,
)
from georibbon.export.comparison_page import comparison_html
from georibbon.export.mesh import UNITS, write_mesh
from georibbon.export.surfaces import mesh_facts, moved, surface_with, with_mesh
from georibbon.geometry.alignment import Motion
from georibbon.geometry.mesh import area, is_watertight
from georibbon.geometry.settings import SurfaceSettings
from georibbon.session.folder import read_recording

RESULT = synthetic.reconstruction()
MOTION = Motion(rotations.exp(np.array([0.02, -0.01, 0.3])), np.array([0.1, 0.2, -0.05]))


def raised(result, height):
    """The result with its surface so much higher along z, metres."""
    mesh = result.surface.mesh
    up = replace(mesh, vertices=mesh.vertices + np.array([0.0, 0.0, height]))
    return replace(result, surface=replace(result.surface, mesh=up))


def test_a_raised_surface_deviates_by_its_rise_with_the_sign():
    found = compare(raised(RESULT, 1e-4), "up", other_of(RESULT, "down"), tolerance=2e-4)
    assert found.statistics.mean == pytest.approx(1e-4, rel=0.05)
    assert found.statistics.within == pytest.approx(1.0)
    other_way = compare(RESULT, "down", other_of(raised(RESULT, 1e-4), "up"))
    assert other_way.statistics.mean == pytest.approx(-1e-4, rel=0.05)


def test_alignment_takes_a_motion_back_and_tells_it():
    found = compare(moved(RESULT, MOTION), "moved", other_of(RESULT, "still"), aligned=True)
    assert found.statistics.rms < 1e-5
    assert found.motion.angle == pytest.approx(MOTION.angle, abs=1e-3)
    assert compare(moved(RESULT, MOTION), "moved", other_of(RESULT, "still")).motion is None


def test_another_tolerance_counts_anew_what_was_measured_already():
    found = compare(raised(RESULT, 1e-3), "up", other_of(RESULT, "down"), tolerance=5e-4)
    assert found.statistics.within < 0.1
    wider = with_tolerance(found, RESULT.surface.mesh, 2e-3)
    assert wider.statistics.within == pytest.approx(1.0)
    assert wider.statistics.rms == found.statistics.rms


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply"])
def test_a_surface_deviates_nowhere_from_its_own_file(tmp_path, unit, ending):
    path = tmp_path / f"part{ending}"
    write_mesh(RESULT.surface.mesh, path, unit)
    found = compare(RESULT, "part", read_other(path, unit))
    assert found.statistics.largest < 1e-6
    assert found.statistics.covered == pytest.approx(1.0)


def test_a_mesh_file_in_another_unit_has_nothing_in_common(tmp_path):
    write_mesh(RESULT.surface.mesh, tmp_path / "part.stl", "mm")
    far = Other("far", replace(RESULT.surface.mesh, vertices=RESULT.surface.mesh.vertices + 9.0))
    assert compare(RESULT, "part", far).statistics is None
    assert read_other(tmp_path / "part.stl", "m").mesh.vertices.max() > 100.0


@pytest.mark.parametrize(
    ("name", "data"),
    [("a.stl", b"solid nothing"), ("a.obj", b"v 0 0 0\n"), ("a.ply", b"ply\n"), ("a.stl", b"")],
)
def test_files_that_hold_no_mesh_are_refused_in_a_sentence(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ExportError, match=name):
        read_other(tmp_path / name)


def test_mesh_files_are_known_by_their_endings(tmp_path):
    (tmp_path / "folder.stl").mkdir()
    assert is_mesh_file(tmp_path / "a.STL")
    assert not is_mesh_file(tmp_path / "a.georibbon")
    assert not is_mesh_file(tmp_path / "folder.stl")


def test_a_recording_is_reconstructed_to_be_compared_with(small_capture):
    other = read_other(small_capture)
    assert other.name == "dome"
    assert [one.name for one in other.result.passes] == ["P1", "P2", "P3"]
    assert compare(other.result, "again", other).statistics.largest < 1e-12


def test_what_has_no_surface_is_refused():
    bare = synthetic.reconstruction(with_surface=False)
    for act in (lambda: other_of(bare, "bare"), lambda: surface_with(bare, SurfaceSettings())):
        with pytest.raises(ExportError, match="no surface"):
            act()


def test_passes_are_paired_by_their_names():
    fewer = replace(RESULT, passes=(*RESULT.passes[1:], replace(RESULT.passes[0], name="P9")))
    pairs = {pair.name: pair for pair in pass_pairs(RESULT, fewer)}
    assert list(pairs)[-1] == "P9"
    assert pairs["P1"].second is None
    assert pairs["P9"].first is None
    assert pairs["P2"].first.name == pairs["P2"].second.name == "P2"
    assert all(pair.second is None for pair in pass_pairs(RESULT, None))


def test_the_data_say_all_in_the_units_of_their_names():
    found = compare(raised(RESULT, 1e-3), "up", other_of(RESULT, "down"), aligned=True)
    data = comparison_data(found, RESULT)
    assert (data["first"], data["second"]) == ("up", "down")
    assert data["deviation"]["tolerance_mm"] == pytest.approx(0.5)
    assert data["deviation"]["rms_mm"] == pytest.approx(1e3 * found.statistics.rms, rel=1e-5)
    assert len(data["aligned"]["rotation"]) == 3
    assert data["passes"][0]["second"]["quality"] == "good"


def test_the_page_has_the_figures_and_escapes_names():
    found = compare(RESULT, "<b>one", other_of(RESULT, "two & more"))
    page = comparison_html(found, RESULT, comparison_data(found, RESULT))
    assert "&lt;b&gt;one from two &amp; more" in page
    assert "<b>one" not in page
    assert page.count("data:image/") == 2
    assert "Root mean square" in page


def test_the_page_tells_that_nothing_is_in_common():
    far = Other("far", replace(RESULT.surface.mesh, vertices=RESULT.surface.mesh.vertices + 9.0))
    found = compare(RESULT, "one", far)
    page = comparison_html(found, RESULT, comparison_data(found, RESULT))
    assert "no place in common" in page
    assert "data:image/" not in page


# What is made anew, and moved


@pytest.fixture(scope="module")
def dome(small_capture):
    return read_other(small_capture).result


def test_the_same_settings_give_the_same_surface(dome):
    again = surface_with(dome, SurfaceSettings())
    assert np.allclose(again.mesh.vertices, dome.surface.mesh.vertices, atol=1e-12)


def test_a_finer_tolerance_gives_more_triangles_and_a_thickness_a_closed_solid(dome):
    fine, solid = (
        mesh_of(Choice("surface", None, "mm", settings), dome)
        for settings in (SurfaceSettings(tolerance=5e-6), SurfaceSettings(thickness=2e-3))
    )
    assert len(fine.triangles) > len(dome.surface.mesh.triangles)
    assert is_watertight(solid)
    assert mesh_facts(solid).watertight
    assert not mesh_facts(fine).watertight
    assert mesh_facts(fine).area == pytest.approx(area(fine))
    assert max(mesh_facts(fine).size) == pytest.approx(0.6, abs=0.1)


def test_a_moved_result_keeps_its_shape():
    there = moved(RESULT, MOTION)
    assert area(there.surface.mesh) == pytest.approx(area(RESULT.surface.mesh))
    for one, other in zip(RESULT.passes, there.passes, strict=True):
        assert other.position_sigma == pytest.approx(one.position_sigma)
        assert MOTION.applied(one.strip.points) == pytest.approx(other.strip.points)
        steps = np.diff(other.strip.points, axis=0)
        along = np.sum(steps * other.strip.tangents[:-1], axis=1)
        assert (along > 0).all()
    bare = moved(synthetic.reconstruction(with_surface=False), MOTION)
    assert bare.surface is None


def test_a_mesh_can_stand_for_a_results_surface():
    shown = with_mesh(RESULT, RESULT.surface.mesh)
    assert shown.surface.area == pytest.approx(area(RESULT.surface.mesh))
    assert shown.survey == ()


# What is written


def written(tmp_path, name, kind, dome, small_capture, **words):
    path = tmp_path / name
    write(
        Choice(kind, path, **words), dome, lambda: read_recording(small_capture), "dome", "Dome",
        lambda: False,
    )  # fmt: skip
    return path


def test_every_kind_is_written(tmp_path, dome, small_capture):
    for name, kind in (("a.stl", "surface"), ("a.csv", "curves"), ("a.json", "report")):
        assert written(tmp_path, name, kind, dome, small_capture).stat().st_size > 100
    folder = written(tmp_path, "raw", "recording", None, small_capture)
    assert (folder / "recording.toml").is_file()
    assert {one.name for one in tmp_path.iterdir()} == {"a.stl", "a.csv", "a.json", "raw"}


@pytest.mark.parametrize(
    ("name", "kind"), [("a.stl", "surface"), ("a.json", "report"), ("raw", "recording")]
)
def test_what_is_cancelled_leaves_nothing(tmp_path, dome, small_capture, name, kind):
    with pytest.raises(CancelledError):
        write(
            Choice(kind, tmp_path / name), dome, lambda: read_recording(small_capture), "dome",
            None, lambda: True,
        )  # fmt: skip
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_written_is_refused_in_a_sentence_with_the_right_name(
    tmp_path, dome, small_capture, monkeypatch
):
    (tmp_path / "folder.stl").mkdir()
    for name, kind, what in (
        ("a.txt", "surface", "a.txt"),
        ("folder.stl", "surface", "is a folder"),
        ("no/a.csv", "curves", "a.csv"),
    ):
        with pytest.raises(ExportError, match=what):
            written(tmp_path, name, kind, dome, small_capture)
    with pytest.raises(ExportError, match="no result"):
        written(tmp_path, "a.csv", "curves", None, small_capture)
    thick = SurfaceSettings(thickness=50.0)
    with pytest.raises(SurfaceError, match="thick"):
        written(tmp_path, "a.stl", "surface", dome, small_capture, settings=thick)

    def refuse(_surface, path, _unit, _name):
        raise ExportError(f"{path}: no")

    monkeypatch.setattr(choices, "write_surface", refuse)
    with pytest.raises(ExportError, match=f"^{tmp_path / 'a.stl'}: no$"):
        written(tmp_path, "a.stl", "surface", dome, small_capture)
    assert [one.name for one in tmp_path.iterdir()] == ["folder.stl"]
