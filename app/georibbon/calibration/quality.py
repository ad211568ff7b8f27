"""How well the poses determine a calibration: predicted, from the normal matrices."""

from dataclasses import dataclass

import numpy as np

from georibbon.calibration.separable import Normals
from georibbon.ribbon import FloatArray


@dataclass(frozen=True, eq=False)
class Determined:
    """theta: (n, 4) standard deviation of a row of each sensor's [K | c], worst of its axes.

    unknowns: (m,) of the poses' unknowns.  Both for readings of unit weight.
    """

    theta: FloatArray
    unknowns: FloatArray


def determined(normals: Normals, axes: FloatArray, free: int = 0) -> Determined:
    """Standard deviations from the normal matrices, for readings of standard deviation 1.

    free: how many directions of the poses' unknowns are left undetermined by
    the readings and are held (3 for the accelerometers' common rotation): the
    covariance is then the pseudo-inverse without them.  A sensor row's
    covariance is N^-1 + N^-1 C S^-1 C^T N^-1.
    """
    values, vectors = np.linalg.eigh(normals.reduced)
    kept = np.maximum(values[free:], values[-1] * 1e-15)
    root = vectors[:, free:] / np.sqrt(kept)
    inverse = np.linalg.inv(normals.sensors)
    carried = np.einsum("nab,nbkm->nkam", inverse, normals.coupling) @ root
    variance = np.diagonal(inverse, axis1=1, axis2=2)[:, None] + (carried**2).sum(axis=3)
    present = np.arange(3) < axes[:, None]
    worst = np.where(present[:, :, None], variance, 0.0).max(axis=1)
    return Determined(np.sqrt(worst), np.sqrt((root**2).sum(axis=1)))


def coverage(directions: FloatArray) -> float:
    """Three times the smallest eigenvalue of unit directions' covariance (1: evenly spread)."""
    centred = directions - directions.mean(axis=0)
    return float(3.0 * np.linalg.eigvalsh(centred.T @ centred / len(directions))[0])
