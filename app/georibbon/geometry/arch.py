"""A curved panel like the source paper's test surface, and the passes laid over it.

Sprynski, Szafran, Lacolle and Biard (2008) show a rational bicubic surface with
five geodesics and give no data.  This one is of the same kind and size: an
arch of two radians, about 0.9 m long and 0.55 m wide, from a net of 8 by 7
points with unequal weights.  The radius falls off towards both sides, so that
it is curved both ways, and is uneven, so that no two passes are alike; the
passes have no inflections (their normal curvature is -3.2 to -1.3 1/m).  The
constants were chosen so that the gaps between five passes are 23 to 99 mm,
69 mm in the mean.
"""

import numpy as np

from georibbon.geometry.cubic_basis import clamped_knots
from georibbon.geometry.frames import Strip
from georibbon.geometry.geodesics import directions_at, geodesics
from georibbon.geometry.nurbs import NurbsSurface

LENGTH = 0.72  # m, of a pass
OUTERMOST = (0.135, 0.865)  # v of the first and the last pass, halfway along the arch


def arch() -> NurbsSurface:
    """The surface: u along the arch, v across it, both from 0 to 1; the normals point up."""
    along, across = np.linspace(-1.0, 1.0, 8)[:, None], np.linspace(-1.0, 1.0, 7)[None, :]
    uneven = 0.023 * np.sin(2.0 * along + 1.5 * across + 1.45)
    uneven = uneven + 0.005 * np.sin(2.0 * along + 5.0 * across)
    radius = 0.455 - 0.125 * across**2 + uneven
    y = np.broadcast_to(0.272 * across, radius.shape)
    net = np.stack([radius * np.sin(along), y, radius * np.cos(along)], axis=2)
    weights = 1.0 + 0.21 * np.cos(3.0 * along + 1.0) * np.cos(2.0 * across - 0.5)
    return NurbsSurface(net, weights, clamped_knots(8), clamped_knots(7))


def arch_strips(count: int = 5, samples: int = 121) -> tuple[Strip, ...]:
    """So many geodesics over the arch, 0.72 m long, evenly placed across its middle."""
    surface = arch()
    uv = np.stack([np.full(count, 0.5), np.linspace(*OUTERMOST, count)], axis=1)
    s = np.linspace(-LENGTH / 2, LENGTH / 2, samples)
    return geodesics(surface, uv, directions_at(surface, uv, np.zeros(count)), s)
