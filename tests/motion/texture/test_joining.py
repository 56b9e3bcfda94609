"""Tests of fragment joining (P014-P017): no jump, no kink, and fitting fragments are unchanged."""

import numpy as np
import pytest

from live.motion.texture.fragments import (
    blend_weights,
    concatenate_fragments,
    fit_quadratic,
    skew_to_meet,
    smooth_joins,
)

CHANCE = np.random.default_rng(3)


def test_fragments_meet_at_midpoint_and_keep_shape() -> None:
    parts = [CHANCE.normal(size=(n, 3)) for n in (9, 14, 6)]
    met = skew_to_meet(parts)
    for before, after, old, new in zip(met[:-1], met[1:], parts[:-1], parts[1:], strict=True):
        assert np.allclose(before[-1], after[0], atol=1e-12)
        assert np.allclose(after[0], 0.5 * (old[-1] + new[0]), atol=1e-12)
    assert np.array_equal(met[0][0], parts[0][0])
    for old, new in zip(parts, met, strict=True):  # the change is linear
        assert np.abs(np.diff(new - old, n=2, axis=0)).max() < 1e-12
    assert concatenate_fragments(met).shape == (9 + 13 + 5, 3)


def test_fitting_fragments_are_unchanged() -> None:
    curve = CHANCE.normal(size=(30, 2))
    assert np.allclose(concatenate_fragments(skew_to_meet([curve[:11], curve[10:21], curve[20:]])), curve, atol=1e-12)


def test_blend_weight_is_one_at_join_and_flat_at_ends() -> None:
    f = blend_weights(1000)
    assert f[1000] == 1.0
    assert f[0] < 1e-30
    assert np.all((f >= 0.0) & (f <= 1.0))
    assert abs(f[1] - f[0]) < 1e-5
    assert abs(f[1001] - f[1000]) < 1e-5


def test_parabola_is_fitted_exactly() -> None:
    t = np.arange(-20.0, 21.0)[:, None]
    curve = 0.3 * t * t - 2.0 * t + 7.0
    assert np.allclose(fit_quadratic(curve, 20, 9), curve[11:30], atol=1e-9)
    assert np.allclose(smooth_joins(curve, np.array([20])), curve, atol=1e-9)


def _largest_slope_change(rate: int) -> float:
    """Largest change of slope between samples of a roof function, joined within 10 units of time."""
    t = np.arange(-40 * rate, 40 * rate + 1) / rate
    curve = -np.abs(t)[:, None]
    joined = smooth_joins(curve, np.array([40 * rate]), 10 * rate)
    assert np.array_equal(joined[np.abs(t) >= 10.0], curve[np.abs(t) >= 10.0])
    slope = np.diff(joined[:, 0]) * rate
    return float(np.abs(np.diff(slope)).max())


def test_joined_curve_has_no_kink() -> None:
    """Denser samples keep the slope change of a kink; for a C1 curve it falls with the sample distance."""
    coarse, fine = _largest_slope_change(4), _largest_slope_change(32)
    assert fine < coarse / 6.0
    assert fine < 0.05  # the kink of the roof is 2


@pytest.mark.parametrize("reach", [2, 3, 4, 6, 10])
def test_parabola_is_kept_for_short_fragments(reach: int) -> None:
    t = np.arange(-2.0 * reach, 2.0 * reach + 1.0)[:, None]
    curve = 0.3 * t * t - 2.0 * t + 7.0
    assert np.allclose(smooth_joins(curve, np.array([2 * reach])), curve, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_smoothing_does_not_add_kinks(seed: int) -> None:
    chance = np.random.default_rng(seed)
    cuts = np.cumsum(chance.integers(3, 12, 12))
    wave = np.sin(np.arange(cuts[-1] + 1.0) / 6.0)[:, None]
    bent = wave + np.interp(np.arange(cuts[-1] + 1.0), cuts, chance.normal(0.0, 0.3, len(cuts)))[:, None]
    joins = cuts[1:-1]
    out = smooth_joins(bent, joins)
    before, after = (np.abs(np.diff(curve, 2, axis=0)).max() for curve in (bent, out))
    assert after <= before + 1e-9


def test_consecutive_joins_are_unchanged() -> None:
    curve = CHANCE.normal(size=(60, 1))
    assert np.array_equal(smooth_joins(curve, np.array([20, 40]), 5, np.array([True, True])), curve)
