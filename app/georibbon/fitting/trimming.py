"""What is left of a pass without its ends."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import Strip, frames_from, interpolated, unit

SAME_PLACE = 1e-6  # m: an end this near to a node is that node


@dataclass(frozen=True, eq=False)
class Curve:
    """A pass's curve with how well it is known.

    strip: n points.  covariance: (n, 3, 3) m², of the points.  normal_sigma:
    (n,) radians.
    """

    strip: Strip
    covariance: FloatArray
    normal_sigma: FloatArray


def trimmed(curve: Curve, trim: tuple[float, float]) -> Curve:
    """The curve without so many metres of its start and of its end.

    Places stay what they are: the first is at trim[0], not at 0.  The new ends
    lie on the cubics through the points along their tangents; covariances are
    taken linearly between nodes.  Without a trim it is the same object.
    """
    if trim == (0.0, 0.0):
        return curve
    strip = curve.strip
    places = strip.s
    first, last = places[0] + trim[0], places[-1] - trim[1]
    inside = places[(places > first + SAME_PLACE) & (places < last - SAME_PLACE)]
    s = np.concatenate([[first], inside, [last]])
    points = CubicHermiteSpline(places, strip.points, strip.tangents)(s)
    tangents = unit(interpolated(s, places, strip.tangents))
    frames = frames_from(tangents, interpolated(s, places, strip.normals))
    flat = interpolated(s, places, curve.covariance.reshape(-1, 9))
    sigma = np.interp(s, places, curve.normal_sigma)
    return Curve(Strip(s, points, frames), flat.reshape(-1, 3, 3), sigma)
