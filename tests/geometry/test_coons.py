"""Coons patches between four geodesics, and when they exist."""

from functools import cache

import numpy as np
import pytest

from georibbon.errors import SurfaceError
from georibbon.geometry.closest import closest_point
from georibbon.geometry.coons import CORNERS, coons_patch, existence
from georibbon.geometry.edges import edge_of
from georibbon.geometry.frames import Strip, arc_angles, curvatures
from georibbon.geometry.meetings import meeting
from georibbon.geometry.reference import Bonnet, Cylinder, Ellipsoid, Plane, Saddle, Torus
from georibbon.rotations import exp
from passes import moved, passes, plane_passes, upside_down

SURFACES = {
    "plane": (Plane(), (0.0, 0.0)),
    "cylinder": (Cylinder(), (0.1, 0.2)),
    "sphere": (Ellipsoid(), (0.3, 0.2)),
    "torus": (Torus(), (0.4, 0.5)),
    "bonnet": (Bonnet(), (0.1, 0.2)),
    "saddle": (Saddle(), (0.1, 0.2)),
}
SHARES = np.linspace(0.0, 1.0, 9)


@cache
def crossed(name, size):
    """Two passes and two ties around a place, oblique to each other, and where they meet."""
    surface, place = SURFACES[name]
    centre = np.array(place)
    jet = surface.jet(centre[None])
    step = 0.5 * size / np.linalg.norm([jet.pu[0], jet.pv[0]], axis=1)
    rows, columns = (
        passes(
            surface,
            [centre - shift, centre + shift],
            [turn, turn + 0.1 * size],
            length=3.0 * size,
            count=49,
        )
        for shift, turn in ((step * [0, 1], 0.3), (step * [1, 0], 1.4))
    )
    met = [[meeting(edge_of(row), edge_of(column)) for column in columns] for row in rows]
    return rows, columns, met


def part(strip, first, last):
    """A part of a strip as a strip, anew through 33 places."""
    s = np.linspace(first, last, 33)
    here = edge_of(strip).at(s)
    return Strip(s - first, here.points, here.frames)


@cache
def cell(name, size=0.2):
    """The four strips around a cell: bottom, top, left, right."""
    rows, columns, met = crossed(name, size)
    along = [part(row, *(one.places[0] for one in at)) for row, at in zip(rows, met, strict=True)]
    across = [part(column, *(at[k].places[1] for at in met)) for k, column in enumerate(columns)]
    return (*along, *across)


def rolled(strip, rate):
    """The strip with normals rolled about it: not at its ends, where the roll's rate is given."""
    share = strip.s / strip.s[-1]
    angle = rate * strip.s * (1.0 - share)
    turns = exp(angle[:, None] * strip.tangents)
    return Strip(strip.s, strip.points, turns @ strip.frames)


def strip_at(strip):
    """Points and normals at the shares."""
    edge = edge_of(strip)
    here = edge.at(edge.first + SHARES * edge.length)
    return here.points, here.normals


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("rate", [0.0, 0.4])
def test_boundaries_and_their_normals_are_kept_even_where_twists_disagree(name, rate):
    bottom, top, left, right = cell(name)
    bottom, right = rolled(bottom, rate), rolled(right, -rate)
    grid = coons_patch(bottom, top, left, right).at(SHARES, SHARES)
    for strip, side in (
        (bottom, np.s_[:, 0]),
        (top, np.s_[:, -1]),
        (left, np.s_[0]),
        (right, np.s_[-1]),
    ):
        points, normals = strip_at(strip)
        np.testing.assert_allclose(grid.points[side], points, atol=2e-9)
        assert np.degrees(arc_angles(grid.normals[side], normals)).max() < 1e-4


@pytest.mark.parametrize("rate", [0.0, 0.4])
def test_derivatives_are_those_of_the_points(rate):
    bottom, top, left, right = cell("torus")
    patch = coons_patch(rolled(bottom, rate), top, left, right)
    inner, step = SHARES[1:-1], 1e-5
    grid = patch.at(inner, inner)
    by_u = (patch.at(inner + step, inner).points - patch.at(inner - step, inner).points) / 2 / step
    by_v = (patch.at(inner, inner + step).points - patch.at(inner, inner - step).points) / 2 / step
    np.testing.assert_allclose(grid.along, by_u, atol=1e-9)
    np.testing.assert_allclose(grid.across, by_v, atol=1e-9)


def test_boundaries_are_geodesics_of_the_patch():
    strips = cell("bonnet")
    u, step = SHARES[1:-1], 1e-3
    patch = coons_patch(*strips)
    before, here, after = (patch.at(u + shift, np.array([0.0, 1.0])) for shift in (-step, 0, step))
    bend = (before.points - 2.0 * here.points + after.points) / step**2
    speed = np.linalg.norm(here.along, axis=-1)
    sideways = np.cross(here.normals, here.along)
    turning = np.sum(bend * sideways, axis=-1) / speed**3
    assert np.abs(turning).max() < 1e-4  # 1/m


@pytest.mark.parametrize(("name", "limit"), [("plane", 1e-15), ("cylinder", 1e-10)])
def test_planes_and_cylinders_are_reproduced(name, limit):
    grid = coons_patch(*cell(name)).at(SHARES, SHARES)
    found = closest_point(SURFACES[name][0], grid.points.reshape(-1, 3))
    assert np.abs(found.distance).max() < limit


@pytest.mark.parametrize("name", ["sphere", "torus", "bonnet", "saddle"])
def test_smaller_cells_come_closer_to_the_surface_by_more_than_the_fourth_order(name):
    errors = []
    for size in (0.2, 0.1):
        grid = coons_patch(*cell(name, size)).at(SHARES, SHARES)
        found = closest_point(SURFACES[name][0], grid.points.reshape(-1, 3))
        errors.append(np.abs(found.distance).max())
        true = SURFACES[name][0].normals(found.uv).reshape(grid.normals.shape)
        side = np.sign(np.sum(true * grid.normals))
        assert np.degrees(arc_angles(side * true, grid.normals)).max() < 0.03
    assert errors[0] < 2e-5
    assert np.log2(errors[0] / errors[1]) > 5.0


@pytest.mark.parametrize("rate", [0.0, 0.4])
def test_the_patch_is_the_same_however_it_is_looked_at(rate):
    bottom, top, left, right = cell("torus")
    bottom = rolled(bottom, rate)
    u, v = SHARES, SHARES[::2]
    grid = coons_patch(bottom, top, left, right).at(u, v)
    swapped = coons_patch(left, right, bottom, top).at(v, u)
    turned = coons_patch(bottom.reversed(), top.reversed(), right, left).at(1.0 - u, v)
    over = coons_patch(*map(upside_down, (bottom, top, left, right))).at(u, v)
    for points, normals in (
        (np.swapaxes(swapped.points, 0, 1), np.swapaxes(swapped.normals, 0, 1)),
        (turned.points, turned.normals),
        (over.points, -over.normals),
    ):
        np.testing.assert_allclose(points, grid.points, atol=1e-12)
        np.testing.assert_allclose(normals, grid.normals, atol=1e-9)


def test_the_patch_moves_with_its_curves():
    turn, shift = exp(np.array([0.3, -1.1, 0.7])), np.array([1.0, -2.0, 0.5])
    strips = cell("bonnet")
    grid = coons_patch(*strips).at(SHARES, SHARES)
    other = coons_patch(*(moved(strip, turn, shift) for strip in strips)).at(SHARES, SHARES)
    np.testing.assert_allclose(other.points, grid.points @ turn.T + shift, atol=1e-12)
    np.testing.assert_allclose(other.normals, grid.normals @ turn.T, atol=1e-9)


@pytest.mark.parametrize("name", SURFACES)
def test_the_local_condition_holds_for_geodesics_of_one_surface(name):
    rows, columns, met = crossed(name, 0.2)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            one = met[i][j]
            assert one.miss < 1e-9
            assert one.corner.normals < 1e-6
            assert abs(one.corner.residual) < 1e-6
            # The same from curvatures and torsions: (t1 + t2) sin a = (k1 - k2) cos a.
            (k1, t1), (k2, t2) = (
                [np.interp(s, strip.s, values) for values in curvatures(strip)]
                for s, strip in zip(one.places, (row, column), strict=True)
            )
            sine, cosine = np.sin(one.corner.angle), np.cos(one.corner.angle)
            assert abs(cosine) > 0.1  # or the law would say nothing of k
            # `curvatures` gives V'.N, which is minus N'.V.
            assert -(t1 + t2) * sine == pytest.approx((k1 - k2) * cosine, abs=3e-3)


def test_the_residual_is_the_rate_by_which_normals_roll_too_fast():
    bottom, top, left, right = cell("torus")
    checks = existence(rolled(bottom, 2.0), top, left, right)
    angles = {one.where: one.value for one in checks if one.code == "corner-angle"}
    twists = {one.where: one for one in checks if one.code == "corner-twist"}
    for where in ("bottom-left", "bottom-right"):
        expected = 2.0 * np.sin(np.radians(angles[where]))
        assert twists[where].value == pytest.approx(expected, rel=1e-3)
        assert twists[where].verdict == "warn"
        assert "lay one of them again" in twists[where].message
    assert twists["top-left"].verdict == "pass"
    assert {one.verdict for one in existence(bottom, top, left, right)} == {"pass"}
    assert len(checks) == 3 * len(CORNERS) + 1


def test_a_curve_upside_down_is_told():
    bottom, top, left, right = cell("sphere")
    told = existence(bottom, upside_down(top), left, right)[-1]
    assert (told.code, told.verdict) == ("corner-orientation", "fail")
    told = existence(bottom, top, right, left)[-1]
    assert told.verdict == "pass"  # a loop run the other way round
    told = existence(bottom, top.reversed(), left, right)[-1]
    assert told.verdict == "fail"
    with pytest.raises(SurfaceError, match="face opposite sides"):
        coons_patch(bottom, upside_down(top), left, right)


def test_curves_that_do_not_meet_or_disagree_are_refused():
    bottom, top, left, right = cell("sphere")
    away = Strip(top.s, top.points + np.array([0.0, 0.0, 1e-4]), top.frames)
    with pytest.raises(SurfaceError, match=r"u = 0, v = 1 lie 0\.1000 mm apart"):
        coons_patch(bottom, away, left, right)
    tilted = Strip(left.s, left.points, exp(np.radians(5.0) * left.tangents) @ left.frames)
    with pytest.raises(SurfaceError, match=r"at the corner u = 0, v = 0 lie 5\.0"):
        coons_patch(bottom, top, tilted, right)
    normals = [one for one in existence(bottom, top, tilted, right) if "normals" in one.code]
    assert sorted(one.verdict for one in normals) == ["pass", "pass", "warn", "warn"]
    assert max(one.value for one in normals) == pytest.approx(5.0, rel=1e-3)
    flat, other = plane_passes(0.0, 0.1, length=0.2, nodes=9)
    with pytest.raises(SurfaceError, match="run along each other"):
        coons_patch(flat, other, flat, other)


def test_lines_in_space_meet_where_they_come_closest():
    along, _ = plane_passes(0.0, 1.0, length=0.4, nodes=9)
    turn = exp(np.array([0.0, 0.0, np.radians(60.0)]))
    across = moved(along, turn, np.array([0.05, 0.0, 0.003]))
    met = meeting(edge_of(along), edge_of(across))
    assert met.places == pytest.approx((0.25, 0.2), abs=1e-12)
    assert met.miss == pytest.approx(0.003)
    assert np.degrees(met.corner.angle) == pytest.approx(60.0)
    beyond = meeting(edge_of(along), edge_of(moved(across, np.eye(3), np.array([0.18, 0.0, 0.0]))))
    assert beyond.places[0] == pytest.approx(0.4)  # its end is the nearest there is
    assert beyond.miss > 0.02
