"""Laws of the built surface: accuracy, chord tolerance, orientation, seams, equivariance."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.errors import SettingsError, SurfaceError
from georibbon.geometry.closest import closest_point
from georibbon.geometry.frames import Strip, arc_angles
from georibbon.geometry.geodesics import directions_at, geodesics
from georibbon.geometry.mesh import (
    Mesh,
    area,
    boundary_edges,
    facets,
    is_oriented,
    is_watertight,
    volume,
)
from georibbon.geometry.reference import (
    Bonnet,
    Cylinder,
    Ellipsoid,
    ReferenceSurface,
    Saddle,
    Torus,
)
from georibbon.geometry.surface import Surface, SurfaceSettings, build_surface
from passes import moved, passes, plane_passes, sphere_passes, upside_down


def built(strips: Sequence[Strip], tolerance: float = 5e-5, **more: object) -> Surface:
    names = [f"P{k + 1}" for k in range(len(strips))]
    thickness = more.pop("thickness", None)
    return build_surface(strips, names, SurfaceSettings(tolerance, thickness), **more)


def rows_of(gap: float, count: int) -> list[tuple[float, float]]:
    return [(0.0, gap * (k - 0.5 * (count - 1))) for k in range(count)]


def distances(surface: ReferenceSurface, points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(closest_point(surface, points).points - points, axis=1)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def inside_points(mesh: Mesh) -> np.ndarray:
    """Middles of all triangles and of all their edges."""
    corners = mesh.vertices[mesh.triangles]
    middles = [0.5 * (corners[:, k] + corners[:, (k + 1) % 3]) for k in range(3)]
    return np.concatenate([corners.mean(axis=1), *middles])


@pytest.mark.parametrize(
    ("surface", "limit"), [(Saddle(), 1.1e-6), (Bonnet(), 1e-6), (Torus(0.5, 0.2), 4e-5)]
)
def test_the_surface_meets_the_truth(surface: ReferenceSurface, limit: float) -> None:
    gap = 0.45 if isinstance(surface, Torus) else 0.1
    strips = passes(surface, rows_of(gap, 5), length=0.4 if gap > 0.4 else 0.96)
    mesh = built(strips, 2e-4).mesh
    assert rms(distances(surface, mesh.vertices)) < limit


def solid_angle(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """The area of a triangle of great arcs on the unit sphere (Van Oosterom and Strackee)."""
    return 2.0 * float(np.arctan2(abs(a @ np.cross(b, c)), 1.0 + a @ b + b @ c + c @ a))


def test_the_surface_between_great_circles_is_the_sphere_with_its_area() -> None:
    radius = 0.6
    surface = built(sphere_passes())
    assert np.abs(np.linalg.norm(surface.mesh.vertices, axis=1) - radius).max() < 1e-9
    assert np.degrees(arc_angles(surface.mesh.normals, surface.mesh.vertices)).max() < 1e-4
    corners = np.stack([strip.points[[0, -1]] for strip in sphere_passes()]) / radius
    exact = radius**2 * sum(
        solid_angle(a[0], a[1], b[1]) + solid_angle(a[0], b[1], b[0]) for a, b in pairwise(corners)
    )
    assert surface.area == pytest.approx(exact, rel=2e-4)


def test_between_rings_around_a_cylinder_the_rulings_are_exact() -> None:
    cylinder = Cylinder()
    mesh = built(passes(cylinder, rows_of(0.1, 3)), 2e-4).mesh
    assert distances(cylinder, mesh.vertices).max() < 1e-8


def test_the_error_falls_with_the_third_order_of_the_gap_or_faster() -> None:
    surface = Saddle()
    errors = [
        rms(distances(surface, built(passes(surface, rows_of(gap, 3)), 5e-4).mesh.vertices))
        for gap in (0.2, 0.1)
    ]
    assert errors[0] / errors[1] > 8.0


def shaped(shape: str) -> tuple[ReferenceSurface, list[Strip]]:
    """A surface and passes on it."""
    if shape == "bonnet":
        return Bonnet(), passes(Bonnet(), rows_of(0.1, 3), length=0.6)
    if shape == "elbow":
        elbow = Torus(0.5, 0.2, upright=True)
        return elbow, passes(elbow, rows_of(0.3, 3), length=0.6)
    if shape == "fan":
        return Saddle(), passes(Saddle(), rows_of(0.1, 3), [0.0, 0.06, -0.06], length=0.6)
    return twisted_by_rulings(0.4)


def twisted_by_rulings(radius: float) -> tuple[ReferenceSurface, list[Strip]]:
    """Passes on the straight lines x - y = const of z = (x² - y²) / 2r: twist alone."""
    x = np.array([-0.05, 0.0, 0.05])
    lean = (x / radius) ** 2
    angles = 0.5 * np.arccos(lean / (1.0 + lean))
    surface = Saddle(radius, radius)
    return surface, passes(surface, list(zip(x, -x, strict=True)), angles, length=0.6)


@pytest.mark.parametrize("tolerance", [2e-4, 5e-5, 2e-5])
@pytest.mark.parametrize("shape", ["bonnet", "elbow", "fan", "rulings"])
def test_triangles_stay_within_the_tolerance_of_the_patches(shape: str, tolerance: float) -> None:
    """And, where their edges are not bounded by 2 cm, nearly reach it: none is wasted."""
    surface, strips = shaped(shape)
    mesh = built(strips, tolerance).mesh
    away = distances(surface, inside_points(mesh)[::5])
    patches_own = 2e-6
    assert away.max() < tolerance + patches_own
    assert tolerance > 1e-4 or away.max() > 0.15 * tolerance


@pytest.mark.parametrize("tolerance", [1e-4, 5e-5, 1e-5])
def test_triangles_on_a_sphere_stay_within_the_tolerance(tolerance: float) -> None:
    mesh = built(sphere_passes(), tolerance).mesh
    away = np.abs(np.linalg.norm(inside_points(mesh), axis=1) - 0.6).max()
    assert 0.4 * tolerance < away < tolerance


def test_a_plane_needs_few_triangles_yet_none_longer_than_asked() -> None:
    mesh = built(plane_passes(0.0, 0.1)).mesh
    edges = mesh.vertices[mesh.triangles] - mesh.vertices[np.roll(mesh.triangles, 1, axis=1)]
    assert len(mesh.triangles) < 1000
    assert np.linalg.norm(edges, axis=2).max() < 0.0285


@pytest.mark.parametrize("turn", ["none", "some", "all", "over"])
def test_triangles_and_normals_face_outward_however_passes_are_given(turn: str) -> None:
    strips = sphere_passes(shifts=[0.0, 0.03, -0.02, 0.0, 0.05])
    if turn in {"some", "over"}:
        strips = [s.reversed() if k % 2 else s for k, s in enumerate(strips)]
    if turn == "all":
        strips = [s.reversed() for s in strips][::-1]
    if turn == "over":
        strips[3] = upside_down(strips[3])
    mesh = built([strips[k] for k in (3, 0, 4, 1, 2)]).mesh
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    assert (np.sum(facets(mesh) * middles, axis=1) > 0.0).all()
    assert (np.sum(mesh.normals * mesh.vertices, axis=1) > 0.59).all()
    assert is_oriented(mesh)


def test_seams_have_no_double_vertices_and_no_gaps() -> None:
    surface = built(sphere_passes())
    mesh = surface.mesh
    assert len(np.unique(np.round(mesh.vertices, 9), axis=0)) == len(mesh.vertices)
    rows, columns = surface.shape
    assert len(boundary_edges(mesh)) == 2 * (rows - 1) + 2 * (columns - 1)
    assert len(mesh.vertices) == rows * columns


def test_the_passes_are_lines_of_the_mesh_with_their_own_normals() -> None:
    strips = sphere_passes(shifts=[0.0, 0.03, -0.02, 0.0, 0.05])
    surface = built(strips)
    grid = surface.mesh.vertices.reshape(*surface.shape, 3)
    normals = surface.mesh.normals.reshape(*surface.shape, 3)
    for name, column in zip(surface.order, surface.columns, strict=True):
        strip = strips[int(name[1:]) - 1]
        assert np.allclose(grid[[0, -1], column], strip.points[[0, -1]], atol=1e-9)
        plane = np.cross(strip.points[0], strip.points[-1])
        assert np.abs(grid[:, column] @ plane).max() < 1e-9
        assert np.allclose(normals[:, column], grid[:, column] / 0.6, atol=1e-8)


def test_the_surface_moves_with_its_passes() -> None:
    strips = passes(
        Bonnet(), rows_of(0.1, 4), [0.0, 0.05, 0.0, -0.04], shifts=[0.0, 0.05, 0.0, 0.0]
    )
    turn, shift = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix(), np.array([5.0, -2.0, 1.0])
    plain = built(strips)
    other = built([moved(strip, turn, shift) for strip in strips])
    assert other.shape == plain.shape
    assert np.allclose(other.mesh.vertices, plain.mesh.vertices @ turn.T + shift, atol=1e-9)
    assert np.allclose(other.mesh.normals, plain.mesh.normals @ turn.T, atol=1e-7)
    for a, b in zip(plain.checks, other.checks, strict=True):
        assert (a.code, a.where, a.verdict) == (b.code, b.where, b.verdict)


def test_the_order_in_which_passes_are_given_does_not_matter() -> None:
    strips = passes(Bonnet(), rows_of(0.1, 4))
    plain = built(strips)
    names = ["P3", "P1", "P4", "P2"]
    other = build_surface([strips[k] for k in (2, 0, 3, 1)], names, SurfaceSettings())
    assert other.area == pytest.approx(plain.area, rel=1e-9)
    assert other.order in {plain.order, plain.order[::-1]}


def test_passes_run_backwards_give_the_same_surface() -> None:
    strips = passes(Saddle(), rows_of(0.1, 3), shifts=[0.0, 0.04, 0.0])
    plain = built(strips)
    back = built([strip.reversed() for strip in strips])
    assert back.area == pytest.approx(plain.area, rel=1e-5)
    assert distances(Saddle(), back.mesh.vertices).max() < 2e-5


def test_the_passes_sigma_is_carried_to_the_vertices() -> None:
    strips = sphere_passes([0.0, 0.1, 0.2])
    ramp = np.linspace(1e-3, 3e-3, 97)
    sigmas = [ramp, ramp[::-1], np.full(97, 1e-3)]
    given = [strips[0], strips[1].reversed(), strips[2]]
    surface = built(given, sigmas=sigmas)
    assert surface.mesh.sigma is not None
    sigma = surface.mesh.sigma.reshape(surface.shape)
    for name, column in zip(surface.order, surface.columns, strict=True):
        expected = (1e-3, 1e-3) if name == "P3" else (1e-3, 3e-3)
        assert np.allclose(sigma[[0, -1], column], expected)
    assert sigma.min() >= 1e-3 - 1e-12
    assert sigma.max() <= 3e-3 + 1e-12
    between = sigma[-1, (surface.columns[-1] + surface.columns[-2]) // 2]
    assert 1.0e-3 < between < 3.0e-3


def test_without_sigma_the_mesh_has_none() -> None:
    surface = built(sphere_passes([0.0, 0.1]))
    assert surface.mesh.sigma is None
    assert surface.solid is None
    assert surface.export_mesh is surface.mesh


def test_a_thickened_surface_is_a_closed_solid_of_the_right_volume() -> None:
    surface = built(sphere_passes(), thickness=0.005)
    assert surface.solid is not None
    assert surface.export_mesh is surface.solid
    assert is_watertight(surface.solid)
    shrunk = (1.0 - (1.0 - 0.005 / 0.6) ** 3) * 0.6 / 3.0
    assert volume(surface.solid) == pytest.approx(surface.area * shrunk, rel=1e-3)
    assert surface.area == pytest.approx(area(surface.mesh))


def test_a_wall_thicker_than_the_surface_bends_is_refused() -> None:
    with pytest.raises(SurfaceError, match="choose a smaller thickness"):
        built(sphere_passes([0.0, 0.05], 0.2, length=0.3), thickness=0.25)


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_passes_are_refused(count: int) -> None:
    with pytest.raises(SurfaceError, match="at least 2 are needed"):
        built(sphere_passes()[:count])


def test_a_pass_of_too_few_points_is_refused_by_name() -> None:
    with pytest.raises(SurfaceError, match="pass P2 has 3 points, at least 4"):
        built([*plane_passes(0.0), *plane_passes(0.1, nodes=3)])


@pytest.mark.parametrize("part", ["s", "points", "frames"])
def test_a_pass_with_what_is_no_number_is_refused_by_name(part: str) -> None:
    strips = plane_passes(0.0, 0.1)
    parts = {"s": strips[1].s, "points": strips[1].points, "frames": strips[1].frames}
    spoiled = parts[part].copy()
    spoiled[5] = np.nan
    with pytest.raises(SurfaceError, match="pass P2 has points or normals that are not numbers"):
        built([strips[0], Strip(**{**parts, part: spoiled})])


def test_a_pass_whose_places_do_not_ascend_is_refused_by_name() -> None:
    strips = plane_passes(0.0, 0.1)
    wrong = Strip(strips[0].s[::-1], strips[0].points, strips[0].frames)
    with pytest.raises(SurfaceError, match="pass P1 has places along the ribbon"):
        built([wrong, strips[1]])


def test_a_pass_whose_frames_are_none_is_refused_by_name() -> None:
    strips = plane_passes(0.0, 0.1)
    wrong = Strip(strips[1].s, strips[1].points, 0.9 * strips[1].frames)
    with pytest.raises(SurfaceError, match="pass P2 has frames that are not three unit vectors"):
        built([strips[0], wrong])


@pytest.mark.parametrize("angle", [1.0, 5.0, 20.0])
def test_passes_that_begin_at_one_mark_span_a_surface_within_the_tolerance(angle: float) -> None:
    ball = Ellipsoid()
    turns = np.radians([-angle, angle])
    directions = directions_at(ball, np.zeros((2, 2)), turns)
    fan = list(geodesics(ball, np.zeros((2, 2)), directions, np.linspace(0.0, 0.6, 121)))
    surface = built(fan, 5e-5)
    corners = surface.mesh.vertices[surface.mesh.triangles]
    middles = np.concatenate([corners.mean(axis=1), 0.5 * (corners + np.roll(corners, 1, 1))[:, 0]])
    assert np.abs(np.linalg.norm(middles, axis=1) - 0.6).max() < 5e-5
    assert len(surface.mesh.triangles) < 20_000
    assert {check.code for check in surface.checks if check.verdict != "pass"} == {"pinch"}


def test_a_large_object_has_edges_in_proportion() -> None:
    strips = plane_passes(*(5.0 * k for k in range(5)), length=50.0)
    surface = built(strips)
    assert surface.area == pytest.approx(50.0 * 20.0)
    assert len(surface.mesh.triangles) < 500_000


def test_passes_that_lie_on_each_other_are_refused() -> None:
    with pytest.raises(SurfaceError, match="lie on each other"):
        built(plane_passes(0.0, 0.0005, 0.0))


def test_more_triangles_than_anyone_can_use_are_refused() -> None:
    with pytest.raises(SurfaceError, match="choose a larger tolerance"):
        built(sphere_passes(), 1e-8)


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ({"tolerance": 0.0}, "tolerance"),
        ({"tolerance": np.nan}, "tolerance"),
        ({"thickness": -1e-3}, "thickness"),
        ({"thickness": np.inf}, "thickness"),
    ],
)
def test_settings_that_mean_nothing_are_refused(settings: dict[str, float], name: str) -> None:
    with pytest.raises(SettingsError, match=f"the surface's {name} is"):
        SurfaceSettings(**settings)
