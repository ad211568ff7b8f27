"""Curves whose tangents are known, for the tests of what is made of tangents."""

import numpy as np

from georibbon.geometry.frames import unit


def helix(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    a, b = 0.1, 0.03
    t = s / np.hypot(a, b)
    points = np.stack([a * np.cos(t), a * np.sin(t), b * t], axis=1)
    tangents = np.stack([-a * np.sin(t), a * np.cos(t), np.full_like(t, b)], axis=1)
    return points - points[0], tangents / np.hypot(a, b), unit(points * [1.0, 1.0, 0.0])


def some_directions(count: int, spread: float = 0.3) -> np.ndarray:
    steps = spread * np.random.default_rng(5).normal(size=(count, 3))
    return unit(np.array([1.0, 0.5, 0.2]) + np.cumsum(steps, axis=0))
