"""The joint adjustment: against an independent cost, dense algebra, and what it must find."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from laid import (
    DIP,
    FLAT,
    both,
    constant,
    degrees_between,
    lay,
    plane,
    ribbon,
    shape_of,
    sphere,
    wavy,
)

from georibbon.fitting.grid import (
    Shape,
    integrate_frames,
    integrate_positions,
    make_grid,
)
from georibbon.fitting.joint import (
    JointProblem,
    State,
    cost_of,
    descend,
    evaluate,
    place,
    whiten_all,
    with_survey,
)
from georibbon.fitting.result import normal_sigma, of_adjustment, position_covariance
from georibbon.fitting.sensing import Noise
from georibbon.fitting.shared import Shared, SharedSigmas
from georibbon.fitting.strip import ROBUST_LIMIT
from georibbon.fitting.survey import ChordSet, CrossingSet, DistanceSet, MarkSet
from georibbon.rotations import about_z, exp
from georibbon.world import field_direction

RIBBON = ribbon(10)
GRID = make_grid(RIBBON)
LENGTH = float(GRID.nodes[-1])
N, M = len(RIBBON.sensors), GRID.unknowns
MAGNETIC = np.array([sensor.kind == "magnetometer" for sensor in RIBBON.sensors])
HEADING = 0.6
UP = np.array([0.0, 0.0, 1.0])
SIGMAS = SharedSigmas(heading=1e3, dip=0.01, mounting=0.004, gauge=0.002, offset=0.003)
MARK_SIGMA = 5e-4


@dataclass(frozen=True, eq=False)
class Case:
    """A joint problem and its truth."""

    problem: JointProblem
    truth: State

    @property
    def points(self):
        frames = integrate_frames(GRID, self.truth.shape)
        return integrate_positions(GRID, self.truth.shape, frames) + self.truth.origin[:, None]


def marks(points, nodes=(0, -1), sigma=MARK_SIGMA):
    """Marks of every pass at some nodes, exact."""
    passes = np.repeat(np.arange(len(points)), len(nodes))
    places = np.tile(nodes, len(points))
    return MarkSet(passes, GRID.nodes[places], points[passes, places], np.full(len(passes), sigma))


def case(shape, origin, *, seed=None, skew_seed=None, sigmas=SIGMAS, smoothing=1e-4, survey=None):
    """The passes in the workpiece frame, the field HEADING away from its y axis."""
    laid = lay(RIBBON, shape, seed=seed, skew_seed=skew_seed, heading=HEADING)
    p = len(origin)
    zero = np.zeros((N, 3))
    frames = integrate_frames(GRID, shape)
    points = integrate_positions(GRID, shape, frames) + origin[:, None]
    problem = JointProblem(
        grid=GRID,
        array=laid.problem.array,
        observations=laid.problem.observations,
        noise=Noise(),
        smoothing=np.full(p, smoothing),
        survey=(marks(points),) if survey is None else survey(points),
        anchors=np.zeros((p, 3)),
        anchor_sigma=np.full(p, 1e3),
        expected=Shared(0.0, DIP, zero, zero),
        sigmas=sigmas,
    )
    return Case(problem, State(shape, origin, Shared(HEADING, DIP, zero, zero)))


def stepped(state, x):
    """The state after a step x of all unknowns: passes (m + 3 each), heading, dip, tilt, offset."""
    p = len(state.origin)
    passes = x[: p * (M + 3)].reshape(p, M + 3)
    shared = x[p * (M + 3) :]
    tilt = shared[2 : 2 + 3 * N].reshape(N, 3)
    offset = np.zeros((N, 3))
    offset[MAGNETIC] = shared[2 + 3 * N :].reshape(-1, 3)
    was = state.shared
    return State(
        state.shape.moved(passes[:, :M]),
        state.origin + passes[:, M:],
        Shared(was.heading + shared[0], was.dip + shared[1], was.tilt + tilt, was.offset + offset),
    )


def unknowns(p):
    return p * (M + 3) + 2 + 3 * N + 3 * int(MAGNETIC.sum())


def residuals(problem, state, white):
    """Everything that is squared, written out anew: (sensors, marks, priors)."""
    frames = integrate_frames(GRID, state.shape)
    points = integrate_positions(GRID, state.shape, frames) + state.origin[:, None]
    shared, sigmas = state.shared, problem.sigmas
    field = about_z(-shared.heading) @ [0.0, np.cos(shared.dip), -np.sin(shared.dip)]
    sensors = np.zeros((len(points), N, 3))
    for i, node in enumerate(GRID.sensor_nodes):
        seen = (field if MAGNETIC[i] else UP) @ frames[:, node]
        seen = seen - np.cross(shared.tilt[i], seen)
        said = seen @ problem.array.gain[i].T + shared.offset[i]
        raw = said - problem.observations.values[:, i]
        sensors[:, i] = np.einsum("pab,pb->pa", white[:, i], raw)
    (survey,) = problem.survey
    there = np.searchsorted(GRID.nodes, survey.at - 1e-9)
    marked = (points[survey.i, there] - survey.position) / survey.sigma[:, None]
    values, vectors = np.linalg.eigh(GRID.roughness)
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    rough = np.sqrt(problem.smoothing)[:, None, None] * (state.shape.rates @ root.T)
    anchored = (state.origin - problem.anchors) / problem.anchor_sigma[:, None]
    spread = np.linalg.cholesky(sigmas.mounting**2 * np.eye(N) + sigmas.gauge**2 * np.ones((N, N)))
    tilt = np.linalg.solve(spread, shared.tilt - problem.expected.tilt)
    offset = (shared.offset - problem.expected.offset)[MAGNETIC] / sigmas.offset
    angles = [
        (shared.heading - problem.expected.heading) / sigmas.heading,
        (shared.dip - problem.expected.dip) / sigmas.dip,
    ]
    priors = [rough.ravel(), anchored.ravel(), tilt.ravel(), offset.ravel(), np.array(angles)]
    return sensors, marked, np.concatenate(priors)


def robust(squares):
    limit = ROBUST_LIMIT**2
    return np.where(
        squares <= limit, squares, limit + limit * np.log(np.maximum(squares, limit) / limit)
    )


def linear(squares):
    """Huber's."""
    size = np.sqrt(squares)
    return np.where(size <= ROBUST_LIMIT, squares, 2 * ROBUST_LIMIT * size - ROBUST_LIMIT**2)


def cost(problem, state, white, marks_count=robust):
    sensors, marked, priors = residuals(problem, state, white)
    return (
        robust(np.sum(sensors**2, axis=2)).sum()
        + marks_count(np.sum(marked**2, axis=1)).sum()
        + np.sum(priors**2)
    )


def jacobian(problem, state, white, step=1e-6):
    columns = []
    for k in range(unknowns(len(state.origin))):
        x = np.zeros(unknowns(len(state.origin)))
        x[k] = step
        ahead, behind = (residuals(problem, stepped(state, way * x), white) for way in (1, -1))
        columns.append(
            np.concatenate([(a - b).ravel() for a, b in zip(ahead, behind, strict=True)])
            / (2 * step)
        )
    return np.stack(columns, axis=1)


def lively(**options):
    """Two passes with marks, sensors askew."""
    shape = both(wavy(GRID, exp(np.array([0.2, 0.1, 0.3]))), wavy(GRID, scale=-1.0))
    return case(shape, np.array([[0.1, 0, 0], [0, 0.2, 0.05]]), skew_seed=3, **options)


def shaken(state, seed=1, degrees=2.0):
    """The state somewhat off."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=unknowns(len(state.origin)))
    p = len(state.origin)
    passes = x[: p * (M + 3)].reshape(p, -1)
    passes[:, :3] *= np.radians(degrees)
    passes[:, 3:M] *= 0.1
    passes[:, M:] *= 0.005
    x[p * (M + 3) :] = 0.0
    x[p * (M + 3)] = np.radians(degrees)
    return stepped(state, x)


# --- against independent algebra ---


def test_the_covariance_is_the_dense_inverse_of_independent_equations():
    of = lively()
    j = jacobian(of.problem, of.truth, whiten_all(of.problem, of.truth))
    scale = 1 / np.sqrt(np.sum(j**2, axis=0))
    j = j * scale
    dense = np.linalg.inv(j.T @ j) * scale * scale[:, None]
    found = evaluate(of.problem, of.truth)
    for p in range(2):
        part = slice(p * (M + 3), (p + 1) * (M + 3))
        sigma = np.sqrt(np.diag(dense[part, part]))
        np.testing.assert_allclose(
            found.covariance[p] / np.outer(sigma, sigma),
            dense[part, part] / np.outer(sigma, sigma),
            atol=1e-4,
        )
    heading = 2 * (M + 3)
    assert found.heading_sigma == pytest.approx(np.sqrt(dense[heading, heading]), rel=1e-3)


@pytest.mark.parametrize(("firm", "marks_count"), [(False, robust), (True, linear)])
def test_the_descent_ends_where_an_independent_cost_is_least(firm, marks_count):
    """Its gradient there, in the metric of the covariance, is nothing; one mark is 5 mm off."""
    of = lively(seed=4)
    (survey,) = of.problem.survey
    position = survey.position.copy()
    position[2, 1] += 0.005
    problem = replace(of.problem, firm=firm, survey=(replace(survey, position=position),))
    of = replace(of, problem=problem)
    begin = shaken(of.truth)
    white = whiten_all(of.problem, begin)
    end = descend(of.problem, begin, iterations=100, tolerance=1e-10)
    j = jacobian(of.problem, end, white)
    total = unknowns(2)
    gradient = np.zeros(total)
    for k in range(total):
        x = np.zeros(total)
        x[k] = 1e-6
        ahead, behind = (
            cost(of.problem, stepped(end, way * x), white, marks_count) for way in (1, -1)
        )
        gradient[k] = (ahead - behind) / 2e-6
    scale = 1 / np.sqrt(np.sum(j**2, axis=0))
    j = j * scale
    decrement = (gradient * scale) @ np.linalg.solve(j.T @ j, gradient * scale) / 4
    assert decrement < 1e-4
    assert cost(problem, end, white, marks_count) < cost(problem, of.truth, white, marks_count)


def test_the_adjustment_tells_the_independent_cost_and_residuals():
    of = lively(seed=5)
    state = shaken(of.truth, degrees=0.2)
    white = whiten_all(of.problem, state)
    found = evaluate(of.problem, state)
    sensors, marked, _ = residuals(of.problem, state, white)
    np.testing.assert_allclose(found.residuals, sensors, atol=1e-9)
    np.testing.assert_allclose(found.squares, np.sum(sensors**2, axis=2), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.rows[0].residuals, marked, atol=1e-7)
    np.testing.assert_array_equal(found.white, white)
    diagonal = np.abs(np.diagonal(white, axis1=-2, axis2=-1))
    expected = cost(of.problem, state, white) - 2 * np.log(diagonal).sum()
    assert found.cost == pytest.approx(expected, rel=1e-9)
    firmly = cost(of.problem, state, white, linear) - 2 * np.log(diagonal).sum()
    assert cost_of(of.problem, state) == pytest.approx(firmly, rel=1e-9)
    assert firmly > expected + 10


def test_placing_gives_the_curves_of_the_state():
    of = lively()
    here = place(of.problem, of.truth)
    np.testing.assert_allclose(here.points, of.points, atol=1e-13)
    np.testing.assert_allclose(here.frames, integrate_frames(GRID, of.truth.shape), atol=1e-14)


# --- exact data, exact result ---


@pytest.mark.parametrize("surface", ["plane", "sphere"])
def test_exact_data_give_the_exact_surface(surface):
    offsets = (-0.1, 0.0, 0.1)
    shape, origin = plane(GRID, offsets) if surface == "plane" else sphere(GRID, 0.4, offsets)
    of = case(shape, origin)
    found = evaluate(of.problem, descend(of.problem, shaken(of.truth), 50, tolerance=1e-12))
    assert np.abs(found.placed.points - of.points).max() < 2e-6
    apart = degrees_between(found.placed.frames, integrate_frames(GRID, of.truth.shape))
    assert apart.max() < 0.01
    assert found.state.shared.heading == pytest.approx(HEADING, abs=1e-5)
    assert found.squares.max() < 1e-3


def test_the_heading_is_found_from_marks_at_both_ends_and_not_from_starts():
    shape, origin = plane(GRID, (0.0, 0.1))
    ends = case(shape, origin)
    starts = case(shape, origin, survey=lambda points: (marks(points, (0,)),))
    assert evaluate(ends.problem, ends.truth).heading_sigma < np.radians(0.5)
    assert evaluate(starts.problem, starts.truth).heading_sigma > 10.0
    end = descend(ends.problem, shaken(ends.truth, degrees=10.0), 50, tolerance=1e-10)
    assert end.shared.heading == pytest.approx(HEADING, abs=1e-4)


def test_crossings_and_distances_hold_passes_as_marks_do():
    """Two passes and a tie across them: the marks of one pass place the others."""
    flat = shape_of(GRID, FLAT, constant(0.0), constant(0.0))
    tie = shape_of(GRID, about_z(np.pi / 2), constant(0.0), constant(0.0))
    origin = np.array([[0.0, 0, 0], [0, 0.2, 0], [0.15, -0.05, 0]])

    def survey(points):
        at = np.array([[0.15, 0.05], [0.15, 0.25]])
        sigma = np.full(2, 1e-3)
        return (
            marks(points[:1]),
            CrossingSet(np.array([0, 1]), np.array([2, 2]), at, sigma),
            DistanceSet(
                np.array([0, 0]),
                np.array([1, 1]),
                np.array([[0, 0], [LENGTH] * 2]),
                np.full(2, 0.2),
                sigma,
            ),
        )

    of = case(both(flat, flat, tie), origin, survey=survey)
    begin = shaken(of.truth)
    found = evaluate(of.problem, descend(of.problem, begin, 50, tolerance=1e-12))
    assert np.abs(found.placed.points - of.points).max() < 5e-6
    sigma = [np.sqrt(np.trace(part[-3:, -3:])) for part in found.covariance]
    assert sigma[0] < sigma[1] < 0.01
    loose = case(both(flat, flat, tie), origin, survey=lambda points: survey(points)[:1])
    assert np.sqrt(np.trace(evaluate(loose.problem, loose.truth).covariance[1][-3:, -3:])) > 100


@pytest.mark.parametrize(("turn", "shift"), [(0.9, (1.0, -2.0, 0.3)), (-2.8, (0.0, 0.5, 0.0))])
def test_turning_and_shifting_the_marks_turns_and_shifts_the_result(turn, shift):
    of = lively(seed=6)
    begin = shaken(of.truth)
    rotation = about_z(turn)
    (survey,) = of.problem.survey
    moved = replace(survey, position=survey.position @ rotation.T + shift)
    there = replace(of.problem, survey=(moved,))
    other = State(
        Shape(rotation @ begin.shape.start, begin.shape.rates),
        begin.origin @ rotation.T + shift,
        replace(begin.shared, heading=begin.shared.heading - turn),
    )
    one = descend(of.problem, begin, 50, tolerance=1e-10)
    two = descend(there, other, 50, tolerance=1e-10)
    points = place(of.problem, one).points @ rotation.T + shift
    np.testing.assert_allclose(place(there, two).points, points, atol=2e-7)
    assert two.shared.heading == pytest.approx(one.shared.heading - turn, abs=1e-6)
    spread = [
        position_covariance(found.placed, found.covariance)
        for found in (evaluate(of.problem, one), evaluate(there, two))
    ]
    np.testing.assert_allclose(
        spread[1], rotation @ spread[0] @ rotation.T, atol=1e-4 * np.abs(spread[0]).max()
    )


# --- what all passes share ---


def many(count, **options):
    """Passes on a saddle-like fan with marks, so that shared errors show."""
    rng = np.random.default_rng(9)
    shapes = [
        wavy(GRID, exp(np.array([0.3, 0.3, 0.6]) * rng.normal(size=3)), scale=rng.normal())
        for _ in range(count)
    ]
    origin = np.stack([np.zeros(count), 0.1 * np.arange(count), np.zeros(count)], axis=1)
    return case(both(*shapes), origin, **options)


def spoiled(of, shared):
    """The readings as they are with these sensor errors and this dip; the truth tells them."""
    frames = integrate_frames(GRID, of.truth.shape)[:, GRID.sensor_nodes]
    array, values = of.problem.array, of.problem.observations.values.copy()
    before, after = (
        np.where(MAGNETIC[:, None], field_direction(dip, HEADING), UP) for dip in (DIP, shared.dip)
    )
    change = (after - before)[:, None] @ frames
    seen = after[:, None] @ frames
    change = (change + np.cross(seen, shared.tilt[:, None]))[:, :, 0]
    values += ((array.gain @ change[..., None])[..., 0] + shared.offset) * array.axes
    observed = replace(of.problem.observations, values=values)
    truth = replace(of.truth, shared=replace(shared, heading=HEADING))
    return replace(of, problem=replace(of.problem, observations=observed), truth=truth)


def shared_errors(**values):
    """No errors but those given."""
    zero = {"tilt": np.zeros((N, 3)), "offset": np.zeros((N, 3)), "dip": DIP}
    return Shared(heading=HEADING, **{**zero, **values})


def begun(of):
    """The true curves, without knowing the shared errors."""
    return replace(of.truth, shared=replace(of.problem.expected, heading=HEADING))


def test_a_sensors_error_that_every_pass_sees_is_recovered():
    tilt = np.zeros((N, 3))
    tilt[4] = [0.02, -0.015, 0.01]
    sigmas = replace(SIGMAS, mounting=0.02, gauge=1e-4)
    of = spoiled(many(8, sigmas=sigmas), shared_errors(tilt=tilt))
    end = descend(of.problem, begun(of), 50, tolerance=1e-8)
    np.testing.assert_allclose(end.shared.tilt[4], tilt[4], atol=0.005)
    assert np.abs(np.delete(end.shared.tilt, 4, axis=0)).max() < 0.006
    fixed = replace(of.problem, sigmas=replace(sigmas, mounting=1e-5, gauge=1e-6))
    stiff = descend(fixed, begun(of), 50, tolerance=1e-8)
    free_error, stiff_error = (
        np.abs(place(of.problem, state).points - of.points).max() for state in (end, stiff)
    )
    assert free_error < 0.5 * stiff_error


def test_a_wrong_dip_is_put_right():
    of = spoiled(many(6), shared_errors(dip=DIP + 0.008))
    end = descend(of.problem, begun(of), 50, tolerance=1e-8)
    assert end.shared.dip == pytest.approx(DIP + 0.008, abs=0.003)


def test_a_magnetometers_offset_is_recovered():
    offset = np.zeros((N, 3))
    offset[5, :2] = [0.02, -0.01]
    of = spoiled(many(8, sigmas=replace(SIGMAS, offset=0.02)), shared_errors(offset=offset))
    end = descend(of.problem, begun(of), 50, tolerance=1e-8)
    np.testing.assert_allclose(end.shared.offset[5, :2], [0.02, -0.01], atol=0.005)
    assert (end.shared.offset[~MAGNETIC] == 0).all()


def test_what_all_share_counts_in_the_covariance():
    sure = evaluate((of := many(4)).problem, of.truth)
    doubtful = replace(of.problem, sigmas=replace(SIGMAS, mounting=0.02, gauge=0.02))
    unsure = evaluate(doubtful, of.truth)
    for one, other in zip(sure.covariance, unsure.covariance, strict=True):
        assert np.trace(other[:M, :M]) > np.trace(one[:M, :M])


def test_a_mark_wrong_by_5_cm_does_not_bend_the_curves():
    of = many(3, seed=7)
    (survey,) = of.problem.survey
    position = survey.position.copy()
    position[1] += [0.0, 0.05, 0.0]
    wrong = replace(of.problem, survey=(replace(survey, position=position),))
    right = descend(of.problem, of.truth, 50)
    end = descend(wrong, of.truth, 50)
    away = np.linalg.norm(place(wrong, end).points - place(of.problem, right).points, axis=2)
    assert away.max() < 4e-3
    rows = evaluate(wrong, end).rows[0]
    assert int(np.argmax(rows.squares)) == 1


def drawn(seed):
    """Two passes with everything drawn that the problem says is uncertain; the marks, too."""
    rng = np.random.default_rng(seed + 1000)
    draw = rng.standard_normal
    tilt = SIGMAS.mounting * draw((N, 3)) + SIGMAS.gauge * draw(3)
    offset = SIGMAS.offset * draw((N, 3)) * MAGNETIC[:, None]
    shared = shared_errors(tilt=tilt, offset=offset, dip=DIP + SIGMAS.dip * draw())
    of = spoiled(many(2, seed=seed), shared)
    (survey,) = of.problem.survey
    measured = replace(survey, position=survey.position + MARK_SIGMA * draw((4, 3)))
    return replace(of, problem=replace(of.problem, survey=(measured,)))


def test_the_joint_covariance_is_honest():
    """Over 40 draws of readings, marks and shared errors these are as large as they are said."""
    ratios = []
    for seed in range(40):
        of = drawn(seed)
        found = evaluate(of.problem, descend(of.problem, begun(of)))
        spread = position_covariance(found.placed, found.covariance)
        variance = np.diagonal(spread, axis1=2, axis2=3)
        away = found.placed.points - of.points
        true_normals = integrate_frames(GRID, of.truth.shape)[..., 2]
        tilted = np.sum(np.cross(true_normals, found.placed.frames[..., 2]) ** 2, axis=2)
        sigma = normal_sigma(found.placed, found.covariance)
        ratios.append([np.mean(away**2 / variance), np.mean(tilted / (2 * sigma**2))])
    points, normals = np.sqrt(np.mean(ratios, axis=0))
    assert 0.8 < points < 1.25
    assert 0.8 < normals < 1.25


# --- the rest ---


def test_a_start_at_the_minimum_is_left_as_it_is():
    of = lively()
    end = descend(of.problem, of.truth, tolerance=1e-6)
    np.testing.assert_allclose(place(of.problem, end).points, of.points, atol=1e-5)


def test_asked_for_more_than_numbers_hold_the_descent_ends():
    of = lively(seed=2)
    near = descend(of.problem, of.truth, 50, tolerance=1e-9)
    end = descend(of.problem, near, 200, tolerance=0.0)
    np.testing.assert_allclose(
        place(of.problem, end).points, place(of.problem, near).points, atol=2e-5
    )


def test_a_survey_grows_without_touching_the_old_one():
    of = lively()
    more = ChordSet(np.array([0]), np.array([1]), np.zeros((1, 2)), np.zeros(1), np.ones(1))
    grown = with_survey(of.problem, more, more)
    assert grown.survey == (*of.problem.survey, more, more)
    assert len(of.problem.survey) == 1


def test_where_no_step_helps_the_descent_ends():
    """Readings far beyond anything: the cost is flat, and nothing loops."""
    of = lively()
    values = np.where(of.problem.observations.values != 0, 1e9, 0.0)
    problem = replace(of.problem, observations=replace(of.problem.observations, values=values))
    end = descend(problem, of.truth)
    assert np.isfinite(place(problem, end).points).all()


def test_the_result_carries_the_adjustment_over():
    of = many(2, seed=3)
    found = evaluate(of.problem, of.truth)
    present = of.problem.observations.present
    fit = of_adjustment(found, present, np.array([0.1, 0.2]), (True, False), True, ())
    assert (fit.heading, fit.heading_sigma) == (of.truth.shared.heading, found.heading_sigma)
    taken = of_adjustment(found, present, np.array([0.1, 0.2]), (True, False), False, ())
    assert taken.heading_sigma is None
    np.testing.assert_array_equal(fit.points, found.placed.points)
    np.testing.assert_array_equal(fit.s, GRID.nodes)
    np.testing.assert_array_equal(
        fit.covariance, position_covariance(found.placed, found.covariance)
    )
    for p in range(2):
        start = found.covariance[p][M:, M:]
        np.testing.assert_allclose(fit.covariance[p, 0], start, rtol=1e-9)
        np.testing.assert_allclose(
            fit.covariance[p], np.swapaxes(fit.covariance[p], 1, 2), atol=1e-15
        )
    assert fit.ambiguous == (True, False)
    assert (fit.normal_sigma > 0).all()
