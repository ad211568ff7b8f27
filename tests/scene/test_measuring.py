"""Picks, distances and sections, on surfaces whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import synthetic
from georibbon.errors import SurfaceError
from georibbon.geometry.mesh import grid_mesh
from georibbon.geometry.surface import Surface
from georibbon.scene.measuring import Probe, cut, section_table

RESULT = synthetic.reconstruction()
PROBE = Probe(RESULT)
BALL = 0.5


def on_ball():
    """The synthetic result with a piece of a ball as its surface."""
    u, v = np.meshgrid(np.linspace(-0.8, 0.8, 61), np.linspace(-0.6, 0.6, 41), indexing="ij")
    normals = np.stack((np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)), axis=-1)
    mesh = grid_mesh(BALL * normals, normals, np.full(u.shape, 1e-3))
    return replace(RESULT, surface=Surface(mesh, 1.0, (), shape=(61, 41)))


ROUND = Probe(on_ball())


def seen_from_above(probe, x, y):
    return probe.hit(np.array([x, y, 2.0]), np.array([x, y, -2.0]), 0.01)


places = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.2, 0.2))


@given(at=places)
def test_a_pick_lies_under_the_pointer_and_bends_as_the_ball(at):
    pick = seen_from_above(ROUND, *at)
    assert pick.position[:2] == pytest.approx(at, abs=1e-6)
    assert np.linalg.norm(pick.position) == pytest.approx(BALL, abs=2e-4)
    assert pick.normal == pytest.approx(pick.position / np.linalg.norm(pick.position), abs=1e-3)
    assert pick.sigma == pytest.approx(1e-3)
    assert pick.mean == pytest.approx(-1.0 / BALL, rel=1e-3)
    assert pick.gaussian == pytest.approx(1.0 / BALL**2, rel=2e-3)
    assert pick.along == pytest.approx(-1.0 / BALL, rel=1e-3)


@given(share=st.floats(0.02, 0.98), which=st.integers(1, 3))
def test_a_pick_over_a_pass_tells_the_pass_and_the_place_along_it(share, which):
    strip = RESULT.passes[which].strip
    s = share * strip.s[-1]
    x, y = (np.interp(s, strip.s, strip.points[:, k]) for k in (0, 1))
    pick = seen_from_above(PROBE, x, y)
    assert pick.away < 2e-4
    if pick.pass_name != "T1":  # where the tie crosses, it is as near
        assert pick.pass_name == RESULT.passes[which].name
        assert pick.s == pytest.approx(s, abs=2e-4)


def test_beside_everything_nothing_is_picked_and_near_a_pass_that_pass():
    bare = Probe(replace(RESULT, surface=None))
    strip = RESULT.passes[2].strip
    x, y, _ = strip.points[30] + [0.0, 0.006, 0.0]
    pick = seen_from_above(bare, x, y)
    assert (pick.pass_name, pick.on) == ("P3", None)
    assert pick.sigma == pytest.approx(RESULT.passes[2].position_sigma[30], rel=0.05)
    assert seen_from_above(bare, x, y + 0.05) is None
    assert seen_from_above(PROBE, 5.0, 5.0) is None


@given(first=places, second=places)
def test_on_a_ball_the_way_over_the_surface_is_a_great_circle(first, second):
    a, b = (seen_from_above(ROUND, *at) for at in (first, second))
    found = ROUND.distance(a, b)
    assert found.straight == pytest.approx(np.linalg.norm(a.position - b.position))
    assert found.along == pytest.approx(2 * BALL * np.arcsin(found.straight / 2 / BALL), rel=3e-3,
                                        abs=1e-5)  # fmt: skip
    assert found.along >= found.straight - 1e-9
    assert found.path[[0, -1]] == pytest.approx(np.stack((a.position, b.position)))


def test_a_distances_sigma_is_that_of_independent_ends():
    a, b = seen_from_above(PROBE, 0.2, 0.1), seen_from_above(PROBE, 0.6, 0.1)
    along = (b.position - a.position) / np.linalg.norm(b.position - a.position)
    share = along**2 @ [0.2, 0.3, 0.5]  # as the made-up covariances are shared out
    expected = np.sqrt(share * (a.sigma**2 + b.sigma**2))
    assert PROBE.distance(a, b).sigma == pytest.approx(expected)
    assert PROBE.distance(a, replace(b, sigma=None)).sigma is None


def test_without_a_surface_there_is_a_straight_distance_alone():
    bare = Probe(replace(RESULT, surface=None))
    a, b = (seen_from_above(bare, *RESULT.passes[0].strip.points[k, :2]) for k in (10, 60))
    found = bare.distance(a, b)
    assert found.straight > 0.3
    assert found.along is None
    assert len(found.path) == 0
    with pytest.raises(SurfaceError, match="no surface to be cut"):
        bare.section(a, b)


@given(first=places, second=places, upright=st.booleans())
def test_a_section_lies_in_its_plane_on_the_ball_and_runs_through_both_places(
    first, second, upright
):
    a, b = (seen_from_above(ROUND, *at) for at in (first, second))
    sight = None if upright else np.array([0.3, 0.2, -1.0])
    if np.hypot(*np.subtract(first, second)) < 0.01:
        return
    found = ROUND.section(a, b, sight)
    inside = np.array([0.0, 0.0, 1.0]) if upright else sight
    normal = np.cross(b.position - a.position, inside)
    assert (found.points - a.position) @ (normal / np.linalg.norm(normal)) == pytest.approx(
        0.0, abs=1e-9
    )
    assert np.linalg.norm(found.points, axis=1) == pytest.approx(BALL, abs=3e-4)
    for place, s in ((a.position, 0.0), (b.position, found.between)):
        at = [np.interp(s, found.s, found.points[:, k]) for k in range(3)]
        assert at == pytest.approx(place, abs=1e-5)
    assert np.diff(found.s).min() >= 0
    assert found.s[-1] - found.s[0] == pytest.approx(found.length)
    assert 0 < found.between <= found.length
    rebuilt = np.hypot(np.diff(found.across), np.diff(found.height))
    assert rebuilt.sum() == pytest.approx(found.length)


def test_an_upright_profile_has_z_as_its_height():
    a, b = seen_from_above(ROUND, -0.1, 0.0), seen_from_above(ROUND, 0.2, 0.1)
    found = ROUND.section(a, b)
    assert found.height == pytest.approx(found.points[:, 2] - a.position[2])
    assert np.interp(found.between, found.s, found.across) == pytest.approx(np.hypot(0.3, 0.1))


def test_two_equal_places_span_no_plane():
    pick = seen_from_above(ROUND, 0.0, 0.0)
    with pytest.raises(SurfaceError, match="determine no plane"):
        ROUND.section(pick, pick)


def test_a_section_beside_the_surface_is_refused():
    """As through two places on the ends of ties, which reach over the border."""
    pick = seen_from_above(ROUND, 0.0, 0.0)
    beside = [replace(pick, position=np.array([9.0, y, 0.0]), on=None) for y in (0.0, 1.0)]
    with pytest.raises(SurfaceError, match="does not meet the surface"):
        ROUND.section(*beside)


def test_a_part_that_the_section_does_not_reach_has_no_way_between():
    """Two sheets side by side: the section of one does not run on to the other."""
    sheets = [np.array([0.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.3])]
    flat = grid_mesh(
        np.stack(np.meshgrid([0.0, 0.4], [0.0, 0.4], [0.0], indexing="ij"), -1)[:, :, 0],
        np.tile([0.0, 0.0, 1.0], (2, 2, 1)),
    )
    mesh = replace(
        flat,
        vertices=np.concatenate([flat.vertices + shift for shift in sheets]),
        triangles=np.concatenate((flat.triangles, flat.triangles + 4)),
        normals=np.concatenate((flat.normals, flat.normals)),
    )
    probe = Probe(replace(RESULT, surface=Surface(mesh, 0.32, ())))
    a, b = seen_from_above(probe, 0.1, 0.1), seen_from_above(probe, 1.3, 0.2)
    found = probe.section(a, b)
    assert found.between is None
    assert found.points[:, 0].max() == pytest.approx(0.4)
    assert found.length == pytest.approx(0.4 * np.hypot(1.2, 0.1) / 1.2)


def test_a_closed_cut_ends_where_it_starts():
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 40), np.linspace(-1, 1, 5), indexing="ij")
    normals = np.stack((np.cos(u), np.sin(u), np.zeros_like(u)), axis=-1)
    tube = grid_mesh(normals + v[..., None] * [0, 0, 1.0], normals)
    welded = replace(tube, triangles=np.where(tube.triangles >= 195, tube.triangles - 195,
                                              tube.triangles))  # fmt: skip
    (ring,) = cut(welded, np.array([0.0, 0.0, 0.1]), np.array([0.0, 0.0, 1.0]))
    assert np.array_equal(ring[0], ring[-1])
    lengths = np.linalg.norm(np.diff(ring, axis=0), axis=1)
    assert lengths.sum() == pytest.approx(2 * np.pi, rel=3e-3)
    assert cut(welded, np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 1.0])) == []


def test_a_section_as_a_table_holds_its_numbers():
    found = ROUND.section(seen_from_above(ROUND, -0.1, 0.0), seen_from_above(ROUND, 0.2, 0.1))
    head, *rows = section_table(found).splitlines()
    assert head == "s,across,height,x,y,z"
    numbers = np.array([[float(word) for word in row.split(",")] for row in rows])
    expected = np.column_stack((found.s, found.across, found.height, found.points))
    assert numbers == pytest.approx(expected, abs=1e-9)
