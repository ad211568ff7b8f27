"""What the surface's colours stand for: the modes, their values, units and ranges."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.curvature import (
    Curvature,
    grid_curvature,
    grid_differences,
    mesh_curvature,
)
from georibbon.geometry.frames import curvatures
from georibbon.geometry.surface import Surface
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.scene.colours import round_range, round_step

Mode = Literal["uncertainty", "gaussian", "mean", "normal", "deviation", "zebra", "plain"]
MODES: tuple[Mode, ...] = (
    "uncertainty", "gaussian", "mean", "normal", "deviation", "zebra", "plain",
)  # fmt: skip
PARTS = ("surface", "passes", "ties", "sensors", "frames", "marks", "labels", "floor")
SHOWN_FIRST = frozenset(PARTS) - {"sensors", "frames"}
LENGTHS = ("uncertainty", "deviation")  # modes whose values are lengths
SIGNED = ("gaussian", "mean", "normal", "deviation")
_TITLES: Mapping[Mode, str] = {
    "uncertainty": "Position\nuncertainty\n1σ, {unit}\n",
    "gaussian": "Gaussian\ncurvature\n1/m²\n",
    "mean": "Mean\ncurvature\n1/m\n",
    "normal": "Curvature\nalong passes\n1/m\n",
    "deviation": "Deviation\n{words}{unit}\n",
}
_OUTLIERS = 1.0  # per cent of signed values at either end that do not widen the range


@dataclass(frozen=True, eq=False)
class Look:
    """What a person chose of a scene.

    colouring: one of MODES.  ranges: by the mode, (low, high) in its SI unit (m,
    1/m, 1/m²) where it is fixed; from the data where not.  deviation: (n,) m of
    the mesh's vertices, signed, NaN where there is nothing to compare with;
    deviation_words: from what.  shown: of PARTS.  symbol, metres: the unit of
    length in words, and its size.  translate: what puts the scene's English words
    into the reader's language.
    """

    colouring: Mode = "uncertainty"
    ranges: Mapping[Mode, tuple[float, float]] = field(default_factory=lambda: MappingProxyType({}))
    deviation: FloatArray | None = None
    deviation_words: str = ""
    shown: frozenset[str] = SHOWN_FIRST
    symbol: str = "mm"
    metres: float = 1e-3
    translate: Callable[[str], str] = str

    @property
    def unit(self) -> float:
        """The size of the unit that the mode's values are shown in."""
        return self.metres if self.colouring in LENGTHS else 1.0

    @property
    def title(self) -> str:
        """The scale's title, with the unit."""
        words = f"{self.deviation_words}\n" if self.deviation_words else ""
        title = self.translate(_TITLES[self.colouring])
        return title.format(unit=self.symbol, words=words)


def surface_values(surface: Surface, look: Look) -> FloatArray | None:
    """(n,) what the vertices' colours stand for, in SI units; None where there is nothing."""
    mesh, mode = surface.mesh, look.colouring
    if mode == "uncertainty":
        return mesh.sigma
    if mode == "deviation":
        fits = look.deviation is not None and len(look.deviation) == len(mesh.vertices)
        return look.deviation if fits else None
    if mode in ("gaussian", "mean"):
        bend = surface_curvature(surface)
        return bend.gaussian if mode == "gaussian" else bend.mean
    if mode == "normal" and is_grid(surface):
        return surface_curvature(surface).along(along_passes(surface))
    return None


def surface_curvature(surface: Surface) -> Curvature:
    """The surface's curvature at its mesh's vertices."""
    mesh = surface.mesh
    return grid_curvature(mesh, surface.shape) if is_grid(surface) else mesh_curvature(mesh)


def along_passes(surface: Surface) -> FloatArray:
    """(n, 3) the direction of the passes at the vertices of a surface that is a grid, in metres."""
    grid = surface.mesh.vertices.reshape(*surface.shape, 3)
    return grid_differences(grid)[0].reshape(-1, 3)


def is_grid(surface: Surface) -> bool:
    """Whether the mesh's vertices are a grid of the surface's shape."""
    rows, columns = surface.shape
    return rows > 1 and columns > 1 and rows * columns == len(surface.mesh.vertices)


def pass_values(fitted: FittedPass, mode: Mode) -> FloatArray | None:
    """(n,) what a pass's colours stand for where there is no surface, in SI units."""
    if mode == "uncertainty":
        return fitted.position_sigma
    return curvatures(fitted.strip)[0] if mode == "normal" else None


def scene_values(result: Reconstruction, look: Look) -> FloatArray | None:
    """(n,) all that is coloured, in SI units: of the surface, or of the passes without one."""
    if result.surface is not None:
        return surface_values(result.surface, look)
    of_passes = [pass_values(one, look.colouring) for one in result.passes]
    return np.concatenate([values for values in of_passes if values is not None] or [np.empty(0)])


def range_of(values: FloatArray, look: Look) -> tuple[float, float, float]:
    """(low, high, step of the scale) in the unit that is shown: fixed, or round and from the data.

    Of signed values it lies even about zero, and the outermost hundredth at
    either end does not widen it.
    """
    fixed = look.ranges.get(look.colouring)
    if fixed is not None:
        low, high = (value / look.unit for value in fixed)
        return low, high, round_step(high - low, 6)
    known = values[np.isfinite(values)] / look.unit
    if not len(known):
        return 0.0, 1.0, 0.2
    if look.colouring not in SIGNED:
        return round_range(float(known.min()), float(known.max()))
    ends = np.percentile(known, [_OUTLIERS, 100.0 - _OUTLIERS])
    reach = float(np.max(np.abs(ends)))
    _, reach, step = round_range(0.0, reach, 4)
    return -reach, reach, step
