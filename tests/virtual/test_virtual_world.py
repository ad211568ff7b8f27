"""The virtual ribbon in its world: it says what `simulate` records, and moves as hands do."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from worlds import QUIET, SMALL, counts_of, world_of

from georibbon.errors import SettingsError
from georibbon.rotations import about_x, about_y, about_z
from georibbon.simulation import FaultSettings, PoseSettings, simulate
from georibbon.simulation.capture import error_streams, make_bench
from georibbon.simulation.virtual import noise_counts
from georibbon.virtual import VirtualRibbon, VirtualSettings
from georibbon.virtual.motion import Motion, draw_sway, least_jerk
from georibbon.virtual.places import Places

FAR = 6.0
"""Standard deviations that a mean of noise does not miss by."""


def assert_as_recorded(counts, recorded):
    """Two sets of frames whose noise differs have one mean."""
    spread = noise_counts(simulate(SMALL).recording.ribbon, SMALL.ribbon)
    allowed = FAR * np.hypot(spread, 0.3) * np.sqrt(1 / len(counts) + 1 / len(recorded))
    assert (np.abs(counts.mean(axis=0) - recorded.mean(axis=0)) < allowed).all()


def settle(world):
    """Let it come to rest."""
    world.frames(300)
    assert ", still" in world.do("status")


def test_a_laid_ribbon_says_what_simulate_records():
    recording, world = simulate(SMALL).recording, world_of()
    for run in reversed(recording.passes):  # in any order
        world.do(f"lay {run.name}")
        settle(world)
        assert_as_recorded(counts_of(world, 400), run.readings.counts)


def test_a_posed_ribbon_says_what_simulate_records():
    recording, world = simulate(SMALL).recording, world_of()
    for number in (1, 2, 9, 16):
        world.do(f"pose {number}")
        settle(world)
        assert_as_recorded(counts_of(world, 400), recording.poses[number - 1].readings.counts)


def test_truth_and_survey_are_those_of_simulate():
    simulation, world = simulate(SMALL), world_of()
    recording, truth = simulation.recording, simulation.truth
    assert world.survey() == (recording.marks, recording.distances, recording.crossings)
    assert world.truth.yaw_degrees == truth.yaw_degrees
    assert world.passes == tuple(truth.strips)
    for name, strip in truth.strips.items():
        np.testing.assert_array_equal(world.truth.strips[name].points, strip.points)
    for one, other in zip(world.truth.calibration.sensors, truth.calibration.sensors, strict=True):
        np.testing.assert_array_equal(one.gain, other.gain)
        np.testing.assert_array_equal(one.bias, other.bias)


def test_a_simulated_magnet_lies_beside_its_pass_alone():
    faults = FaultSettings(magnet=0.4, magnet_on="P2")
    with_magnet = simulate(replace(SMALL, faults=faults)).recording
    world = world_of(replace(SMALL, faults=faults))
    for name in ("P2", "P3"):
        world.do(f"lay {name}")
        settle(world)
        recorded = next(run for run in with_magnet.passes if run.name == name)
        assert_as_recorded(counts_of(world, 400), recorded.readings.counts)
    plain = next(run for run in simulate(SMALL).recording.passes if run.name == "P2")
    moved = with_magnet.passes[1].readings.counts.mean(axis=0) - plain.readings.counts.mean(axis=0)
    assert np.abs(moved).max() > 100.0


def test_a_pass_laid_again_is_a_little_different():
    world = world_of(QUIET)
    first, again = [], []
    for found in (first, again):
        world.do("lay P1")
        settle(world)
        found.append(counts_of(world, 1)[0])
        world.do("lift")
        world.frames(50)
    gap = np.abs(first[0] - again[0])
    # Contact of 0.25 degrees an axis: some ten counts of a few thousand, and no more.
    assert 1.0 < np.median(gap[gap > 0]) < 400.0


def test_at_rest_without_noise_every_frame_is_the_same():
    world = world_of(QUIET)
    world.do("lay T1")
    settle(world)
    counts = counts_of(world, 50)
    assert (counts == counts[0]).all()


def test_frames_do_not_depend_on_how_many_are_asked_for_at_once():
    one, other = world_of(), world_of()
    for world in (one, other):
        world.do("lay P2")
    at_once = counts_of(one, 600)
    in_parts = np.concatenate([counts_of(other, n) for n in (1, 99, 250, 250)])
    np.testing.assert_array_equal(at_once, in_parts)


def test_another_seed_is_another_ribbon():
    assert not np.array_equal(
        counts_of(world_of(), 5), counts_of(world_of(replace(SMALL, seed=6)), 5)
    )


def test_a_move_is_smooth_and_ends_where_it_should():
    rng = np.random.default_rng(3)
    begin = about_z(np.linspace(0.0, 0.4, 8))
    target = about_x(2.0) @ about_y(np.linspace(-0.3, 0.3, 8))
    motion = Motion(begin, target, 10.0, 1.5, draw_sway(rng))
    np.testing.assert_allclose(motion.frames(np.array([9.0, 10.0])), [begin, begin], atol=1e-12)
    late = np.array([motion.still_from, motion.still_from + 5.0])
    np.testing.assert_allclose(motion.frames(late), [target, target], atol=1e-12)
    frames = motion.frames(np.arange(9.5, motion.still_from + 0.5, 0.001))
    np.testing.assert_allclose(
        frames @ np.swapaxes(frames, 2, 3), np.broadcast_to(np.eye(3), frames.shape), atol=1e-12
    )
    speed = np.linalg.norm(np.diff(frames, axis=0), axis=(2, 3)) / 0.001
    # Half a turn in 1.5 s and the sway: some radians a second; and no jump of the speed.
    assert 1.0 < speed.max() < 20.0
    assert np.abs(np.diff(speed, axis=0)).max() < 0.5


def test_hands_that_moved_go_on_without_a_jerk():
    world = world_of(replace(QUIET, layout=replace(QUIET.layout, contact=0.0)))
    steps = []
    for words in ("status", "lay P1", "lift", "lay P2", "next"):
        before = counts_of(world, 70)
        world.do(words)
        joined = np.concatenate([before, counts_of(world, 70)])
        steps.append(np.abs(np.diff(joined, n=2, axis=0)).max(axis=1))
    # The change of speed where a command comes is none that the sway does not make anyway.
    usual = max(step.max() for step in steps[:1])
    assert all(step[68:71].max() < 3 * usual for step in steps)


def test_least_jerk_goes_from_rest_to_rest():
    np.testing.assert_array_equal(
        least_jerk(np.array([-1.0, 0.0, 0.5, 1.0, 2.0])), [0, 0, 0.5, 1, 1]
    )
    ends = least_jerk(np.array([1e-3, 1 - 1e-3]))
    np.testing.assert_allclose(ends, [1e-8, 1 - 1e-8], atol=2e-10)


def test_lifted_it_never_rests_and_held_it_does():
    world = world_of(QUIET)
    world.frames(1000)
    moving = counts_of(world, 100)
    assert (moving.std(axis=0) > 10.0).mean() > 0.5
    world.do("hold")
    held = counts_of(world, 10)
    assert (held == held[0]).all()
    # It is held where it was: no more of a step than the sway makes in a frame or two.
    assert np.abs(held[0] - moving[-1]).max() < 3 * np.abs(np.diff(moving, axis=0)).max()
    world.do("lift")
    assert (counts_of(world, 300)[100:].std(axis=0) > 10.0).mean() > 0.5


def test_without_hands_it_is_there_at_once():
    world = world_of(QUIET, pace=0.0)
    assert world.do("lay P1") == "P1, still"
    counts = counts_of(world, 20)
    assert (counts == counts[0]).all()


def test_careful_poses_are_what_is_asked():
    care = PoseSettings(heading_care=0.0, pitch_care=0.0, bend=0.0, table_tilt=0.0)
    settings = replace(SMALL, poses=care)
    streams = error_streams(settings.seed)
    places = Places(make_bench(settings, streams), streams, None)
    free = places.posed_as((30.0, 20.0, -40.0, False))
    # Headings count from an unknown direction: only what is seen of the vertical is known.
    asked = about_y(np.radians(40.0)) @ about_x(np.radians(30.0))
    np.testing.assert_allclose(free[:, 2], np.broadcast_to(asked[2], (16, 3)), atol=1e-12)
    turned = places.posed_as((30.0, 50.0, -40.0, False)) @ np.swapaxes(free, 1, 2)
    np.testing.assert_allclose(
        turned, np.broadcast_to(about_z(np.radians(30.0)), (16, 3, 3)), atol=1e-12
    )


def test_careless_poses_differ_from_time_to_time_but_not_on_the_table():
    streams = error_streams(1)
    places = Places(make_bench(SMALL, streams), streams, None)
    free = [places.posed_as((0.0, 0.0, 40.0, False)) for _ in range(2)]
    assert np.abs(free[0][:, 2] - free[1][:, 2]).max() > 1e-3
    table = [places.posed_as((0.0, 0.0, 0.0, True)) for _ in range(2)]
    assert np.abs(table[0] - table[1]).max() > 1e-3  # the heading
    # What the slip of a heading leaves of the table's tilt.
    assert np.abs(table[0][:, 2] - table[1][:, 2]).max() < 0.02


def test_play_holds_every_place_in_its_order():
    simulation = replace(SMALL, poses=PoseSettings(poses=((0, 0, 0, True), (90, 10, 5, False))))
    recording, world = simulate(simulation).recording, world_of(simulation, hold=1.0)
    assert world.do("play") == "2 poses, then P1, P2, P3, T1"
    places = []
    while not world.played.is_set():
        counts = counts_of(world, 5)
        where = world.do("status").split(";")[0].split(",")
        if where[1] == " still":
            if where[0] not in [name for name, _ in places]:
                places.append((where[0], []))
            places[-1][1].append(counts[-1])
    assert [name for name, _ in places] == ["in pose 1", "in pose 2", "P1", "P2", "P3", "T1"]
    for (_, held), item in zip(places, (*recording.poses, *recording.passes), strict=True):
        assert 19 <= len(held) <= 21  # a second, looked at every 0.05 s
        assert_as_recorded(np.array(held[1:]), item.readings.counts)


def test_another_command_ends_the_play():
    world = world_of(hold=1.0)
    world.do("poses")
    world.frames(500)
    world.do("lay P3")
    world.frames(2000)
    assert world.do("status").startswith("P3, still;")
    assert not world.played.is_set()


def test_noise_is_as_large_as_asked():
    world = world_of(pace=0.0)
    world.do("lay P1")
    once = counts_of(world, 500).std(axis=0)
    world.do("noise 3")
    np.testing.assert_allclose(counts_of(world, 500).std(axis=0) / once, 3.0, rtol=0.3)


def test_a_dead_sensor_says_nothing_until_it_is_alive():
    world = world_of(pace=0.0)
    world.do("lay P1")
    before = counts_of(world, 20)
    columns = [world.ribbon.columns.index(name) for name in ("A03x", "A03y", "A03z")]
    world.do("dead A03")
    dead = counts_of(world, 20)
    assert (dead[:, columns] == 0).all()
    assert np.count_nonzero((dead == 0).all(axis=0)) == 3
    world.do("alive A03")
    assert np.abs(counts_of(world, 20) - before).max() < 500.0


def test_a_magnet_disturbs_the_magnetometers_near_it_and_goes():
    world = world_of(QUIET, pace=0.0)
    world.do("lay P1")
    before = counts_of(world, 1)[0]
    world.do("magnet 0.5 0.1 0.05")
    moved = np.abs(counts_of(world, 1)[0] - before)
    for sensor, columns in zip(world.ribbon.sensors, world.ribbon.slices, strict=True):
        near = sensor.kind == "magnetometer" and abs(sensor.position - 0.1) < 0.04
        far = sensor.kind == "accelerometer" or abs(sensor.position - 0.1) > 0.1
        assert not near or moved[columns].max() > 50.0
        assert not far or moved[columns].max() <= 1.0
    world.do("magnet off")
    np.testing.assert_array_equal(counts_of(world, 1)[0], before)


def test_a_passing_magnet_comes_along_the_ribbon_and_is_gone():
    world = world_of(QUIET, pace=0.0)
    world.do("lay P1")
    before = counts_of(world, 1)[0]
    world.do("magnet pass 0.5 2")
    moved = np.abs(counts_of(world, 400) - before)
    magnetometers = [i for i, name in enumerate(world.ribbon.columns) if name.startswith("M")]
    first = magnetometers[0], magnetometers[-2]
    assert moved[:, magnetometers].max() > 50.0
    assert np.argmax(moved[:, first[0]]) < np.argmax(moved[:, first[1]])
    assert moved[201:].max() == 0.0


def test_lost_values_are_lost_on_the_wire():
    world = world_of(replace(SMALL, faults=FaultSettings(lost=0.2)))
    lost = counts_of(world, 200) == -32768
    assert 0.17 < lost.mean() < 0.23


def test_a_fault_that_names_nothing_is_refused():
    with pytest.raises(SettingsError, match="A99"):
        world_of(replace(SMALL, faults=FaultSettings(dead=("A99",))))
    with pytest.raises(SettingsError, match="P9"):
        world_of(replace(SMALL, faults=FaultSettings(magnet=0.1, magnet_on="P9")))


def test_time_goes_on_by_itself_or_as_it_is_told():
    world = world_of()
    world.advance(2.5)
    assert [frame.t for frame in world.frames(3)] == pytest.approx([2.51, 2.52, 2.53])


def test_who_serves_it_is_woken_when_there_is_something_to_do():
    world, woken = world_of(), []
    world.attach(lambda: woken.append(len(woken)))
    world.do("status")
    assert woken == [0]
    world.advance(0.5)
    assert woken == [0, 1]
    world.detach()
    world.advance(0.5)
    world.do("status")
    assert woken == [0, 1]


def test_it_is_attached_by_one_at_a_time():
    """Who attaches waits for who uses the ribbon at this moment: the clock is asked in that."""
    attached = []

    def attach():
        world.attach(lambda: None)
        attached.append(True)

    def clock():
        if beside and not beside[0].ident:
            beside[0].start()
            beside[0].join(0.2)  # not a wait: it cannot end before this returns
            attached.append(False)
        return 0.0

    beside = []
    world = VirtualRibbon(VirtualSettings(SMALL), clock=clock)
    beside.append(threading.Thread(target=attach))
    world.catch_up()
    beside[0].join()
    assert attached == [False, True]
    with pytest.raises(SettingsError, match="served already"):
        world.attach(lambda: None)
