"""Geodesic Hermite patches between neighbouring passes.

At every common parameter u the patch between the curves f0 and f1 is the
Hermite cubic that leaves f0 along T0 and arrives at f1 along T1, both square
to the measured normals, so that the surface has the passes' normals and the
passes are geodesics of it (Sprynski, Szafran, Lacolle and Biard, Surface
reconstruction via geodesic interpolation, Computer-Aided Design 40, 2008):

    F(u, v) = H0(v) f0 + H1(v) lambda0 d T0 + H2(v) lambda1 d T1 + H3(v) f1
    H0 = 2v³ - 3v² + 1,  H1 = v³ - 2v² + v,  H2 = v³ - v²,  H3 = 1 - H0

with d = |f1 - f0|; where the surface shall have the same curvature on both sides
of a pass, the lines across are quintic.  All functions work on all patches and parameters at once.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from georibbon.arrays import BoolArray, FloatArray
from georibbon.geometry.correspondence import Arrangement, Correspondence, correspond
from georibbon.geometry.frames import cross, dot, unit
from georibbon.geometry.interior import QUINTIC
from georibbon.geometry.lifts import Cells
from georibbon.geometry.rails import PINCHED, Rails, interpolant, sampled_all, sampled_moving
from georibbon.geometry.scheme import DEFAULT, Scheme, scheme_for
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.slopes import STEP, control_with_slope

# F = POWERS(v) @ HERMITE @ control: the basis H0, H1, H2, H3 in powers of v.
HERMITE = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-3.0, -2.0, -1.0, 3.0], [2.0, 1.0, 1.0, -2.0]]
)
# The same for F, F_v, F_vv at v = 0, then F_vv, F_v, F at v = 1.
QUINTIC_HERMITE = QUINTIC[:, [0, 1, 2, 5, 4, 3]]
BASES = {4: HERMITE, 6: QUINTIC_HERMITE}


def basis(v: FloatArray, order: int = 0, count: int = 4) -> FloatArray:
    """(m, c) the Hermite functions at v (m,), or their derivatives of that order.

    count: how many rows c the control has, 4 (H0 to H3) or 6 (quintic).
    """
    powers = np.zeros((len(v), count))
    for k in range(order, count):
        falling = np.prod(np.arange(k, k - order, -1))
        powers[:, k] = falling * v ** (k - order)
    functions: FloatArray = powers @ BASES[count]
    return functions


@dataclass(frozen=True, eq=False)
class Lines:
    """The lines across of all patches at common parameters.

    rails: the strips at the k parameters.  control: (p-1, k, c, 3) metres,
    c = 4 or 6; slope: its derivative by u.
    u: (k,) and cells: what ties add to the patches there (see `lifted`), where they do.
    """

    rails: Rails
    control: FloatArray
    slope: FloatArray
    u: FloatArray | None = None
    cells: Cells | None = None


@dataclass(frozen=True, eq=False)
class Patches(Lines):
    """All patches at common parameters; bend: (p-1, k, c, 3), the second derivative by u."""

    bend: FloatArray = field(kw_only=True)

    @cached_property
    def mean_gaps(self) -> FloatArray:
        """(p-1,) metres, mean distance of neighbours."""
        means: FloatArray = np.mean(self.rails.gaps, axis=1)
        return means


@dataclass(frozen=True, eq=False)
class PatchSet:
    """What all patches are made from: the passes in order across, matched and interpolated.

    cells: what ties add to them, where they close cells.
    """

    arrangement: Arrangement
    match: Correspondence
    splines: tuple[BSpline, ...]
    scheme: Scheme = DEFAULT
    cells: Cells | None = None


def patches_between(arrangement: Arrangement, settings: SurfaceSettings | None = None) -> PatchSet:
    """Match and interpolate passes that are in order across, and lay the lines between them."""
    chosen = settings or SurfaceSettings()
    strips = arrangement.strips
    match = correspond(strips, chosen.correspondence)
    model = PatchSet(arrangement, match, tuple(map(interpolant, strips)))
    u = natural_parameters(model)
    return replace(model, scheme=scheme_for(chosen, lambda: rails_at(model, u), u))


def natural_parameters(model: PatchSet) -> FloatArray:
    """(n,) parameters at equal distances, as many as the middle pass has points."""
    middle = model.match.middle
    first, last = model.match.ends[middle]
    return np.linspace(first, last, len(model.arrangement.strips[middle].s))


def rails_at(model: PatchSet, u: FloatArray) -> Rails:
    """All passes at the common parameters u (k,)."""
    return sampled_all(model.splines, model.match(u))


def lines_at(model: PatchSet, u: FloatArray) -> Lines:
    """The lines across at parameters u (k,), metres along the middle pass."""
    rails, rates = sampled_moving(model.splines, *model.match.with_rates(u))
    cells = model.cells
    steer = cells.steered if cells is not None and any(cells.lifts) else None
    control, slope = control_with_slope(rails, rates, model.scheme, u, steer)
    return Lines(rails, control, slope, u, model.cells)


def patches_at(model: PatchSet, u: FloatArray) -> Patches:
    """The patches at parameters u (k,), metres along the middle pass.

    The second derivative is that of the first a hundredth of a millimetre
    before and behind u, or beside it at the ends.
    """
    first, last = model.match.ends[model.match.middle]
    centre, count = np.clip(u, first + STEP, last - STEP), len(u)
    lines = lines_at(model, np.concatenate([u, centre - STEP, centre + STEP]))
    slope, before, after = np.split(lines.slope, [count, 2 * count], axis=1)
    here = Rails(lines.rails.points[:, :count], lines.rails.frames[:, :count])
    bend = (after - before) / (2.0 * STEP)
    return Patches(here, lines.control[:, :count], slope, u, model.cells, bend=bend)


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
    def pinched(self) -> BoolArray:
        """(..., k, m) where the patch has no width, as its strips lie on each other."""
        along, across = dot(self.along, self.along), dot(self.across, self.across)
        narrow: BoolArray = (along == 0.0) | (across < PINCHED**2)
        return narrow

    @cached_property
    def turn(self) -> FloatArray:
        """(..., k, m) J = (F_u x F_v) . N / (|F_u| |F_v|): 1 upright and square, <= 0 folded.

        1 where the strips lie within a millimetre of each other.
        """
        along, across = dot(self.along, self.along), dot(self.across, self.across)
        upright = dot(cross(self.along, self.across), self.reference)
        ratio = upright / np.sqrt(np.where(self.pinched, 1.0, along * across))
        return np.where(self.pinched, 1.0, ratio)

    @property
    def normals(self) -> FloatArray:
        """(..., k, m, 3) unit normals; where it is folded or pinched, the strips' blended."""
        square = cross(self.along, self.across)
        good = (dot(square, self.reference) > 0.0) & ~self.pinched
        return unit(np.where(good[..., None], square, self.reference))


def patch_grid(
    control: FloatArray, slope: FloatArray, ends: tuple[FloatArray, FloatArray], v: FloatArray
) -> PatchGrid:
    """Patches on a grid.

    control, slope: (..., k, c, 3), the control and its derivative by u; ends:
    normals (..., k, 3) of the first and second strip; v: (m,) between 0 and 1.
    """
    count = control.shape[-2]
    functions = basis(v, 0, count)
    share = v[:, None]
    reference = unit((1.0 - share) * ends[0][..., None, :] + share * ends[1][..., None, :])
    across = basis(v, 1, count) @ control
    return PatchGrid(functions @ control, functions @ slope, across, reference)


def lifted(grid: PatchGrid, patches: Patches, i: int, v: FloatArray) -> PatchGrid:
    """The i-th patch's grid at v (m,) with what ties add to it; the same where they add nothing."""
    lift = None if patches.cells is None else patches.cells.lifts[i]
    if lift is None or patches.u is None:
        return grid
    more = lift.at(patches.u, v)
    return PatchGrid(
        grid.points + more.points,
        grid.along + more.along,
        grid.across + more.across,
        grid.reference,
    )
