"""Statements of the derivations in docs that nothing else tests: numbers, orders, limits."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from georibbon.geometry.arch import arch_strips
from georibbon.geometry.binormals import bend_of
from georibbon.geometry.correspondence import absorbed
from georibbon.geometry.fairness import CRITERIA, Quadrature, lines_between
from georibbon.geometry.frames import curvatures, frames_from
from georibbon.geometry.frenet import curvature_vectors, curve_through, frenet
from georibbon.geometry.interior import line_widths
from georibbon.geometry.patch import basis
from georibbon.geometry.rails import Rails
from georibbon.geometry.surface import blended
from georibbon.rotations import about_z
from georibbon.world import UP, field_direction

CHORD = np.array([1.0, 0.0, 0.0])


def leaning(*angles):
    """(k, 3) unit vectors at angles from the chord within one plane."""
    return np.array([[np.cos(a), np.sin(a), 0.0] for a in angles])


@pytest.fixture(scope="module")
def geodesic():
    return arch_strips(5, 481)[1]


def test_the_roll_in_a_frame_that_does_not_turn_changes_by_the_geodesic_torsion(geodesic):
    s = geodesic.s
    tangents, bent = curvature_vectors(curve_through(s, geodesic.points), s)
    roll = bend_of(s, geodesic.points, tangents, bent).roll(geodesic.normals)
    torsion = curvatures(geodesic)[1]
    inner = slice(5, -5)
    assert np.abs(torsion).max() > 0.5
    assert np.gradient(roll, s)[inner] == pytest.approx(torsion[inner], abs=1e-6)


def test_the_torsion_of_a_geodesic_is_its_geodesic_torsion_whichever_way_it_bends(geodesic):
    s, inner = geodesic.s, slice(20, -20)
    torsion = curvatures(geodesic)[1]
    found = frenet(curve_through(s, geodesic.points), s).torsion
    # The surface's third derivatives jump where its knots are.
    assert found[inner] == pytest.approx(torsion[inner], abs=0.01)
    mirrored = frenet(curve_through(s, geodesic.points * np.array([1.0, 1.0, -1.0])), s).torsion
    assert mirrored == pytest.approx(-found, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "factor"),
    [("criterion1", 1 / 6), ("criterion2", 0.25), ("bending", 0.25), ("curvature-variation", 0.25)],
)
def test_where_the_minimum_lies_on_lines_that_turn_little(name, factor):
    turn = 0.1
    lines = lines_between(CHORD[None], leaning(turn), leaning(-turn))
    rule = Quadrature(CRITERIA[name], 16)
    found = minimize_scalar(
        lambda x: rule(lines, np.full((1, 2), x))[0, 0],
        bounds=(-0.02, 0.02),
        method="bounded",
        options={"xatol": 1e-10},
    )
    assert np.expm1(found.x) / turn**2 == pytest.approx(factor, abs=2e-3)


def test_two_criteria_vanish_with_long_tangents_and_the_first_rises():
    turned = np.array([[np.cos(0.4), -0.2, 0.3]])
    lines = lines_between(CHORD[None], leaning(0.3), turned / np.linalg.norm(turned))
    values = {
        name: [
            float(Quadrature(CRITERIA[name], 64)(lines, np.full((1, 2), np.log(far)))[0, 0])
            for far in (1e2, 1e3)
        ]
        for name in ("criterion1", "criterion2-vector", "criterion3", "bending")
    }
    for name, power in (("criterion1", 2), ("criterion2-vector", -2), ("criterion3", -4)):
        near, far = values[name]
        assert np.log10(far / near) == pytest.approx(power, abs=0.1), name
    assert values["bending"][0] == pytest.approx(values["bending"][1], rel=0.05)


def test_a_line_with_arc_lengths_leaves_the_arc_with_the_sixth_power_of_its_turn():
    v = np.linspace(0.0, 1.0, 401)
    away = []
    for turn in np.radians([30.0, 60.0, 90.0]):
        half = 0.5 * turn
        radius, middle = 0.5 / np.sin(half), np.array([0.5, -0.5 / np.tan(half), 0.0])
        length = 2.0 / (1.0 + np.cos(half))
        control = np.vstack([np.zeros(3), length * leaning(half, -half), CHORD])
        line = basis(v) @ control
        away.append(np.abs(np.linalg.norm(line - middle, axis=1) - radius).max())
    assert away[1:] == pytest.approx([2.4e-5, 1.9e-4], rel=0.03)
    # Over a chord: the radius falls with the turn, so one power less remains.
    assert np.log2(away[1] / away[0]) == pytest.approx(5.0, abs=0.1)


def test_the_width_of_a_patch_is_its_lines_length_to_the_second_order():
    missed = []
    for size in (0.1, 0.2):
        slopes = size * np.array([1.0, 0.4])
        points = np.stack([np.zeros(3), CHORD])[:, None]
        normals = np.array([[-np.sin(a), np.cos(a), 0.0] for a in slopes])
        frames = frames_from(np.tile([0.0, 0.0, 1.0], (2, 1)), normals)[:, None]
        # Only one of two passes counts: as wide as all are in the mean.
        width = line_widths(Rails(points, frames))[0][0, 0]
        v, weights = np.polynomial.legendre.leggauss(20)
        steep = basis(0.5 * (v + 1.0), 1)[:, 1:3] @ np.tan(slopes)
        length = 0.5 * weights @ np.hypot(1.0, steep)
        missed.append(abs(width - length))
    assert missed[1] / missed[0] == pytest.approx(16.0, rel=0.25)
    assert missed[1] < 1e-3


def test_what_a_match_is_bent_by_is_smooth_where_it_begins_and_never_turns_back():
    leftover, half = 0.1, 1.0
    x = np.linspace(0.0, 0.5, 5001)
    bend = absorbed(leftover, x, half)
    slope = np.gradient(bend, x)
    assert slope.max() <= 1e-9
    assert slope.min() == pytest.approx(-16 / 9 * 2 / 5, rel=1e-4)
    second = np.gradient(slope, x)
    around = np.abs(x - 2.5 * leftover) < 2e-3
    assert np.abs(second[around]).max() < 0.05 * np.abs(second).max()


def test_a_ribbon_level_on_a_wall_reads_as_its_mirror_image_does():
    """Two axes along tangent and conormal; the third tells the two apart."""
    dip, heading, runs = np.radians(62.0), np.radians(20.0), np.radians(120.0)
    # The field points north of a frame turned by the heading: as an azimuth from x.
    north = np.pi / 2 - heading
    field = field_direction(dip, heading)
    seen = []
    for azimuth in (runs, 2.0 * north - runs):
        tangent = about_z(azimuth) @ np.array([1.0, 0.0, 0.0])
        frame = np.stack([tangent, UP, np.cross(tangent, UP)], axis=1)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        seen.append((frame.T @ field, frame.T @ UP))
    (one, up), (other, its_up) = seen
    assert one[:2] == pytest.approx(other[:2], abs=1e-12)
    assert up == pytest.approx(its_up, abs=1e-12)
    assert abs(one[2] - other[2]) > 0.3


@pytest.mark.parametrize("correlation", [-1.0, 0.0, 0.5, 1.0])
def test_standard_deviations_between_passes_are_never_too_small(correlation):
    v = np.linspace(0.0, 1.0, 11)
    for one, other in ((1.0, 1.0), (1.0, 3.0)):
        both = 2.0 * v * (1.0 - v) * correlation * one * other
        true = np.sqrt((1.0 - v) ** 2 * one**2 + v**2 * other**2 + both)
        told = blended(np.array([[one], [other]]), v)[0]
        assert (true <= told + 1e-9).all()
        assert told[[0, -1]] == pytest.approx([one, other])
