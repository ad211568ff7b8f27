"""Actors whose arrays stay: what moves is written into them, in single precision."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkDataArray, vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from georibbon.arrays import FloatArray, IntArray
from georibbon.scene.arrays import shared, to_ids
from georibbon.scene.colours import Colour
from georibbon.scene.shapes import Solid


class _Array:
    """An array that VTK reads where NumPy writes it."""

    def __init__(self, values: NDArray[Any]) -> None:
        self.values = np.array(values, dtype=np.float32, order="C")
        self.vtk: vtkDataArray = shared(self.values)

    def fits(self, values: NDArray[Any]) -> bool:
        return self.values.shape == values.shape

    def write(self, values: NDArray[Any]) -> None:
        self.values[...] = values
        self.vtk.Modified()


class _Buffer:
    """One actor over one data set."""

    def __init__(self) -> None:
        self.data = vtkPolyData()
        self.mapper = vtkPolyDataMapper()
        self.mapper.SetInputData(self.data)
        self.mapper.ScalarVisibilityOff()
        self.actor = vtkActor()
        self.actor.SetMapper(self.mapper)
        self._places: _Array | None = None
        self._scalars: _Array | None = None

    @property
    def points(self) -> NDArray[np.float32]:
        """(n, 3) what is drawn, metres."""
        return np.empty((0, 3), np.float32) if self._places is None else self._places.values

    def show_values(self, values: FloatArray | None, table: vtkLookupTable | None) -> None:
        """Colour by (n,) values of the points, through a table; by one colour where None."""
        self.mapper.SetScalarVisibility(values is not None)
        if values is None or table is None:
            return
        if self._scalars is not None and self._scalars.fits(values):
            self._scalars.write(values)
            self.data.Modified()
        else:
            self._scalars = _Array(values)
            self.data.GetPointData().SetScalars(self._scalars.vtk)
        self.mapper.SetLookupTable(table)
        self.mapper.UseLookupTableScalarRangeOn()
        self.mapper.InterpolateScalarsBeforeMappingOn()

    def _place(self, points: FloatArray) -> None:
        if self._places is not None and self._places.fits(points):
            self._places.write(points)
            self.data.GetPoints().Modified()
        else:
            self._places = _Array(points)
            holder = vtkPoints()
            holder.SetData(self._places.vtk)
            self.data.SetPoints(holder)
        self.data.Modified()


class Triangles(_Buffer):
    """A lit body of triangles."""

    def __init__(self, ambient: float) -> None:
        super().__init__()
        self.actor.GetProperty().SetAmbient(ambient)
        self._normals: _Array | None = None
        self._triangles: IntArray | None = None

    def show(self, solid: Solid) -> bool:
        """Show a body; whether the triangles that were there could stay."""
        same = self._triangles is not None and np.array_equal(self._triangles, solid.triangles)
        self._place(solid.points)
        if self._normals is not None and self._normals.fits(solid.normals):
            self._normals.write(solid.normals)
        else:
            self._normals = _Array(solid.normals)
            self.data.GetPointData().SetNormals(self._normals.vtk)
        if not same:
            self._triangles = solid.triangles
            cells = vtkCellArray()
            cells.SetData(3, to_ids(solid.triangles.ravel()))
            self.data.SetPolys(cells)
        return same


class Lines(_Buffer):
    """Unlit lines of one colour, some pixels wide."""

    def __init__(self, colour: Colour, width: float) -> None:
        super().__init__()
        look = self.actor.GetProperty()
        look.SetColor(*colour)
        look.LightingOff()
        look.SetLineWidth(width)
        look.SetRenderLinesAsTubes(width > 1.0)  # VTK's own: drivers may draw all lines thin
        self._counts: list[int] = []

    def show(self, curves: Sequence[FloatArray]) -> None:
        """Show lines through curves of (n, 3) points each."""
        counts = [len(curve) for curve in curves]
        self._place(np.concatenate([np.empty((0, 3)), *curves]))
        if counts != self._counts:
            self._counts = counts
            self.data.SetLines(_polylines(counts))


def _polylines(counts: Sequence[int]) -> vtkCellArray:
    """Cells of so many points each, one after the other."""
    offsets = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
    numbers = [np.arange(a, b) for a, b in pairwise(offsets.tolist())]
    array = vtkCellArray()
    array.SetData(to_ids(offsets), to_ids(np.concatenate([np.empty(0, np.int64), *numbers])))
    return array
