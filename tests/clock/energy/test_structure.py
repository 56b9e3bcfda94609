"""StructureDetector: which bass returns are drops; beats as values, without sound."""

import numpy as np
import pytest

from live.clock.energy.energy_frames import EnergyFeatures
from live.clock.energy.music_structure import StructureDetector

SOUND = -20.0


def find_drops(low: list[float], rise: dict[int, float] | None = None) -> list[int]:
    """Beats with a drop, for the bass level [dB] at each beat; `rise`: octaves and half decibels added at a beat."""
    structure, found, rng = StructureDetector(), [], np.random.default_rng(3)
    for beat, level in enumerate(low):
        more = (rise or {}).get(beat, 0.0)
        loudness = SOUND + 3.0 * more + rng.normal(0.0, 0.2)
        structure.add(EnergyFeatures(0.5, loudness, level, more + rng.normal(0.0, 0.02), 2))
        if structure.drop:
            found.append(beat)
    return found


GROOVE, BREAK = [-24.0] * 16, [-60.0] * 8
RISE = {beat: (beat - 19) / 6.0 for beat in range(20, 32)}


def test_steady_bass_returning_after_break_is_a_drop() -> None:
    assert find_drops(GROOVE + BREAK + GROOVE) == [24]


def test_slightly_softer_bass_return_is_a_drop() -> None:
    assert find_drops(GROOVE + BREAK + [-29.0] * 8) == [24]


@pytest.mark.parametrize("ever", [True, False])
def test_bass_after_build_up_is_always_a_drop(ever: bool) -> None:
    assert find_drops((GROOVE if ever else [-60.0] * 16) + [-60.0] * 16 + GROOVE, RISE) == [32]


def test_music_without_bass_has_no_drops() -> None:
    tune = [level - 22.0 for level in GROOVE + BREAK]
    assert find_drops(tune + tune) == []


def test_first_bass_without_build_up_is_not_a_drop() -> None:
    assert find_drops([-80.0] * 12 + GROOVE) == []


@pytest.mark.parametrize("pattern", ["x.", "x...", "xx..", "xxx.", "xx......", "xxxx....", "x.....x......"])
def test_intermittent_bass_has_no_drops(pattern: str) -> None:
    low = [-24.0 if step == "x" else -60.0 for step in pattern] * 12
    wild = np.random.default_rng(5).normal(0.0, 0.4, len(low))
    assert find_drops(low, dict(enumerate(wild.tolist()))) == []
