"""Lines across that run on smoothly over all passes: cubic or quintic splines of least energy.

At every common parameter a line across runs over all passes.  As a curve of
t, about its arc length, it passes through the points of the passes, where it
is tangent to the surface: F_t = x V + y tau.  Between them it is

    cubic:    minimising the sum of int |F_tt|² dt; its tangents are common to
              both sides of a pass
    quintic:  minimising the sum of int |F_ttt|² + (e/h²) |F_tt|² dt, with
              F_tt common to both sides too, so that the surface has the same
              curvature on both sides of a pass; h the mean distance of
              passes, e = 1/100

Both are linear systems with a block for each pass and one for each two
neighbours, solved by block elimination at all parameters at once.
"""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import dot, unit
from georibbon.geometry.rails import PINCHED, Rails

STIFFNESS = 1e-2  # e: without it two passes alone do not determine a quintic

# Bases in powers of v: rows are powers, columns the values and derivatives at v = 0, then at 1.
CUBIC = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-3.0, -2.0, 3.0, -1.0], [2.0, 1.0, -2.0, 1.0]]
)
QUINTIC = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
        [-10.0, -6.0, -1.5, 10.0, -4.0, 0.5],
        [15.0, 8.0, 1.5, -15.0, 7.0, -1.0],
        [-6.0, -3.0, -0.5, 6.0, -3.0, 0.5],
    ]
)


def energy(basis: FloatArray, order: int) -> FloatArray:
    """(n, n) the integrals over v from 0 to 1 of products of a basis's derivatives."""
    powers = np.arange(len(basis))
    kept = powers >= order
    falling = np.array([np.prod(np.arange(k, k - order, -1.0)) for k in powers])
    rows = (falling[:, None] * basis)[kept]
    left = powers[kept] - order
    integrals: FloatArray = rows.T @ (1.0 / (left[:, None] + left + 1.0)) @ rows
    return integrals


def smooth_directions(rails: Rails) -> FloatArray:
    """(p, k, 3) unit: the tangents at every pass of the cubic lines of least bending."""
    widths, _ = line_widths(rails)
    scales = widths[..., None] ** np.array([0.0, 1.0, 0.0, 1.0])
    stiff = (scales[..., None] * scales[..., None, :]) * energy(CUBIC, 2)
    return unit(solved(rails, stiff / widths[..., None, None] ** 3)[:, :, 0])


def quintic_control(rails: Rails) -> FloatArray:
    """(p-1, k, 6, 3) metres: F, F_v, F_vv at v = 0, then F_vv, F_v, F at v = 1, of all patches."""
    widths, mean = line_widths(rails)
    scales = widths[..., None] ** np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0])
    products = scales[..., None] * scales[..., None, :]
    wide = widths[..., None, None]
    stiff = products * (energy(QUINTIC, 3) / wide**5 + STIFFNESS * energy(QUINTIC, 2) / wide**3)
    found = solved(rails, stiff) * mean[:, None, None]
    start, end = (
        found[side] * np.stack([widths, widths**2], axis=-1)[..., None]
        for side in (slice(None, -1), slice(1, None))
    )
    ends = rails.points[:-1, :, None], rails.points[1:, :, None]
    return np.concatenate([ends[0], start, end[:, :, ::-1], ends[1]], axis=2)


def line_widths(rails: Rails) -> tuple[FloatArray, FloatArray]:
    """About the lines' lengths (p-1, k) in mean distances of passes, and these (k,), metres.

    d (1 + (b0² + b1²)/15 - b0 b1/30) with the angles b = asin(c.N) at either end: exact to the
    second order.
    """
    c = unit(rails.chords)
    b0, b1 = (
        np.arcsin(np.clip(dot(c, normals), -1.0, 1.0))
        for normals in (rails.frames[:-1, :, :, 2], rails.frames[1:, :, :, 2])
    )
    gaps = np.maximum(rails.gaps, PINCHED)
    mean: FloatArray = np.mean(gaps, axis=0)
    widths: FloatArray = gaps / mean * (1.0 + (b0**2 + b1**2) / 15.0 - b0 * b1 / 30.0)
    return widths, mean


def solved(rails: Rails, stiff: FloatArray) -> FloatArray:
    """(p, k, d, 3) the derivatives at all passes that minimise the sum of the patches' energies.

    stiff: (p-1, k, 2 + 2 d, 2 + 2 d), each patch's energy as a form of value
    and derivatives at either pass, for t and points in mean distances of
    passes.  The first derivative lies in the tangent plane, others are free.
    """
    half = stiff.shape[-1] // 2
    _, mean = line_widths(rails)
    places = (rails.points - rails.points[:1]) / mean[:, None]
    free = freedoms(rails.frames, half - 1)
    inner, outer = slice(1, half), slice(half + 1, None)
    diagonal = np.zeros((*places.shape[:2], free.shape[-1], free.shape[-1]))
    side = np.zeros((*places.shape[:2], free.shape[-1]))
    for ends, rows in ((slice(None, -1), inner), (slice(1, None), outer)):
        diagonal[ends] += squeezed(free[ends], stiff[..., rows, rows], free[ends])
        # A shift of all points costs nothing, so only the chord counts.
        pull = stiff[..., rows, half, None] * np.diff(places, axis=0)[:, :, None]
        flat = pull.reshape(*pull.shape[:2], -1)
        side[ends] -= np.einsum("...ia,...i->...a", free[ends], flat)
    coupling = squeezed(free[:-1], stiff[..., inner, outer], free[1:])
    unknowns = block_solved(diagonal, coupling, side)
    found: FloatArray = np.einsum("...ia,...a->...i", free, unknowns)
    return found.reshape(*places.shape[:2], half - 1, 3)


def freedoms(frames: FloatArray, count: int) -> FloatArray:
    """(p, k, 3 d, 3 d - 1) from unknowns to derivatives: V and tau for the first, then all axes."""
    free = np.zeros((*frames.shape[:2], 3 * count, 3 * count - 1))
    free[..., :3, 0], free[..., :3, 1] = frames[..., 1], frames[..., 0]
    free[..., 3:, 2:] = np.eye(3 * count - 3)
    return free


def squeezed(left: FloatArray, form: FloatArray, right: FloatArray) -> FloatArray:
    """(..., n, n) left^T (form ⊗ I) right, for forms (..., d, d) and left, right (..., 3 d, n)."""
    d = form.shape[-1]
    full = np.einsum("...rs,ab->...rasb", form, np.eye(3)).reshape(*form.shape[:-2], 3 * d, 3 * d)
    product: FloatArray = np.swapaxes(left, -1, -2) @ full @ right
    return product


def block_solved(diagonal: FloatArray, coupling: FloatArray, side: FloatArray) -> FloatArray:
    """(p, k, n) the solution of symmetric block-tridiagonal systems.

    diagonal: (p, k, n, n), coupling: (p-1, k, n, n) between each block and the
    next, side: (p, k, n).
    """
    pivots, reduced = [diagonal[0]], [side[0]]
    carried = []
    for i, upper in enumerate(coupling):
        both = np.concatenate([upper, reduced[i][..., None]], axis=-1)
        parts = np.linalg.solve(pivots[i], both)
        carried.append(parts)
        lower = np.swapaxes(upper, -1, -2)
        pivots.append(diagonal[i + 1] - lower @ parts[..., :-1])
        reduced.append(side[i + 1] - (lower @ parts[..., -1:])[..., 0])
    found = [np.linalg.solve(pivots[-1], reduced[-1][..., None])[..., 0]]
    for parts in reversed(carried):
        found.append(parts[..., -1] - (parts[..., :-1] @ found[-1][..., None])[..., 0])
    return np.stack(found[::-1])
