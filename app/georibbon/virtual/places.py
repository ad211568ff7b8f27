"""Where the ribbon can be: the passes and ties of a surface or mesh, and the calibration poses.

The true sensor models, the passes, the contact of the first laying of each, the
attitudes of the first time in each pose and the survey are those of `simulate`
with the same settings; a pass laid again, or a pose done again, is a little
different, as with any hand.
"""

from collections.abc import Mapping

import numpy as np

from georibbon.arrays import FloatArray
from georibbon.calibration.plans import AskedPose
from georibbon.errors import SettingsError
from georibbon.geometry.frames import Strip
from georibbon.recording import Recording, Workpiece
from georibbon.session.folder import toml_text
from georibbon.session.outline import MOST_TABLE_PITCH, Survey, tables_of
from georibbon.session.words import nearest, told
from georibbon.simulation.capture import (
    Bench,
    Streams,
    check_names,
    laid_frames,
    lay_on_surface,
    thinned,
    title_of,
)
from georibbon.simulation.poses import asked_poses, draw_slips, set_bar
from georibbon.simulation.survey import measure_crossings, measure_distances, measure_marks
from georibbon.simulation.truth import Truth
from georibbon.virtual.body import Magnet
from georibbon.virtual.mesh import lay_on_mesh, read_mesh
from georibbon.virtual.settings import MeshSettings, check_number

MESH_CROSSING = 0.002
"""Metres by which two smoothed curves on a mesh may miss each other where they cross."""


class Places:
    """The places of one virtual capture."""

    def __init__(self, bench: Bench, streams: Streams, mesh: MeshSettings | None) -> None:
        """Lays all passes; raises `SettingsError` where one does not fit the surface."""
        simulation = bench.settings
        self._bench = bench
        self._strips, self.truth = _laid(mesh, bench)
        check_names(simulation.faults, bench.ribbon, self._strips)
        self._again = streams.turn
        self._laid = {
            name: laid_frames(bench, strip, streams.lay) for name, strip in self._strips.items()
        }
        self.poses = asked_poses(simulation.poses)
        self._bar = set_bar(simulation.poses, len(bench.ribbon.sensors), streams.pose)
        slips = draw_slips(simulation.poses, len(self.poses), streams.pose)
        true = self._bar.attitudes(self.poses, slips)
        self._posed: dict[int, FloatArray] = dict(enumerate(true))
        tolerance = 1e-6 if mesh is None else MESH_CROSSING
        self.survey: Survey = (
            measure_marks(self._strips, simulation.survey, streams.measure),
            measure_distances(self._strips, simulation.survey, streams.measure),
            measure_crossings(self._strips, simulation.survey, streams.measure, tolerance),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The passes, P1, P2, ..., and the ties, T1, ..."""
        return tuple(self._strips)

    def laid(self, name: str) -> FloatArray:
        """(n, 3, 3) the sensors' frames on a pass or tie; `SettingsError` where there is none."""
        if name not in self._strips:
            hint = nearest(name, self.names) or f"; there are {', '.join(self.names)}"
            raise SettingsError(f"there is no pass {told(name)}{hint}")
        if name in self._laid:
            return self._laid.pop(name)
        return laid_frames(self._bench, self._strips[name], self._again)

    def magnet(self, name: str) -> Magnet | None:
        """The magnet that the settings put beside a pass."""
        faults = self._bench.settings.faults
        if faults.magnet == 0 or name != faults.magnet_on:
            return None
        length = self._bench.ribbon.length
        place = length / 2 if faults.magnet_place is None else faults.magnet_place
        return Magnet(faults.magnet, place, faults.magnet_reach)

    def posed(self, number: int) -> FloatArray:
        """(n, 3, 3) the sensors' frames in a pose of the plan, counted from 1; `SettingsError`."""
        if not 1 <= number <= len(self.poses):
            there = f"there are 1 to {len(self.poses)}" if self.poses else "no pose is planned"
            raise SettingsError(f"there is no pose {number}; {there}")
        if number - 1 in self._posed:
            return self._posed.pop(number - 1)
        return self.posed_as(self.poses[number - 1])

    def posed_as(self, asked: AskedPose) -> FloatArray:
        """(n, 3, 3) the sensors' frames in any pose, carelessly done; `SettingsError`."""
        _check_pose(asked)
        slips = draw_slips(self._bench.settings.poses, 1, self._again)
        return np.asarray(self._bar.attitudes((asked,), slips)[0])

    def plan_text(self) -> str:
        """A plan file, TOML, for a capture of all this."""
        simulation = self._bench.settings
        workpiece = Workpiece(True, self._bench.yaw if simulation.tell_heading else None)
        tables = tables_of(Recording(self._bench.ribbon, (), (), *self.survey, workpiece), ())
        plan = {
            "format": "georibbon-plan",
            "version": 1,
            "title": title_of(simulation),
            # A list of poses has no place in a plan file.
            "poses": 0 if simulation.poses.poses else simulation.poses.plan,
            "passes": simulation.layout.passes,
            "ties": simulation.layout.ties,
        }
        kept = ("workpiece", "mark", "distance", "crossing")
        return toml_text(plan | {key: tables[key] for key in kept})


def _check_pose(asked: AskedPose) -> None:
    roll, heading, pitch, table = asked
    check_number("roll (degrees)", roll, -360.0, 360.0)
    check_number("heading (degrees)", heading, -360.0, 360.0)
    most = MOST_TABLE_PITCH if table else 90.0
    check_number("pitch on the table (degrees)" if table else "pitch (degrees)", pitch, -most, most)


def _laid(mesh: MeshSettings | None, bench: Bench) -> tuple[Mapping[str, Strip], Truth]:
    """The passes and ties, and the truth of them."""
    if mesh is None:
        return lay_on_surface(bench)
    simulation = bench.settings
    strips = lay_on_mesh(read_mesh(mesh), simulation.layout, simulation.ribbon.length)
    coarse = thinned(strips)
    truth = Truth(simulation.surface, coarse, bench.yaw, calibration=bench.calibration)
    return strips, truth
