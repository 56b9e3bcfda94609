"""BarPointer on grooves with known beats: every metre, noise, silence, tempo changes and stability."""

import numpy as np
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.bar_pointer.metre import DEFAULT, METRES, Metre, counted_metre
from live.clock.bar_pointer.state_space import BarPointerModel
from tests.clock.bar_pointer.made import RATE, Activations, beat_number_accuracy, errors, follow, groove
from tests.fixtures.mostly_long import mostly_long


def concatenate_activations(*parts: Activations) -> Activations:
    """Concatenates the parts in time."""
    starts = np.cumsum([0, *(part.beat.size for part in parts)])
    return Activations(
        np.concatenate([part.beat for part in parts]),
        np.concatenate([part.downbeat for part in parts]),
        np.concatenate([part.truth + start for part, start in zip(parts, starts[:-1], strict=True)]),
    )


@mostly_long("bpm", [40, 60, 84.7, 120, 133.3, 187, 240], quick=[3])
def test_beats_are_found_at_any_tempo(bpm: float) -> None:
    activations = groove(bpm, 4, 14.0)
    pointer = BarPointer()
    followed = follow(pointer, activations)
    late = errors(followed, activations, 7.0)
    assert late.size == pytest.approx(7.0 * bpm / 60.0, abs=1.5)
    assert abs(np.mean(late)) < 0.012
    assert np.max(np.abs(late)) < 0.030
    assert pointer.tempo == pytest.approx(bpm, rel=0.02)
    assert pointer.confidence > 0.5


@mostly_long("metre", METRES, quick=[1])
def test_every_metre_and_its_downbeat_are_found(metre: int) -> None:
    after = 10.0 if metre in (2, 3, 4, 6) else 18.0  # rare metres need more measures
    activations = groove(126.0, metre, after + 6.0)
    pointer = BarPointer(BarPointerModel(metres=(*DEFAULT, Metre(8)))) if metre == 8 else BarPointer()
    assert beat_number_accuracy(follow(pointer, activations), activations, metre, after) == 1.0


@pytest.mark.long
def test_only_the_metres_given_are_found() -> None:
    activations = groove(126.0, 5, 16.0)
    pointer = BarPointer(BarPointerModel(metres=(Metre(3), Metre(4))))
    assert set(follow(pointer, activations).metre[8:].tolist()) <= {3, 4}


@pytest.mark.long
def test_groups_decide_where_a_measure_of_five_begins() -> None:
    """Strong first and fourth beats alike are 3 + 2 from the first on, or 2 + 3 from the fourth on."""
    activations = groove(126.0, 5, 30.0)
    for number, place in enumerate(activations.truth):
        if number % 5 == 3:
            frames = slice(max(int(place) - 2, 0), int(place) + 4)
            activations.downbeat[frames] = 0.8 * activations.beat[frames]
    for text, first in (("3+2", 0), ("2+3", 3)):
        pointer = BarPointer(BarPointerModel(metres=(Metre.parse(text),)))
        followed = follow(pointer, activations)
        late = followed.time > 15.0 * RATE
        number = np.argmin(np.abs(followed.time[late, None] - activations.truth[None]), axis=1)
        assert np.all(followed.beat[late] == (number - first) % 5)


@pytest.mark.parametrize(
    ("text", "beats", "groups"), [(5, 5, ()), ("7", 7, ()), ("3+2", 5, (3, 2)), ("3+3+2", 8, (3, 3, 2))]
)
def test_metres_are_read(text: str | int, beats: int, groups: tuple[int, ...]) -> None:
    assert Metre.parse(text) == Metre(beats, groups)


@pytest.mark.parametrize("text", ["", "1", "10", "3+", "0+4", "-3", "4/4", "3+2+5", "9999999", "³"])
def test_other_metres_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"expected|has 2 to 9 beats"):
        Metre.parse(text)


@pytest.mark.parametrize(
    ("beats", "counted"), [(0, 0), (1, 0), (2, 2), (7, 7), (8, 4), (10, 5), (11, 0), (12, 6), (16, 4)]
)
def test_long_measures_are_counted_in_parts(beats: int, counted: int) -> None:
    assert counted_metre(beats, DEFAULT) == counted
    assert counted_metre(8, (Metre(8),)) == 8


@pytest.mark.long
def test_noisy_activations_do_not_lose_the_beat() -> None:
    activations = groove(104.0, 3, 30.0, doubt=0.6)
    followed = follow(BarPointer(), activations)
    assert np.percentile(np.abs(errors(followed, activations, 8.0)), 95) < 0.035
    assert beat_number_accuracy(followed, activations, 3, 15.0) > 0.9


@pytest.mark.long
def test_new_tempo_is_followed_within_four_seconds() -> None:
    first, second = groove(102.0, 4, 12.0), groove(133.0, 4, 8.0, first=20.0)
    activations = concatenate_activations(first, second)
    late = errors(follow(BarPointer(), activations), activations, 16.0)
    assert late.size >= 8
    assert np.max(np.abs(late)) < 0.035


def test_grid_continues_unchanged_while_not_listening() -> None:
    activations = groove(120.0, 4, 10.0)
    pointer = BarPointer()
    follow(pointer, activations)
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


@mostly_long("bpm", [70.0, 93.0, 141.0], quick=[1])
def test_grid_before_missing_beats_is_restored_after_music_ends(bpm: float) -> None:
    """Beats are missing for two seconds before the end of music is detected; the measure continues as before."""
    activations = groove(bpm, 4, 16.0, doubt=0.3)
    pointer = BarPointer()
    follow(pointer, activations)
    missed = round(2.0 * RATE)
    for _ in range(missed):
        pointer.step(0.005, 0.002)
    pointer.restore_before(missed)
    for _ in range(round(6.0 * RATE)):
        pointer.step(0.005, 0.002, listening=False)
    now = activations.beat.size + missed + round(6.0 * RATE) - 1
    beats = (now - pointer.since_beat - activations.truth[0]) / (60.0 * RATE / bpm)
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


@mostly_long("wrong", [1, 2, 3], quick=[])
def test_after_a_stop_the_old_line_stays_although_the_music_seems_to_begin_anew(wrong: int) -> None:
    """The music returns on the grid, in the middle of a measure; for two measures its first beat is heard as a one."""
    activations = groove(112.0, 4, 20.0)
    pointer = BarPointer()
    follow(pointer, activations)
    for _ in range(round(4.0 * RATE)):
        pointer.step(0.005, 0.002, listening=False)
    pointer.resume(0.3)
    coming = (pointer.beat + 1) % 4
    again = groove(112.0, 4, 20.0, first=pointer.to_next)
    period = 60.0 * RATE / 112.0
    for number, place in enumerate(again.truth):
        one = (number + wrong) % 4 == 0 if number < 8 else (number + coming) % 4 == 0
        at = slice(max(int(place) - 2, 0), int(place) + 4)
        again.downbeat[at] = again.beat[at] * (0.8 if one else 0.1)
    followed = follow(pointer, again)
    number = np.round((followed.time - again.truth[0]) / period).astype(int)
    assert np.all(followed.beat[1:] == (coming + number[1:]) % 4)


@pytest.mark.long
def test_offbeat_accent_does_not_shift_confident_grid() -> None:
    activations = groove(100.0, 4, 16.0)
    half = 0.5 * 60.0 * RATE / 100.0
    beat, downbeat = activations.beat.copy(), activations.downbeat.copy()
    for place in activations.truth[(activations.truth > 10.0 * RATE) & (activations.truth < 11.5 * RATE)]:
        beat[int(place + half)] = 0.9
    late = errors(follow(BarPointer(), Activations(beat, downbeat, activations.truth)), activations, 6.0)
    assert np.max(np.abs(late)) < 0.03


@pytest.mark.long
def test_steady_groove_is_tracked_for_a_minute_without_slips() -> None:
    """No missing or extra beat, and no drift (half an hour of sound: bench/_long_groove.py)."""
    activations = groove(121.3, 4, 60.0, doubt=0.2)
    followed = follow(BarPointer(), activations)
    steps = np.diff(followed.time[followed.time > 8.0 * RATE]) / (60.0 * RATE / 121.3)
    assert np.all(np.abs(steps - 1.0) < 0.08)
    assert abs(np.mean(errors(followed, activations, 30.0)) - np.mean(errors(followed, activations, 8.0))) < 0.003


def test_same_frames_give_identical_state() -> None:
    activations = groove(97.0, 3, 6.0, doubt=0.5)
    one, other = BarPointer(), BarPointer()
    follow(one, activations)
    follow(other, activations)
    assert (one.tempo, one.to_next, one.share) == (other.tempo, other.to_next, other.share)


@pytest.mark.long
def test_clear_resets_the_state() -> None:
    pointer, fresh = BarPointer(), BarPointer()
    follow(pointer, groove(140.0, 4, 6.0))
    pointer.clear()
    activations = groove(90.0, 3, 6.0)
    assert np.array_equal(follow(pointer, activations).time, follow(fresh, activations).time)
