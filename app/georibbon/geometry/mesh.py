"""Triangle meshes: built from grids, oriented, thickened and checked."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh.

    vertices: (n, 3) float64, metres, none twice.  triangles: (m, 3) int64,
    counter-clockwise seen from outside.  normals: (n, 3) float64, unit,
    outward.  sigma: (n,) float64, metres, the standard deviation of each
    vertex's position (square root of the covariance's trace), or None.
    """

    vertices: FloatArray
    triangles: IntArray
    normals: FloatArray
    sigma: FloatArray | None = None
