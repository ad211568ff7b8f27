"""Laws of the lines that run on over all passes: least energy, smoothness, curvature."""

import numpy as np
import pytest

from georibbon.geometry.correspondence import arrange
from georibbon.geometry.frames import arc_angles, unit
from georibbon.geometry.interior import (
    CUBIC,
    QUINTIC,
    block_solved,
    energy,
    line_widths,
    quintic_control,
    smooth_directions,
)
from georibbon.geometry.patch import (
    Patches,
    basis,
    natural_parameters,
    patch_grid,
    patches_at,
    patches_between,
    rails_at,
)
from georibbon.geometry.rails import Rails
from georibbon.geometry.reference import Bonnet, Ellipsoid, Torus
from georibbon.geometry.settings import SurfaceSettings
from passes import passes, plane_passes, sphere_passes

V = np.linspace(0.0, 1.0, 9)
INSIDE = np.linspace(0.1, 0.85, 25)


def rails_of(count: int = 4) -> Rails:
    places = [(0.0, 0.1 * k - 0.2) for k in range(count)]
    angles = [0.0, 0.05, -0.04, 0.0, 0.03][:count]
    return rails_at(patches_between(arrange(passes(Bonnet(), places, angles))), INSIDE)


def patches_of(interior: str, surface: object, gap: float = 0.1, count: int = 4) -> Patches:
    places = [(0.0, gap * (k - 0.5 * (count - 1))) for k in range(count)]
    strips = passes(surface, places, length=0.96)
    return patches_at(patches_between(arrange(strips), SurfaceSettings(interior=interior)), INSIDE)


@pytest.mark.parametrize(("table", "orders"), [(CUBIC, 2), (QUINTIC, 3)])
def test_bases_hold_values_and_derivatives_at_both_ends(table: np.ndarray, orders: int) -> None:
    for k in range(2 * orders):
        polynomial = np.polynomial.Polynomial(table[:, k])
        found = [
            (polynomial.deriv(n) if n else polynomial)(end) for end in (0, 1) for n in range(orders)
        ]
        assert np.allclose(found, np.eye(2 * orders)[k], atol=1e-12)


@pytest.mark.parametrize("order", [2, 3])
def test_energies_are_integrals(order: int) -> None:
    places, weights = np.polynomial.legendre.leggauss(8)
    values = [
        np.polynomial.Polynomial(QUINTIC[:, k]).deriv(order)(0.5 * (places + 1)) for k in range(6)
    ]
    expected = np.array([[weights @ (a * b) / 2 for b in values] for a in values])
    assert np.allclose(energy(QUINTIC, order), expected)


def test_beams_bend_as_in_any_textbook() -> None:
    beam = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    assert np.allclose(energy(CUBIC, 2), beam)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_block_elimination_solves_the_whole_system(count: int) -> None:
    random = np.random.default_rng(7)
    square = random.normal(size=(count, 3, 4, 4))
    diagonal = square @ np.swapaxes(square, -1, -2) + 20.0 * np.eye(4)
    coupling = random.normal(size=(count - 1, 3, 4, 4))
    side = random.normal(size=(count, 3, 4))
    whole = np.zeros((3, 4 * count, 4 * count))
    for i in range(count):
        at = slice(4 * i, 4 * i + 4)
        whole[:, at, at] = diagonal[i]
        if i:
            whole[:, 4 * i - 4 : 4 * i, at] = coupling[i - 1]
            whole[:, at, 4 * i - 4 : 4 * i] = np.swapaxes(coupling[i - 1], -1, -2)
    found = np.moveaxis(block_solved(diagonal, coupling, side), 0, 1).reshape(3, -1)
    assert np.allclose(whole @ found[..., None], np.moveaxis(side, 0, 1).reshape(3, -1, 1))


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_both_kinds_of_lines_leave_in_the_tangent_planes(count: int) -> None:
    rails = rails_of(count)
    normals = rails.frames[..., 2]
    directions = smooth_directions(rails)
    assert directions.shape == rails.points.shape
    assert np.allclose(np.linalg.norm(directions, axis=-1), 1.0)
    assert np.abs(np.sum(directions * normals, axis=-1)).max() < 1e-12
    control = quintic_control(rails)
    assert np.abs(np.sum(unit(control[:, :, 1]) * normals[:-1], axis=-1)).max() < 1e-12
    assert np.abs(np.sum(unit(control[:, :, 4]) * normals[1:], axis=-1)).max() < 1e-12
    assert np.array_equal(control[:, :, 0], rails.points[:-1])
    assert np.array_equal(control[:, :, 5], rails.points[1:])


def lines_energy(control: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """(k,) the quintic lines' energy, in mean distances of passes, from their derivatives."""
    places, weights = np.polynomial.legendre.leggauss(8)
    v = 0.5 * (places + 1.0)
    total = 0.0
    for order, weight in ((3, 1.0), (2, 1e-2)):
        square = np.sum((basis(v, order, 6) @ control) ** 2, axis=-1) @ (0.5 * weights)
        total = total + weight * square / widths ** (2 * order - 1)
    return np.sum(total, axis=0)


def test_no_neighbouring_quintic_has_less_energy() -> None:
    """Moved tangents and second derivatives, the same on both sides of each pass."""
    rails = rails_of()
    control = quintic_control(rails)
    widths, mean = line_widths(rails)
    least = lines_energy(control / mean[:, None, None], widths)
    random = np.random.default_rng(9)
    for _ in range(20):
        turn = np.einsum(
            "pkij,pkj->pki", rails.frames[..., :2], random.normal(size=(4, len(INSIDE), 2))
        )
        bend = random.normal(size=(4, len(INSIDE), 3))
        moved = control.copy()
        for side, rows in ((slice(None, -1), (1, 2)), (slice(1, None), (4, 3))):
            moved[:, :, rows[0]] += 1e-4 * widths[..., None] * turn[side]
            moved[:, :, rows[1]] += 1e-4 * widths[..., None] ** 2 * bend[side]
        assert (lines_energy(moved / mean[:, None, None], widths) > least).all()


def test_lines_run_on_in_one_direction_across_every_pass() -> None:
    """Separate chords make a kink of some degrees; the smooth lines none."""
    kinks = {}
    for interior in ("g1", "c1-lines", "g2"):
        control = patches_of(interior, Ellipsoid(0.6, 0.4, 0.3)).control
        v = np.array([0.0, 1.0])
        ahead = basis(v, 1, control.shape[-2]) @ control
        kinks[interior] = np.degrees(arc_angles(ahead[:-1, :, 1], ahead[1:, :, 0]).max())
    assert kinks["g1"] > 1.0
    assert kinks["c1-lines"] < 1e-4
    assert kinks["g2"] < 1e-4


def normal_curvatures(patches: Patches, side: int, v: float) -> np.ndarray:
    """(p-2, k) curvature across, at v of the patches before (0) or after (1) the inner passes."""
    which = slice(None, -1) if side == 0 else slice(1, None)
    control, slope, bend = patches.control[which], patches.slope[which], patches.bend[which]
    count, at = control.shape[-2], np.array([v])
    fu, fv = (basis(at, k, count) @ c for k, c in ((0, slope), (1, control)))
    normals = unit(np.cross(fu, fv))
    second = [
        np.sum((basis(at, k, count) @ c) * normals, axis=-1)
        for k, c in ((0, bend), (1, slope), (2, control))
    ]
    # The direction square to the pass in terms of the two derivatives.
    across = fv - fu * np.sum(fu * fv, axis=-1, keepdims=True) / np.sum(fu * fu, axis=-1)[..., None]
    ratio = -np.sum(fu * fv, axis=-1) / np.sum(fu * fu, axis=-1)
    form = second[0] * ratio**2 + 2.0 * second[1] * ratio + second[2]
    return (form / np.sum(across * across, axis=-1))[..., 0]


@pytest.mark.parametrize("surface", [Bonnet(), Torus(0.5, 0.2)], ids=["bonnet", "torus"])
def test_quintic_lines_give_the_surface_one_curvature_on_both_sides(surface: object) -> None:
    """The jump over a shrinking step goes to zero; that of cubic lines does not."""
    gap = 0.4 if isinstance(surface, Torus) else 0.1
    jumps = {}
    for interior in ("g1", "g2"):
        patches = patches_of(interior, surface, gap)
        jumps[interior] = [
            np.abs(
                normal_curvatures(patches, 0, 1.0 - step) - normal_curvatures(patches, 1, step)
            ).max()
            for step in (0.1, 0.01, 0.0)
        ]
    assert jumps["g2"][2] < 1e-3
    assert jumps["g2"][1] < 0.3 * jumps["g2"][0] or jumps["g2"][0] < 1e-2
    assert jumps["g1"][2] > 10.0 * jumps["g2"][2]


@pytest.mark.parametrize("interior", ["g1", "c1-lines", "g2"])
def test_on_a_plane_all_lines_are_the_plane(interior: str) -> None:
    strips = plane_passes(0.0, 0.1, 0.25, shifts=[0.0, 0.05, 0.0])
    model = patches_between(arrange(strips), SurfaceSettings(interior=interior))
    patches = patches_at(model, natural_parameters(model))
    normals = patches.rails.frames[..., 2]
    grid = patch_grid(patches.control, patches.slope, (normals[:-1], normals[1:]), V)
    assert np.abs(grid.points[..., 2]).max() < 1e-12
    assert np.allclose(grid.normals, [0.0, 0.0, 1.0], atol=1e-9)


def test_quintic_lines_are_more_exact_where_the_surface_is_smooth() -> None:
    """And between two passes alone they are determined too."""
    strips = sphere_passes([-0.05, 0.05])
    model = patches_between(arrange(strips), SurfaceSettings(interior="g2"))
    control = patches_at(model, natural_parameters(model)).control
    radius = np.linalg.norm(basis(V, 0, 6) @ control, axis=-1)
    assert np.abs(radius - 0.6).max() < 2e-5
