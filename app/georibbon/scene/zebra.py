"""Stripes as long straight lamps would throw them on a polished surface.

A stripe that breaks shows where the surface has an edge (G0), one that has a
kink where its curvature jumps (G1), one that is smooth that it is too (G2).
"""

import numpy as np
from vtkmodules.vtkRenderingCore import vtkCamera

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import unit
from georibbon.geometry.mesh import Mesh


def stripes(mesh: Mesh, camera: vtkCamera) -> FloatArray:
    """(n,) from -1 to 1: how high the direction is that each vertex mirrors to the camera.

    The line of sight e is mirrored at the normal n, r = 2 (n . e) n - e, and its
    elevation towards the picture's upward direction is taken, as a share of a
    right angle: lamps lie across, above one another.
    """
    if camera.GetParallelProjection():
        sight = -np.array(camera.GetDirectionOfProjection())[None]
    else:
        sight = unit(np.array(camera.GetPosition()) - mesh.vertices)
    height = mirrored_height(mesh.normals, sight, np.array(camera.GetViewUp()))
    return np.asarray(np.arcsin(np.clip(height, -1.0, 1.0)) / (0.5 * np.pi))


def mirrored_height(normals: FloatArray, sight: FloatArray, up: FloatArray) -> FloatArray:
    """(n,) r . up with r = 2 (n . e) n - e; n: (n, 3), e: (n or 1, 3), up: (3,), all unit."""
    facing = np.sum(normals * sight, axis=1)
    height: FloatArray = 2.0 * facing * (normals @ up) - sight @ up
    return height
