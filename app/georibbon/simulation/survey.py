"""The virtual survey: marks, distances and crossings as a careful hand measures them."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from georibbon.geometry.frames import Strip
from georibbon.recording import Crossing, Distance, Mark
from georibbon.simulation.layout import crossing
from georibbon.simulation.settings import SurveySettings


def measure_marks(
    strips: Mapping[str, Strip], survey: SurveySettings, rng: np.random.Generator
) -> tuple[Mark, ...]:
    """The starts and ends of the passes, as far as the survey's kinds say."""
    marks = []
    for name, strip in strips.items():
        if not name.startswith("P"):
            continue
        for kind, index in (("starts", 0), ("ends", -1)):
            error = survey.mark_sigma * rng.standard_normal(3)
            if kind in survey.kinds:
                x, y, z = (float(value) for value in np.round(strip.points[index] + error, 6))
                at = float(strip.s[index])
                marks.append(Mark(name, at, (x, y, z), survey.mark_sigma))
    return tuple(marks)


def measure_distances(
    strips: Mapping[str, Strip], survey: SurveySettings, rng: np.random.Generator
) -> tuple[Distance, ...]:
    """The distances between the starts, and between the ends, of neighbouring passes."""
    if "distances" not in survey.kinds:
        return ()
    found = []
    for p, q in pairwise(name for name in strips if name.startswith("P")):
        for index in (0, -1):
            length = float(np.linalg.norm(strips[p].points[index] - strips[q].points[index]))
            length += survey.distance_sigma * rng.standard_normal()
            at = (float(strips[p].s[index]), float(strips[q].s[index]))
            found.append(Distance((p, q), at, round(length, 6), survey.distance_sigma))
    return tuple(found)


def measure_crossings(
    strips: Mapping[str, Strip],
    survey: SurveySettings,
    rng: np.random.Generator,
    tolerance: float = 1e-6,
) -> tuple[Crossing, ...]:
    """Where each tie meets each pass, within a tolerance (m), read on both ribbons."""
    found = []
    for tie in (name for name in strips if name.startswith("T")):
        for name in (name for name in strips if name.startswith("P")):
            error = survey.crossing_sigma / np.sqrt(2) * rng.standard_normal(2)
            met = crossing(strips[name], strips[tie], tolerance)
            if met is None:
                continue
            length = strips[name].s[-1]
            first, second = (float(a) for a in np.round(np.clip(met + error, 0.0, length), 6))
            found.append(Crossing((name, tie), (first, second), survey.crossing_sigma))
    return tuple(found)
