"""Laws of matching passes of thousands of points, and hundreds of passes."""

import numpy as np
import pytest

from georibbon.geometry import correspondence
from georibbon.geometry.correspondence import correspond, feet, pass_distances
from georibbon.geometry.frames import Strip, frames_from
from passes import sphere_passes


def arc(points: int, y: float, begin: float) -> Strip:
    """A circle's arc of half a metre's radius about the y axis, 0.8 m long."""
    s = np.linspace(0.0, 0.8, points)
    angle = 2.0 * (s + begin)
    zero = np.zeros_like(s)
    normals = np.stack([np.sin(angle), zero, np.cos(angle)], axis=1)
    tangents = np.stack([np.cos(angle), zero, -np.sin(angle)], axis=1)
    return Strip(s, 0.5 * normals + [0.0, y, 0.0], frames_from(tangents, normals))


@pytest.mark.parametrize("points", [257, 1000, 5001])
def test_feet_are_found_among_many_nodes(points: int) -> None:
    """Across the cylinder they lie level: at t = s + 0.1."""
    at = np.linspace(-0.05, 0.8, 41)
    t, valid = feet(arc(points, 0.0, 0.0), arc(points, 0.1, -0.1), at)
    expected = at + 0.1
    inside = (at >= 0.0) & (expected <= 0.8)
    assert np.array_equal(valid, inside)
    assert np.abs(t - expected)[inside].max() < 1e-9


def test_many_feet_are_found_part_by_part(monkeypatch: pytest.MonkeyPatch) -> None:
    at = np.linspace(0.0, 0.7, 100)
    one, other = arc(300, 0.0, 0.0), arc(300, 0.1, -0.1)
    whole = feet(one, other, at)
    monkeypatch.setattr(correspondence, "CHUNK", 7)
    for part, same in zip(feet(one, other, at), whole, strict=True):
        assert np.allclose(part, same, rtol=0.0, atol=1e-12)


def test_the_match_does_not_depend_on_how_many_points_there_are() -> None:
    u = np.linspace(0.05, 0.75, 20)
    few, many = (correspond([arc(n, 0.0, 0.0), arc(n, 0.1, 0.05)])(u) for n in (201, 2001))
    assert np.abs(few - many).max() < 1e-6


def test_distances_of_many_passes_are_found_part_by_part(monkeypatch: pytest.MonkeyPatch) -> None:
    strips = sphere_passes()
    whole = pass_distances(strips)
    monkeypatch.setattr(correspondence, "MOST_PRODUCTS", 1)
    assert np.allclose(pass_distances(strips), whole, rtol=0.0, atol=1e-12)
