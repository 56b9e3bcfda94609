"""BeatRegression: the line through beats that jitter, tempi that waver, and which beats are left out at the end."""

import numpy as np
import pytest

from live.clock.bar_pointer.beat_regression import FADE_OUT_FRAMES, MIN_BEATS, BeatRegression
from live.clock.bar_pointer.state_space import SLOTS

SLOTS_SAID = np.full(SLOTS, 1.0 / SLOTS)


def passed(times: np.ndarray, interval: float) -> BeatRegression:
    """A grid whose beats fall at these frames, up to just after the last."""
    passed = BeatRegression()
    slot = 0
    for frame in range(1, int(times[-1]) + 4):
        slot = int(np.searchsorted(times, frame, side="right")) % 4
        nearest = times[np.argmin(np.abs(times - frame))]
        passed.step(frame - nearest, interval, slot, SLOTS_SAID, restarted=False)
    return passed


def test_many_beats_that_jitter_make_one_line() -> None:
    rng = np.random.default_rng(1)
    times = 20.0 + 43.27 * np.arange(30) + rng.normal(0.0, 0.6, 30)
    found = passed(times, 43.0)
    assert found.interval == pytest.approx(43.27, abs=0.05)
    kept = found.grid_before(0.0)
    assert kept is not None
    since, interval, _, _ = kept
    now, step = int(times[-1]) + 3, interval
    beats = (now - since + 16 * step - 20.0) / 43.27
    assert abs(beats - round(beats)) * 43.27 < 2.0


def test_a_tempo_that_changes_is_taken_from_fewer_beats() -> None:
    times = 20.0 + np.cumsum(np.concatenate([np.full(16, 40.0), np.full(8, 41.6)]))
    assert passed(times, 41.6).interval == pytest.approx(41.6, abs=0.15)


def test_beats_of_the_end_are_left_out() -> None:
    times = 20.0 + 50.0 * np.arange(16)
    dragged = np.concatenate([times, times[-1] + 53.0 * np.arange(1, 4)])
    found = passed(dragged, 50.0)
    kept = found.grid_before(dragged[-1] + 3 - times[-1] - FADE_OUT_FRAMES - 1)
    assert kept is not None
    since, interval, _, _ = kept
    assert interval == pytest.approx(50.0, abs=0.02)
    assert (int(dragged[-1]) + 3 - since - 20.0) % 50.0 == pytest.approx(0.0, abs=0.1)


def test_few_beats_are_no_line() -> None:
    assert passed(20.0 + 50.0 * np.arange(MIN_BEATS - 1), 50.0).grid_before(0.0) is None
