"""What people say by hand: the tempo and its level, half and double, the one, the metre."""

import numpy as np
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from tests.clock.bar_pointer.made import RATE, errors, follow, groove, numbers_right


def test_a_tapped_tempo_is_obeyed_and_its_level_kept() -> None:
    """Every beat of the groove sounds; the hand says that only every second one is a beat."""
    heard = groove(150.0, 4, 20.0)
    pointer = BarPointer()
    follow(pointer, heard, 0, int(5.0 * RATE))
    assert pointer.tempo == pytest.approx(150.0, rel=0.03)
    pointer.set_tempo(75.0)
    follow(pointer, heard, int(5.0 * RATE), int(5.1 * RATE))
    assert pointer.tempo == pytest.approx(75.0, rel=0.04)
    follow(pointer, heard, int(5.1 * RATE))
    assert pointer.tempo == pytest.approx(75.0, rel=0.03)


def test_a_tap_that_is_a_little_wrong_is_put_right_by_the_music() -> None:
    heard = groove(96.0, 4, 12.0)
    pointer = BarPointer()
    follow(pointer, heard, 0, int(3.0 * RATE))
    pointer.set_tempo(99.5)
    follow(pointer, heard, int(3.0 * RATE))
    assert pointer.tempo == pytest.approx(96.0, rel=0.015)


@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_scaling_by_two_halves_the_period_at_once(factor: float) -> None:
    heard = groove(100.0, 4, 12.0)
    pointer = BarPointer()
    follow(pointer, heard, 0, int(8.0 * RATE))
    before = pointer.interval
    pointer.scale(factor)
    follow(pointer, heard, int(8.0 * RATE), int(8.0 * RATE) + 4)
    assert pointer.interval == pytest.approx(before / factor, rel=0.03)
    late = errors(follow(pointer, heard, int(8.0 * RATE) + 4), heard, 8.1)
    near = np.abs(late) < 0.04
    assert near.all() if factor == 0.5 else 0.3 < np.mean(near) < 0.7
    assert pointer.tempo == pytest.approx(100.0 * factor, rel=0.03)


def test_scaling_beyond_what_is_danced_changes_nothing() -> None:
    heard = groove(200.0, 4, 6.0)
    pointer = BarPointer()
    follow(pointer, heard)
    before = pointer.interval
    pointer.scale(2.0)
    pointer.step(0.01, 0.003)
    assert pointer.interval == pytest.approx(before, rel=0.02)
    with pytest.raises(ValueError, match=r"2 or 0\.5"):
        pointer.scale(3.0)


@pytest.mark.parametrize("wanted", [0, 1, 2, 3])
def test_this_is_the_one(wanted: int) -> None:
    """The network hears no downbeats at all: whichever beat is pressed begins the measures from then on."""
    heard = groove(116.0, 4, 16.0)
    heard.downbeat[:] = 0.25 * heard.beat
    pointer = BarPointer()
    pointer.set_metre(4)
    begin = int(8.0 * RATE)
    follow(pointer, heard, 0, begin)
    pressed = heard.truth[heard.truth < begin - 5][-4 + wanted]
    pointer.set_downbeat(begin - 1 - pressed + 1.5)  # pressed a little early
    followed = follow(pointer, heard, begin)
    number = np.argmin(np.abs(followed.time[:, None] - heard.truth[None]), axis=1)
    first = int(np.argmin(np.abs(heard.truth - pressed)))
    assert np.all(followed.beat == (number - first) % 4)


def test_a_line_that_was_set_is_given_up_only_when_the_music_says_so_clearly() -> None:
    heard = groove(116.0, 4, 60.0)
    heard.downbeat[:] = 0.3 * heard.beat + 0.2 * heard.downbeat
    pointer = BarPointer()
    pointer.set_metre(4)
    begin = int(3.0 * RATE)
    follow(pointer, heard, 0, begin)
    wrong = heard.truth[5]
    pointer.set_downbeat(begin - 1 - wrong)
    soon = follow(pointer, heard, begin, begin + int(1.5 * RATE))
    number = np.argmin(np.abs(soon.time[:, None] - heard.truth[None]), axis=1)
    assert np.all(soon.beat == (number - 5) % 4)
    later = follow(pointer, heard, begin + int(1.5 * RATE))
    assert numbers_right(later, heard, 4, 52.0) == 1.0


@pytest.mark.parametrize("metre", [2, 3, 4, 6])
def test_the_metre_can_be_set(metre: int) -> None:
    heard = groove(120.0, 4, 8.0)
    pointer = BarPointer()
    follow(pointer, heard, 0, 300)
    pointer.set_metre(metre)
    followed = follow(pointer, heard, 300)
    assert np.all(followed.metre == metre)
    pointer.set_metre(0)


def test_what_is_no_metre_and_no_tempo_is_refused() -> None:
    pointer = BarPointer()
    with pytest.raises(ValueError, match="5 beats"):
        pointer.set_metre(5)
    for bpm in (0.0, 500.0, float("nan")):
        with pytest.raises(ValueError, match="bpm"):
            pointer.set_tempo(bpm)


def test_let_go_frees_the_level() -> None:
    heard = groove(160.0, 4, 30.0)
    pointer = BarPointer()
    follow(pointer, heard, 0, 200)
    pointer.set_tempo(80.0)
    follow(pointer, heard, 200, 600)
    assert pointer.tempo == pytest.approx(80.0, rel=0.03)
    pointer.clear_manual()
    follow(pointer, heard, 600)
    assert pointer.tempo == pytest.approx(160.0, rel=0.03)
