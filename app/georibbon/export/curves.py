"""The passes' curves as CSV."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.export.files import CURVES_ENDINGS, require_ending, write_whole
from georibbon.geometry.frames import Strip
from georibbon.reconstruction import Reconstruction
from georibbon.recording import PassKind

COLUMNS = ("pass", "s", "x", "y", "z", "nx", "ny", "nz", "sigma", "kind", "tx", "ty", "tz")


def write_curves(reconstruction: Reconstruction, path: Path) -> None:
    """Write every pass and tie of a result to a .csv file: see `write_strips`."""
    write_strips(
        [(one.name, one.kind, one.strip, one.position_sigma) for one in reconstruction.passes], path
    )


def write_strips(
    curves: Iterable[tuple[str, PassKind, Strip, FloatArray | None]], path: Path
) -> None:
    """Write curves, each a name, a kind, a strip and its sigma, one row a point, to a .csv file.

    Columns: pass (its name), s (arc length), x y z (position), nx ny nz (unit
    normal out of the surface), sigma (square root of the trace of the
    position's covariance; nothing where it is not known), kind ("pass" or
    "tie"), tx ty tz (unit tangent along the ribbon).  Lengths in metres,
    workpiece frame, UTF-8.  Names are kept exactly, quoted where CSV needs it.
    Raises ExportError for another ending or a place that cannot be written.
    """
    require_ending(path, CURVES_ENDINGS, "curves")
    text = ",".join(COLUMNS) + "\n" + "".join(_rows(*one) for one in curves)
    write_whole(path, text.encode("utf-8"))


def _rows(name: str, kind: PassKind, strip: Strip, sigma: FloatArray | None) -> str:
    numbers = [strip.s[:, None], strip.points, strip.normals, strip.tangents]
    if sigma is not None:
        numbers.insert(3, sigma[:, None])
    # A percent sign in a name must not be taken for a place to put a number.
    start, spread = _quoted(name).replace("%", "%%"), "%.10g" if sigma is not None else ""
    row = ",".join([start, *["%.10g"] * 7, spread, kind, *["%.10g"] * 3]) + "\n"
    return (row * len(strip.s)) % tuple(np.hstack(numbers).ravel().tolist())


def _quoted(name: str) -> str:
    """The name as a CSV field (RFC 4180): in quotes where it holds a sign of the format."""
    if any(sign in name for sign in ',"\r\n') or name != name.strip():
        return '"' + name.replace('"', '""') + '"'
    return name
