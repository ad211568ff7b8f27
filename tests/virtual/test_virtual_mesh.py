"""Passes on a mesh out of a file."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from worlds import QUIET, SMALL, counts_of, world_of

from georibbon.errors import GeoribbonError, SettingsError
from georibbon.geometry.closest import closest_point
from georibbon.session import mesh_file
from georibbon.simulation import LayoutSettings, make_surface, read_truth, write_truth
from georibbon.virtual import MeshSettings
from georibbon.virtual.mesh import lay_on_mesh, read_mesh

LAYOUT = LayoutSettings(passes=3, ties=1, heading=20.0)
LENGTH = 0.6


def written(folder, shape, kind="stl", name="part"):
    """A shape of trimesh as a file."""
    data = shape.export(file_type=kind)
    path = folder / f"{name}.{kind}"
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def obj(folder, text):
    """An OBJ file of that text."""
    path = folder / "part.obj"
    path.write_text(text, encoding="utf-8")
    return path


def laid(path, unit="mm", layout=LAYOUT, length=LENGTH):
    return lay_on_mesh(read_mesh(MeshSettings(path, unit)), layout, length)


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """A finely triangulated ball of half a metre, in millimetres."""
    ball = trimesh.creation.icosphere(subdivisions=5, radius=500.0)
    return written(tmp_path_factory.mktemp("ball"), ball)


def test_passes_on_a_ball_are_great_circles(ball):
    strips = laid(ball)
    assert list(strips) == ["P1", "P2", "P3", "T1"]
    for strip in strips.values():
        np.testing.assert_allclose(np.linalg.norm(strip.points, axis=1), 0.5, atol=2e-4)
        across = np.linalg.svd(strip.points)[2][2]
        assert np.abs(strip.points @ across).max() < 1e-3
        outwards = strip.points / np.linalg.norm(strip.points, axis=1)[:, None]
        angles = np.degrees(np.arccos(np.clip(np.sum(strip.normals * outwards, axis=1), -1, 1)))
        assert angles.max() < 0.5
        # Its own length, along an arc of that angle.
        turned = np.arccos(np.clip(outwards[0] @ outwards[-1], -1, 1))
        assert 0.5 * turned == pytest.approx(LENGTH, abs=5e-4)


def test_passes_lie_as_on_the_reference_surface(ball):
    """On a ball: the same distances between the passes, the tie square to the middle one."""
    strips = laid(ball)
    middles = [strips[f"P{k}"].points[len(strips["P1"].s) // 2] for k in (1, 2, 3)]
    for a, b in pairwise(middles):
        assert 0.5 * np.arccos(a @ b / 0.25) == pytest.approx(0.1, abs=1e-3)
    np.testing.assert_allclose(middles[1], [0.0, 0.0, 0.5], atol=1e-3)
    along = strips["P2"].tangents[len(strips["P2"].s) // 2]
    np.testing.assert_allclose(
        along[:2], [np.cos(np.radians(20)), np.sin(np.radians(20))], atol=0.01
    )
    tie = strips["T1"].tangents[len(strips["T1"].s) // 2]
    assert abs(tie @ along) < 0.01


def test_the_frames_are_a_curves_own_and_turn_smoothly(ball):
    for strip in laid(ball).values():
        frames = strip.frames
        np.testing.assert_allclose(
            frames @ np.swapaxes(frames, 1, 2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-9
        )
        assert (np.linalg.det(frames) > 0).all()
        slope = np.gradient(strip.points, strip.s, axis=0)[2:-2]
        np.testing.assert_allclose(slope, strip.tangents[2:-2], atol=2e-3)
        # Two radians a metre on this ball, spread evenly.
        turn = np.linalg.norm(np.diff(strip.frames, axis=0), axis=(1, 2)) / np.diff(strip.s)
        assert turn.max() < 2 * np.sqrt(2) * 1.5


def test_a_finer_mesh_is_nearer_to_the_surface_it_is_of(tmp_path):
    torus = make_surface("torus", {})
    errors = []
    for k in (1, 2):
        shape = trimesh.creation.torus(700.0, 350.0, 60 * k, 40 * k)
        strips = laid(
            written(tmp_path, shape, name=f"t{k}"), layout=replace(LAYOUT, start=(0, -0.7))
        )
        gaps = [closest_point(torus, strip.points).distance for strip in strips.values()]
        errors.append(np.abs(np.concatenate(gaps)).max())
    assert errors[1] < 0.5 * errors[0] < 1.5e-3


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
def test_all_kinds_of_files_give_the_same_passes(tmp_path, kind):
    box = trimesh.creation.box((1000.0, 800.0, 400.0))
    strips = laid(written(tmp_path, box, kind), layout=replace(LAYOUT, heading=0.0))
    s = np.linspace(0.0, LENGTH, len(strips["P2"].s))
    true = np.stack([s - LENGTH / 2, 0 * s, 0 * s + 0.2], axis=1)
    np.testing.assert_allclose(strips["P2"].points, true, atol=1e-9)
    up = np.broadcast_to([0.0, 0.0, 1.0], true.shape)
    np.testing.assert_allclose(strips["P2"].normals, up, atol=1e-9)


def test_over_an_edge_the_pass_goes_on_straight(tmp_path):
    box = trimesh.creation.box((400.0, 800.0, 400.0))
    strip = laid(written(tmp_path, box), layout=replace(LAYOUT, heading=0.0, spacing=0.02))["P2"]
    assert strip.points[0, 2] == pytest.approx(0.1, abs=0.02)
    np.testing.assert_allclose(strip.points[:, 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(strip.normals[[0, -1]], [[-1, 0, 0], [1, 0, 0]], atol=0.3)


def test_the_unit_is_told(tmp_path):
    in_metres = trimesh.creation.box((1.0, 0.8, 0.4))
    strips = laid(written(tmp_path, in_metres), "m")
    assert strips["P2"].points[:, 2] == pytest.approx(0.2)
    with pytest.raises(SettingsError, match=r"--unit m\)"):
        laid(written(tmp_path, in_metres), "mm")
    with pytest.raises(SettingsError, match=r"--unit mm\)"):
        laid(written(tmp_path, trimesh.creation.box((1000.0, 800.0, 400.0))), "m")
    with pytest.raises(SettingsError, match="inch"):
        MeshSettings(tmp_path / "part.stl", "inch")


QUAD = "v -500 -500 0\nv 500 -500 0\nv 500 500 0\nv -500 500 0\n"
WALL = "v -500 0 -500\nv 500 0 -500\nv 500 0 500\nv -500 0 500\n"


def test_what_is_met_from_above_is_outside(tmp_path):
    for faces in ("f 1 2 3 4\n", "f 4 3 2 1\n"):
        strips = laid(obj(tmp_path, QUAD + faces))
        np.testing.assert_allclose(strips["P1"].normals[:, 2], 1.0)


def test_an_upright_sheet_is_laid_on_too(tmp_path):
    strips = laid(obj(tmp_path, WALL + "f 1 2 3 4\n"))
    np.testing.assert_allclose(strips["P2"].points[:, 1], 0.0, atol=1e-12)
    assert len(strips) == 4


def test_a_pass_that_runs_off_is_named(tmp_path):
    path = obj(tmp_path, QUAD + "f 1 2 3 4\n")
    with pytest.raises(SettingsError, match="P3 runs off the mesh"):
        laid(
            path,
            layout=replace(LAYOUT, start=(0.0, 0.25), heading=0.0, fan=20.0, fan_kind="spread"),
            length=0.9,
        )
    with pytest.raises(SettingsError, match="the line across the passes runs off"):
        laid(path, layout=replace(LAYOUT, spacing=0.6))
    with pytest.raises(SettingsError, match="T1 runs off"):
        laid(path, layout=replace(LAYOUT, start=(0.0, 0.3), heading=0.0, spacing=0.05))
    with pytest.raises(SettingsError, match="P1 runs off"):
        laid(path, length=3.0)


def test_a_start_off_the_mesh_is_refused(tmp_path):
    with pytest.raises(SettingsError, match="nothing at the start 2,0"):
        laid(obj(tmp_path, QUAD + "f 1 2 3 4\n"), layout=replace(LAYOUT, start=(2.0, 0.0)))


def test_a_mesh_too_small_for_the_ribbon_is_refused(tmp_path):
    with pytest.raises(SettingsError, match="too small for a ribbon"):
        laid(written(tmp_path, trimesh.creation.box((60.0, 60.0, 60.0))))


TRIANGLE = "v 0 0 0\nv 1000 0 0\nv 0 1000 0\n"
REFUSED = {
    "no triangles": "v 0 0 0\nv 1 0 0\n",
    "no finite point": "v nan 0 0\nv 1000 0 0\nv 0 1000 0\nf 1 2 3\n",
    "a corner is no finite point": "v 1e300 0 0\nv 1000 0 0\nv 0 1e300 0\nf 1 2 3\n",
    "no area": TRIANGLE + "f 1 1 2\n",
    "more than two triangles": TRIANGLE + "v 0 -1000 0\nv 0 0 1000\nf 1 2 3\nf 2 1 4\nf 1 2 5\n",
    "do not all face one way": QUAD + "f 1 2 3\nf 1 4 3\n",
    "touch in corners only": TRIANGLE + "v -1000 0 0\nv 0 -1000 0\nf 1 2 3\nf 1 4 5\n",
    "no OBJ file": TRIANGLE + "f 1 2 9\n",
}


@pytest.mark.parametrize("reason", REFUSED)
def test_a_bad_mesh_is_refused_with_its_fault(tmp_path, reason):
    with pytest.raises(SettingsError, match=reason):
        laid(obj(tmp_path, REFUSED[reason]))


def test_what_the_parser_stumbles_over_is_not_printed(tmp_path):
    """A picture that a mesh names is not looked for; in a process that nobody has set up."""
    path = tmp_path / "part.ply"
    path.write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile /nowhere.png\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    )
    words = (
        "import pathlib, sys\n"
        "from georibbon.errors import ExportError\n"
        "from georibbon.session.mesh_file import read_triangles\n"
        "print(len(read_triangles(pathlib.Path(sys.argv[1]), 'm', ExportError).triangles))\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", words, str(path)], capture_output=True, text=True, check=True
    )
    assert (ran.stdout.strip(), ran.stderr) == ("1", "")


def test_other_files_and_too_large_ones_are_refused(tmp_path, monkeypatch):
    with pytest.raises(SettingsError, match=r"ends with .stl, .obj or .ply"):
        read_mesh(MeshSettings(tmp_path / "part.step"))
    with pytest.raises(SettingsError, match="missing"):
        read_mesh(MeshSettings(tmp_path / "part.stl"))
    path = written(tmp_path, trimesh.creation.box((1000.0, 800.0, 400.0)))
    monkeypatch.setattr(mesh_file, "MAX_TRIANGLES", 11)
    with pytest.raises(SettingsError, match="at most 11"):
        read_mesh(MeshSettings(path))
    monkeypatch.setattr(mesh_file, "MAX_BYTES", 100)
    with pytest.raises(SettingsError, match="more than 100 bytes"):
        read_mesh(MeshSettings(path))


@given(
    st.sampled_from(["stl", "obj", "ply"]),
    st.lists(st.tuples(st.integers(0, 1200), st.integers(0, 255)), min_size=1, max_size=6),
    st.integers(0, 2000),
)
def test_a_spoilt_file_is_read_or_refused(tmp_path_factory, kind, changes, kept):
    data = GOOD[kind]
    spoilt = bytearray(data[: max(len(data) - kept, 0)])
    for at, value in changes:
        if at < len(spoilt):
            spoilt[at] = value
    path = tmp_path_factory.getbasetemp() / f"spoilt.{kind}"
    path.write_bytes(bytes(spoilt))
    try:
        mesh = read_mesh(MeshSettings(path))
    except GeoribbonError as error:
        told = str(error)
    else:
        told = ""
        assert np.isfinite(mesh.vertices).all()
        assert set(mesh.triangles.ravel()) == set(range(len(mesh.vertices)))
    assert "\n" not in told


def _exported(kind):
    data = trimesh.creation.box((1000.0, 800.0, 400.0)).export(file_type=kind)
    return data.encode() if isinstance(data, str) else data


GOOD = {kind: _exported(kind) for kind in ("stl", "obj", "ply")}


def test_a_virtual_ribbon_on_a_mesh_is_surveyed_and_scored(tmp_path, ball):
    world = world_of(replace(SMALL, layout=replace(LAYOUT, ties=2)), mesh=MeshSettings(ball))
    marks, _, crossings = world.survey()
    assert {mark.pass_name for mark in marks} == {"P1", "P2", "P3"}
    assert len(crossings) == 6
    write_truth(world.truth, tmp_path / "truth.json")
    truth = read_truth(tmp_path / "truth.json")
    assert truth.surface == "part.stl"
    assert truth.shape is None
    np.testing.assert_allclose(
        truth.strips["P1"].points, world.truth.strips["P1"].points, atol=1e-8
    )


def test_a_ribbon_on_a_mesh_says_nearly_what_it_says_on_the_surface(ball):
    """The forward model sees the strips' frames: on a ball, those of the reference sphere."""
    layout = replace(LAYOUT, ties=0, heading=0.0, spacing=0.1, contact=0.0)
    one = world_of(replace(QUIET, layout=layout, yaw=10.0), mesh=MeshSettings(ball), pace=0.0)
    other = world_of(replace(QUIET, surface="sphere", layout=layout, yaw=10.0), pace=0.0)
    for world in (one, other):
        world.do("lay P2")
    a, b = counts_of(one, 1)[0], counts_of(other, 1)[0]
    # Half a degree of 16384 counts.
    assert np.abs(a - b).max() < 16384 * np.radians(0.5)
    assert np.abs(b).max() > 10_000
