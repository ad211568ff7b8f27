"""Virtual captures: what is recorded follows from the truth and the settings."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from georibbon.calibration.plans import PLANS
from georibbon.errors import SettingsError
from georibbon.geometry.closest import closest_point
from georibbon.simulation import (
    SURFACES,
    FaultSettings,
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    SurveySettings,
    simulate,
)
from georibbon.simulation.capture import frames_at
from georibbon.simulation.forward import expected_counts
from georibbon.simulation.layout import crossing, lay_passes
from georibbon.simulation.surfaces import make_surface, surface_kind
from georibbon.world import UP, field_direction

PERFECT = RibbonSettings(
    sensors=16,
    length=0.48,
    magnetometer_axes=3,
    acceleration_noise=0.0,
    field_noise=0.0,
    bias=0.0,
    scale=0.0,
    cross_axis=0.0,
    mounting=0.0,
    hard_iron=0.0,
    soft_iron=0.0,
)
SMALL = SimulationSettings(
    "saddle",
    ribbon=replace(PERFECT),
    poses=PoseSettings(plan=0),
    layout=LayoutSettings(passes=3, contact=0.0),
    frames=4,
    yaw=30.0,
)
REAL = replace(SMALL, ribbon=RibbonSettings(sensors=16, length=0.48), poses=PoseSettings())


def counts_of(recording):
    return [item.readings.counts for item in (*recording.poses, *recording.passes)]


def test_the_same_settings_give_the_same_capture():
    one, other = simulate(REAL), simulate(replace(REAL))
    for a, b in zip(counts_of(one.recording), counts_of(other.recording), strict=True):
        np.testing.assert_array_equal(a, b)
    assert one.recording.marks == other.recording.marks
    assert one.truth.yaw_degrees == other.truth.yaw_degrees


def test_another_seed_gives_other_errors_on_the_same_curves():
    one, other = simulate(replace(REAL, yaw=None)), simulate(replace(REAL, yaw=None, seed=2))
    assert one.truth.yaw_degrees != other.truth.yaw_degrees
    assert one.recording.marks != other.recording.marks
    assert not np.array_equal(counts_of(one.recording)[0], counts_of(other.recording)[0])
    for name, strip in one.truth.strips.items():
        np.testing.assert_array_equal(strip.points, other.truth.strips[name].points)


def test_what_is_changed_alone_changes():
    one = simulate(REAL)
    other = simulate(replace(REAL, survey=SurveySettings(("distances",)), poses=PoseSettings(20)))
    for a, b in zip(one.recording.passes, other.recording.passes, strict=True):
        np.testing.assert_array_equal(a.readings.counts, b.readings.counts)


@pytest.mark.parametrize("name", SURFACES)
def test_every_surface_has_a_capture(name):
    layout = LayoutSettings(passes=5, ties=2)
    found = simulate(SimulationSettings(name, layout=layout, frames=2, poses=PoseSettings(plan=0)))
    recording, truth = found.recording, found.truth
    assert [item.name for item in recording.passes] == ["P1", "P2", "P3", "P4", "P5", "T1", "T2"]
    assert [item.kind for item in recording.passes] == ["pass"] * 5 + ["tie"] * 2
    assert len(recording.marks) == 10
    assert len(recording.crossings) == 10
    for strip in truth.strips.values():
        on = closest_point(truth.shape, strip.points, grid=60)
        np.testing.assert_allclose(on.distance, 0.0, atol=1e-10)
        np.testing.assert_allclose(truth.shape.normals(on.uv), strip.normals, atol=1e-9)
        np.testing.assert_allclose(strip.s, np.linspace(0.0, 0.96, 97), atol=1e-12)
    starts = np.array([truth.strips[f"P{k}"].points[0] for k in range(1, 6)])
    ends = np.array([truth.strips[f"P{k}"].points[-1] for k in range(1, 6)])
    for row in (starts, ends):
        gaps = np.linalg.norm(np.diff(row, axis=0), axis=1)
        assert ((gaps > 0.05) & (gaps < 0.16)).all()


def test_an_elbows_passes_hang_underneath_and_face_sideways():
    strips = simulate(replace(REAL, surface="elbow", ribbon=RibbonSettings())).truth.strips
    up = np.concatenate([strip.normals[:, 2] for strip in strips.values()])
    assert up.min() < -0.9
    assert up.max() > -0.35


def test_the_ribbon_has_its_sensors_by_turns_half_a_pitch_from_its_ends():
    ribbon = simulate(replace(REAL, ribbon=RibbonSettings(sensors=32))).recording.ribbon
    assert [sensor.name for sensor in ribbon.sensors[:4]] == ["A01", "M01", "A02", "M02"]
    positions = [sensor.position for sensor in ribbon.sensors]
    np.testing.assert_allclose(positions, 0.015 + 0.03 * np.arange(32), atol=1e-12)
    assert len(ribbon.columns) == 16 * 3 + 16 * 2


def test_passes_lie_their_spacing_apart_in_their_middles_and_parallel_there():
    layout = LayoutSettings(passes=4, spacing=0.07, start=(0.1, -0.05), heading=40.0)
    kind = surface_kind("plane")
    strips = lay_passes(make_surface("plane", {}), kind, layout, 0.4)
    middles = np.array([strip.points[len(strip.s) // 2] for strip in strips.values()])
    np.testing.assert_allclose(np.linalg.norm(np.diff(middles, axis=0), axis=1), 0.07, atol=1e-9)
    np.testing.assert_allclose(middles.mean(axis=0), [0.1, -0.05, 0.0], atol=1e-9)
    along = np.array([np.cos(np.radians(40.0)), np.sin(np.radians(40.0)), 0.0])
    for strip in strips.values():
        np.testing.assert_allclose(strip.tangents, np.tile(along, (len(strip.s), 1)), atol=1e-9)


@pytest.mark.parametrize(
    ("kind", "turns"), [("alternate", [6.0, -6.0, 6.0]), ("spread", [6.0, 6.0, 6.0])]
)
def test_fanned_passes_turn_off_their_neighbours_by_the_angle_asked(kind, turns):
    layout = LayoutSettings(passes=4, fan=6.0, fan_kind=kind, heading=10.0)
    strips = lay_passes(make_surface("plane", {}), surface_kind("plane"), layout, 0.3)
    tangents = np.array([strip.tangents[0] for strip in strips.values()])
    angles = np.degrees(np.arctan2(tangents[:, 1], tangents[:, 0]))
    np.testing.assert_allclose(np.diff(angles), turns, atol=1e-7)
    assert abs(angles.mean() - 10.0) < 1e-7


def test_ties_cross_the_middle_pass_squarely_where_asked():
    layout = LayoutSettings(passes=3, ties=2, tie_places=(0.25, 0.8))
    strips = lay_passes(make_surface("dome", {}), surface_kind("dome"), layout, 0.8)
    for name, place in (("T1", 0.25), ("T2", 0.8)):
        at, along_tie = crossing(strips["P2"], strips[name])
        assert at == pytest.approx(place * 0.8, abs=1e-7)
        assert along_tie == pytest.approx(0.4, abs=1e-7)
        pair = (frames_at(strips[n], np.array([s]))[0] for n, s in (("P2", at), (name, along_tie)))
        tau, sigma = (frame[:, 0] for frame in pair)
        assert abs(tau @ sigma) < 1e-7


def test_strips_that_do_not_meet_have_no_crossing():
    strips = lay_passes(
        make_surface("plane", {}), surface_kind("plane"), LayoutSettings(passes=2), 0.4
    )
    assert crossing(strips["P1"], strips["P2"]) is None


def test_a_perfect_ribbon_says_its_frames():
    """Readings over counts per unit are up and field in the strip's frame, yaw applied."""
    found = simulate(SMALL)
    turn = Rotation.from_euler("z", 30.0, degrees=True).as_matrix()
    ribbon, field = found.recording.ribbon, field_direction(np.radians(SMALL.dip))
    kind = surface_kind("saddle")
    strips = lay_passes(make_surface("saddle", {}), kind, SMALL.layout, 0.48)
    for item in found.recording.passes:
        frames = turn @ frames_at(strips[item.name], np.array([s.position for s in ribbon.sensors]))
        for sensor, columns, frame in zip(ribbon.sensors, ribbon.slices, frames, strict=True):
            seen = UP if sensor.kind == "accelerometer" else field
            expected = sensor.counts_per_unit * (frame.T @ seen)
            np.testing.assert_allclose(item.readings.counts[2, columns], expected, atol=0.51)


def test_means_differ_from_the_true_models_by_noise_and_contact_alone():
    settings = replace(REAL, layout=replace(SMALL.layout, contact=0.0), frames=400)
    found = simulate(settings)
    ribbon = found.recording.ribbon
    turn = Rotation.from_euler("z", 30.0, degrees=True).as_matrix()
    strips = lay_passes(make_surface("saddle", {}), surface_kind("saddle"), settings.layout, 0.48)
    places = np.array([sensor.position for sensor in ribbon.sensors])
    sigma = np.concatenate([[16.384] * 3, [10.0] * 2] * 8) / np.sqrt(400)
    ratios = []
    for item in found.recording.passes:
        frames = turn @ frames_at(strips[item.name], places)
        models, field = found.truth.calibration.sensors, field_direction(np.radians(62.0))
        expected = expected_counts(ribbon, models, frames, field)
        ratios.append((item.readings.counts.mean(axis=0) - expected) / sigma)
    assert 0.85 < np.std(ratios) < 1.15
    noise = found.recording.passes[0].readings.counts.std(axis=0) / sigma / 20.0
    np.testing.assert_allclose(noise, 1.0, atol=0.2)


@pytest.mark.parametrize("degrees", [0.25, 1.0])
def test_contact_turns_each_sensor_by_the_angle_asked(degrees):
    layout = LayoutSettings(passes=12, spacing=0.02, contact=degrees)
    settings = replace(SMALL, surface="plane", layout=layout)
    found = simulate(settings)
    tilts = np.concatenate(
        [
            item.readings.counts[0, columns][:2] / 16384.0
            for item in found.recording.passes
            for sensor, columns in zip(
                found.recording.ribbon.sensors, found.recording.ribbon.slices, strict=True
            )
            if sensor.kind == "accelerometer"
        ]
    )
    assert np.degrees(np.std(tilts)) == pytest.approx(degrees, rel=0.2)


def test_magnitudes_of_the_true_models_are_as_asked():
    ribbon = RibbonSettings(sensors=256, length=7.68)
    settings = replace(SMALL, surface="plane", parameters={"size": 20.0}, ribbon=ribbon, frames=2)
    models = simulate(settings).truth.calibration.sensors
    accelerometers = [model for model in models if model.name.startswith("A")]
    magnetometers = [model for model in models if model.name.startswith("M")]
    gains = np.array([model.gain for model in accelerometers]) / 16384.0
    assert np.std([m.bias for m in accelerometers]) / 16384.0 == pytest.approx(0.03, rel=0.1)
    assert np.std([m.bias for m in magnetometers]) / 2000.0 == pytest.approx(0.3, rel=0.1)
    assert np.std(np.diagonal(gains, axis1=1, axis2=2)) == pytest.approx(0.02, rel=0.15)
    turned = (gains - np.swapaxes(gains, 1, 2))[:, [2, 0, 1], [1, 2, 0]] / 2
    # Mounting of 2 degrees, and the antisymmetric half of cross axes of 0.01.
    expected = np.hypot(np.radians(2.0), 0.01 / np.sqrt(2))
    assert np.std(turned) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("plan", PLANS)
def test_careful_poses_have_the_attitudes_asked(plan):
    care = PoseSettings(plan, heading_care=0.0, pitch_care=0.0, bend=0.0, table_tilt=0.0)
    recording = simulate(replace(SMALL, poses=care)).recording
    assert len(recording.poses) == plan
    field, found = [], []
    for pose in recording.poses:
        angles = [pose.heading, -pose.pitch, pose.roll]
        asked = Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()
        counts = pose.readings.counts[0]
        np.testing.assert_allclose(counts[:3] / 16384.0, asked.T @ UP, atol=1e-4)
        field.append(asked @ (counts[3:6] / 2000.0))
        found.append(tuple(pose.readings.counts[0]))
    # The field points one way in all, up to the one unknown rotation about the vertical.
    np.testing.assert_allclose(field, np.tile(field[0], (plan, 1)), atol=2e-3)


def test_every_plan_shows_four_faces_and_turns_the_bar():
    for plan in PLANS.values():
        table = [pose for pose in plan if pose[3]]
        assert {roll for roll, *_ in table} == {0.0, 90.0, 180.0, 270.0}
        assert len({heading % 360 for _, heading, *_ in table}) >= 2
        assert {pitch for _, _, pitch, on_table in plan if not on_table} == {40.0, -40.0}


def test_the_bars_bend_is_the_same_in_all_poses():
    care = PoseSettings(16, heading_care=0.0, pitch_care=0.0, bend=1.0, table_tilt=0.0)
    poses = simulate(replace(SMALL, poses=care)).recording.poses
    level = [pose for pose in poses if pose.roll == 0.0 and pose.table]
    columns = np.arange(0, 48, 6)
    one, other = (pose.readings.counts[0, columns] / 16384.0 for pose in level)
    np.testing.assert_allclose(one, other, atol=1e-4)
    assert np.degrees(one.std()) > 0.3


def test_carelessness_and_the_tables_tilt_are_as_asked():
    plan = tuple((0.0, 0.0, 30.0, False) for _ in range(300))
    care = PoseSettings(poses=plan, heading_care=10.0, pitch_care=3.0, bend=0.0)
    recording = simulate(replace(SMALL, poses=care)).recording
    means = np.array([pose.readings.counts[0] for pose in recording.poses])
    pitch = np.degrees(np.arcsin(np.clip(means[:, 0] / 16384.0, -1, 1)))
    assert pitch.mean() == pytest.approx(30.0, abs=1.0)
    assert pitch.std() == pytest.approx(3.0, rel=0.15)
    tilts = []
    for seed in range(30):
        care = PoseSettings(poses=((0.0, 0.0, 0.0, True),) * 2, table_tilt=2.0, bend=0.0)
        one, other = simulate(replace(SMALL, poses=care, seed=seed)).recording.poses
        tilts.append(one.readings.counts[0, :2] / 16384.0)
        assert np.linalg.norm(tilts[-1]) == pytest.approx(
            np.linalg.norm(other.readings.counts[0, :2] / 16384.0), abs=2e-4
        )
    assert np.degrees(np.std(tilts)) == pytest.approx(2.0, rel=0.3)


def test_marks_have_the_error_asked():
    survey = SurveySettings(("starts", "ends"), mark_sigma=0.002)
    layout = LayoutSettings(passes=60, spacing=0.01)
    found = simulate(replace(SMALL, surface="plane", survey=survey, layout=layout))
    errors = []
    for mark in found.recording.marks:
        strip = found.truth.strips[mark.pass_name]
        index = 0 if mark.at == 0.0 else -1
        assert mark.at == pytest.approx(strip.s[index])
        errors.append(np.array(mark.position) - strip.points[index])
    assert len(errors) == 120
    assert np.std(errors) == pytest.approx(0.002, rel=0.12)


@pytest.mark.parametrize(
    ("kinds", "marks", "distances"),
    [((), 0, 0), (("starts",), 3, 0), (("ends",), 3, 0), (("distances",), 0, 4)],
)
def test_the_survey_holds_what_is_asked(kinds, marks, distances):
    recording = simulate(replace(SMALL, survey=SurveySettings(kinds))).recording
    assert (len(recording.marks), len(recording.distances)) == (marks, distances)
    assert recording.crossings == ()


def test_distances_are_between_neighbouring_starts_and_ends():
    survey = SurveySettings(("distances",), distance_sigma=1e-6)
    found = simulate(replace(SMALL, survey=survey))
    for item in found.recording.distances:
        ends = [
            found.truth.strips[name].points[0 if at == 0.0 else -1]
            for name, at in zip(item.passes, item.at, strict=True)
        ]
        assert item.distance == pytest.approx(np.linalg.norm(ends[0] - ends[1]), abs=1e-5)


def test_crossings_have_the_error_asked_between_the_two_points():
    survey = SurveySettings((), crossing_sigma=0.001)
    layout = LayoutSettings(passes=20, spacing=0.015, ties=10, heading=0.0)
    recording = simulate(replace(SMALL, surface="plane", survey=survey, layout=layout)).recording
    assert len(recording.crossings) == 200
    first = np.array([item.at for item in recording.crossings])
    places = 0.48 * np.linspace(0.1, 0.9, 12)[1:-1]
    tie = np.array([int(item.passes[1][1:]) for item in recording.crossings])
    assert np.std(first[:, 0] - places[tie - 1]) == pytest.approx(0.001 / np.sqrt(2), rel=0.2)


def test_crossings_stay_on_the_ribbon():
    survey = SurveySettings((), crossing_sigma=0.05)
    layout = LayoutSettings(ties=2, tie_places=(0.0, 1.0), heading=0.0)
    recording = simulate(replace(SMALL, surface="plane", survey=survey, layout=layout)).recording
    at = np.array([item.at for item in recording.crossings])
    assert at.min() >= 0.0
    assert at.max() <= 0.48


def test_the_heading_is_told_only_when_asked():
    assert simulate(SMALL).recording.workpiece.heading is None
    assert simulate(replace(SMALL, tell_heading=True)).recording.workpiece.heading == 30.0


def test_titles():
    assert simulate(SMALL).recording.title == "saddle, 3 passes, 0 ties"
    assert simulate(replace(SMALL, title="a saddle")).recording.title == "a saddle"


def test_dead_sensors_say_nothing_in_any_file():
    recording = simulate(replace(REAL, faults=FaultSettings(dead=("M02",)))).recording
    columns = recording.ribbon.slices[3]
    for counts in counts_of(recording):
        np.testing.assert_array_equal(counts[:, columns], 0.0)
        assert (counts[:, : columns.start] != 0.0).any(axis=0).all()


def test_lost_values_are_as_many_as_asked():
    settings = replace(REAL, faults=FaultSettings(lost=0.1), frames=100)
    counts = np.concatenate(counts_of(simulate(settings).recording))
    assert np.isnan(counts).mean() == pytest.approx(0.1, rel=0.1)


def test_a_magnet_disturbs_about_four_magnetometers_of_its_pass():
    ribbon = replace(PERFECT, sensors=32, length=0.96)
    plain = replace(SMALL, ribbon=ribbon)
    magnet = replace(plain, faults=FaultSettings(magnet=0.25, magnet_on="P2"))
    one, other = simulate(plain).recording, simulate(magnet).recording
    for before, after in zip(one.passes, other.passes, strict=True):
        change = (after.readings.counts - before.readings.counts)[0]
        sizes = [np.linalg.norm(change[columns]) / 2000.0 for columns in one.ribbon.slices]
        moved = [k for k, size in enumerate(sizes) if size > 0.05]
        if before.name != "P2":
            assert not moved
            continue
        assert len(moved) == 4
        assert all(one.ribbon.sensors[k].kind == "magnetometer" for k in moved)
        assert max(sizes) == pytest.approx(0.25, abs=0.01)


def test_a_magnet_lies_where_it_is_put():
    faults = FaultSettings(magnet=0.25, magnet_on="P1", magnet_place=0.1, magnet_reach=0.04)
    one, other = simulate(SMALL).recording, simulate(replace(SMALL, faults=faults)).recording
    change = (other.passes[0].readings.counts - one.passes[0].readings.counts)[0]
    sizes = [np.linalg.norm(change[columns]) for columns in one.ribbon.slices]
    positions = np.array([sensor.position for sensor in one.ribbon.sensors])
    assert abs(positions[int(np.argmax(sizes))] - 0.1) <= 0.03


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"surface": "shoe"}, "no surface 'shoe'"),
        ({"parameters": {"bumps": 1.0}}, "no parameter 'bumps'"),
        ({"parameters": {"radius_x": np.nan}}, "radius_x is nan; give a value from 0.05 to 50"),
        ({"parameters": {"radius_y": 0.0}}, "radius_y is 0; give a value"),
        ({"layout": LayoutSettings(start=(0.99, 0.0))}, "P1 runs off"),
        ({"layout": LayoutSettings(start=(0.0, -1.1))}, "0,-1.1 is off the surface; .* -1 to 1"),
        ({"faults": FaultSettings(dead=("A99",))}, "A99"),
        ({"faults": FaultSettings(magnet=0.2, magnet_on="P9")}, "P9"),
    ],
)
def test_settings_that_do_not_fit_together_are_refused(change, words):
    with pytest.raises(SettingsError, match=words):
        simulate(replace(SMALL, **change))


@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        (RibbonSettings, {"sensors": 2}, "sensors is 2"),
        (RibbonSettings, {"magnetometer_axes": 4}, "give 2 or 3"),
        (RibbonSettings, {"length": float("nan")}, "length"),
        (RibbonSettings, {"bias": -0.1}, "bias"),
        (RibbonSettings, {"mounting": 90.0}, "mounting"),
        (PoseSettings, {"plan": 7}, "12, 16, 20"),
        (PoseSettings, {"bend": -1.0}, "bend"),
        (LayoutSettings, {"passes": 1}, "passes"),
        (LayoutSettings, {"spacing": 0.0}, "spacing"),
        (LayoutSettings, {"start": (0.0, 1e308)}, "start is 1e\\+308"),
        (LayoutSettings, {"fan_kind": "wild"}, "alternate"),
        (LayoutSettings, {"ties": 2, "tie_places": (0.5,)}, "1 tie places"),
        (LayoutSettings, {"ties": 1, "tie_places": (1.5,)}, "place"),
        (SurveySettings, {"kinds": ("middles",)}, "middles"),
        (SurveySettings, {"mark_sigma": 0.0}, "mark_sigma"),
        (FaultSettings, {"lost": 1.0}, "lost"),
        (FaultSettings, {"magnet": -1.0}, "magnet"),
        (SimulationSettings, {"dip": 90.0}, "dip"),
        (SimulationSettings, {"frames": 1}, "frames"),
        (SimulationSettings, {"seed": -1}, "seed"),
    ],
)
def test_values_that_mean_nothing_are_refused(kind, change, words):
    with pytest.raises(SettingsError, match=words):
        kind(**change)


@pytest.mark.parametrize("name", SURFACES)
def test_every_parameter_has_limits_and_a_default_within_them(name):
    kind = SURFACES[name]
    assert kind.limits.keys() == kind.parameters.keys()
    for key, (least, most) in kind.limits.items():
        assert least < kind.parameters[key] < most
        for value in (least, most):
            assert make_surface(name, {key: value})
            with pytest.raises(SettingsError, match=f"{name}: {key} is"):
                make_surface(name, {key: value + np.copysign(1.0, value - kind.parameters[key])})
