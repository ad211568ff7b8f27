"""Look-up tables for quantities, in 2D and in 3D, and the scene's fixed colours.

The map is viridis (Smith and van der Walt 2015): even steps to the eye, readable
in grey and by people who confuse red and green.  It is kept as 24 anchors,
between which linear interpolation stays within three of 255 levels, so that the
scene needs no plotting library.  What has a sign has a map of its own, from blue
over a light grey to red, as dark at one end as at the other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Colour = tuple[float, float, float]

_ANCHORS = (
    "440154 471164 482072 472e7c 433c84 3f4989 39558c 34608d 2f6b8e 2b768e 26808e 228b8d "
    "1f958b 1fa088 24aa83 30b47c 41be72 57c766 6fcf58 8ad647 a7db34 c5e022 e2e418 fde725"
)

_SIGNED_ANCHORS = "0b3c8c 2c69b8 5e97d3 9dc1e4 d3dfea e9e7e4 f0d3c4 e5a388 d06e55 b03a34 7f1022"

BACKGROUND: Colour = (1.0, 1.0, 1.0)
INK: Colour = (0.13, 0.15, 0.18)
GRID: Colour = (0.80, 0.82, 0.85)
GRID_WORDS: Colour = (0.40, 0.42, 0.46)
PLAIN_SURFACE: Colour = (0.62, 0.70, 0.78)
PASS: Colour = (0.10, 0.11, 0.13)
TIE: Colour = (0.84, 0.33, 0.10)
MARK: Colour = (0.80, 0.10, 0.42)


@dataclass(frozen=True)
class Paper:
    """What a scene stands on, and the colours that stand out from it.

    ink: words and borders.  run: passes.  grid: the floor's lines; grid_words:
    what is said of them.  axes: of x, y and z.  live: what is being laid;
    neighbour: what it is laid beside.  blank: what is not known.
    sensor, unused: sensors that count and
    that do not.  tool: what is pointed at and measured.
    """

    background: Colour
    ink: Colour
    run: Colour
    tie: Colour
    mark: Colour
    grid: Colour
    grid_words: Colour
    axes: tuple[Colour, Colour, Colour]
    live: Colour
    neighbour: Colour
    blank: Colour
    sensor: Colour
    unused: Colour
    tool: Colour


WHITE = Paper(
    BACKGROUND,
    INK,
    PASS,
    TIE,
    MARK,
    GRID,
    GRID_WORDS,
    ((0.75, 0.15, 0.15), (0.10, 0.50, 0.20), (0.15, 0.30, 0.75)),
    live=(0.00, 0.36, 0.90),
    neighbour=(0.50, 0.20, 0.72),
    blank=(0.52, 0.53, 0.56),
    sensor=(0.98, 0.98, 0.98),
    unused=(0.86, 0.11, 0.11),
    tool=(0.86, 0.00, 0.55),
)
DARK = Paper(
    background=(0.0902, 0.0980, 0.1137),
    ink=(0.90, 0.91, 0.93),
    run=(0.94, 0.95, 0.96),
    tie=(1.00, 0.62, 0.32),
    mark=(1.00, 0.47, 0.72),
    grid=(0.27, 0.29, 0.32),
    grid_words=(0.66, 0.69, 0.73),
    axes=((1.00, 0.48, 0.45), (0.44, 0.82, 0.52), (0.50, 0.69, 1.00)),
    live=(0.35, 0.85, 1.00),
    neighbour=(0.82, 0.66, 1.00),
    blank=(0.45, 0.46, 0.49),
    sensor=(0.13, 0.15, 0.18),
    unused=(1.00, 0.42, 0.38),
    tool=(1.00, 0.55, 0.88),
)


def quantity_table(size: int = 256) -> NDArray[np.uint8]:
    """(size, 3) uint8, sRGB, from the smallest value's colour to the largest's."""
    return _table(_ANCHORS, size)


def signed_table(size: int = 256) -> NDArray[np.uint8]:
    """(size, 3) uint8, sRGB, from the most negative value's colour over zero's to the other end."""
    return _table(_SIGNED_ANCHORS, size)


def zebra_table(stripes: int = 44, size: int = 4096) -> NDArray[np.uint8]:
    """(size, 3) uint8, sRGB: dark and light stripes in turn, with edges a twelfth of them wide."""
    phase = (np.arange(size) + 0.5) / size * stripes
    wave = np.clip(6.0 * (2.0 * np.abs((phase % 2.0) - 1.0) - 1.0), -1.0, 1.0)
    grey = np.rint(135.0 + 110.0 * wave).astype(np.uint8)
    return np.repeat(grey[:, None], 3, axis=1)


def _table(words: str, size: int) -> NDArray[np.uint8]:
    anchors = np.array([list(bytes.fromhex(word)) for word in words.split()], dtype=float)
    at = np.linspace(0, len(anchors) - 1, size)
    columns = [np.interp(at, np.arange(len(anchors)), column) for column in anchors.T]
    table: NDArray[np.uint8] = np.rint(np.column_stack(columns)).astype(np.uint8)
    return table


def round_step(width: float, parts: int) -> float:
    """The smallest of 1, 2, 5 times a power of ten that cuts `width` into at most `parts`."""
    least = width / parts
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(m * power for m in (1, 2, 5, 10) if m * power >= least * (1 - 1e-9)))


def round_range(low: float, high: float, parts: int = 6) -> tuple[float, float, float]:
    """(low, high, step): the range widened outwards to whole steps of a round number.

    A range narrower than a twentieth of its upper end is no difference worth
    colours: it is widened to start from zero.
    """
    if high - low < 0.05 * abs(high):
        low = 0.0
    if high <= low:
        low, high = 0.0, 1.0
    step = round_step(high - low, parts)
    return (
        float(np.floor(low / step + 1e-9)) * step,
        float(np.ceil(high / step - 1e-9)) * step,
        step,
    )
