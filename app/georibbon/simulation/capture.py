"""A virtual capture: the ribbon made, calibrated, laid, read, and the survey taken."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration, SensorModel
from georibbon.calibration.plans import PLANS
from georibbon.errors import SettingsError
from georibbon.geometry.frames import Strip
from georibbon.recording import Pass, PassKind, Pose, Recording, Workpiece
from georibbon.ribbon import Readings, Ribbon
from georibbon.rotations import about_z
from georibbon.simulation.forward import expected_counts, sample_counts
from georibbon.simulation.layout import lay_passes
from georibbon.simulation.poses import attitudes
from georibbon.simulation.settings import FaultSettings, SimulationSettings
from georibbon.simulation.surfaces import make_surface, surface_kind
from georibbon.simulation.survey import measure_crossings, measure_distances, measure_marks
from georibbon.simulation.truth import Truth
from georibbon.simulation.virtual import noise_counts, small_rotations, true_models, virtual_ribbon
from georibbon.world import field_direction

TRUTH_STEP = 0.01


@dataclass(frozen=True, eq=False)
class Simulation:
    """A virtual capture: what was recorded, and the truth."""

    recording: Recording
    truth: Truth


@dataclass(frozen=True, eq=False)
class _Bench:
    """What every file of one capture shares."""

    settings: SimulationSettings
    ribbon: Ribbon
    models: tuple[SensorModel, ...]
    field: FloatArray

    def read(
        self,
        frames: FloatArray,
        rng: np.random.Generator,
        disturbance: FloatArray | None = None,
    ) -> Readings:
        """One file: sensor frames (n, 3, 3), ribbon to world."""
        expected = expected_counts(self.ribbon, self.models, frames, self.field, disturbance)
        noise = noise_counts(self.ribbon, self.settings.ribbon)
        counts = sample_counts(expected, noise, self.settings.frames, rng)
        _spoil(counts, self.ribbon, self.settings.faults, rng)
        t = np.round(np.arange(self.settings.frames) / self.ribbon.rate, 6)
        return Readings(t, counts)


def simulate(settings: SimulationSettings) -> Simulation:
    """The recording and truth of a virtual capture; the same for the same settings.

    Raises `SettingsError` where a setting means nothing, `SurfaceError` where
    the surface is too sharply bent for geodesics to be followed.
    """
    streams = [
        np.random.default_rng(seed) for seed in np.random.SeedSequence(settings.seed).spawn(6)
    ]
    make, pose, lay, read, measure, turn = streams
    ribbon = virtual_ribbon(settings.ribbon)
    models = true_models(ribbon, settings.ribbon, make)
    dip = float(np.radians(settings.dip))
    bench = _Bench(settings, ribbon, models, field_direction(dip))
    yaw = float(np.round(turn.uniform(-180.0, 180.0), 2)) if settings.yaw is None else settings.yaw
    surface = make_surface(settings.surface, settings.parameters)
    kind = surface_kind(settings.surface)
    strips = lay_passes(surface, kind, settings.layout, settings.ribbon.length)
    _check_names(settings, ribbon, strips)
    recording = Recording(
        ribbon=ribbon,
        poses=_poses(bench, pose),
        passes=_passes(bench, strips, yaw, lay, read),
        marks=measure_marks(strips, settings.survey, measure),
        distances=measure_distances(strips, settings.survey, measure),
        crossings=measure_crossings(strips, settings.survey, measure),
        workpiece=Workpiece(True, yaw if settings.tell_heading else None),
        title=_title(settings),
    )
    parameters = {**kind.parameters, **settings.parameters}
    coarse = {name: _thinned(strip) for name, strip in strips.items()}
    calibration = Calibration(ribbon.id, dip, models)
    truth = Truth(settings.surface, coarse, yaw, parameters, surface, calibration)
    return Simulation(recording, truth)


def _check_names(settings: SimulationSettings, ribbon: Ribbon, strips: Mapping[str, Strip]) -> None:
    """Raise `SettingsError` where a fault names what is not there."""
    known = {sensor.name for sensor in ribbon.sensors}
    for name in settings.faults.dead:
        if name not in known:
            last = ribbon.sensors[-1].name
            raise SettingsError(f"dead sensor {name!r}: the ribbon has A01, M01 to {last}")
    if settings.faults.magnet > 0 and settings.faults.magnet_on not in strips:
        raise SettingsError(
            f"a magnet on {settings.faults.magnet_on!r}: the passes are {', '.join(strips)}"
        )


def _title(settings: SimulationSettings) -> str:
    if settings.title is not None:
        return settings.title
    return f"{settings.surface}, {settings.layout.passes} passes, {settings.layout.ties} ties"


def _poses(bench: _Bench, rng: np.random.Generator) -> tuple[Pose, ...]:
    """The calibration poses; the bar's bend at each sensor is the same in all."""
    care = bench.settings.poses
    plan = care.poses or PLANS.get(care.plan, ())
    bend = small_rotations(care.bend, len(bench.ribbon.sensors), rng)
    true = attitudes(plan, care.heading_care, care.pitch_care, care.table_tilt, rng)
    return tuple(
        Pose(
            f"roll {roll:g}, heading {heading:g}, pitch {pitch:g}",
            *(float(roll), float(heading), float(pitch)),
            table,
            bench.read(attitude @ bend, rng),
        )
        for (roll, heading, pitch, table), attitude in zip(plan, true, strict=True)
    )


def _passes(
    bench: _Bench,
    strips: Mapping[str, Strip],
    yaw: float,
    lay: np.random.Generator,
    read: np.random.Generator,
) -> tuple[Pass, ...]:
    """The passes and ties, each sensor's contact with the surface a little off."""
    turn = about_z(np.radians(yaw))
    positions = np.array([sensor.position for sensor in bench.ribbon.sensors])
    contact = bench.settings.layout.contact
    passes = []
    for name, strip in strips.items():
        frames = turn @ frames_at(strip, positions)
        frames = frames @ small_rotations(contact, len(positions), lay)
        disturbance = _magnet(bench, name, positions)
        kind: PassKind = "tie" if name.startswith("T") else "pass"
        passes.append(Pass(name, kind, bench.read(frames, read, disturbance)))
    return tuple(passes)


def frames_at(strip: Strip, s: FloatArray) -> FloatArray:
    """(n, 3, 3) a strip's frames at distances s (n,): splined entrywise, made orthonormal."""
    u, _, vt = np.linalg.svd(CubicSpline(strip.s, strip.frames)(s))
    return np.asarray(u @ vt, dtype=np.float64)


def _magnet(bench: _Bench, name: str, positions: FloatArray) -> FloatArray | None:
    """(n, 3) what the magnet beside a pass adds to the field at each sensor."""
    faults = bench.settings.faults
    if faults.magnet == 0 or name != faults.magnet_on:
        return None
    middle = bench.ribbon.length / 2 if faults.magnet_place is None else faults.magnet_place
    # Flat over the magnet and steep at its ends, as a magnet held close looks.
    share = faults.magnet * np.exp(-(((positions - middle) / faults.magnet_reach) ** 6))
    direction = np.array([0.8, -0.36, 0.48])
    return np.asarray(share[:, None] * direction)


def _spoil(
    counts: FloatArray, ribbon: Ribbon, faults: FaultSettings, rng: np.random.Generator
) -> None:
    """Dead sensors say 0, lost values are NaN; in place."""
    for sensor, columns in zip(ribbon.sensors, ribbon.slices, strict=True):
        if sensor.name in faults.dead:
            counts[:, columns] = 0.0
    if faults.lost > 0:
        counts[rng.random(counts.shape) < faults.lost] = np.nan


def _thinned(strip: Strip) -> Strip:
    """The strip at about every `TRUTH_STEP` metres, its end kept."""
    n = round(strip.s[-1] / TRUTH_STEP) + 1
    index = np.unique(np.rint(np.linspace(0, len(strip.s) - 1, n)).astype(np.int64))
    return Strip(strip.s[index], strip.points[index], strip.frames[index])
