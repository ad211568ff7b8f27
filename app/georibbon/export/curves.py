"""The passes' curves as CSV."""

from pathlib import Path

import numpy as np

from georibbon.export.files import CURVES_ENDINGS, require_ending, write_whole
from georibbon.reconstruction import FittedPass, Reconstruction

COLUMNS = ("pass", "s", "x", "y", "z", "nx", "ny", "nz", "sigma", "kind", "tx", "ty", "tz")


def write_curves(reconstruction: Reconstruction, path: Path) -> None:
    """Write every pass and tie, one row a point, to a .csv file.

    Columns: pass (its name), s (arc length), x y z (position), nx ny nz (unit
    normal out of the surface), sigma (square root of the trace of the
    position's covariance), kind ("pass" or "tie"), tx ty tz (unit tangent along
    the ribbon).  Lengths in metres, workpiece frame, UTF-8.  Names are kept
    exactly, quoted where CSV needs it.  Raises ExportError for another ending
    or a place that cannot be written.
    """
    require_ending(path, CURVES_ENDINGS, "curves")
    text = ",".join(COLUMNS) + "\n" + "".join(map(_rows, reconstruction.passes))
    write_whole(path, text.encode("utf-8"))


def _rows(fitted: FittedPass) -> str:
    strip, sigma = fitted.strip, fitted.position_sigma
    numbers = np.column_stack((strip.s, strip.points, strip.normals, sigma, strip.tangents))
    # A percent sign in a name must not be taken for a place to put a number.
    name = _quoted(fitted.name).replace("%", "%%")
    row = f"{name},{','.join(['%.10g'] * 8)},{fitted.kind},{','.join(['%.10g'] * 3)}\n"
    return (row * len(numbers)) % tuple(numbers.ravel().tolist())


def _quoted(name: str) -> str:
    """The name as a CSV field (RFC 4180): in quotes where it holds a sign of the format."""
    if any(sign in name for sign in ',"\r\n') or name != name.strip():
        return '"' + name.replace('"', '""') + '"'
    return name
