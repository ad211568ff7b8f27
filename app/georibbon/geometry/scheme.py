"""How the lines across are laid: the settings made ready for the passes at hand."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.directions import Ends, angled_directions, directions_of
from georibbon.geometry.fairness import CRITERIA, fairest_lengths, lines_between
from georibbon.geometry.frames import dot, unit
from georibbon.geometry.interior import quintic_control, smooth_directions
from georibbon.geometry.rails import Rails
from georibbon.geometry.settings import Direction, Interior, SurfaceSettings
from georibbon.geometry.torsion import least_torsion_angles


@dataclass(frozen=True, eq=False)
class Found:
    """What a criterion's minimisation found, for all patches.

    logs: spline of the logarithms of the tangent lengths, u -> (k, p-1, 2);
    None where they are those of an arc.  unsettled: (p-1,) the share of lines
    at which Newton's method did not come to rest.  bounded: (p-1,) the share at
    which it ran into its bounds.
    """

    logs: CubicSpline | None
    unsettled: FloatArray
    bounded: FloatArray


@dataclass(frozen=True, eq=False)
class Scheme:
    """How control is made of rails.

    angles: (p-1 or 1, 2, 2) radians, at either pass, at the first and last
    parameter of `span`, in the place of the direction.  factors: constant
    lengths.  found: what a criterion found.
    """

    direction: Direction = "safe-chord"
    interior: Interior = "g1"
    angles: FloatArray | None = None
    span: tuple[float, float] = (0.0, 1.0)
    factors: tuple[float, float] | None = None
    found: Found | None = None

    def of_patch(self, i: int) -> "Scheme":
        """The scheme of the i-th patch alone."""
        angles, found, one = self.angles, self.found, slice(i, i + 1)
        if angles is not None and len(angles) > 1:
            angles = angles[one]
        if found is not None:
            logs = found.logs
            if logs is not None:
                logs = CubicSpline.construct_fast(logs.c[:, :, one], logs.x)
            found = Found(logs, found.unsettled[one], found.bounded[one])
        return replace(self, angles=angles, found=found)


def scheme_for(settings: SurfaceSettings, rails_at_u: Callable[[], Rails], u: FloatArray) -> Scheme:
    """The scheme that settings ask for; what depends on the passes is found on their rails at u."""
    span = (float(u[0]), float(u[-1]))
    lengths = settings.lengths
    if not settings.uses_lengths:
        return Scheme(interior=settings.interior)
    if lengths == "criterion4" and settings.interior == "g1":
        angles, unsettled, bounded = least_torsion_angles(rails_at_u(), (u - u[0]) / (u[-1] - u[0]))
        return Scheme(angles=angles, span=span, found=Found(None, unsettled, bounded))
    scheme = Scheme(settings.direction, settings.interior, span=span)
    if settings.direction == "angles" and settings.uses_direction:
        scheme = replace(scheme, angles=np.radians(np.reshape(settings.angles, (1, 2, 2))))
    if lengths == "unit":
        lengths = (1.0, 1.0)
    if not isinstance(lengths, str):
        return replace(scheme, factors=lengths)
    if lengths not in CRITERIA:
        return scheme
    rails = rails_at_u()
    return replace(scheme, found=fairest(lengths, rails, directions_at(rails, scheme, u), u))


def fairest(name: str, rails: Rails, directions: Ends, u: FloatArray) -> Found:
    """The lengths that minimise the named criterion on every line, as a spline of u (k,)."""
    arcs = np.stack([arc_lengths(one, rails) for one in directions], axis=-1)
    start, end = (one.reshape(-1, 3) for one in directions)
    chords = unit(rails.chords).reshape(-1, 3)
    best = fairest_lengths(name, lines_between(chords, start, end), arcs.reshape(-1, 2))
    pinched = rails.pinched
    logs = np.where(pinched[..., None], 0.0, np.log(best.factors).reshape(arcs.shape))
    unsettled, bounded = (
        np.mean(flags.reshape(pinched.shape) & ~pinched, axis=1)
        for flags in (~best.settled, best.bounded)
    )
    return Found(CubicSpline(u, np.swapaxes(logs, 0, 1)), unsettled, bounded)


def directions_at(rails: Rails, scheme: Scheme, u: FloatArray | None = None) -> Ends:
    """(p-1, k, 3) twice: in which directions lines leave and arrive.

    u: (k,), only needed where the scheme has angles.
    """
    if scheme.interior == "c1-lines":
        across = smooth_directions(rails)
        return across[:-1], across[1:]
    if scheme.angles is None or u is None:
        return directions_of(rails, scheme.direction)
    first, last = scheme.span
    share = ((u - first) / (last - first))[:, None]
    begin, end = scheme.angles[:, None, :, 0], scheme.angles[:, None, :, 1]
    angles = np.broadcast_to((1.0 - share) * begin + share * end, (*rails.gaps.shape, 2))
    return angled_directions(rails, angles)


def lengths_at(rails: Rails, directions: Ends, scheme: Scheme, u: FloatArray | None) -> Ends:
    """(p-1, k) twice: the factors of the chord's length that lines leave and arrive with."""
    if scheme.factors is not None:
        ones = np.ones_like(rails.gaps)
        return scheme.factors[0] * ones, scheme.factors[1] * ones
    if scheme.found is not None and scheme.found.logs is not None and u is not None:
        factors = np.exp(np.moveaxis(scheme.found.logs(u), 1, 0))
        return factors[..., 0], factors[..., 1]
    return arc_lengths(directions[0], rails), arc_lengths(directions[1], rails)


def arc_lengths(directions: FloatArray, rails: Rails) -> FloatArray:
    """(p-1, k) the factors lambda = 2 / (1 + T.c), which reproduce a circular arc.

    directions: (p-1, k, 3) unit.  T.c is taken between 0 and 1; where the
    strips lie within a millimetre of each other lambda is 1.
    """
    cosine = np.clip(dot(directions, unit(rails.chords)), 0.0, 1.0)
    factors: FloatArray = 2.0 / (1.0 + np.where(rails.pinched, 1.0, cosine))
    return factors


def hermite_control(rails: Rails, directions: Ends, lambdas: Ends) -> FloatArray:
    """(p-1, k, 4, 3) metres: f0, lambda0 d T0, lambda1 d T1, f1 of all patches.

    directions: (p-1, k, 3) unit, at either strip; lambdas: (p-1, k) at either strip.
    """
    start, end = (
        (factor * rails.gaps)[..., None] * direction
        for factor, direction in zip(lambdas, directions, strict=True)
    )
    return np.stack([rails.points[:-1], start, end, rails.points[1:]], axis=2)


DEFAULT = Scheme()


def control_of(rails: Rails, scheme: Scheme = DEFAULT, u: FloatArray | None = None) -> FloatArray:
    """(p-1, k, c, 3) metres: the patches' control, c = 4 for cubic, 6 for quintic lines.

    u: (k,), needed where the scheme was fitted to the passes.
    """
    if scheme.interior == "g2":
        return quintic_control(rails)
    directions = directions_at(rails, scheme, u)
    return hermite_control(rails, directions, lengths_at(rails, directions, scheme, u))
