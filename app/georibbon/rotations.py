"""Rotations by their vectors, over stacks of any shape.

A rotation vector phi (…, 3), radians, stands for exp([phi]x).  Angles come
from atan2, never from arccos, which loses half the digits near zero.
"""

import numpy as np

from georibbon.arrays import FloatArray

# Below this angle the closed forms lose digits to cancellation and series take over; at 0.02 rad
# the first neglected term of the series is below 1e-12.
_SMALL = 0.02


def skew(v: FloatArray) -> FloatArray:
    """(…, 3) to (…, 3, 3): the matrix [v]x with [v]x w = v x w."""
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1] = -v[..., 2]
    out[..., 0, 2] = v[..., 1]
    out[..., 1, 0] = v[..., 2]
    out[..., 1, 2] = -v[..., 0]
    out[..., 2, 0] = -v[..., 1]
    out[..., 2, 1] = v[..., 0]
    return out


def _coefficients(phi: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """sin(a)/a, (1 - cos a)/a² and (a - sin a)/a³ for the angles a = |phi|."""
    square = np.sum(phi * phi, axis=-1)
    small = square < _SMALL**2
    safe = np.where(small, 1.0, square)
    angle = np.sqrt(safe)
    sine = np.where(small, 1 - square / 6 * (1 - square / 20), np.sin(angle) / angle)
    cosine = np.where(small, 0.5 - square / 24 * (1 - square / 30), (1 - np.cos(angle)) / safe)
    third = np.where(
        small, 1 / 6 - square / 120 * (1 - square / 42), (angle - np.sin(angle)) / (safe * angle)
    )
    return sine, cosine, third


def _polynomial(phi: FloatArray, linear: FloatArray, square: FloatArray) -> FloatArray:
    """I + linear [phi]x + square [phi]x², with [phi]x² = phi phi^T - |phi|² I."""
    out = square[..., None, None] * (phi[..., :, None] * phi[..., None, :])
    out += linear[..., None, None] * skew(phi)
    diagonal = 1.0 - square * np.sum(phi * phi, axis=-1)
    for k in range(3):
        out[..., k, k] += diagonal
    return out


def exp(phi: FloatArray) -> FloatArray:
    """(…, 3) rotation vectors to (…, 3, 3) rotations (Rodrigues)."""
    sine, cosine, _ = _coefficients(phi)
    return _polynomial(phi, sine, cosine)


def exp_and_jacobian(phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The rotations and their left Jacobians, (…, 3, 3) each.

    exp([phi + d]x) = exp([J d]x) exp([phi]x) to first order in d, with
    J = I + (1 - cos a)/a² [phi]x + (a - sin a)/a³ [phi]x².
    """
    sine, cosine, third = _coefficients(phi)
    return _polynomial(phi, sine, cosine), _polynomial(phi, cosine, third)


def log(rotations: FloatArray) -> FloatArray:
    """(…, 3, 3) rotations to (…, 3) rotation vectors of angle 0 to pi.

    At exactly half a turn the axis has two signs; one of them is returned.
    """
    r = rotations
    axial = 0.5 * np.stack(
        [
            r[..., 2, 1] - r[..., 1, 2],
            r[..., 0, 2] - r[..., 2, 0],
            r[..., 1, 0] - r[..., 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(axial, axis=-1)
    cosine = 0.5 * (np.trace(r, axis1=-2, axis2=-1) - 1.0)
    angle = np.arctan2(sine, cosine)
    factor = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1.0)
    out = np.asarray(factor[..., None] * axial)
    return np.asarray(np.where((cosine < -0.99)[..., None], _near_half_turn(r, axial, angle), out))


def _near_half_turn(r: FloatArray, axial: FloatArray, angle: FloatArray) -> FloatArray:
    """The rotation vector where sin(angle) is too small to give the axis: from R + R^T.

    Near half a turn 1 - cos(angle) is nearly 2; elsewhere the result is not used.
    """
    cosine = np.cos(angle)[..., None, None]
    outer = (0.5 * (r + np.swapaxes(r, -1, -2)) - cosine * np.eye(3)) / np.maximum(
        1.0 - cosine, 1.0
    )
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    axis = np.take_along_axis(outer, largest[..., None, None], axis=-1)[..., 0]
    axis = axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-300)
    sign = np.where(np.sum(axis * axial, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    return np.asarray(sign * angle[..., None] * axis)


def to_up(gravity: FloatArray) -> FloatArray:
    """(…, 3) directions to (…, 3, 3) rotations R with R gravity/|gravity| = (0, 0, 1).

    The smallest such rotation; for straight down, a half turn about x.
    """
    g = gravity / np.linalg.norm(gravity, axis=-1, keepdims=True)
    x, y, z = g[..., 0], g[..., 1], g[..., 2]
    zero = np.zeros_like(x)
    axial = np.stack([y, -x, zero], axis=-1)
    sine = np.hypot(x, y)
    flat = sine < 1e-12
    axis = np.where(
        flat[..., None], np.array([1.0, 0.0, 0.0]), axial / np.where(flat, 1.0, sine)[..., None]
    )
    return exp(axis * np.arctan2(sine, z)[..., None])


def _about(angle: FloatArray | float, axis: int) -> FloatArray:
    a = np.asarray(angle, dtype=float)
    one, other = (axis + 1) % 3, (axis + 2) % 3
    out = np.zeros((*a.shape, 3, 3))
    out[..., one, one] = out[..., other, other] = np.cos(a)
    out[..., other, one] = np.sin(a)
    out[..., one, other] = -out[..., other, one]
    out[..., axis, axis] = 1.0
    return out


def about_x(angle: FloatArray | float) -> FloatArray:
    """Right-handed rotations (…, 3, 3) by the angles (…), radians, about x."""
    return _about(angle, 0)


def about_y(angle: FloatArray | float) -> FloatArray:
    """Right-handed rotations (…, 3, 3) by the angles (…), radians, about y."""
    return _about(angle, 1)


def about_z(angle: FloatArray | float) -> FloatArray:
    """Rotations (…, 3, 3) by the angles (…), radians counter-clockwise from above, about z."""
    return _about(angle, 2)
