"""The scene of one result: it owns the renderers and actors and serves any render window."""

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np
from vtkmodules.vtkRenderingCore import vtkLight, vtkLightKit, vtkRenderer, vtkRenderWindow

from georibbon.arrays import FloatArray
from georibbon.geometry.frames import interpolated, unit
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.scene import actors, overlays, places, shapes
from georibbon.scene.buffers import Lines
from georibbon.scene.camera import Region, fit_view, view_direction
from georibbon.scene.colouring import (
    SIGNED,
    Look,
    pass_values,
    range_of,
    scene_values,
)
from georibbon.scene.colours import (
    WHITE,
    Colour,
    Paper,
    quantity_table,
    round_step,
    signed_table,
    zebra_table,
)
from georibbon.scene.drawing import CaptureDrawing
from georibbon.scene.passes import Tubes, whole
from georibbon.scene.words import Words
from georibbon.scene.zebra import stripes
from georibbon.world import UP

_MOST_LABELS = 12
_TUBE, _BALL = 0.0022, 0.0060  # radii as shares of the object's diagonal,
_CURSOR, _SENSOR, _LIVE, _AXIS = 0.011, 0.0042, 0.0042, 0.018
_MOST_FULL = 16  # of up to so many passes; more are drawn thinner, not to hide the surface
_FRAMED = Region(left=0.91, right=0.60, bottom=0.90, top=0.90)
_CELLS = 12  # of the floor's grid along the object's longer side, at most
_SAME_SIZE = 1.25  # an object that grows or shrinks by less keeps its tubes' and its floor's size
_FINE_BALLS = 60
_LIT = 3  # lights of the kit: from the camera, the key and the fill
_LOOSE = 0.25  # of the diagonal, by which a ribbon in the hand may leave the floor
_GAP = 0.03  # from the object to the floor, as a share of its diagonal


KeyLine = tuple[str, str, Colour]  # a sign, what it means, and their colour


class Scene:
    """Surface, passes, ties, survey points, floor, axes and scalar bar of one result.

    The surface is coloured by what the look asks for, at first by its position
    uncertainty (square root of the covariance's trace); without a surface the
    passes are.  font_size: pixels.  uncertainty_range: millimetres, to compare
    results with one another; from the data where None.  paper: the ground and
    what is drawn on it.  line_scale: pixels that a line one pixel wide takes on a
    dense screen.  z of the workpiece is up.

    `update` shows another result in the place of the one that is shown, in the
    same arrays where their sizes are the same.
    """

    def __init__(
        self,
        reconstruction: Reconstruction | None,
        font_size: int = 14,
        uncertainty_range: tuple[float, float] | None = None,
        paper: Paper = WHITE,
        look: Look | None = None,
        line_scale: float = 1.0,
    ) -> None:
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(*paper.background)
        self.overlay = overlays.axes_renderer(font_size, paper.axes, line_scale)
        self.direction = view_direction(UP[None])
        self._paper = paper
        self._look = look or Look()
        if uncertainty_range is not None:
            fixed = (uncertainty_range[0] * 1e-3, uncertainty_range[1] * 1e-3)
            self._look = replace(self._look, ranges={"uncertainty": fixed})
        self._result: Reconstruction | None = None
        self._drawing = CaptureDrawing()
        self._cursor_at: tuple[str, float] | None = None
        self._held: tuple[int, tuple[str, ...]] = (0, ())  # what the box is of
        self._box = np.empty((0, 3))  # the corners that the floor was made for
        self._size = self._thickness = 0.0
        self._range: tuple[float, float] = (0.0, 1.0)
        self._make_actors(line_scale)
        self._make_tables()
        self._words = Words(self.renderer, font_size)
        self._bar = overlays.ScalarBar(font_size, paper.ink)
        self.renderer.AddViewProp(self._bar.actor)
        self._cross = overlays.cross(font_size, paper.tool)
        self.renderer.AddViewProp(self._cross)
        self._key = overlays.Key(self.renderer, font_size)
        self._lights = vtkLightKit()
        self._lights.AddLightsToRenderer(self.renderer)
        lights = self.renderer.GetLights()
        for k in range(_LIT, lights.GetNumberOfItems()):
            # Those behind light edges alone, and cost as much as the others.
            cast("vtkLight", lights.GetItemAsObject(k)).SwitchOff()
        self.update(reconstruction)

    @property
    def look(self) -> Look:
        """What is chosen of it."""
        return self._look

    @property
    def range(self) -> tuple[float, float]:
        """(low, high) that the colours stand for, in the mode's SI unit."""
        return self._range

    @property
    def result(self) -> Reconstruction | None:
        """What is shown."""
        return self._result

    # --- what is shown ---

    def update(self, reconstruction: Reconstruction | None) -> bool:
        """Show this result instead; whether the floor, and so what fits, has changed."""
        first = self._result is None
        self._result = reconstruction
        if reconstruction is not None and first:
            normals = [fitted.strip.normals for fitted in reconstruction.passes]
            self.direction = view_direction(np.concatenate(normals))
        return self._show()

    def show_capture(self, drawing: CaptureDrawing | None) -> bool:
        """Show a capture's curves besides; whether the floor has changed."""
        self._drawing = drawing or CaptureDrawing()
        return self._show()

    def apply(self, look: Look) -> None:
        """Take up another look."""
        before, self._look = self._look, look
        keyed = "deviation" in (look.colouring, before.colouring)  # the key tells of it
        if keyed or look.shown != before.shown or look.symbol != before.symbol:
            self._show()
        else:
            self._colour()

    def show_cursor(self, name: str, s: float) -> None:
        """Put a ball on a pass, s metres along it; none where there is no such pass."""
        self._cursor_at = (name, s)
        strips = [one.strip for one in self._passes() if one.name == name]
        self._cursor.actor.SetVisibility(bool(strips))
        if strips:
            strip = strips[0]
            at = interpolated(np.array([s]), strip.s, strip.points)
            self._cursor.show(shapes.stamped(shapes.ball(), at, self._size * _CURSOR))

    def show_marks(self, points: FloatArray, curves: Sequence[FloatArray]) -> None:
        """Show what is pointed at, (n, 3), and measured, curves of (n, 3) points each."""
        self._tool_points.actor.SetVisibility(len(points) > 0)
        if len(points):
            size = 0.7 * self._size * _BALL  # no balls, as the survey's marks are
            self._tool_points.show(shapes.stamped(shapes.die(), points, size))
        self._tool_lines.actor.SetVisibility(len(curves) > 0)
        self._tool_lines.show(curves)

    def show_cross(self, shown: bool) -> None:
        """Show where the middle of the picture is."""
        self._cross.SetVisibility(shown)

    # --- where it is seen ---

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
        points = np.concatenate((*self._extent(), self._floor.points))
        view = fit_view(points, towards, aspect, _FRAMED, parallel)
        camera.SetPosition(*view.position.tolist())
        camera.SetFocalPoint(*view.focus.tolist())
        camera.SetViewUp(*view.up.tolist())
        camera.SetViewAngle(float(np.degrees(view.angle)))
        camera.SetParallelScale(view.half_height)
        self.renderer.ResetCameraClippingRange()
        self.follow()

    def follow(self) -> None:
        """Turn what goes with the scene's camera as it is turned: the axes, words and stripes."""
        camera, corner = self.renderer.GetActiveCamera(), self.overlay.GetActiveCamera()
        direction = np.subtract(camera.GetPosition(), camera.GetFocalPoint())
        corner.SetFocalPoint(0.0, 0.0, 0.0)
        corner.SetPosition(*(direction / np.linalg.norm(direction)).tolist())
        corner.SetViewUp(*camera.GetViewUp())
        corner.ParallelProjectionOn()
        self.overlay.ResetCamera(-0.3, 1.1, -0.3, 1.1, -0.3, 1.1)
        self._words.follow(camera)
        window = self.renderer.GetRenderWindow()
        if window is not None:
            overlays.place_axes(self.overlay, self._key.follow(window))
        if self._look.colouring == "zebra":
            self._stripe()

    # --- making ---

    def _make_actors(self, line_scale: float) -> None:
        paper = self._paper
        self._surface = actors.skin()
        self._border = Lines(paper.ink, 1.5 * line_scale)
        self._runs = {
            "passes": Tubes(paper.run, line_scale),
            "ties": Tubes(paper.tie, line_scale),
            "taken passes": Tubes(paper.run, line_scale),
            "taken ties": Tubes(paper.tie, line_scale),
            "neighbour": Tubes(paper.neighbour, line_scale),
            "live": Tubes(paper.live, line_scale),
        }
        self._marks = actors.solid_of(paper.mark)
        self._spans = Lines(paper.mark, 1.5 * line_scale)
        self._sensors = actors.solid_of(paper.sensor)
        self._unused = actors.solid_of(paper.unused)
        self._axes = [Lines(colour, 2.0 * line_scale) for colour in paper.axes]
        self._floor = Lines(paper.grid, line_scale)
        self._cursor = actors.solid_of(paper.ink)
        self._tool_points = actors.solid_of(paper.tool, ambient=0.6)
        self._tool_lines = Lines(paper.tool, 3.0 * line_scale)
        self._tool_lines.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._tool_lines.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-4.0, -4.0)
        bodies = [self._surface, self._border]
        bodies += [body for run in self._runs.values() for body in (run.body, run.thin)]
        bodies += [self._marks, self._spans, self._sensors, self._unused, *self._axes]
        bodies += [self._floor, self._cursor, self._tool_points, self._tool_lines]
        for body in bodies:
            self.renderer.AddActor(body.actor)
        for hidden in (self._cursor, self._tool_points, self._tool_lines):
            hidden.actor.VisibilityOff()

    def _make_tables(self) -> None:
        blank = self._paper.blank
        self._tables = {
            "quantity": actors.look_up_table(quantity_table(), blank),
            "signed": actors.look_up_table(signed_table(), blank),
            "zebra": actors.look_up_table(zebra_table(), blank),
        }
        self._tables["zebra"].SetRange(-1.0, 1.0)

    # --- showing ---

    def _show(self) -> bool:
        new_floor = self._measure()
        self._show_surface()
        self._show_passes()
        self._show_capture()
        self._show_sensors()
        lines = [*self._show_survey(), *self._show_live_key()]
        if new_floor:
            self._show_floor()
        self._floor.actor.SetVisibility("floor" in self._look.shown)
        self._show_labels()
        self._show_key(lines)
        self._colour()
        if self._cursor_at is not None:
            self.show_cursor(*self._cursor_at)
        return new_floor

    def _passes(self) -> tuple[FittedPass, ...]:
        return () if self._result is None else self._result.passes

    def _extent(self) -> list[FloatArray]:
        """Points among which everything lies."""
        points = [*self._lasting(), *self._live()]
        return points or [np.array([[-0.5, -0.3, 0.0], [0.5, 0.3, 0.0]])]

    def _lasting(self) -> list[FloatArray]:
        """Points of all but what is being laid."""
        points = [fitted.strip.points for fitted in self._passes()]
        if self._result is not None and self._result.surface is not None:
            points.append(self._result.surface.mesh.vertices)
        return points + [curve for _, _, curve in self._drawn()]

    def _live(self) -> list[FloatArray]:
        """The points of what is being laid, if anything is seen of it."""
        live = self._drawing.live
        return [live[1]] if live is not None and whole(live[1]) else []

    def _measure(self) -> bool:
        """Take the object's size; whether it is another than the floor was made for.

        A ribbon in the hand may go a little beyond the floor, and come back,
        without another.
        """
        low, high = _box(self._extent())
        size = float(np.linalg.norm(high - low)) or 1.0
        held = (id(self._result), tuple(name for name, _, _ in self._drawing.passes))
        another, self._held = held != self._held, held
        fits = len(self._box) > 0 and all(
            self._is_inside(points, margin)
            for points, margin in ((self._lasting(), 0.5 * _GAP), (self._live(), _LOOSE))
        )
        if another and size * _SAME_SIZE < self._size:
            fits = False
        if not fits:
            self._box, self._size = np.stack((low, high)), size
        count = len(self._passes()) + len(self._drawing.passes)
        self._thickness = self._size * min(1.0, _MOST_FULL / max(count, 1))
        return not fits

    def _is_inside(self, points: list[FloatArray], margin: float) -> bool:
        """Whether points lie in the floor's box, or beyond it by this share of its diagonal."""
        if not points:
            return True
        (low, high), beyond = _box(points), margin * self._size
        return bool(np.all(low >= self._box[0] - beyond) and np.all(high <= self._box[1] + beyond))

    def _show_surface(self) -> None:
        surface = None if self._result is None else self._result.surface
        shown = surface is not None and "surface" in self._look.shown
        self._surface.actor.SetVisibility(shown)
        self._border.actor.SetVisibility(shown)
        if surface is not None:
            mesh = surface.mesh
            self._surface.show(shapes.Solid(mesh.vertices, mesh.normals, mesh.triangles))
            self._border.show(places.border(surface))

    def _show_passes(self) -> None:
        for kind, part in (("pass", "passes"), ("tie", "ties")):
            curves = [one.strip.points for one in self._passes() if one.kind == kind]
            self._runs[part].show(curves, self._thickness * _TUBE)
            self._runs[part].set_visible(part in self._look.shown)

    def _drawn(self) -> list[tuple[str, str, FloatArray]]:
        """The capture's curves that the result does not hold."""
        held = {one.name for one in self._passes()}
        return [one for one in self._drawing.passes if one[0] not in held and whole(one[2])]

    def _show_capture(self) -> None:
        neighbour = self._drawing.neighbour
        drawn = [one for one in self._drawn() if one[0] != neighbour]
        for kind, part in (("pass", "passes"), ("tie", "ties")):
            curves = [points for _, of, points in drawn if of == kind]
            self._runs[f"taken {part}"].show(curves, self._thickness * _TUBE)
            self._runs[f"taken {part}"].set_visible(part in self._look.shown)
        beside = [points for name, _, points in self._drawn() if name == neighbour]
        beside += [one.strip.points for one in self._passes() if one.name == neighbour]
        self._runs["neighbour"].show(beside[:1], self._thickness * _TUBE * 1.5)
        self._runs["live"].show(self._live(), self._size * _LIVE)

    def _show_sensors(self) -> None:
        shown = self._look.shown
        found = None
        if self._result is not None and self._passes() and shown & {"sensors", "frames"}:
            found = places.sensor_places(self._result)
        size = self._thickness * _SENSOR
        for body, used in ((self._sensors, True), (self._unused, False)):
            at = np.empty((0, 3)) if found is None else found.points[found.used == used]
            seen = "sensors" in shown and len(at) > 0
            body.actor.SetVisibility(seen)
            if seen:
                solid = _ball_of(len(at)) if used else shapes.die()
                body.show(shapes.stamped(solid, at, size if used else 1.2 * size))
        for axis, lines in enumerate(self._axes):
            seen = found is not None and "frames" in shown
            lines.actor.SetVisibility(seen)
            if found is not None and seen:
                reach = self._thickness * _AXIS * found.frames[:, :, axis]
                lines.show(list(np.stack((found.points, found.points + reach), axis=1)))

    def _show_survey(self) -> list[KeyLine]:
        lines: list[KeyLine] = []
        mark = self._paper.mark
        found = None if self._result is None else places.survey_places(self._result)
        seen = found is not None and "marks" in self._look.shown
        size = self._thickness * _BALL
        solids = []
        if found is not None and seen:
            if len(found.points):
                solids.append((found.points, size))
                lines.append(("● ", "mark or crossing", mark))
            if len(found.spans):
                lines.append(("─ ", "measured distance", mark))
            if len(found.ends):
                solids.append((found.ends, 0.5 * size))
            self._spans.show([*found.gaps, *found.spans])
        self._spans.actor.SetVisibility(seen)
        self._marks.actor.SetVisibility(bool(solids))
        if solids:
            at = np.concatenate([points for points, _ in solids])
            sizes = np.concatenate([np.full(len(points), of) for points, of in solids])
            self._marks.show(shapes.stamped(_ball_of(len(at)), at, sizes))
        return lines

    def _show_live_key(self) -> list[KeyLine]:
        lines: list[KeyLine] = []
        if self._runs["live"].any:
            lines.append(("━ ", "being laid", self._paper.live))
        if self._runs["neighbour"].any:
            lines.append(("━ ", "its neighbour", self._paper.neighbour))
        return lines

    def _show_floor(self) -> None:
        low, high = self._box
        self._step = round_step(float(max((high - low)[:2])) or 1.0, _CELLS)
        underneath = self.direction[2] > 0
        gap = _GAP * self._size
        level = float(low[2] - gap if underneath else high[2] + gap)
        corners = (
            np.floor(low[:2] / self._step) * self._step,
            np.ceil(high[:2] / self._step) * self._step,
        )
        self._floor.show(places.grid(*corners, self._step, level))
        side = 1.0 if underneath else -1.0  # the key light comes from the visible side
        self._lights.SetKeyLightElevation(50.0 * side)
        self._lights.SetFillLightElevation(-75.0 * side)

    def _show_labels(self) -> None:
        self._words.set_visible("labels" in self._look.shown)
        ink, labels = self._paper.ink, []
        runs = [(one.name, one.strip.points) for one in self._passes()]
        runs += [(name, points) for name, _, points in self._drawn()]
        for name, points in runs[:: -(-len(runs) // _MOST_LABELS) or 1]:
            colour = self._paper.neighbour if name == self._drawing.neighbour else ink
            labels.append((name, *self._beside(points), colour))
        live = self._drawing.live
        if live is not None and self._runs["live"].any:
            labels.append((live[0], *self._beside(live[1]), self._paper.live))
        self._words.show(labels)

    def _beside(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where a curve's label stands, and which way that is from the curve."""
        before = unit(points[0] - points[1])
        return points[0] + 0.02 * self._size * before, before

    def _show_key(self, survey: list[KeyLine]) -> None:
        lines: list[KeyLine] = []
        bare = self._result is not None and self._result.surface is None
        coloured = bare and self._look.colouring in ("uncertainty", "normal")
        for kind, part, colour in (
            ("pass", "passes", self._paper.run),
            ("tie", "ties", self._paper.tie),
        ):
            runs = self._runs[part].any and not coloured
            if part in self._look.shown and (runs or self._runs[f"taken {part}"].any):
                lines.append(("━ ", kind, colour))
        lines += survey
        if self._sensors.actor.GetVisibility():
            lines.append(("○ ", "sensor", self._paper.ink))
        if self._unused.actor.GetVisibility():
            lines.append(("■ ", "sensor left out", self._paper.unused))
        compared = self._look.deviation if self._look.colouring == "deviation" else None
        if compared is not None and np.isnan(compared).any():
            lines.append(("■ ", "nothing to compare with", self._paper.grid_words))
        say = self._look.translate
        said = [(sign + say(words), colour) for sign, words, colour in lines]
        if "floor" in self._look.shown:
            cell = f"{self._step / self._look.metres:.4g} {self._look.symbol}"
            said.append(("┼ " + say("grid, {cell}").format(cell=cell), self._paper.grid_words))
        self._key.show(said)

    # --- colouring ---

    def _colour(self) -> None:
        """Colour by what the look asks for, in the arrays that are there."""
        result, look = self._result, self._look
        values = None if result is None else scene_values(result, look)
        known = values is not None and len(values) > 0
        self._bar.actor.SetVisibility(known)
        table = self._tables["signed" if look.colouring in SIGNED else "quantity"]
        if values is not None and known:
            low, high, step = range_of(values, look)
            table.SetRange(low, high)
            self._range = (low * look.unit, high * look.unit)
            self._bar.show(table, look.title, step)
        surface = None if result is None else result.surface
        if look.colouring == "zebra":
            self._stripe()
        elif surface is not None:
            of = None if values is None else values / look.unit
            self._surface.show_values(of, table)
        for kind, part in (("pass", "passes"), ("tie", "ties")):
            self._runs[part].colour_by(self._bare_values(kind), table)

    def _bare_values(self, kind: str) -> list[FloatArray] | None:
        """Each pass's values, in the unit that is shown, where there is no surface to colour."""
        if self._result is None or self._result.surface is not None:
            return None
        values = [
            pass_values(one, self._look.colouring) for one in self._passes() if one.kind == kind
        ]
        known = [one / self._look.unit for one in values if one is not None]
        return known if known and len(known) == len(values) else None

    def _stripe(self) -> None:
        if self._result is None or self._result.surface is None:
            return
        camera = self.renderer.GetActiveCamera()
        mesh = self._result.surface.mesh
        self._surface.show_values(stripes(mesh, camera), self._tables["zebra"])


def _box(points: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """(3,) the least and the greatest coordinates of points (n, 3)."""
    low = np.min([one.min(axis=0) for one in points], axis=0)
    high = np.max([one.max(axis=0) for one in points], axis=0)
    return low, high


def _ball_of(count: int) -> shapes.Solid:
    """A ball as fine as there is time for so many of them."""
    return shapes.ball() if count <= _FINE_BALLS else shapes.ball(cuts=1)
