"""How often the daily check is right, fault by fault, and what the plans of poses give.

Each ribbon is calibrated on a bent bar over a tilted table by a careless hand; then,
fixed anew on the same bar, it is checked by three poses, with a fault or without.

    .venv/bin/python benchmarks/daily_check.py [--ribbons N]
"""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from support.tables import met, publish, table

from georibbon.arrays import FloatArray
from georibbon.calibration import calibrate
from georibbon.calibration.check import CHECK_POSES, Check, check_calibration
from georibbon.calibration.expected import PLAN_ERRORS
from georibbon.calibration.model import Calibration
from georibbon.calibration.plans import PLANS, AskedPose
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
SEAT = 0.1  # degrees an axis, of every sensor when the ribbon is fixed on the bar anew
FRAMES = 100


class Case:
    """One ribbon with its bar, calibrated by a plan."""

    def __init__(self, seed: int, plan: int = 20) -> None:
        self.settings = SimulationSettings(
            seed=seed,
            frames=FRAMES,
            dip=DIP,
            ribbon=RibbonSettings(),
            poses=PoseSettings(plan=plan),
        )
        streams = error_streams(seed)
        self.rng = np.random.default_rng(seed + 10_000)
        self.bench = make_bench(self.settings, streams)
        self.bar = set_bar(self.settings.poses, len(self.bench.ribbon.sensors), streams.pose)
        with one_thread():
            poses = self.poses(self.bench, PLANS[plan], 0.0)
            self.calibration: Calibration = calibrate(self.bench.ribbon, poses)

    def poses(
        self,
        bench: Bench,
        plan: tuple[AskedPose, ...],
        seat: float,
        beside: dict[int, FloatArray] | None = None,
    ) -> list[Pose]:
        """The poses as recorded; beside: what a magnet adds at the sensors, by pose."""
        slips = draw_slips(self.settings.poses, len(plan), self.rng)
        frames = self.bar.attitudes(plan, slips)
        frames = frames @ small_rotations(seat, frames.shape[1], self.rng)
        return [
            Pose(
                f"roll {pose[0]:g}, heading {pose[1]:g}, pitch {pose[2]:g}",
                *pose,
                bench.read(found, self.rng, (beside or {}).get(place)),
            )
            for place, (pose, found) in enumerate(zip(plan, frames, strict=True))
        ]

    def check(self, bench: Bench, beside: dict[int, FloatArray] | None = None) -> Check:
        """The daily check of a bench that may have changed."""
        poses = self.poses(bench, CHECK_POSES, SEAT, beside)
        with one_thread():
            return check_calibration(bench.ribbon, self.calibration, poses)

    def altered(self, name: str, turn: FloatArray, bias: FloatArray) -> Bench:
        """The bench with a sensor turned (degrees) and its bias changed (units)."""
        models = []
        for sensor, model in zip(self.bench.ribbon.sensors, self.bench.models, strict=True):
            changed = replace(
                model,
                gain=model.gain @ exp(np.radians(turn)),
                bias=model.bias + sensor.counts_per_unit * bias[: sensor.axes],
            )
            models.append(changed if model.name == name else model)
        return replace(self.bench, models=tuple(models))

    def direction(self) -> FloatArray:
        """(3,) a unit vector that may be any."""
        drawn = self.rng.standard_normal(3)
        return np.asarray(drawn / np.linalg.norm(drawn))


def _names(check: Check) -> set[str | None]:
    return {notice.sensor for notice in check.findings if notice.sensor is not None}


def _turned(case: Case, name: str, degrees: float) -> bool:
    check = case.check(case.altered(name, degrees * case.direction(), np.zeros(3)))
    return _names(check) == {name}


def _shifted(case: Case, name: str, bias: float) -> bool:
    level = case.direction() * [1.0, 1.0, 0.0]
    level /= np.linalg.norm(level)
    check = case.check(case.altered(name, np.zeros(3), bias * level))
    return _names(check) == {name}


def _elsewhere(case: Case, dip: float, strength: float) -> bool:
    field = strength * field_direction(float(np.radians(dip)))
    check = case.check(replace(case.bench, field=field))
    return not check.undisturbed and not _names(check)


def _dead(case: Case) -> bool:
    settings = replace(case.settings, faults=FaultSettings(dead=("M05",)))
    return _names(case.check(replace(case.bench, settings=settings))) == {"M05"}


def _steel(case: Case) -> bool:
    sensors = len(case.bench.ribbon.sensors)
    near = 1.0 + 0.5 * np.linspace(-1.0, 1.0, sensors)[:, None]
    beside = {int(case.rng.integers(3)): 0.2 * near * case.direction()}
    return bool(case.check(case.bench, beside).again)


FAULTS: dict[str, tuple[str, float, Callable[[Case], bool]]] = {
    "none": ("good", 0.95, lambda case: case.check(case.bench).verdict == "good"),
    "A07 turned by 2°": ("A07 alone", 0.95, lambda case: _turned(case, "A07", 2.0)),
    "M05 turned by 2°": ("M05 alone", 0.9, lambda case: _turned(case, "M05", 2.0)),
    "A07 turned by 1°": ("A07 alone", 0.8, lambda case: _turned(case, "A07", 1.0)),
    "A07's bias by 20 mg": ("A07 alone", 0.95, lambda case: _shifted(case, "A07", 0.02)),
    "M05's hard iron by 8 %": ("M05 alone", 0.95, lambda case: _shifted(case, "M05", 0.08)),
    "M05 dead": ("M05 alone", 0.95, _dead),
    "a field 5 % stronger": ("the place", 0.95, lambda case: _elsewhere(case, DIP, 1.05)),
    "a field 5° flatter": ("the place", 0.95, lambda case: _elsewhere(case, DIP - 5.0, 1.0)),
    "steel near one pose, 20 %": ("a pose again", 0.95, _steel),
}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ribbons", type=int, default=20, help="ribbons, each with every fault")
    ribbons = parser.parse_args().ribbons
    cases = [Case(seed) for seed in range(ribbons)]
    rows = []
    for fault, (wanted, least, right) in FAULTS.items():
        share = float(np.mean([right(case) for case in cases]))
        rows.append((fault, f"{wanted} in {least:.0%}", f"{share:.0%}", met(share >= least)))
    plans = []
    for plan, expected in PLAN_ERRORS.items():
        found = [Case(seed, plan).calibration.quality for seed in range(max(ribbons // 2, 1))]
        tilt, heading = (
            float(np.mean([getattr(one, name) for one in found])) for name in ("tilt", "heading")
        )
        fine = abs(tilt - expected[0]) < 0.03 and abs(heading - expected[1]) < 0.05
        told = f"{expected[0]:.2f}° and {expected[1]:.2f}°"
        plans.append((f"{plan} poses", told, f"{tilt:.2f}° and {heading:.2f}°", met(fine)))
    publish(
        "daily_check",
        [
            table(("fault", "asked", "found", "verdict"), rows),
            table(("plan", "tilt and heading as told", "predicted", "verdict"), plans),
        ],
    )


if __name__ == "__main__":
    main()
