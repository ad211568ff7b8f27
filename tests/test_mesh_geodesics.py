"""Geodesics of triangle meshes: exact on planes, tending to great circles on finer balls."""

import numpy as np
import pytest
import trimesh

from georibbon.errors import SurfaceError
from georibbon.geometry.closed_geodesics import sphere_geodesic
from georibbon.geometry.frames import Strip, arc_angles
from georibbon.geometry.mesh import Mesh, grid_mesh
from georibbon.geometry.reference import Bonnet, Plane, ReferenceSurface
from georibbon.geometry.shortest import shortest_geodesic
from georibbon.mesh_geodesics import MeshGeodesics, OffTheMeshError, shortest_path

RADIUS = 0.5
FIRST, SECOND = np.array([0.3, -0.2, 0.6]), np.array([-0.5, 0.3, 0.4])


def meshed(surface: ReferenceSurface, rows: int, columns: int) -> Mesh:
    """A surface over its box, in so many rows and columns of cells cut into triangles."""
    u = np.linspace(surface.lower[0], surface.upper[0], rows + 1)
    v = np.linspace(surface.lower[1], surface.upper[1], columns + 1)
    uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=2).reshape(-1, 2)
    shape = (rows + 1, columns + 1, 3)
    jet = surface.jet(uv)
    return grid_mesh(jet.p.reshape(shape), jet.normals.reshape(shape))


def geodesics_of(mesh: Mesh | trimesh.Trimesh) -> MeshGeodesics:
    triangles = mesh.triangles if isinstance(mesh, Mesh) else mesh.faces
    return MeshGeodesics(np.array(mesh.vertices), np.array(triangles, dtype=np.int64))


def ball(subdivisions: int) -> trimesh.Trimesh:
    return trimesh.creation.icosphere(subdivisions=subdivisions, radius=RADIUS)


def onto(mesh: trimesh.Trimesh, point: np.ndarray) -> np.ndarray:
    """The point of a ball's mesh straight towards its middle from a point."""
    ray = point / np.linalg.norm(point)
    corners = np.asarray(mesh.triangles)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    at = np.sum(corners[:, 0] * normals, axis=1) / (normals @ ray)
    return ray * at[at > 0].min()


def square_to_curve(strip: Strip) -> None:
    """The frames are orthonormal and right-handed, and the tangents the curve's own."""
    frames = strip.frames
    np.testing.assert_allclose(
        np.swapaxes(frames, 1, 2) @ frames, np.eye(3) + 0 * frames, atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-9)
    slope = np.gradient(strip.points, strip.s, axis=0)[2:-2]
    np.testing.assert_allclose(slope, strip.tangents[2:-2], atol=5e-3)


PLANE = geodesics_of(meshed(Plane(25.0, 2.0, 1.5), 9, 7))
NORMAL = np.array([0.0, -np.sin(np.radians(25.0)), np.cos(np.radians(25.0))])


def on_plane(x: float, y: float) -> np.ndarray:
    return np.array([x, y * np.cos(np.radians(25.0)), y * np.sin(np.radians(25.0))])


def test_on_a_plane_the_way_between_two_points_is_the_straight_line() -> None:
    first, second = on_plane(-0.71, -0.33), on_plane(0.62, 0.41)
    strip = PLANE.shortest(first, second, samples=80)
    line = np.linspace(first, second, 80)
    np.testing.assert_allclose(strip.points, line, atol=1e-9)
    np.testing.assert_allclose(strip.normals, np.broadcast_to(NORMAL, line.shape), atol=1e-9)
    assert strip.s[0] == 0.0
    assert strip.s[-1] == pytest.approx(np.linalg.norm(second - first), abs=1e-9)
    square_to_curve(strip)


def test_on_a_plane_the_straightest_geodesic_is_the_straight_line() -> None:
    point, ahead = on_plane(0.1, 0.05), on_plane(1.0, 0.4) / np.hypot(1.0, 0.4)
    s = np.linspace(-0.5, 0.3, 90)
    strip = PLANE.straightest(point, 3.0 * ahead + 0.2 * NORMAL, s)
    np.testing.assert_allclose(strip.points, point + s[:, None] * ahead, atol=1e-9)
    np.testing.assert_allclose(strip.s, s + 0.5, atol=1e-15)
    square_to_curve(strip)


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.4), (-0.4, 0.0)])
def test_a_geodesic_may_begin_or_end_at_its_point(start: float, end: float) -> None:
    point, s = on_plane(0.1, 0.05), np.linspace(start, end, 40)
    strip = PLANE.straightest(point, np.array([1.0, 0.0, 0.0]), s)
    np.testing.assert_allclose(strip.points[:, 0], 0.1 + s, atol=1e-9)


@pytest.mark.parametrize("samples", [2, 3, 5])
def test_a_geodesic_may_be_asked_for_at_few_places(samples: int) -> None:
    mesh = ball(4)
    geodesics, start, end = geodesics_of(mesh), onto(mesh, FIRST), onto(mesh, SECOND)
    dense = geodesics.shortest(start, end, samples=1 + 60 * (samples - 1))
    few = geodesics.shortest(start, end, samples=samples)
    np.testing.assert_allclose(few.points, dense.points[::60], atol=2e-4)
    np.testing.assert_allclose(np.linalg.det(few.frames), 1.0, atol=1e-9)


def test_two_points_of_one_triangle_are_joined_straight() -> None:
    strip = PLANE.shortest(on_plane(0.01, 0.02), on_plane(0.03, 0.03), samples=20)
    np.testing.assert_allclose(strip.points, np.linspace(*strip.points[[0, -1]], 20), atol=1e-9)
    assert strip.s[-1] == pytest.approx(np.hypot(0.02, 0.01), abs=1e-12)


def test_on_finer_balls_the_way_between_two_points_tends_to_the_great_circle() -> None:
    angle = arc_angles(FIRST, SECOND)
    errors, lengths, leans = [], [], []
    for subdivisions in (4, 5):
        mesh = ball(subdivisions)
        strip = geodesics_of(mesh).shortest(onto(mesh, FIRST), onto(mesh, SECOND))
        true = sphere_geodesic(RADIUS, FIRST, SECOND, np.linspace(0.0, RADIUS * angle, 121))
        errors.append(np.linalg.norm(strip.points - true.points, axis=1).max())
        leans.append(np.degrees(arc_angles(strip.normals, true.normals)).max())
        lengths.append(abs(strip.s[-1] - RADIUS * angle))
        square_to_curve(strip)
    assert errors[1] < 0.5 * errors[0] < 1.5e-3
    assert lengths[1] < 0.4 * lengths[0] < 3e-4
    assert leans[1] < 0.5 * leans[0] < 0.3


def test_on_finer_balls_the_straightest_geodesic_tends_to_the_great_circle() -> None:
    s, ahead, errors = np.linspace(-0.3, 0.5, 121), np.array([1.0, 0.4, 0.2]), []
    for subdivisions in (3, 4, 5):
        mesh = ball(subdivisions)
        strip = geodesics_of(mesh).straightest(onto(mesh, FIRST), ahead, s)
        true = sphere_geodesic(RADIUS, FIRST, ahead, s)
        errors.append(np.linalg.norm(strip.points - true.points, axis=1).max())
    assert errors[2] < 0.5 * errors[0] < 5e-3


def test_the_way_between_two_points_of_a_meshed_surface_is_its_geodesic() -> None:
    surface, start, end = Bonnet(), np.array([-0.4, -0.3]), np.array([0.4, 0.2])
    mesh = meshed(Bonnet(length=1.2, width=1.2), 80, 80)
    ends = surface.points(np.stack([start, end]))
    found = geodesics_of(mesh).shortest(*ends)
    true = shortest_geodesic(surface, start, end)
    assert found.s[-1] == pytest.approx(true.s[-1], rel=2e-4)
    assert np.linalg.norm(found.points - true.points, axis=1).max() < 2e-3


def test_the_way_over_an_edge_is_straight_when_unfolded() -> None:
    box = trimesh.creation.box((0.4, 0.8, 0.4))
    first, second = np.array([0.05, -0.1, 0.2]), np.array([0.2, 0.2, 0.1])
    vertices, triangles = np.array(box.vertices), np.array(box.faces, dtype=np.int64)
    faces, weights = MeshGeodesics(vertices, triangles).locate(np.stack([first, second]))
    path = shortest_path(vertices, triangles, (faces[0], weights[0]), (faces[1], weights[1]))
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length == pytest.approx(np.hypot(0.15 + 0.1, 0.3), rel=1e-3)


def test_normals_are_those_of_the_facets_across_a_crease_and_blended_elsewhere() -> None:
    box = geodesics_of(trimesh.creation.box((0.4, 0.8, 0.4)))
    points = np.array([[0.19, 0.3, 0.2], [0.2, 0.3, 0.19]])
    np.testing.assert_allclose(box.normals(points), [[0, 0, 1], [1, 0, 0]], atol=1e-12)
    mesh = ball(4)
    normals = geodesics_of(mesh).normals(np.array([onto(mesh, FIRST), onto(mesh, SECOND)]))
    assert np.degrees(arc_angles(normals, np.stack([FIRST, SECOND]))).max() < 0.5


def test_a_geodesic_that_runs_off_the_mesh_says_how_far_it_came() -> None:
    with pytest.raises(OffTheMeshError, match=r"runs off the mesh 0\.9 m") as told:
        PLANE.straightest(on_plane(0.1, 0.0), np.array([1.0, 0.0, 0.0]), np.linspace(-0.5, 1.1, 9))
    assert told.value.reached == pytest.approx(0.9)


def test_points_that_are_one_or_on_different_pieces_are_refused() -> None:
    here = on_plane(0.1, 0.05)
    with pytest.raises(SurfaceError, match="are one"):
        PLANE.shortest(here, here)
    two = trimesh.util.concatenate([ball(1), ball(1).apply_translation([3.0, 0.0, 0.0])])
    with pytest.raises(SurfaceError, match="no way over the mesh"):
        geodesics_of(two).shortest(np.array([-0.5, 0.0, 0.0]), np.array([3.5, 0.0, 0.0]))


def test_a_mesh_that_is_not_manifold_is_refused() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    with pytest.raises(SurfaceError, match="not manifold"):
        MeshGeodesics(vertices, np.array([[0, 1, 2], [0, 3, 4]]))
