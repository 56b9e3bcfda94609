"""Whereabouts: whether music has left the grid, and how sure one may be of it."""

import numpy as np
import pytest

from live.clock.bar_pointer.observation_model import ActivationPhase

BEAT = 40


def heard(
    strength: tuple[float, float, float, float], beats: int = 20, after: ActivationPhase | None = None
) -> ActivationPhase:
    """Activations this strong on the beat, a quarter after it, half, three quarters."""
    found = ActivationPhase() if after is None else after
    for frame in range(beats * BEAT):
        at = frame % BEAT
        found.step(at / BEAT, strength[at // 10] if at % 10 == 0 else 0.0)
    return found


def test_strengths_are_those_of_the_last_beats() -> None:
    assert heard((0.8, 0.1, 0.3, 0.2)).strength == pytest.approx([0.8, 0.1, 0.3, 0.2], abs=0.01)


def test_music_in_between_has_left_the_grid_and_off_beats_have_not() -> None:
    assert heard((0.3, 0.7, 0.1, 0.0)).grid_is_lost
    assert not heard((0.3, 0.0, 0.7, 0.0)).grid_is_lost


def test_beats_that_were_sure_and_are_found_half_a_beat_later_are_elsewhere() -> None:
    late = (0.1, 0.0, 0.8, 0.0)
    assert not heard(late, 40).grid_is_lost  # as ever
    moved = heard((0.8, 0.0, 0.1, 0.0), 40)
    assert not moved.grid_is_lost
    assert heard(late, 4, after=moved).grid_is_lost
    assert not heard(late, 150, after=moved).grid_is_lost  # the song is like that


def test_a_measure_of_silence_is_no_reason_to_leave_the_grid() -> None:
    quiet = heard((0.0, 0.0, 0.0, 0.0), 4, after=heard((0.5, 0.0, 0.1, 0.0), 40))
    assert not quiet.grid_is_lost


def test_confidence_grows_with_the_share_and_the_beats_and_falls_with_what_lies_elsewhere() -> None:
    clear = heard((0.75, 0.02, 0.05, 0.02))
    assert 0.9 < clear.confidence(0.99) < 0.98
    assert np.all(np.diff([clear.confidence(share) for share in np.linspace(0.0, 1.0, 9)]) >= 0.0)
    assert clear.confidence(0.3) < clear.confidence(0.9) - 0.05
    for elsewhere in ((0.35, 0.02, 0.05, 0.02), (0.75, 0.02, 0.7, 0.02), (0.75, 0.7, 0.05, 0.02)):
        assert heard(elsewhere).confidence(0.99) < clear.confidence(0.99) - 0.02
    assert clear.confidence(0.9) < clear.confidence(0.9, level_is_set=True) < 1.0
    assert heard((0.1, 0.1, 0.1, 0.1)).confidence(0.02) < 0.3
