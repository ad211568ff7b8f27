"""Frames as a ribbon at rest, moved or beside a magnet sends them."""

from collections.abc import Sequence

import numpy as np

from georibbon.device.frames import LOST, Frame
from georibbon.ribbon import Ribbon
from georibbon.simulation.settings import RibbonSettings
from georibbon.simulation.virtual import noise_counts, virtual_ribbon

SETTINGS = RibbonSettings(sensors=16, length=0.48)
RIBBON = virtual_ribbon(SETTINGS)
SIGMA = noise_counts(RIBBON, SETTINGS)
MG = 16.384  # counts


def columns(ribbon: Ribbon, kind: str) -> np.ndarray:
    """The columns of all sensors of one kind."""
    return np.concatenate(
        [
            np.arange(where.start, where.stop)
            for where in map(ribbon.slices.__getitem__, ribbon.indices(kind))
        ]
    )


ACCELEROMETERS, MAGNETOMETERS = columns(RIBBON, "accelerometer"), columns(RIBBON, "magnetometer")


def at_rest(frames: int, seed: int = 0, sigma: np.ndarray = SIGMA) -> np.ndarray:
    """(frames, c) counts of a ribbon that lies still, with white noise."""
    base = np.random.default_rng(77).uniform(-1500.0, 1500.0, len(sigma))
    return base + sigma * np.random.default_rng(seed).standard_normal((frames, len(sigma)))


def frames_of(
    counts: np.ndarray, rate: float = RIBBON.rate, times: Sequence[float] | None = None
) -> list[Frame]:
    """Counts (m, c), NaN for what is lost, as frames evenly in time or at the times given."""
    t = np.arange(len(counts)) / rate if times is None else times
    whole = np.where(np.isfinite(counts), np.clip(np.rint(counts), -32767, 32767), LOST)
    return [
        Frame(float(when), row, 0.0) for when, row in zip(t, whole.astype(np.int16), strict=True)
    ]
