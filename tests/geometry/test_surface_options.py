"""Laws that hold for every choice of how the surface is laid through its passes."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.geometry.checks import Check
from georibbon.geometry.closest import closest_point
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.frames import Strip, arc_angles, unit
from georibbon.geometry.mesh import is_oriented
from georibbon.geometry.patch import Patches, basis, patch_grid, patches_at, patches_between
from georibbon.geometry.reference import Bonnet, Cylinder, Ellipsoid, ReferenceSurface, Torus
from georibbon.geometry.settings import (
    CORRESPONDENCES,
    DIRECTIONS,
    INTERIORS,
    LENGTHS,
    SurfaceSettings,
)
from georibbon.geometry.surface import Surface, build_surface, rebuilt
from passes import moved, passes, sphere_passes

CHOICES = [
    *({"direction": word} for word in DIRECTIONS[1:]),
    *({"lengths": word} for word in LENGTHS[1:]),
    {"lengths": (1.2, 0.9)},
    *({"correspondence": word} for word in CORRESPONDENCES[1:]),
    *({"interior": word} for word in INTERIORS[1:]),
    {"direction": "angles", "angles": (4.0, -3.0, -2.0, 5.0)},
    {"direction": "section", "lengths": "bending"},
    {"interior": "c1-lines", "lengths": "criterion1"},
    {"interior": "c1-lines", "lengths": "criterion4"},
]
V = np.linspace(0.0, 1.0, 21)
U = np.linspace(0.1, 0.85, 60)


def named(choice: dict[str, object]) -> str:
    return " ".join(str(value) for value in choice.values())


every_choice = pytest.mark.parametrize("choice", CHOICES, ids=named)


@cache
def bonnet_strips() -> list[Strip]:
    places = [(0.0, 0.1 * k - 0.1) for k in range(3)]
    return passes(Bonnet(), places, [0.0, 0.04, -0.04], shifts=[0.0, 0.03, -0.02])


@cache
def level_strips() -> list[Strip]:
    return passes(Bonnet(), [(0.0, 0.1 * k - 0.1) for k in range(3)], [0.0, 0.04, -0.04])


def patches_of(
    strips: Sequence[Strip], choice: dict[str, object], u: np.ndarray | None = None
) -> Patches:
    model = patches_between(arrange(strips), SurfaceSettings(**choice))
    first, last = model.match.ends[model.match.middle]
    return patches_at(model, np.linspace(first, last, 60) if u is None else u)


def built(strips: Sequence[Strip], choice: dict[str, object], **more: object) -> Surface:
    names = [f"P{k + 1}" for k in range(len(strips))]
    return build_surface(strips, names, SurfaceSettings(**choice, **more))


def derivative(patches: Patches, v: float, order: int = 1) -> np.ndarray:
    """(p-1, k, 3) the derivative across at one v."""
    control = patches.control
    return (basis(np.array([v]), order, control.shape[-2]) @ control)[:, :, 0]


def rms_error(surface: ReferenceSurface, patches: Patches) -> float:
    points = basis(V, 0, patches.control.shape[-2]) @ patches.control
    away = closest_point(surface, points.reshape(-1, 3)).distance
    return float(np.sqrt(np.mean(away**2)))


@every_choice
def test_patches_meet_their_passes_and_leave_in_the_tangent_planes(
    choice: dict[str, object],
) -> None:
    patches = patches_of(bonnet_strips(), choice)
    control, rails = patches.control, patches.rails
    ends = basis(np.array([0.0, 1.0]), 0, control.shape[-2]) @ control
    assert np.allclose(ends[:, :, 0], rails.points[:-1], atol=1e-14)
    assert np.allclose(ends[:, :, 1], rails.points[1:], atol=1e-13)
    normals = rails.frames[..., 2]
    for v, facing in ((0.0, normals[:-1]), (1.0, normals[1:])):
        across = unit(derivative(patches, v))
        assert np.abs(np.sum(across * facing, axis=-1)).max() < 1e-11
        conormals = rails.frames[:-1, :, :, 1] if v == 0.0 else rails.frames[1:, :, :, 1]
        assert (np.sum(across * conormals, axis=-1) > 0.3).all()


@every_choice
def test_passes_are_geodesics_of_the_surface(choice: dict[str, object]) -> None:
    """On both sides of every pass its curvature vector lies along the surface's normal."""
    model_u = np.linspace(0.25, 0.55, 200)
    patches = patches_of(bonnet_strips(), choice, model_u)
    normals = patches.rails.frames[..., 2]
    grid = patch_grid(patches.control, patches.slope, (normals[:-1], normals[1:]), V[[0, -1]])
    sides = ((patches.rails.points[:-1], 0), (patches.rails.points[1:], 1))
    for points, column in sides:
        facing = unit(np.cross(grid.along[:, :, column], grid.across[:, :, column]))
        step = np.linalg.norm(np.diff(points, axis=1), axis=-1, keepdims=True)
        tangents = np.diff(points, axis=1) / step
        bend = np.diff(tangents, axis=1) / (0.5 * (step[:, 1:] + step[:, :-1]))
        sideways = np.cross(facing[:, 1:-1], unit(tangents[:, 1:] + tangents[:, :-1]))
        assert np.abs(np.sum(bend * sideways, axis=-1)).max() < 2e-3
        assert np.abs(np.sum(bend * facing[:, 1:-1], axis=-1)).max() > 0.1


@every_choice
def test_seams_are_smooth(choice: dict[str, object]) -> None:
    patches = patches_of(bonnet_strips(), choice)
    normals = patches.rails.frames[..., 2]
    grid = patch_grid(patches.control, patches.slope, (normals[:-1], normals[1:]), V[[0, -1]])
    for column, facing in ((0, normals[:-1]), (1, normals[1:])):
        assert np.degrees(arc_angles(grid.normals[:, :, column], facing)).max() < 2e-4


@every_choice
def test_the_surface_moves_with_its_passes(choice: dict[str, object]) -> None:
    strips = bonnet_strips()
    turn, shift = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix(), np.array([5.0, -2.0, 1.0])
    plain = patches_of(strips, choice)
    other = patches_of([moved(strip, turn, shift) for strip in strips], choice)
    expected = plain.control @ turn.T
    expected[:, :, [0, -1]] += shift
    assert np.allclose(other.control, expected, atol=1e-7)


@every_choice
def test_twice_the_passes_is_twice_the_surface(choice: dict[str, object]) -> None:
    strips = bonnet_strips()
    large = [Strip(2.0 * strip.s, 2.0 * strip.points, strip.frames) for strip in strips]
    plain, other = patches_of(strips, choice), patches_of(large, choice)
    assert np.allclose(other.control, 2.0 * plain.control, atol=1e-7)
    assert np.allclose(other.slope, plain.slope, atol=1e-3)


@pytest.mark.parametrize(
    "choice",
    [one for one in CHOICES if "angles" not in one and one.get("lengths") != (1.2, 0.9)],
    ids=named,
)
def test_from_the_other_side_it_is_the_same_surface(choice: dict[str, object]) -> None:
    """Passes run backwards, in the other order across: the same lines, run the other way.

    Passes measured from their other ends agree where lengths are equal.
    """
    strips = level_strips()
    plain = patches_of(strips, choice)
    back = patches_of([strip.reversed() for strip in strips], choice)
    points = basis(V, 0, plain.control.shape[-2])
    mirrored = (points @ back.control)[::-1, ::-1, ::-1]
    assert np.abs(mirrored - points @ plain.control).max() < 2e-5


def sphere_error(gap: float, choice: dict[str, object]) -> float:
    strips = sphere_passes([-gap, 0.0, gap], length=0.6)
    return rms_error(Ellipsoid(), patches_of(strips, choice))


@cache
def torus_strips(gap: float) -> list[Strip]:
    return passes(
        Torus(0.5, 0.2), [(0.0, 0.3 + gap / 0.2 * k) for k in (-1, 0, 1)], length=0.4, count=49
    )


def torus_error(gap: float, choice: dict[str, object]) -> float:
    torus = Torus(0.5, 0.2)
    return rms_error(torus, patches_of(torus_strips(gap), choice))


ACCURATE = [
    {"direction": "chord"},
    {"direction": "section"},
    *({"lengths": word} for word in LENGTHS[1:] if word not in {"criterion3", "criterion4"}),
    {"interior": "c1-lines"},
    {"interior": "g2"},
]


@pytest.mark.parametrize("choice", ACCURATE, ids=named)
@pytest.mark.parametrize("error", [sphere_error, torus_error])
def test_the_error_falls_with_the_third_order_of_the_gap_or_faster(
    error: Callable[[float, dict[str, object]], float], choice: dict[str, object]
) -> None:
    coarse, fine = error(0.12, choice), error(0.06, choice)
    assert coarse < 2e-4
    assert coarse / fine > 7.0 or fine < 1e-9


@cache
def ring_strips() -> list[Strip]:
    return passes(Cylinder(), [(0.0, 0.1 * k) for k in range(3)], length=0.8)


@pytest.mark.parametrize("interior", INTERIORS)
@pytest.mark.parametrize("lengths", ["arc", "unit", "criterion1", "criterion2", "bending"])
def test_between_rings_around_a_cylinder_the_surface_is_exact(interior: str, lengths: str) -> None:
    patches = patches_of(ring_strips(), {"interior": interior, "lengths": lengths})
    assert rms_error(Cylinder(), patches) < 1e-8


@every_choice
def test_every_choice_gives_a_mesh_and_a_preview_of_it(choice: dict[str, object]) -> None:
    strips = bonnet_strips()
    surface = built([strips[0], strips[1].reversed(), strips[2]], choice, tolerance=2e-4)
    rows, columns = surface.shape
    assert len(surface.mesh.vertices) == rows * columns
    assert is_oriented(surface.mesh)
    assert np.allclose(np.linalg.norm(surface.mesh.normals, axis=1), 1.0)
    again = rebuilt(surface, [strips[0], strips[1].reversed(), strips[2]])
    assert np.array_equal(again.mesh.vertices, surface.mesh.vertices)


def checks_of(surface: Surface, code: str) -> list[Check]:
    return [check for check in surface.checks if check.code == code]


def test_what_a_criterion_settled_is_told_only_where_one_was_chosen() -> None:
    assert not checks_of(built(bonnet_strips(), {}), "tangent-lengths")
    told = checks_of(built(bonnet_strips(), {"lengths": "criterion1"}), "tangent-lengths")
    assert [(check.where, check.verdict, check.value) for check in told] == [
        ("P1-P2", "pass", 0.0),
        ("P2-P3", "pass", 0.0),
    ]
    assert told[0].message == "the tangent lengths between P1-P2 minimise the criterion chosen"


def test_lengths_that_run_into_their_bounds_are_told_with_advice() -> None:
    """The squared torsion of strongly twisted lines falls as they grow without end."""
    strips = passes(Torus(), [(0.0, 0.0), (0.0, 1.2)], [0.3, -0.3], length=0.5)
    told = checks_of(built(strips, {"lengths": "criterion3"}, tolerance=1e-3), "tangent-lengths")
    assert told[0].verdict == "warn"
    assert told[0].value > 1.0
    assert told[0].message.endswith("lie at the bounds: choose those of an arc")


def test_the_fourth_criterion_tells_of_directions() -> None:
    told = checks_of(built(bonnet_strips(), {"lengths": "criterion4"}), "tangent-lengths")
    assert told[0].message.startswith("the directions between P1-P2 minimise")


@pytest.mark.parametrize("rule", CORRESPONDENCES)
def test_the_overlap_is_told_where_feet_were_asked_for(rule: str) -> None:
    told = checks_of(built(bonnet_strips(), {"correspondence": rule}), "overlap")
    assert bool(told) == rule.startswith("foot")


def test_cut_to_the_overlap_the_surface_is_smaller_and_nowhere_askew() -> None:
    strips = passes(Bonnet(), [(0.0, 0.0), (0.0, 0.1)], shifts=[0.0, 0.3])
    whole, cut = built(strips, {}), built(strips, {"correspondence": "foot-trim"})
    assert cut.area < 0.85 * whole.area
    assert checks_of(whole, "skew")[0].value > 0.8
    assert checks_of(cut, "skew")[0].value < 0.2
    drifts = zip(checks_of(whole, "heading-drift"), checks_of(cut, "heading-drift"), strict=True)
    assert all(one.value == other.value for one, other in drifts)


def test_coinciding_stretches_are_bridged_by_every_criterion() -> None:
    """Two passes that touch in the middle: no number is lost there."""
    strips = sphere_passes([0.0, 0.05], length=0.5)
    bent = strips[1].points.copy()
    near = np.abs(strips[1].s - 0.25) < 0.02
    bent[near] = strips[0].points[near]
    touching = [strips[0], Strip(strips[1].s, bent, strips[1].frames)]
    for choice in CHOICES:
        assert np.isfinite(patches_of(touching, choice).control).all()
