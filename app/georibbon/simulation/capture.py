"""A virtual capture: the ribbon made, calibrated, laid, read, and the survey taken."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from georibbon.arrays import FloatArray
from georibbon.calibration.model import Calibration, SensorModel
from georibbon.errors import SettingsError
from georibbon.geometry.frames import Strip
from georibbon.recording import Pass, PassKind, Pose, Recording, Workpiece
from georibbon.ribbon import Readings, Ribbon
from georibbon.rotations import about_z
from georibbon.simulation.forward import expected_counts, sample_counts
from georibbon.simulation.layout import lay_passes
from georibbon.simulation.poses import asked_poses, draw_slips, set_bar
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
class Streams:
    """Where the errors of one capture are drawn, each kind from a stream of its own.

    make: the sensors; pose: the calibration; lay: contact; read: noise on the
    passes; measure: the survey; turn: the workpiece's heading.
    """

    make: np.random.Generator
    pose: np.random.Generator
    lay: np.random.Generator
    read: np.random.Generator
    measure: np.random.Generator
    turn: np.random.Generator


@dataclass(frozen=True, eq=False)
class Bench:
    """What every file of one capture shares.

    models: the sensors' true models.  field: (3,) the unit field in the world.
    yaw: degrees, world = Rz(yaw) workpiece.
    """

    settings: SimulationSettings
    ribbon: Ribbon
    models: tuple[SensorModel, ...]
    field: FloatArray
    yaw: float

    @property
    def positions(self) -> FloatArray:
        """(n,) metres from the ribbon's start to each sensor."""
        return np.array([sensor.position for sensor in self.ribbon.sensors])

    @property
    def calibration(self) -> Calibration:
        """The true models as a calibration."""
        return Calibration(self.ribbon.id, float(np.radians(self.settings.dip)), self.models)

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
        faults = self.settings.faults
        spoil(counts, self.ribbon, faults.dead, faults.lost, rng)
        t = np.round(np.arange(self.settings.frames) / self.ribbon.rate, 6)
        return Readings(t, counts)


def error_streams(seed: int) -> Streams:
    """The streams of a seed."""
    seeds = np.random.SeedSequence(seed).spawn(6)
    return Streams(*(np.random.default_rng(one) for one in seeds))


def make_bench(settings: SimulationSettings, streams: Streams) -> Bench:
    """The ribbon with its true models, and the world; draws from `make` and `turn`."""
    ribbon = virtual_ribbon(settings.ribbon)
    models = true_models(ribbon, settings.ribbon, streams.make)
    field = field_direction(float(np.radians(settings.dip)))
    drawn = float(np.round(streams.turn.uniform(-180.0, 180.0), 2))
    yaw = drawn if settings.yaw is None else settings.yaw
    return Bench(settings, ribbon, models, field, yaw)


def simulate(settings: SimulationSettings) -> Simulation:
    """The recording and truth of a virtual capture; the same for the same settings.

    Raises `SettingsError` where a setting means nothing, `SurfaceError` where
    the surface is too sharply bent for geodesics to be followed.
    """
    streams = error_streams(settings.seed)
    bench = make_bench(settings, streams)
    strips, truth = lay_on_surface(bench)
    check_names(settings.faults, bench.ribbon, strips)
    recording = Recording(
        ribbon=bench.ribbon,
        poses=_poses(bench, streams.pose),
        passes=_passes(bench, strips, streams),
        marks=measure_marks(strips, settings.survey, streams.measure),
        distances=measure_distances(strips, settings.survey, streams.measure),
        crossings=measure_crossings(strips, settings.survey, streams.measure),
        workpiece=Workpiece(True, bench.yaw if settings.tell_heading else None),
        title=title_of(settings),
    )
    return Simulation(recording, truth)


def lay_on_surface(bench: Bench) -> tuple[dict[str, Strip], Truth]:
    """The passes and ties on the settings' reference surface, and the truth of them.

    Raises `SettingsError` where there is no such surface, or one runs off it.
    """
    settings = bench.settings
    surface = make_surface(settings.surface, settings.parameters)
    kind = surface_kind(settings.surface)
    strips = lay_passes(surface, kind, settings.layout, settings.ribbon.length)
    parameters = {**kind.parameters, **settings.parameters}
    coarse = thinned(strips)
    truth = Truth(settings.surface, coarse, bench.yaw, parameters, surface, bench.calibration)
    return strips, truth


def check_names(faults: FaultSettings, ribbon: Ribbon, strips: Mapping[str, Strip]) -> None:
    """Raise `SettingsError` where a fault names what is not there."""
    known = {sensor.name for sensor in ribbon.sensors}
    for name in faults.dead:
        if name not in known:
            last = ribbon.sensors[-1].name
            raise SettingsError(f"dead sensor {name!r}: the ribbon has A01, M01 to {last}")
    if faults.magnet > 0 and faults.magnet_on not in strips:
        raise SettingsError(f"a magnet on {faults.magnet_on!r}: the passes are {', '.join(strips)}")


def title_of(settings: SimulationSettings) -> str:
    """The title given, or one that tells the surface and the passes."""
    if settings.title is not None:
        return settings.title
    return f"{settings.surface}, {settings.layout.passes} passes, {settings.layout.ties} ties"


def _poses(bench: Bench, rng: np.random.Generator) -> tuple[Pose, ...]:
    """The calibration poses as recorded."""
    plan = asked_poses(bench.settings.poses)
    bar = set_bar(bench.settings.poses, len(bench.ribbon.sensors), rng)
    true = bar.attitudes(plan, draw_slips(bench.settings.poses, len(plan), rng))
    return tuple(
        Pose(
            f"roll {roll:g}, heading {heading:g}, pitch {pitch:g}",
            *(float(roll), float(heading), float(pitch)),
            table,
            bench.read(frames, rng),
        )
        for (roll, heading, pitch, table), frames in zip(plan, true, strict=True)
    )


def _passes(bench: Bench, strips: Mapping[str, Strip], streams: Streams) -> tuple[Pass, ...]:
    """The passes and ties as recorded."""
    passes = []
    for name, strip in strips.items():
        frames = laid_frames(bench, strip, streams.lay)
        disturbance = _magnet(bench, name)
        kind: PassKind = "tie" if name.startswith("T") else "pass"
        passes.append(Pass(name, kind, bench.read(frames, streams.read, disturbance)))
    return tuple(passes)


def laid_frames(bench: Bench, strip: Strip, rng: np.random.Generator) -> FloatArray:
    """(n, 3, 3) the sensors' frames, ribbon to world, laid on a strip of the workpiece.

    Each sensor's contact with the surface is a little off, drawn from `rng`.
    """
    frames = about_z(np.radians(bench.yaw)) @ frames_at(strip, bench.positions)
    contact = bench.settings.layout.contact
    return np.asarray(frames @ small_rotations(contact, len(bench.positions), rng))


def frames_at(strip: Strip, s: FloatArray) -> FloatArray:
    """(n, 3, 3) a strip's frames at distances s (n,): splined entrywise, made orthonormal."""
    u, _, vt = np.linalg.svd(CubicSpline(strip.s, strip.frames)(s))
    return np.asarray(u @ vt, dtype=np.float64)


def _magnet(bench: Bench, name: str) -> FloatArray | None:
    """(n, 3) what the magnet beside a pass adds to the field at each sensor."""
    faults = bench.settings.faults
    if faults.magnet == 0 or name != faults.magnet_on:
        return None
    middle = bench.ribbon.length / 2 if faults.magnet_place is None else faults.magnet_place
    return magnet_field(bench.positions, faults.magnet, middle, faults.magnet_reach)


def magnet_field(
    positions: FloatArray, share: float, place: float | FloatArray, reach: float
) -> FloatArray:
    """(..., n, 3) what a magnet adds to the field at positions (n,), in units of the field.

    share: its greatest; place (...): metres along the ribbon; reach: metres.
    """
    away = (positions - np.asarray(place)[..., None]) / reach
    # Flat over the magnet and steep at its ends, as a magnet held close looks.
    share_there = share * np.exp(-(away**6))
    direction = np.array([0.8, -0.36, 0.48])
    return np.asarray(share_there[..., None] * direction)


def spoil(
    counts: FloatArray,
    ribbon: Ribbon,
    dead: Collection[str],
    lost: float,
    rng: np.random.Generator,
) -> None:
    """Dead sensors say 0, the share `lost` of all values is NaN; counts (m, c) in place."""
    for sensor, columns in zip(ribbon.sensors, ribbon.slices, strict=True):
        if sensor.name in dead:
            counts[:, columns] = 0.0
    if lost > 0:
        counts[rng.random(counts.shape) < lost] = np.nan


def thinned(strips: Mapping[str, Strip]) -> dict[str, Strip]:
    """The strips at about every `TRUTH_STEP` metres, their ends kept."""
    return {name: _thinned(strip) for name, strip in strips.items()}


def _thinned(strip: Strip) -> Strip:
    n = round(strip.s[-1] / TRUTH_STEP) + 1
    index = np.unique(np.rint(np.linspace(0, len(strip.s) - 1, n)).astype(np.int64))
    return Strip(strip.s[index], strip.points[index], strip.frames[index])
