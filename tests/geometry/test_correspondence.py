"""Laws of matching: the feet's equation, symmetry, cover, order of passes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.geometry.correspondence import (
    arrange,
    ascending,
    correspond,
    feet,
    hermite,
    match_pair,
    order_passes,
)
from georibbon.geometry.frames import Strip
from georibbon.geometry.reference import Bonnet, Torus
from passes import moved, passes, plane_passes, sphere_passes, upside_down


def at(strip: Strip, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    points, tangents, _ = hermite(strip.points, strip.tangents, strip.s, s)
    return points, tangents


def bonnet_pair() -> list[Strip]:
    return passes(Bonnet(), [(0.0, 0.1), (0.03, 0.2)], [0.0, 0.05], shifts=[0.0, 0.06])


def test_hermite_reproduces_a_cubic_with_its_derivatives() -> None:
    def cubic(s: np.ndarray) -> list[np.ndarray]:
        return [
            np.stack([s**3 - s, 2.0 * s**2, 1.0 + s], axis=1),
            np.stack([3.0 * s**2 - 1.0, 4.0 * s, np.ones_like(s)], axis=1),
            np.stack([6.0 * s, np.full_like(s, 4.0), np.zeros_like(s)], axis=1),
        ]

    nodes = np.array([0.0, 0.3, 0.4, 1.0])
    points, slopes, _ = cubic(nodes)
    places = np.array([-0.1, 0.0, 0.2, 0.35, 0.7, 1.0])
    for found, exact in zip(hermite(points, slopes, nodes, places), cubic(places), strict=True):
        assert np.allclose(found, exact, atol=1e-13)


def test_feet_fulfil_their_equation() -> None:
    a, b = bonnet_pair()
    s = np.linspace(0.0, 0.96, 50)
    t, valid = feet(a, b, s)
    assert np.count_nonzero(valid) > 40
    here, ahead = at(a, s[valid])
    there, along = at(b, t[valid])
    assert np.abs(np.sum((there - here) * (ahead + along), axis=1)).max() < 1e-12


def test_a_foot_of_a_foot_is_the_point_itself() -> None:
    a, b = bonnet_pair()
    t, valid = feet(a, b, a.s)
    back, still = feet(b, a, t[valid])
    assert still.all()
    assert np.allclose(back, a.s[valid], atol=1e-9)


def test_feet_move_with_the_passes() -> None:
    pair = bonnet_pair()
    turn, shift = Rotation.from_rotvec([0.4, 2.0, -0.3]).as_matrix(), np.array([3.0, -1.0, 2.0])
    plain, valid = feet(*pair, pair[0].s)
    there, also = feet(*(moved(strip, turn, shift) for strip in pair), pair[0].s)
    assert np.array_equal(valid, also)
    assert np.allclose(there[valid], plain[valid], atol=1e-9)


def test_feet_backwards_are_the_same_feet() -> None:
    a, b = bonnet_pair()
    plain, valid = feet(a, b, a.s)
    back, also = feet(a.reversed(), b.reversed(), a.s[-1] - a.s)
    assert np.array_equal(valid, also)
    assert np.allclose(b.s[-1] - back[valid], plain[valid], atol=1e-9)


def test_on_parallel_straight_passes_the_foot_lies_straight_across() -> None:
    a, b = plane_passes(0.0, 0.1, shifts=[0.0, 0.123])
    s = np.linspace(0.0, 0.96, 33)
    t, valid = feet(a, b, s)
    assert np.allclose(t[valid], s[valid] - 0.123, atol=1e-12)
    assert np.array_equal(valid, s >= 0.123)


def test_level_passes_match_to_their_very_ends() -> None:
    a, b = sphere_passes([0.0, 0.1])
    t, valid = feet(a, b, a.s)
    assert valid.all()
    assert np.allclose(t, a.s, atol=1e-9)


def test_places_outside_the_first_pass_have_no_foot() -> None:
    a, b = plane_passes(0.0, 0.1)
    assert not feet(a, b, np.array([-0.1, 1.2]))[1].any()


def test_the_nearest_of_several_feet_is_taken() -> None:
    """A pass that runs once around a tube has a foot on its far side as well."""
    ring, other = passes(Torus(0.5, 0.1), [(0.0, 0.0), (0.2, 0.0)], np.pi / 2, length=0.6)
    t, valid = feet(ring, other, ring.s)
    there, here = at(other, t[valid])[0], at(ring, ring.s[valid])[0]
    assert valid.sum() > 80
    assert np.linalg.norm(there - here, axis=1).max() < 0.14


def test_on_a_plane_feet_are_shifted_as_the_passes_are() -> None:
    a, b = plane_passes(0.0, 0.1, shifts=[0.0, 0.2])
    t, valid = feet(a, b, a.s)
    assert np.array_equal(valid, a.s >= 0.2 - 1e-9)
    assert np.allclose(a.s[valid] - t[valid], 0.2)


@pytest.mark.parametrize("shifts", [[0.0, 0.0], [0.0, 0.1], [0.1, 0.0], [0.0, 0.4]])
@pytest.mark.parametrize("lengths", [(0.96, 0.96), (0.96, 0.6), (0.6, 0.96)])
def test_a_match_covers_both_passes_and_ascends(
    shifts: list[float], lengths: tuple[float, float]
) -> None:
    a = passes(Bonnet(), [(0.0, 0.1)], length=lengths[0], shifts=shifts[0])[0]
    b = passes(Bonnet(), [(0.0, 0.2)], length=lengths[1], shifts=shifts[1])[0]
    match = match_pair(a, b)
    assert match.by_feet
    assert (np.diff(match.a) > 0.0).all()
    assert (np.diff(match.b) > 0.0).all()
    assert np.array_equal(match.a[[0, -1]], a.s[[0, -1]])
    assert np.array_equal(match.b[[0, -1]], b.s[[0, -1]])


def test_a_match_is_by_feet_well_inside_the_overlap() -> None:
    a, b = plane_passes(0.0, 0.1, shifts=[0.0, 0.1])
    match = match_pair(a, b)
    inside = (match.a > 0.35) & (match.a < 0.6)
    assert np.allclose((match.a - match.b)[inside], 0.1, atol=1e-9)
    assert match.overlap == pytest.approx(0.86 / 0.96)


def test_a_match_is_the_same_from_either_side() -> None:
    a, b = bonnet_pair()
    there, back = match_pair(a, b), match_pair(b, a)
    assert np.allclose(back.backward(a.s), there.forward(a.s), atol=1e-6)
    assert back.overlap == pytest.approx(there.overlap)


def test_passes_that_do_not_overlap_are_matched_by_equal_shares() -> None:
    a, b = plane_passes(0.0, 0.1, shifts=[0.0, 1.2])
    match = match_pair(a, b)
    assert not match.by_feet
    assert match.overlap == 0.0
    assert np.allclose(match.forward(a.s), b.s)


def test_passes_that_hardly_overlap_are_matched_by_equal_shares() -> None:
    match = match_pair(*plane_passes(0.0, 0.1, shifts=[0.0, 0.9]))
    assert not match.by_feet
    assert match.overlap == pytest.approx(0.0625, abs=1e-6)


def test_a_pass_with_a_hole_in_its_feet_is_matched_by_equal_shares() -> None:
    """The neighbour turns away by more than a right angle in its middle: no feet there."""
    a = plane_passes(0.0)[0]
    s = np.linspace(0.0, 1.2, 121)
    heading = 2.2 * np.sin(2.0 * np.pi * s / 1.2)
    tangents = np.stack([np.cos(heading), np.sin(heading), 0.0 * s], axis=1)
    points = np.concatenate([[[-0.2, 0.3, 0.0]], tangents[1:] * 0.01]).cumsum(axis=0)
    normals = np.tile([0.0, 0.0, 1.0], (121, 1))
    frames = np.stack([tangents, np.cross(normals, tangents), normals], axis=2)
    match = match_pair(a, Strip(s, points, frames))
    assert not match.by_feet


def test_the_curve_through_a_match_ascends_even_where_a_spline_would_not() -> None:
    source = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    target = np.array([0.0, 0.01, 0.02, 2.0, 2.01])
    curve = ascending(source, target)
    assert (np.diff(curve(np.linspace(0.0, 4.0, 400))) > 0.0).all()
    assert np.allclose(curve(source), target)


@pytest.mark.parametrize("count", [2, 3, 6])
def test_all_passes_share_one_ascending_parameter(count: int) -> None:
    shifts = [0.0, 0.05, -0.04, 0.1, 0.0, 0.02][:count]
    places = [(0.0, -0.3 + 0.1 * k) for k in range(count)]
    strips = passes(Bonnet(), places, shifts=shifts)
    match = correspond(strips)
    u = np.linspace(0.0, 0.96, 300)
    rows = match(u)
    assert rows.shape == (count, 300)
    assert (np.diff(rows, axis=1) > 0.0).all()
    assert np.allclose(rows[:, 0], 0.0, atol=1e-15)
    assert np.allclose(rows[:, -1], 0.96, atol=1e-15)
    assert np.array_equal(rows[(count - 1) // 2], u)


def test_passes_come_in_order_across_however_they_are_numbered() -> None:
    strips = sphere_passes(np.linspace(-0.4, 0.4, 9))
    mixed = np.random.default_rng(4).permutation(9)
    order = order_passes([strips[k] for k in mixed])
    places = mixed[list(order)]
    assert np.array_equal(places, np.arange(9)) or np.array_equal(places, np.arange(9)[::-1])
    assert order[0] < order[-1]


def test_passes_around_a_pipe_elbow_come_in_order() -> None:
    """From its left over its underside to its right, where no single axis sorts them."""
    angles = np.linspace(0.0, 4.5, 10)
    strips = passes(Torus(0.5, 0.12, upright=True), [(0.0, v) for v in angles], length=0.5)
    mixed = np.random.default_rng(8).permutation(10)
    places = mixed[list(order_passes([strips[k] for k in mixed]))]
    assert np.array_equal(np.abs(np.diff(places)), np.ones(9))


def test_passes_shifted_along_come_in_order() -> None:
    order = order_passes(plane_passes(0.0, 0.05, 0.1, 0.15, shifts=[0.0, 0.3, 0.0, 0.3]))
    assert order == (0, 1, 2, 3)


def test_a_pass_off_the_row_is_still_counted_once() -> None:
    """Five passes in a row and one high above the middle: the tree has a branch."""
    strips = plane_passes(0.0, 0.1, 0.2, 0.3, 0.4)
    strips.append(moved(plane_passes(0.2)[0], np.eye(3), np.array([0.0, 0.0, 0.08])))
    assert sorted(order_passes(strips)) == list(range(6))


@pytest.mark.parametrize("backwards", [[], [1], [0], [0, 2, 3], [0, 1, 2, 3, 4]])
def test_passes_are_turned_to_run_as_the_first_given_does(backwards: list[int]) -> None:
    strips = sphere_passes()
    given = [s.reversed() if k in backwards else s for k, s in enumerate(strips)]
    arrangement = arrange(given)
    first = arrangement.order.index(0)
    assert not arrangement.turned[first]
    ahead = arrangement.strips[first].tangents[48]
    assert all(strip.tangents[48] @ ahead > 0.9 for strip in arrangement.strips)
    turned = {arrangement.order[k] for k in np.flatnonzero(arrangement.turned)}
    assert turned == (set(range(5)) - set(backwards) if 0 in backwards else set(backwards))
    assert not arrangement.flipped.any()


def test_the_first_given_keeps_its_direction_wherever_it_lies() -> None:
    strips = sphere_passes()
    arrangement = arrange([strips[2].reversed(), strips[0], strips[4], strips[1], strips[3]])
    first = arrangement.order.index(0)
    assert first == 2
    assert np.array_equal(arrangement.turned, np.arange(5) != first)


def test_the_order_runs_along_the_conormals() -> None:
    for strips in (sphere_passes(), [s.reversed() for s in sphere_passes()]):
        arrangement = arrange(strips)
        first, second = arrangement.strips[:2]
        assert (second.points[48] - first.points[48]) @ first.conormals[48] > 0.0


@pytest.mark.parametrize("turn", [1.0, 1.7, 2.5])
def test_passes_either_side_of_an_edge_both_face_outward(turn: float) -> None:
    """Normals more than a right angle apart are no sign that one pass lies upside down."""
    strips = sphere_passes([-0.3 * turn, 0.3 * turn], shifts=[0.0, 0.05])
    assert not arrange(strips).flipped.any()


@pytest.mark.parametrize("over", [[2], [0], [3, 4]])
def test_a_pass_that_lies_upside_down_is_found(over: list[int]) -> None:
    strips = sphere_passes()
    arrangement = arrange([upside_down(s) if k in over else s for k, s in enumerate(strips)])
    flipped = {arrangement.order[k] for k in np.flatnonzero(arrangement.flipped)}
    assert flipped == set(over)
    for strip in arrangement.strips:
        assert strip.normals[48] @ strip.points[48] > 0.0
        assert np.allclose(np.linalg.det(strip.frames), 1.0)
