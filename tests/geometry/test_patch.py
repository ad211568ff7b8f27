"""Laws of the patches: interpolation, geodesics, exact arcs, exact derivatives, symmetry."""

from functools import cache

import numpy as np
import pytest

from georibbon.geometry.correspondence import arrange
from georibbon.geometry.directions import safe_directions
from georibbon.geometry.frames import Strip, arc_angles, frames_from, unit
from georibbon.geometry.patch import (
    Patches,
    PatchGrid,
    PatchSet,
    basis,
    patch_grid,
    patches_at,
    patches_between,
)
from georibbon.geometry.rails import Rails, interpolant, sampled
from georibbon.geometry.reference import Bonnet, Cone, Torus
from georibbon.geometry.scheme import arc_lengths, control_of
from passes import passes, plane_passes, sphere_passes

V = np.linspace(0.0, 1.0, 21)
INSIDE = np.linspace(0.05, 0.9, 30)


@cache
def bonnet_model() -> PatchSet:
    places = [(0.0, 0.1), (0.0, 0.2), (0.02, 0.32)]
    strips = passes(Bonnet(), places, [0.0, 0.05, -0.05], shifts=[0.0, 0.03, -0.02])
    return patches_between(arrange(strips))


def bonnet_patches(u: np.ndarray = INSIDE) -> Patches:
    return patches_at(bonnet_model(), u)


def grid_of(patches: Patches) -> PatchGrid:
    normals = patches.rails.frames[..., 2]
    return patch_grid(patches.control, patches.slope, (normals[:-1], normals[1:]), V)


def bent_rails(turn: float, skew: float = 0.0) -> Rails:
    """Two passes along x, square to a circular arc of radius 1 that turns by `turn`."""
    angles = np.array([-0.5, 0.5]) * turn
    normals = np.stack([np.zeros(2), np.sin(angles), np.cos(angles)], axis=1)
    points = normals + np.array([[0.0, 0.0, 0.0], [skew, 0.0, 0.0]])
    frames = frames_from(np.tile([1.0, 0.0, 0.0], (2, 1)), normals)
    return Rails(points[:, None], frames[:, None])


def test_the_basis_interpolates_ends_and_slopes() -> None:
    ends = np.array([0.0, 1.0])
    assert np.array_equal(basis(ends), np.eye(4)[[0, 3]])
    assert np.array_equal(basis(ends, 1), np.eye(4)[[1, 2]])


@pytest.mark.parametrize("order", [1, 2])
def test_the_basis_derivatives_are_those_of_the_basis(order: int) -> None:
    h = 1e-4
    differences = (basis(V + h, order - 1) - basis(V - h, order - 1)) / (2.0 * h)
    assert np.allclose(basis(V, order), differences, atol=1e-7)


def test_interpolated_strips_keep_their_points_and_normals() -> None:
    strip = passes(Bonnet(), [(0.0, 0.3)], 0.2)[0]
    points, frames = sampled(interpolant(strip), strip.s)
    assert np.allclose(points, strip.points, atol=1e-12)
    assert np.allclose(frames[:, :, 2], strip.normals, atol=1e-7)
    assert np.allclose(frames[:, :, 0], strip.tangents, atol=1e-7)


def test_strips_of_four_points_are_interpolated_by_a_cubic() -> None:
    strip = plane_passes(0.0, nodes=4)[0]
    points, frames = sampled(interpolant(strip), np.array([0.1]))
    assert np.allclose(points, [[-0.38, 0.0, 0.0]])
    assert np.allclose(frames, np.eye(3))


def test_directions_are_unit_and_tangent() -> None:
    rails = bonnet_patches().rails
    for k, directions in enumerate(safe_directions(rails)):
        assert np.allclose(np.linalg.norm(directions, axis=-1), 1.0)
        normals = rails.frames[k : k + 2, :, :, 2]
        assert np.abs(np.sum(directions * normals, axis=-1)).max() < 1e-14


def test_ordinary_directions_are_the_chord_brought_into_the_tangent_plane() -> None:
    rails = bonnet_patches().rails
    c = unit(rails.chords)
    normals = rails.frames[:-1, :, :, 2]
    expected = unit(c - np.sum(c * normals, axis=-1, keepdims=True) * normals)
    assert np.allclose(safe_directions(rails)[0], expected, atol=1e-12)


@pytest.mark.parametrize("skew", [3.0, 30.0, -30.0])
def test_very_oblique_directions_stay_forward_and_continuous(skew: float) -> None:
    rails = bent_rails(0.5, skew)
    start, end = safe_directions(rails)
    assert np.sum(start * rails.frames[:-1, :, :, 1]) > 0.2
    assert np.sum(end * rails.frames[1:, :, :, 1]) > 0.2
    nearby = safe_directions(bent_rails(0.5, skew + 1e-6))[0]
    assert np.abs(nearby - start).max() < 1e-5


def test_passes_on_each_other_leave_along_their_conormals() -> None:
    rails = bent_rails(0.0)
    assert np.allclose(safe_directions(rails), [[[[0.0, 1.0, 0.0]]]] * 2)
    assert np.array_equal(arc_lengths(safe_directions(rails)[0], rails), [[1.0]])
    assert np.isfinite(control_of(rails)).all()


@pytest.mark.parametrize(("degrees", "error"), [(20.0, 1e-7), (60.0, 2.6e-5), (90.0, 2.1e-4)])
def test_circular_arcs_are_reproduced(degrees: float, error: float) -> None:
    """The radius is met within the known error of the cubic, relative to the chord."""
    rails = bent_rails(np.radians(degrees))
    points = basis(V) @ control_of(rails)[0, 0]
    chord = 2.0 * np.sin(np.radians(degrees) / 2.0)
    assert np.abs(np.linalg.norm(points, axis=1) - 1.0).max() / chord < error


def test_lambda_is_at_least_one_and_at_most_two() -> None:
    flat = bent_rails(0.1)
    back = np.array([[[0.0, -1.0, 0.0]]])
    assert np.allclose(arc_lengths(back, flat), 2.0)
    assert np.allclose(arc_lengths(-back, bent_rails(0.0, 1.0)), 2.0)
    assert np.allclose(arc_lengths(unit(flat.chords), flat), 1.0)


def test_patches_interpolate_their_passes() -> None:
    patches = bonnet_patches()
    grid = grid_of(patches)
    assert np.allclose(grid.points[:, :, 0], patches.rails.points[:-1], atol=1e-14)
    assert np.allclose(grid.points[:, :, -1], patches.rails.points[1:], atol=1e-14)


def test_patches_have_the_passes_normals_at_their_seams() -> None:
    """Tangent planes agree on both sides of every pass, so the surface is smooth across it."""
    patches = bonnet_patches()
    grid = grid_of(patches)
    normals = patches.rails.frames[..., 2]
    assert np.degrees(arc_angles(grid.normals[:, :, 0], normals[:-1])).max() < 1e-4
    assert np.degrees(arc_angles(grid.normals[:, :, -1], normals[1:])).max() < 1e-4


def test_passes_are_geodesics_of_the_surface() -> None:
    """Their curvature vector lies along the surface's normal, found from differences."""
    fine = np.linspace(0.1, 0.8, 300)
    patches = bonnet_patches(fine)
    for points, normals in zip(
        patches.rails.points, grid_of(patches).normals[:, :, 0], strict=False
    ):
        step = np.linalg.norm(np.diff(points, axis=0), axis=1)
        tangents = np.diff(points, axis=0) / step[:, None]
        curvature = np.diff(tangents, axis=0) / (0.5 * (step[1:] + step[:-1]))[:, None]
        sideways = np.cross(normals[1:-1], unit(tangents[1:] + tangents[:-1]))
        assert np.abs(np.sum(curvature * sideways, axis=1)).max() < 1e-3
        assert np.abs(np.sum(curvature * normals[1:-1], axis=1)).max() > 0.1


@pytest.mark.parametrize("u", [INSIDE, np.array([0.0, 0.5, 0.96])])
def test_derivatives_along_are_those_of_the_patch(u: np.ndarray) -> None:
    h = 1e-4
    inner = np.clip(u, 2 * h, 0.96 - 2 * h)
    here = bonnet_patches(inner)
    around = [bonnet_patches(inner + k * h).control for k in (-1, 0, 1)]
    assert np.allclose(here.slope, (around[2] - around[0]) / (2 * h), atol=1e-4)
    assert np.allclose(
        here.bend, (around[2] - 2 * around[1] + around[0]) / h**2, rtol=1e-2, atol=1e-2
    )
    ends = bonnet_patches(u)
    assert np.allclose(ends.slope, here.slope + (u - inner)[:, None, None] * here.bend, atol=1e-3)


def test_derivatives_across_are_those_of_the_patch() -> None:
    control = bonnet_patches().control
    h = 1e-5
    slope = (basis(V + h) - basis(V - h)) @ control / (2 * h)
    assert np.allclose(basis(V, 1) @ control, slope, atol=1e-9)


def test_the_surface_between_great_circles_is_the_sphere() -> None:
    patches = patches_at(patches_between(arrange(sphere_passes())), INSIDE)
    grid = grid_of(patches)
    assert np.abs(np.linalg.norm(grid.points, axis=-1) - 0.6).max() < 1e-8
    assert np.degrees(arc_angles(grid.normals, grid.points)).max() < 1e-3


def test_between_passes_square_to_a_ruling_of_a_cone_the_ruling_is_exact() -> None:
    strips = passes(Cone(30.0), [(0.3, 0.6), (0.3, 0.9)], length=0.5)
    grid = grid_of(patches_at(patches_between(arrange(strips)), np.array([0.25])))
    across = unit(grid.across[0, 0])
    assert np.allclose(across, across[0], atol=1e-9)
    assert np.allclose(np.abs(across[0] @ unit(grid.points[0, 0, 0])), 1.0, atol=1e-12)


def test_a_torus_is_met_with_the_third_order_or_better() -> None:
    errors = []
    for gap in (0.4, 0.2):
        strips = passes(Torus(0.5, 0.2), [(0.0, 0.3), (0.0, 0.3 + gap)], length=0.3)
        points = grid_of(
            patches_at(patches_between(arrange(strips)), np.linspace(0, 0.3, 9))
        ).points
        radius = np.hypot(points[..., 0], points[..., 1]) - 0.5
        errors.append(np.abs(np.hypot(radius, points[..., 2]) - 0.2).max())
    assert errors[0] / errors[1] > 8.0
    assert errors[1] < 5e-5


def test_from_the_other_side_it_is_the_same_patch() -> None:
    """Passes run backwards and in the other order: u and v swap ends, nothing else."""
    strips = passes(Bonnet(), [(0.0, 0.1), (0.0, 0.2)], [0.0, 0.05], shifts=[0.0, 0.04])
    model = patches_between(arrange(strips))
    mirrored = patches_between(arrange([strip.reversed() for strip in strips]))
    assert mirrored.arrangement.order == (1, 0)
    plain = grid_of(patches_at(model, INSIDE))
    back = grid_of(patches_at(mirrored, 0.96 - model.match(INSIDE)[1]))
    assert np.abs(back.points[0, :, ::-1] - plain.points[0]).max() < 1e-6
    assert np.abs(back.normals[0, :, ::-1] - plain.normals[0]).max() < 1e-5


def test_pinched_points_do_not_count_as_folded() -> None:
    zero = np.zeros((1, 2, 3, 3))
    grid = PatchGrid(zero, zero, zero, np.tile([0.0, 0.0, 1.0], (1, 2, 3, 1)))
    assert np.array_equal(grid.turn, np.ones((1, 2, 3)))
    assert np.array_equal(grid.normals[0, 0, 0], [0.0, 0.0, 1.0])


def test_a_folded_patch_has_negative_turn_and_the_blended_normals() -> None:
    strips = plane_passes(0.0, 0.1)
    wrong = Strip(strips[1].s, strips[1].points * [1.0, -1.0, 1.0], strips[1].frames)
    control = control_of(
        Rails(np.stack([strips[0].points, wrong.points]), np.stack([s.frames for s in strips]))
    )
    slope = np.zeros_like(control)
    slope[:, :, [0, 3]] = [1.0, 0.0, 0.0]
    up = np.tile([0.0, 0.0, 1.0], (1, 97, 1))
    grid = patch_grid(control, slope, (up, up), V)
    assert grid.turn.min() == pytest.approx(-1.0)
    assert np.allclose(grid.normals, [0.0, 0.0, 1.0])
