"""Offline beats: a made-up piece is found as it was made, and what a person says is kept."""

import numpy as np
import pytest

from live.base.arrays import Float64
from live.clock.tracking.offline_beats import Activations, Beats, find_beats
from tests.fixtures.mostly_long import mostly_long

FRAME = 512 / 44100


def activations(beats: Float64, downbeats: Float64, seconds: float, *, off: float = 0.02, seed: int = 1) -> Activations:
    """Return probabilities with a bump at each beat, noise, and `off` half-way between beats."""
    time = np.arange(0.0, seconds, FRAME)
    rng = np.random.default_rng(seed)
    beat = rng.uniform(0.0, 0.05, time.size)
    downbeat = np.zeros(time.size)
    for each in beats:
        beat += 0.8 * np.exp(-(((time - each) / 0.014) ** 2))
    for each in (beats[1:] + beats[:-1]) / 2:
        beat += off * np.exp(-(((time - each) / 0.014) ** 2))
    for each in downbeats:
        downbeat += 0.6 * np.exp(-(((time - each) / 0.014) ** 2))
    beat = np.clip(beat, 0.001, 0.98)
    return Activations(time, beat, np.minimum(downbeat + 0.1 * beat, beat))


def lines(found: Beats) -> Float64:
    return found.time[found.number == 0]


def distance(found: Float64, wanted: Float64) -> float:
    """Return the largest distance of a wanted time from a found one [s]."""
    return float(np.abs(found[:, np.newaxis] - wanted).min(axis=0).max())


@mostly_long(("bpm", "metre"), [(62.0, 4), (80.0, 3), (104.0, 4), (141.0, 4)], quick=[2])
def test_a_steady_piece_is_found_from_its_first_measure_on(bpm: float, metre: int) -> None:
    beats = 1.7 + np.arange(64) * 60.0 / bpm
    found = find_beats(activations(beats, beats[2::metre], beats[-1] + 1.0))
    inner = (found.time > beats[0] - 0.2) & (found.time < beats[-1] + 0.2)
    assert distance(found.time, beats) < 0.01
    assert inner.sum() == 64
    assert distance(lines(found), beats[2::metre]) < 0.01
    assert set(found.metre[found.number == 0].tolist()) == {metre}


def test_a_ramp_and_a_jump_are_followed() -> None:
    gaps = np.concatenate([np.linspace(0.6, 0.43, 60), np.full(40, 0.62)])
    beats = 0.8 + np.concatenate([[0.0], np.cumsum(gaps)])
    found = find_beats(activations(beats, beats[::4], beats[-1] + 1.0))
    missed = np.abs(found.time[:, np.newaxis] - beats).min(axis=0) > 0.03
    assert missed.sum() <= 3  # at the jump


@pytest.mark.long
def test_the_tempo_can_be_halved_and_doubled() -> None:
    beats = 0.5 + np.arange(100) * 0.4  # 150 bpm
    heard = activations(beats, beats[::4], 41.0)
    slow = find_beats(heard, bpm_range=(60.0, 94.0))
    assert np.median(np.diff(slow.time)) == pytest.approx(0.8, abs=0.01)
    beats = 0.5 + np.arange(50) * 0.8
    fast = find_beats(activations(beats, beats[::4], 41.0, off=0.5), bpm_range=(120.0, 188.0))
    assert np.median(np.diff(fast.time)) == pytest.approx(0.4, abs=0.01)


@pytest.mark.long
def test_one_line_moves_all_the_others() -> None:
    beats = 0.5 + np.arange(80) * 0.5
    heard = activations(beats, np.zeros(0), 41.0)  # the network hears no downbeat
    moved = find_beats(heard, downbeats=[float(beats[9])], metres=[(0.0, 4)])
    assert distance(lines(moved), beats[1::4]) < 0.03
    off = find_beats(heard, downbeats=[float(beats[8]) + 0.25], metres=[(0.0, 4)])  # the off-beats are the beats
    assert distance(lines(off), beats[:-1:4] + 0.25) < 0.05


def test_a_metre_holds_from_its_line_on() -> None:
    beats = 0.5 + np.arange(80) * 0.5
    found = find_beats(activations(beats, beats[::4], 41.0), metres=[(0.0, 4), (20.4, 5)])
    assert set(found.metre[found.time < 20.0].tolist()) == {4}
    assert set(found.metre[found.time > 23.0].tolist()) == {5}
    with pytest.raises(ValueError, match="no tempo between"):
        find_beats(activations(beats, beats[::4], 41.0), bpm_range=(1.0, 2.0))


def test_silence_and_nothing_are_harmless() -> None:
    empty = np.zeros(0)
    assert find_beats(Activations(empty, empty, empty)).time.size == 0
    quiet = Activations(np.arange(500) * FRAME, np.full(500, 0.01), np.full(500, 0.002))
    assert np.isfinite(find_beats(quiet).time).all()
