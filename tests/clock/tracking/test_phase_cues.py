"""Phase cues: what is heard at the quarters of a beat, the scores of four grids, and what the pointer makes of them."""

import numpy as np
import numpy.typing as npt
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW
from live.clock.tracking.phase_cues import (
    FIRST_BEATS,
    HEARD,
    ONSETS,
    PHASE_FEATURES,
    PHASE_WEIGHTS,
    PLACES,
    PhaseCues,
    QuarterFeatures,
    grid_scores,
)
from tests.clock.bar_pointer.made import follow, groove
from tests.fixtures.mostly_long import mostly_long

FRAMES = 40
"""Frames of a beat."""
SHORT, LONG = BANDS_PER_WINDOW
Features = npt.NDArray[np.float32]


def dance(beats: int, chord_beats: int = 2, seed: int = 0) -> list[Features]:
    """Frames of music: a bass note on each beat, a hat on each off-beat, a short note that leads into it, and a chord
    that changes on a beat."""
    rng = np.random.default_rng(seed)
    tones = [np.sort(rng.choice(LONG, 5, replace=False)) for _ in range(beats // chord_beats + 1)]
    frames = []
    for frame in range(beats * FRAMES):
        features = rng.gamma(1.0, 0.02, 2 * BAND_COUNT).astype(np.float32)
        features[SHORT + tones[frame // FRAMES // chord_beats]] += 2.0
        place, after = divmod(frame % FRAMES, FRAMES // PLACES)
        if after < 2 and place == 0:
            features[BAND_COUNT + SHORT : BAND_COUNT + SHORT + 14] += 1.5
        if after < 2 and place == 2:
            features[BAND_COUNT + 52 : BAND_COUNT + SHORT] += 1.0
        if after < 2 and place == 3:
            features[BAND_COUNT + 20 : BAND_COUNT + 45] += 0.4
        frames.append(features)
    return frames


def told(frame: int) -> float:
    """What a network says that takes the off-beats for the beats."""
    return 0.9 if frame % FRAMES == FRAMES // 2 else 0.05


def heard_from(first: int, beats: int = 24) -> npt.NDArray[np.float64]:
    """Features of a grid that begins `first` frames after the beats."""
    collect, last = QuarterFeatures(), None
    for frame, features in enumerate(dance(beats + 1)):
        if frame >= first:
            found = collect.step(features, told(frame), float((frame - first) % FRAMES), FRAMES)
            last = last if found is None else found
    assert last is not None
    return last


def test_places_hear_their_onsets_and_the_change_of_harmony() -> None:
    heard = heard_from(0)
    assert heard.shape == (PLACES, PHASE_FEATURES)
    np.testing.assert_allclose(heard[:, :HEARD].mean(axis=0), 0.0, atol=1e-9)
    assert heard[:, 0].argmax() == 0  # bass
    assert heard[:, 1].argmax() == 3  # middle: the pickup
    assert heard[:, 2].argmax() == 2  # hat
    assert heard[:, ONSETS].argmax() == 2  # the network
    assert heard[:, HEARD - 1].argmax() == 0  # harmony
    assert heard[0, -1] > 0.2  # it changes on each second beat


@pytest.mark.parametrize("shift", range(PLACES))
def test_a_grid_that_begins_later_hears_the_same_at_other_places(shift: int) -> None:
    np.testing.assert_allclose(heard_from(shift * FRAMES // PLACES), np.roll(heard_from(0), -shift, axis=0), atol=0.25)


@pytest.mark.parametrize("shift", range(PLACES))
def test_the_weights_find_the_beats_from_any_grid(shift: int) -> None:
    """... though the network says the off-beats."""
    cues, said, first = PhaseCues(PHASE_WEIGHTS), [], shift * FRAMES // PLACES
    for frame, features in enumerate(dance(32, seed=4)[first:]):
        found = cues.step(features, told(frame + first), float(frame % FRAMES), FRAMES)
        if found is not None:
            said.append(found)
    assert 32 - FIRST_BEATS - 2 <= len(said) <= 32 - FIRST_BEATS + 1
    scores = np.array(said)
    assert (scores.argmax(axis=1) == (PLACES - shift) % PLACES).all()
    assert (np.sort(scores)[:, -1] - np.sort(scores)[:, -2]).min() > 1.0


def test_scores_of_a_shifted_grid_are_shifted() -> None:
    rng = np.random.default_rng(1)
    features, weights = rng.normal(size=(2, PLACES, PHASE_FEATURES))
    scores = grid_scores(features, weights)
    np.testing.assert_allclose(grid_scores(np.roll(features, -1, axis=0), weights), np.roll(scores, -1))


def test_nothing_is_said_before_enough_beats_and_after_clear() -> None:
    cues, frames = PhaseCues(PHASE_WEIGHTS), dance(FIRST_BEATS - 1)
    for _ in range(2):
        assert all(cues.step(one, told(k), float(k % FRAMES), FRAMES) is None for k, one in enumerate(frames))
        cues.clear()


@pytest.mark.parametrize("shift", [1, 2, 3])
def test_after_a_shift_the_memory_belongs_to_the_new_grid(shift: int) -> None:
    later, frames = shift * FRAMES // PLACES, dance(48)
    cues = PhaseCues(PHASE_WEIGHTS)
    for frame in range(24 * FRAMES):
        found = cues.step(frames[frame], told(frame), float(frame % FRAMES), FRAMES)
    assert found is None or found.argmax() == 0
    cues.shift(shift)
    said = []
    for frame in range(24 * FRAMES, 27 * FRAMES):
        found = cues.step(frames[frame], told(frame), float((frame - later) % FRAMES), FRAMES)
        if found is not None:
            said.append(found)
    assert len(said) >= 2  # at once, not after eight beats
    assert all(scores.argmax() == PLACES - shift for scores in said)


def test_weights_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="phase cues of shape"):
        PhaseCues(np.zeros(PLACES))


def follow_with_cues(pointer: BarPointer, scores: list[float], first: int = 1000) -> float:
    """Let a pointer that heard beats until frame `first` go on to 40 s and tell it `scores` of its first beats after
    each; return how far its beats are from what it hears [beats]."""
    activations, passed, told = groove(120.0, 4, 40.0), 0, np.array(scores)
    for frame in range(first, activations.beat.size):
        pointer.step(float(activations.beat[frame]), float(activations.downbeat[frame]))
        number = int(np.searchsorted(activations.truth, frame - 30))
        if number != passed:
            passed = number
            told = np.roll(told, -pointer.add_phase_cue(told))
    last = activations.beat.size - 1 - pointer.since_beat
    nearest = activations.truth[np.abs(activations.truth - last).argmin()]
    return float((last - nearest) / pointer.interval)


def pointer_on_beats(frames: int = 1000) -> BarPointer:
    pointer = BarPointer()
    follow(pointer, groove(120.0, 4, 40.0), 0, frames)
    return pointer


@mostly_long(
    ("scores", "away"),
    [([-2.0, -3.0, 0.0, -3.0], 0.5), ([-2.0, -4.0, -4.0, 0.0], -0.25), ([-1.0, 0.0, -4.0, -2.0], 0.25)],
    quick=[1],
)
def test_sure_cues_move_the_beats_against_the_network_and_hold_them(scores: list[float], away: float) -> None:
    pointer = pointer_on_beats()
    found = follow_with_cues(pointer, scores)
    assert pointer.jumps == 1
    assert (found - away + 0.5) % 1.0 - 0.5 == pytest.approx(0.0, abs=0.05)
    assert pointer.tempo == pytest.approx(120.0, rel=0.01)
    assert pointer.phase_odds > 0.9


@mostly_long("scores", [[0.0, -4.0, -4.0, -4.0], [-0.2, -1.0, 0.0, -1.0]], quick=[])
def test_cues_for_the_beats_or_in_doubt_leave_them_alone(scores: list[float]) -> None:
    pointer = pointer_on_beats()
    assert abs(follow_with_cues(pointer, scores)) < 0.05
    assert pointer.jumps == 0


@pytest.mark.long
def test_beats_of_the_measure_are_counted_half_a_beat_later() -> None:
    pointer, other = pointer_on_beats(), pointer_on_beats()
    activations, told = groove(120.0, 4, 40.0), np.array([-3.0, -3.0, 0.0, -3.0])
    for _ in range(4):
        pointer.add_phase_cue(told)
    for frame in range(1000, 1400):
        for one in (pointer, other):
            one.step(float(activations.beat[frame]), float(activations.downbeat[frame]))
        half = 0.5 * pointer.interval
        if other.since_beat > half + 2.0:
            assert pointer.beat == other.beat
            assert pointer.since_beat == pytest.approx(other.since_beat - half, abs=0.5)
        elif other.since_beat < half - 2.0:
            assert pointer.beat == (other.beat - 1) % 4
            assert pointer.since_beat == pytest.approx(other.since_beat + half, abs=0.5)


@pytest.mark.long
def test_another_grid_begins_without_a_choice() -> None:
    pointer, activations = pointer_on_beats(), groove(156.0, 4, 30.0)
    for _ in range(4):
        pointer.add_phase_cue(np.array([-3.0, -3.0, 0.0, -3.0]))
    for frame in range(activations.beat.size):
        pointer.step(float(activations.beat[frame]), float(activations.downbeat[frame]))
    assert pointer.tempo == pytest.approx(156.0, rel=0.01)
    assert pointer.jumps >= 2
    assert pointer.phase_odds == 0.0
    last = activations.beat.size - 1 - pointer.since_beat
    assert np.abs(activations.truth - last).min() < 0.05 * pointer.interval


@mostly_long(("bpm", "kept"), [(120.0, 0.5), (123.0, 0.5), (60.0, 0.0), (90.0, 0.0)], quick=[2])
def test_a_tempo_by_hand_keeps_the_choice_if_it_is_the_same(bpm: float, kept: float) -> None:
    pointer = pointer_on_beats()
    for _ in range(4):
        pointer.add_phase_cue(np.array([-3.0, -3.0, 0.0, -3.0]))
    pointer.set_tempo(bpm)
    assert pointer.beat_offset == kept


@pytest.mark.long
def test_half_the_tempo_keeps_the_beats_that_were_chosen() -> None:
    pointer = pointer_on_beats()
    for _ in range(4):
        pointer.add_phase_cue(np.array([-3.0, -3.0, 0.0, -3.0]))
    pointer.scale(0.5)
    assert pointer.beat_offset == 0.25
    assert abs(abs(follow_with_cues(pointer, [0.0, -1.0, -1.0, -1.0])) - 0.25) < 0.03  # of beats twice as long


@pytest.mark.long
def test_a_beat_by_hand_is_left_alone_and_keeps_or_clears_the_choice() -> None:
    pointer = pointer_on_beats()
    pointer.set_beat(pointer.since_beat)
    assert abs(follow_with_cues(pointer, [-6.0, -6.0, 0.0, -6.0])) < 0.05  # no cue moves it
    for pressed, away in ((0.0, 0.5), (0.5, 0.0)):  # on the chosen beats, half a beat beside them
        chosen = pointer_on_beats()
        for _ in range(4):
            chosen.add_phase_cue(np.array([-3.0, -3.0, 0.0, -3.0]))
        chosen.set_downbeat(chosen.since_beat + pressed * chosen.interval)
        assert abs(abs(follow_with_cues(chosen, [-3.0, -3.0, 0.0, -3.0])) - away) < 0.05
