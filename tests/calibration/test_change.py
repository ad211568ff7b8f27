"""What has changed between two calibrations: exact for exact models, silent about noise."""

from dataclasses import replace

import numpy as np
import pytest
from days import DIP, Ribbon

from georibbon.calibration.change import difference
from georibbon.calibration.expected import expected_errors
from georibbon.errors import CalibrationError
from georibbon.rotations import exp

NAME, PLACE = "A03", 4


@pytest.fixture(scope="module")
def ribbon():
    return Ribbon(seed=5)


def altered(calibration, place, change):
    sensors = list(calibration.sensors)
    sensors[place] = change(sensors[place])
    return replace(calibration, sensors=tuple(sensors))


def of(found, name):
    return next(one for one in found.sensors if one.name == name)


def test_nothing_has_changed_from_a_calibration_to_itself(ribbon):
    found = difference(ribbon.ribbon, ribbon.calibration, ribbon.calibration)
    assert max(one.degrees for one in found.sensors) < 1e-6
    assert found.turn < 1e-6
    assert found.words == "no sensor stands out, all have changed by less than 0.1°"


@pytest.mark.parametrize("place", [4, 5])
def test_a_turn_is_measured_exactly(ribbon, place):
    turn = np.array([0.6, -0.8, 1.5])
    new = altered(
        ribbon.calibration, place, lambda m: replace(m, gain=m.gain @ exp(np.radians(turn)))
    )
    name = ribbon.ribbon.sensors[place].name
    one = of(difference(ribbon.ribbon, ribbon.calibration, new), name)
    near = 0.02 if place == 4 else 0.3  # two axes tell turns less exactly
    assert one.tilt == pytest.approx(1.0, abs=near)
    assert one.heading == pytest.approx(1.5, abs=near)
    assert one.scale == pytest.approx(0.0, abs=0.05)
    assert one.stands_out


def test_the_change_is_told_in_words(ribbon):
    turn = exp(np.radians(np.array([0.0, 1.2, 0.0])))
    new = altered(ribbon.calibration, PLACE, lambda m: replace(m, gain=m.gain @ turn))
    found = difference(ribbon.ribbon, ribbon.calibration, new)
    assert found.words.startswith(f"{NAME} has changed by 1.0°, all others by less than 0.1°")


def test_bias_and_scale_are_measured(ribbon):
    unit = float(np.linalg.norm(ribbon.calibration.sensors[PLACE].gain)) / np.sqrt(3.0)
    new = altered(
        ribbon.calibration,
        PLACE,
        lambda m: replace(m, gain=m.gain * 1.02, bias=m.bias + 0.012 * unit * np.eye(3)[0]),
    )
    one = of(difference(ribbon.ribbon, ribbon.calibration, new), NAME)
    assert one.bias == pytest.approx(12.0)
    assert one.scale == pytest.approx(2.0)
    assert one.degrees == pytest.approx(np.degrees(np.hypot(0.02, 0.012)), rel=1e-6)


def test_a_turn_of_all_is_common_and_no_sensors(ribbon):
    turn = exp(np.radians(np.array([0.0, 0.0, 0.7])))
    new = replace(
        ribbon.calibration,
        sensors=tuple(replace(m, gain=m.gain @ turn) for m in ribbon.calibration.sensors),
    )
    found = difference(ribbon.ribbon, ribbon.calibration, new)
    assert found.turn == pytest.approx(0.7)
    assert max(one.degrees for one in found.sensors) < 1e-6
    assert "all together are turned by 0.7°" in found.words


def test_another_field_is_no_sensors_change(ribbon):
    factor = [1.04 if s.kind == "magnetometer" else 1.0 for s in ribbon.ribbon.sensors]
    new = replace(
        ribbon.calibration,
        dip=ribbon.calibration.dip - np.radians(2.0),
        sensors=tuple(
            replace(m, gain=m.gain * f)
            for m, f in zip(ribbon.calibration.sensors, factor, strict=True)
        ),
    )
    found = difference(ribbon.ribbon, ribbon.calibration, new)
    assert found.strength == pytest.approx(4.0)
    assert found.dip == pytest.approx(-2.0)
    assert max(one.degrees for one in found.sensors) < 1e-6
    assert "the field is 4.0 % stronger" in found.words
    assert "the field is 2.0° flatter" in found.words


@pytest.mark.parametrize(
    ("strength", "dip", "turn", "words"),
    [
        (0.9, 0.9, 0.2, ""),
        (1.1, 0.0, 0.0, "the field is 1.1 % stronger"),
        (0.0, 1.1, 0.0, "the field is 1.1° steeper"),
        (0.0, 0.0, 0.4, "all together are turned by 0.4°"),
    ],
)
def test_what_calibrations_of_an_unchanged_ribbon_differ_by_is_worth_no_word(
    ribbon, strength, dip, turn, words
):
    """strength in percent, dip and turn in degrees."""
    turned = exp(np.radians(np.array([turn, 0.0, 0.0])))
    factors = [
        1.0 + 0.01 * strength * (sensor.kind == "magnetometer") for sensor in ribbon.ribbon.sensors
    ]
    new = replace(
        ribbon.calibration,
        dip=ribbon.calibration.dip + np.radians(dip),
        sensors=tuple(
            replace(m, gain=f * m.gain @ turned)
            for m, f in zip(ribbon.calibration.sensors, factors, strict=True)
        ),
    )
    found = difference(ribbon.ribbon, ribbon.calibration, new)
    plain = "no sensor stands out, all have changed by less than 0.1°"
    assert found.words.startswith("; ".join([plain, words]) if words else plain)
    assert (found.words == plain) == (not words)


def test_sensors_lost_and_regained_are_named(ribbon):
    off = altered(ribbon.calibration, PLACE, lambda m: replace(m, used=False, reason="dead"))
    found = difference(ribbon.ribbon, ribbon.calibration, off)
    assert found.lost == (NAME,)
    assert np.isnan(of(found, NAME).degrees)
    assert f"no longer used: {NAME}" in found.words
    back = difference(ribbon.ribbon, off, ribbon.calibration)
    assert back.regained == (NAME,)
    assert f"used again: {NAME}" in back.words


def test_many_that_stand_out_are_counted(ribbon):
    turn = exp(np.radians(np.array([3.0, 0.0, 0.0])))
    new = ribbon.calibration
    for place in range(0, 12, 2):
        sign = turn if place % 4 else turn.T
        new = altered(new, place, lambda m, sign=sign: replace(m, gain=m.gain @ sign))
    pairs = difference(ribbon.ribbon, ribbon.calibration, new)
    marked = [one for one in pairs.sensors if one.stands_out]
    assert len(marked) in (0, 6)  # where most have changed none stands out


def test_without_any_sensor_in_common_nothing_is_told_of_turns(ribbon):
    none = replace(
        ribbon.calibration,
        sensors=tuple(replace(m, used=False, reason="-") for m in ribbon.calibration.sensors),
    )
    found = difference(ribbon.ribbon, ribbon.calibration, none)
    assert found.turn == 0.0
    assert len(found.lost) == 16


def test_two_calibrations_of_an_unchanged_ribbon_differ_in_no_sensor(ribbon):
    found = difference(ribbon.ribbon, ribbon.calibration, ribbon.calibrated(seat=0.05))
    assert not any(one.stands_out for one in found.sensors)
    assert found.words.startswith("no sensor stands out")


def test_a_turned_sensor_is_found_between_two_calibrations(ribbon):
    again = ribbon.calibrated(ribbon.changed("A05", turn=(0.0, 1.5, 0.0)), seat=0.05)
    found = difference(ribbon.ribbon, ribbon.calibration, again)
    assert [one.name for one in found.sensors if one.stands_out] == ["A05"]
    assert of(found, "A05").tilt == pytest.approx(1.5, abs=0.3)
    assert abs(found.dip) < 1.0


def test_another_ribbons_calibration_is_refused(ribbon):
    other = replace(ribbon.calibration, ribbon_id="GR-9")
    with pytest.raises(CalibrationError, match="GR-9"):
        difference(ribbon.ribbon, ribbon.calibration, other)


def test_expected_errors_have_their_uncertainty(ribbon):
    found = expected_errors(ribbon.ribbon, ribbon.calibration)
    quality = ribbon.calibration.quality
    assert (found.tilt, found.heading) == (quality.tilt, quality.heading)
    # Eight sensors of a kind: the root mean square of so few scatters by an eighth to a half.
    assert 0.1 * found.tilt < found.tilt_sigma < 0.3 * found.tilt
    assert 0.15 * found.heading < found.heading_sigma < 0.4 * found.heading
    assert expected_errors(ribbon.ribbon, replace(ribbon.calibration, quality=None)) is None


def test_what_is_common_to_all_alone_scatters_as_its_degrees_of_freedom_say(ribbon):
    """The root mean square of f normal errors scatters by 1/√(2 f) of itself, to the first order:
    f is 2 for the tilt of the bar, 1 for its heading.
    """
    gauge, level = 0.1, np.cos(ribbon.calibration.dip)
    common = replace(
        ribbon.calibration.quality, gauge=gauge, tilt=np.sqrt(2.0) * gauge, heading=gauge / level
    )
    found = expected_errors(ribbon.ribbon, replace(ribbon.calibration, quality=common))
    assert found.tilt_sigma == pytest.approx(found.tilt / 2.0)
    assert found.heading_sigma == pytest.approx(found.heading / np.sqrt(2.0))


def test_more_sensors_make_the_expected_error_surer(ribbon):
    few = expected_errors(ribbon.ribbon, ribbon.calibration)
    many = Ribbon(seed=5, sensors=32)
    more = expected_errors(many.ribbon, many.calibration)
    assert more.tilt_sigma / more.tilt < few.tilt_sigma / few.tilt


def test_a_perfect_calibration_has_no_uncertainty(ribbon):
    perfect = replace(ribbon.calibration.quality, tilt=0.0, heading=0.0, gauge=0.0)
    found = expected_errors(ribbon.ribbon, replace(ribbon.calibration, quality=perfect))
    assert (found.tilt_sigma, found.heading_sigma) == (0.0, 0.0)


def test_the_dip_of_the_place_is_found(ribbon):
    assert np.degrees(ribbon.calibration.dip) == pytest.approx(DIP, abs=0.5)
