"""Closed forms of geodesics: they are those that are integrated, and obey the printed laws."""

import numpy as np
import pytest

from georibbon.errors import SurfaceError
from georibbon.geometry.closed_geodesics import (
    clairaut,
    cone_curvatures,
    cone_distances,
    cone_geodesic,
    sphere_geodesic,
)
from georibbon.geometry.frames import Strip, curvatures
from georibbon.geometry.geodesics import directions_at, geodesic
from georibbon.geometry.reference import Cone, Ellipsoid, Torus

Z = np.array([0.0, 0.0, 1.0])
S = np.linspace(-0.5, 0.7, 241)
every_cone = pytest.mark.parametrize("half_angle", [20.0, 30.0, 45.0, 60.0, 85.0])


def in_plane_bend(strip: Strip) -> np.ndarray:
    """Geodesic curvature by central differences of the fourth order."""
    h, x = strip.s[1], strip.points
    second = (-x[:-4] + 16 * x[1:-3] - 30 * x[2:-2] + 16 * x[3:-1] - x[4:]) / (12 * h**2)
    return np.einsum("ij,ij->i", second, strip.conormals[2:-2])


@every_cone
def test_a_cones_closed_form_is_the_geodesic_that_is_integrated(half_angle: float) -> None:
    cone, nearest, azimuth = Cone(half_angle), 0.3, 0.4
    strip = cone_geodesic(cone, nearest, azimuth, S)
    slant = nearest / np.sin(np.radians(half_angle))
    start = np.array([[azimuth, slant]])
    ahead = directions_at(cone, start, np.zeros(1))[0]
    integrated = geodesic(cone, start[0], ahead, S)
    np.testing.assert_allclose(strip.points, integrated.points, atol=1e-9)
    np.testing.assert_allclose(strip.frames, integrated.frames, atol=1e-8)
    np.testing.assert_allclose(strip.s, integrated.s, atol=1e-15)


@every_cone
def test_a_cones_geodesic_does_not_bend_in_its_surface(half_angle: float) -> None:
    strip = cone_geodesic(Cone(half_angle), 0.3, 0.4, S)
    np.testing.assert_allclose(in_plane_bend(strip), 0.0, atol=2e-6)


def test_read_as_printed_the_curve_on_the_cone_is_no_geodesic() -> None:
    """u0 / cos((v - v0) sin a) (cos v, sin v, A): A = 1 / tan a, neither atan a nor tan a."""
    a, v = np.radians(30.0), np.linspace(-0.8, 0.8, 401)
    radius = 0.3 / np.cos(v * np.sin(a))

    def bend(slope: float) -> float:
        points = np.stack([radius * np.cos(v), radius * np.sin(v), radius * slope], axis=1)
        first = np.gradient(points, v, axis=0, edge_order=2)
        second = np.gradient(first, v, axis=0, edge_order=2)
        outwards = np.stack([slope * np.cos(v), slope * np.sin(v), -np.ones_like(v)], axis=1)
        normal = outwards / np.hypot(slope, 1.0)
        volume = np.einsum("ij,ij->i", np.cross(first, second), normal)
        return float(np.abs(volume / np.linalg.norm(first, axis=1) ** 3)[5:-5].max())

    assert bend(1 / np.tan(a)) < 1e-3
    assert bend(np.arctan(a)) > 0.5
    assert bend(np.tan(a)) > 0.5


@every_cone
def test_normal_curvature_and_torsion_of_a_cones_geodesic(half_angle: float) -> None:
    cone, s = Cone(half_angle), np.linspace(-0.4, 0.6, 2001)
    bending, torsion = curvatures(cone_geodesic(cone, 0.3, 1.0, s))
    normal, twist = cone_curvatures(cone, 0.3, s)
    np.testing.assert_allclose(bending[1:-1], normal[1:-1], atol=3e-6)
    np.testing.assert_allclose(torsion[1:-1], twist[1:-1], atol=3e-6)


@every_cone
def test_the_distance_to_the_axis_is_least_at_its_point_and_is_clairauts_constant(
    half_angle: float,
) -> None:
    strip = cone_geodesic(Cone(half_angle), 0.3, -2.0, S)
    distance = np.hypot(*strip.points[:, :2].T)
    assert distance.min() >= 0.3 - 1e-15
    np.testing.assert_allclose(distance[S.searchsorted(0.0)], 0.3, atol=1e-4)
    # The cone's azimuth runs clockwise seen from above.
    np.testing.assert_allclose(clairaut(strip, Z), -0.3, atol=1e-12)


@every_cone
def test_distances_to_azimuths(half_angle: float) -> None:
    cone, angles = Cone(half_angle), np.array([-0.9, -0.2, 0.0, 1.1])
    strip = cone_geodesic(cone, 0.3, 0.4, cone_distances(cone, 0.3, angles))
    azimuth = np.arctan2(-strip.points[:, 1], strip.points[:, 0])
    np.testing.assert_allclose(azimuth, 0.4 + angles, atol=1e-12)


def test_level_geodesics_of_a_cone_match_by_meridians_where_they_match_by_length() -> None:
    cone, ends = Cone(30.0), np.array([-0.7, 1.2])
    rows = []
    for nearest in (0.3, 0.39):
        s = np.linspace(*cone_distances(cone, nearest, ends), 60)
        points = cone_geodesic(cone, nearest, 0.0, s).points
        rows.append(np.arctan2(-points[:, 1], points[:, 0]))
    np.testing.assert_allclose(rows[0], rows[1], atol=1e-12)


def test_a_geodesic_that_crosses_itself_is_refused_and_up_to_there_it_is_not() -> None:
    cone = Cone(20.0)
    limit = cone_distances(cone, 0.1, np.array([np.pi]))[0]
    with pytest.raises(SurfaceError, match="crosses itself 0\\.540 m before and beyond"):
        cone_geodesic(cone, 0.1, 0.0, np.linspace(-limit - 0.001, limit + 0.001, 50))
    whole = cone_geodesic(cone, 0.1, 0.0, np.array([-limit, 0.0, limit - 1e-9]))
    np.testing.assert_allclose(whole.points[0], whole.points[2], atol=1e-8)
    one_sided = cone_geodesic(cone, 0.1, 0.0, np.linspace(0.0, 3 * limit, 50))
    assert len(one_sided.s) == 50


def test_blunt_cones_geodesics_never_cross_themselves() -> None:
    s = np.linspace(-50.0, 50.0, 2001)
    azimuth = np.unwrap(np.arctan2(*cone_geodesic(Cone(31.0), 0.1, 0.0, s).points[:, 1::-1].T))
    assert np.ptp(azimuth) < 2 * np.pi


@pytest.mark.parametrize("nearest", [0.0, -0.1, np.nan, np.inf])
def test_a_distance_from_the_axis_that_means_nothing_is_refused(nearest: float) -> None:
    with pytest.raises(SurfaceError, match="give a distance above zero"):
        cone_geodesic(Cone(30.0), nearest, 0.0, S)


def test_azimuths_that_a_geodesic_never_reaches_are_refused() -> None:
    with pytest.raises(SurfaceError, match=r"turns by 127\.3° .* and 130\.0° are asked for"):
        cone_distances(Cone(45.0), 0.3, np.radians([0.0, -130.0]))


def test_a_spheres_closed_form_is_the_geodesic_that_is_integrated() -> None:
    sphere, start = Ellipsoid(0.5, 0.5, 0.5), np.array([[0.2, 0.3]])
    point, ahead = sphere.points(start)[0], directions_at(sphere, start, np.array([0.9]))[0]
    strip = sphere_geodesic(0.5, point, 3.0 * ahead, S)
    integrated = geodesic(sphere, start[0], ahead, S)
    np.testing.assert_allclose(strip.points, integrated.points, atol=1e-9)
    np.testing.assert_allclose(strip.frames, integrated.frames, atol=1e-8)


def test_a_great_circle_bends_evenly_and_does_not_twist() -> None:
    strip = sphere_geodesic(0.5, np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.0, 0.2]), S)
    bending, torsion = curvatures(strip)
    np.testing.assert_allclose(bending, -2.0, atol=1e-10)
    np.testing.assert_allclose(torsion, 0.0, atol=1e-10)
    np.testing.assert_allclose(in_plane_bend(strip), 0.0, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(strip.points, axis=1), 0.5, atol=1e-15)


def test_a_great_circle_closes_after_its_length_and_no_more_is_given() -> None:
    once = np.linspace(0.0, 2 * np.pi * 0.5, 9)
    point, ahead = np.array([0.5, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    strip = sphere_geodesic(0.5, point, ahead, once)
    np.testing.assert_allclose(strip.points[0], strip.points[-1], atol=1e-15)
    with pytest.raises(SurfaceError, match=r"3\.142 m long, and 3\.299 m are asked for"):
        sphere_geodesic(0.5, point, ahead, 1.05 * once)


@pytest.mark.parametrize("direction", [[2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
def test_a_direction_off_the_sphere_is_refused(direction: list[float]) -> None:
    with pytest.raises(SurfaceError, match="stands upright"):
        sphere_geodesic(0.5, np.array([0.5, 0.0, 0.0]), np.array(direction), S)


@pytest.mark.parametrize("angle", [0.3, 1.2, -2.5])
def test_clairauts_constant_is_that_of_other_surfaces_of_revolution_too(angle: float) -> None:
    torus, start = Torus(0.6, 0.25), np.array([[0.3, 0.4]])
    ahead = directions_at(torus, start, np.array([angle]))[0]
    constant = clairaut(geodesic(torus, start[0], ahead, S), Z)
    radius = np.hypot(*torus.points(start)[0, :2])
    np.testing.assert_allclose(constant, radius * np.cos(angle), atol=1e-9)


def test_clairauts_constant_tells_what_is_no_geodesic() -> None:
    strip = sphere_geodesic(0.5, np.array([1.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), S)
    turned = Strip(strip.s, strip.points, np.roll(strip.frames, 40, axis=0))
    assert np.ptp(clairaut(strip, Z)) < 1e-14
    assert np.ptp(clairaut(turned, Z)) > 0.1
