"""Figure 17: a real object's surface from a ribbon, here a virtual capture of a car bonnet."""

from dataclasses import replace

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.fitting.settings import Method, ReconstructionSettings
from georibbon.geometry.closest import closest_point
from georibbon.geometry.surface import Surface, SurfaceSettings
from georibbon.paper_figures.building import (
    DEFAULT,
    Numbers,
    crossings_of,
    tear_ratio,
    verdict_of,
)
from georibbon.paper_figures.figure import Choice, Curve, Figure, Model, Whose
from georibbon.paper_figures.known_surfaces import COLOURS
from georibbon.reconstruction import Reconstruction, reconstruct
from georibbon.simulation import FaultSettings, Simulation, score, simulate
from georibbon.simulation.demonstration import demonstration_settings

ROWS_DRAWN, COARSE = 120, 2


def figure_17() -> Figure:
    """A virtual car bonnet from a virtual ribbon's readings."""
    simulation = simulate(replace(demonstration_settings(), faults=FaultSettings()))
    ribbon = simulation.recording.ribbon
    plain = SurfaceSettings(direction="chord", lengths="unit", correspondence="fraction")
    return Figure(
        17,
        "A car bonnet from a ribbon",
        f"A virtual ribbon of {len(ribbon.sensors)} sensors, {ribbon.length:.2f} m long, with the "
        "errors of a real one, calibrated from poses and laid on a virtual car bonnet in "
        f"{sum(one.kind == 'pass' for one in simulation.recording.passes)} passes, whose ends are "
        "marked, and two ties across.",
        "A real object, a part of a car, with a ribbon of sensors laid on it several times, and "
        "the surface from what it measured.",
        "The object is virtual here, so that its true shape is known. Fitting all readings at once "
        "to what a ribbon can do, and to the marks, comes nearer to it than a curve from each "
        "pass's tangents.",
        (
            _choice("from tangents, along the chord", "paper", simulation, "paper", plain),
            _choice("Georibbon's default", "georibbon", simulation, "ribbon", SurfaceSettings()),
        ),
        main=("curves_rms_mm", "normal_rms_deg", "rms_mm", "max_mm"),
        colours=COLOURS,
    )


def _choice(
    name: str, whose: Whose, simulation: Simulation, method: Method, laid: SurfaceSettings
) -> Choice:
    result = reconstruct(simulation.recording, ReconstructionSettings(method=method, surface=laid))
    found = score(result, simulation.truth)
    shape, surface = simulation.truth.shape, result.surface
    if shape is None or surface is None or found.surface_rms is None or found.surface_max is None:
        raise RuntimeError("the demonstration has a known surface, and one is built")
    points, normals = thinned(surface)
    away = 1e3 * np.abs(closest_point(shape, points.reshape(-1, 3)).distance)
    curves = found.curves.all
    numbers: Numbers = {
        "curves_rms_mm": curves.rms,
        "curves_max_mm": curves.max,
        "normal_rms_deg": curves.normal_rms,
        "normal_max_deg": curves.normal_max,
        "rms_mm": found.surface_rms,
        "max_mm": found.surface_max,
        "tear_ratio": tear_ratio(points[None]),
        "self_crossing_pairs": crossings_of(
            points[::COARSE, ::COARSE], normals[::COARSE, ::COARSE]
        ),
        "fold_least": min(one.value for one in surface.checks if one.code == "fold"),
    }
    settings = f"method {method}; {DEFAULT if method == 'ribbon' else 'chord, unit, fraction'}"
    drawing = Model(
        grids=(points,),
        normals=(normals,),
        values=(away.reshape(points.shape[:-1]),),
        curves=_passes(result),
    )
    return Choice(name, whose, settings, numbers, verdict_of(numbers), drawing)


def thinned(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """(k, m, 3) points and normals of a built surface, with fewer rows than its mesh has."""
    rows = surface.shape[0]
    some = np.unique(np.linspace(0, rows - 1, ROWS_DRAWN).astype(int))
    points, normals = (
        values.reshape(*surface.shape, 3)[some]
        for values in (surface.mesh.vertices, surface.mesh.normals)
    )
    return points, normals


def _passes(result: Reconstruction) -> tuple[Curve, ...]:
    return tuple(Curve(one.strip.points) for one in result.passes if one.kind == "pass")
