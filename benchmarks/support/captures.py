"""The captures that the figures are measured on."""

from dataclasses import replace

from georibbon.simulation import (
    FaultSettings,
    LayoutSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
)

# Vertical walls aside, whose shape a ribbon with 2-axis magnetometers hardly sees.
SURFACES = (
    *("sphere", "dome", "ellipsoid", "cone", "torus", "saddle", "bonnet", "hull", "seat"),
    *("elbow", "cylinder", "spline"),
)
# Sensors in all, and the axes of the magnetometers.
RIBBONS = ((32, 2), (16, 2), (64, 3), (24, 3), (48, 2), (32, 3), (64, 2), (16, 3))


def ribbon(k: int) -> RibbonSettings:
    """The k-th ribbon, over and over again."""
    sensors, axes = RIBBONS[k % len(RIBBONS)]
    return RibbonSettings(sensors=sensors, magnetometer_axes=axes)


def marked(surface: str, seed: int, made: RibbonSettings) -> SimulationSettings:
    """Five passes whose starts and ends are marked to 0.5 mm; the heading as the seed draws it."""
    return SimulationSettings(surface=surface, seed=seed, ribbon=made)


def fanned(capture: SimulationSettings, degrees: float = 3.0) -> SimulationSettings:
    """The capture with its passes out of parallel."""
    return replace(capture, layout=replace(capture.layout, fan=degrees))


def tied(capture: SimulationSettings, ties: int = 3) -> SimulationSettings:
    """The capture without marks, crossed by tie passes instead."""
    layout = replace(capture.layout, ties=ties)
    return replace(capture, layout=layout, survey=SurveySettings(kinds=()))


def spaced(capture: SimulationSettings) -> SimulationSettings:
    """The capture without marks, the distances of neighbouring starts and ends measured."""
    return replace(capture, survey=SurveySettings(kinds=("distances",)))


def dead(capture: SimulationSettings) -> SimulationSettings:
    """The capture with an accelerometer and a magnetometer dead; which, the seed tells."""
    each = capture.ribbon.sensors // 2
    one, other = 1 + capture.seed % each, 1 + (3 * capture.seed + 2) % each
    return replace(capture, faults=FaultSettings(dead=(f"A{one:02}", f"M{other:02}")))


def magnetised(capture: SimulationSettings) -> SimulationSettings:
    """The capture with a magnet of a quarter of the field near four magnetometers of one pass."""
    made = capture.ribbon
    pitch = 2 * made.length / made.sensors
    # Midway between two magnetometers; where and on which pass, the seed tells.
    step = 2 + capture.seed % (made.sensors // 2 - 4)
    faults = FaultSettings(
        magnet=0.25,
        magnet_on=f"P{1 + capture.seed % capture.layout.passes}",
        magnet_place=(step + 0.25) * pitch,
        magnet_reach=2 * pitch,
    )
    return replace(capture, faults=faults)


def many(surface: str, passes: int, spacing: float = 0.1) -> SimulationSettings:
    """A long object under many passes, marked at starts and ends."""
    size = (passes + 10) * spacing
    layout = LayoutSettings(passes=passes, spacing=spacing, start=(0.0, 0.0))
    if surface == "plane":
        return SimulationSettings(surface, {"size": max(size, 3.0)}, layout=layout)
    return SimulationSettings(
        surface, {"length": max(size, 3.0)}, layout=replace(layout, heading=0.0)
    )


def spread(surface: str, seed: int, spacing: float) -> SimulationSettings:
    """Five marked passes that far apart."""
    return SimulationSettings(surface, seed=seed, layout=LayoutSettings(spacing=spacing))
