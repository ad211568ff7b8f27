"""Crossing triangles, against the separating axis theorem; surfaces that run through themselves."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.geometry.checks import self_crossing
from georibbon.geometry.crossings import crossing_triangles, near_pairs
from georibbon.geometry.frames import Strip, frames_from
from georibbon.geometry.mesh import Mesh
from georibbon.geometry.patch import PatchGrid
from georibbon.geometry.surface import SurfaceSettings, build_surface
from passes import sphere_passes


def soup(count: int, seed: int) -> Mesh:
    """Loose triangles in a unit box."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(size=(count, 1, 3)) + 0.3 * rng.normal(size=(count, 3, 3))
    vertices = corners.reshape(-1, 3)
    return Mesh(vertices, np.arange(3 * count).reshape(-1, 3), np.zeros_like(vertices))


def separated(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether some plane parts two triangles in general position."""
    edges_a, edges_b = np.roll(a, -1, axis=0) - a, np.roll(b, -1, axis=0) - b
    axes = [np.cross(edges_a[0], edges_a[1]), np.cross(edges_b[0], edges_b[1])]
    axes += [np.cross(p, q) for p in edges_a for q in edges_b]
    return any((a @ x).max() < (b @ x).min() or (b @ x).max() < (a @ x).min() for x in axes)


@pytest.mark.parametrize("seed", range(4))
def test_crossings_are_those_that_no_plane_parts(seed: int) -> None:
    mesh = soup(40, seed)
    corners = mesh.vertices[mesh.triangles]
    expected = {
        (i, j) for i, j in combinations(range(40), 2) if not separated(corners[i], corners[j])
    }
    assert len(expected) > 20
    assert {tuple(sorted(pair)) for pair in crossing_triangles(mesh).tolist()} == expected


def test_crossings_move_with_the_mesh() -> None:
    mesh = soup(60, 9)
    turned = Rotation.from_rotvec([1.0, 2.0, -0.5]).apply(mesh.vertices) + np.array(
        [3.0, 0.0, -1.0]
    )
    other = crossing_triangles(Mesh(turned, mesh.triangles, mesh.normals))
    assert set(map(tuple, other.tolist())) == set(map(tuple, crossing_triangles(mesh).tolist()))


def test_neighbours_and_parallel_triangles_do_not_cross() -> None:
    vertices = np.array(
        [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.2], [0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]]
    )
    triangles = np.array([[0, 1, 2], [2, 1, 3], [4, 5, 6]])
    assert len(crossing_triangles(Mesh(vertices, triangles, vertices))) == 0
    flat = Mesh(vertices[[0, 1, 2, 0, 1, 2]], np.array([[0, 1, 2], [3, 4, 5]]), vertices)
    assert len(crossing_triangles(flat)) == 0


@pytest.mark.parametrize("seed", range(4))
def test_within_one_plane_nothing_crosses_wherever_it_lies(seed: int) -> None:
    mesh, rng = soup(60, seed), np.random.default_rng(seed)
    turned = Rotation.from_rotvec(rng.normal(size=3)).apply(mesh.vertices * [1.0, 1.0, 0.0])
    plane = Mesh(turned + rng.normal(size=3), mesh.triangles, mesh.normals)
    assert len(near_pairs(plane.vertices[plane.triangles])[0]) > 100
    assert len(crossing_triangles(plane)) == 0


def test_rings_of_a_pipe_do_not_run_through_themselves() -> None:
    angle = np.linspace(0.0, 1.975 * np.pi, 80)
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros(80)], axis=1)
    frames = frames_from(np.stack([-out[:, 1], out[:, 0], out[:, 2]], axis=1), out)
    strips = [Strip(0.1 * angle, 0.1 * out + [0.0, 0.0, z], frames) for z in (0.0, 0.05, 0.1, 0.15)]
    surface = build_surface(strips, "abcd", SurfaceSettings())
    check = next(check for check in surface.checks if check.code == "self-crossing")
    assert check.verdict == "pass", check.message


def looped() -> PatchGrid:
    """Two patches along x: the first is flat, the second curls over and back down through it."""
    x = np.linspace(0.0, 0.5, 60)[None, :, None]
    v = np.linspace(0.0, 1.0, 9)
    y = np.stack([0.1 * v, 0.1 - 0.08 * v])[:, None]
    z = np.stack([0.0 * v, 0.06 * np.sin(1.4 * np.pi * v)])[:, None]
    points = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    return PatchGrid(points, points, points, up)


def test_a_patch_that_comes_down_through_its_neighbour_is_found_and_named() -> None:
    check = self_crossing(looped(), ["P1-P2", "P2-P3"])
    assert check.verdict == "fail"
    assert check.where == "P1-P2"
    assert check.value >= 24
    assert "between P1-P2 and that between P2-P3 runs through itself" in check.message


def test_a_patch_that_runs_through_itself_is_named_alone() -> None:
    """One patch whose section is a loop."""
    x = np.linspace(0.0, 0.5, 60)[None, :, None]
    v = np.linspace(-1.0, 1.0, 9)[None, None]
    points = np.stack(np.broadcast_arrays(x, 0.1 * (v**3 - 0.6 * v), 0.1 * v**2), axis=-1)
    up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    check = self_crossing(PatchGrid(points, points, points, up), ["P1-P2"])
    assert check.verdict == "fail"
    assert "the surface between P1-P2 runs through itself" in check.message


def test_a_dome_does_not_run_through_itself() -> None:
    surface = build_surface(sphere_passes(), ["a", "b", "c", "d", "e"], SurfaceSettings())
    check = next(check for check in surface.checks if check.code == "self-crossing")
    assert (check.verdict, check.value, check.where) == ("pass", 0.0, "surface")
