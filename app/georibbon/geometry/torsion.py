"""Directions across with the least torsion, by angles that change linearly along the passes.

The fourth criterion of Sprynski, Szafran, Lacolle and Biard (2008): the lines
across of a patch, with tangents as long as their chords, leave and arrive at
angles alpha0(u) and alpha1(u) from the conormals, both linear in u, that
minimise the sum of the squared torsion over the patch,

    theta = 12 D / (|F' x F''|² + eps),  D = det(T0, c, T1)

By itself that drives lines askew, for theta falls as they twist; so the angles
start at the linear fit of those in which every line has no torsion at all, in
the plane of its chord and the mean normal, and stay within ten degrees of it.
"""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.directions import angles_of, at_angles, section_directions
from georibbon.geometry.fairness import derivative_rows
from georibbon.geometry.frames import cross, dot, unit
from georibbon.geometry.rails import Rails

FLOOR = 1e-3  # eps
REACH = np.radians(10.0)
NODES = 8
ITERATIONS = 30
TOLERANCE = 1e-6
ROUNDING = 1e-13
LEAST_STIFFNESS = 1e-12
DIFFERENCE = 1e-5
MOST_LINES = 33


def least_torsion_angles(
    rails: Rails, share: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(p-1, 2, 2) angles, radians, at either pass, at its beginning and its end.

    share: (k,) from 0 at the beginning to 1 at the end.  Also for each patch
    (p-1,) whether the minimum was not found, and whether it lies at the bounds,
    as 0 or 1.  Newton's method, the Hessian by differences of the gradient.
    """
    some = np.unique(np.linspace(0, len(share) - 1, MOST_LINES).astype(int))
    rails = Rails(rails.points[:, some], rails.frames[:, some])
    ramp = np.stack([1.0 - share[some], share[some]], axis=1)
    x = linear_fit(rails, ramp)
    low, high = x - REACH, x + REACH
    value, gradient = torsion_sum(rails, x, ramp)
    damping, settled = np.full(len(x), 1e-3), np.zeros(len(x), dtype=bool)
    for _ in range(ITERATIONS):
        step = damped_step(gradient, bends(rails, x, ramp), low - x, high - x, damping)
        settled |= (np.abs(step).max(axis=1) < TOLERANCE) & (damping < 1.0)
        if settled.all():
            break
        other, slope = torsion_sum(rails, x + step, ramp)
        better = other <= value + ROUNDING * (1.0 + value)
        x = np.where(better[:, None], x + step, x)
        value = np.where(better, other, value)
        gradient = np.where(better[:, None], slope, gradient)
        damping = np.where(better, 0.1 * damping, 10.0 * damping)
    bounded = (np.minimum(x - low, high - x) < TOLERANCE).any(axis=1)
    return x.reshape(-1, 2, 2), (~settled).astype(float), bounded.astype(float)


def torsion_sum(rails: Rails, x: FloatArray, ramp: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(..., p-1) half the sum of the squared torsion, and its gradient by x (..., p-1, 4)."""
    residuals, slopes = torsions(rails, x, ramp)
    gradient: FloatArray = (residuals[..., None, :] @ slopes)[..., 0, :]
    return 0.5 * np.sum(residuals**2, axis=-1), gradient


def bends(rails: Rails, x: FloatArray, ramp: FloatArray) -> FloatArray:
    """(p-1, 4, 4) the Hessian of the sum, by central differences of its gradient."""
    steps = DIFFERENCE * np.concatenate([np.eye(4), -np.eye(4)])
    slopes = torsion_sum(rails, x + steps[:, None], ramp)[1]
    form = np.moveaxis(slopes[:4] - slopes[4:], 0, 2) / (2.0 * DIFFERENCE)
    symmetric: FloatArray = 0.5 * (form + np.swapaxes(form, 1, 2))
    return symmetric


def linear_fit(rails: Rails, ramp: FloatArray) -> FloatArray:
    """(p-1, 4) the linear fit of the angles at which lines have no torsion."""
    directions = section_directions(rails)
    found = [
        angles_of(one, frames) @ np.linalg.pinv(ramp).T
        for one, frames in zip(directions, (rails.frames[:-1], rails.frames[1:]), strict=True)
    ]
    return np.concatenate(found, axis=1)


def damped_step(
    gradient: FloatArray, form: FloatArray, low: FloatArray, high: FloatArray, damping: FloatArray
) -> FloatArray:
    """(p-1, 4) Newton's steps between low and high (p-1, 4), with the Hessian made positive.

    What would go beyond a bound is held there, and the others step again.
    """
    sizes, axes = np.linalg.eigh(form)
    sizes = np.abs(sizes) + (damping * np.abs(sizes).max(axis=1))[:, None] + LEAST_STIFFNESS
    form = (axes * sizes[:, None, :]) @ np.swapaxes(axes, 1, 2)
    held = ((low >= 0.0) & (gradient > 0.0)) | ((high <= 0.0) & (gradient < 0.0))
    step = np.zeros_like(gradient)
    for _ in range(5):
        pull = gradient + np.einsum("pij,pj->pi", form, np.where(held, step, 0.0))
        rest = np.where(held[:, :, None] | held[:, None, :], np.eye(4), form)
        free = -np.linalg.solve(rest, np.where(held, 0.0, pull)[..., None])[..., 0]
        step = np.where(held, step, free)
        beyond = (step < low) | (step > high)
        held, step = held | beyond, np.clip(step, low, high)
        if not beyond.any():
            break
    return step


def torsions(rails: Rails, x: FloatArray, ramp: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(..., p-1, r) theta at all lines and Gauss nodes, by the root of the node's weight, and its
    derivatives (..., p-1, r, 4) by the angles x (..., p-1, 4).

    ramp: (k, 2) the shares of the angles at the beginning and at the end.
    """
    places, weights = np.polynomial.legendre.leggauss(NODES)
    first, second, _ = derivative_rows(0.5 * (places + 1.0))
    angles = np.einsum("ka,...pia->...pik", ramp, x.reshape(*x.shape[:-1], 2, 2))
    frames = rails.frames[:-1], rails.frames[1:]
    t = [at_angles(frames[i], angles[..., i, :]) for i in range(2)]
    turned = [at_angles(frames[i], angles[..., i, :] + 0.5 * np.pi) for i in range(2)]
    c = np.broadcast_to(unit(rails.chords), t[0].shape)
    control = np.stack([c, *t], axis=-2)
    speed, bend = first @ control, second @ control
    square = cross(speed, bend)
    size = dot(square, square) + FLOOR
    root = 12.0 * np.sqrt(0.5 * weights)
    twist = triple(t[0], c, t[1])
    slopes = []
    for i, moved in enumerate((triple(turned[0], c, t[1]), triple(t[0], c, turned[1]))):
        ahead = turned[i][..., None, :]
        change = cross(first[:, 1 + i, None] * ahead, bend)
        change += cross(speed, second[:, 1 + i, None] * ahead)
        growth = 2.0 * dot(square, change) / size
        by_angle = root * (moved[..., None] - twist[..., None] * growth) / size
        slopes.append(by_angle[..., None] * ramp[:, None, :])
    theta = root * twist[..., None] / size
    both = np.concatenate(slopes, axis=-1)
    return theta.reshape(*x.shape[:-1], -1), both.reshape(*x.shape[:-1], -1, 4)


def triple(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """(...) the determinants of vectors (..., 3)."""
    return dot(cross(a, b), c)
