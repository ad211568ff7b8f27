"""Laws of the lines' derivatives along the passes, in closed form and by differences."""

from dataclasses import replace

import numpy as np
import pytest

from georibbon.geometry.correspondence import arrange
from georibbon.geometry.patch import PatchSet, lines_at, patches_between, rails_at
from georibbon.geometry.rails import sampled_moving
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.scheme import control_of
from georibbon.geometry.settings import SurfaceSettings
from georibbon.geometry.slopes import control_with_slope
from passes import passes, plane_passes

INSIDE = np.linspace(0.1, 0.8, 25)
H = 1e-5
CHOICES = [
    {},
    {"direction": "conormal"},
    {"direction": "conormal", "lengths": "unit"},
    {"lengths": (0.7, 1.4)},
    {"lengths": "criterion1"},
    {"direction": "chord"},
    {"direction": "section"},
    {"direction": "angles", "angles": (10.0, -5.0, 3.0, 8.0)},
    {"interior": "c1-lines"},
    {"interior": "g2"},
]


def model_of(choice: dict, shift: float = 0.03) -> PatchSet:
    places = [(0.0, 0.1), (0.0, 0.2), (0.02, 0.32)]
    strips = passes(Bonnet(), places, [0.0, 0.05, -0.05], shifts=[0.0, shift, -0.02])
    return patches_between(arrange(strips), SurfaceSettings(**choice))


def differences(model: PatchSet, u: np.ndarray) -> np.ndarray:
    before, after = (
        control_of(rails_at(model, u + step), model.scheme, u + step) for step in (-H, H)
    )
    return (after - before) / (2.0 * H)


@pytest.mark.parametrize("choice", CHOICES, ids=str)
def test_the_slope_is_the_control_s_derivative(choice: dict) -> None:
    model = model_of(choice)
    lines = lines_at(model, INSIDE)
    control = control_of(rails_at(model, INSIDE), model.scheme, INSIDE)
    assert np.allclose(lines.control, control, atol=1e-12)
    assert np.allclose(lines.slope, differences(model, INSIDE), atol=2e-7)


def test_very_oblique_lines_are_differentiated_too() -> None:
    """By equal fractions of passes shifted by half a metre, so that c.V is below 1/4."""
    model = model_of({"correspondence": "fraction"}, shift=0.5)
    rails = rails_at(model, INSIDE)
    chords = rails.chords / rails.gaps[..., None]
    advance = np.sum(chords * rails.frames[:-1, :, :, 1], axis=-1)
    assert (advance < 0.25).any()
    assert np.allclose(lines_at(model, INSIDE).slope, differences(model, INSIDE), atol=1e-6)


def test_passes_on_each_other_have_finite_slopes() -> None:
    """Where two passes touch there is no chord; the derivative by differences stands."""
    model = model_of({})
    rails, rates = sampled_moving(model.splines, *model.match.with_rates(INSIDE))
    touching = replace(rails, points=np.stack([rails.points[0]] * 3))
    control, slope = control_with_slope(touching, rates, model.scheme, INSIDE)
    assert np.isfinite(control).all()
    assert np.isfinite(slope).all()


def test_rates_are_the_rails_derivatives() -> None:
    model = model_of({})
    rails, rates = sampled_moving(model.splines, *model.match.with_rates(INSIDE))
    around = [rails_at(model, INSIDE + step) for step in (-H, H)]
    for name in ("points", "frames"):
        assert np.allclose(getattr(rails, name), getattr(rails_at(model, INSIDE), name), atol=1e-13)
        by_differences = (getattr(around[1], name) - getattr(around[0], name)) / (2.0 * H)
        assert np.allclose(getattr(rates, name), by_differences, atol=1e-6)


def test_straight_passes_go_on_at_one_pace() -> None:
    model = patches_between(arrange(plane_passes(0.0, 0.1, 0.2)))
    u = np.linspace(*model.match.ends[1], 9)
    lines = lines_at(model, u)
    assert np.allclose(lines.slope[:, :, 1:3], 0.0, atol=1e-12)
    assert np.allclose(np.linalg.norm(lines.slope[:, :, [0, 3]], axis=-1), 1.0)
