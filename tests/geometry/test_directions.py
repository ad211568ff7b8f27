"""Laws of the directions across and of the angles of least torsion."""

import numpy as np
import pytest

from georibbon.geometry.correspondence import arrange
from georibbon.geometry.directions import (
    angled_directions,
    angles_of,
    at_angles,
    directions_of,
    safe_directions,
)
from georibbon.geometry.fairness import derivative_rows
from georibbon.geometry.frames import Strip, frames_from, unit
from georibbon.geometry.patch import basis, patches_between, rails_at
from georibbon.geometry.rails import Rails
from georibbon.geometry.reference import Bonnet, Torus
from georibbon.geometry.scheme import arc_lengths, hermite_control
from georibbon.geometry.settings import DIRECTIONS
from georibbon.geometry.torsion import REACH, least_torsion_angles, linear_fit, torsions
from passes import passes, plane_passes

SHARE = np.linspace(0.0, 1.0, 33)
RAMP = np.stack([1.0 - SHARE, SHARE], axis=1)


def rails_of(strips: list[Strip]) -> Rails:
    model = patches_between(arrange(strips))
    return rails_at(model, 0.96 * SHARE)


def bonnet_rails() -> Rails:
    places = [(0.0, 0.1), (0.0, 0.2), (0.02, 0.32)]
    return rails_of(passes(Bonnet(), places, [0.0, 0.05, -0.05], shifts=[0.0, 0.05, -0.03]))


def torus_rails() -> Rails:
    return rails_of(passes(Torus(), [(0.0, 0.0), (0.0, 0.4), (0.0, 0.8)], [0.0, 0.1, 0.0]))


@pytest.mark.parametrize("kind", DIRECTIONS)
def test_directions_are_unit_square_to_the_normals_and_lead_across(kind: str) -> None:
    rails = bonnet_rails()
    for k, directions in enumerate(directions_of(rails, kind)):
        frames = rails.frames[k : k + 2]
        assert np.allclose(np.linalg.norm(directions, axis=-1), 1.0)
        assert np.abs(np.sum(directions * frames[..., 2], axis=-1)).max() < 1e-14
        assert (np.sum(directions * frames[..., 1], axis=-1) > 0.5).all()


def test_the_safe_chord_is_the_chord_unless_it_turns_back() -> None:
    rails = bonnet_rails()
    for plain, safe in zip(directions_of(rails, "chord"), safe_directions(rails), strict=True):
        assert np.allclose(plain, safe, atol=1e-12)
    back = plane_passes(0.0, 0.1, shifts=[0.0, 3.0])
    rails = Rails(np.stack([s.points for s in back]), np.stack([s.frames for s in back]))
    plain, safe = directions_of(rails, "chord")[0], safe_directions(rails)[0]
    assert np.allclose(plain, unit(rails.chords))
    assert (safe[..., 1] > plain[..., 1] + 0.1).all()


def test_a_chord_that_stands_upright_leads_along_the_conormal() -> None:
    frames = np.tile(np.eye(3), (2, 1, 1, 1))
    rails = Rails(np.array([[[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.1]]]), frames)
    for kind in ("chord", "safe-chord"):
        assert np.allclose(directions_of(rails, kind), [[[[0.0, 1.0, 0.0]]]] * 2)


@pytest.mark.parametrize("kind", DIRECTIONS)
def test_passes_on_each_other_leave_along_their_conormals(kind: str) -> None:
    rails = Rails(np.zeros((2, 1, 3)), np.tile(np.eye(3), (2, 1, 1, 1)))
    assert np.allclose(directions_of(rails, kind), [[[[0.0, 1.0, 0.0]]]] * 2)
    angled = angled_directions(rails, np.ones((1, 1, 2)))
    assert np.allclose(angled, [[[[0.0, 1.0, 0.0]]]] * 2)


def test_lines_in_a_section_have_no_torsion() -> None:
    rails = torus_rails()
    start, end = directions_of(rails, "section")
    lengths = arc_lengths(start, rails), arc_lengths(end, rails)
    control = hermite_control(rails, (start, end), lengths)
    first, second, third = (basis(np.linspace(0, 1, 9), k) @ control for k in (1, 2, 3))
    size = np.linalg.norm(first, axis=-1) * np.linalg.norm(second, axis=-1)
    triple = np.sum(np.cross(first, second) * third, axis=-1)
    assert np.abs(triple / (size * np.linalg.norm(third, axis=-1) + 1e-12)).max() < 1e-10
    both = rails.frames[:-1, :, :, 2] + rails.frames[1:, :, :, 2]
    side = np.cross(rails.chords, both)
    assert np.abs(np.sum(side * start, axis=-1)).max() < 1e-14


def test_angles_and_directions_are_each_others_inverse() -> None:
    frames = bonnet_rails().frames
    angles = np.random.default_rng(3).uniform(-1.5, 1.5, frames.shape[:2])
    assert np.allclose(angles_of(at_angles(frames, angles), frames), angles)
    level = frames_from(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    assert np.allclose(at_angles(level, np.array(np.pi / 6)), [0.5, np.sqrt(0.75), 0.0])


@pytest.mark.parametrize("rails", [bonnet_rails(), torus_rails()], ids=["bonnet", "torus"])
def test_the_torsions_slopes_are_their_derivatives(rails: Rails) -> None:
    x = np.random.default_rng(4).normal(0.0, 0.2, (2, 4))
    _, slopes = torsions(rails, x, RAMP)
    for k in range(4):
        step = 1e-6 * np.eye(4)[k]
        change = torsions(rails, x + step, RAMP)[0] - torsions(rails, x - step, RAMP)[0]
        exact = slopes[:, :, k]
        assert np.abs(change / 2e-6 - exact).max() < 1e-6 * np.abs(exact).max()


def test_the_torsion_is_that_of_the_lines() -> None:
    rails = torus_rails()
    x = np.full((2, 4), 0.1)
    theta = torsions(rails, x, RAMP)[0].reshape(2, 33, 8)
    angles = np.full((2, 33, 2), 0.1)
    directions = angled_directions(rails, angles)
    ones = np.ones_like(rails.gaps)
    control = hermite_control(rails, directions, (ones, ones)) / rails.gaps[..., None, None]
    places, weights = np.polynomial.legendre.leggauss(8)
    first, second, third = (basis(0.5 * (places + 1.0), k) @ control for k in (1, 2, 3))
    cross = np.cross(first, second)
    expected = np.sum(cross * third, axis=-1) / (np.sum(cross**2, axis=-1) + 1e-3)
    assert np.allclose(theta, expected * np.sqrt(0.5 * weights))
    assert derivative_rows(places).shape == (3, 8, 3)


def test_the_least_torsion_is_found_within_its_bounds() -> None:
    rails = torus_rails()
    angles, unsettled, bounded = least_torsion_angles(rails, SHARE)
    start = linear_fit(rails, RAMP)
    flat = angles.reshape(2, 4)
    assert (np.abs(flat - start) <= REACH + 1e-12).all()
    assert not unsettled.any()
    gradient = np.stack(
        [
            np.sum(torsions(rails, flat + step, RAMP)[0] ** 2, axis=1)
            - np.sum(torsions(rails, flat - step, RAMP)[0] ** 2, axis=1)
            for step in 1e-5 * np.eye(4)
        ],
        axis=1,
    )
    free = np.where(gradient > 0.0, flat > start - REACH + 1e-6, flat < start + REACH - 1e-6)
    assert np.abs(gradient * free).max() < 1e-4 * np.abs(gradient).max() + 1e-8
    assert np.array_equal(bounded, (np.abs(flat - start) > REACH - 1e-6).any(axis=1))
    least, before = (np.sum(torsions(rails, x, RAMP)[0] ** 2, axis=1) for x in (flat, start))
    assert (least < before).all()


def test_on_a_plane_there_is_no_torsion_and_the_angles_stay() -> None:
    rails = rails_of(plane_passes(0.0, 0.1))
    angles, unsettled, bounded = least_torsion_angles(rails, SHARE)
    assert np.abs(angles).max() < 1e-12
    assert not unsettled.any()
    assert not bounded.any()
