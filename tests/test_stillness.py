"""The means of still windows: laws of means, and honesty of their sigma."""

import numpy as np
import pytest

from georibbon.ribbon import Readings
from georibbon.stillness import means_of_blocks, still_means


def readings(counts: np.ndarray) -> Readings:
    return Readings(np.arange(len(counts)) / 100.0, np.asarray(counts, dtype=float))


def test_mean_moves_with_the_counts_and_sigma_does_not() -> None:
    counts = np.random.default_rng(0).normal(0.0, 30.0, (100, 4))
    one, moved = still_means(readings(counts)), still_means(readings(counts + 1234.0))
    np.testing.assert_allclose(moved.mean, one.mean + 1234.0, rtol=1e-12)
    np.testing.assert_allclose(moved.sigma, one.sigma, rtol=1e-9)


def test_lost_values_are_left_out() -> None:
    counts = np.random.default_rng(1).normal(5.0, 30.0, (100, 2))
    counts[20:40, 0] = np.nan
    found = still_means(readings(counts))
    assert found.mean[0] == pytest.approx(np.nanmean(counts[:, 0]))
    assert list(found.frames) == [80, 100]
    assert np.all(np.isfinite(found.sigma))


def test_a_column_without_a_value_is_nan_and_the_others_are_not() -> None:
    counts = np.full((50, 2), np.nan)
    counts[:, 1] = 7.0
    found = still_means(readings(counts))
    assert np.isnan(found.mean[0])
    assert np.isnan(found.sigma[0])
    assert found.mean[1] == pytest.approx(7.0)
    assert found.frames[0] == 0


def test_no_frame_at_all_gives_nan() -> None:
    found = still_means(readings(np.empty((0, 3))))
    assert np.all(np.isnan(found.mean))
    assert np.all(np.isnan(found.sigma))


def test_equal_counts_are_still_known_only_to_their_rounding() -> None:
    found = still_means(readings(np.full((100, 1), 42.0)))
    assert found.sigma[0] == pytest.approx(1.0 / np.sqrt(12.0 * 100.0))


@pytest.mark.parametrize("frames", [1, 3, 10, 57])
def test_short_windows_have_a_finite_sigma(frames: int) -> None:
    found = still_means(readings(np.random.default_rng(2).normal(0.0, 9.0, (frames, 2))))
    assert np.all(np.isfinite(found.sigma))
    assert np.all(found.sigma > 0.0)


@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_sigma_is_honest_over_many_windows(memory: float) -> None:
    """The rms of (error / sigma) is near 1, also for noise that remembers."""
    noise = np.random.default_rng(3).normal(0.0, 10.0, (300, 3000))
    for k in range(1, len(noise)):
        noise[k] += memory * noise[k - 1]
    found = still_means(readings(noise))
    honest = np.sqrt(np.mean(found.mean**2) / np.mean(found.sigma**2))
    assert 0.9 < honest < 1.1


def test_blocks_of_one_value_give_the_spread_over_the_root_of_the_number() -> None:
    counts = np.random.default_rng(4).normal(0.0, 20.0, (80, 3))
    found = means_of_blocks(counts, np.ones_like(counts))
    np.testing.assert_allclose(found.mean, counts.mean(axis=0))
    np.testing.assert_allclose(found.sigma, counts.std(axis=0, ddof=1) / np.sqrt(80))


def test_blocks_of_any_length_have_the_mean_of_their_values() -> None:
    counts = np.random.default_rng(5).normal(300.0, 20.0, (100, 2))
    cuts = np.array([0, 3, 4, 40, 60, 61, 90])
    sums = np.add.reduceat(counts, cuts, axis=0)
    sizes = np.tile(np.diff([*cuts, 100])[:, None].astype(float), (1, 2))
    empty = np.zeros((2, 2))
    found = means_of_blocks(np.concatenate([sums, empty]), np.concatenate([sizes, empty]))
    np.testing.assert_allclose(found.mean, counts.mean(axis=0))
    np.testing.assert_array_equal(found.frames, [100, 100])
    parts = sizes * (sums / sizes - counts.mean(axis=0)) ** 2
    np.testing.assert_allclose(found.sigma**2, parts.sum(axis=0) / (6 * 100))
