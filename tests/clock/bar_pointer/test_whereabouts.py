"""Activation phase: detection of a lost grid, and confidence."""

import numpy as np
import pytest

from live.clock.bar_pointer.observation_model import ActivationPhase

BEAT = 40


def feed_activations(
    strength: tuple[float, float, float, float], beats: int = 20, after: ActivationPhase | None = None
) -> ActivationPhase:
    """Feeds activations of this strength on the beat and a quarter, half and three quarters after it."""
    found = ActivationPhase() if after is None else after
    for frame in range(beats * BEAT):
        at = frame % BEAT
        found.step(at / BEAT, strength[at // 10] if at % 10 == 0 else 0.0)
    return found


def test_strengths_match_recent_activations() -> None:
    assert feed_activations((0.8, 0.1, 0.3, 0.2)).strength == pytest.approx([0.8, 0.1, 0.3, 0.2], abs=0.01)


def test_quarter_offset_loses_the_grid_but_offbeats_do_not() -> None:
    assert feed_activations((0.3, 0.7, 0.1, 0.0)).grid_is_lost
    assert not feed_activations((0.3, 0.0, 0.7, 0.0)).grid_is_lost


def test_shift_of_confident_beats_to_offbeat_loses_the_grid() -> None:
    late = (0.1, 0.0, 0.8, 0.0)
    assert not feed_activations(late, 40).grid_is_lost  # unchanged
    moved = feed_activations((0.8, 0.0, 0.1, 0.0), 40)
    assert not moved.grid_is_lost
    assert feed_activations(late, 4, after=moved).grid_is_lost
    assert not feed_activations(late, 150, after=moved).grid_is_lost  # the offbeat accents persist


def test_measure_of_silence_keeps_the_grid() -> None:
    quiet = feed_activations((0.0, 0.0, 0.0, 0.0), 4, after=feed_activations((0.5, 0.0, 0.1, 0.0), 40))
    assert not quiet.grid_is_lost


def test_confidence_grows_with_share_strength_and_phase_cues() -> None:
    clear = feed_activations((0.75, 0.02, 0.05, 0.02))
    assert 0.7 < clear.confidence(0.99) < clear.confidence(0.99, phase_odds=4.0) < 0.98
    assert clear.confidence(0.99, phase_odds=-4.0) < clear.confidence(0.99) - 0.1
    assert np.all(np.diff([clear.confidence(share) for share in np.linspace(0.0, 1.0, 9)]) >= 0.0)
    assert clear.confidence(0.3) < clear.confidence(0.9) - 0.05
    for weaker in (0.2, 0.4, 0.6):
        assert feed_activations((weaker, 0.02, 0.05, 0.02)).confidence(0.99) < clear.confidence(0.99) - 0.05
    assert clear.confidence(0.9) < clear.confidence(0.9, level_is_set=True) < 1.0
    assert feed_activations((0.1, 0.1, 0.1, 0.1)).confidence(0.02) < 0.3
