"""Structure: which returns of the bass are drops; beats as values, without sound."""

import numpy as np
import pytest

from live.clock.energy.energy_frames import EnergyFeatures
from live.clock.energy.music_structure import StructureDetector

SOUND = -20.0


def drops(low: list[float], rise: dict[int, float] | None = None) -> list[int]:
    """Beats with a drop, for the level of the bass [dB] at each; `rise`: octaves and half decibels more at a beat."""
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


def test_a_bass_that_was_steady_and_returns_after_a_break_drops() -> None:
    assert drops(GROOVE + BREAK + GROOVE) == [24]


def test_a_bass_that_returns_a_little_softer_drops_too() -> None:
    assert drops(GROOVE + BREAK + [-29.0] * 8) == [24]


@pytest.mark.parametrize("ever", [True, False])
def test_a_build_up_drops_after_a_groove_or_where_there_was_never_a_bass(ever: bool) -> None:
    assert drops((GROOVE if ever else [-60.0] * 16) + [-60.0] * 16 + GROOVE, RISE) == [32]


def test_what_is_lowest_in_a_tune_without_bass_comes_and_goes() -> None:
    tune = [level - 22.0 for level in GROOVE + BREAK]
    assert drops(tune + tune) == []


def test_the_first_bass_of_a_piece_is_no_drop_without_a_build_up() -> None:
    assert drops([-80.0] * 12 + GROOVE) == []


@pytest.mark.parametrize("pattern", ["x.", "x...", "xx..", "xxx.", "xx......", "xxxx....", "x.....x......"])
def test_a_bass_that_comes_and_goes_has_no_drops(pattern: str) -> None:
    low = [-24.0 if step == "x" else -60.0 for step in pattern] * 12
    wild = np.random.default_rng(5).normal(0.0, 0.4, len(low))
    assert drops(low, dict(enumerate(wild.tolist()))) == []
