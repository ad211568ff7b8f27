"""In which direction the lines across leave a pass and reach the next.

Every direction is a unit vector T square to the pass's normal N.  With c the
unit chord between matched points, tau the tangent and V the conormal:

    conormal        T = V
    chord           T = normalise(c - (c.N) N)
    safe chord      T = normalise(max(c.V, 1/4) V + (c.tau) tau)
    section         T_i = normalise((S.N_i) c - (c.N_i) S), S = N_0 + N_1
    angles          T = cos(alpha) V + sin(alpha) tau

In a section the line's end tangents and its chord lie in one plane, that of c
and the mean normal, so that its torsion is zero.  Where two passes lie within
a millimetre of each other every direction is V.
"""

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import dot, unit
from georibbon.geometry.rails import Rails
from georibbon.geometry.settings import Direction

LEAST_ADVANCE = 0.25
LEAST_CHORD = 1e-6  # of a chord's part in the tangent plane, below which it has no direction

Ends = tuple[FloatArray, FloatArray]


def directions_of(rails: Rails, kind: Direction) -> Ends:
    """(p-1, k, 3) twice: unit directions in which lines leave their first and reach their second
    strip; for the kind "angles" see `angled_directions`.
    """
    if kind == "section":
        found = section_directions(rails)
    elif kind in {"chord", "safe-chord"}:
        ahead = safe_direction if kind == "safe-chord" else projected_direction
        c = unit(rails.chords)
        found = ahead(c, rails.frames[:-1]), ahead(c, rails.frames[1:])
    else:
        found = rails.frames[:-1, :, :, 1], rails.frames[1:, :, :, 1]
    return where_apart(rails, found)


def where_apart(rails: Rails, found: Ends) -> Ends:
    """The directions found; the conormals where the strips lie on each other."""
    pinched = rails.pinched[..., None]
    return (
        np.where(pinched, rails.frames[:-1, :, :, 1], found[0]),
        np.where(pinched, rails.frames[1:, :, :, 1], found[1]),
    )


def angled_directions(rails: Rails, angles: FloatArray) -> Ends:
    """(p-1, k, 3) twice: directions at angles (p-1, k, 2), radians, at either strip."""
    found = (
        at_angles(rails.frames[:-1], angles[..., 0]),
        at_angles(rails.frames[1:], angles[..., 1]),
    )
    return where_apart(rails, found)


def safe_directions(rails: Rails) -> Ends:
    """The chord's direction brought into the tangent plane, kept from turning back."""
    return directions_of(rails, "safe-chord")


def safe_direction(c: FloatArray, frames: FloatArray) -> FloatArray:
    """(..., 3) normalise(max(c.V, 1/4) V + (c.tau) tau) for unit chords c (..., 3)."""
    local = np.einsum("...i,...ij->...j", c, frames[..., :2])
    local[..., 1] = np.maximum(local[..., 1], LEAST_ADVANCE)
    return unit(np.einsum("...ij,...j->...i", frames[..., :2], local))


def projected_direction(c: FloatArray, frames: FloatArray) -> FloatArray:
    """(..., 3) normalise(c - (c.N) N) for unit chords c (..., 3); V where c stands upright."""
    flat = np.einsum(
        "...ij,...j->...i", frames[..., :2], np.einsum("...i,...ij->...j", c, frames[..., :2])
    )
    upright = dot(flat, flat)[..., None] < LEAST_CHORD**2
    return np.where(upright, frames[..., 1], unit(flat))


def section_directions(rails: Rails) -> Ends:
    """(p-1, k, 3) twice: within the plane of the chord and the sum of both normals."""
    c = unit(rails.chords)
    first, second = rails.frames[:-1, :, :, 2], rails.frames[1:, :, :, 2]
    both = first + second
    start, end = (
        dot(both, n)[..., None] * c - dot(c, n)[..., None] * both for n in (first, second)
    )
    return unit(start), unit(end)


def at_angles(frames: FloatArray, angles: FloatArray) -> FloatArray:
    """(..., 3) cos(alpha) V + sin(alpha) tau for angles (...) in radians."""
    turned: FloatArray = (
        np.cos(angles)[..., None] * frames[..., 1] + np.sin(angles)[..., None] * frames[..., 0]
    )
    return turned


def angles_of(directions: FloatArray, frames: FloatArray) -> FloatArray:
    """(...) radians, the angles alpha = atan2(T.tau, T.V) of directions (..., 3)."""
    found: FloatArray = np.arctan2(dot(directions, frames[..., 0]), dot(directions, frames[..., 1]))
    return found
