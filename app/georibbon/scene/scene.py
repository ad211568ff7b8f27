"""The scene of one result: it owns the renderers and actors and serves any render window."""

import numpy as np
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingCore import vtkLightKit, vtkProp, vtkRenderer, vtkRenderWindow

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import interpolated
from georibbon.reconstruction import FittedPass, Reconstruction, SurveyResidual
from georibbon.scene import actors, overlays
from georibbon.scene.camera import Region, fit_view, view_direction
from georibbon.scene.colours import WHITE, Colour, Paper, round_range, round_step

_MOST_LABELS = 12
_TUBE, _BALL = 0.0022, 0.0060  # radii as shares of the object's diagonal,
_CURSOR = 0.011
_MOST_FULL = 16  # of up to so many passes; more are drawn thinner, not to hide the surface
_FRAMED = Region(left=0.91, right=0.60, bottom=0.90, top=0.90)
_CELLS = 12  # of the floor's grid along the object's longer side, at most


class Scene:
    """Surface, passes, ties, survey points, floor, axes and scalar bar of one result.

    The surface is coloured by its position uncertainty (square root of the
    covariance's trace, millimetres); without a surface the passes are.
    font_size: pixels.  uncertainty_range: millimetres, to compare results with
    one another; from the data where None.  paper: the ground and what is drawn on
    it.  z of the workpiece is up.
    """

    def __init__(
        self,
        reconstruction: Reconstruction,
        font_size: int = 14,
        uncertainty_range: tuple[float, float] | None = None,
        paper: Paper = WHITE,
    ) -> None:
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(*paper.background)
        self.overlay = overlays.axes_renderer(font_size, paper.axes)
        self._paper = paper
        self._font_size = font_size
        self._key: list[tuple[str, Colour]] = []
        self._result = reconstruction
        self._curves = [fitted.strip.points for fitted in reconstruction.passes]
        self._points = _extent(reconstruction)
        self._size = float(np.linalg.norm(np.ptp(self._points, axis=0)))
        self._thickness = self._size * min(1.0, _MOST_FULL / len(reconstruction.passes))
        self.direction = view_direction(
            np.concatenate([fitted.strip.normals for fitted in reconstruction.passes])
        )
        table, step = self._table(uncertainty_range)
        self._add_surface(table)
        self._add_passes(table)
        self._add_survey()
        self._add_floor()
        self._cursor = actors.sphere_actor(np.zeros((1, 3)), self._size * _CURSOR, paper.ink)
        self._cursor.VisibilityOff()
        self._add(self._cursor)
        if table is not None:
            self._add(overlays.scalar_bar(table, step, font_size, paper.ink))
        for line in overlays.key(self._key, font_size):
            self._add(line)
        self._lights = _lights(from_above=bool(self.direction[2] > 0))
        self._lights.AddLightsToRenderer(self.renderer)

    def attach(self, window: vtkRenderWindow) -> None:
        """Show the scene in a window: the scene below, the axes in a layer above."""
        window.SetNumberOfLayers(2)
        self.renderer.SetLayer(0)
        self.overlay.SetLayer(1)
        window.AddRenderer(self.renderer)
        window.AddRenderer(self.overlay)

    def frame(self, aspect: float, direction: FloatArray | None = None) -> None:
        """Put the camera where everything fits a picture of this width over height.

        direction: (3,) unit vector from the object to the camera; the scene's own
        where None.  The camera's kind of projection is kept.
        """
        camera = self.renderer.GetActiveCamera()
        towards = self.direction if direction is None else direction
        parallel = bool(camera.GetParallelProjection())
        view = fit_view(self._points, towards, aspect, _FRAMED, parallel)
        camera.SetPosition(*view.position.tolist())
        camera.SetFocalPoint(*view.focus.tolist())
        camera.SetViewUp(*view.up.tolist())
        camera.SetViewAngle(float(np.degrees(view.angle)))
        camera.SetParallelScale(view.half_height)
        self.renderer.ResetCameraClippingRange()
        self.follow()

    def follow(self) -> None:
        """Turn the corner's axes as the scene's camera is turned."""
        camera, corner = self.renderer.GetActiveCamera(), self.overlay.GetActiveCamera()
        direction = np.subtract(camera.GetPosition(), camera.GetFocalPoint())
        corner.SetFocalPoint(0.0, 0.0, 0.0)
        corner.SetPosition(*(direction / np.linalg.norm(direction)).tolist())
        corner.SetViewUp(*camera.GetViewUp())
        corner.ParallelProjectionOn()
        self.overlay.ResetCamera(-0.3, 1.1, -0.3, 1.1, -0.3, 1.1)

    def show_cursor(self, name: str, s: float) -> None:
        """Put a ball on a pass, s metres along it; none where there is no such pass."""
        strips = [fitted.strip for fitted in self._result.passes if fitted.name == name]
        self._cursor.SetVisibility(bool(strips))
        if strips:
            strip = strips[0]
            (at,) = interpolated(np.array([s]), strip.s, strip.points)
            self._cursor.SetPosition(*at.tolist())

    def _add(self, prop: vtkProp) -> None:
        self.renderer.AddViewProp(prop)

    def _table(self, fixed: tuple[float, float] | None) -> tuple[vtkLookupTable | None, float]:
        values = _uncertainty(self._result)
        if values is None:
            return None, 0.0
        low, high, step = round_range(*(fixed or (float(values.min()), float(values.max()))))
        return actors.look_up_table(low, high), step

    def _add_surface(self, table: vtkLookupTable | None) -> None:
        if self._result.surface is None:
            return
        data = actors.surface_data(self._result.surface.mesh)
        coloured = self._result.surface.mesh.sigma is not None
        self._add(actors.surface_actor(data, table if coloured else None))
        self._add(actors.border_actor(data, self._paper.ink))

    def _add_passes(self, table: vtkLookupTable | None) -> None:
        bare = table if self._result.surface is None else None
        for kind, colour in (("pass", self._paper.run), ("tie", self._paper.tie)):
            some = [fitted for fitted in self._result.passes if fitted.kind == kind]
            if some:
                curves = [fitted.strip.points for fitted in some]
                sigma = [fitted.position_sigma for fitted in some]
                self._add(actors.tube_actor(curves, self._thickness * _TUBE, colour, sigma, bare))
                if bare is None:
                    self._key.append((f"━ {kind}", colour))
        every = -(-len(self._result.passes) // _MOST_LABELS)
        rightwards = np.cross((0.0, 0.0, 1.0), self.direction)
        for fitted in self._result.passes[::every]:
            before = -fitted.strip.tangents[0]
            at = fitted.strip.points[0] + 0.02 * self._size * before
            side = actors.side_of(float(before @ rightwards))
            ink = self._paper.ink
            self._add(actors.label_actor(fitted.name, at, self._font_size, side, ink))

    def _add_survey(self) -> None:
        mark = self._paper.mark
        places = {fitted.name: fitted for fitted in self._result.passes}
        points, spans = [], []
        for seen in self._result.survey:
            ends = _observed(seen, places)
            if seen.kind == "distance":
                spans.append(ends)
            elif len(ends):
                points.append(ends.mean(axis=0))
        if points:
            self._add(actors.sphere_actor(np.array(points), self._thickness * _BALL, mark))
            self._key.append(("● mark or crossing", mark))
        if spans:
            self._add(actors.line_actor(spans, mark, 1.5))
            self._key.append(("─ measured distance", mark))

    def _add_floor(self) -> None:
        low, high = self._points.min(axis=0), self._points.max(axis=0)
        step = round_step(float(max(high[:2] - low[:2])), _CELLS)
        underneath = self.direction[2] > 0
        gap = 0.03 * self._size
        level = low[2] - gap if underneath else high[2] + gap
        lines = _grid(np.floor(low[:2] / step) * step, np.ceil(high[:2] / step) * step, step, level)
        self._add(actors.line_actor(lines, self._paper.grid, 1.0))
        self._points = np.concatenate((self._points, *lines))
        self._key.append((f"┼ grid, {step * 1e3:g} mm", self._paper.grid_words))


def _lights(from_above: bool) -> vtkLightKit:
    """Key, fill and back light that go with the camera, the key on the visible side."""
    lights = vtkLightKit()
    side = 1.0 if from_above else -1.0
    lights.SetKeyLightElevation(50.0 * side)
    lights.SetFillLightElevation(-75.0 * side)
    return lights


def _extent(result: Reconstruction) -> FloatArray:
    """(n, 3) points among which everything lies."""
    points = [fitted.strip.points for fitted in result.passes]
    if result.surface is not None:
        points.append(result.surface.mesh.vertices)
    return np.concatenate(points)


def _uncertainty(result: Reconstruction) -> FloatArray | None:
    """(n,) millimetres: what the colours stand for, or None where nothing is known."""
    if result.surface is None:
        return np.concatenate([fitted.position_sigma for fitted in result.passes]) * 1e3
    sigma = result.surface.mesh.sigma
    return None if sigma is None else sigma * 1e3


def _observed(seen: SurveyResidual, places: dict[str, FittedPass]) -> FloatArray:
    """(passes, 3) fitted points that an observation of the survey speaks of."""
    strips = [places[name].strip for name in seen.passes]
    found = [
        interpolated(np.array([at]), strip.s, strip.points)
        for strip, at in zip(strips, seen.at, strict=True)
    ]
    return np.concatenate(found)


def _grid(low: FloatArray, high: FloatArray, step: float, level: float) -> list[FloatArray]:
    """Lines of a level square grid from corner to corner, as (2, 3) arrays."""
    lines = []
    for axis in (0, 1):
        for at in np.arange(low[axis], high[axis] + step / 2, step):
            ends = np.full((2, 3), level)
            ends[:, axis] = at
            ends[:, 1 - axis] = low[1 - axis], high[1 - axis]
            lines.append(ends)
    return lines
