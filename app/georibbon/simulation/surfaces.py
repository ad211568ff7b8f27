"""The surfaces that can be captured virtually, and how passes lie on them by default."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from georibbon.errors import SettingsError
from georibbon.geometry.reference import (
    Bonnet,
    BSplineSurface,
    Cone,
    Cylinder,
    Ellipsoid,
    Hull,
    Plane,
    ReferenceSurface,
    Saddle,
    Seat,
    Torus,
)

Limits = tuple[float, float]
# What a ribbon can be laid on, and a geodesic followed over: from a pipe to a ship.
SIZE = (0.05, 50.0)  # m
CURVATURE = (-20.0, 20.0)  # 1/m


@dataclass(frozen=True)
class SurfaceKind:
    """A surface that can be simulated.

    make: builds it from `parameters` (the defaults by name; lengths in
    metres); limits: the least and the greatest value of each.  start: (u, v) of
    the middle of the passes; heading: degrees from the u direction; spacing:
    metres between passes.
    """

    description: str
    make: Callable[..., ReferenceSurface]
    parameters: Mapping[str, float]
    limits: Mapping[str, Limits]
    start: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0
    spacing: float = 0.1


def _sphere(radius: float) -> Ellipsoid:
    return Ellipsoid(radius, radius, radius)


def _elbow(bend: float, radius: float) -> Torus:
    return Torus(bend, radius, upright=True)


def _lying(radius: float, length: float) -> Cylinder:
    return Cylinder(radius, length)


def _wall(radius: float) -> Cylinder:
    return Cylinder(radius, upright=True)


def _plane(tilt: float, size: float) -> Plane:
    return Plane(tilt, size, size)


def spline_panel(size: float, relief: float, seed: float) -> BSplineSurface:
    """A panel of `size` metres square whose bicubic net is raised at random by `relief` metres."""
    n = 10
    rng = np.random.default_rng(int(seed))
    x = (np.arange(n) - (n - 1) / 2) * size / (n - 3)
    grid_x, grid_y = np.meshgrid(x, x, indexing="ij")
    z = relief * rng.standard_normal((n, n)) - 0.4 * (grid_x**2 + grid_y**2) / size
    return BSplineSurface(np.stack([grid_x, grid_y, z], axis=2))


SURFACES: Mapping[str, SurfaceKind] = {
    "sphere": SurfaceKind(
        "a ball of 1 m", _sphere, {"radius": 0.5}, {"radius": SIZE}, spacing=0.13
    ),
    "dome": SurfaceKind(
        "the top of a ball of 1.3 m", _sphere, {"radius": 0.65}, {"radius": SIZE}, spacing=0.12
    ),
    "ellipsoid": SurfaceKind(
        "a three-axis ellipsoid",
        Ellipsoid,
        {"a": 0.75, "b": 0.6, "c": 0.4},
        {"a": SIZE, "b": SIZE, "c": SIZE},
        spacing=0.11,
    ),
    "cone": SurfaceKind(
        "the side of a circular cone, passes across it",
        Cone,
        {"half_angle": 35.0},
        {"half_angle": (1.0, 89.0)},
        start=(0.0, 0.95),
        heading=10.0,
    ),
    "torus": SurfaceKind(
        "the top of a ring lying flat",
        Torus,
        {"major": 0.7, "minor": 0.35},
        {"major": SIZE, "minor": SIZE},
        start=(0.0, -0.5),
    ),
    "saddle": SurfaceKind(
        "a saddle",
        Saddle,
        {"radius_x": 1.1, "radius_y": 0.8},
        {"radius_x": SIZE, "radius_y": SIZE},
        heading=20.0,
        spacing=0.09,
    ),
    "bonnet": SurfaceKind(
        "a car bonnet, rippled, with inflections",
        Bonnet,
        {"crown_x": 0.3, "crown_y": 0.9, "ripple": 0.02, "wavelength": 0.7},
        {"crown_x": CURVATURE, "crown_y": CURVATURE, "ripple": (-0.5, 0.5), "wavelength": SIZE},
    ),
    "hull": SurfaceKind(
        "a boat's hull, keel up",
        Hull,
        {"length": 2.6, "beam": 0.9, "depth": 0.4},
        {"length": SIZE, "beam": SIZE, "depth": SIZE},
        start=(0.15, -0.35),
        heading=4.0,
        spacing=0.09,
    ),
    "seat": SurfaceKind(
        "a moulded seat, from the pan up the back",
        Seat,
        {"slope": 1.6, "bend": 0.3, "hollow": 0.7},
        {"slope": (-20.0, 20.0), "bend": (0.01, 50.0), "hollow": CURVATURE},
    ),
    "elbow": SurfaceKind(
        "a large pipe's elbow: passes hang underneath and turn up to face sideways",
        _elbow,
        {"bend": 0.7, "radius": 0.28},
        {"bend": SIZE, "radius": SIZE},
        start=(0.75, 0.1),
        spacing=0.11,
    ),
    "cylinder": SurfaceKind(
        "a pipe lying level, passes over it",
        _lying,
        {"radius": 0.5, "length": 3.0},
        {"radius": SIZE, "length": SIZE},
        heading=15.0,
    ),
    "wall": SurfaceKind("a curved vertical wall", _wall, {"radius": 1.0}, {"radius": SIZE}),
    "plane": SurfaceKind(
        "a plane; tilt 90: a vertical wall",
        _plane,
        {"tilt": 0.0, "size": 3.0},
        {"tilt": (-180.0, 180.0), "size": SIZE},
    ),
    "spline": SurfaceKind(
        "a bicubic B-spline panel with random relief",
        spline_panel,
        {"size": 1.6, "relief": 0.02, "seed": 3.0},
        {"size": SIZE, "relief": (0.0, 0.5), "seed": (0.0, 1e9)},
        start=(3.5, 3.5),
        heading=8.0,
        spacing=0.09,
    ),
}
"""The surfaces by name."""


def surface_kind(name: str) -> SurfaceKind:
    """The kind of that name; raises `SettingsError` where there is none."""
    if name not in SURFACES:
        raise SettingsError(
            f"surface: there is no surface {name!r}; choose one of {', '.join(SURFACES)}"
        )
    return SURFACES[name]


def make_surface(name: str, parameters: Mapping[str, float]) -> ReferenceSurface:
    """The named surface with `parameters` in place of its defaults; raises `SettingsError`."""
    kind = surface_kind(name)
    for key, value in parameters.items():
        if key not in kind.parameters:
            known = ", ".join(kind.parameters)
            raise SettingsError(f"surface {name}: no parameter {key!r}; it has {known}")
        least, most = kind.limits[key]
        if not least <= value <= most:
            raise SettingsError(
                f"surface {name}: {key} is {value:g}; give a value from {least:g} to {most:g}"
            )
    return kind.make(**{**kind.parameters, **parameters})
