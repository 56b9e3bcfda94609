"""Tests of two-beat lines: they follow a varying tempo, where lines at a constant tempo do not."""

import numpy as np
import pytest

from live.motion.beats.tempo_estimation import RELIABLE_STRENGTH, find_two_beat_lines
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON

RATE = 60.0
SECONDS = 40.0


def pulsing_clip(turns: np.ndarray, seed: int = 0) -> Clip:
    """Clip with quick, quick, slow forward speed in each of its `turns` (T,), with noise."""
    chance = np.random.default_rng(seed)
    speed = 0.5 + 0.4 * np.cos(2.0 * np.pi * turns) + 0.2 * np.cos(4.0 * np.pi * turns + 1.0)
    speed = speed + 0.3 * chance.normal(size=len(turns))
    root = np.tile(SKELETON.rest_positions()[0].astype(np.float32), (len(turns), 1))
    root[:, 2] = np.cumsum(speed) / RATE
    rotation = np.zeros((len(turns), JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    return Clip("danced", root, rotation, RATE, np.ones((len(turns), 2), np.bool_))


def varying_turns(swing: float = 0.25) -> tuple[np.ndarray, np.ndarray]:
    """Turns (T,) of 0.73 s each that are up to `swing` of one early and late, and when each begins [s]."""
    time = np.arange(int(SECONDS * RATE)) / RATE
    turns = time / 0.73 + swing * np.sin(2.0 * np.pi * time / 30.0)
    return turns, np.interp(np.arange(1.0, np.floor(turns[-1])), turns, time)


def median_line_distance(lines: np.ndarray, others: np.ndarray) -> float:
    """Median distance of lines from the nearest other lines [s]."""
    return float(np.median(np.abs(lines[:, None] - others).min(axis=1)))


def test_lines_follow_varying_tempo() -> None:
    turns, real = varying_turns()
    for period_hint in (None, 0.75):
        found = find_two_beat_lines([pulsing_clip(turns)], period_hint)
        assert found is not None
        assert found.strength > RELIABLE_STRENGTH
        assert median_line_distance(found.lines, real) < 0.03
        assert abs(len(found.lines) - len(real)) <= 2
    even = real[0] + 0.73 * np.arange(len(real))
    assert median_line_distance(even, real) > 0.06


def test_lines_of_two_dancers_agree() -> None:
    turns, _ = varying_turns()
    one, other = (find_two_beat_lines([pulsing_clip(turns, seed)]) for seed in (1, 2))
    assert one is not None
    assert other is not None
    assert median_line_distance(one.lines, other.lines) < 0.03


def test_noise_is_unreliable_and_short_or_still_clip_has_no_lines() -> None:
    turns, _ = varying_turns()
    noise = find_two_beat_lines([pulsing_clip(np.random.default_rng(3).random(len(turns)))])
    assert noise is not None
    assert noise.strength < RELIABLE_STRENGTH
    assert find_two_beat_lines([pulsing_clip(turns[:200])]) is None
    still = pulsing_clip(turns)
    root = np.repeat(still.root_position[:1], len(turns), axis=0)
    assert find_two_beat_lines([Clip("still", root, still.rotation, RATE, still.contact)]) is None


def test_beats_are_lines_and_midpoints_of_whole_recording() -> None:
    turns, _ = varying_turns(0.0)
    found = find_two_beat_lines([pulsing_clip(turns)])
    assert found is not None
    beats = found.beats(SECONDS)
    assert np.isin(found.lines, beats).all()
    np.testing.assert_allclose(np.diff(beats), 0.365, atol=0.03)
    assert beats[0] < 0.4
    assert beats[-1] > SECONDS - 0.4
    assert beats[-1] <= SECONDS
    assert found.beats(10.0)[-1] == pytest.approx(10.0, abs=0.4)
