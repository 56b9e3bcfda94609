import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.editing.time_warp import SequenceWarp, draw_sequence_warp, warp_sequence
from tests.motion.editing.made_steps import sketched_step


def test_constant_warp_is_sine_of_thesis() -> None:
    warp = SequenceWarp(np.array((0.0, 1.0, 2.0)), np.full(3, 0.07), np.full(3, 2.0))
    x = np.linspace(0.0, 2.0, 50)
    assert warp.phase(x) == pytest.approx(x + 0.07 * np.sin(2.0 * np.pi * 2.0 * x))
    assert warp.max_deviation() == pytest.approx(0.8796, abs=5e-5)


def test_varying_frequency_accumulates_phase() -> None:
    # f goes from 0.5 to 1.5 linearly over 2 measures: φ = 2π (0.5 x + 0.25 x²), not 2π (0.5 + 0.5 x) x
    warp = SequenceWarp(np.array((0.0, 2.0)), np.array((0.05, 0.05)), np.array((0.5, 1.5)))
    x = np.array((0.3, 1.1, 1.9))
    assert warp.phase(x) == pytest.approx(x + 0.05 * np.sin(2.0 * np.pi * (0.5 * x + 0.25 * x * x)))


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.floats(1.0, 60.0), st.floats(0.5, 4.0), st.floats(0.0, 0.5))
def test_random_warps_increase_and_keep_ends(seed: int, measures: float, spacing: float, a_max: float) -> None:
    warp = draw_sequence_warp(np.random.default_rng(seed), measures, spacing=spacing, a_max=a_max)
    assert warp.max_deviation() <= 0.95 + 1e-9
    x = np.linspace(0.0, measures, int(200 * measures))
    assert (np.diff(warp.phase(x)) > 0.0).all()
    assert warp.phase(np.array((0.0, measures))) == pytest.approx([0.0, measures], abs=1e-6)
    assert warp.phase(measures - 1e-9) == pytest.approx(measures, abs=1e-6)


def test_seed_determines_warp() -> None:
    x = np.linspace(0.0, 16.0, 100)
    one, same, other = (draw_sequence_warp(np.random.default_rng(seed), 16).phase(x) for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert np.abs(one - other).max() > 0.01


def test_measure_lines_are_desynchronized() -> None:
    warp = draw_sequence_warp(np.random.default_rng(4), 32)
    lines = np.arange(1.0, 32.0)
    assert np.abs(warp.phase(lines) - lines).max() > 0.01


def test_decreasing_warp_is_refused() -> None:
    with pytest.raises(ValueError, match="time would run back"):
        SequenceWarp(np.array((0.0, 1.0, 2.0)), np.full(3, 0.1), np.full(3, 2.0))
    with pytest.raises(ValueError, match="too small"):
        draw_sequence_warp(np.random.default_rng(1), 0.0)


def test_warped_step_keeps_lead_in_and_tail() -> None:
    step = sketched_step("grapevine")
    warped = warp_sequence(step, draw_sequence_warp(np.random.default_rng(5), step.measures, spacing=1.0))
    first, end = round(step.first), round(step.first + 2 * step.samples_per_measure)
    assert np.allclose(warped.clip.rotation[:first], step.clip.rotation[:first], atol=1e-6)
    assert np.allclose(warped.clip.rotation[end:], step.clip.rotation[end:], atol=1e-6)
    assert not np.allclose(warped.clip.rotation[first:end], step.clip.rotation[first:end], atol=1e-3)
