"""What can be asked of a result by pointing at it: places, distances, sections.

Nothing here is drawn; a window asks along a line of sight, a test as it likes.
"""

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator

from georibbon.arrays import FloatArray
from georibbon.errors import SurfaceError
from georibbon.geometry.curvature import Curvature
from georibbon.geometry.frames import curvatures, unit
from georibbon.geometry.mesh import Mesh
from georibbon.geometry.surface import Surface
from georibbon.mesh_geodesics import shortest_path
from georibbon.reconstruction import FittedPass, Reconstruction
from georibbon.scene.buffers import Triangles
from georibbon.scene.colouring import along_passes, is_grid, surface_curvature
from georibbon.scene.shapes import Solid
from georibbon.world import UP

_LEAST_ANGLE = 1e-6  # sine between two directions below which they span no plane


@dataclass(frozen=True, eq=False)
class Pick:
    """A place on the surface, or on a pass where there is no surface.

    position: (3,) m, in the workpiece frame.  normal: (3,) unit.  sigma: m, the
    position's standard deviation (root of the covariance's trace), None where it
    is not known.  pass_name, s: the nearest pass or tie and the place along it, m;
    away: how far off that is, m.  gaussian (1/m²), mean, along (1/m; along the
    passes): the curvature there, positive towards the normal; None where it is
    not known.  on: the mesh's triangle and the (3,) barycentric weights of its
    corners; None on a pass alone.
    """

    position: FloatArray
    normal: FloatArray
    sigma: float | None
    pass_name: str
    s: float
    away: float
    gaussian: float | None
    mean: float | None
    along: float | None
    on: tuple[int, FloatArray] | None = None


@dataclass(frozen=True, eq=False)
class Distance:
    """How far two places lie from each other, m.

    sigma: the standard deviation of `straight`, as though both ends erred
    independently of each other; None where it is not known.
    along: the length of the shortest way over the surface near by, and path its
    (n, 3) points; None and no points where both are not on one surface.
    """

    first: Pick
    second: Pick
    straight: float
    sigma: float | None
    along: float | None
    path: FloatArray


@dataclass(frozen=True, eq=False)
class Section:
    """The line in which a plane through two places cuts the surface.

    points: (n, 3) m, in the workpiece frame.  s: (n,) m along the line, 0 at the
    first place and growing towards the second.  across, height: (n,) m, in the
    plane, from the first place: towards the second (level in an upright plane)
    and square to that (straight up in an upright plane).  length: m, of all of
    it; between: m along it from the first place to the second, None where the
    second lies on another part of the surface.  upright: whether the plane is.
    """

    first: Pick
    second: Pick
    points: FloatArray
    s: FloatArray
    across: FloatArray
    height: FloatArray
    length: float
    between: float | None
    upright: bool


class Probe:
    """One result, asked by lines of sight."""

    def __init__(self, result: Reconstruction) -> None:
        self.result = result
        self._surface = result.surface

    def hit(self, start: FloatArray, end: FloatArray, reach: float) -> Pick | None:
        """What a line of sight from `start` to `end`, (3,) m, meets first; None if nothing.

        Of a result without a surface, or beside it, the curve that the line passes
        nearest to, within `reach` metres.
        """
        met = None if self._surface is None else self._meet(start, end)
        return met if met is not None else self._brush(start, end, reach)

    def place(self, triangle: int, weights: FloatArray) -> Pick:
        """A place on the surface's mesh: (3,) weights of a triangle's corners."""
        surface = self._required()
        mesh, corners = surface.mesh, surface.mesh.triangles[triangle]
        position = weights @ mesh.vertices[corners]
        owner, s, away = self._nearest(position)
        sigma = None if mesh.sigma is None else float(weights @ mesh.sigma[corners])
        bend = self._curvature
        return Pick(
            position,
            unit(weights @ mesh.normals[corners]),
            sigma,
            owner.name,
            s,
            away,
            _finite(weights @ bend.gaussian[corners]),
            _finite(weights @ bend.mean[corners]),
            None if self._along is None else _finite(weights @ self._along[corners]),
            (triangle, weights),
        )

    def distance(self, first: Pick, second: Pick) -> Distance:
        """How far two places lie apart; the way over the surface may take a second."""
        apart = second.position - first.position
        straight = float(np.linalg.norm(apart))
        both = [self._variance_along(one, unit(apart)) for one in (first, second)]
        known = [variance for variance in both if variance is not None]
        sigma = float(np.sqrt(sum(known))) if len(known) == 2 else None
        path = np.empty((0, 3))
        if self._surface is not None and first.on is not None and second.on is not None:
            mesh = self._surface.mesh
            path = shortest_path(mesh.vertices, mesh.triangles, first.on, second.on)
        along = float(_arc(path)[-1]) if len(path) else None
        return Distance(first, second, straight, sigma, along, path)

    def section(self, first: Pick, second: Pick, sight: FloatArray | None = None) -> Section:
        """The cut through two places, upright, or along a line of sight (3,).

        Raises SurfaceError where the places do not determine the plane, where it
        misses the surface, as beside it on a tie, or where there is none.
        """
        mesh = self._required().mesh
        inside = UP if sight is None else unit(sight)
        apart = second.position - first.position
        normal = np.cross(apart, inside)
        if np.linalg.norm(normal) <= _LEAST_ANGLE * (np.linalg.norm(apart) or 1.0):
            raise SurfaceError(
                "the two places lie above one another and determine no plane: choose two that "
                "are apart as seen along the plane"
            )
        normal = unit(normal)
        across = np.cross(inside, normal) if sight is None else unit(apart)
        height = np.cross(normal, across)
        chains = cut(mesh, first.position, normal)
        if not chains:
            raise SurfaceError(
                "the plane through the two places does not meet the surface: choose places on it"
            )
        away = [_nearest_on(chain, first.position) for chain in chains]
        best = int(np.argmin([gap for gap, _ in away]))
        points, arc = chains[best], _arc(chains[best])
        gap, at = _nearest_on(points, second.position)
        begin = away[best][1]
        if at < begin:
            points, arc = points[::-1], arc[-1] - arc[::-1]
            begin, at = arc[-1] - begin, arc[-1] - at
        relative = points - first.position
        size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
        return Section(
            first, second, points, arc - begin, relative @ across, relative @ height,
            float(arc[-1]), float(at - begin) if gap < 1e-6 * size else None, sight is None,
        )  # fmt: skip

    def _required(self) -> Surface:
        if self._surface is None:
            raise SurfaceError(
                "there is no surface to be cut yet, at least two passes are needed: lay another"
            )
        return self._surface

    def _meet(self, start: FloatArray, end: FloatArray) -> Pick | None:
        t: Any = mutable(0.0)  # written to, as no plain number can be
        sub: Any = mutable(0)
        cell: Any = mutable(0)
        x, parametric = [0.0] * 3, [0.0] * 3
        locator, _ = self._locator
        if not locator.IntersectWithLine(
            start.tolist(), end.tolist(), 1e-9, t, x, parametric, sub, cell
        ):
            return None
        r, s = parametric[:2]
        return self.place(int(cell), np.array([1.0 - r - s, r, s]))

    def _brush(self, start: FloatArray, end: FloatArray, reach: float) -> Pick | None:
        """The place on a pass that a line of sight passes nearest to."""
        along = unit(end - start)
        found: tuple[float, FittedPass, int] | None = None
        for fitted in self.result.passes:
            apart = np.linalg.norm(np.cross(fitted.strip.points - start, along), axis=1)
            k = int(np.argmin(apart))
            if apart[k] <= reach and (found is None or apart[k] < found[0]):
                found = float(apart[k]), fitted, k
        return None if found is None else _on_pass(found[1], found[2])

    def _nearest(self, position: FloatArray) -> tuple[FittedPass, float, float]:
        """The pass or tie nearest to a place, where along it, m, and how far off, m."""
        found = []
        for fitted in self.result.passes:
            away, arc = _nearest_on(fitted.strip.points, position)
            chord = _arc(fitted.strip.points)
            found.append((away, fitted, float(np.interp(arc, chord, fitted.strip.s))))
        away, owner, s = min(found, key=lambda one: one[0])
        return owner, s, away

    def _variance_along(self, pick: Pick, direction: FloatArray) -> float | None:
        """m²: a place's variance in a direction, shared out as the nearest pass's is."""
        if pick.sigma is None:
            return None
        owner = next(one for one in self.result.passes if one.name == pick.pass_name)
        nearest = int(np.argmin(np.abs(owner.strip.s - pick.s)))
        covariance = owner.covariance[nearest]
        trace = float(np.trace(covariance))
        share = float(direction @ covariance @ direction) / trace if trace > 0.0 else 1.0 / 3.0
        return share * pick.sigma**2

    @cached_property
    def _locator(self) -> tuple[vtkStaticCellLocator, vtkPolyData]:
        """VTK's search tree over the mesh, and the data that it stands on."""
        mesh = self._required().mesh
        body = Triangles(0.0)
        body.show(Solid(mesh.vertices, mesh.normals, mesh.triangles))
        locator = vtkStaticCellLocator()
        locator.SetDataSet(body.data)
        locator.BuildLocator()
        self._held = body  # its arrays
        return locator, body.data

    @cached_property
    def _curvature(self) -> Curvature:
        return surface_curvature(self._required())

    @cached_property
    def _along(self) -> FloatArray | None:
        surface = self._required()
        return self._curvature.along(along_passes(surface)) if is_grid(surface) else None


def section_table(section: Section) -> str:
    """A section as CSV: s, across, height, x, y, z, one row a point, in metres."""
    rows = np.column_stack((section.s, section.across, section.height, section.points))
    lines = [",".join(f"{value:.10g}" for value in row) for row in rows.tolist()]
    return "\n".join(("s,across,height,x,y,z", *lines, ""))


def _on_pass(fitted: FittedPass, k: int) -> Pick:
    strip = fitted.strip
    return Pick(
        strip.points[k], strip.normals[k], float(fitted.position_sigma[k]), fitted.name,
        float(strip.s[k]), 0.0, None, None, float(curvatures(strip)[0][k]),
    )  # fmt: skip


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _arc(points: FloatArray) -> FloatArray:
    """(n,) m along a polyline (n, 3)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate(([0.0], np.cumsum(steps)))


def _nearest_on(points: FloatArray, position: FloatArray) -> tuple[float, float]:
    """How far a polyline (n, 3) is from a place (3,), and where along it that is, m."""
    steps = np.diff(points, axis=0)
    squared = np.sum(steps * steps, axis=1)
    share = np.sum((position - points[:-1]) * steps, axis=1) / np.where(squared > 0, squared, 1.0)
    share = np.clip(share, 0.0, 1.0)
    away = np.linalg.norm(points[:-1] + share[:, None] * steps - position, axis=1)
    k = int(np.argmin(away))
    arc = _arc(points)
    return float(away[k]), float(arc[k] + share[k] * (arc[k + 1] - arc[k]))


def cut(mesh: Mesh, origin: FloatArray, normal: FloatArray) -> list[FloatArray]:
    """The polylines (n, 3) in which a plane cuts a mesh; a closed one ends at its start.

    origin: (3,) m, a point of the plane; normal: (3,) unit.
    """
    side = (mesh.vertices - origin) @ normal
    side[np.abs(side) < 1e-12] = 1e-12  # a vertex in the plane counts as above it
    edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    crossing = (side[edges[:, 0]] > 0) != (side[edges[:, 1]] > 0)
    pairs, number = np.unique(np.sort(edges[crossing], axis=1), axis=0, return_inverse=True)
    ratio = side[pairs[:, 0]] / (side[pairs[:, 0]] - side[pairs[:, 1]])
    low, high = mesh.vertices[pairs[:, 0]], mesh.vertices[pairs[:, 1]]
    nodes = low + ratio[:, None] * (high - low)
    return [nodes[chain] for chain in _chains(number.reshape(-1, 2).tolist())]


def _chains(segments: list[list[int]]) -> list[list[int]]:
    """Pairs of numbers joined to chains where they meet."""
    beside: dict[int, list[int]] = defaultdict(list)
    for a, b in segments:
        beside[a].append(b)
        beside[b].append(a)
    ends = [node for node, others in beside.items() if len(others) == 1]
    left, chains = set(beside), []
    for start in [*ends, *beside]:
        if start not in left:
            continue
        chain = [start]
        left.discard(start)
        while following := [node for node in beside[chain[-1]] if node in left]:
            chain.append(following[0])
            left.discard(following[0])
        if len(chain) > 2 and chain[0] in beside[chain[-1]]:
            chain.append(chain[0])
        chains.append(chain)
    return [chain for chain in chains if len(chain) > 1]
