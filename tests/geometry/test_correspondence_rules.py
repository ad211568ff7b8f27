"""Laws of the other correspondences: fractions, arc lengths, feet cut to the overlap."""

from functools import cache

import numpy as np
import pytest

from georibbon.errors import SurfaceError
from georibbon.geometry.correspondence import correspond, feet, match_pair
from georibbon.geometry.frames import Strip
from georibbon.geometry.reference import Bonnet
from georibbon.geometry.settings import CORRESPONDENCES
from passes import passes, plane_passes


@cache
def uneven(count: int = 5) -> list[Strip]:
    """Passes of unequal lengths, shifted along."""
    lengths = [0.9, 0.7, 0.96, 0.6, 0.8]
    shifts = [0.0, 0.05, -0.04, 0.1, 0.02]
    return [
        passes(Bonnet(), [(0.0, 0.1 * k - 0.2)], length=lengths[k], shifts=shifts[k])[0]
        for k in range(count)
    ]


def parameters(match: object, count: int = 200) -> np.ndarray:
    return np.linspace(*match.ends[match.middle], count)


@pytest.mark.parametrize("rule", CORRESPONDENCES)
@pytest.mark.parametrize("count", [2, 3, 5])
def test_all_passes_share_one_ascending_parameter(rule: str, count: int) -> None:
    strips = uneven(count)
    match = correspond(strips, rule)
    rows = match(parameters(match))
    assert (np.diff(rows, axis=1) > 0.0).all()
    for strip, places, ends in zip(strips, rows, match.ends, strict=True):
        assert np.allclose(places[[0, -1]], ends, atol=1e-12)
        assert places[0] >= strip.s[0]
        assert places[-1] <= strip.s[-1]
    assert match.rule == rule


@pytest.mark.parametrize("rule", ["foot-cover", "fraction"])
def test_covering_rules_reach_the_ends_of_all_passes(rule: str) -> None:
    strips = uneven()
    for strip, ends in zip(strips, correspond(strips, rule).ends, strict=True):
        assert np.array_equal(ends, strip.s[[0, -1]])


def test_fractions_are_equal() -> None:
    strips = uneven()
    match = correspond(strips, "fraction")
    rows = match(parameters(match))
    shares = rows / np.array([strip.s[-1] for strip in strips])[:, None]
    assert np.allclose(shares, np.linspace(0.0, 1.0, 200))


def test_arc_lengths_are_equal_and_end_with_the_shortest() -> None:
    match = correspond(uneven(), "arc-length")
    rows = match(parameters(match))
    assert np.allclose(rows, np.linspace(0.0, 0.6, 200))


def test_feet_cut_to_the_overlap_are_feet_from_end_to_end() -> None:
    a, b = uneven(2)
    match = correspond([a, b], "foot-trim")
    on_a, on_b = match(parameters(match))
    found, valid = feet(a, b, on_a[1:-1])
    assert valid.all()
    assert np.allclose(found, on_b[1:-1], atol=2e-5)
    assert on_a[-1] - on_a[0] == pytest.approx(0.7, abs=0.05)


def test_the_common_stretch_ends_where_some_pass_ends() -> None:
    strips = uneven()
    match = correspond(strips, "foot-trim")
    begins = [ends[0] - strip.s[0] for strip, ends in zip(strips, match.ends, strict=True)]
    finishes = [strip.s[-1] - ends[1] for strip, ends in zip(strips, match.ends, strict=True)]
    assert min(begins) < 1e-6
    assert min(finishes) < 1e-6
    assert max(begins) > 0.05


def test_on_a_plane_the_common_stretch_is_known() -> None:
    strips = plane_passes(0.0, 0.1, 0.2, 0.3, shifts=[0.0, 0.2, 0.1, -0.1])
    match = correspond(strips, "foot-trim")
    assert np.allclose(match.ends, [[0.2, 0.86], [0.0, 0.66], [0.1, 0.76], [0.3, 0.96]], atol=1e-9)
    rows = match(parameters(match))
    assert np.allclose(np.diff(rows, axis=1), rows[0, 1] - rows[0, 0])


def test_the_rules_agree_on_level_passes_of_one_length() -> None:
    strips = plane_passes(0.0, 0.1, 0.2)
    u = np.linspace(0.0, 0.96, 50)
    for rule in CORRESPONDENCES:
        assert np.allclose(correspond(strips, rule)(u), np.tile(u, (3, 1)), atol=1e-9)


def test_passes_with_nothing_in_common_cannot_be_cut_to_it() -> None:
    strips = plane_passes(0.0, 0.1, 0.2, shifts=[0.0, 0.5, 0.95])
    with pytest.raises(SurfaceError, match="have 10 mm in common, at least a tenth of a pass"):
        correspond(strips, "foot-trim")


def test_passes_without_feet_are_matched_by_fractions_uncut() -> None:
    a, b = plane_passes(0.0, 0.1, shifts=[0.0, 1.2])
    match = match_pair(a, b, "foot-trim")
    assert not match.by_feet
    assert np.array_equal(correspond([a, b], "foot-trim").ends, [a.s[[0, -1]], b.s[[0, -1]]])
