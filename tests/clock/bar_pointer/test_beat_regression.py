"""BeatRegression: the line through jittered beats, tempo changes, and exclusion of the last beats."""

import numpy as np
import pytest

from live.clock.bar_pointer.beat_regression import FADE_OUT_FRAMES, MIN_BEATS, BeatRegression
from live.clock.bar_pointer.metre import SLOTS

SLOTS_SAID = np.full(SLOTS, 1.0 / SLOTS)


def run_regression(times: np.ndarray, interval: float) -> BeatRegression:
    """A regression fed with beats at these frames, up to just after the last."""
    regression = BeatRegression()
    slot = 0
    for frame in range(1, int(times[-1]) + 4):
        slot = int(np.searchsorted(times, frame, side="right")) % 4
        nearest = times[np.argmin(np.abs(times - frame))]
        regression.step(frame - nearest, interval, slot, SLOTS_SAID, restarted=False)
    return regression


def test_jittered_beats_fit_one_line() -> None:
    rng = np.random.default_rng(1)
    times = 20.0 + 43.27 * np.arange(30) + rng.normal(0.0, 0.6, 30)
    found = run_regression(times, 43.0)
    assert found.interval == pytest.approx(43.27, abs=0.05)
    kept = found.grid_before(0.0)
    assert kept is not None
    since, interval, _, _ = kept
    now, step = int(times[-1]) + 3, interval
    beats = (now - since + 16 * step - 20.0) / 43.27
    assert abs(beats - round(beats)) * 43.27 < 2.0


def test_changed_tempo_is_fitted_from_fewer_beats() -> None:
    times = 20.0 + np.cumsum(np.concatenate([np.full(16, 40.0), np.full(8, 41.6)]))
    assert run_regression(times, 41.6).interval == pytest.approx(41.6, abs=0.15)


def test_dragged_final_beats_are_excluded() -> None:
    times = 20.0 + 50.0 * np.arange(16)
    dragged = np.concatenate([times, times[-1] + 53.0 * np.arange(1, 4)])
    found = run_regression(dragged, 50.0)
    kept = found.grid_before(dragged[-1] + 3 - times[-1] - FADE_OUT_FRAMES - 1)
    assert kept is not None
    since, interval, _, _ = kept
    assert interval == pytest.approx(50.0, abs=0.02)
    assert (int(dragged[-1]) + 3 - since - 20.0) % 50.0 == pytest.approx(0.0, abs=0.1)


def test_too_few_beats_give_no_line() -> None:
    assert run_regression(20.0 + 50.0 * np.arange(MIN_BEATS - 1), 50.0).grid_before(0.0) is None
