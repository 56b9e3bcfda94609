import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.editing.time_warp import (
    A_MAX,
    F_MAX,
    MeasureWarps,
    draw_measure_warps,
    measure_warp,
    measure_warp_slope,
    steepness,
    warp_clip,
    warp_step,
)
from live.motion.editing.turn_insertion import BLEND_WINDOW
from tests.motion.editing.made_steps import random_clip, random_step, sketched_step

PHASES = np.linspace(0.0, 1.0, 1001)
SIGNS = st.sampled_from((-1.0, 1.0))


def test_slope_matches_thesis_value() -> None:
    assert steepness(7 / 100, 2.0) == pytest.approx(0.8796, abs=5e-5)
    fastest, slowest = (measure_warp_slope(0.25, 0.07, 2.0, 0.25, sign) for sign in (1.0, -1.0))
    assert fastest == pytest.approx(1.8796, abs=5e-5)
    assert slowest == pytest.approx(0.1204, abs=5e-5)
    assert steepness(A_MAX, F_MAX) < 1.0


def test_values_match_hand_calculation() -> None:
    # N = 100, A = 7, f = 2: half a wave of 25 frames from x0 = 30, its top 12.5 frames later
    frames = np.array((0.0, 30.0, 42.5, 36.25, 55.0, 80.0, 100.0))
    expected = np.array((0.0, 30.0, 49.5, 36.25 + 7 * np.sqrt(0.5), 55.0, 80.0, 100.0))
    assert 100 * measure_warp(frames / 100, 0.07, 2.0, 0.30, 1.0) == pytest.approx(expected)
    assert 100 * measure_warp(frames / 100, 0.07, 2.0, 0.30, -1.0) == pytest.approx(2 * frames - expected)


@given(st.floats(0.0, 1.0), st.floats(0.1, 4.0), st.floats(-1.0, 2.0), SIGNS, st.floats(0.0, 0.6))
def test_warp_increases_and_is_identity_at_ends(
    share: float, frequency: float, start: float, sign: float, window: float
) -> None:
    f = max(frequency, 0.5 / (1.0 - window))
    amplitude = share * 0.999 / (2.0 * np.pi * f)
    warped = measure_warp(PHASES, amplitude, frequency, start, sign, window)
    assert (np.diff(warped) >= -1e-12).all()
    assert warped[0] == 0.0
    assert abs(warped[-1] - 1.0) <= 1e-6
    last = np.flatnonzero(PHASES + window >= 1.0)
    assert np.abs(warped[last] - PHASES[last]).max() <= 1e-6
    assert np.abs(warped - PHASES).max() <= amplitude + 1e-12


@pytest.mark.long
@given(st.floats(0.0, 1.0), st.floats(0.7, 4.0), st.floats(0.0, 0.2), SIGNS)
def test_slope_matches_finite_difference(share: float, frequency: float, start: float, sign: float) -> None:
    amplitude = share / (2.0 * np.pi * frequency)
    middle = start + np.linspace(0.1, 0.9, 9) * 0.5 / frequency
    ends = measure_warp(np.stack((middle - 1e-6, middle + 1e-6)), amplitude, frequency, start, sign, 0.0)
    slope = measure_warp_slope(middle, amplitude, frequency, start, sign, 0.0)
    assert (ends[1] - ends[0]) / 2e-6 == pytest.approx(slope, abs=1e-4)


@pytest.mark.long
@given(st.integers(0, 1000), st.floats(0.0, 0.5))
def test_random_warps_stay_within_ranges(seed: int, window: float) -> None:
    warps = draw_measure_warps(np.random.default_rng(seed), 200, window=window)
    half = 0.5 / warps.frequency
    assert warps.amplitude.min() >= 0.0
    assert warps.amplitude.max() <= A_MAX
    assert warps.frequency.min() >= 0.5
    assert warps.frequency.max() <= F_MAX
    assert warps.start.min() >= 0.0
    assert (warps.start + half).max() <= 1.0 - window + 1e-12
    assert set(warps.sign) == {-1.0, 1.0}
    warped = warps.phase(PHASES[:, None], window)
    assert (np.diff(warped, axis=0) > 0.0).all()
    assert np.abs(warped[-1] - 1.0).max() <= 1e-6


def test_seeded_warps_repeat_and_use_full_ranges() -> None:
    a, b = (draw_measure_warps(np.random.default_rng(7), 2000) for _ in range(2))
    for name in ("amplitude", "frequency", "start", "sign"):
        assert np.array_equal(getattr(a, name), getattr(b, name))
    assert np.quantile(a.amplitude, (0.1, 0.9)) == pytest.approx((0.1 * A_MAX, 0.9 * A_MAX), rel=0.25)
    assert a.frequency.mean() == pytest.approx(0.5 * (0.625 + F_MAX), abs=0.05)
    assert abs(a.sign.mean()) < 0.1


@pytest.mark.parametrize(
    "options",
    [{"a_max": 0.08}, {"a_max": -0.1}, {"a_max": float("nan")}, {"f_max": 0.4}, {"window": 0.9}, {"window": 1.0}],
)
def test_decreasing_or_overlong_warp_is_refused(options: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"a_max|f_max"):
        draw_measure_warps(np.random.default_rng(1), 3, **options)


def test_warped_step_samples_warped_phase() -> None:
    step = sketched_step("grapevine")
    warps = draw_measure_warps(np.random.default_rng(3), 2)
    warped = warp_step(step, warps)
    for measure, x in ((0, 0.25), (0, 0.5), (1, 0.375), (1, 0.625)):
        sample = round(step.first + (measure + x) * step.samples_per_measure)
        source = step.first + (measure + float(warps.phase(x)[measure])) * step.samples_per_measure
        low, part = int(source), source - int(source)
        expected = (1 - part) * step.clip.root_position[low] + part * step.clip.root_position[low + 1]
        assert warped.clip.root_position[sample] == pytest.approx(expected, abs=1e-6)


def test_lead_in_tail_lines_and_windows_stay_unwarped() -> None:
    step = sketched_step("grapevine")
    warped = warp_step(step, draw_measure_warps(np.random.default_rng(3), 2))
    place = (np.arange(step.clip.sample_count) - step.first) / step.samples_per_measure
    phase = np.mod(place, 1.0)
    same = (place <= 0.0) | (place >= 2.0) | (phase >= 1.0 - BLEND_WINDOW) | (phase == 0.0)
    assert same.mean() < 0.7
    assert np.allclose(warped.clip.root_position[same], step.clip.root_position[same], atol=1e-6)
    assert np.allclose(warped.clip.rotation[same], step.clip.rotation[same], atol=1e-6)
    assert np.array_equal(warped.clip.contact[same], step.clip.contact[same])


def test_zero_amplitude_is_identity() -> None:
    step = random_step(1)
    none = MeasureWarps(*(np.array((value,)) for value in (0.0, 1.0, 0.1, 1.0)))
    assert np.allclose(warp_step(step, none).clip.rotation, step.clip.rotation, atol=1e-6)


def test_clip_is_sampled_backward_and_beyond_ends() -> None:
    clip = random_clip(2)
    back = warp_clip(clip, np.arange(clip.sample_count, dtype=np.float64)[::-1])
    assert np.allclose(back.root_position, clip.root_position[::-1], atol=1e-6)
    assert np.array_equal(back.contact, clip.contact[::-1])
    held = warp_clip(clip, np.full(4, 1000.0))
    assert np.allclose(held.root_position, clip.root_position[-1], atol=1e-6)


def test_wrong_number_of_warps_is_refused() -> None:
    with pytest.raises(ValueError, match="3 warps for the 1 measures"):
        warp_step(random_step(1), draw_measure_warps(np.random.default_rng(1), 3))
