"""The passes' curves as CSV."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from georibbon.export.files import require_ending, write_whole
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.ribbon import FloatArray

COLUMNS = ("pass", "s", "x", "y", "z", "nx", "ny", "nz", "sigma", "kind", "tx", "ty", "tz")


def position_sigma(fitted: FittedPass) -> FloatArray:
    """(n,) metres: the square root of the trace of each point's covariance."""
    sigma: FloatArray = np.sqrt(np.trace(fitted.covariance, axis1=1, axis2=2))
    return sigma


def write_curves(reconstruction: Reconstruction, path: Path) -> None:
    """Write every pass and tie, one row a point, to a .csv file.

    Columns: pass (its name), s (arc length), x y z (position), nx ny nz (unit
    normal out of the surface), sigma (square root of the trace of the
    position's covariance), kind ("pass" or "tie"), tx ty tz (unit tangent along
    the ribbon).  Lengths in metres, workpiece frame, UTF-8.  Names are kept
    exactly, quoted where CSV needs it.  Raises ExportError for another ending
    or a place that cannot be written.
    """
    require_ending(path, (".csv",), "curves")
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for fitted in reconstruction.passes:
        writer.writerows(_rows(fitted))
    write_whole(path, text.getvalue().encode("utf-8"))


def _rows(fitted: FittedPass) -> Iterator[tuple[str, ...]]:
    strip, sigma = fitted.strip, position_sigma(fitted)
    before = np.column_stack((strip.s, strip.points, strip.normals, sigma))
    for row, tangent in zip(before.tolist(), strip.tangents.tolist(), strict=True):
        yield (
            fitted.name,
            *(f"{value:.10g}" for value in row),
            fitted.kind,
            *(f"{value:.10g}" for value in tangent),
        )
