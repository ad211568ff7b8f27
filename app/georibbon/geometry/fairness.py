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

where e/A³ is the square of the derivative of the curvature vector kappa n,
its part along the line left out: (d kappa/dv)² and kappa² times the squared
turn of the normal.  That is smooth where the curvature vanishes.  The literal
criterion 2 has (AI - HB)² / (W + eps) in the place of AG - H²: (d kappa/dv)²
alone, with a corner there.  Criteria 1 to 3 are those
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
        step = bounded_step(jet, x[active], reach[active])
        size = np.abs(step).max(axis=1)
        done = (size < TOLERANCE) & (size < reach[active])
        x[active[done]] += step[done]
        settled[active[done]] = True
        active, jet, step, size = active[~done], jet[:, ~done], step[~done], size[~done]
        if len(active) == 0:
            break
        trial = anchored(rule, lines[active], x[active] + step, anchors[active])
        better = trial[0] <= jet[0] + ROUNDING * (1.0 + np.abs(jet[0]))
        x[active[better]] += step[better]
        wider = np.minimum(2.0 * reach[active], GREATEST_STEP)
        reach[active] = np.where(better, wider, 0.5 * size)
        jet = np.where(better, trial, jet)
    return x, settled


def bounded_step(jet: Jet, x: FloatArray, reach: FloatArray) -> FloatArray:
    """(n, 2) the step to the minimum of the quadratic within the bounds and `reach` (n,).

    The Hessian is made positive where it is not.  Where Newton's step leads
    outside, the minimum lies on one of the four sides.
    """
    low, high = np.maximum(-BOX - x.T, -reach), np.minimum(BOX - x.T, reach)
    g, h01 = jet[1:3], jet[4]
    h = jet[[3, 5]] + positive_shift(jet)
    step = np.stack([h01 * g[1] - h[1] * g[0], h01 * g[0] - h[0] * g[1]])
    step /= h[0] * h[1] - h01 * h01
    out = ((step < low) | (step > high)).any(axis=0)
    if out.any():
        step[:, out] = least_side(g[:, out], h[:, out], h01[out], low[:, out], high[:, out])
    return step.T


def least_side(
    g: FloatArray, h: FloatArray, h01: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """(2, n) the minimum of g.s + s.(H s)/2 on the sides of the rectangles from low to high (2, n).

    h: (2, n), h01: (n,), the Hessians' diagonals and other element.
    """
    step, best = np.zeros_like(g), np.full(g.shape[1], np.inf)
    for fixed, bound in ((0, low), (0, high), (1, low), (1, high)):
        other = 1 - fixed
        side = np.empty_like(g)
        side[fixed] = bound[fixed]
        free = -(g[other] + h01 * side[fixed]) / h[other]
        side[other] = np.clip(free, low[other], high[other])
        value = np.sum(g * side + 0.5 * h * side * side, axis=0) + h01 * side[0] * side[1]
        step = np.where(value < best, side, step)
        best = np.minimum(best, value)
    return step


def positive_shift(jet: Jet) -> FloatArray:
    """(n,) what makes the Hessians positive when added to their diagonals."""
    middle, half = 0.5 * (jet[3] + jet[5]), 0.5 * (jet[3] - jet[5])
    spread = np.hypot(half, jet[4])
    least, floor = middle - spread, np.maximum(1e-6 * (np.abs(middle) + spread), SMALLEST_SHIFT)
    shift: FloatArray = np.where(least < floor, floor - least + np.abs(least), 0.0)
    return shift
