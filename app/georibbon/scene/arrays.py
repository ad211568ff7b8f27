"""NumPy arrays to VTK and back: the one place that calls VTK's bridge, which has no types."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkDataArray, vtkIdTypeArray


def to_vtk(values: NDArray[Any]) -> vtkDataArray:
    """A VTK copy of an (n,) or (n, components) array, of the same number type."""
    flat = np.ascontiguousarray(values)
    array: vtkDataArray = numpy_support.numpy_to_vtk(  # type: ignore[no-untyped-call]  # VTK's
        flat, deep=True
    )
    return array


def to_ids(values: NDArray[np.int64]) -> vtkIdTypeArray:
    """A VTK copy of an (n,) array of point numbers."""
    flat = np.ascontiguousarray(values, dtype=np.int64)
    array: vtkIdTypeArray = numpy_support.numpy_to_vtkIdTypeArray(  # type: ignore[no-untyped-call]  # VTK's
        flat, deep=True
    )
    return array


def from_vtk(array: vtkDataArray) -> NDArray[Any]:
    """A NumPy view of a VTK array, (n,) or (n, components)."""
    view: NDArray[Any] = numpy_support.vtk_to_numpy(array)  # type: ignore[no-untyped-call]  # VTK's
    return view


def shared(values: NDArray[Any]) -> vtkDataArray:
    """A VTK array over the memory of a contiguous NumPy array, which must be kept alive."""
    array: vtkDataArray = numpy_support.numpy_to_vtk(values)  # type: ignore[no-untyped-call]  # VTK's
    return array
