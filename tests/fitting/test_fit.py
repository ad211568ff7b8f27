"""Whole fits: passes and survey together, what is assumed, what is named, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from laid import (
    DIP,
    both,
    calibration,
    constant,
    degrees_between,
    marked,
    plane,
    points_of,
    recording,
    ribbon,
    shape_of,
    sphere,
)

from georibbon.calibration.model import Calibration
from georibbon.errors import FitError
from georibbon.fitting.assessment import assess
from georibbon.fitting.capture import LEAST_ACCELEROMETERS, LEAST_MAGNETOMETERS, prepare
from georibbon.fitting.fit import FitSettings, fit_alone, fit_together
from georibbon.fitting.grid import Shape, integrate_frames, make_grid
from georibbon.fitting.paper import fit_paper
from georibbon.fitting.placing import AMBIGUOUS_WITHIN
from georibbon.fitting.screening import screen
from georibbon.recording import Crossing, Distance, Mark, Workpiece
from georibbon.ribbon import Ribbon, Sensor
from georibbon.rotations import about_z, exp
from georibbon.simulation.scoring import rigid_motion

RIBBON, RIBBON3 = ribbon(16), ribbon(16, 3)
GRID = make_grid(RIBBON)
LENGTH = float(GRID.nodes[-1])
OFFSETS = (-0.1, 0.0, 0.1)
HEADING = 0.7


def captured(made, calibrated=None):
    calibrated = calibrated or calibration(made.ribbon)
    return prepare(made, calibrated, screen(made.ribbon, made.passes, calibrated))


def fitted(made, *, neighbours=True, calibrated=None, **smoothing):
    """The joint fit of a recording with its capture."""
    capture, settings = captured(made, calibrated), FitSettings(neighbours, smoothing)
    candidates = fit_alone(capture, range(len(made.passes)), settings)
    return capture, fit_together(capture, candidates, settings)


def dome(of=RIBBON, seed=1, offsets=OFFSETS, **options):
    """A recording of great circles, and their true points."""
    shape, origin = sphere(make_grid(of), 0.5, offsets)
    points = points_of(GRID, shape, origin)
    survey = {"marks": marked(GRID, points), "heading": HEADING, **options}
    return recording(of, shape, seed=seed, **survey), points


def away(fit, points):
    """Metres, rms over all nodes."""
    return np.sqrt(np.mean(np.sum((fit.points - points) ** 2, axis=2)))


def away_aligned(fit, points):
    turn, shift = rigid_motion(fit.points.reshape(-1, 3), points.reshape(-1, 3))
    return away(replace(fit, points=fit.points @ turn.T + shift), points)


def codes(notices):
    return [notice.code for notice in notices]


# --- marks ---


@pytest.mark.parametrize("of", [RIBBON, RIBBON3], ids=["2 axes", "3 axes"])
@pytest.mark.parametrize("neighbours", [True, False])
def test_marks_at_both_ends_give_the_curves(of, neighbours):
    made, points = dome(of)
    capture, fit = fitted(made, neighbours=neighbours)
    assert away(fit, points) < 0.8e-3
    assert fit.notices == ()
    assert fit.ambiguous == (False,) * 3
    np.testing.assert_array_equal(fit.s, GRID.nodes)
    assert fit.present.all()
    assert assess(capture, fit, {})[1] == ()


def test_the_heading_is_found_whatever_it_is():
    shape, origin = sphere(GRID, 0.5, OFFSETS)
    points = points_of(GRID, shape, origin)
    for heading in np.radians([-170.0, -60.0, 10.0, 100.0]):
        made = recording(RIBBON, shape, seed=2, heading=heading, marks=marked(GRID, points))
        assert away(fitted(made)[1], points) < 0.8e-3


def test_smoothing_is_as_asked_or_by_the_evidence():
    made, _ = dome()
    capture = captured(made)
    asked = FitSettings(smoothing={"P1": 0.1, "*": 0.3})
    together = fit_together(capture, fit_alone(capture, range(3), asked), asked)
    np.testing.assert_allclose(together.lengths, [0.1, 0.3, 0.3])
    free = fit_together(capture, fit_alone(capture, range(3), FitSettings()), FitSettings())
    assert (free.lengths > 0.12).all()  # constant rates: long lengths


def test_a_mark_wrong_by_5_cm_does_not_bend_the_curves():
    made, points = dome()
    marks = list(made.marks)
    x, y, z = marks[3].position
    marks[3] = replace(marks[3], position=(x, y + 0.05, z))
    _, wrong = fitted(replace(made, marks=tuple(marks)))
    _, without = fitted(replace(made, marks=(*made.marks[:3], *made.marks[4:])))
    assert np.linalg.norm(wrong.points - without.points, axis=2).max() < 1.5e-3
    assert away(wrong, points) < 2.5e-3


# --- without a heading ---


def starts_only(seed=1, shape=None, origin=None, **survey):
    if shape is None:
        shape, origin = sphere(GRID, 0.5, OFFSETS)
    points = points_of(GRID, shape, origin)
    marks = marked(GRID, points, ends=(0,))
    made = recording(RIBBON, shape, seed=seed, heading=HEADING, marks=marks, **survey)
    return made, points


@pytest.mark.parametrize("surface", ["sphere", "plane"])
def test_starts_alone_assume_a_line_square_to_the_passes_and_say_so(surface):
    shape, origin = sphere(GRID, 0.5, OFFSETS) if surface == "sphere" else plane(GRID, OFFSETS)
    made, points = starts_only(shape=shape, origin=origin)
    _, fit = fitted(made)
    assert codes(fit.notices) == ["heading-assumed"]
    # Square it was: so the result is about right, and knows how little that says.
    sigma = np.sqrt(np.trace(fit.covariance[:, -1], axis1=1, axis2=2))
    assert (sigma < 0.05).all()
    assert np.linalg.norm(fit.points - points, axis=2).max() < 4 * sigma.max()


def test_one_mark_alone_leaves_magnetic_axes():
    shape, origin = sphere(GRID, 0.5, (0.0,))
    made, points = starts_only(shape=shape, origin=origin)
    _, fit = fitted(made)
    assert codes(fit.notices) == ["heading-assumed"]
    turned = (points - points[:, :1]) @ about_z(HEADING).T + points[:, :1]
    assert away(fit, turned) < 10e-3


# --- distances and crossings ---


def distances(points):
    out = []
    for k in range(len(points) - 1):
        for end in (0, -1):
            at = float(GRID.nodes[end])
            apart = float(np.linalg.norm(points[k + 1, end] - points[k, end]))
            out.append(Distance((f"P{k + 1}", f"P{k + 2}"), (at, at), apart, 5e-4))
    return tuple(out)


@pytest.mark.parametrize("order", [1, -1])
def test_distances_alone_place_neighbours_on_the_side_that_the_readings_tell(order):
    """Great circles that are parallel at their starts come together: on one side only."""
    shape, _ = sphere(GRID, 0.5, OFFSETS[::order])
    ahead = exp(np.array([0.0, 0.5 * LENGTH / 0.5, 0.0]))
    from_middle = Shape(shape.start @ ahead, shape.rates)
    points = points_of(GRID, from_middle, 0.5 * from_middle.start[:, :, 2])
    made = recording(RIBBON, from_middle, seed=3, distances=distances(points))
    _, fit = fitted(made)
    assert codes(fit.notices) == ["across-assumed"]
    np.testing.assert_allclose(fit.points[0, 0], 0.0, atol=1e-6)
    assert away_aligned(fit, points) < 3e-3


@pytest.mark.parametrize("order", [1, -1])
def test_the_papers_way_finds_that_side_too(order):
    shape, _ = sphere(GRID, 0.3, OFFSETS[::order])
    ahead = exp(np.array([0.0, 0.5 * LENGTH / 0.3, 0.0]))
    from_middle = Shape(shape.start @ ahead, shape.rates)
    points = points_of(GRID, from_middle, 0.3 * from_middle.start[:, :, 2])
    made = recording(RIBBON, from_middle, seed=3, distances=distances(points))
    fit = fit_paper(captured(made))
    assert codes(fit.notices) == ["across-assumed"]
    assert away_aligned(fit, points) < 8e-3


def test_on_a_plane_where_nothing_tells_neighbours_are_to_the_left():
    shape, origin = plane(GRID, (0.0, 0.1))
    points = points_of(GRID, shape, origin)
    made = recording(RIBBON, shape, seed=3, distances=distances(points))
    _, fit = fitted(made)
    across = (fit.points[1] - fit.points[0]).mean(axis=0)
    assert across @ fit.frames[0, 8, :, 1] > 0.09


def test_ties_place_passes_without_marks():
    shape, origin = sphere(GRID, 0.5, OFFSETS)
    quarter = about_z(np.pi / 2)
    tie, tie_origin = sphere(GRID, 0.5, (-0.12, 0.12))
    ties = Shape(quarter @ tie.start, tie.rates)
    everything = both(shape, ties)
    points = points_of(GRID, everything, np.concatenate([origin, tie_origin @ quarter.T]))
    crossings = []
    for p in range(3):
        for t in (3, 4):
            gap = np.linalg.norm(points[p][:, None] - points[t][None], axis=2)
            a, b = np.unravel_index(np.argmin(gap), gap.shape)
            # The nodes nearest to the crossing, and the rest of the way along either.
            chord = points[t, b] - points[p, a]
            frames = integrate_frames(GRID, everything)
            s = GRID.nodes[a] + chord @ frames[p, a, :, 0]
            u = GRID.nodes[b] - chord @ frames[t, b, :, 0]
            names = (f"P{p + 1}", f"T{t - 2}")
            crossings.append(Crossing(names, (float(s), float(u)), 1e-3))
    made = recording(
        RIBBON,
        everything,
        names=("P1", "P2", "P3", "T1", "T2"),
        seed=4,
        heading=HEADING,
        crossings=tuple(crossings),
    )
    _, fit = fitted(made)
    assert fit.notices == ()
    assert away_aligned(fit, points) < 2e-3
    np.testing.assert_allclose(fit.points[0, 0], 0.0, atol=1e-6)


def test_passes_that_nothing_holds_are_refused_by_name():
    shape, origin = sphere(GRID, 0.5, OFFSETS)
    points = points_of(GRID, shape, origin)
    made = recording(RIBBON, shape, seed=1, marks=marked(GRID, points)[:4])
    for way in (lambda: fitted(made), lambda: fit_paper(captured(made))):
        with pytest.raises(FitError, match="pass P3"):
            way()


# --- two shapes ---


def wall(headings=(0.0, 0.05), of=RIBBON, **options):
    """Passes level along a wall of 1 m radius, one above the other."""
    upright = exp(np.array([np.pi / 2, 0.0, 0.0]))
    shapes = both(
        *(
            shape_of(GRID, about_z(angle) @ upright, constant(0.0), constant(1.0))
            for angle in headings
        )
    )
    origin = np.array([[0.0, 0.0, 0.1 * k] for k in range(len(headings))])
    points = points_of(GRID, shapes, origin)
    ends = options.pop("ends", (0, -1))
    marks = marked(GRID, points, ends)
    return recording(of, shapes, seed=5, marks=marks, **options), points


def test_marks_tell_the_twins_apart():
    made, points = wall(heading=0.3)
    _, fit = fitted(made, neighbours=False)
    assert away(fit, points) < 3e-3
    assert fit.ambiguous == (False, False)


def told(made):
    """The same with the heading known."""
    return replace(made, workpiece=Workpiece(True, 0.0))


def test_where_nothing_tells_them_apart_it_is_said():
    made, points = wall(headings=(0.4,), ends=(0,))
    capture, fit = fitted(told(made))
    assert fit.ambiguous == (True,)
    assert codes(fit.notices) == ["ambiguous-shape"]
    assert fit.notices[0].pass_name == "P1"
    assert assess(capture, fit, {})[0][0].verdict == "redo"
    assert AMBIGUOUS_WITHIN == 10.0
    three, _ = wall(headings=(0.4,), ends=(0,), of=RIBBON3)
    assert fitted(told(three))[1].ambiguous == (False,)
    np.testing.assert_allclose(points[0, 0], 0.0, atol=1e-12)


# --- faults ---


def with_magnet(made, name="P2", sensors=("M03", "M04", "M05", "M06"), strength=0.25):
    """A magnet of a quarter of the field beside some magnetometers of one pass."""
    passes = []
    for one in made.passes:
        values = one.readings.counts.copy()
        if one.name == name:
            for sensor, columns in zip(made.ribbon.sensors, made.ribbon.slices, strict=True):
                if sensor.name in sensors:
                    push = strength * sensor.counts_per_unit * np.array([0.7, -0.7, 0.3])
                    values[:, columns] += push[: sensor.axes]
        passes.append(replace(one, readings=replace(one.readings, counts=values)))
    return replace(made, passes=tuple(passes))


@pytest.mark.parametrize("of", [RIBBON, RIBBON3], ids=["2 axes", "3 axes"])
def test_a_magnet_is_named_and_does_little_harm(of):
    made, points = dome(of)
    made = with_magnet(made)
    capture, fit = fitted(made)
    assert away(fit, points) < 1.5e-3
    notices = assess(capture, fit, {})[1]
    disturbed = {notice.sensor for notice in notices if notice.code == "field-disturbed"}
    assert disturbed == {"M03", "M04", "M05", "M06"}
    assert {notice.pass_name for notice in notices} == {"P2"}


def dead(made, names):
    passes = []
    for one in made.passes:
        values = one.readings.counts.copy()
        for sensor, columns in zip(made.ribbon.sensors, made.ribbon.slices, strict=True):
            if sensor.name in names:
                values[:, columns] = 0.0
        passes.append(replace(one, readings=replace(one.readings, counts=values)))
    return replace(made, passes=tuple(passes))


def test_two_dead_sensors_are_left_out_and_do_little_harm():
    made, points = dome()
    capture, fit = fitted(dead(made, ("A03", "M06")))
    assert away(fit, points) < 1.5e-3
    assert not fit.present[:, [4, 11]].any()
    assert assess(capture, fit, {})[0][0].ignored == ("A03", "M06")


def test_magnetometers_that_say_nonsense_are_a_bad_pass_and_no_crash():
    made, _ = dome()
    names = tuple(sensor.name for sensor in RIBBON.sensors if sensor.name.startswith("M"))
    capture, fit = fitted(with_magnet(made, sensors=names, strength=5.0))
    assert assess(capture, fit, {})[0][1].verdict == "redo"
    assert np.isfinite(fit.points).all()


@pytest.mark.parametrize(
    ("letter", "kind", "least"),
    [("A", "accelerometers", LEAST_ACCELEROMETERS), ("M", "magnetometers", LEAST_MAGNETOMETERS)],
)
def test_too_few_live_sensors_are_refused(letter, kind, least):
    made, _ = dome()
    names = [sensor.name for sensor in RIBBON.sensors if sensor.name.startswith(letter)]
    captured(dead(made, names[least:]))
    with pytest.raises(FitError, match=rf"pass P1: {least - 1} {kind} .*at least {least}"):
        captured(dead(made, names[least - 1 :]))


# --- ribbons of other makes ---


def made_of(sensors):
    length = 0.48
    out = Ribbon("GR-0002", length, 100.0, tuple(sensors))
    grid = make_grid(out)
    shape, origin = sphere(grid, 0.5, OFFSETS)
    points = points_of(grid, shape, origin)
    marks = marked(grid, points)
    return recording(out, shape, seed=6, heading=HEADING, marks=marks), points


def test_accelerometer_and_magnetometer_may_sit_at_one_place():
    pairs = []
    for k in range(8):
        place = 0.03 + 0.06 * k
        pairs.append(Sensor(f"A{k + 1}", "accelerometer", 3, place, 16384.0))
        pairs.append(Sensor(f"M{k + 1}", "magnetometer", 3, place, 2000.0))
    made, points = made_of(pairs)
    assert away(fitted(made)[1], points) < 1.5e-3
    assert away(fit_paper(captured(made)), points) < 3e-3


def test_sensors_may_be_unevenly_spaced_and_listed_in_any_order():
    places = np.array([0.0, 0.02, 0.05, 0.11, 0.15, 0.16, 0.22, 0.27, 0.3, 0.38, 0.41, 0.48])
    sensors = [
        Sensor(f"A{k}", "accelerometer", 3, float(s), 16384.0)
        if k % 2
        else Sensor(f"M{k}", "magnetometer", 2, float(s), 2000.0)
        for k, s in enumerate(places)
    ]
    made, points = made_of([*sensors[6:], *sensors[:6]])
    assert away(fitted(made)[1], points) < 2e-3
    assert away(fit_paper(captured(made)), points) < 4e-3


def test_two_magnetometers_may_sit_at_one_place():
    sensors = []
    for k in range(6):
        place = 0.04 + 0.08 * k
        sensors.append(Sensor(f"A{k + 1}", "accelerometer", 3, place, 16384.0))
        sensors.append(Sensor(f"M{k + 1}L", "magnetometer", 3, place, 2000.0))
        sensors.append(Sensor(f"M{k + 1}R", "magnetometer", 3, place, 2000.0))
    made, points = made_of(sensors)
    assert away(fitted(made)[1], points) < 2e-3


# --- laws of the whole ---


def test_the_fit_knows_no_difference_between_passes_and_their_order():
    made, _ = dome()
    _, forth = fitted(made)
    backwards = replace(made, passes=made.passes[::-1], marks=made.marks[::-1])
    _, back = fitted(backwards)
    np.testing.assert_allclose(back.points[::-1], forth.points, atol=0.05e-3)


def test_turning_and_shifting_the_marks_turns_and_shifts_the_result():
    made, _ = dome()
    turn, shift = about_z(2.2), np.array([3.0, -1.0, 0.5])
    marks = tuple(
        Mark(m.pass_name, m.at, tuple(turn @ m.position + shift), m.sigma) for m in made.marks
    )
    _, here = fitted(made)
    _, there = fitted(replace(made, marks=marks))
    np.testing.assert_allclose(there.points, here.points @ turn.T + shift, atol=0.02e-3)
    np.testing.assert_allclose(there.frames, turn @ here.frames, atol=1e-3)
    np.testing.assert_allclose(
        there.covariance, turn @ here.covariance @ turn.T, atol=0.02 * here.covariance.max()
    )


def test_a_less_sure_calibration_makes_less_sure_curves():
    made, _ = dome()
    sigmas = []
    for factor in (1.0, 4.0):
        calibrated = calibration(RIBBON)
        doubtful = Calibration(
            calibrated.ribbon_id,
            DIP,
            calibrated.sensors,
            mounting_sigma=factor * calibrated.mounting_sigma,
            gauge_sigma=factor * 0.001,
            dip_sigma=factor * 0.002,
        )
        fit = fitted(made, calibrated=doubtful)[1]
        sigmas.append(np.trace(fit.covariance, axis1=2, axis2=3).mean())
    assert sigmas[1] > 1.5 * sigmas[0]


def test_frames_and_points_belong_together():
    made, _ = dome()
    _, fit = fitted(made)
    steps = np.diff(fit.points, axis=1)
    tangents = steps / np.linalg.norm(steps, axis=2, keepdims=True)
    ahead = 0.5 * (fit.frames[:, 1:, :, 0] + fit.frames[:, :-1, :, 0])
    assert np.degrees(np.abs(tangents - ahead).max()) < 0.1
    eye = np.broadcast_to(np.eye(3), fit.frames.shape)
    assert degrees_between(fit.frames @ np.swapaxes(fit.frames, 2, 3), eye).max() < 1e-5


def test_without_a_neighbour_it_makes_no_difference_to_ask_for_neighbours():
    """One pass with five marks, of which one is wrong by 2 cm."""
    shape, origin = sphere(GRID, 0.5, (0.0,))
    points = points_of(GRID, shape, origin)
    marks = list(marked(GRID, points, ends=(0, 8, 16, 24, -1)))
    x, y, z = marks[2].position
    marks[2] = replace(marks[2], position=(x, y + 0.02, z))
    made = recording(RIBBON, shape, seed=8, heading=HEADING, marks=tuple(marks))
    with_them, alone = (fitted(made, neighbours=yes)[1] for yes in (True, False))
    np.testing.assert_allclose(with_them.points, alone.points, atol=1e-5)
    assert away(alone, points) < 1.5e-3
