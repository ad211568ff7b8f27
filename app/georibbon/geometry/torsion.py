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
from georibbon.geometry.frames import unit
from georibbon.geometry.rails import Rails

FLOOR = 1e-3  # eps
REACH = np.radians(10.0)
NODES = 8
ITERATIONS = 60
TOLERANCE = 1e-7


def least_torsion_angles(
    rails: Rails, share: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(p-1, 2, 2) angles, radians, at either pass, at its beginning and its end.

    share: (k,) from 0 at the beginning to 1 at the end.  Also for each patch
    (p-1,) whether the minimum was not found, and whether it lies at the bounds, as 0 or 1.
    """
    ramp = np.stack([1.0 - share, share], axis=1)
    start = linear_fit(rails, ramp)
    low, high = start - REACH, start + REACH
    x, damping = start.copy(), np.full(len(start), 1e-3)
    residuals, slopes = torsions(rails, x, ramp)
    settled = np.zeros(len(start), dtype=bool)
    for _ in range(ITERATIONS):
        tried = np.clip(x + damped_step(residuals, slopes, x, (low, high), damping), low, high)
        size = np.abs(tried - x).max(axis=1)
        others, other_slopes = torsions(rails, tried, ramp)
        better = np.sum(others**2, axis=1) <= np.sum(residuals**2, axis=1)
        settled |= size < TOLERANCE
        x = np.where(better[:, None], tried, x)
        residuals = np.where(better[:, None], others, residuals)
        slopes = np.where(better[:, None, None], other_slopes, slopes)
        damping = np.where(better, 0.2 * damping, 10.0 * damping)
        if settled.all():
            break
    bounded = ((x == low) | (x == high)).any(axis=1)
    return x.reshape(-1, 2, 2), (~settled).astype(float), bounded.astype(float)


def linear_fit(rails: Rails, ramp: FloatArray) -> FloatArray:
    """(p-1, 4) the linear fit of the angles at which lines have no torsion."""
    directions = section_directions(rails)
    found = [
        angles_of(one, frames) @ np.linalg.pinv(ramp).T
        for one, frames in zip(directions, (rails.frames[:-1], rails.frames[1:]), strict=True)
    ]
    return np.concatenate(found, axis=1)


def damped_step(
    residuals: FloatArray,
    slopes: FloatArray,
    x: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    damping: FloatArray,
) -> FloatArray:
    """(p-1, 4) Levenberg and Marquardt's steps; what a bound holds stays."""
    gradient = np.einsum("pri,pr->pi", slopes, residuals)
    form = np.einsum("pri,prj->pij", slopes, slopes)
    held = ((x <= bounds[0]) & (gradient > 0.0)) | ((x >= bounds[1]) & (gradient < 0.0))
    form[held[:, :, None] | held[:, None, :]] = 0.0
    scale = np.trace(form, axis1=1, axis2=2)[:, None] * damping[:, None] + 1e-12
    form[:, range(4), range(4)] += np.where(held, 1.0, scale)
    step: FloatArray = -np.linalg.solve(form, np.where(held, 0.0, gradient)[..., None])[..., 0]
    return step


def torsions(rails: Rails, x: FloatArray, ramp: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(p-1, r) theta at all lines and Gauss nodes, by the root of the node's weight, with its
    derivatives (p-1, r, 4) by the angles x (p-1, 4)."""
    places, weights = np.polynomial.legendre.leggauss(NODES)
    first, second, _ = derivative_rows(0.5 * (places + 1.0))
    angles = np.einsum("ka,pia->pik", ramp, x.reshape(-1, 2, 2))
    frames = rails.frames[:-1], rails.frames[1:]
    c = unit(rails.chords)
    t = [at_angles(frames[i], angles[:, i]) for i in range(2)]
    dt = [at_angles(frames[i], angles[:, i] + 0.5 * np.pi) for i in range(2)]
    products = [np.cross(*(row @ np.stack([c, *t], axis=2) for row in (first, second)))]
    twist = [np.sum(np.cross(t[0], c) * t[1], axis=-1)]
    for i in range(2):
        lone = np.zeros((*c.shape[:2], 3, 3))
        lone[:, :, 1 + i] = dt[i]
        moved = [t[0], t[1]]
        moved[i] = dt[i]
        products.append(
            np.cross(first @ lone, second @ np.stack([c, *t], axis=2))
            + np.cross(first @ np.stack([c, *t], axis=2), second @ lone)
        )
        twist.append(np.sum(np.cross(moved[0], c) * moved[1], axis=-1))
    size = np.sum(products[0] ** 2, axis=-1) + FLOOR
    root = np.sqrt(0.5 * weights)
    theta = 12.0 * root * twist[0][..., None] / size
    slopes = []
    for i in range(2):
        growth = 2.0 * np.sum(products[0] * products[1 + i], axis=-1)
        by_angle = 12.0 * root * (twist[1 + i][..., None] - twist[0][..., None] * growth / size)
        slopes.append((by_angle / size)[..., None] * ramp[:, None, :])
    both = np.concatenate(slopes, axis=-1)
    return theta.reshape(len(x), -1), both.reshape(len(x), -1, 4)
