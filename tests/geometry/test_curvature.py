"""Curvature of meshes, against the surfaces that they were taken from."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.geometry.curvature import grid_curvature, grid_differences, mesh_curvature
from georibbon.geometry.mesh import Mesh, grid_mesh

RING, PIPE = 0.7, 0.3


def torus(count, uneven=1.0):
    """A piece of a torus as a grid mesh, with its Gaussian, mean curvature and directions."""
    u, v = np.meshgrid(
        2.0 * np.linspace(0.0, 1.0, count) ** uneven, np.linspace(-0.4, 1.5, count), indexing="ij"
    )
    outward = np.stack((np.cos(u), np.sin(u), np.zeros_like(u)), axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    normals = np.cos(v)[..., None] * outward + np.sin(v)[..., None] * up
    mesh = grid_mesh(RING * outward + PIPE * normals, normals)
    around = -np.cos(v).ravel() / (RING + PIPE * np.cos(v).ravel())
    across = np.full(u.size, -1.0 / PIPE)
    along_u = np.stack((-np.sin(u), np.cos(u), np.zeros_like(u)), axis=-1).reshape(-1, 3)
    return mesh, (count, count), around, across, along_u


def worst(count, of):
    mesh, shape, around, across, _ = torus(count, uneven=1.3)
    found = of(mesh, shape)
    return max(
        np.abs(found.gaussian - around * across).max(),
        np.abs(found.mean - 0.5 * (around + across)).max(),
    )


def test_on_a_torus_a_grid_converges_in_second_order():
    errors = [worst(count, grid_curvature) for count in (11, 21, 41)]
    assert errors[0] < 0.02
    assert errors[0] / errors[1] > 3.2
    assert errors[1] / errors[2] > 3.2


def test_on_a_torus_any_mesh_converges_in_first_order():
    errors = [worst(count, lambda mesh, _: mesh_curvature(mesh)) for count in (11, 21, 41)]
    assert errors[2] < 0.15
    assert errors[0] / errors[1] > 1.7
    assert errors[1] / errors[2] > 1.7


@pytest.mark.parametrize("of", [grid_curvature, lambda mesh, _: mesh_curvature(mesh)])
@given(angle=st.floats(0.0, np.pi))
def test_normal_curvature_obeys_euler(of, angle):
    """k(a) = k1 cos² a + k2 sin² a, a from the first principal direction."""
    mesh, shape, around, across, along_u = torus(31)
    other = np.cross(mesh.normals, along_u)
    directions = 3.0 * (np.cos(angle) * along_u + np.sin(angle) * other)
    expected = around * np.cos(angle) ** 2 + across * np.sin(angle) ** 2
    assert of(mesh, shape).along(directions) == pytest.approx(expected, abs=0.2)


@given(radius=st.floats(0.01, 100.0), seed=st.integers(0, 1000))
def test_any_triangles_on_a_ball_have_its_curvature_exactly(radius, seed):
    """N = P/R: the normals turn as the points go, however the mesh lies."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(30, 3)) * 0.2 + [0.0, 0.0, 1.0]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    triangles = np.array([rng.choice(30, 3, replace=False) for _ in range(60)])
    points = radius * normals
    across = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]],
        points[triangles[:, 2]] - points[triangles[:, 0]],
    )
    down = np.sum(across * normals[triangles[:, 0]], axis=1) < 0
    triangles[down] = triangles[down][:, ::-1]
    slim = np.linalg.norm(across, axis=1) < 1e-3 * radius**2
    mesh = Mesh(points, triangles[~slim], normals)
    found = mesh_curvature(mesh)
    met = np.unique(mesh.triangles)
    assert found.mean[met] == pytest.approx(-1.0 / radius, rel=1e-6)
    assert found.gaussian[met] == pytest.approx(1.0 / radius**2, rel=1e-6)


@given(turn=st.floats(0.0, np.pi))
def test_a_cylinder_bends_one_way_only(turn):
    """Gaussian curvature none, mean half of 1/R, however the grid runs over it."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 25), np.linspace(-0.5, 0.5, 25), indexing="ij")
    angle, height = (np.cos(turn) * u - np.sin(turn) * v), np.sin(turn) * u + np.cos(turn) * v
    normals = np.stack((np.cos(angle), np.sin(angle), np.zeros_like(angle)), axis=-1)
    points = 0.8 * normals + height[..., None] * [0.0, 0.0, 1.0]
    found = grid_curvature(grid_mesh(points, normals), (25, 25))
    assert found.gaussian == pytest.approx(0.0, abs=1e-3)
    assert found.mean == pytest.approx(-0.5 / 0.8, abs=1e-3)


def test_curvature_is_positive_towards_the_normals():
    mesh, shape, around, across, _ = torus(21)
    inward = Mesh(mesh.vertices, mesh.triangles[:, ::-1], -mesh.normals)
    for found in (grid_curvature(inward, shape), mesh_curvature(inward)):
        assert found.mean == pytest.approx(-0.5 * (around + across), abs=0.1)


def test_what_has_no_area_has_no_curvature():
    points = np.zeros((3, 3, 3))
    points[..., 0] = np.arange(3)
    normals = np.tile([0.0, 0.0, 1.0], (3, 3, 1))
    lone = Mesh(points.reshape(-1, 3), np.array([[0, 1, 2]]), normals.reshape(-1, 3))
    assert np.isnan(grid_curvature(lone, (3, 3)).mean).all()
    assert np.isnan(mesh_curvature(lone).gaussian).all()


def test_differences_are_exact_for_parabolas_and_for_two_points():
    at = np.arange(6.0)
    grid = np.stack(np.broadcast_arrays(at[:, None] ** 2, 3.0 * at[None, :2]), axis=-1)
    along, across = grid_differences(grid)
    assert along[..., 0] == pytest.approx(np.repeat(2.0 * at[:, None], 2, axis=1))
    assert across[..., 1] == pytest.approx(3.0)
