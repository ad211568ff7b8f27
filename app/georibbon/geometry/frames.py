"""Curves on a surface with their frames.

A strip is one pass as a curve: its points by arc length and, at each, the
right-handed frame R = [tau, V, N]: tangent along the ribbon, conormal across
it, surface normal; V = N x tau (GEOMETRY 1).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Strip:
    """A pass's curve with its frames.

    s: (n,) float64, metres, ascending.  points: (n, 3) float64, metres.
    frames: (n, 3, 3) float64, columns tau, V, N, orthonormal, right-handed.
    """

    s: FloatArray
    points: FloatArray
    frames: FloatArray

    @property
    def tangents(self) -> FloatArray:
        """(n, 3) unit tangents, along the ribbon."""
        return self.frames[:, :, 0]

    @property
    def conormals(self) -> FloatArray:
        """(n, 3) unit conormals V = N x tau, across the ribbon."""
        return self.frames[:, :, 1]

    @property
    def normals(self) -> FloatArray:
        """(n, 3) unit normals, out of the surface."""
        return self.frames[:, :, 2]

    def reversed(self) -> "Strip":
        """The same curve run backwards: s -> L - s, tau -> -tau, V -> -V, N kept."""
        frames = self.frames[::-1] * np.array([-1.0, -1.0, 1.0])
        return Strip(self.s[-1] - self.s[::-1], self.points[::-1], frames)
