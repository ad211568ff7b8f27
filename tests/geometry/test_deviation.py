"""How far a mesh lies from another: against brute force, plane, sphere and rigid motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from georibbon import rotations
from georibbon.geometry import nearest
from georibbon.geometry.alignment import STILL, Motion, align
from georibbon.geometry.deviation import deviation, deviation_statistics, vertex_areas
from georibbon.geometry.mesh import grid_mesh
from georibbon.geometry.nearest import TriangleLocator


def sheet(n=12, height=lambda x, y: 0.1 * x * x + 0.05 * y**3, size=(1.0, 0.8)):
    """A mesh over a rectangle about the origin, metres."""
    x, y = np.meshgrid(
        np.linspace(-0.5, 0.5, n) * size[0], np.linspace(-0.5, 0.5, n) * size[1], indexing="ij"
    )
    points = np.stack([x, y, height(x, y)], axis=2)
    normals = np.zeros_like(points)
    normals[..., 2] = 1.0
    return grid_mesh(points, normals)


def flat(n=12):
    return sheet(n, lambda x, y: 0 * x * y)


def ball(subdivisions=3, radius=0.1):
    """An octahedron's triangles divided and carried onto a sphere: vertices, triangles."""
    v = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    t = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    )
    for _ in range(subdivisions):
        a, b, c = v[t[:, 0]], v[t[:, 1]], v[t[:, 2]]
        corners = np.stack([a, b, c, a + b, b + c, c + a], axis=1).reshape(-1, 3)
        corners /= np.linalg.norm(corners, axis=1, keepdims=True)
        v, index = np.unique(np.round(corners, 12), axis=0, return_inverse=True)
        i = index.reshape(-1, 6)
        parts = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
        t = np.concatenate([i[:, part] for part in parts])
    return radius * v, t


def located(mesh):
    return TriangleLocator(mesh.vertices, mesh.triangles)


def brute_distance(points, vertices, triangles):
    """Distances point by point and triangle by triangle, by projecting onto planes and edges."""
    found = np.full(len(points), np.inf)
    for i, p in enumerate(points):
        for a, b, c in vertices[triangles]:
            n = np.cross(b - a, c - a)
            n = n / np.linalg.norm(n)
            q = p - ((p - a) @ n) * n
            inside = all(
                np.cross(end - start, q - start) @ n >= 0 for start, end in ((a, b), (b, c), (c, a))
            )
            if inside:
                found[i] = min(found[i], abs((p - a) @ n))
            for start, end in ((a, b), (b, c), (c, a)):
                t = np.clip((p - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
                found[i] = min(found[i], np.linalg.norm(p - start - t * (end - start)))
    return found


def test_nearest_points_are_as_near_as_brute_force_finds():
    mesh = sheet(5)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (60, 3))
    found = located(mesh).nearest(points)
    assert found.distance == pytest.approx(
        brute_distance(points, mesh.vertices, mesh.triangles), rel=1e-12
    )


def test_nearest_points_lie_on_the_triangles_that_are_named():
    mesh = sheet(7)
    points = np.random.default_rng(2).uniform(-0.7, 0.7, (200, 3))
    found = located(mesh).nearest(points)
    corners = mesh.vertices[mesh.triangles[found.faces]]
    assert np.einsum("ij,ijk->ik", found.weights, corners) == pytest.approx(found.points, abs=1e-14)
    assert found.weights.min() >= -1e-12
    assert np.linalg.norm(points - found.points, axis=1) == pytest.approx(found.distance)


def test_large_and_tiny_triangles_side_by_side_are_searched_exactly():
    fine, coarse = sheet(9, size=(0.01, 0.01)), sheet(3, lambda x, y: 0.2 + 0 * x * y)
    vertices = np.concatenate([fine.vertices, coarse.vertices])
    triangles = np.concatenate([fine.triangles, coarse.triangles + len(fine.vertices)])
    points = np.random.default_rng(3).uniform(-0.1, 0.3, (40, 3))
    found = TriangleLocator(vertices, triangles).nearest(points)
    assert found.distance == pytest.approx(brute_distance(points, vertices, triangles), rel=1e-12)


def test_triangles_without_area_spoil_nothing():
    mesh = flat(4)
    triangles = np.concatenate([mesh.triangles, [[0, 0, 1], [2, 2, 2]]])
    points = np.random.default_rng(4).uniform(-0.3, 0.3, (30, 3))
    found = TriangleLocator(mesh.vertices, triangles).nearest(points)
    assert found.distance == pytest.approx(np.abs(points[:, 2]), abs=1e-15)


def test_over_a_plane_the_deviation_is_the_height_with_its_sign():
    points = np.random.default_rng(5).uniform(-0.35, 0.35, (300, 3)) * [1.0, 1.0, 0.3]
    assert deviation(points, located(flat())) == pytest.approx(points[:, 2], abs=1e-15)


def test_turned_triangles_turn_the_sign():
    mesh = flat()
    turned = TriangleLocator(mesh.vertices, mesh.triangles[:, ::-1])
    points = mesh.vertices + np.array([0.0, 0.0, 0.002])
    assert deviation(points, turned) == pytest.approx(np.full(len(points), -0.002))


def test_a_mesh_deviates_nowhere_from_itself_its_border_included():
    mesh = sheet(20)
    values = deviation(mesh.vertices, located(mesh))
    assert values == pytest.approx(np.zeros(len(values)), abs=1e-12)


@pytest.mark.parametrize("step", [0.01, -0.01])
def test_an_offset_sphere_deviates_by_the_offset(step):
    vertices, triangles = ball(4)
    found = deviation(vertices * (1 + step / 0.1), TriangleLocator(vertices, triangles))
    assert found == pytest.approx(np.full(len(found), step), abs=1e-4)


def test_around_a_closed_mesh_the_sign_tells_outside_from_inside():
    vertices, triangles = ball(1)  # sharp corners, where a triangle's own normal would mislead
    points = np.random.default_rng(6).normal(size=(500, 3))
    points *= np.linspace(0.085, 0.115, 500)[:, None] / np.linalg.norm(points, axis=1)[:, None]
    normals = np.cross(
        vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
        vertices[triangles[:, 2]] - vertices[triangles[:, 0]],
    )
    heights = np.einsum("fk,nfk->nf", normals, points[:, None] - vertices[triangles[:, 0]])
    outside = (heights > 0).any(axis=1)  # the ball is convex
    found = deviation(points, TriangleLocator(vertices, triangles))
    there = np.isfinite(found)
    assert np.count_nonzero(there) > 300
    assert np.array_equal(found[there] > 0, outside[there])


def test_beyond_the_border_there_is_nothing_to_compare_with():
    points = np.array([[0.6, 0.0, 0.01], [0.0, 0.41, 0.0], [0.55, 0.45, -0.01]])
    assert np.isnan(deviation(points, located(flat()))).all()


def test_straight_over_the_border_there_is():
    points = np.array([[0.5, 0.0, 0.01], [-0.5, 0.4, 0.02]])
    assert deviation(points, located(flat())) == pytest.approx([0.01, 0.02])


@pytest.mark.parametrize(("lean", "there"), [(0.05, True), (0.2, False)])
def test_leaning_out_over_the_border_counts_as_beyond_from_a_tenth_on(lean, there):
    points = np.array([[0.5 + lean * 0.02, 0.0, 0.02]])
    assert np.isfinite(deviation(points, located(flat()))).item() is there


def test_what_is_far_away_belongs_to_something_else():
    mesh = flat()
    points = np.array([[0.0, 0.0, 0.12], [0.0, 0.0, 0.2]])
    assert deviation(points, located(mesh)) == pytest.approx([0.12, np.nan], nan_ok=True)


def test_beyond_the_reach_a_point_of_the_mesh_is_found_all_the_same():
    mesh = sheet(9)
    points = np.random.default_rng(8).uniform(-0.7, 0.7, (200, 3))
    exact, rough = located(mesh).nearest(points), located(mesh).nearest(points, 0.1)
    near = exact.distance <= 0.1
    assert near.any()
    assert np.array_equal(rough.distance[near], exact.distance[near])
    assert (rough.distance >= exact.distance).all()
    assert np.linalg.norm(points - rough.points, axis=1) == pytest.approx(rough.distance)


def test_many_candidates_are_taken_in_parts(monkeypatch):
    vertices, triangles = ball(2)  # from its middle all triangles are equally near
    points = np.random.default_rng(9).normal(size=(50, 3)) * 1e-6
    whole = TriangleLocator(vertices, triangles).nearest(points)
    monkeypatch.setattr(nearest, "_PAIRS", 300)
    parts = TriangleLocator(vertices, triangles).nearest(points)
    assert all(np.array_equal(a, b) for a, b in zip(whole, parts, strict=True))


def test_no_point_has_no_deviation():
    assert deviation(np.zeros((0, 3)), located(flat())).shape == (0,)


@settings(max_examples=25, deadline=None)
@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-2, 2)] * 3), st.integers(0, 1000))
def test_moving_both_changes_nothing(turn, away, seed):
    rng = np.random.default_rng(seed)
    mesh = sheet(6)
    points = rng.uniform(-0.6, 0.6, (30, 3)) * [1.0, 1.0, 0.2]
    motion = Motion(rotations.exp(np.array(turn)), np.array(away))
    before = deviation(points, located(mesh))
    after = deviation(
        motion.applied(points), TriangleLocator(motion.applied(mesh.vertices), mesh.triangles)
    )
    assert after == pytest.approx(before, abs=1e-12, nan_ok=True)


def test_areas_of_the_vertices_sum_to_the_mesh():
    mesh = flat(9)
    assert vertex_areas(mesh.vertices, mesh.triangles).sum() == pytest.approx(0.8)


def test_statistics_count_each_place_by_its_area():
    values = np.array([0.001, -0.003, 0.001, np.nan])
    found = deviation_statistics(values, np.array([1.0, 1.0, 2.0, 4.0]), 0.002)
    assert found.covered == pytest.approx(0.5)
    assert found.mean == pytest.approx(0.0)
    assert found.rms == pytest.approx(np.sqrt((1e-6 + 9e-6 + 2e-6) / 4))
    assert found.p95 == pytest.approx(0.003)
    assert (found.lowest, found.highest, found.largest) == pytest.approx((-0.003, 0.001, 0.003))
    assert found.within == pytest.approx(0.75)


def test_ninety_five_of_a_hundred_are_within_the_p95():
    values = np.linspace(-1.0, 1.0, 2001) ** 3
    found = deviation_statistics(values, np.ones(2001), 0.5)
    assert found.p95 == pytest.approx(np.quantile(np.abs(values), 0.95), abs=2e-3)


def test_where_nothing_was_compared_there_are_no_figures():
    assert deviation_statistics(np.array([np.nan]), np.ones(1), 0.001) is None


MOTION = Motion(rotations.exp(np.array([0.05, -0.03, 0.5])), np.array([0.1, 0.2, -0.05]))


def wavy(n):
    return sheet(n, lambda x, y: 0.1 * x * x + 0.15 * y**3 + 0.05 * x * y)


def test_alignment_finds_the_motion_back():
    mesh, reference = wavy(25), wavy(31)
    found = align(MOTION.applied(mesh.vertices), located(reference), reference.vertices)
    back = found.applied(MOTION.applied(mesh.vertices))
    assert np.nanmax(np.abs(deviation(back, located(reference)))) < 1e-4
    # Along itself a gentle surface is hardly held.
    assert np.linalg.norm(back - mesh.vertices, axis=1).max() < 8e-3
    assert found.angle == pytest.approx(MOTION.angle, abs=5e-3)


def test_alignment_is_a_rigid_motion_and_the_same_each_time():
    mesh, reference = wavy(15), wavy(21)
    moved = MOTION.applied(mesh.vertices)
    one = align(moved, located(reference), reference.vertices)
    two = align(moved, located(reference), reference.vertices)
    assert np.array_equal(one.rotation, two.rotation)
    assert np.array_equal(one.translation, two.translation)
    assert one.rotation.T @ one.rotation == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(one.rotation) == pytest.approx(1.0)


def test_with_noise_it_is_found_back_from_the_other_way_round():
    mesh, reference = wavy(25), wavy(31)
    turned = Motion(rotations.exp(np.array([0.0, 0.0, 2.8])), np.array([0.1, 0.0, 0.02]))
    noise = 2e-4 * np.random.default_rng(3).standard_normal(mesh.vertices.shape)
    moved = turned.applied(mesh.vertices + noise)
    found = align(moved, located(reference), reference.vertices)
    back = deviation(found.applied(moved), located(reference))
    assert np.sqrt(np.nanmean(back**2)) < 4e-4
    assert found.angle == pytest.approx(2.8, abs=0.05)


def test_what_fits_nearly_as_well_the_other_way_round_is_not_turned():
    """A dome with a ripple of a fifth the other way about: half of the miss, turned."""

    def dome(share):
        return sheet(31, lambda x, y: -0.2 * (x * x + y * y) + share * 5e-4 * np.sin(25.0 * x))

    reference, mesh = dome(1.0), dome(-0.3)
    found = align(mesh.vertices, located(reference), reference.vertices)
    assert found.angle < 0.1


def test_what_lies_right_is_left():
    mesh = wavy(20)
    found = align(mesh.vertices, located(mesh), mesh.vertices)
    assert found.applied(mesh.vertices) == pytest.approx(mesh.vertices, abs=1e-9)


def test_a_plane_over_a_larger_one_is_not_slid_along_it():
    small, large = sheet(9, lambda x, y: 0 * x * y, size=(0.3, 0.2)), flat(20)
    moved = small.vertices + np.array([0.02, 0.05, 0.003])
    found = align(moved, located(large), large.vertices)
    assert found.applied(moved) == pytest.approx(moved - [0.0, 0.0, 0.003], abs=1e-9)


def test_what_lies_apart_entirely_is_brought_over():
    mesh = wavy(15)
    found = align(mesh.vertices + 5.0, located(mesh), mesh.vertices)
    assert found.applied(mesh.vertices + 5.0) == pytest.approx(mesh.vertices, abs=1e-6)


def test_the_still_motion_moves_nothing():
    points = np.random.default_rng(7).normal(size=(5, 3))
    assert np.array_equal(STILL.applied(points), points)
    assert np.array_equal(STILL.turned(points), points)
    assert STILL.angle == 0.0
