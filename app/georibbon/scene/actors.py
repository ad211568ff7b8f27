"""What stands in the scene: the surface, the passes, the survey's points, the floor."""

from itertools import pairwise
from typing import Literal

import numpy as np
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkBillboardTextActor3D,
    vtkGlyph3DMapper,
    vtkPolyDataMapper,
)

from georibbon.arrays import FloatArray, IntArray
from georibbon.geometry.mesh import Mesh
from georibbon.scene.arrays import to_ids, to_vtk
from georibbon.scene.colours import PLAIN_SURFACE, Colour, quantity_table
from georibbon.scene.text import plain_label, style

Side = Literal["left", "middle", "right"]


def look_up_table(low: float, high: float) -> vtkLookupTable:
    """The colours of a quantity between `low` and `high`."""
    colours = quantity_table()
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colours))
    for index, (red, green, blue) in enumerate((colours / 255.0).tolist()):
        table.SetTableValue(index, red, green, blue, 1.0)
    table.SetRange(low, high)
    return table


def polydata(points: FloatArray) -> vtkPolyData:
    """A data set of (n, 3) points, single precision, with no cells yet."""
    holder = vtkPoints()
    holder.SetData(to_vtk(points.astype(np.float32)))
    data = vtkPolyData()
    data.SetPoints(holder)
    return data


def cells(lists: list[IntArray]) -> vtkCellArray:
    """Cells from lists of point numbers, of any lengths."""
    offsets = np.concatenate(([0], np.cumsum([len(one) for one in lists]))).astype(np.int64)
    array = vtkCellArray()
    array.SetData(
        to_ids(offsets),
        to_ids(np.concatenate(lists)),
    )
    return array


def surface_data(mesh: Mesh) -> vtkPolyData:
    """The mesh with its normals and, where it has them, its sigmas in millimetres."""
    data = polydata(mesh.vertices)
    triangles = vtkCellArray()
    triangles.SetData(3, to_ids(mesh.triangles.ravel()))
    data.SetPolys(triangles)
    data.GetPointData().SetNormals(to_vtk(mesh.normals.astype(np.float32)))
    if mesh.sigma is not None:
        _set_scalars(data, mesh.sigma * 1e3)
    return data


def surface_actor(data: vtkPolyData, table: vtkLookupTable | None) -> vtkActor:
    """The surface, coloured by its sigma where a table is given."""
    actor = _actor(data, table)
    look = actor.GetProperty()
    look.SetColor(*PLAIN_SURFACE)
    look.SetAmbient(0.22)
    look.SetDiffuse(0.80)
    look.SetSpecular(0.12)
    look.SetSpecularPower(25)
    return actor


def border_actor(data: vtkPolyData, colour: Colour) -> vtkActor:
    """The surface's border as a thin line."""
    edges = vtkFeatureEdges()
    edges.SetInputData(data)
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.NonManifoldEdgesOff()
    edges.ColoringOff()
    edges.Update()
    actor = _actor(edges.GetOutput(), None)
    _flat(actor, colour)
    actor.GetProperty().SetLineWidth(1.5)
    return actor


def tube_actor(
    curves: list[FloatArray],
    radius: float,
    colour: Colour,
    sigma: list[FloatArray] | None = None,
    table: vtkLookupTable | None = None,
) -> vtkActor:
    """Curves of (n, 3) points each as tubes; coloured by sigma (metres) with a table."""
    data = line_data(curves)
    if sigma is not None and table is not None:
        _set_scalars(data, np.concatenate(sigma) * 1e3)
    tubes = vtkTubeFilter()
    tubes.SetInputData(data)
    tubes.SetRadius(radius)
    tubes.SetNumberOfSides(12)
    tubes.CappingOn()
    tubes.Update()
    actor = _actor(tubes.GetOutput(), table)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetAmbient(0.3)
    return actor


def line_actor(curves: list[FloatArray], colour: Colour, width: float) -> vtkActor:
    """Curves of (n, 3) points each as lines of one colour, `width` pixels wide."""
    actor = _actor(line_data(curves), None)
    _flat(actor, colour)
    actor.GetProperty().SetLineWidth(width)
    return actor


def sphere_actor(points: FloatArray, radius: float, colour: Colour) -> vtkActor:
    """A ball at each of (n, 3) points."""
    ball = vtkSphereSource()
    ball.SetRadius(radius)
    ball.SetThetaResolution(20)
    ball.SetPhiResolution(14)
    ball.Update()
    mapper = vtkGlyph3DMapper()
    mapper.SetInputData(polydata(points))
    mapper.SetSourceData(ball.GetOutput())
    mapper.ScalingOff()
    mapper.OrientOff()
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetAmbient(0.35)
    return actor


def label_actor(
    text: str, at: FloatArray, size: int, side: Side, colour: Colour
) -> vtkBillboardTextActor3D:
    """A word that always faces the reader and lies on one side of a (3,) point."""
    actor = vtkBillboardTextActor3D()
    actor.SetInput(plain_label(text))
    actor.SetPosition(*(float(value) for value in at))
    look = actor.GetTextProperty()
    style(look, size, colour, bold=True)
    look.SetJustification({"left": 2, "middle": 1, "right": 0}[side])  # VTK_TEXT_RIGHT, ...
    look.SetVerticalJustificationToCentered()
    return actor


def side_of(rightwards: float) -> Side:
    """Where a label lies so that it does not cover the curve that it leads to."""
    if abs(rightwards) < 0.3:
        return "middle"
    return "left" if rightwards < 0 else "right"


def line_data(curves: list[FloatArray]) -> vtkPolyData:
    """Polylines through curves of (n, 3) points each."""
    data = polydata(np.concatenate(curves))
    starts = np.cumsum([0] + [len(curve) for curve in curves])
    data.SetLines(cells([np.arange(a, b) for a, b in pairwise(starts)]))
    return data


def _set_scalars(data: vtkPolyData, values: FloatArray) -> None:
    array = to_vtk(values.astype(np.float32))
    array.SetName("sigma")
    data.GetPointData().SetScalars(array)


def _actor(data: vtkPolyData, table: vtkLookupTable | None) -> vtkActor:
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetScalarVisibility(table is not None)
    if table is not None:
        mapper.SetLookupTable(table)
        mapper.UseLookupTableScalarRangeOn()
        mapper.InterpolateScalarsBeforeMappingOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor


def _flat(actor: vtkActor, colour: Colour) -> None:
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().LightingOff()
