"""Tangent lengths that minimise a criterion of fairness, for all lines across at once.

A line across, divided by its chord's length, is the Hermite cubic with end
points 0 and c and end tangents lambda0 T0 and lambda1 T1.  All that a criterion
sees of it are the dot products of its derivatives,

    A = F'.F'  B = F'.F''  C = F''.F''  G = F'''.F'''  H = F'.F'''  I = F''.F'''

each a quadratic in the two lengths whose coefficients are dot products of c,
T0 and T1.  With W = AC - B² (so that the curvature is sqrt(W) / A^(3/2)),
D = det(T0, c, T1) and L the line's length:

    criterion 1          int B²/A dv                     the speed's variation, (d|F'|/dv)²
    criterion 2          int e/A³ dv                     the curvature's variation, (d kappa/dv)²
    criterion 3          int (12 lambda0 lambda1 D)² / (W + eps)² dv     the squared torsion
    bending              L int W/A^(5/2) dv              L int kappa² ds
    curvature variation  L³ int e/A^(7/2) dv             L³ int |d(kappa n)/ds|² ds

    e = (AG - H²) - 6 (AI - HB) B/A + 9 W B²/A²

is |d(kappa n)/dv|² A³, of the curvature as a vector; the literal criterion 2
has (AI - HB)² / (W + eps) in the place of AG - H².  Criteria 1 to 3 are those
of Sprynski, Szafran, Lacolle and Biard (2008).  The second and third fall
without end as the lengths grow, and none bends them back where a line is
straight; so all but the first are anchored, weight |log lambda - log arc|²
added, and lengths are kept between 1/4 and 4.  Bending and curvature variation
do not depend on the scale of the line or of its parameter.

The minimum is found by Newton's method on log lambda with exact derivatives:
every quantity is a second-order jet (value, both first and all three second
derivatives).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from georibbon.arrays import BoolArray, FloatArray

NODES = (8, 16)
OBLIQUE = 0.7
BOX = float(np.log(4.0))
GREATEST_STEP = 0.4
TOLERANCE = 1e-7
ITERATIONS = 40
CHUNK = 1024
TORSION_FLOOR = 1e-4
CURVATURE_FLOOR = 1e-8
SMALLEST_SHIFT = 1e-9
ROUNDING = 1e-13

# Monomials 1, l0, l1, l0², l0 l1, l1² and their exponents.
EXPONENTS = np.array([[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]], dtype=float)
FIRST, SECOND = EXPONENTS.T
# Value, derivatives by x0, x1, and by x0 x0, x0 x1, x1 x1, with lambda = exp(x).
JET_FACTORS = np.stack([np.ones(6), FIRST, SECOND, FIRST**2, FIRST * SECOND, SECOND**2])

Jet = FloatArray
Density = Callable[[list[Jet], Jet], Jet]


def times(a: Jet, b: Jet) -> Jet:
    """The product of two jets (6, ...)."""
    product: Jet = a[0] * b + a * b[0]
    product[0] = a[0] * b[0]
    product[3] += 2.0 * a[1] * b[1]
    product[4] += a[1] * b[2] + a[2] * b[1]
    product[5] += 2.0 * a[2] * b[2]
    return product


def composed(a: Jet, value: FloatArray, first: FloatArray, second: FloatArray) -> Jet:
    """The jet of f(a), given f, f' and f'' at a's value."""
    result: Jet = first * a
    result[0] = value
    result[3] += second * a[1] * a[1]
    result[4] += second * a[1] * a[2]
    result[5] += second * a[2] * a[2]
    return result


def inverse(a: Jet) -> Jet:
    """1 / a."""
    value = 1.0 / a[0]
    square = value * value
    return composed(a, value, -square, 2.0 * square * value)


def root(a: Jet) -> Jet:
    """The square root of a."""
    value = np.sqrt(a[0])
    first = 0.5 / value
    return composed(a, value, first, -0.5 * first / a[0])


def raised(a: Jet, floor: float) -> Jet:
    """A jet plus a number."""
    result = a.copy()
    result[0] += floor
    return result


@dataclass(frozen=True)
class Criterion:
    """A criterion of fairness.

    dots: which of the dot products A, B, C, G, H, I it needs.  density: their
    jets, and that of 12 lambda0 lambda1 D, to that of the integrand.  power:
    of the line's length, by which the integral is multiplied.  anchor: the
    weight of |log lambda - log arc|².
    """

    dots: str
    density: Density
    power: int
    anchor: float


def speed_variation(dots: list[Jet], _torsion: Jet) -> Jet:
    """B²/A."""
    a, b = dots
    return times(times(b, b), inverse(a))


def curvature_rate(dots: list[Jet], literal: bool) -> tuple[Jet, Jet]:
    """e, of the curvature as a vector or, literally, as a number; and 1/A."""
    a, b, c, g, h, i = dots
    one_over, steep = inverse(a), times(a, i) - times(h, b)
    bent = times(a, c) - times(b, b)
    share = times(b, one_over)
    if literal:
        main = times(times(steep, steep), inverse(raised(bent, CURVATURE_FLOOR)))
    else:
        main = times(a, g) - times(h, h)
    return main - 6.0 * times(steep, share) + 9.0 * times(bent, times(share, share)), one_over


def curvature_vector_rate(dots: list[Jet], _torsion: Jet) -> Jet:
    """e / A³."""
    e, one_over = curvature_rate(dots, literal=False)
    return times(e, times(one_over, times(one_over, one_over)))


def curvature_number_rate(dots: list[Jet], _torsion: Jet) -> Jet:
    """e / A³, literally."""
    e, one_over = curvature_rate(dots, literal=True)
    return times(e, times(one_over, times(one_over, one_over)))


def squared_torsion(dots: list[Jet], torsion: Jet) -> Jet:
    """(12 lambda0 lambda1 D)² / (W + eps)²."""
    a, b, c = dots
    twist = times(torsion, inverse(raised(times(a, c) - times(b, b), TORSION_FLOOR)))
    return times(twist, twist)


def bending(dots: list[Jet], _torsion: Jet) -> Jet:
    """W / A^(5/2)."""
    a, b, c = dots
    one_over = inverse(a)
    bent = times(a, c) - times(b, b)
    return times(bent, times(times(one_over, one_over), root(one_over)))


def curvature_variation(dots: list[Jet], _torsion: Jet) -> Jet:
    """e / A^(7/2)."""
    e, one_over = curvature_rate(dots, literal=False)
    cube = times(one_over, times(one_over, one_over))
    return times(e, times(cube, root(one_over)))


CRITERIA = {
    "criterion1": Criterion("AB", speed_variation, 0, 0.0),
    "criterion2": Criterion("ABCGHI", curvature_number_rate, 0, 1e-2),
    "criterion2-vector": Criterion("ABCGHI", curvature_vector_rate, 0, 1e-2),
    "criterion3": Criterion("ABC", squared_torsion, 0, 1e-2),
    "bending": Criterion("ABC", bending, 1, 1e-3),
    "curvature-variation": Criterion("ABCGHI", curvature_variation, 3, 1e-2),
}


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines across, each divided by its chord's length.

    grams: (n, 6) the factors of 1, l0, l1, l0², l0 l1, l1² in any dot product:
    1, T0.c, T1.c, 1, T0.T1, 1.  twists: (n,) det(T0, c, T1).
    """

    grams: FloatArray
    twists: FloatArray

    def __getitem__(self, which: BoolArray | slice) -> "Lines":
        """Some of the lines."""
        return Lines(self.grams[which], self.twists[which])


def lines_between(chords: FloatArray, start: FloatArray, end: FloatArray) -> Lines:
    """Lines along unit chords (n, 3) that leave and arrive in unit directions (n, 3)."""
    one = np.ones(len(chords))
    dots = (np.sum(x * y, axis=1) for x, y in ((start, chords), (end, chords), (start, end)))
    g0, g1, g = dots
    grams = np.stack([one, g0, g1, one, g, one], axis=1)
    return Lines(grams, np.sum(np.cross(start, chords) * end, axis=1))


def derivative_rows(v: FloatArray) -> FloatArray:
    """(3, m, 3) F', F'', F''' as multiples of c, lambda0 T0 and lambda1 T1 at v (m,)."""
    one = np.ones_like(v)
    first = np.stack([6 * v - 6 * v**2, 1 - 4 * v + 3 * v**2, 3 * v**2 - 2 * v], axis=1)
    second = np.stack([6 - 12 * v, 6 * v - 4, 6 * v - 2], axis=1)
    return np.stack([first, second, np.stack([-12 * one, 6 * one, 6 * one], axis=1)])


def dot_tables(v: FloatArray) -> dict[str, FloatArray]:
    """For each of A, B, C, G, H, I the (6, m) multiples of a line's grams' monomials at v (m,)."""
    rows = derivative_rows(v)
    tables = {}
    for name, i, j in (
        ("A", 0, 0),
        ("B", 0, 1),
        ("C", 1, 1),
        ("G", 2, 2),
        ("H", 0, 2),
        ("I", 1, 2),
    ):
        pairs = rows[i][:, :, None] * rows[j][:, None, :]
        tables[name] = np.stack(
            [
                pairs[:, 0, 0],
                pairs[:, 0, 1] + pairs[:, 1, 0],
                pairs[:, 0, 2] + pairs[:, 2, 0],
                pairs[:, 1, 1],
                pairs[:, 1, 2] + pairs[:, 2, 1],
                pairs[:, 2, 2],
            ]
        )
    return tables


class Quadrature:
    """A criterion's integral by the Gauss rule of so many nodes, with its derivatives."""

    def __init__(self, criterion: Criterion, nodes: int) -> None:
        places, weights = np.polynomial.legendre.leggauss(nodes)
        tables = dot_tables(0.5 * (places + 1.0))
        self.criterion = criterion
        self.weights = 0.5 * weights
        self.table = np.concatenate([tables[name] for name in criterion.dots], axis=1)

    def __call__(self, lines: Lines, x: FloatArray) -> Jet:
        """(6, n) the criterion's jet by x = log lambda (n, 2), the anchor not counted."""
        monomials = np.exp(x @ EXPONENTS.T) * lines.grams
        jets = (JET_FACTORS[:, None, :] * monomials) @ self.table
        dots = np.split(jets, len(self.criterion.dots), axis=2)
        scale = 12.0 * lines.twists * np.exp(x[:, 0] + x[:, 1])
        torsion = np.broadcast_to(scale[:, None], (6, len(x), 1))
        integral = self.criterion.density(dots, torsion) @ self.weights
        if self.criterion.power == 0:
            return integral
        length = root(dots[0]) @ self.weights
        for _ in range(self.criterion.power):
            integral = times(integral, length)
        return integral


@dataclass(frozen=True, eq=False)
class Fairest:
    """Lengths that minimise a criterion, for n lines.

    factors: (n, 2) multiples of the chord's length.  settled: (n,) where
    Newton's method came to rest; elsewhere the best that was found is given.
    bounded: (n,) where a length lies at the bounds.
    """

    factors: FloatArray
    settled: BoolArray
    bounded: BoolArray


def fairest_lengths(name: str, lines: Lines, arcs: FloatArray) -> Fairest:
    """The tangent lengths (n, 2) that minimise the named criterion, from those of an arc (n, 2)."""
    criterion = CRITERIA[name]
    anchors = np.log(arcs)
    oblique = bool(len(arcs)) and float(lines.grams[:, 1:3].min()) < OBLIQUE
    rule = Quadrature(criterion, NODES[oblique])
    x, settled = np.empty_like(anchors), np.empty(len(anchors), dtype=bool)
    for first in range(0, len(anchors), CHUNK):
        part = slice(first, first + CHUNK)
        x[part], settled[part] = newton(rule, lines[part], anchors[part])
    bounded = np.asarray((np.abs(x) >= BOX).any(axis=1))
    return Fairest(np.exp(x), settled, bounded)


def anchored(rule: Quadrature, lines: Lines, x: FloatArray, anchors: FloatArray) -> Jet:
    """(6, n) the criterion's jet with its anchor."""
    jet = rule(lines, x)
    weight, away = rule.criterion.anchor, x - anchors
    jet[0] += weight * np.sum(away * away, axis=1)
    jet[1:3] += 2.0 * weight * away.T
    jet[[3, 5]] += 2.0 * weight
    return jet


def newton(rule: Quadrature, lines: Lines, anchors: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(n, 2) the minima in log lambda from the anchors on, and whether each was found (n,).

    Each step is bounded, and taken back and halved where it led upwards.
    """
    x = np.clip(anchors, -BOX, BOX)
    settled = np.zeros(len(x), dtype=bool)
    active = np.arange(len(x))
    reach = np.full(len(x), GREATEST_STEP)
    jet = anchored(rule, lines, x, anchors)
    for _ in range(ITERATIONS):
        tried = np.clip(x[active] + bounded_step(jet, x[active], reach[active]), -BOX, BOX)
        size = np.abs(tried - x[active]).max(axis=1)
        done = size < TOLERANCE
        x[active[done]], settled[active[done]] = tried[done], True
        active, jet, tried, size = active[~done], jet[:, ~done], tried[~done], size[~done]
        if len(active) == 0:
            break
        trial = anchored(rule, lines[active], tried, anchors[active])
        better = trial[0] <= jet[0] + ROUNDING * (1.0 + np.abs(jet[0]))
        x[active[better]] = tried[better]
        reach[active] = np.where(better, np.minimum(2.0 * reach[active], GREATEST_STEP), 0.5 * size)
        jet = np.where(better, trial, jet)
    return x, settled


def bounded_step(jet: Jet, x: FloatArray, reach: FloatArray) -> FloatArray:
    """(n, 2) Newton's step, with the Hessian made positive, within `reach` (n,) for each length.

    A length at a bound that the gradient pushes outward stays.
    """
    gradient = jet[1:3].copy()
    h00, h01, h11 = jet[3].copy(), jet[4].copy(), jet[5].copy()
    held = ((x.T >= BOX) & (gradient < 0.0)) | ((x.T <= -BOX) & (gradient > 0.0))
    gradient[held] = 0.0
    h01[held.any(axis=0)] = 0.0
    h00[held[0]] = h11[held[1]] = 1.0
    middle, half = 0.5 * (h00 + h11), 0.5 * (h00 - h11)
    spread = np.hypot(half, h01)
    least, greatest = middle - spread, np.abs(middle) + spread
    floor = np.maximum(1e-6 * greatest, SMALLEST_SHIFT)
    shift = np.where(least < floor, np.maximum(floor - least, 0.0) + np.abs(least), 0.0)
    h00, h11 = h00 + shift, h11 + shift
    determinant = h00 * h11 - h01 * h01
    step = np.stack(
        [h01 * gradient[1] - h11 * gradient[0], h01 * gradient[0] - h00 * gradient[1]], axis=1
    )
    step /= determinant[:, None]
    size = np.abs(step).max(axis=1)
    bounded: FloatArray = step * np.minimum(1.0, reach / np.maximum(size, 1e-300))[:, None]
    return bounded
