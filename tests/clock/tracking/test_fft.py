"""MagnitudeTransform against numpy's FFT in double precision, the transform's lengths against scipy's."""

import numpy as np
import pytest
from scipy.fft import next_fast_len

from live.clock.tracking.fft import MagnitudeTransform, fast_length


@pytest.mark.parametrize("length", [8, 64, 1485, 1486, 2048, 2229, 4096, 4458])
def test_transform_matches_numpy_fft(length: int) -> None:
    rng = np.random.default_rng(length)
    history, window = rng.normal(size=length + 3).astype(np.float32), rng.random(length).astype(np.float32)
    transform = MagnitudeTransform(window, fast_length(length) // 2)
    transform.compute(history)
    expected = np.abs(np.fft.rfft(history[3:].astype(np.float64) * window, transform.length))[:-1]
    np.testing.assert_allclose(transform.magnitude, expected, atol=2e-6 * np.sqrt(length) * expected.max())


def test_fast_lengths_are_products_of_small_primes() -> None:
    for least in (2, 1485, 1486, 2048, 8916, 17833):
        assert fast_length(least) == 2 * next_fast_len((least + 1) // 2)
    assert fast_length(2 * 13) == 2 * 14
    assert fast_length(4 * 3 * 11) == 4 * 3 * 11


def test_too_many_bins_are_refused() -> None:
    with pytest.raises(ValueError, match="bins"):
        MagnitudeTransform(np.ones(64, np.float32), 33)
