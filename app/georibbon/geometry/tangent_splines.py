"""The ways to interpolate the tangents of a curve, by name.

unrolled: a cubic spline in the plane onto which the sphere is rolled along the
directions.  averages: weighted spherical averages.  components: a cubic spline
of each component, made unit: the plainest, and the fastest.  All three are of
fourth order in the pitch and turn with the directions.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import unit
from georibbon.geometry.settings import TangentRule
from georibbon.geometry.spherical import (
    MakeSpline,
    SphericalSpline,
    check_directions,
    held_near,
)
from georibbon.geometry.spherical_averages import AverageSpline


@dataclass(frozen=True, eq=False)
class ComponentSpline:
    """A curve on the unit sphere through given directions: a spline of each component, made unit.

    s: (n,) float64, n >= 2, strictly ascending.  tangents: (n, 3) float64, unit.
    Called with (k,) parameters it gives (k, 3) unit vectors; beyond the ends it
    is continued by at most half a pitch.  Raises FitError as `SphericalSpline`.
    """

    s: FloatArray
    tangents: FloatArray

    def __post_init__(self) -> None:
        check_directions(self.s, self.tangents)

    def __call__(self, s: FloatArray) -> FloatArray:
        """(k, 3) unit directions at the parameters s (k,)."""
        return unit(self._spline(held_near(self.s, s)))

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.s, self.tangents)


SPLINES: Mapping[TangentRule, MakeSpline] = {
    "unrolled": SphericalSpline,
    "averages": AverageSpline,
    "components": ComponentSpline,
}
"""The splines by name, the default first."""
