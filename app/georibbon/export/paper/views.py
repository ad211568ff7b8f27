"""The surfaces of the paper's figures in space, drawn off screen."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkLightKit, vtkProperty, vtkRenderer

from georibbon.arrays import FloatArray
from georibbon.geometry.mesh import grid_mesh
from georibbon.paper_figures import Model
from georibbon.scene import shapes
from georibbon.scene.actors import look_up_table, skin, solid_of
from georibbon.scene.buffers import Lines, Triangles
from georibbon.scene.camera import Region, View, fit_view
from georibbon.scene.colours import BACKGROUND, INK, Colour, signed_table
from georibbon.scene.offscreen import offscreen_window, pixels
from georibbon.scene.shapes import Solid

BACK: Colour = (0.95, 0.72, 0.52)  # of a surface's other side, which a fold turns up
ACROSS: Colour = (0.30, 0.34, 0.40)
ARROW: Colour = (0.76, 0.10, 0.36)
TUBE, ARROW_TUBE = 0.0045, 0.0022  # radii as shares of the object's size
SIDES = 10
REGION = Region(0.96, 0.96, 0.94, 0.94)

Pixels = NDArray[np.uint8]


def common_view(
    models: Sequence[Model], towards: tuple[float, float, float], aspect: float
) -> tuple[View, float]:
    """The view from which all models are seen alike, and their size, metres."""
    points = np.concatenate([_extent(model) for model in models])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    direction = np.asarray(towards) / np.linalg.norm(towards)
    return fit_view(points, direction, aspect, REGION), size


def _extent(model: Model) -> FloatArray:
    parts = [grid[::4].reshape(-1, 3) for grid in model.grids]
    parts += [curve.points for curve in model.curves if curve.bold]
    parts += list(model.arrows or ())
    return np.concatenate(parts)


def drawn_model(
    model: Model, view: View, size: float, top: float, pixels_of: tuple[int, int]
) -> Pixels:
    """A picture of a model, (height, width, 3), of so many pixels (width, height).

    size: metres, of all models together.  top: what the last colour stands for.
    Raises ExportError where the system cannot draw.
    """
    renderer = vtkRenderer()
    renderer.SetBackground(*BACKGROUND)
    lights = vtkLightKit()
    lights.AddLightsToRenderer(renderer)
    parts = [*_surface(model, top), *_curves(model, size)]
    for part in parts:
        renderer.AddActor(part.actor)
    _stand(renderer, view)
    window = offscreen_window(pixels_of)
    try:
        window.AddRenderer(renderer)
        window.Render()
        return pixels(window)
    finally:
        window.Finalize()


def _stand(renderer: vtkRenderer, view: View) -> None:
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*view.position.tolist())
    camera.SetFocalPoint(*view.focus.tolist())
    camera.SetViewUp(*view.up.tolist())
    camera.SetViewAngle(float(np.degrees(view.angle)))
    renderer.ResetCameraClippingRange()


def _surface(model: Model, top: float) -> list[Triangles]:
    table = look_up_table(signed_table(511)[255:], INK)
    table.SetRange(0.0, top)
    parts = []
    for i, (grid, normals) in enumerate(zip(model.grids, model.normals, strict=True)):
        mesh = grid_mesh(grid, normals)
        part = skin()
        part.show(Solid(mesh.vertices, mesh.normals, mesh.triangles))
        part.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        part.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)
        if model.values:
            part.show_values(model.values[i].ravel(), table)
        else:
            back = vtkProperty()
            back.DeepCopy(part.actor.GetProperty())
            back.SetColor(*BACK)
            back.SetAmbient(0.45)
            part.actor.SetBackfaceProperty(back)
        parts.append(part)
    return parts


def _curves(model: Model, size: float) -> list[Triangles | Lines]:
    parts: list[Triangles | Lines] = []
    bold = [curve.points for curve in model.curves if curve.bold]
    thin = [curve.points for curve in model.curves if not curve.bold]
    if bold:
        body = solid_of(INK)
        body.show(shapes.tubes(bold, TUBE * size, SIDES))
        parts.append(body)
    if thin:
        lines = Lines(ACROSS, 1.0)
        lines.show(thin)
        parts.append(lines)
    if model.arrows is not None:
        body = solid_of(ARROW)
        starts, ends = model.arrows
        body.show(shapes.tubes(list(np.stack([starts, ends], axis=1)), ARROW_TUBE * size, 6))
        parts.append(body)
    return parts
