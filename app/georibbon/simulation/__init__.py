"""Virtual captures: recordings of a virtual ribbon on known surfaces, with their truth."""

from georibbon.simulation.capture import Simulation, simulate
from georibbon.simulation.settings import (
    FaultSettings,
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
)
from georibbon.simulation.surfaces import SURFACES, SurfaceKind, make_surface
from georibbon.simulation.truth import Truth

__all__ = [
    "SURFACES",
    "FaultSettings",
    "LayoutSettings",
    "PoseSettings",
    "RibbonSettings",
    "Simulation",
    "SimulationSettings",
    "SurfaceKind",
    "SurveySettings",
    "Truth",
    "make_surface",
    "simulate",
]
