import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from live.motion import quaternion
from live.motion.editing.foot_correction import find_feet
from live.motion.editing.variation import (
    LOWER,
    UPPER,
    draw_factors,
    draw_sequence_factors,
    factor_at,
    scale_clip,
    scale_sequence,
    scale_step,
)
from live.motion.quaternion import mean_rotation, scale_about_mean
from tests.motion.editing.made_steps import random_clip, random_step, sketched_step

FACTORS = st.floats(0.5, 1.5)


def rotations(seed: int, count: int, spread: float) -> np.ndarray:
    """Rotations (count, 4) within `spread` [rad] of a random one, with random signs."""
    chance = np.random.default_rng(seed)
    axis = quaternion.unit(chance.normal(size=(count, 3)))
    away = quaternion.from_axis_angle(axis, chance.uniform(0.0, spread, count))
    centre = quaternion.unit(chance.normal(size=4))
    return np.asarray(quaternion.mul(centre, away) * chance.choice((-1.0, 1.0), (count, 1)))


@given(st.integers(0, 1000), st.integers(1, 40))
def test_mean_rotation_matches_scipy(seed: int, count: int) -> None:
    q = rotations(seed, count, 1.5)
    expected = Rotation.from_quat(q, scalar_first=True).mean().as_quat(scalar_first=True)
    assert abs(expected @ mean_rotation(q)) == pytest.approx(1.0, abs=1e-9)


@given(st.integers(0, 1000), st.floats(0.0, 1.5))
def test_scaling_multiplies_rotation_vector_from_mean(seed: int, factor: float) -> None:
    q = rotations(seed, 12, 1.3)
    mean = mean_rotation(q)
    scaled = scale_about_mean(mean, q, factor)
    centre = Rotation.from_quat(mean, scalar_first=True)
    before, after = ((centre.inv() * Rotation.from_quat(each, scalar_first=True)).as_rotvec() for each in (q, scaled))
    assert np.allclose(after, factor * before, atol=1e-7)
    assert np.allclose(np.linalg.norm(scaled, axis=-1), 1.0)


@given(st.integers(0, 1000))
def test_scaled_rotation_is_continuous_past_half_turn(seed: int) -> None:
    axis = quaternion.unit(np.random.default_rng(seed).normal(size=3))
    q = quaternion.from_axis_angle(np.broadcast_to(axis, (400, 3)), np.linspace(0.0, 2.0 * np.pi, 400))
    scaled = scale_about_mean(np.array((1.0, 0.0, 0.0, 0.0)), q, 1.2)
    turned = 2.0 * np.arccos(np.minimum(np.abs(np.sum(scaled[1:] * scaled[:-1], axis=-1)), 1.0))
    assert turned.max() < 0.05


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), FACTORS)
def test_only_upper_body_changes_and_factor_one_is_identity(seed: int, factor: float) -> None:
    clip = random_clip(seed)
    scaled = scale_clip(clip, factor)
    assert np.array_equal(scaled.rotation[:, LOWER], clip.rotation[:, LOWER])
    assert np.array_equal(scaled.root_position, clip.root_position)
    assert np.array_equal(scaled.contact, clip.contact)
    assert np.array_equal(find_feet(scaled).ball, find_feet(clip).ball)
    assert np.allclose(np.linalg.norm(scaled.rotation, axis=-1), 1.0, atol=1e-5)
    assert np.array_equal(scale_clip(clip, 1.0).rotation, clip.rotation)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.floats(0.8, 1.2))
def test_spread_about_mean_scales_by_factor(seed: int, factor: float) -> None:
    clip = random_clip(seed)
    scaled = scale_clip(clip, factor)
    for joint in UPPER[::5]:
        mean = mean_rotation(clip.rotation[:, joint])
        angles = [
            2.0 * np.arccos(np.clip(np.abs(each.rotation[:, joint].astype(np.float64) @ mean), 0.0, 1.0))
            for each in (clip, scaled)
        ]
        small = angles[0] < np.radians(150.0)
        assert np.allclose(np.minimum(angles[1], 2 * np.pi - angles[1])[small], factor * angles[0][small], atol=2e-3)


def test_factors_are_three_corrected_thesis_values() -> None:
    factors = draw_factors(np.random.default_rng(1), 3000)
    assert np.unique(factors) == pytest.approx((0.8, 1.0, 1.2))
    for value in (0.8, 1.0, 1.2):
        assert np.isclose(factors, value).mean() == pytest.approx(1 / 3, abs=0.04)
    assert np.array_equal(factors, draw_factors(np.random.default_rng(1), 3000))
    with pytest.raises(ValueError, match="r_max"):
        draw_factors(np.random.default_rng(1), 3, r_max=1.0)


@given(st.integers(0, 1000), st.floats(0.0, 40.0), st.floats(0.3, 4.0))
def test_sequence_factors_repeat_in_pairs_and_bound_curve(seed: int, measures: float, spacing: float) -> None:
    places, factors = draw_sequence_factors(np.random.default_rng(seed), measures, spacing=spacing)
    assert np.array_equal(factors[::2], factors[1::2])
    assert np.diff(places) == pytest.approx(spacing)
    assert places[-1] >= measures
    x = np.linspace(0.0, measures, 300)
    r = factor_at(places, factors, x)
    assert r.min() >= 0.8 - 1e-12
    assert r.max() <= 1.2 + 1e-12
    assert factor_at(places, factors, places) == pytest.approx(factors)
    middle = 0.5 * (places[:-1:2] + places[1::2])
    assert factor_at(places, factors, middle) == pytest.approx(factors[::2])  # equal neighbours are joined flat


def test_measure_factors_ease_before_measure_line() -> None:
    step = sketched_step("grapevine")
    one, other = scale_step(step, 0.8), scale_step(step, 1.2)
    both = scale_step(step, (0.8, 1.2))
    line = round(step.first + step.samples_per_measure)
    begin = round(step.first + 0.8 * step.samples_per_measure)
    assert np.array_equal(both.clip.rotation[:begin], one.clip.rotation[:begin])
    assert np.array_equal(both.clip.rotation[line:], other.clip.rotation[line:])
    assert not np.allclose(one.clip.rotation[line:], other.clip.rotation[line:], atol=1e-3)
    jumps = np.linalg.norm(np.diff(both.clip.rotation, axis=0), axis=-1).max(axis=1)
    raw = np.linalg.norm(np.diff(step.clip.rotation, axis=0), axis=-1).max()
    assert jumps.max() < 1.5 * raw


def test_sequence_of_ones_is_identity() -> None:
    step = sketched_step("grapevine")
    places = np.arange(4.0)
    assert np.array_equal(scale_sequence(step, places, np.ones(4)).clip.rotation, step.clip.rotation)
    changed = scale_sequence(step, places, np.array((1.2, 1.2, 0.8, 0.8)))
    assert np.array_equal(changed.clip.rotation[:5], scale_step(step, 1.2).clip.rotation[:5])


def test_wrong_number_of_factors_is_refused() -> None:
    with pytest.raises(ValueError, match="3 factors for the 1 measures"):
        scale_step(random_step(1), (1.0, 1.0, 0.8))
