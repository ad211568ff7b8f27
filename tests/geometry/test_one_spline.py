"""Laws of the one spline: exactness, order, deviation, equivariance, continuity, refusal."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from georibbon.errors import SurfaceError
from georibbon.geometry.alignment import Motion
from georibbon.geometry.correspondence import arrange
from georibbon.geometry.frames import Strip
from georibbon.geometry.mesh import grid_mesh
from georibbon.geometry.nearest import TriangleLocator
from georibbon.geometry.one_spline import (
    OneSpline,
    Target,
    approximated,
    interpolated,
    one_spline,
    target_of,
)
from georibbon.geometry.patch import PatchGrid, PatchSet, patches_between, rails_at
from georibbon.geometry.reference import Bonnet, Torus
from georibbon.geometry.settings import Interior, SurfaceSettings
from georibbon.geometry.surface import Surface, build_surface
from passes import passes, plane_passes, sphere_passes

TOLERANCE = 5e-5
U = np.linspace(0.0, 0.9, 41)
Map = Callable[[np.ndarray, np.ndarray], np.ndarray]


@cache
def bonnet_surface(interior: Interior = "g1") -> Surface:
    places = [(0.0, 0.1), (0.0, 0.2), (0.02, 0.32)]
    strips = passes(Bonnet(), places, [0.0, 0.05, -0.05], shifts=[0.0, 0.03, -0.02])
    return build_surface(strips, "abc", SurfaceSettings(1e-5, interior=interior))


def model_of(surface: Surface) -> PatchSet:
    assert surface.plan is not None
    return surface.plan.model


@cache
def bonnet_spline(interior: Interior = "g1") -> OneSpline:
    return one_spline(model_of(bonnet_surface(interior)), TOLERANCE)


def graph(height: Map, slope_x: Map, slope_y: Map) -> Target:
    """Two pieces of the graph z = height(x, y), 0.4 wide each, lines across along y."""
    widths = np.array([0.4, 0.4])

    def grid(u: np.ndarray, t: np.ndarray) -> PatchGrid:
        y = np.array([0.0, 0.4])[:, None, None] + 0.4 * t
        x = np.broadcast_to(u[:, None], (2, len(u), len(t)))
        y = np.broadcast_to(y, x.shape)
        one, nil = np.ones_like(x), np.zeros_like(x)
        along = np.stack([one, nil, slope_x(x, y)], axis=-1)
        across = 0.4 * np.stack([nil, one, slope_y(x, y)], axis=-1)
        upright = np.broadcast_to([0.0, 0.0, 1.0], along.shape)
        return PatchGrid(np.stack([x, y, height(x, y)], axis=-1), along, across, upright)

    return Target(np.linspace(0.0, 1.0, 21), widths, np.array([True]), grid)


def waves() -> Target:
    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 0.05 * np.sin(5.0 * x + 1.0) * np.cos(4.0 * y)

    def slope_x(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 0.25 * np.cos(5.0 * x + 1.0) * np.cos(4.0 * y)

    def slope_y(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return -0.2 * np.sin(5.0 * x + 1.0) * np.sin(4.0 * y)

    return graph(height, slope_x, slope_y)


def error_of(target: Target, spline: OneSpline) -> float:
    u, t = np.linspace(0.0, 1.0, 83), np.linspace(0.0, 1.0, 37)
    exact = target.grid(u, t).points
    return float(np.linalg.norm(spline.on_pieces(u, t) - exact, axis=-1).max())


def test_a_bicubic_is_reproduced_exactly() -> None:
    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return x**3 * y**3 - x * y**2 + 0.5 * x**2

    target = graph(
        height,
        lambda x, y: 3.0 * x**2 * y**3 - y**2 + x,
        lambda x, y: 3.0 * x**3 * y**2 - 2.0 * x * y,
    )
    spline = approximated(target, 1e-9, 1e-6, 1000)
    assert spline.count == (5, 6)  # nothing was halved
    assert error_of(target, spline) < 1e-15
    assert spline.deviation < 1e-14


@pytest.mark.parametrize("along", [True, False])
def test_the_error_falls_with_the_fourth_power(along: bool) -> None:
    target, errors = waves(), []
    for count in (4, 8, 16):
        spans, pieces = (count, 32) if along else (128, count)
        nodes = np.linspace(0.0, 1.0, spans + 1)
        errors.append(error_of(target, interpolated(target, nodes, np.array([pieces, pieces]))))
    for coarse, fine in pairwise(errors):
        assert 11.0 < coarse / fine < 30.0


@pytest.mark.parametrize("interior", ["g1", "c1-lines", "g2"])
def test_it_keeps_what_it_claims_by_closest_points(interior: Interior) -> None:
    surface, spline = bonnet_surface(interior), bonnet_spline(interior)
    assert spline.deviation <= TOLERANCE
    u = np.linspace(spline.knots[0][0], spline.knots[0][-1], 157)
    w = np.linspace(spline.seams[0], spline.seams[-1], 97)
    locator = TriangleLocator(surface.mesh.vertices, surface.mesh.triangles)
    away = locator.nearest(spline(u, w).reshape(-1, 3)).distance.max()
    assert away <= spline.deviation + 1e-5  # the triangles' own
    assert away > 0.05 * spline.deviation  # and it claims no nonsense


@pytest.mark.parametrize("interior", ["g1", "c1-lines", "g2"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_it_is_within_the_tolerance_between_all_places_looked_at(
    interior: Interior, tolerance: float
) -> None:
    model = model_of(bonnet_surface(interior))
    spline = one_spline(model, tolerance)
    target = target_of(model)
    u = np.sort(np.random.default_rng(7).uniform(*spline.knots[0][[0, -1]], 300))
    t = np.linspace(0.0, 1.0, 23)
    gap = spline.on_pieces(u, t) - target.grid(u, t).points
    assert np.linalg.norm(gap, axis=-1).max() <= spline.deviation <= tolerance
    assert spline.turn <= np.radians(1.0)


def test_a_smaller_tolerance_takes_more_control_points() -> None:
    model = model_of(bonnet_surface())
    counts = [one_spline(model, tolerance).count[0] for tolerance in (1e-3, 1e-5, 1e-7)]
    assert counts == sorted(set(counts))


@pytest.mark.parametrize("interior", ["g1", "c1-lines"])
def test_the_passes_are_isoparametric_lines(interior: Interior) -> None:
    model, spline = model_of(bonnet_surface(interior)), bonnet_spline(interior)
    u = np.linspace(spline.knots[0][0], spline.knots[0][-1], 201)
    rails = rails_at(model, u).points
    found = np.swapaxes(spline(u, spline.seams), 0, 1)
    assert np.linalg.norm(found - rails, axis=-1).max() <= spline.deviation
    nodes = np.concatenate([u[[0, -1]], spline.knots[0][6:-6:4]])  # knots that are nodes
    exact = rails_at(model, nodes).points
    np.testing.assert_allclose(np.swapaxes(spline(nodes, spline.seams), 0, 1), exact, atol=1e-12)


def test_knots_are_clamped_and_as_many_as_control_points_ask_for() -> None:
    for interior in ("g1", "c1-lines", "g2"):
        spline = bonnet_spline(interior)
        for knots, count in zip(spline.knots, spline.count, strict=True):
            assert len(knots) == count + 4
            assert (np.diff(knots) >= 0.0).all()
            times = np.unique(knots, return_counts=True)[1]
            assert times[0] == times[-1] == 4
            assert times[1:-1].max() <= 3


def normals_beside(spline: OneSpline, w: float) -> tuple[np.ndarray, np.ndarray]:
    u = np.linspace(spline.knots[0][0], spline.knots[0][-1], 51)
    beside = np.array([np.nextafter(w, -1.0), w])
    square = np.cross(spline(u, beside, nu=1), spline(u, beside, nw=1))
    square /= np.linalg.norm(square, axis=-1, keepdims=True)
    return square[:, 0], square[:, 1]


def test_corners_keep_the_tangent_plane_and_smooth_lines_have_none() -> None:
    corner, smooth = bonnet_spline("g1"), bonnet_spline("c1-lines")
    assert not corner.smooth
    assert smooth.smooth
    assert smooth.control.shape[1] % 2 == 0  # no knot more than twice
    for spline in (corner, smooth):
        before, after = normals_beside(spline, spline.seams[1])
        apart = np.arctan2(
            np.linalg.norm(np.cross(before, after), axis=1), np.sum(before * after, axis=1)
        )
        assert apart.max() < 2.0 * spline.turn + 1e-9
    u = np.linspace(*smooth.knots[0][[0, -1]], 51)
    w = smooth.seams[1]
    slopes = smooth(u, np.array([np.nextafter(w, -1.0), w]), nw=1)
    np.testing.assert_allclose(slopes[:, 0], slopes[:, 1], atol=1e-9)
    slopes = corner(u, np.array([np.nextafter(corner.seams[1], -1.0), corner.seams[1]]), nw=1)
    assert np.abs(slopes[:, 0] - slopes[:, 1]).max() > 1e-3


def test_a_motion_of_the_passes_moves_the_spline() -> None:
    strips = passes(Torus(0.5, 0.2), [(0.0, 0.0), (0.0, 0.4)], length=0.4)
    motion = Motion(Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix(), np.array([3.0, -2.0, 1.0]))
    moved = [
        Strip(one.s, motion.applied(one.points), motion.rotation @ one.frames) for one in strips
    ]
    here, there = (one_spline(patches_between(arrange(one)), 1e-5) for one in (strips, moved))
    assert here.count == there.count
    np.testing.assert_allclose(motion.applied(here.control), there.control, atol=1e-9)
    np.testing.assert_allclose(here.deviation, there.deviation, rtol=1e-4)


def test_two_level_passes_are_one_bicubic_piece_of_the_plane() -> None:
    spline = one_spline(patches_between(arrange(plane_passes(0.0, 0.1))), 1e-6)
    assert spline.count == (5, 4)
    assert np.abs(spline.control[..., 2]).max() < 1e-15
    assert spline.deviation < 1e-12
    assert spline.smooth


def test_great_circles_give_the_sphere() -> None:
    spline = one_spline(patches_between(arrange(sphere_passes())), 1e-6)
    u = np.linspace(*spline.knots[0][[0, -1]], 99)
    radius = np.linalg.norm(spline(u, np.linspace(0.0, spline.seams[-1], 77)), axis=-1)
    assert np.abs(radius - 0.6).max() < 2e-6


def test_its_derivatives_are_those_of_its_points() -> None:
    spline, h = bonnet_spline(), 1e-6
    u, w = np.array([0.2, 0.5]), np.array([0.03, 0.15])
    for order, step in (({"nu": 1}, (h, 0.0)), ({"nw": 1}, (0.0, h))):
        ahead, back = (spline(u + s * step[0], w + s * step[1]) for s in (1.0, -1.0))
        np.testing.assert_allclose((ahead - back) / (2 * h), spline(u, w, **order), atol=1e-6)


def test_it_is_the_sum_of_control_points_and_basis_functions() -> None:
    spline, (u, w) = bonnet_spline(), (np.array([0.37]), np.array([0.11]))
    rows, columns = (
        BSpline.design_matrix(at, knots, 3).toarray()
        for at, knots in zip((u, w), spline.knots, strict=True)
    )
    summed = np.einsum("i,ijk,j->k", rows[0], spline.control, columns[0])
    np.testing.assert_allclose(spline(u, w)[0, 0], summed, atol=1e-14)


def test_what_takes_too_many_control_points_is_refused_in_a_sentence() -> None:
    with pytest.raises(SurfaceError, match="needs more than 300 control points: choose a larger"):
        one_spline(model_of(bonnet_surface()), 1e-8, most=300)


def test_a_jump_is_refused_and_not_followed_for_ever() -> None:
    def step(x: np.ndarray, _y: np.ndarray) -> np.ndarray:
        return np.where(x > 1.0 / 3.0, 0.01, 0.0)

    def nil(x: np.ndarray, _y: np.ndarray) -> np.ndarray:
        return np.zeros_like(x)

    with pytest.raises(SurfaceError, match="check the passes for jumps"):
        approximated(graph(step, nil, nil), 1e-5, 0.02, 100_000)


def test_a_crease_is_followed_and_its_turn_told() -> None:
    def ridge(x: np.ndarray, _y: np.ndarray) -> np.ndarray:
        return 0.1 * np.abs(x - 1.0 / 3.0)

    def slope(x: np.ndarray, _y: np.ndarray) -> np.ndarray:
        return 0.1 * np.sign(x - 1.0 / 3.0)

    target = graph(ridge, slope, lambda x, _y: np.zeros_like(x))
    spline = approximated(target, 1e-5, 0.01, 10_000)
    assert error_of(target, spline) <= spline.deviation <= 1e-5
    assert 0.05 < spline.turn < 0.25  # half the crease and somewhat beyond
    assert np.diff(np.unique(spline.knots[0])).max() > 0.05  # and far from it spans stay wide


def test_where_normals_turn_more_than_is_allowed_spans_are_halved() -> None:
    loose, strict = (approximated(waves(), 1e-2, turn, 10_000) for turn in (1.0, 1e-3))
    assert strict.count[0] > loose.count[0]
    assert strict.turn <= 1e-3


def test_it_runs_through_the_ties_where_the_surface_does() -> None:
    strips = passes(Bonnet(), [(0.0, -0.25), (0.0, 0.05), (0.0, 0.3)], length=0.6)
    ties = passes(Bonnet(), [(-0.1, 0.0), (0.2, 0.0)], [np.pi / 2] * 2, length=0.8)
    named = list(zip("xy", ties, strict=True))
    inner, away = ties[0].points[35:62], []
    for cells in (False, True):
        surface = build_surface(strips, "abc", SurfaceSettings(cells=cells), ties=named)
        spline = one_spline(model_of(surface), 2e-5)
        u = np.linspace(*spline.knots[0][[0, -1]], 200)
        points = spline(u, np.linspace(0.0, spline.seams[-1], 150))
        mesh = grid_mesh(points, np.zeros_like(points), None)
        away.append(TriangleLocator(mesh.vertices, mesh.triangles).nearest(inner).distance.max())
    assert away[0] > 4e-5
    assert away[1] < 1e-5
