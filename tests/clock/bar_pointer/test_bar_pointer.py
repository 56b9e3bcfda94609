"""BarPointer: grooves whose beats are known, in every metre; silence, new tempi, what stays put."""

import numpy as np
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.bar_pointer.state_space import METRES
from tests.clock.bar_pointer.made import RATE, Heard, errors, follow, groove, numbers_right


def joined(*parts: Heard) -> Heard:
    """One after the other."""
    starts = np.cumsum([0, *(part.beat.size for part in parts)])
    return Heard(
        np.concatenate([part.beat for part in parts]),
        np.concatenate([part.downbeat for part in parts]),
        np.concatenate([part.truth + start for part, start in zip(parts, starts[:-1], strict=True)]),
    )


@pytest.mark.parametrize("bpm", [40, 60, 84.7, 120, 133.3, 187, 240])
def test_beats_of_any_tempo_are_found(bpm: float) -> None:
    heard = groove(bpm, 4, 14.0)
    pointer = BarPointer()
    followed = follow(pointer, heard)
    late = errors(followed, heard, 7.0)
    assert late.size == pytest.approx(7.0 * bpm / 60.0, abs=1.5)
    assert abs(np.mean(late)) < 0.012
    assert np.max(np.abs(late)) < 0.030
    assert pointer.tempo == pytest.approx(bpm, rel=0.02)
    assert pointer.confidence > 0.5


@pytest.mark.parametrize("metre", METRES)
def test_every_metre_and_its_line_are_found(metre: int) -> None:
    heard = groove(126.0, metre, 16.0)
    assert numbers_right(follow(BarPointer(), heard), heard, metre, 10.0) == 1.0


def test_noise_is_no_reason_to_lose_the_beat() -> None:
    heard = groove(104.0, 3, 30.0, doubt=0.6)
    followed = follow(BarPointer(), heard)
    assert np.percentile(np.abs(errors(followed, heard, 8.0)), 95) < 0.035
    assert numbers_right(followed, heard, 3, 15.0) > 0.9


def test_a_new_tempo_is_taken_within_four_seconds() -> None:
    first, second = groove(102.0, 4, 12.0), groove(133.0, 4, 8.0, first=20.0)
    heard = joined(first, second)
    late = errors(follow(BarPointer(), heard), heard, 16.0)
    assert late.size >= 8
    assert np.max(np.abs(late)) < 0.035


def test_without_listening_the_grid_runs_on_and_nothing_else_changes() -> None:
    heard = groove(120.0, 4, 10.0)
    pointer = BarPointer()
    follow(pointer, heard)
    pointer.step(0.0, 0.0, listening=False)
    assert pointer.tempo == pytest.approx(120.0, rel=4e-3)
    tempo, beat, ahead = pointer.tempo, pointer.beat, pointer.to_next
    frames = round(8.0 * RATE)
    for _ in range(frames):
        pointer.step(0.0, 0.0, listening=False)
    gone = ahead + np.arange(40) * pointer.interval - frames
    passed = int(np.sum(gone <= 0.0))
    assert pointer.tempo == pytest.approx(tempo)
    assert pointer.to_next == pytest.approx(gone[passed], abs=1e-6)
    assert pointer.beat == (beat + passed) % 4


@pytest.mark.parametrize("bpm", [70.0, 93.0, 141.0])
def test_what_was_made_of_missing_beats_is_taken_back_when_music_has_ended(bpm: float) -> None:
    """For two seconds beats are missed before it is known that nobody plays; the measure goes on as it was."""
    heard = groove(bpm, 4, 16.0, doubt=0.3)
    pointer = BarPointer()
    follow(pointer, heard)
    missed = round(2.0 * RATE)
    for _ in range(missed):
        pointer.step(0.005, 0.002)
    pointer.restore_before(missed)
    for _ in range(round(6.0 * RATE)):
        pointer.step(0.005, 0.002, listening=False)
    now = heard.beat.size + missed + round(6.0 * RATE) - 1
    beats = (now - pointer.since_beat - heard.truth[0]) / (60.0 * RATE / bpm)
    assert abs(beats - round(beats)) * 60.0 * RATE / bpm < 2.5
    assert pointer.beat == round(beats) % 4
    pointer.resume(0.3)
    coming = (pointer.beat + 1) % 4
    again = groove(bpm, 4, 6.0, first=pointer.to_next)
    again.downbeat[:] = 0.25 * again.beat  # the line is known from before alone
    followed = follow(pointer, again)
    assert np.max(np.abs(errors(followed, again, 0.5))) < 0.035
    number = np.argmin(np.abs(followed.time[:4, None] - again.truth[None]), axis=1)
    assert np.all(followed.beat[1:4] == (coming + number[1:]) % 4)


def test_an_accent_on_the_off_beat_does_not_move_a_grid_that_is_sure() -> None:
    heard = groove(100.0, 4, 16.0)
    half = 0.5 * 60.0 * RATE / 100.0
    beat, downbeat = heard.beat.copy(), heard.downbeat.copy()
    for place in heard.truth[(heard.truth > 10.0 * RATE) & (heard.truth < 11.5 * RATE)]:
        beat[int(place + half)] = 0.9
    late = errors(follow(BarPointer(), Heard(beat, downbeat, heard.truth)), heard, 6.0)
    assert np.max(np.abs(late)) < 0.03


def test_a_minute_of_one_groove_without_a_slip() -> None:
    """No beat too many or too few, and no drift (half an hour of sound: bench/_long_groove.py)."""
    heard = groove(121.3, 4, 60.0, doubt=0.2)
    followed = follow(BarPointer(), heard)
    steps = np.diff(followed.time[followed.time > 8.0 * RATE]) / (60.0 * RATE / 121.3)
    assert np.all(np.abs(steps - 1.0) < 0.08)
    assert abs(np.mean(errors(followed, heard, 30.0)) - np.mean(errors(followed, heard, 8.0))) < 0.003


def test_the_same_frames_give_the_same_bits() -> None:
    heard = groove(97.0, 3, 6.0, doubt=0.5)
    one, other = BarPointer(), BarPointer()
    follow(one, heard)
    follow(other, heard)
    assert (one.tempo, one.to_next, one.share) == (other.tempo, other.to_next, other.share)


def test_clear_forgets() -> None:
    pointer, fresh = BarPointer(), BarPointer()
    follow(pointer, groove(140.0, 4, 6.0))
    pointer.clear()
    heard = groove(90.0, 3, 6.0)
    assert np.array_equal(follow(pointer, heard).time, follow(fresh, heard).time)
