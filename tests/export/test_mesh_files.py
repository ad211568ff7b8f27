"""Mesh files: read back by VTK's readers, an implementation that shares nothing with ours."""

from dataclasses import replace

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOGeometry import vtkOBJReader, vtkSTLReader
from vtkmodules.vtkIOPLY import vtkPLYReader

import synthetic
from georibbon.errors import ExportError
from georibbon.export.mesh import UNITS, write_mesh
from georibbon.geometry.mesh import Mesh, thicken

READERS = {".stl": vtkSTLReader, ".obj": vtkOBJReader, ".ply": vtkPLYReader}
SCALE = {"mm": 1000.0, "cm": 100.0, "m": 1.0, "in": 1 / 0.0254}


def read(path):
    """(points, triangles, normals or None) as VTK reads them, with nothing merged."""
    reader = READERS[path.suffix.lower()]()
    reader.SetFileName(str(path))
    if path.suffix == ".stl":
        reader.MergingOff()
    reader.Update()
    data = reader.GetOutput()
    triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    normals = data.GetPointData().GetNormals()
    points = vtk_to_numpy(data.GetPoints().GetData())
    return points, triangles, None if normals is None else vtk_to_numpy(normals)


@pytest.fixture(scope="module")
def mesh():
    return synthetic.mesh(25, 17)


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply", ".STL"])
def test_every_triangle_comes_back(mesh, tmp_path, ending, unit):
    path = tmp_path / f"part{ending}"
    write_mesh(mesh, path, unit)
    points, triangles, _ = read(path)
    expected = (mesh.vertices * SCALE[unit])[mesh.triangles]
    if ending == ".obj":  # text of ten digits: better than single precision
        assert np.allclose(points[triangles], expected, rtol=1e-9, atol=1e-12)
    else:
        assert np.array_equal(points[triangles], expected.astype(np.float32))


@pytest.mark.parametrize("ending", [".obj", ".ply"])
def test_shared_vertices_stay_shared_and_keep_their_normals(mesh, tmp_path, ending):
    path = tmp_path / f"part{ending}"
    write_mesh(mesh, path, "mm")
    points, triangles, normals = read(path)
    assert len(points) == len(mesh.vertices)
    assert np.array_equal(triangles, mesh.triangles)
    assert np.allclose(normals, mesh.normals, atol=1e-6)


def test_the_rim_of_a_solid_obj_is_shaded_as_it_lies(mesh, tmp_path):
    solid = thicken(mesh, 0.002)
    write_mesh(solid, tmp_path / "part.obj", "m")
    lines = [line.split() for line in (tmp_path / "part.obj").read_text().splitlines()]
    rows = {kind: [line[1:] for line in lines if line[0] == kind] for kind in ("v", "vn", "f")}
    assert len(rows["v"]) == len(solid.vertices)
    normals = np.array(rows["vn"], dtype=float)
    corners = np.array([[word.split("//") for word in row] for row in rows["f"]], dtype=int) - 1
    assert np.array_equal(corners[..., 0], solid.triangles)
    a, b, c = np.moveaxis(solid.vertices[solid.triangles], 1, 0)
    outward = np.cross(b - a, c - a)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    assert np.min(np.sum(normals[corners[..., 1]] * outward[:, None], axis=2)) > 0.5


def test_obj_holds_more_than_single_precision(tmp_path):
    shift = np.array([100.123456789, 0.0, 0.0])
    flat = synthetic.mesh(3, 3)
    write_mesh(replace(flat, vertices=flat.vertices + shift), tmp_path / "far.obj", "m")
    lines = (tmp_path / "far.obj").read_text().splitlines()
    rows = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    assert np.max(np.abs(rows - flat.vertices - shift)) < 1e-7


def test_stl_facet_normals_agree_with_the_outward_vertex_normals(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "part.stl", "m")
    raw = (tmp_path / "part.stl").read_bytes()
    facets = np.frombuffer(raw[84:], dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    mean = mesh.normals[mesh.triangles].mean(axis=1)
    assert np.allclose(np.linalg.norm(facets["n"], axis=1), 1, atol=1e-6)
    assert np.min(np.sum(facets["n"] * mean, axis=1)) > 0.95


def test_a_triangle_without_area_gets_no_normal_rather_than_nan(tmp_path):
    flat = Mesh(np.eye(3), np.array([[0, 1, 2], [0, 0, 1]]), np.eye(3))
    write_mesh(flat, tmp_path / "part.stl", "m")
    raw = (tmp_path / "part.stl").read_bytes()
    assert np.isfinite(np.frombuffer(raw[84 + 50 : 84 + 98], dtype="<f4")).all()


@pytest.mark.parametrize("unit", UNITS)
def test_ply_carries_sigma_in_the_files_unit(mesh, tmp_path, unit):
    write_mesh(mesh, tmp_path / "part.ply", unit)
    raw = (tmp_path / "part.ply").read_bytes()
    body = raw[raw.index(b"end_header\n") + len(b"end_header\n") :]
    rows = np.frombuffer(body[: 28 * len(mesh.vertices)], dtype="<f4").reshape(-1, 7)
    assert np.allclose(rows[:, 6], mesh.sigma * SCALE[unit], rtol=1e-6)
    assert b"property float sigma" in raw


def test_ply_without_sigma_has_no_such_property(mesh, tmp_path):
    write_mesh(replace(mesh, sigma=None), tmp_path / "part.ply", "mm")
    assert b"sigma" not in (tmp_path / "part.ply").read_bytes()
    assert len(read(tmp_path / "part.ply")[0]) == len(mesh.vertices)


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply"])
def test_the_file_tells_its_unit(mesh, tmp_path, ending, unit):
    path = tmp_path / f"part{ending}"
    write_mesh(mesh, path, unit)
    head = path.read_bytes()[:200].decode("latin-1")
    assert f"unit: {unit}" in head.replace("\n", " ").replace("  ", " ") + " "
    assert head.count("unit: ") == 1
    assert not head.startswith("solid")


@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply"])
def test_the_same_mesh_gives_the_same_bytes(mesh, tmp_path, ending):
    first, second = tmp_path / f"one{ending}", tmp_path / f"two{ending}"
    write_mesh(mesh, first, "mm")
    write_mesh(mesh, second, "mm")
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("name", ["part.step", "part", "part.stl.txt"])
def test_an_unknown_ending_is_refused_with_the_known_ones(mesh, tmp_path, name):
    with pytest.raises(ExportError, match=r"\.stl or \.obj or \.ply"):
        write_mesh(mesh, tmp_path / name, "mm")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("field", ["vertices", "normals", "sigma"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(mesh, tmp_path, field, bad):
    values = getattr(mesh, field).copy()
    values[3] = bad
    with pytest.raises(ExportError, match=rf"\d of the surface's {field} values"):
        write_mesh(replace(mesh, **{field: values}), tmp_path / "part.ply", "mm")
    assert list(tmp_path.iterdir()) == []


def test_an_empty_mesh_is_refused(mesh, tmp_path):
    with pytest.raises(ExportError, match="no triangle"):
        write_mesh(replace(mesh, triangles=mesh.triangles[:0]), tmp_path / "part.stl", "mm")


def test_a_missing_folder_and_a_folder_as_file_are_refused(mesh, tmp_path):
    with pytest.raises(ExportError, match="does not exist"):
        write_mesh(mesh, tmp_path / "nowhere" / "part.stl", "mm")
    (tmp_path / "part.stl").mkdir()
    with pytest.raises(ExportError, match="is a folder"):
        write_mesh(mesh, tmp_path / "part.stl", "mm")


def test_a_place_that_cannot_be_written_is_told_in_a_sentence(mesh, tmp_path):
    with pytest.raises(ExportError, match="cannot be written"):
        write_mesh(mesh, tmp_path / ("long" * 80 + ".stl"), "mm")
    assert list(tmp_path.iterdir()) == []


def test_an_older_file_is_replaced_whole(mesh, tmp_path):
    path = tmp_path / "part.obj"
    path.write_text("something longer than nothing\n" * 100000)
    write_mesh(mesh, path, "mm")
    assert path.read_text().startswith("# Georibbon")
    assert list(tmp_path.iterdir()) == [path]
