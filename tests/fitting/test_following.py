"""The joint adjustment followed to another smoothing, against a descent to its minimum."""

from dataclasses import replace

import numpy as np
import pytest

from georibbon.fitting import following
from georibbon.fitting.capture import prepare
from georibbon.fitting.fit import FitSettings, fit_alone, fit_together
from georibbon.fitting.following import follow, stand
from georibbon.fitting.grid import integrate_frames, integrate_positions
from georibbon.fitting.joint import cost_of, descend, place
from georibbon.fitting.screening import screen
from georibbon.simulation import (
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
    simulate,
)


@pytest.fixture(scope="module")
def minimum():
    """The minimum for three passes of a dome, in full."""
    made = simulate(
        SimulationSettings(
            surface="dome",
            seed=4,
            ribbon=RibbonSettings(sensors=16, length=0.48),
            layout=LayoutSettings(passes=3),
            frames=24,
            poses=PoseSettings(plan=0),
        )
    )
    recording, calibration = made.recording, made.truth.calibration
    screened = screen(recording.ribbon, recording.passes, calibration)
    capture = prepare(recording, calibration, screened)
    asked = FitSettings(smoothing={"*": 0.12})
    found = fit_together(capture, fit_alone(capture, range(3), asked), asked).minimum
    state = descend(found.problem, found.state, tolerance=1e-10)
    return replace(found, state=state)


def curves(problem, state):
    frames = integrate_frames(problem.grid, state.shape)
    return integrate_positions(problem.grid, state.shape, frames) + state.origin[:, None]


def to(minimum, factors):
    """The smoothing so many times as long."""
    return minimum.problem.smoothing * np.asarray(factors) ** 6


def test_at_the_minimum_nothing_moves(minimum):
    state, foothold = follow(stand(minimum.problem, minimum.state), minimum.problem.smoothing)
    np.testing.assert_allclose(
        curves(minimum.problem, state), curves(minimum.problem, minimum.state), atol=1e-7
    )
    assert foothold.state is minimum.state


@pytest.mark.parametrize("factors", [(1, 1.3, 1), (0.7, 1, 1), (0.5, 0.5, 0.5), (1.3, 0.6, 1)])
def test_it_leads_to_the_new_minimum(minimum, factors):
    smoothing = to(minimum, factors)
    problem = replace(minimum.problem, smoothing=smoothing)
    state, _ = follow(stand(minimum.problem, minimum.state), smoothing)
    exact = descend(problem, minimum.state, tolerance=1e-10)
    way = np.abs(curves(problem, exact) - curves(problem, minimum.state)).max()
    left = np.abs(curves(problem, state) - curves(problem, exact)).max()
    assert left < 0.1 * way
    assert left < 2e-5
    assert cost_of(problem, state) < cost_of(problem, minimum.state)


def test_half_the_way_leaves_a_quarter_of_the_error(minimum):
    """The step is exact to first order: what is left falls with the square of the way."""
    left = []
    for factor in (1.2, 1.1, 1.05):
        smoothing = to(minimum, (1, factor, 1))
        problem = replace(minimum.problem, smoothing=smoothing)
        state, _ = follow(stand(minimum.problem, minimum.state), smoothing)
        exact = descend(problem, state, tolerance=1e-14)
        left.append(np.abs(curves(problem, state) - curves(problem, exact)).max())
    assert left[1] < 0.4 * left[0]
    assert left[2] < 0.4 * left[1]


def test_its_foothold_is_not_changed(minimum):
    foothold = stand(minimum.problem, minimum.state)
    blocks = {key: block.copy() for key, block in foothold.matrix.blocks.items()}
    gradient = [part.copy() for part in foothold.gradient]
    follow(foothold, to(minimum, (0.5, 2.0, 1.1)))
    for key, block in blocks.items():
        np.testing.assert_array_equal(foothold.matrix.blocks[key], block)
    for one, other in zip(foothold.gradient, gradient, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_great_turn_is_stood_on_anew(minimum):
    near, foothold = follow(stand(minimum.problem, minimum.state), to(minimum, (1, 1.01, 1)))
    assert foothold.state is minimum.state
    smoothing = to(minimum, (1, 8.0, 1))
    far, foothold = follow(stand(minimum.problem, minimum.state), smoothing)
    assert foothold.state is not minimum.state
    np.testing.assert_array_equal(foothold.problem.smoothing, smoothing)
    frames = (place(minimum.problem, one).frames for one in (minimum.state, far))
    assert np.abs(np.subtract(*frames)).max() > 0.5 * following.FAR
    assert near is not far


def test_weights_count_in_the_smoothing_too(minimum):
    """A pass that counts four times is led to its own minimum."""
    weighed = replace(minimum.problem, weights=np.array([1.0, 4.0, 1.0]))
    state = descend(weighed, minimum.state, tolerance=1e-10)
    smoothing = to(minimum, (1, 1.2, 1))
    led, _ = follow(stand(weighed, state), smoothing)
    exact = descend(replace(weighed, smoothing=smoothing), state, tolerance=1e-10)
    np.testing.assert_allclose(curves(weighed, led), curves(weighed, exact), atol=1e-5)


@pytest.mark.parametrize("factors", [(1, 0.7, 1), (1.4, 1, 0.9), (0.5, 1.2, 1.7)])
def test_held_columns_and_a_new_factor_lead_to_the_same(minimum, factors, monkeypatch):
    monkeypatch.setattr(following, "FAR", np.inf)
    smoothing, steps = to(minimum, factors), []
    for few in (3, 0):
        monkeypatch.setattr(following, "FEW", few)
        state, _ = follow(stand(minimum.problem, minimum.state), smoothing)
        steps.append(curves(minimum.problem, state))
    np.testing.assert_allclose(steps[0], steps[1], atol=1e-9)


def test_what_leads_nowhere_is_refused(minimum, monkeypatch):
    monkeypatch.setattr(following, "LOST", 1e-6)
    with pytest.raises(np.linalg.LinAlgError, match="turns a strip"):
        follow(stand(minimum.problem, minimum.state), to(minimum, (1, 1.2, 1)))
