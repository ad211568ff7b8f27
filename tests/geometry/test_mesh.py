"""Laws of meshes: area and volume known in closed form, orientation, closed solids."""

import numpy as np
import pytest

from georibbon.errors import SurfaceError
from georibbon.geometry.frames import unit
from georibbon.geometry.mesh import (
    Mesh,
    area,
    boundary_edges,
    folding_thickness,
    grid_mesh,
    is_oriented,
    is_watertight,
    thicken,
    volume,
)


def flat(rows: int = 4, columns: int = 6, width: float = 2.0, depth: float = 3.0) -> Mesh:
    x, y = np.meshgrid(
        np.linspace(0.0, width, rows), np.linspace(0.0, depth, columns), indexing="ij"
    )
    points = np.stack([x, y, 0.0 * x], axis=-1)
    return grid_mesh(points, np.broadcast_to([0.0, 0.0, 1.0], points.shape), x + 1.0)


def cap(radius: float = 0.5, count: int = 80, inward: bool = False) -> Mesh:
    """A patch of a sphere; inward: seen from within, normals towards the centre."""
    u, v = np.meshgrid(np.linspace(-0.7, 0.7, count), np.linspace(-0.6, 0.6, count), indexing="ij")
    outward = np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], axis=-1)
    if inward:
        return grid_mesh(radius * outward[::-1], -outward[::-1])
    return grid_mesh(radius * outward, outward)


def test_a_flat_grid_has_its_rectangle_s_area_and_faces_its_normals() -> None:
    mesh = flat()
    assert area(mesh) == pytest.approx(6.0)
    assert len(mesh.triangles) == 2 * 3 * 5
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    assert mesh.sigma is not None
    assert np.allclose(mesh.sigma, mesh.vertices[:, 0] + 1.0)


def test_a_grid_s_boundary_is_its_rim_run_once_around() -> None:
    edges = boundary_edges(flat(4, 6))
    assert len(edges) == 2 * (3 + 5)
    assert np.array_equal(np.sort(edges[:, 0]), np.sort(edges[:, 1]))
    assert is_oriented(flat())
    assert not is_watertight(flat())


def test_quadrilaterals_are_cut_along_their_shorter_diagonal() -> None:
    for lean in (0.5, -0.5):
        points = np.array([[[0.0, 0, 0], [lean, 1.0, 0]], [[1.0, 0, 0], [1.0 + lean, 1.0, 0]]])
        mesh = grid_mesh(points, np.broadcast_to([0.0, 0.0, 1.0], points.shape))
        edges = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
        assert lengths.max() < 1.2
        assert is_oriented(mesh)


def test_no_vertex_is_there_twice() -> None:
    assert len(np.unique(cap().vertices, axis=0)) == len(cap().vertices)


def test_the_area_of_a_sphere_s_patch_converges_with_second_order() -> None:
    exact = 0.25 * 1.4 * 2.0 * np.sin(0.6)
    errors = [exact - area(cap(count=count)) for count in (21, 41)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_a_flat_slab_has_its_volume_and_is_closed() -> None:
    solid = thicken(flat(), 0.25)
    assert is_watertight(solid)
    assert volume(solid) == pytest.approx(6.0 * 0.25)
    assert area(solid) == pytest.approx(2.0 * 6.0 + 0.25 * 2.0 * (2.0 + 3.0))
    assert solid.sigma is not None
    assert len(solid.sigma) == len(solid.vertices) == len(solid.normals)


@pytest.mark.parametrize("inward", [False, True])
def test_a_shell_s_volume_is_that_between_two_spheres(inward: bool) -> None:
    solid = thicken(cap(inward=inward), 0.1)
    inner = 0.6**3 - 0.5**3 if inward else 0.5**3 - 0.4**3
    exact = inner / 3.0 * 1.4 * 2.0 * np.sin(0.6)
    assert is_watertight(solid)
    assert volume(solid) == pytest.approx(exact, rel=1e-3)


def test_the_outer_face_is_the_skin_itself() -> None:
    skin = cap()
    solid = thicken(skin, 0.01)
    assert np.array_equal(solid.vertices[: len(skin.vertices)], skin.vertices)
    assert np.array_equal(solid.triangles[: len(skin.triangles)], skin.triangles)
    offset = np.linalg.norm(solid.vertices[len(skin.vertices) :], axis=1)
    assert np.allclose(offset, 0.49)


def test_a_solid_moves_with_its_skin() -> None:
    skin = cap()
    shift = np.array([100.0, -3.0, 7.0])
    moved = Mesh(skin.vertices + shift, skin.triangles, skin.normals)
    assert volume(thicken(moved, 0.1)) == pytest.approx(volume(thicken(skin, 0.1)), rel=1e-9)


def test_a_sphere_s_skin_folds_at_its_centre() -> None:
    assert folding_thickness(cap(0.5)) == pytest.approx(0.5, rel=1e-6)


def test_a_flat_skin_and_a_hollow_one_never_fold() -> None:
    assert folding_thickness(flat()) == np.inf
    assert folding_thickness(cap(inward=True)) == np.inf


def test_a_cylinder_folds_at_its_axis() -> None:
    angle, along = np.meshgrid(np.linspace(-1, 1, 60), np.linspace(0, 1, 9), indexing="ij")
    outward = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=-1)
    points = 0.2 * outward + along[..., None] * [0.0, 1.0, 0.0]
    mesh = grid_mesh(points, outward)
    assert folding_thickness(mesh) == pytest.approx(0.2, rel=1e-6)


def test_a_saddle_folds_where_it_bends_outward_most() -> None:
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, 41), np.linspace(-0.1, 0.1, 41), indexing="ij")
    points = np.stack([x, y, x**2 / 0.8 - y**2 / 0.6], axis=-1)
    normals = unit(np.stack([-2 * x / 0.8, 2 * y / 0.6, np.ones_like(x)], axis=-1))
    assert folding_thickness(grid_mesh(points, normals)) == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize("thickness", [0.5, 0.7])
def test_a_wall_thicker_than_the_bend_is_refused(thickness: float) -> None:
    with pytest.raises(SurfaceError, match=r"at most 500\.00 mm is possible"):
        thicken(cap(0.5), thickness)


def test_a_triangle_run_the_wrong_way_is_seen() -> None:
    solid = thicken(flat(), 0.25)
    wrong = solid.triangles.copy()
    wrong[3] = wrong[3, ::-1]
    mesh = Mesh(solid.vertices, wrong, solid.normals)
    assert not is_oriented(mesh)
    assert not is_watertight(mesh)
    hole = Mesh(solid.vertices, solid.triangles[1:], solid.normals)
    assert is_oriented(hole)
    assert not is_watertight(hole)
    assert len(boundary_edges(hole)) == 3
