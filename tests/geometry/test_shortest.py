"""Geodesics between two points: they are geodesics and short; the chain is of second order."""

from itertools import pairwise

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from scipy.interpolate import CubicSpline

from georibbon.errors import SurfaceError
from georibbon.geometry.arch import arch
from georibbon.geometry.frames import Strip
from georibbon.geometry.geodesics import geodesic
from georibbon.geometry.reference import (
    Bonnet,
    Cone,
    Cylinder,
    Ellipsoid,
    Hull,
    Plane,
    ReferenceSurface,
    Saddle,
    Torus,
)
from georibbon.geometry.shortest import Chain, shortest_chain, shortest_geodesic

CASES = {
    "plane": (Plane(30.0), (-0.4, 0.2), (0.7, -0.5)),
    "bonnet": (Bonnet(), (-0.4, -0.3), (0.4, 0.2)),
    "torus": (Torus(), (0.0, -1.5), (1.2, 1.0)),
    "cone": (Cone(35.0), (-1.0, 1.0), (1.0, 0.8)),
    "saddle": (Saddle(), (-0.5, -0.4), (0.5, 0.3)),
    "hull": (Hull(), (-0.5, -1.0), (0.4, 0.6)),
    "sphere": (Ellipsoid(), (-0.9, 0.1), (0.8, 0.3)),
    "arch": (arch(), (0.2, 0.3), (0.8, 0.7)),
}
every_case = pytest.mark.parametrize("name", CASES)


def case(name: str) -> tuple[ReferenceSurface, np.ndarray, np.ndarray]:
    surface, start, end = CASES[name]
    return surface, np.array(start), np.array(end)


def length(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def away(chain: Chain, strip: Strip) -> float:
    """The chain's greatest distance from the strip at the same shares of their lengths."""
    links = np.linalg.norm(np.diff(chain.points, axis=0), axis=1)
    share = np.r_[0.0, np.cumsum(links)] / links.sum()
    there = CubicSpline(strip.s, strip.points)(share * strip.s[-1])
    return float(np.linalg.norm(there - chain.points, axis=1).max())


@every_case
def test_it_runs_from_the_first_point_to_the_second(name: str) -> None:
    surface, start, end = case(name)
    strip = shortest_geodesic(surface, start, end)
    ends = surface.points(np.stack([start, end]))
    np.testing.assert_allclose(strip.points[[0, -1]], ends, atol=2e-9)
    normals = surface.normals(np.stack([start, end]))
    np.testing.assert_allclose(strip.normals[[0, -1]], normals, atol=1e-8)
    assert len(strip.s) == 121
    assert strip.s[0] == 0.0


@pytest.mark.parametrize("name", ["bonnet", "torus", "saddle", "hull"])
def test_it_is_the_geodesic_that_starts_as_it_does(name: str) -> None:
    surface, start, end = case(name)
    strip = shortest_geodesic(surface, start, end, samples=21)
    again = geodesic(surface, start, strip.tangents[0], strip.s)
    np.testing.assert_allclose(again.points, strip.points, atol=1e-9)
    np.testing.assert_allclose(again.frames, strip.frames, atol=1e-8)


@pytest.mark.parametrize("name", ["bonnet", "torus", "cone", "hull"])
def test_the_way_back_is_the_same_way(name: str) -> None:
    surface, start, end = case(name)
    there, back = (
        shortest_geodesic(surface, *ends, samples=21) for ends in ((start, end), (end, start))
    )
    np.testing.assert_allclose(back.points, there.reversed().points, atol=1e-8)
    np.testing.assert_allclose(back.s[-1], there.s[-1], rtol=1e-9)


@every_case
def test_no_way_near_by_is_shorter(name: str) -> None:
    surface, start, end = case(name)
    chain = shortest_chain(surface, start, end, nodes=60)
    random = np.random.default_rng(4)
    bump = np.sin(np.pi * np.linspace(0.0, 1.0, 61))[:, None]
    box = np.subtract(surface.upper, surface.lower)
    for _ in range(10):
        other = chain.uv + 1e-2 * box * bump * random.normal(size=2)
        assert length(surface.points(other)) > length(chain.points)


@every_case
def test_the_chain_is_of_second_order_with_links_equally_long(name: str) -> None:
    surface, start, end = case(name)
    strip = shortest_geodesic(surface, start, end, samples=200)
    chains = [shortest_chain(surface, start, end, nodes) for nodes in (25, 50, 100)]
    errors = [away(chain, strip) for chain in chains]
    if name in ("plane", "sphere"):  # where a chain's points lie on the geodesic
        np.testing.assert_allclose(errors, 0.0, atol=1e-8)
    else:
        for coarse, fine in pairwise(errors):
            assert coarse / fine == pytest.approx(4.0, rel=0.1)
    assert errors[-1] < 2e-5
    links = np.linalg.norm(np.diff(chains[-1].points, axis=0), axis=1)
    np.testing.assert_allclose(links, links.mean(), rtol=2e-3)
    assert max(chain.steps for chain in chains) <= 6  # only with the whole Hessian


def test_on_an_oblate_ellipsoid_it_is_as_long_as_geographiclib_says() -> None:
    a, f = 0.7, 0.1
    surface, known = Ellipsoid(a, a * (1 - f), a), Geodesic(a, f)
    for turn in (20.0, 75.0, 120.0):
        lines = []
        for latitude, longitude in ((-20.0, 0.0), (35.0, turn)):
            beta = np.arctan((1 - f) * np.tan(np.radians(latitude)))
            lines.append(np.array([np.radians(longitude), beta]))
        expected = known.Inverse(-20.0, 0.0, 35.0, turn)["s12"]
        assert shortest_geodesic(surface, *lines).s[-1] == pytest.approx(expected, abs=1e-9)


def test_the_ends_tell_the_way_around() -> None:
    cylinder = Cylinder(0.5)
    for turns in (0, 1, 2):
        angle = 1.0 + 2 * np.pi * turns
        strip = shortest_geodesic(cylinder, np.array([0.0, -0.2]), np.array([angle, 0.4]))
        assert strip.s[-1] == pytest.approx(np.hypot(0.5 * angle, 0.6), abs=1e-9)


def test_over_a_ridge_the_way_turns_aside_though_straight_on_is_a_geodesic_too() -> None:
    """Along the outermost circle of a ring's tube it is longer than over its side."""
    ring, start, end = Torus(0.5, 0.2, upright=True), np.array([-1.5, 0.0]), np.array([1.5, 0.0])
    strip = shortest_geodesic(ring, start, end)
    assert strip.s[-1] < 0.7 * 3.0 - 0.3
    assert np.abs(strip.points[:, 1]).max() > 0.1
    around = geodesic(ring, start, (1.0, 0.0, 0.0), np.array([0.0, 0.7 * 3.0]))
    np.testing.assert_allclose(np.linalg.norm(around.points[-1, [0, 2]]), 0.7, atol=1e-12)


def test_two_points_that_are_one_are_refused() -> None:
    here = np.array([0.3, 0.4])
    with pytest.raises(SurfaceError, match="the two points are one"):
        shortest_geodesic(Saddle(), here, here)
    with pytest.raises(SurfaceError, match="or no numbers"):
        shortest_geodesic(Saddle(), here, np.array([np.nan, 0.0]))


def test_a_way_over_the_edge_is_refused() -> None:
    """Around a cone it goes up, and this one is cut off above its two points."""
    with pytest.raises(SurfaceError, match="leaves the surface over its edge"):
        shortest_geodesic(Cone(20.0), np.array([0.0, 0.025]), np.array([4.0, 0.025]))


@pytest.mark.parametrize(
    ("surface", "start", "end", "said"),
    [
        (Cone(15.0), (0.0, 0.9), (12.5, 0.9), "not found exactly"),  # more than it ever turns
        (Cone(10.0), (0.0, 0.9), (17.9, 0.9), "not found exactly"),
        (
            Ellipsoid(),
            (0.0, 0.0),
            (np.pi, 0.0),
            "no shortest way",
        ),  # opposite: as many as one likes
        (Ellipsoid(), (0.0, 0.0), (0.0, np.pi / 2), "over its edge"),  # a pole of the parameters
        (Cone(40.0), (0.0, 0.5), (0.0, -0.5), "such as a pole"),
        (arch(), (-5.0, 0.0), (6.0, 2.0), "cannot be followed"),  # far outside, where w vanishes
        (arch(), (0.0, 0.0), (1.0, 0.0), "over its edge"),
    ],
)
def test_where_there_is_no_one_shortest_way_it_is_told(
    surface: ReferenceSurface, start: tuple[float, float], end: tuple[float, float], said: str
) -> None:
    with pytest.raises(SurfaceError, match=f"{said}.*choose nearer points"):
        shortest_geodesic(surface, np.array(start), np.array(end))
