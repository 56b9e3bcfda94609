"""Two-beat lines follow a tempo that wanders, where the lines of one tempo would not."""

import numpy as np
import pytest

from live.motion.beats.tempo_estimation import RELIABLE_STRENGTH, find_two_beat_lines
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON

RATE = 60.0
SECONDS = 40.0


def danced(turns: np.ndarray, seed: int = 0) -> Clip:
    """A body that goes quick, quick, slow in each of its `turns` (T,), the more forward the faster; with noise."""
    chance = np.random.default_rng(seed)
    speed = 0.5 + 0.4 * np.cos(2.0 * np.pi * turns) + 0.2 * np.cos(4.0 * np.pi * turns + 1.0)
    speed = speed + 0.3 * chance.normal(size=len(turns))
    root = np.tile(SKELETON.rest_positions()[0].astype(np.float32), (len(turns), 1))
    root[:, 2] = np.cumsum(speed) / RATE
    rotation = np.zeros((len(turns), JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    return Clip("danced", root, rotation, RATE, np.ones((len(turns), 2), np.bool_))


def wandering(swing: float = 0.25) -> tuple[np.ndarray, np.ndarray]:
    """Turns (T,) of 0.73 s each that come up to `swing` of one early and late, and when each begins [s]."""
    time = np.arange(int(SECONDS * RATE)) / RATE
    turns = time / 0.73 + swing * np.sin(2.0 * np.pi * time / 30.0)
    return turns, np.interp(np.arange(1.0, np.floor(turns[-1])), turns, time)


def away(lines: np.ndarray, others: np.ndarray) -> float:
    """Median distance of lines from the nearest others [s]."""
    return float(np.median(np.abs(lines[:, None] - others).min(axis=1)))


def test_the_lines_of_a_dance_whose_tempo_wanders_lie_where_it_begins_anew() -> None:
    turns, real = wandering()
    for said in (None, 0.75):
        found = find_two_beat_lines([danced(turns)], said)
        assert found is not None
        assert found.strength > RELIABLE_STRENGTH
        assert away(found.lines, real) < 0.03
        assert abs(len(found.lines) - len(real)) <= 2
    even = real[0] + 0.73 * np.arange(len(real))
    assert away(even, real) > 0.06


def test_two_dancers_who_are_read_apart_have_the_same_lines() -> None:
    turns, _ = wandering()
    one, other = (find_two_beat_lines([danced(turns, seed)]) for seed in (1, 2))
    assert one is not None
    assert other is not None
    assert away(one.lines, other.lines) < 0.03


def test_what_keeps_no_time_is_not_clear_and_what_is_too_short_or_still_has_no_lines() -> None:
    turns, _ = wandering()
    noise = find_two_beat_lines([danced(np.random.default_rng(3).random(len(turns)))])
    assert noise is not None
    assert noise.strength < RELIABLE_STRENGTH
    assert find_two_beat_lines([danced(turns[:200])]) is None
    still = danced(turns)
    root = np.repeat(still.root_position[:1], len(turns), axis=0)
    assert find_two_beat_lines([Clip("still", root, still.rotation, RATE, still.contact)]) is None


def test_beats_are_the_lines_and_their_middles_through_the_whole_recording() -> None:
    turns, _ = wandering(0.0)
    found = find_two_beat_lines([danced(turns)])
    assert found is not None
    beats = found.beats(SECONDS)
    assert np.isin(found.lines, beats).all()
    np.testing.assert_allclose(np.diff(beats), 0.365, atol=0.03)
    assert beats[0] < 0.4
    assert beats[-1] > SECONDS - 0.4
    assert beats[-1] <= SECONDS
    assert found.beats(10.0)[-1] == pytest.approx(10.0, abs=0.4)
