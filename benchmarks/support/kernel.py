"""OpenCASCADE's surfaces through curves: the loft, and the plate with tangent planes or without."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import Strip
from support.produced import COLUMNS, ROWS, Sampled, from_slopes, midpoints, places_between

BAND = 0.01  # m, half the width of the surface that carries a pass's tangent planes
PLACES = 121  # along a curve of the plate's parameters


def kernel_curve(points: FloatArray) -> Any:
    """OpenCASCADE's interpolating B-spline curve through points (n, 3)."""
    from OCP.collections import HArray1_gp_Pnt
    from OCP.GeomAPI import GeomAPI_Interpolate
    from OCP.gp import gp_Pnt

    array = HArray1_gp_Pnt(1, len(points))
    for i, point in enumerate(points.tolist()):
        array.SetValue(i + 1, gp_Pnt(*point))
    made = GeomAPI_Interpolate(array, False, 1e-9)
    made.Perform()
    return made.Curve()


def loft_lay(strips: Sequence[Strip], degree: int) -> Any:
    """OpenCASCADE's smooth loft through the curves as wires; ValueError where it fails."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    sections = BRepOffsetAPI_ThruSections(False, False, 1e-6)
    sections.CheckCompatibility(False)
    sections.SetMaxDegree(degree)
    for strip in strips:
        edge = BRepBuilderAPI_MakeEdge(kernel_curve(strip.points)).Edge()
        sections.AddWire(BRepBuilderAPI_MakeWire(edge).Wire())
    sections.Build()
    if not sections.IsDone():
        raise ValueError("the loft is not done")
    faces = TopExp_Explorer(sections.Shape(), TopAbs_FACE)
    return BRep_Tool.Surface_s(TopoDS.Face(faces.Current()), TopLoc_Location()), len(strips)


def kernel_slopes(surface: Any, places: FloatArray) -> Sampled:
    """Points and derivatives of OpenCASCADE's surface at parameters (k, w, 2)."""
    from OCP.gp import gp_Pnt, gp_Vec

    point, along, across = gp_Pnt(), gp_Vec(), gp_Vec()
    found = []
    for u, v in places.reshape(-1, 2).tolist():
        surface.D1(u, v, point, along, across)
        found.append([(one.X(), one.Y(), one.Z()) for one in (point, along, across)])
    values = np.array(found).reshape(*places.shape[:2], 3, 3)
    return from_slopes(values[:, :, 0], values[:, :, 1], values[:, :, 2])


def loft_sample(laid: Any) -> Sampled:
    """Its points and derivatives, by the kernel's own evaluation."""
    surface, passes = laid
    u0, u1, v0, v1 = surface.Bounds()
    at = midpoints(u0, u1, ROWS), midpoints(v0, v1, COLUMNS * (passes - 1))
    return kernel_slopes(surface, np.stack(np.meshgrid(*at, indexing="ij"), axis=2))


def kernel_band(strip: Strip) -> Any:
    """A narrow ruled surface along a pass, whose tangent planes in its middle are the pass's."""
    from OCP.GeomFill import GeomFill

    sides = (kernel_curve(strip.points + one * strip.conormals) for one in (-BAND, BAND))
    return GeomFill.Surface_s(*sides)


def constraint(strip: Strip, tangent: bool, keep: list[Any]) -> Any:
    """The pass as the plate's constraint, with its tangent planes or without."""
    from OCP.Adaptor3d import Adaptor3d_CurveOnSurface
    from OCP.Geom2d import Geom2d_Line
    from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
    from OCP.GeomAdaptor import GeomAdaptor_Curve, GeomAdaptor_Surface
    from OCP.GeomPlate import GeomPlate_CurveConstraint
    from OCP.gp import gp_Dir2d, gp_Pnt2d

    if tangent:
        band = kernel_band(strip)
        u0, u1, v0, v1 = band.Bounds()
        line = Geom2d_Line(gp_Pnt2d(u0, 0.5 * (v0 + v1)), gp_Dir2d(1.0, 0.0))
        middle = Geom2dAdaptor_Curve(line, 0.0, u1 - u0)
        curve = Adaptor3d_CurveOnSurface(middle, GeomAdaptor_Surface(band))
        keep += [band, line, middle]
    else:
        curve = GeomAdaptor_Curve(kernel_curve(strip.points))
    keep.append(curve)
    return GeomPlate_CurveConstraint(curve, int(tangent), 40, 1e-5, 1e-3, 0.1)


def plate_lay(strips: Sequence[Strip], tangent: bool, order: int) -> Any:
    """OpenCASCADE's plate through the curves, of that order of energy; ValueError if it fails."""
    from OCP.GeomPlate import GeomPlate_BuildPlateSurface

    keep: list[Any] = []
    builder = GeomPlate_BuildPlateSurface(order, 40, 3, 1e-6, 1e-5, 1e-3, 0.1, False)
    for strip in strips:
        keep.append(constraint(strip, tangent, keep))
        builder.Add(keep[-1])
    builder.Perform()
    if not builder.IsDone():
        raise ValueError("the plate is not done")
    return builder.Surface(), builder, keep


def plate_sample(laid: Any) -> Sampled:
    """Its points and derivatives, between the curves as they run in its parameters."""
    surface, builder, *_ = laid
    curves = list(builder.Curves2d())
    ends = [(one.FirstParameter(), one.LastParameter()) for one in curves]
    runs = [
        [one.Value(float(t)) for t in np.linspace(*end, PLACES)]
        for one, end in zip(curves, ends, strict=True)
    ]
    places = np.array([[(point.X(), point.Y()) for point in run] for run in runs])
    return kernel_slopes(surface, places_between(np.swapaxes(places, 0, 1)))
