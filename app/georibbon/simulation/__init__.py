"""Virtual captures: recordings of a virtual ribbon on known surfaces, with their truth."""

from georibbon.simulation.capture import Simulation, simulate
from georibbon.simulation.scoring import CurveErrors, Errors, Score, curve_errors, score
from georibbon.simulation.settings import (
    FaultSettings,
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
)
from georibbon.simulation.surfaces import SURFACES, SurfaceKind, make_surface
from georibbon.simulation.truth import Truth, read_truth, write_truth

__all__ = [
    "SURFACES",
    "CurveErrors",
    "Errors",
    "FaultSettings",
    "LayoutSettings",
    "PoseSettings",
    "RibbonSettings",
    "Score",
    "Simulation",
    "SimulationSettings",
    "SurfaceKind",
    "SurveySettings",
    "Truth",
    "curve_errors",
    "make_surface",
    "read_truth",
    "score",
    "simulate",
    "write_truth",
]
