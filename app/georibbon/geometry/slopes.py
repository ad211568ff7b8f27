"""The control of the lines across with its derivative along the passes.

A line leaves or reaches a pass along T = (a V + b tau) / r, r = |(a, b)|, with
a = max(c.V, 1/4) and b = c.tau for the safe chord, c the unit chord, and a = 1 and
b = 0 for the conormal.  Its tangent there is w a V + w b tau, w = l / r with the
length l; these and the products are differentiated by the common parameter,
as are those of the closed form l = 2 d / (1 + T.c), d the chord's length.
Directions that are solved for are differentiated numerically.
"""

from collections.abc import Callable, Sequence

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.components import dotted, inner
from georibbon.geometry.directions import LEAST_ADVANCE
from georibbon.geometry.rails import PINCHED, Rails, Rates
from georibbon.geometry.scheme import Scheme, control_of

STEP = 1e-5  # m
IN_CLOSED_FORM = ("safe-chord", "conormal")

Changing = tuple[FloatArray, FloatArray]
Steer = Callable[[FloatArray, Rails, FloatArray], FloatArray]


def control_with_slope(
    rails: Rails, rates: Rates, scheme: Scheme, u: FloatArray, steer: Steer | None = None
) -> Changing:
    """(p-1, k, c, 3) metres: the patches' control, and its derivative by u (k,).

    rates: the derivatives of the rails by u.  steer: what is done to the control, if anything.
    """
    simple = scheme.interior == "g1" and scheme.angles is None and steer is None
    if simple and scheme.direction in IN_CLOSED_FORM:
        found = hermite_with_slope(rails, rates, scheme, u)
        if found is not None:
            return found
    control, before, after = (
        steered(moved(rails, rates, step), scheme, u + step, steer) for step in (0.0, -STEP, STEP)
    )
    return control, (after - before) / (2.0 * STEP)


def steered(rails: Rails, scheme: Scheme, u: FloatArray, steer: Steer | None) -> FloatArray:
    """(p-1, k, c, 3) metres: the patches' control, with what is done to it."""
    control = control_of(rails, scheme, u)
    return control if steer is None else steer(control, rails, u)


def moved(rails: Rails, rates: Rates, step: float) -> Rails:
    """The rails a little further on."""
    return Rails(rails.points + step * rates.points, rails.frames + step * rates.frames)


def hermite_with_slope(
    rails: Rails, rates: Rates, scheme: Scheme, u: FloatArray
) -> Changing | None:
    """The same in closed form; None where strips lie on each other."""
    points, moves = inner(rails.points), inner(rates.points)
    chord, change = points[:, 1:] - points[:, :-1], moves[:, 1:] - moves[:, :-1]
    gap = np.sqrt(dotted(chord, chord))
    if gap.min() < PINCHED:
        return None
    c = chord / gap
    growth = dotted(c, change)
    dc = (change - growth * c) / gap
    (tau, v), (dtau, dv) = both_ends(rails), both_ends(rates)
    x, dx = part(c, v), part(dc, v) + part(c, dv)
    y, dy = part(c, tau), part(dc, tau) + part(c, dtau)
    ahead, dahead, aside, daside = heading(x, dx, y, dy, scheme)
    size = np.sqrt(ahead * ahead + aside * aside)
    dsize = (ahead * dahead + aside * daside) / size
    lean, dlean = size, dsize
    if ahead is not x:
        lean = (ahead * x + aside * y) / size
        dlean = dahead * x + ahead * dx + daside * y + aside * dy
        dlean = (dlean - lean * dsize) / size
    factor, dfactor = factors(lean, dlean, scheme, u)
    scale = factor * gap / size
    dscale = (dfactor * gap + factor * growth - scale * dsize) / size
    p, dp = scale * ahead, dscale * ahead + scale * dahead
    q, dq = scale * aside, dscale * aside + scale * daside
    return (
        assembled(points, ((p, v), (q, tau))),
        assembled(moves, ((dp, v), (dq, tau), (p, dv), (q, dtau))),
    )


def both_ends(moving: Rails | Rates) -> tuple[FloatArray, FloatArray]:
    """tau and V at the first and second strip of each patch, (2, 3, p-1, k) each."""
    axes = moving.frames.transpose(3, 2, 0, 1)[:2]
    strips, count = axes.shape[2:]
    ends = np.empty((2, 2, 3, strips - 1, count))
    ends[:, 0], ends[:, 1] = axes[:, :, :-1], axes[:, :, 1:]
    return ends[0], ends[1]


def part(chords: FloatArray, axes: FloatArray) -> FloatArray:
    """(2, p-1, k) the parts of chords (3, p-1, k) along axes (2, 3, p-1, k) at either end."""
    parts: FloatArray = np.einsum("iqk,eiqk->eqk", chords, axes)
    return parts


def heading(
    x: FloatArray, dx: FloatArray, y: FloatArray, dy: FloatArray, scheme: Scheme
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """(2, p-1, k) each: a and b of the direction a V + b tau, each before its derivative.

    x, y: c.V and c.tau, before their derivatives.
    """
    if scheme.direction == "conormal":
        zero = np.zeros_like(x)
        return np.ones_like(x), zero, zero, zero
    if x.min() >= LEAST_ADVANCE:
        return x, dx, y, dy
    ahead = np.maximum(x, LEAST_ADVANCE)
    return ahead, np.where(ahead == x, dx, 0.0), y, dy


def factors(lean: FloatArray, dlean: FloatArray, scheme: Scheme, u: FloatArray) -> Changing:
    """(2, p-1, k) the lengths as factors of the chord's, and their derivatives.

    lean: T.c, dlean: its derivative, of which those of an arc are made.
    """
    if scheme.factors is not None:
        constant = np.broadcast_to(np.reshape(scheme.factors, (2, 1, 1)), lean.shape)
        return constant, np.zeros_like(lean)
    if scheme.found is not None and scheme.found.logs is not None:
        logs, rate = (np.moveaxis(scheme.found.logs(u, order), (2, 1), (0, 1)) for order in (0, 1))
        return np.exp(logs), np.exp(logs) * rate
    kept = np.minimum(np.maximum(lean, 0.0), 1.0)
    factor = 2.0 / (1.0 + kept)
    return factor, np.where(kept == lean, -0.5 * factor * factor * dlean, 0.0)


def assembled(points: FloatArray, terms: Sequence[Changing]) -> FloatArray:
    """(p-1, k, 4, 3) control of points (3, p, k) and the tangents at either end:

    the sum of factors (2, p-1, k) times vectors (2, 3, p-1, k).
    """
    control = np.empty((4, 3, points.shape[1] - 1, points.shape[2]))
    control[0], control[3] = points[:, :-1], points[:, 1:]
    tangents = control[1:3]
    (factor, vectors), *rest = terms
    np.multiply(factor[:, None], vectors, out=tangents)
    spare = np.empty_like(vectors)
    for factor, vectors in rest:
        tangents += np.multiply(factor[:, None], vectors, out=spare)
    return control.transpose(2, 3, 0, 1)
