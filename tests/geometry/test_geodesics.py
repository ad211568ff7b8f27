"""Geodesics obey their laws and agree with closed forms and with geographiclib."""

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic

from georibbon.errors import SurfaceError
from georibbon.geometry.geodesics import directions_at, geodesic, geodesics, tangent_rates, trace
from georibbon.geometry.reference import (
    Bonnet,
    BSplineSurface,
    Cone,
    Cylinder,
    Ellipsoid,
    Hull,
    Plane,
    Saddle,
    Seat,
    Torus,
)

NET = np.stack(
    [
        *np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij"),
        0.04 * np.random.default_rng(5).standard_normal((9, 9)),
    ],
    axis=2,
)
CASES = {
    "plane": (Plane(90.0), (0.1, 0.2)),
    "ellipsoid": (Ellipsoid(0.7, 0.6, 0.4), (0.2, 0.3)),
    "cone": (Cone(35.0), (0.3, 0.9)),
    "torus": (Torus(0.6, 0.25), (0.3, 0.4)),
    "elbow": (Torus(0.7, 0.28, upright=True), (0.5, 0.3)),
    "cylinder": (Cylinder(0.5), (0.3, 0.4)),
    "saddle": (Saddle(), (0.1, 0.2)),
    "bonnet": (Bonnet(), (0.1, 0.2)),
    "seat": (Seat(), (0.1, 0.2)),
    "hull": (Hull(), (0.1, 0.2)),
    "spline": (BSplineSurface(NET), (3.2, 2.9)),
}
every_case = pytest.mark.parametrize("name", CASES)
S = np.linspace(-0.4, 0.4, 801)


def run(name, s=S, angle=0.5):
    surface, uv = CASES[name]
    start = np.array([uv])
    direction = directions_at(surface, start, np.array([angle]))
    return trace(surface, start, direction, s)


def derivatives(y, h):
    """First and second derivatives by central differences of the fourth order, ends left out."""
    first = (y[:-4] - 8 * y[1:-3] + 8 * y[3:-1] - y[4:]) / (12 * h)
    second = (-y[:-4] + 16 * y[1:-3] - 30 * y[2:-2] + 16 * y[3:-1] - y[4:]) / (12 * h**2)
    return first, second


@every_case
def test_unit_speed_and_no_geodesic_curvature_by_finite_differences(name):
    strip = run(name)[1][0]
    first, second = derivatives(strip.points, strip.s[1])
    # The spline's third derivatives jump at its knots, where differences lose their order.
    rough, limit = (1e-6, 2e-3) if name == "spline" else (1e-7, 1e-5)
    np.testing.assert_allclose(np.linalg.norm(first, axis=1), 1.0, atol=rough)
    np.testing.assert_allclose(first, strip.tangents[2:-2], atol=rough)
    across = np.einsum("ij,ij->i", second, strip.conormals[2:-2])
    np.testing.assert_allclose(across, 0.0, atol=limit)


@every_case
def test_frames_are_right_handed_and_stand_on_the_surface(name):
    paths, (strip,) = run(name)
    frames = strip.frames
    np.testing.assert_allclose(
        np.swapaxes(frames, 1, 2) @ frames, np.eye(3)[None] + 0 * frames, atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-12)
    surface = CASES[name][0]
    np.testing.assert_allclose(strip.points, surface.points(paths[:, 0]), atol=1e-15)
    np.testing.assert_allclose(strip.normals, surface.normals(paths[:, 0]), atol=1e-15)


@every_case
def test_a_geodesic_run_backwards_is_the_same_curve(name):
    paths, (strip,) = run(name)
    surface = CASES[name][0]
    back = geodesic(surface, paths[-1, 0], -strip.tangents[-1], strip.s)
    np.testing.assert_allclose(back.points, strip.reversed().points, atol=1e-8)
    np.testing.assert_allclose(back.frames, strip.reversed().frames, atol=1e-7)


def test_many_at_once_are_each_alone():
    surface = Ellipsoid(0.7, 0.6, 0.4)
    uv = np.random.default_rng(1).uniform(-0.5, 0.5, (4, 2))
    directions = directions_at(surface, uv, np.array([0.0, 1.0, 2.0, -1.0]))
    together = geodesics(surface, uv, directions, S)
    for strip, start, direction in zip(together, uv, directions, strict=True):
        alone = geodesic(surface, start, direction, S)
        np.testing.assert_allclose(strip.points, alone.points, atol=1e-9)


def test_a_directions_length_does_not_matter():
    surface, uv = CASES["torus"]
    direction = directions_at(surface, np.array([uv]), np.array([0.7]))[0]
    one, three = (geodesic(surface, uv, k * direction, S).points for k in (1.0, 3.0))
    np.testing.assert_allclose(one, three, atol=1e-12)


def test_a_geodesic_may_begin_or_end_at_its_point_or_be_the_point_alone():
    surface, uv = CASES["bonnet"]
    whole = run("bonnet")[1][0]
    after, before, alone = (run("bonnet", s)[1][0] for s in (S[S >= 0], S[S <= 0], np.zeros(1)))
    np.testing.assert_allclose(after.points, whole.points[400:], atol=1e-9)
    np.testing.assert_allclose(before.points, whole.points[:401], atol=1e-9)
    np.testing.assert_allclose(alone.points, surface.points(np.array([uv])), atol=1e-15)
    assert before.s[0] == 0.0


def test_rates_move_along_the_asked_tangent():
    surface, uv = CASES["hull"]
    start = np.array([uv])
    jet = surface.jet(start)
    direction = directions_at(surface, start, np.array([1.1]))
    rates = tangent_rates(jet, direction)
    np.testing.assert_allclose(jet.pu * rates[:, :1] + jet.pv * rates[:, 1:], direction, atol=1e-14)


def test_directions_turn_about_the_normal_from_p_u():
    surface, uv = CASES["saddle"]
    start = np.array([uv, uv])
    along, across = directions_at(surface, start, np.array([0.0, np.pi / 2]))
    jet = surface.jet(start)
    np.testing.assert_allclose(along, jet.pu[0] / np.linalg.norm(jet.pu[0]), atol=1e-15)
    np.testing.assert_allclose(np.cross(along, across), jet.normals[0], atol=1e-15)


def test_on_a_plane_it_is_straight():
    strip = run("plane")[1][0]
    line = strip.points[0] + strip.s[:, None] * strip.tangents[0]
    np.testing.assert_allclose(strip.points, line, atol=1e-12)


def test_on_a_sphere_it_is_a_great_circle():
    sphere = Ellipsoid(0.5, 0.5, 0.5)
    start = np.array([[0.2, 0.3]])
    p, t = sphere.points(start)[0], directions_at(sphere, start, np.array([0.9]))[0]
    strip = geodesic(sphere, start[0], t, S)
    angle = S[:, None] / 0.5
    np.testing.assert_allclose(strip.points, p * np.cos(angle) + 0.5 * t * np.sin(angle), atol=1e-9)


def test_on_a_cylinder_it_is_a_helix():
    angle = 0.6
    strip = geodesic(Cylinder(0.5), (0.0, 0.0), (np.cos(angle), np.sin(angle), 0.0), S)
    turn = S * np.cos(angle) / 0.5
    helix = np.stack([0.5 * np.sin(turn), S * np.sin(angle), 0.5 * np.cos(turn)], axis=1)
    np.testing.assert_allclose(strip.points, helix, atol=1e-10)


def test_on_a_cone_it_is_a_straight_line_when_unrolled():
    """Slant rho = hypot(rho0, s), azimuth atan(s / rho0) / sin a, from the closest point on."""
    half, rho0 = np.radians(35.0), 0.6
    strip = geodesic(Cone(35.0), (0.0, rho0), (0.0, -1.0, 0.0), S)
    rho, turn = np.hypot(rho0, S), np.arctan(S / rho0) / np.sin(half)
    radius = rho * np.sin(half)
    line = [radius * np.cos(turn), -radius * np.sin(turn), -rho * np.cos(half)]
    np.testing.assert_allclose(strip.points, np.stack(line, axis=1), atol=1e-10)


@pytest.mark.parametrize(("name", "axis"), [("torus", 2), ("elbow", 1), ("cone", 2)])
@pytest.mark.parametrize("angle", [0.2, 1.2, -2.5])
def test_clairaut(name, axis, angle):
    """On a surface of revolution radius times the sine of the angle to the meridian is constant."""
    strip = run(name, np.linspace(-0.3, 0.9, 500), angle)[1][0]
    others = [i for i in range(3) if i != axis]
    (x, y), (tx, ty) = strip.points[:, others].T, strip.tangents[:, others].T
    momentum = x * ty - y * tx
    np.testing.assert_allclose(momentum, momentum[0], atol=1e-9)


@pytest.mark.parametrize("azimuth", [0.0, 37.0, 90.0, 215.0])
@pytest.mark.parametrize("latitude", [-20.0, 0.0, 35.0])
def test_geographiclib_on_an_oblate_ellipsoid(azimuth, latitude):
    a, f = 0.7, 0.1
    surface = Ellipsoid(a, a * (1 - f), a)
    start = np.array([[0.3, np.arctan((1 - f) * np.tan(np.radians(latitude)))]])
    direction = directions_at(surface, start, np.radians([90.0 - azimuth]))
    s = np.linspace(0.0, 0.8, 9)
    found = geodesic(surface, start[0], direction[0], s)
    for point, distance in zip(found.points, s, strict=True):
        there = Geodesic(a, f).Direct(latitude, np.degrees(0.3), azimuth, distance)
        beta = np.arctan((1 - f) * np.tan(np.radians(there["lat2"])))
        expected = surface.points(np.array([[np.radians(there["lon2"]), beta]]))[0]
        np.testing.assert_allclose(point, expected, atol=1e-9)


def test_a_tighter_tolerance_comes_nearer_to_the_closed_form():
    sphere = Ellipsoid(0.5, 0.5, 0.5)
    s = np.linspace(0.0, 1.5, 40)
    circle = 0.5 * np.stack([np.sin(s / 0.5), 0 * s, np.cos(s / 0.5)], axis=1)
    start, direction = np.array([[0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    turned = Ellipsoid(0.5, 0.5, 0.5)
    angle = np.array([0.8])
    tilted = directions_at(turned, start, angle)
    exact = 0.5 * (np.cos(s / 0.5)[:, None] * [[0, 0, 1]] + np.sin(s / 0.5)[:, None] * tilted)
    errors = [
        np.abs(geodesics(sphere, start, tilted, s, tolerance)[0].points - exact).max()
        for tolerance in (1e-4, 1e-7, 1e-11)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-9
    along = geodesics(sphere, start, direction, s)[0].points
    np.testing.assert_allclose(along, circle, atol=1e-10)


def test_where_geodesics_cannot_be_followed_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Just beside an ellipsoid's pole its parameters turn faster than any step can follow."""
    monkeypatch.setattr("georibbon.geometry.geodesics.MOST_EVALUATIONS", 2000)
    s = np.linspace(0.0, 3.0, 5)
    with pytest.raises(SurfaceError, match="cannot be followed beyond 0\\.7"):
        geodesic(Ellipsoid(0.5, 0.5, 0.5), (0.0, 0.0), (1e-12, 1.0, 0.0), s)
