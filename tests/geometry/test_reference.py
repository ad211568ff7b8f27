"""Reference surfaces: their derivatives, normals and closest points obey their laws."""

import numpy as np
import pytest

from georibbon.geometry.closest import closest_point
from georibbon.geometry.reference import (
    Bonnet,
    BSplineSurface,
    Cone,
    Cylinder,
    Ellipsoid,
    Hull,
    Plane,
    ReferenceSurface,
    Saddle,
    Seat,
    Torus,
)

NET = np.stack(
    [
        *np.meshgrid(np.linspace(-1, 1, 7), np.linspace(-1, 1, 8), indexing="ij"),
        0.1 * np.random.default_rng(5).standard_normal((7, 8)),
    ],
    axis=2,
)
SURFACES: dict[str, ReferenceSurface] = {
    "plane": Plane(30.0),
    "ellipsoid": Ellipsoid(0.7, 0.6, 0.4),
    "cone": Cone(35.0),
    "torus": Torus(0.6, 0.25),
    "elbow": Torus(0.6, 0.25, upright=True),
    "cylinder": Cylinder(0.5),
    "wall": Cylinder(0.5, upright=True),
    "saddle": Saddle(),
    "bonnet": Bonnet(),
    "seat": Seat(),
    "hull": Hull(),
    "spline": BSplineSurface(NET),
}
every_surface = pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES.keys())


def inside(surface, n=150, seed=1):
    """n random parameters well within the surface's box."""
    lower, upper = np.array(surface.lower), np.array(surface.upper)
    share = 0.15 + 0.7 * np.random.default_rng(seed).random((n, 2))
    return lower + (upper - lower) * share


def dot(a, b):
    return np.einsum("ij,ij->i", a, b)


@every_surface
@pytest.mark.parametrize("axis", [0, 1])
def test_derivatives_are_those_of_the_points(surface, axis):
    uv, h = inside(surface), 1e-5
    step = h * np.eye(2)[axis]
    ahead, behind, here = surface.jet(uv + step), surface.jet(uv - step), surface.jet(uv)
    first = (here.pu, here.pv)[axis]
    second = ((here.puu, here.puv), (here.puv, here.pvv))[axis]
    np.testing.assert_allclose((ahead.p - behind.p) / (2 * h), first, atol=2e-8)
    np.testing.assert_allclose((ahead.pu - behind.pu) / (2 * h), second[0], atol=2e-7)
    np.testing.assert_allclose((ahead.pv - behind.pv) / (2 * h), second[1], atol=2e-7)


@every_surface
def test_normals_are_unit_and_square_to_the_surface(surface):
    jet = surface.jet(inside(surface))
    normals = jet.normals
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(dot(normals, jet.pu), 0.0, atol=1e-12)
    np.testing.assert_allclose(dot(normals, jet.pv), 0.0, atol=1e-12)
    np.testing.assert_array_equal(surface.normals(inside(surface)), normals)


def ring_height(p, major, axis):
    ring = np.hypot(*(p[:, i] for i in range(3) if i != axis))
    return np.hypot(ring - major, p[:, axis])


IMPLICIT = {
    "ellipsoid": lambda p: np.linalg.norm(p / [0.7, 0.6, 0.4], axis=1),
    "cone": lambda p: np.hypot(p[:, 0], p[:, 1]) + np.tan(np.radians(35.0)) * p[:, 2],
    "torus": lambda p: ring_height(p, 0.6, 2),
    "elbow": lambda p: ring_height(p, 0.6, 1),
    "cylinder": lambda p: np.hypot(p[:, 0], p[:, 2]),
    "wall": lambda p: np.hypot(p[:, 0], p[:, 1]),
    "plane": lambda p: p[:, 2] * np.cos(np.pi / 6) - p[:, 1] * np.sin(np.pi / 6),
}
LEVELS = {
    "ellipsoid": 1.0,
    "cone": 0.0,
    "torus": 0.25,
    "elbow": 0.25,
    "cylinder": 0.5,
    "wall": 0.5,
    "plane": 0.0,
}


@pytest.mark.parametrize("name", IMPLICIT)
def test_points_lie_on_the_implicit_surface_and_normals_point_out_of_it(name):
    surface = SURFACES[name]
    uv = inside(surface)
    points, normals = surface.points(uv), surface.normals(uv)
    np.testing.assert_allclose(IMPLICIT[name](points), LEVELS[name], atol=1e-12)
    assert (IMPLICIT[name](points + 1e-4 * normals) > LEVELS[name]).all()


@pytest.mark.parametrize("name", ["saddle", "bonnet", "seat", "spline"])
def test_heights_have_their_outside_above(name):
    assert (SURFACES[name].normals(inside(SURFACES[name]))[:, 2] > 0).all()


def test_the_hulls_outside_is_away_from_its_middle_line():
    uv = inside(SURFACES["hull"])
    points = SURFACES["hull"].points(uv)
    assert (dot(points * [0, 1, 1], SURFACES["hull"].normals(uv)) > 0).all()


def test_the_elbows_u_begins_at_its_lowest_point_on_the_outside_of_the_bend():
    elbow = SURFACES["elbow"]
    np.testing.assert_allclose(elbow.points(np.zeros((1, 2))), [[0, 0, -0.85]], atol=1e-15)
    np.testing.assert_allclose(elbow.normals(np.zeros((1, 2))), [[0, 0, -1]], atol=1e-15)


def test_a_sphere_has_the_curvature_of_its_radius_in_every_direction():
    jet = Ellipsoid(0.5, 0.5, 0.5).jet(inside(Ellipsoid()))
    for second, a, b in [
        (jet.puu, jet.pu, jet.pu),
        (jet.puv, jet.pu, jet.pv),
        (jet.pvv,) + 2 * (jet.pv,),
    ]:
        np.testing.assert_allclose(dot(second, jet.normals), -dot(a, b) / 0.5, atol=1e-12)


def test_a_bonnet_has_inflections():
    x = np.linspace(-0.5, 0.5, 101)
    bend = Bonnet().height(x, np.zeros_like(x)).zxx
    assert (np.diff(np.sign(bend)) != 0).sum() >= 2


def test_a_spline_is_moved_and_turned_with_its_net():
    uv = inside(SURFACES["spline"])
    turn = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))[0]
    moved = BSplineSurface(NET @ turn.T + [1.0, 2.0, 3.0])
    expected = SURFACES["spline"].points(uv) @ turn.T + [1.0, 2.0, 3.0]
    np.testing.assert_allclose(moved.points(uv), expected, atol=1e-14)


def test_a_spline_reproduces_a_plane():
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    flat = BSplineSurface(np.stack([x, y, 0.3 * x - 0.2 * y], axis=2))
    jet = flat.jet(inside(flat))
    np.testing.assert_allclose(jet.p[:, 2], 0.3 * jet.p[:, 0] - 0.2 * jet.p[:, 1], atol=1e-14)
    np.testing.assert_allclose(jet.puu, 0.0, atol=1e-13)


def test_a_spline_is_twice_differentiable_across_its_knots():
    knots = np.array([[2.0, 1.3], [1.4, 3.0], [2.0, 2.0]])
    before = SURFACES["spline"].jet(knots - 1e-12)
    for one, other in zip(before, SURFACES["spline"].jet(knots + 1e-12), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-10)


@every_surface
@pytest.mark.parametrize("distance", [0.03, -0.03])
def test_the_closest_point_to_a_point_on_a_normal_is_its_foot(surface, distance):
    uv = inside(surface)
    feet = surface.points(uv)
    found = closest_point(surface, feet + distance * surface.normals(uv), grid=60)
    np.testing.assert_allclose(found.points, feet, atol=1e-9)
    np.testing.assert_allclose(found.distance, distance, atol=1e-12)
    np.testing.assert_allclose(surface.points(found.uv), found.points, atol=1e-14)


@every_surface
def test_the_closest_point_is_idempotent(surface):
    uv = inside(surface)
    points = surface.points(uv) + 0.02 * surface.normals(uv)
    once = closest_point(surface, points, grid=60)
    twice = closest_point(surface, once.points, grid=60)
    np.testing.assert_allclose(twice.points, once.points, atol=1e-12)
    np.testing.assert_allclose(twice.distance, 0.0, atol=1e-12)


@every_surface
def test_the_gap_to_the_closest_point_is_square_to_the_surface_and_least(surface):
    rng = np.random.default_rng(3)
    points = surface.points(inside(surface)) + 0.05 * rng.standard_normal((150, 3))
    found = closest_point(surface, points, grid=60)
    jet, gap = surface.jet(found.uv), points - found.points
    for tangent in (jet.pu, jet.pv):
        sine = dot(tangent, gap) / np.linalg.norm(tangent, axis=1)
        np.testing.assert_allclose(sine, 0.0, atol=1e-9)
    others = surface.points(inside(surface, 400, seed=4))
    brute = np.linalg.norm(points[:, None] - others[None], axis=2).min(axis=1)
    assert (np.abs(found.distance) <= brute + 1e-12).all()


def test_a_sphere_is_found_from_near_its_centre_where_newton_alone_would_fail():
    points = 0.1 * np.random.default_rng(6).standard_normal((200, 3))
    found = closest_point(Ellipsoid(0.5, 0.5, 0.5), points, grid=20)
    np.testing.assert_allclose(found.distance, np.linalg.norm(points, axis=1) - 0.5, atol=1e-9)


def test_few_iterations_give_a_near_answer_and_more_a_nearer_one():
    points = np.array([[0.5, 0.2, 0.4], [-0.3, 0.5, 0.1]])
    exact = np.abs(closest_point(SURFACES["ellipsoid"], points).distance)
    rough = np.abs(closest_point(SURFACES["ellipsoid"], points, grid=12, iterations=1).distance)
    assert (rough > exact).all()
    np.testing.assert_allclose(rough, exact, atol=1e-2)


def test_steps_that_would_move_away_are_shortened():
    flat = Ellipsoid(1.0, 0.2, 0.1)
    points = flat.points(inside(flat)) + 0.05 * np.random.default_rng(7).standard_normal((150, 3))
    found = closest_point(flat, points, grid=4)
    jet, gap = flat.jet(found.uv), points - found.points
    np.testing.assert_allclose(dot(jet.pu, gap), 0.0, atol=1e-9)
    np.testing.assert_allclose(dot(jet.pv, gap), 0.0, atol=1e-9)
    nodes = np.stack(np.meshgrid(*np.linspace(flat.lower, flat.upper, 4).T), axis=2).reshape(-1, 2)
    start = np.linalg.norm(points[:, None] - flat.points(nodes)[None], axis=2).min(axis=1)
    assert (np.abs(found.distance) <= start + 1e-12).all()
