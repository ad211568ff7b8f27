"""Geodesic Hermite patches between neighbouring passes.

At every common parameter u the patch between the curves f0 and f1 is the
Hermite cubic that leaves f0 along T0 and arrives at f1 along T1, both square
to the measured normals, so that the surface has the passes' normals and the
passes are geodesics of it (Sprynski, Szafran, Lacolle and Biard, Surface
reconstruction via geodesic interpolation, Computer-Aided Design 40, 2008):

    F(u, v) = H0(v) f0 + H1(v) lambda0 d T0 + H2(v) lambda1 d T1 + H3(v) f1
    H0 = 2v³ - 3v² + 1,  H1 = v³ - 2v² + v,  H2 = v³ - v²,  H3 = 1 - H0

with d = |f1 - f0|.  All functions work on all patches and parameters at once.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from georibbon.arrays import FloatArray
from georibbon.geometry.correspondence import Arrangement, Correspondence, correspond
from georibbon.geometry.frames import Strip, frames_from, unit

# F = POWERS(v) @ HERMITE @ control: the basis H0, H1, H2, H3 in powers of v.
HERMITE = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-3.0, -2.0, -1.0, 3.0], [2.0, 1.0, 1.0, -2.0]]
)
LEAST_ADVANCE = 0.25
PINCHED = 1e-3
STEP = 1e-5


@dataclass(frozen=True, eq=False)
class Rails:
    """All strips at common parameters.

    points: (p, k, 3) metres.  frames: (p, k, 3, 3), columns tau, V, N.
    """

    points: FloatArray
    frames: FloatArray

    @cached_property
    def chords(self) -> FloatArray:
        """(p-1, k, 3) metres, from each strip to the next."""
        return np.diff(self.points, axis=0)

    @cached_property
    def gaps(self) -> FloatArray:
        """(p-1, k) metres between matched points of neighbours."""
        length: FloatArray = np.sqrt(np.sum(self.chords**2, axis=-1))
        return length


def interpolant(strip: Strip) -> BSpline:
    """A spline through a strip's points and normals: s -> (..., 6); quintic, cubic under 6 points.

    A strip needs 4 points.
    """
    degree = 5 if len(strip.s) > 5 else 3
    return make_interp_spline(
        strip.s, np.concatenate([strip.points, strip.normals], axis=1), k=degree
    )


def sampled(spline: BSpline, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (k, 3) and frames (k, 3, 3) of an interpolated strip at s (k,).

    The tangent is the curve's own, the normal made square to it.
    """
    values = spline(s)
    tangents = unit(spline(s, nu=1)[:, :3])
    return values[:, :3], frames_from(tangents, values[:, 3:])


def safe_directions(rails: Rails) -> tuple[FloatArray, FloatArray]:
    """(p-1, k, 3) twice: unit directions in which patches leave their first and reach their
    second strip.

    The chord's direction c brought into the tangent plane, kept from turning back:
    T = normalise(max(c.V, 1/4) V + (c.tau) tau).  Where the strips lie within a
    millimetre of each other it is V.
    """
    pinched = (rails.gaps < PINCHED)[..., None]
    c = unit(rails.chords)
    return (
        np.where(pinched, rails.frames[:-1, :, :, 1], safe_direction(c, rails.frames[:-1])),
        np.where(pinched, rails.frames[1:, :, :, 1], safe_direction(c, rails.frames[1:])),
    )


def safe_direction(c: FloatArray, frames: FloatArray) -> FloatArray:
    """(..., 3) normalise(max(c.V, 1/4) V + (c.tau) tau) for unit chords c (..., 3)."""
    local = np.einsum("...i,...ij->...j", c, frames[..., :2])
    local[..., 1] = np.maximum(local[..., 1], LEAST_ADVANCE)
    return unit(np.einsum("...ij,...j->...i", frames[..., :2], local))


def arc_lengths(directions: FloatArray, rails: Rails) -> FloatArray:
    """(p-1, k) the factors lambda = 2 / (1 + T.c), which reproduce a circular arc.

    directions: (p-1, k, 3) unit.  T.c is taken between 0 and 1; where the
    strips lie within a millimetre of each other lambda is 1.
    """
    cosine = np.clip(np.sum(directions * unit(rails.chords), axis=-1), 0.0, 1.0)
    factors: FloatArray = 2.0 / (1.0 + np.where(rails.gaps < PINCHED, 1.0, cosine))
    return factors


def hermite_control(
    rails: Rails,
    directions: tuple[FloatArray, FloatArray],
    lambdas: tuple[FloatArray, FloatArray],
) -> FloatArray:
    """(p-1, k, 4, 3) metres: f0, lambda0 d T0, lambda1 d T1, f1 of all patches.

    directions: (p-1, k, 3) unit, at either strip; lambdas: (p-1, k) at either strip.
    """
    start, end = (
        (factor * rails.gaps)[..., None] * direction
        for factor, direction in zip(lambdas, directions, strict=True)
    )
    return np.stack([rails.points[:-1], start, end, rails.points[1:]], axis=2)


def control_of(rails: Rails) -> FloatArray:
    """(p-1, k, 4, 3) metres: the patches' control with safe directions and arc lengths."""
    start, end = safe_directions(rails)
    return hermite_control(
        rails, (start, end), (arc_lengths(start, rails), arc_lengths(end, rails))
    )


def basis(v: FloatArray, order: int = 0) -> FloatArray:
    """(m, 4) the Hermite functions H0 to H3 at v (m,), or their derivatives of that order."""
    powers = np.zeros((len(v), 4))
    for k in range(order, 4):
        falling = np.prod(np.arange(k, k - order, -1))
        powers[:, k] = falling * v ** (k - order)
    functions: FloatArray = powers @ HERMITE
    return functions


@dataclass(frozen=True, eq=False)
class Patches:
    """All patches at common parameters, with their derivatives along the passes.

    rails: the strips at the k parameters.  control: (p-1, k, 4, 3) metres;
    slope, bend: its first and second derivatives by u.
    """

    rails: Rails
    control: FloatArray
    slope: FloatArray
    bend: FloatArray

    @cached_property
    def mean_gaps(self) -> FloatArray:
        """(p-1,) metres, mean distance of neighbours."""
        means: FloatArray = np.mean(self.rails.gaps, axis=1)
        return means


@dataclass(frozen=True, eq=False)
class PatchSet:
    """What all patches are made from: the passes in order across, matched and interpolated."""

    arrangement: Arrangement
    match: Correspondence
    splines: tuple[BSpline, ...]


def patches_between(arrangement: Arrangement) -> PatchSet:
    """Match and interpolate passes that are in order across."""
    strips = arrangement.strips
    return PatchSet(arrangement, correspond(strips), tuple(interpolant(s) for s in strips))


def rails_at(model: PatchSet, u: FloatArray) -> Rails:
    """All passes at the common parameters u (k,)."""
    places = model.match(u)
    pairs = [sampled(spline, s) for spline, s in zip(model.splines, places, strict=True)]
    return Rails(np.stack([points for points, _ in pairs]), np.stack([f for _, f in pairs]))


def patches_at(model: PatchSet, u: FloatArray) -> Patches:
    """The patches at parameters u (k,), metres along the middle pass.

    Derivatives are those of the parabola through three places a hundredth of a
    millimetre apart around u, or beside it at the ends.
    """
    first, last = model.match.ends[model.match.middle]
    centre = np.clip(u, first + STEP, last - STEP)
    places = np.concatenate([u, centre - STEP, centre, centre + STEP])
    rails = rails_at(model, places)
    control, before, middle, after = np.split(control_of(rails), 4, axis=1)
    bend = (before - 2.0 * middle + after) / STEP**2
    slope = (after - before) / (2.0 * STEP) + (u - centre)[:, None, None] * bend
    here = Rails(rails.points[:, : len(u)], rails.frames[:, : len(u)])
    return Patches(here, control, slope, bend)


@dataclass(frozen=True, eq=False)
class PatchGrid:
    """Points of patches on a grid of parameters, with their derivatives.

    points, along, across: (..., k, m, 3) F, its derivatives by u and by v.
    reference: (..., k, m, 3) unit, the strips' normals blended linearly.
    """

    points: FloatArray
    along: FloatArray
    across: FloatArray
    reference: FloatArray

    @cached_property
    def turn(self) -> FloatArray:
        """(..., k, m) J = (F_u x F_v) . N / (|F_u| |F_v|): 1 upright and square, <= 0 folded.

        1 where the strips lie within a millimetre of each other.
        """
        along, across = np.sum(self.along**2, axis=-1), np.sum(self.across**2, axis=-1)
        pinched = (along == 0.0) | (across < PINCHED**2)
        upright = np.sum(np.cross(self.along, self.across) * self.reference, axis=-1)
        ratio = upright / np.sqrt(np.where(pinched, 1.0, along * across))
        return np.where(pinched, 1.0, ratio)

    @property
    def normals(self) -> FloatArray:
        """(..., k, m, 3) unit normals; where the patch is folded, the strips' normals blended."""
        square = np.cross(self.along, self.across)
        good = (np.sum(square * self.reference, axis=-1) > 0.0)[..., None]
        return unit(np.where(good, square, self.reference))


def patch_grid(
    control: FloatArray, slope: FloatArray, ends: tuple[FloatArray, FloatArray], v: FloatArray
) -> PatchGrid:
    """Patches on a grid.

    control, slope: (..., k, 4, 3), the control and its derivative by u; ends:
    normals (..., k, 3) of the first and second strip; v: (m,) between 0 and 1.
    """
    functions = basis(v)
    share = v[:, None]
    reference = unit((1.0 - share) * ends[0][..., None, :] + share * ends[1][..., None, :])
    return PatchGrid(functions @ control, functions @ slope, basis(v, 1) @ control, reference)
