"""Stillness told with every frame: laws of rest and motion, and what must not break them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from georibbon.calibration.model import Calibration, SensorModel
from georibbon.device.rolling import LearnedNoise
from georibbon.device.stillness import StillnessMonitor, too_many
from georibbon.simulation.virtual import virtual_ribbon
from georibbon.stillness import still_means
from resting import (
    ACCELEROMETERS,
    MAGNETOMETERS,
    MG,
    RIBBON,
    SETTINGS,
    SIGMA,
    at_rest,
    columns,
    frames_of,
)

RATE = 100


def told(counts, monitor=None, **more):
    """What is told after every frame."""
    monitor = monitor or StillnessMonitor(RIBBON)
    return [monitor.feed([frame]) for frame in frames_of(counts, **more)]


def states(counts, **more):
    return [one.state for one in told(counts, **more)]


def place(name):
    """The columns of a sensor."""
    return next(
        where
        for sensor, where in zip(RIBBON.sensors, RIBBON.slices, strict=True)
        if sensor.name == name
    )


def moved(counts, onset, motion_mg, where=ACCELEROMETERS):
    """The counts with a motion (k,), mg, from a frame on, felt by each axis in its own share."""
    out = counts.copy()
    share = np.random.default_rng(5).uniform(0.5, 1.0, len(where))
    out[onset : onset + len(motion_mg), where] += MG * motion_mg[:, None] * share
    out[onset + len(motion_mg) :, where] += MG * motion_mg[-1] * share
    return out


# --- rest ---


def test_at_rest_it_is_still_within_0_6_s_and_stays_so():
    """Three minutes without one false alarm."""
    found = states(at_rest(180 * RATE))
    assert found.index("still") < 0.6 * RATE
    assert set(found[found.index("still") :]) == {"still"}


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("scale", [0.0, 0.1, 1.0, 4.0])
def test_other_noise_is_rest_too(seed, scale):
    found = told(at_rest(6 * RATE, seed, scale * SIGMA))
    assert [one.state for one in found].index("still") < 0.6 * RATE
    assert found[-1].seconds == pytest.approx(5.99)
    assert found[-1].sensors == ()


@pytest.mark.parametrize("memory", [0.5, 0.7, 0.8])
def test_noise_that_remembers_is_rest_too(memory):
    noise = at_rest(20 * RATE) - at_rest(1, sigma=0 * SIGMA)
    for k in range(1, len(noise)):
        noise[k] += memory * noise[k - 1]
    found = states(noise * np.sqrt(1 - memory**2))
    assert found.index("still") < RATE
    assert np.mean([state == "still" for state in found[100:]]) > 0.95


def test_seconds_run_with_the_frames():
    found = told(at_rest(4 * RATE))
    still = [one for one in found if one.state == "still"]
    np.testing.assert_allclose(np.diff([one.seconds for one in still]), 1 / RATE, rtol=1e-9)
    assert still[0].seconds == pytest.approx(0.49)


# --- motion ---


@given(
    st.sampled_from(["sway", "tremor", "step", "jump", "walk"]),
    st.floats(10.0, 300.0),
    st.integers(0, 1000),
)
def test_motion_is_found_within_half_a_second(kind, amplitude, seed):
    t = np.arange(60) / RATE
    rng = np.random.default_rng(seed)
    motion = {
        "sway": amplitude * np.sin(2 * np.pi * 1.0 * t),
        "tremor": amplitude * np.sin(2 * np.pi * 9.0 * t),
        "step": np.minimum(t / 0.1, 1.0) * amplitude,
        "jump": np.full(60, amplitude),
        "walk": np.cumsum(rng.choice([-1.0, 1.0], 60)) * amplitude / 5,
    }[kind]
    onset = 150
    found = states(moved(at_rest(230, seed), onset, motion))
    assert set(found[60:onset]) == {"still"}
    assert "moving" in found[onset : onset + RATE // 2]


@pytest.mark.parametrize("seed", range(5))
def test_a_slow_drift_is_found_and_never_counts_as_a_second_of_rest(seed):
    """2 mg/s on all axes: each step is far below the noise."""
    drift = 2.0 * np.arange(6 * RATE) / RATE
    found = told(moved(at_rest(8 * RATE, seed), 2 * RATE, drift))
    after = found[2 * RATE :]
    first = next(k for k, one in enumerate(after) if one.state == "moving")
    assert 0.2 * RATE < first < 1.5 * RATE
    assert "drift" in after[first].reason
    assert after[first].drift > 1.0
    assert max(one.seconds for one in after[first:]) < 1.5


def test_after_a_motion_it_is_still_again_half_a_second_later():
    motion = 40.0 * np.sin(np.arange(100) / 7.0)
    found = told(moved(at_rest(500), 200, motion))
    assert found[299].state == "moving"
    again = next(k for k in range(300, 500) if found[k].state == "still")
    assert again <= 300 + 60
    assert found[again].seconds == pytest.approx(0.49)


@pytest.mark.parametrize("seed", range(8))
def test_the_end_of_a_hands_sway_spoils_no_rest(seed):
    """Once still it stays so, for the rest does not begin in what swings out below the noise."""
    t = np.arange(50) / RATE
    waved = 40.0 * np.sin(np.arange(100) / 7.0)
    swings = 3.0 * np.exp(-t / 0.2) * (1.0 - t / t[-1])
    found = told(moved(at_rest(600, seed), 200, np.concatenate([waved, swings])))
    again = next(k for k in range(300, 600) if found[k].state == "still")
    assert again <= 300 + 50 + 25
    assert {one.state for one in found[again:]} == {"still"}


def test_an_odd_sensor_delays_no_rest():
    counts = moved(at_rest(300), 25, np.full(1, 3.0), columns(RIBBON, "accelerometer")[:3])
    assert states(counts).index("still") == 49


def test_a_shaky_start_does_not_spoil_the_noise_that_is_learned():
    rng = np.random.default_rng(3)
    counts = at_rest(20 * RATE)
    counts[: 10 * RATE] += 30 * MG * rng.standard_normal((10 * RATE, len(SIGMA)))
    small = moved(counts, 15 * RATE, 7.0 * np.sin(np.arange(5 * RATE) / 3.0))
    found = states(small)
    assert "still" not in found[: 10 * RATE]
    assert "still" in found[10 * RATE : 10 * RATE + 60]
    assert set(found[14 * RATE : 15 * RATE]) == {"still"}
    assert "moving" in found[15 * RATE : 15 * RATE + RATE // 2]


def noise_of(size=50):
    return LearnedNoise(size, np.full(1, 0.1), np.full(1, 1e4))


def feed(noise, sigma, frames, still, seed=1):
    """The noise that is learned when so many values of white noise have come."""
    values = np.rint(np.random.default_rng(seed).normal(0.0, sigma, frames)).astype(np.int64)
    for value in values:
        noise.append(np.array([value]), np.ones(1, dtype=bool), still)
    return float(noise.sigma[0])


def test_motion_is_not_learned_as_noise():
    """A minute of shaking between two rests changes the noise by no more than its forgetting."""
    noise = noise_of()
    rest = feed(noise, 20.0, 1000, still=True)
    shaken = feed(noise, 400.0, 6000, still=False)
    assert rest == pytest.approx(20.0, rel=0.2)
    assert shaken == pytest.approx(rest * LearnedNoise.FORGETTING**120, rel=1e-6)
    taken_for_rest = feed(noise, 60.0, 6000, still=True)
    assert taken_for_rest == pytest.approx(shaken * LearnedNoise.FORGETTING**120, rel=1e-6)


def test_before_it_ever_lay_still_the_differences_tell_the_noise():
    noise = noise_of()
    feed(noise, 300.0, 500, still=False)
    assert feed(noise, 20.0, 50, still=False) == pytest.approx(1.3 * 20.0, rel=0.25)


def test_noise_neither_falls_to_nothing_nor_is_learned_from_a_frozen_sensor():
    noise = LearnedNoise(50, np.full(1, 5.0), np.full(1, 160.0))
    there = np.ones(1, dtype=bool)
    for _ in range(500):
        noise.append(np.array([7]), there, True)
    assert noise.sigma[0] == 160.0
    for k in range(500):
        noise.append(np.array([7 + k % 2]), there, True)
    assert noise.sigma[0] == 5.0


def test_noise_that_has_truly_grown_is_learned_in_the_end():
    noise = noise_of(10)
    assert 14.0 < feed(noise, 20.0, 500, still=True) < 21.0
    assert 40.0 < feed(noise, 60.0, 15_000, still=True, seed=2) < 63.0


def test_noise_that_remembers_spreads_more_and_its_means_more_still():
    noise, rng, value = noise_of(), np.random.default_rng(3), 0.0
    for _ in range(5000):
        value = 0.6 * value + rng.normal(0.0, 40.0)
        noise.append(np.array([round(value)]), np.ones(1, dtype=bool), True)
    assert noise.sigma[0] == pytest.approx(50.0, rel=0.25)
    assert noise.slow[0] == pytest.approx(100.0, rel=0.3)


@pytest.mark.parametrize("rate", [4.0, 25.0, 400.0, 1000.0])
def test_any_rate_will_do(rate):
    ribbon = replace(RIBBON, rate=rate)
    counts = moved(at_rest(int(4 * rate) + 20), int(3 * rate), np.full(1, 60.0))
    found = told(counts, StillnessMonitor(ribbon), rate=rate)
    first = next(one for one in found if one.state == "still")
    assert first.seconds == pytest.approx((max(10, round(rate / 2)) - 1) / rate)
    assert found[int(3 * rate) + max(3, int(0.1 * rate))].state == "moving"


# --- the same whatever the units and the blocks ---


@pytest.mark.parametrize("factor", [2, 3, 7])
def test_the_scale_of_the_counts_means_nothing(factor):
    scaled = replace(
        RIBBON,
        sensors=tuple(
            replace(sensor, counts_per_unit=factor * sensor.counts_per_unit)
            for sensor in RIBBON.sensors
        ),
    )
    counts = np.rint(moved(at_rest(400), 200, 20 * np.sin(np.arange(50) / 5.0)))
    one = told(counts)
    other = told(factor * counts, StillnessMonitor(scaled))
    assert [a.state for a in one] == [b.state for b in other]
    np.testing.assert_allclose([a.spread for a in one], [b.spread for b in other], rtol=1e-9)
    np.testing.assert_allclose([a.drift for a in one], [b.drift for b in other], atol=1e-9)


@settings(max_examples=15)
@given(st.lists(st.integers(0, 60), max_size=20), st.integers(0, 3))
def test_it_matters_nothing_how_the_frames_are_cut_into_blocks(sizes, seed):
    counts = moved(at_rest(300, seed), 120, 30 * np.sin(np.arange(40) / 4.0))
    counts[np.random.default_rng(seed).random(counts.shape) < 0.02] = np.nan
    frames = frames_of(counts)
    whole, parts = StillnessMonitor(RIBBON), StillnessMonitor(RIBBON)
    expected = whole.feed(frames)
    cuts = [0, *np.minimum(np.cumsum([0, *sizes]), 300).tolist(), 300]
    for a, b in pairwise(cuts):
        last = parts.feed(frames[a:b])
    assert last == expected
    np.testing.assert_array_equal(whole.means().mean, parts.means().mean)
    np.testing.assert_array_equal(whole.means().sigma, parts.means().sigma)


# --- window and means ---


@settings(max_examples=20)
@given(st.integers(60, 290), st.integers(0, 50))
def test_the_mean_is_the_plain_mean_of_the_windows_frames(frames, seed):
    monitor = StillnessMonitor(RIBBON)
    counts = np.rint(at_rest(frames, seed))
    counts[np.random.default_rng(seed).random(counts.shape) < 0.05] = np.nan
    monitor.feed(frames_of(counts))
    window, means = monitor.window(), monitor.means()
    np.testing.assert_array_equal(window.counts, counts)
    np.testing.assert_allclose(window.t, np.arange(frames) / RATE, atol=1e-12)
    np.testing.assert_allclose(means.mean, np.nanmean(counts, axis=0), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(means.frames, np.isfinite(counts).sum(axis=0))


def test_the_window_is_bounded_and_the_mean_goes_on():
    monitor = StillnessMonitor(RIBBON)
    counts = np.rint(at_rest(1000))
    monitor.feed(frames_of(counts))
    np.testing.assert_array_equal(monitor.window().counts, counts[-300:])
    np.testing.assert_allclose(monitor.means().mean, counts.mean(axis=0), rtol=0, atol=1e-9)
    assert set(monitor.means().frames) == {1000}


def test_nothing_is_averaged_over_a_motion():
    monitor = StillnessMonitor(RIBBON)
    counts = np.rint(moved(at_rest(600), 200, np.full(1, 500.0)))
    frames = frames_of(counts)
    monitor.feed(frames[:210])
    assert monitor.window() is None
    assert monitor.means() is None
    monitor.feed(frames[210:])
    window = monitor.window()
    np.testing.assert_array_equal(window.counts, counts[-len(window.counts) :])
    assert 330 >= 600 - 200 - len(window.counts) >= 0
    np.testing.assert_allclose(window.counts.mean(axis=0), counts[250:].mean(axis=0), atol=8.0)


@pytest.mark.parametrize("frames", [100, 600])
def test_sigma_is_right_for_noise_that_remembers_and_the_white_formula_is_not(frames):
    memory, own = 0.7, 8.0
    errors, sigmas, white = [], [], []
    for seed in range(16):
        noise = own * np.random.default_rng(seed).standard_normal((frames + 200, len(SIGMA)))
        for k in range(1, len(noise)):
            noise[k] += memory * noise[k - 1]
        counts = np.rint(noise[200:])
        monitor = StillnessMonitor(RIBBON)
        monitor.feed(frames_of(counts))
        means = monitor.means()
        if means is not None and means.frames[0] == frames:
            errors.append(means.mean)
            sigmas.append(means.sigma)
            white.append(counts.std(axis=0) / np.sqrt(frames))
    assert len(errors) > 9
    honest = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(sigmas)))
    naive = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(white)))
    assert 0.8 < honest < 1.25
    assert naive > 1.9


def test_the_running_means_agree_with_those_of_the_window():
    monitor = StillnessMonitor(RIBBON)
    monitor.feed(frames_of(at_rest(200)))
    running, whole = monitor.means(), still_means(monitor.window())
    np.testing.assert_allclose(running.mean, whole.mean, atol=1e-9)
    ratio = np.sqrt(np.mean(running.sigma**2) / np.mean(whole.sigma**2))
    assert 0.8 < ratio < 1.25


# --- what must not break it ---


def test_dead_lost_and_saturated_values_do_not_prevent_rest():
    counts = at_rest(400)
    counts[:, place("A02")] = 0.0
    counts[:, place("A04")] = np.nan
    counts[:, place("M03").start] = 32767.0
    counts[np.random.default_rng(0).random(counts.shape) < 0.2] = np.nan
    found = told(counts)
    assert found[-1].state == "still"
    assert found[-1].seconds > 3.9
    monitor = StillnessMonitor(RIBBON)
    monitor.feed(frames_of(counts))
    means = monitor.means()
    assert np.isnan(means.mean[place("A04")]).all()
    assert np.isnan(means.mean[place("M03").start])
    assert np.isnan(monitor.window().counts[:, place("M03").start]).all()
    assert means.mean[place("A02")] == pytest.approx(0.0)


def test_values_at_the_ends_of_the_range_now_and_then_do_not_count():
    counts = at_rest(300)
    counts[::17, ACCELEROMETERS] = 32767.0
    counts[5::29, ACCELEROMETERS] = -32767.0
    found = states(counts)
    assert set(found[60:]) == {"still"}


def test_a_ribbon_whose_accelerometers_are_silent_is_not_still():
    counts = at_rest(200)
    counts[:, ACCELEROMETERS] = np.nan
    found = told(counts)
    assert {one.state for one in found} == {"moving"}
    assert "no accelerometer" in found[-1].reason


def with_gap(seconds, jump_mg=0.0):
    t = np.arange(300) / RATE
    t[150:] += seconds
    return told(moved(at_rest(300), 150, np.full(1, jump_mg)), times=t)


def test_lost_packets_do_not_break_the_rest():
    kept = np.random.default_rng(2).random(400) > 0.3
    found = told(at_rest(400)[kept], times=(np.arange(400) / RATE)[kept])
    assert found[-1].state == "still"
    assert found[-1].seconds > 3.9


def test_a_short_gap_is_bridged_and_a_long_one_is_not():
    assert with_gap(0.2)[150].state == "still"
    assert with_gap(0.2)[-1].seconds == pytest.approx(2.99 + 0.2)
    broken = with_gap(0.4)
    assert broken[150].state == "moving"
    assert "missing" in broken[150].reason
    assert broken[-1].seconds == pytest.approx(1.49)
    assert "moving" in {one.state for one in with_gap(0.2, jump_mg=20.0)[150:]}


def test_a_clock_that_goes_back_begins_anew():
    t = np.arange(300) / RATE
    t[200:] -= 1.0
    found = told(at_rest(300), times=t)
    assert found[200].state == "moving"
    assert found[-1].seconds == pytest.approx(0.99)


# --- single sensors ---


def shaken(*names):
    """A rest during which some sensors shake from the second second on."""
    counts = at_rest(400)
    rng = np.random.default_rng(9)
    for name in names:
        where = place(name)
        counts[100:, where] += 60 * MG * rng.standard_normal((300, where.stop - where.start))
    return counts


def test_a_knocked_sensor_is_named_and_does_not_prevent_rest():
    found = told(shaken("A05"))
    assert {one.state for one in found[60:]} == {"still"}
    assert found[-1].sensors == ("A05",)
    assert "A05" in found[-1].reason
    assert found[-1].spread < 3.0


def test_two_sensors_beside_each_other_are_a_motion():
    found = told(shaken("A05", "A06"))
    assert {one.state for one in found[150:]} == {"moving"}
    assert found[-1].sensors == ("A05", "A06")
    assert found[-1].spread > 3.0


def test_more_than_one_in_ten_is_too_many():
    alone = np.zeros(30, dtype=bool)
    assert not too_many(alone)
    alone[[3, 9, 20]] = True
    assert not too_many(alone)
    alone[25] = True
    assert too_many(alone)
    assert too_many(np.array([True, False]))
    assert not too_many(np.array([True, False, False]))


def test_a_sensor_that_the_calibration_leaves_out_is_not_heeded():
    models = tuple(
        SensorModel(
            sensor.name,
            sensor.counts_per_unit * np.eye(3)[: sensor.axes],
            np.zeros(sensor.axes),
            used=sensor.name not in ("A05", "A06"),
        )
        for sensor in RIBBON.sensors
    )
    monitor = StillnessMonitor(RIBBON, Calibration(RIBBON.id, 1.1, models))
    found = told(shaken("A05", "A06"), monitor)
    assert {one.state for one in found[60:]} == {"still"}
    assert found[-1].sensors == ()


def test_accelerometers_alone_will_do():
    ribbon = replace(
        RIBBON, sensors=tuple(RIBBON.sensors[i] for i in RIBBON.indices("accelerometer"))
    )
    counts = moved(at_rest(300), 200, np.full(1, 60.0))[:, ACCELEROMETERS]
    found = states(counts, monitor=StillnessMonitor(ribbon))
    assert set(found[60:200]) == {"still"}
    assert found[205] == "moving"


# --- magnets ---


def test_a_magnet_that_passes_is_told_and_named():
    counts = at_rest(600)
    near = np.r_[place("M03").start : place("M04").stop : 1]
    near = np.intersect1d(near, MAGNETOMETERS)
    counts[200:300, near] += 400.0 * np.sin(np.linspace(0, np.pi, 100))[:, None]
    found = told(counts)
    during = [one for one in found[200:300] if one.state == "disturbed"]
    assert len(during) > 60
    assert set(during[-1].sensors) <= {"M03", "M04"}
    assert "moving" not in {one.state for one in found[200:]}
    assert during[-1].seconds == 0.0
    assert found[-1].state == "still"
    assert found[-1].seconds < 3.3


def three_axes():
    ribbon = virtual_ribbon(replace(SETTINGS, magnetometer_axes=3))
    models = tuple(
        SensorModel(sensor.name, sensor.counts_per_unit * np.eye(3), np.full(3, 11.0))
        for sensor in ribbon.sensors
    )
    base = np.concatenate(
        [sensor.counts_per_unit * np.array([0.6, 0.0, 0.8]) + 11.0 for sensor in ribbon.sensors]
    )
    noise = np.random.default_rng(0).standard_normal((200, len(base)))
    return ribbon, Calibration(ribbon.id, 1.1, models), base + 8.0 * noise


@pytest.mark.parametrize(("share", "word"), [(0.06, "suspect"), (-0.2, "bad")])
def test_a_field_of_another_strength_is_told_where_it_can_be_known(share, word):
    ribbon, calibration, counts = three_axes()
    where = columns(ribbon, "magnetometer")[3:9]
    counts[:, where] += share * (counts[:, where].mean(axis=0) - 11.0)
    monitor = StillnessMonitor(ribbon, calibration)
    found = told(counts, monitor)[-1]
    assert found.state == "disturbed"
    assert found.sensors == ("M02", "M03")
    assert word in found.reason
    assert found.seconds == pytest.approx(1.99)
    assert monitor.window() is not None


def test_a_field_as_it_should_be_is_not_disturbed_and_one_odd_sensor_is_named():
    ribbon, calibration, counts = three_axes()
    assert told(counts, StillnessMonitor(ribbon, calibration))[-1].state == "still"
    counts[:, columns(ribbon, "magnetometer")[:3]] *= 1.3
    found = told(counts, StillnessMonitor(ribbon, calibration))[-1]
    assert found.state == "still"
    assert found.sensors == ("M01",)


# --- beginning and beginning anew ---


def test_before_anything_came_nothing_is_still():
    monitor = StillnessMonitor(RIBBON)
    assert monitor.feed([]).state == "moving"
    assert monitor.window() is None
    assert monitor.means() is None


def test_reset_forgets_the_rest_and_keeps_the_noise():
    monitor = StillnessMonitor(RIBBON)
    frames = frames_of(at_rest(1000))
    monitor.feed(frames[:900])
    monitor.reset()
    assert monitor.window() is None
    assert monitor.feed(frames[900:940]).state == "moving"
    assert monitor.feed(frames[940:]).state == "still"
    assert len(monitor.window().counts) == 100
