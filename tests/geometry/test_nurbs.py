"""Laws of rational B-spline surfaces: derivatives, circles, affine maps; SciPy as the reference."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline, NdBSpline

from georibbon.errors import SurfaceError
from georibbon.geometry.arch import arch, arch_strips
from georibbon.geometry.closest import closest_point
from georibbon.geometry.cubic_basis import clamped_knots, cubic_basis
from georibbon.geometry.frames import curvatures
from georibbon.geometry.geodesics import geodesic
from georibbon.geometry.nurbs import NurbsSurface
from georibbon.geometry.reference import BSplineSurface, Jet
from georibbon.geometry.shortest import shortest_geodesic

RANDOM = np.random.default_rng(11)
UNEVEN = np.array([0.0, 0.0, 0.0, 0.0, 0.1, 0.25, 0.25, 0.9, 2.0, 2.0, 2.0, 2.0])
UNCLAMPED = np.array([-1.0, -0.4, 0.0, 0.3, 0.5, 1.1, 1.2, 2.0, 2.0, 2.7, 3.0])


def some(uneven: float = 0.3) -> NurbsSurface:
    """A surface of 8 by 7 points with uneven knots and weights, one knot of u twice inside."""
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 8), np.linspace(-0.8, 0.8, 7), indexing="ij")
    net = np.stack([x, y, 0.2 * RANDOM.standard_normal((8, 7))], axis=2)
    weights = np.exp(uneven * RANDOM.standard_normal((8, 7)))
    return NurbsSurface(net, weights, UNEVEN, UNCLAMPED)


SOME = some()


def inside(surface: NurbsSurface, count: int = 200) -> np.ndarray:
    return np.random.default_rng(2).uniform(surface.lower, surface.upper, (count, 2))


def scipy_points(surface: NurbsSurface, uv: np.ndarray, nu: tuple[int, int]) -> np.ndarray:
    """Numerator and denominator, (n, 4), or a derivative of theirs, by SciPy."""
    weights = surface.weights[..., None]
    both = np.concatenate([surface.net * weights, weights], axis=2)
    return NdBSpline((surface.knots_u, surface.knots_v), both, 3)(uv, nu=nu)


@pytest.mark.parametrize("knots", [UNEVEN, UNCLAMPED, clamped_knots(9), clamped_knots(4)])
def test_the_basis_is_scipys(knots: np.ndarray) -> None:
    count = len(knots) - 4
    at = np.r_[np.random.default_rng(1).uniform(knots[3], knots[count], 200), knots[3 : count + 1]]
    first, values = cubic_basis(knots)(at)
    reference = BSpline(knots, np.eye(count), 3)
    for order in range(3):
        whole = np.zeros((len(at), count))
        np.put_along_axis(whole, first[:, None] + np.arange(4), values[order], axis=1)
        np.testing.assert_allclose(whole, reference(at, order), atol=1e-9)


@pytest.mark.parametrize("knots", [UNEVEN, UNCLAMPED, clamped_knots(9)])
def test_the_basis_is_a_partition_of_unity_and_not_negative(knots: np.ndarray) -> None:
    at = np.linspace(knots[3], knots[-4], 300)
    values = cubic_basis(knots)(at)[1]
    np.testing.assert_allclose(values[0].sum(axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(values[1].sum(axis=1), 0.0, atol=1e-11)
    np.testing.assert_allclose(values[2].sum(axis=1), 0.0, atol=1e-9)
    assert values[0].min() >= -1e-15


def test_points_are_the_quotient_of_scipys_splines() -> None:
    uv = inside(SOME)
    both = scipy_points(SOME, uv, (0, 0))
    np.testing.assert_allclose(SOME.points(uv), both[:, :3] / both[:, 3:], atol=1e-13)


def test_derivatives_fulfil_the_product_rule_with_scipys_splines() -> None:
    """A = w p, differentiated as a whole: no formula of the module is used."""
    uv = inside(SOME)
    jet = SOME.jet(uv)
    d = {nu: scipy_points(SOME, uv, nu) for nu in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))}
    w = scipy_points(SOME, uv, (0, 0))[:, 3:]
    wu, wv, wuu, wuv, wvv = (one[:, 3:] for one in d.values())
    products = (
        wu * jet.p + w * jet.pu,
        wv * jet.p + w * jet.pv,
        wuu * jet.p + 2 * wu * jet.pu + w * jet.puu,
        wuv * jet.p + wu * jet.pv + wv * jet.pu + w * jet.puv,
        wvv * jet.p + 2 * wv * jet.pv + w * jet.pvv,
    )
    for product, expected in zip(products, d.values(), strict=True):
        np.testing.assert_allclose(product, expected[:, :3], atol=1e-10)


def test_derivatives_are_those_of_finite_differences_outside_the_box_too() -> None:
    uv, h = np.random.default_rng(3).uniform(-0.1, 2.1, (200, 2)), 1e-5
    near = np.abs(uv[:, :1] - UNEVEN).min(axis=1) > 2 * h
    uv = uv[near & (np.abs(uv[:, 1:] - UNCLAMPED).min(axis=1) > 2 * h)]
    jet = SOME.jet(uv)

    def slope(name: str, axis: int) -> np.ndarray:
        step = h * np.eye(2)[axis]
        ahead, behind = (getattr(SOME.jet(uv + sign * step), name) for sign in (1, -1))
        return (ahead - behind) / (2 * h)

    for name, of, axis in (
        ("pu", "p", 0), ("pv", "p", 1), ("puu", "pu", 0), ("puv", "pu", 1), ("pvv", "pv", 1),
    ):  # fmt: skip
        value = getattr(jet, name)
        np.testing.assert_allclose(slope(of, axis), value, atol=1e-5 * np.abs(value).max())


def test_an_affine_map_of_the_net_maps_the_surface() -> None:
    uv = inside(SOME)
    matrix, shift = RANDOM.standard_normal((3, 3)), np.array([1.0, -2.0, 3.0])
    mapped = NurbsSurface(SOME.net @ matrix.T + shift, SOME.weights, UNEVEN, UNCLAMPED)
    for name, one, other in zip(Jet._fields, mapped.jet(uv), SOME.jet(uv), strict=True):
        moved = shift if name == "p" else 0.0
        np.testing.assert_allclose(one, other @ matrix.T + moved, atol=1e-9)


def test_weights_count_by_their_ratios_alone() -> None:
    uv = inside(SOME)
    heavier = NurbsSurface(SOME.net, 7.0 * SOME.weights, UNEVEN, UNCLAMPED)
    for one, other in zip(heavier.jet(uv), SOME.jet(uv), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-10)


def test_a_knot_put_in_changes_nothing() -> None:
    """A knot is inserted into u by Boehm's rule, applied to the weighted points."""
    at, k = 0.6, 6  # between the knots 0.25 and 0.9
    weights = SOME.weights[..., None]
    old = np.concatenate([SOME.net * weights, weights], axis=2)
    share = [(at - UNEVEN[i]) / (UNEVEN[i + 3] - UNEVEN[i]) for i in range(k - 2, k + 1)]
    between = [
        a * old[i] + (1 - a) * old[i - 1] for a, i in zip(share, range(k - 2, k + 1), strict=True)
    ]
    new = [*old[: k - 2], *between, *old[k:]]
    both = np.array(new)
    finer = NurbsSurface(
        both[..., :3] / both[..., 3:], both[..., 3], np.insert(UNEVEN, k + 1, at), UNCLAMPED
    )
    uv = inside(SOME)
    for one, other in zip(finer.jet(uv), SOME.jet(uv), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_with_even_knots_and_weights_it_is_the_uniform_b_spline() -> None:
    net = RANDOM.standard_normal((9, 6, 3))
    one = NurbsSurface(net, np.ones((9, 6)), np.arange(-3.0, 10.0), np.arange(-3.0, 7.0))
    other = BSplineSurface(net)
    assert (one.lower, one.upper) == (other.lower, other.upper)
    uv = np.random.default_rng(4).uniform((-0.3, -0.3), (6.3, 3.3), (200, 2))
    for mine, known in zip(one.jet(uv), other.jet(uv), strict=True):
        np.testing.assert_allclose(mine, known, atol=1e-12)


def quarter_cylinder() -> NurbsSurface:
    """The rational quadratic quarter circle (1, 1/sqrt 2, 1), raised to the third degree, long 1 m.

    Radius 1 m about the y axis, u from +x to +z.
    """
    w = np.sqrt(0.5)
    plane = np.array([[1.0, 0.0, 1.0], [w, w, w], [0.0, 1.0, 1.0]])
    raised = np.stack(
        [plane[0], (plane[0] + 2 * plane[1]) / 3, (2 * plane[1] + plane[2]) / 3, plane[2]]
    )
    y = np.broadcast_to(np.linspace(0.0, 1.0, 4), (4, 4))
    x, z = (raised[:, k, None] / raised[:, 2:] + 0 * y for k in (0, 1))
    weights = np.broadcast_to(raised[:, 2:], (4, 4)).copy()
    return NurbsSurface(np.stack([x, y, z], 2), weights, clamped_knots(4), clamped_knots(4))


def test_a_quarter_of_a_cylinder_is_exact() -> None:
    quarter = quarter_cylinder()
    jet = quarter.jet(inside(quarter))
    np.testing.assert_allclose(np.hypot(jet.p[:, 0], jet.p[:, 2]), 1.0, atol=1e-14)
    radial = jet.p * [1.0, 0.0, 1.0]
    np.testing.assert_allclose(np.abs(np.sum(jet.normals * radial, axis=1)), 1.0, atol=1e-14)
    bend = np.sum(jet.puu * radial, axis=1) / np.sum(jet.pu * jet.pu, axis=1)
    np.testing.assert_allclose(bend, -1.0, atol=1e-12)


def test_its_geodesics_are_helices_from_a_point_and_between_two() -> None:
    """Though the parameter does not run evenly around it."""
    quarter, s = quarter_cylinder(), np.linspace(-0.5, 0.5, 41)
    ahead = np.array([-0.6 * np.sqrt(0.5), 0.8, 0.6 * np.sqrt(0.5)])
    turn = np.pi / 4 + 0.6 * s
    helix = np.stack([np.cos(turn), 0.5 + 0.8 * s, np.sin(turn)], axis=1)
    strip = geodesic(quarter, (0.5, 0.5), ahead, s)
    np.testing.assert_allclose(strip.points, helix, atol=1e-10)
    bending, torsion = curvatures(strip)
    np.testing.assert_allclose(np.abs(bending[1:-1]), 0.36, atol=1e-4)
    np.testing.assert_allclose(np.abs(torsion[1:-1]), 0.48, atol=1e-4)
    ends = closest_point(quarter, helix[[0, -1]]).uv
    between = shortest_geodesic(quarter, ends[0], ends[1], samples=41)
    np.testing.assert_allclose(between.points, helix, atol=1e-9)


def test_a_double_knot_breaks_the_second_derivative_and_nothing_before() -> None:
    before, beyond = (SOME.jet(np.array([[0.25 + d, 0.7]])) for d in (-1e-12, 1e-12))
    np.testing.assert_allclose(before.pu, beyond.pu, atol=1e-9)
    assert np.abs(before.puu - beyond.puu).max() > 0.1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"net": np.zeros((8, 7))}, r"shape \(8, 7\) is found"),
        ({"net": np.zeros((3, 7, 3))}, "at least 4"),
        ({"weights": np.ones((7, 8))}, "one for each point"),
        ({"weights": np.zeros((8, 7))}, "above zero"),
        ({"weights": np.full((8, 7), np.inf)}, "not a number"),
        ({"net": np.full((8, 7, 3), np.nan)}, "not a number"),
        ({"knots_u": UNCLAMPED}, "11 knots are found for 8 control points; 12"),
        ({"knots_u": UNEVEN[::-1].copy()}, "do not descend"),
        ({"knots_u": np.where(UNEVEN > 1.0, np.inf, UNEVEN)}, "not finite"),
        ({"knots_u": np.zeros(12)}, "no parameter between"),
        ({"knots_u": np.array([0.0] * 4 + [0.5] * 4 + [1.0] * 4)}, "tears the surface"),
    ],
)
def test_what_is_no_such_surface_is_refused(change: dict[str, np.ndarray], said: str) -> None:
    parts = {"net": SOME.net, "weights": SOME.weights, "knots_u": UNEVEN, "knots_v": UNCLAMPED}
    with pytest.raises(SurfaceError, match=said):
        NurbsSurface(**{**parts, **change})


def test_the_arch_is_like_the_papers() -> None:
    """Five passes of 0.72 m, 23 to 99 mm apart, without inflections, curved the other way too."""
    strips = arch_strips(samples=61)
    gaps = np.array(
        [np.linalg.norm(after.points - before.points, axis=1) for before, after in pairwise(strips)]
    )
    assert (round(1e3 * gaps.min()), round(1e3 * gaps.max())) == (23, 99)
    assert 1e3 * gaps.mean() == pytest.approx(70.0, abs=1.0)
    assert max(curvatures(one)[0].max() for one in strips) < -1.2
    assert [one.s[-1] for one in strips] == pytest.approx([0.72] * 5)
    surface = arch()
    assert (surface.lower, surface.upper) == ((0.0, 0.0), (1.0, 1.0))
    assert surface.net.shape == (8, 7, 3)
    assert np.ptp(surface.weights) > 0.3
    ends = surface.points(np.array([[0.0, 0.5], [1.0, 0.5]]))
    angles = np.arctan2(ends[:, 0], ends[:, 2])
    assert np.ptp(angles) == pytest.approx(2.0)
    middle = surface.jet(np.array([[0.5, 0.5]]))
    assert middle.normals[0, 2] > 0.9
    across = np.sum(middle.pvv * middle.normals, axis=1) / np.sum(middle.pv**2, axis=1)
    assert across[0] < -1.0
