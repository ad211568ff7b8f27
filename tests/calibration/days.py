"""A virtual ribbon that is calibrated on one day and checked on another."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from georibbon.calibration import calibrate
from georibbon.calibration.check import CHECK_POSES, check_calibration
from georibbon.calibration.model import Calibration
from georibbon.calibration.plans import PLANS
from georibbon.recording import Pose
from georibbon.rotations import exp
from georibbon.simulation.capture import Bench, error_streams, make_bench
from georibbon.simulation.poses import draw_slips, set_bar
from georibbon.simulation.settings import (
    FaultSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
)
from georibbon.simulation.virtual import small_rotations
from georibbon.threads import one_thread
from georibbon.world import field_direction

DIP = 65.0
FRAMES = 100


@dataclass
class Ribbon:
    """A ribbon, its bar and table, by a seed.  axes: of the magnetometers."""

    seed: int = 0
    sensors: int = 16
    axes: int = 2
    plan: int = 20

    def __post_init__(self):
        self.settings = SimulationSettings(
            seed=self.seed,
            frames=FRAMES,
            dip=DIP,
            ribbon=RibbonSettings(sensors=self.sensors, magnetometer_axes=self.axes),
            poses=PoseSettings(plan=self.plan),
        )
        self.rng = np.random.default_rng(1000 + self.seed)
        streams = error_streams(self.seed)
        self.bench = make_bench(self.settings, streams)
        self.ribbon = self.bench.ribbon
        self.bar = set_bar(self.settings.poses, self.sensors, streams.pose)

    def poses(self, plan, bench=None, seat=0.0, disturbance=None):
        """The plan's poses as recorded; seat: degrees an axis, of the ribbon fixed anew.

        disturbance: {place of the pose: (n, 3) in the world, of the field}.
        """
        bench = bench or self.bench
        true = self.bar.attitudes(plan, draw_slips(self.settings.poses, len(plan), self.rng))
        true = true @ small_rotations(seat, self.sensors, self.rng)
        beside = disturbance or {}
        return [
            Pose(
                f"roll {roll:g}, heading {heading:g}, pitch {pitch:g}",
                *(float(roll), float(heading), float(pitch)),
                table,
                bench.read(frames, self.rng, beside.get(place)),
            )
            for place, ((roll, heading, pitch, table), frames) in enumerate(
                zip(plan, true, strict=True)
            )
        ]

    @cached_property
    def calibration(self) -> Calibration:
        """Of the first day."""
        return self.calibrated()

    def calibrated(self, bench=None, seat=0.0) -> Calibration:
        """A calibration by the plan."""
        with one_thread():
            return calibrate(self.ribbon, self.poses(PLANS[self.plan], bench, seat))

    def changed(self, name, turn=(0.0, 0.0, 0.0), bias=(0.0, 0.0, 0.0)) -> Bench:
        """The bench with one sensor turned (degrees about x, y, z) or its bias changed (units)."""
        models = list(self.bench.models)
        place = [model.name for model in models].index(name)
        old, unit = models[place], self.ribbon.sensors[place].counts_per_unit
        axes = len(old.bias)
        models[place] = replace(
            old,
            gain=old.gain @ exp(np.radians(turn)),
            bias=old.bias + unit * np.asarray(bias)[:axes],
        )
        return replace(self.bench, models=tuple(models))

    def in_field(self, dip, strength=1.0) -> Bench:
        """The bench in another field."""
        return replace(self.bench, field=strength * field_direction(float(np.radians(dip))))

    def with_dead(self, name) -> Bench:
        """The bench with a sensor that says nothing any more."""
        return replace(self.bench, settings=replace(self.settings, faults=FaultSettings((name,))))

    def check(self, bench=None, seat=0.1, disturbance=None, plan=CHECK_POSES):
        """The daily check."""
        poses = self.poses(plan, bench, seat, disturbance)
        return check_calibration(self.ribbon, self.calibration, poses)
