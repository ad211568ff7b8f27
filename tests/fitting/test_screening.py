"""Before any fit: sensors that say nothing, and ribbons that did not lie still."""

from dataclasses import replace

import numpy as np
import pytest
from laid import FLAT, calibration, recording, ribbon, wavy

from georibbon.fitting.grid import make_grid
from georibbon.fitting.screening import ALIKE_FRAMES, STILL_FRAMES, screen
from georibbon.recording import Pass
from georibbon.ribbon import Readings
from georibbon.stillness import FULL_SCALE

RIBBON = ribbon(8)
CALIBRATION = calibration(RIBBON)
NAMES = [sensor.name for sensor in RIBBON.sensors]


def passes(count=4, frames=50):
    """Passes at rest, with noise."""
    shape = wavy(make_grid(RIBBON), FLAT)
    stack = shape.take([0] * count)
    return list(recording(RIBBON, stack, frames=frames).passes)


def changed(one, change):
    """The pass with its counts changed by a function that works in place."""
    counts = one.readings.counts.copy()
    change(counts)
    return replace(one, readings=Readings(one.readings.t, counts))


def spoil(which, columns, values, frames=50):
    """Screened passes of which one has some columns overwritten."""
    them = passes(frames=frames)

    def change(counts):
        counts[:, columns] = values

    them[which] = changed(them[which], change)
    return screen(RIBBON, them, CALIBRATION)


def test_passes_at_rest_are_averaged_and_nothing_is_said():
    them = passes()
    found = screen(RIBBON, them, CALIBRATION)
    assert found.notices == ()
    assert found.moved == (False,) * 4
    expected = np.array([one.readings.counts.mean(axis=0) for one in them])
    np.testing.assert_allclose(found.mean, expected)
    # 6 counts of noise in 50 frames; ten blocks tell it to a quarter.
    assert np.median(found.sigma) == pytest.approx(6.0 / np.sqrt(50), rel=0.25)


@pytest.mark.parametrize("name", ["A02", "M03"])
@pytest.mark.parametrize("value", [0.0, 123.0, np.nan])
def test_a_dead_sensor_is_left_out_of_its_pass_and_named(name, value):
    columns = RIBBON.slices[NAMES.index(name)]
    found = spoil(1, columns, value)
    (notice,) = found.notices
    assert (notice.code, notice.pass_name, notice.sensor) == ("sensor-dead", "P2", name)
    assert f"pass P2: sensor {name}" in notice.message
    assert "left out" in notice.message
    assert np.isnan(found.mean[1, columns]).all()
    assert np.isfinite(np.delete(found.mean, 1, axis=0)).all()
    assert np.isfinite(np.delete(found.mean[1], np.r_[columns])).all()


def test_one_axis_without_a_value_makes_the_sensor_dead():
    columns = RIBBON.slices[2]
    found = spoil(0, columns.start, np.nan)
    assert [notice.code for notice in found.notices] == ["sensor-dead"]
    assert np.isnan(found.mean[0, columns]).all()


def test_values_that_are_lost_now_and_then_do_no_harm():
    found = spoil(0, RIBBON.slices[2], np.where(np.arange(50) % 3 == 0, np.nan, 5.0)[:, None])
    assert [notice.message.split(";")[0] for notice in found.notices] == [
        "pass P1: sensor A02 says the same in every frame"
    ]
    them = passes()
    them[0] = changed(them[0], lambda counts: counts.__setitem__((slice(0, 50, 3), 5), np.nan))
    assert screen(RIBBON, them, CALIBRATION).notices == ()


def railed(frames, sign=1):
    """Screened passes of which one axis of the third is at the end of its range now and then."""
    them = passes()
    them[2] = changed(them[2], lambda counts: counts.__setitem__((frames, 4), sign * FULL_SCALE))
    return them[2], screen(RIBBON, them, CALIBRATION)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_saturated_sensor_is_left_out_and_named(sign):
    _, found = railed(slice(0, 10), sign)
    (notice,) = found.notices
    sensor = next(i for i, part in enumerate(RIBBON.slices) if part.start <= 4 < part.stop)
    assert (notice.code, notice.pass_name) == ("sensor-saturated", "P3")
    assert notice.sensor == NAMES[sensor]
    assert np.isnan(found.mean[2, RIBBON.slices[sensor]]).all()


@pytest.mark.parametrize("sign", [1, -1])
def test_single_values_at_the_end_of_the_range_are_left_out_and_told(sign):
    """A bit that flipped on the way is no reason to lose the sensor."""
    one, found = railed([7, 9], sign)
    (notice,) = found.notices
    assert (notice.code, notice.pass_name) == ("values-saturated", "P3")
    assert "2 values" in notice.message
    rest = np.delete(one.readings.counts[:, 4], [7, 9])
    assert found.mean[2, 4] == pytest.approx(rest.mean())
    assert found.moved == (False,) * 4


def test_a_few_equal_frames_prove_nothing():
    columns = RIBBON.slices[0]
    few = spoil(0, columns, 100.0, frames=ALIKE_FRAMES - 1).notices
    assert "sensor-dead" not in {one.code for one in few}
    assert [one.code for one in spoil(0, columns, 100.0, frames=ALIKE_FRAMES).notices] == [
        "sensor-dead"
    ]


def test_what_the_calibration_has_left_out_is_not_named_again():
    models = list(CALIBRATION.sensors)
    models[2] = replace(models[2], used=False, reason="dead")
    them = passes()
    them[0] = changed(them[0], lambda counts: counts.__setitem__((slice(None), slice(5, 8)), 0.0))
    assert RIBBON.slices[2] == slice(5, 8)
    assert screen(RIBBON, them, replace(CALIBRATION, sensors=tuple(models))).notices == ()


# --- lying still ---


def shaken(how, lost=0.0):
    """Screened passes of which the second was moved as a function of the frame's share says, g."""
    them = passes(frames=100)
    share = np.arange(100)[:, None] / 100

    def change(counts):
        for i in RIBBON.indices("accelerometer"):
            counts[:, RIBBON.slices[i]] += 16384.0 * how(share)
        counts[np.random.default_rng(1).random(counts.shape) < lost] = np.nan

    them[1] = changed(them[1], change)
    return screen(RIBBON, them, CALIBRATION)


MOTIONS = {
    "wobble": lambda share: 0.02 * np.sin(40 * share),
    "drift": lambda share: 0.008 * share,
    "knock": lambda share: 0.05 * (np.abs(share - 0.5) < 0.1),
}


@pytest.mark.parametrize("motion", list(MOTIONS))
@pytest.mark.parametrize("lost", [0.0, 0.02, 0.2])
def test_a_pass_that_moved_is_named(motion, lost):
    found = shaken(MOTIONS[motion], lost)
    assert found.moved == (False, True, False, False)
    notices = [notice for notice in found.notices if notice.code == "pass-moved"]
    assert [notice.pass_name for notice in notices] == ["P2"]
    assert "repeat the pass" in notices[0].message


@pytest.mark.parametrize("lost", [0.0, 0.2])
def test_a_still_pass_is_not_accused(lost):
    assert shaken(lambda share: 0 * share, lost).moved == (False,) * 4


def test_more_noise_in_one_pass_alone_is_motion_and_in_all_is_not():
    them = passes()
    noisy = [
        changed(
            one,
            lambda counts: counts.__iadd__(60 * np.random.default_rng(1).normal(size=counts.shape)),
        )
        for one in them
    ]
    assert screen(RIBBON, noisy, CALIBRATION).moved == (False,) * 4
    assert screen(RIBBON, [*them[:3], noisy[3]], CALIBRATION).moved == (False,) * 3 + (True,)


def test_a_pass_without_a_value_has_all_sensors_dead_and_did_not_move():
    found = spoil(0, slice(None), np.nan)
    assert found.moved[0] is False
    assert len(found.notices) == len(NAMES)


@pytest.mark.parametrize("frames", [1, 2, STILL_FRAMES - 1])
def test_a_pass_too_short_to_show_that_it_lay_still_is_told(frames):
    found = screen(RIBBON, passes(frames=frames), CALIBRATION)
    assert found.moved == (False,) * 4
    assert np.isfinite(found.mean).all()
    assert [(one.code, one.pass_name) for one in found.notices] == [
        ("pass-short", f"P{k}") for k in (1, 2, 3, 4)
    ]
    assert screen(RIBBON, passes(frames=STILL_FRAMES), CALIBRATION).notices == ()


def test_constant_counts_in_all_passes_are_dead_and_not_moved():
    nothing = Readings(np.arange(20) / 100, np.ones((20, len(RIBBON.columns))))
    found = screen(RIBBON, [Pass(f"P{k}", "pass", nothing) for k in (1, 2)], CALIBRATION)
    assert found.moved == (False, False)
    assert {notice.code for notice in found.notices} == {"sensor-dead"}
    assert not np.isfinite(found.mean).any()


def test_sensors_too_quiet_to_move_a_count_are_not_dead():
    quiet = [
        Pass(
            one.name,
            one.kind,
            Readings(
                one.readings.t, np.repeat(one.readings.counts[:1], len(one.readings.t), axis=0)
            ),
        )
        for one in passes(frames=20)
    ]
    found = screen(RIBBON, quiet, CALIBRATION)
    assert found.notices == ()
    assert np.isfinite(found.mean).all()
