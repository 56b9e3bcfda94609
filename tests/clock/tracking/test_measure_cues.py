"""Measure cues: features of beats, their odds, and what the pointer makes of them."""

import numpy as np
import numpy.typing as npt
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.bar_pointer.bar_pointer_kernels import weigh_slots
from live.clock.bar_pointer.metre import SLOTS
from live.clock.tracking.beat_network import ActivationStream, BeatNetwork, NetworkWeights
from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW
from live.clock.tracking.measure_cues import CUE_WEIGHTS, CUES, FEATURES, BeatFeatures, MeasureCues
from tests.clock.bar_pointer.made import beat_number_accuracy, follow, groove
from tests.clock.clicks import groove as groove_sound
from tests.clock.tracking.made_weights import random_weights

FRAMES = 40
"""Frames of a beat."""
SHORT, LONG = BANDS_PER_WINDOW
Features = npt.NDArray[np.float32]


def chords(beats: int, metre: int, seed: int = 0) -> list[tuple[int, int, Features]]:
    """(beat, frame of the beat, features): a chord that changes at each measure, with an attack on each beat; a low
    note begins with the measure."""
    rng = np.random.default_rng(seed)
    tones = [np.sort(rng.choice(LONG, 5, replace=False)) for _ in range(beats // metre + 1)]
    frames = []
    for beat in range(beats):
        for frame in range(FRAMES):
            features = rng.gamma(1.0, 0.02, 2 * BAND_COUNT).astype(np.float32)
            features[SHORT + tones[beat // metre]] += 2.0
            if frame < 2:
                features[BAND_COUNT:] += 0.5
                if beat % metre == 0:
                    features[BAND_COUNT + SHORT : BAND_COUNT + SHORT + 14] += 1.5
            frames.append((beat, frame, features))
    return frames


def test_features_tell_change_of_harmony_and_bass() -> None:
    collect, found = BeatFeatures(), {}
    for beat, frame, features in chords(32, 4):
        row = collect.step(features, 0.8, 0.2, float(frame), FRAMES)
        if row is not None:
            found[beat] = row
    assert sorted(found) == list(range(1, 32))  # of the first one the attack was missed
    late = {beat: row for beat, row in found.items() if beat >= 8}
    ones = np.array([row for beat, row in late.items() if beat % 4 == 0])
    others = np.array([row for beat, row in late.items() if beat % 4])
    assert ones.shape[1] == FEATURES
    for column in (0, 2):  # harmony, onset of the bass
        assert ones[:, column].min() > 1.0
        assert others[:, column].max() < 0.5
    assert np.allclose(ones[:, 6], np.log(0.25 / 0.75))  # what the network said: 0.2 of 0.8


def test_the_weights_take_a_new_chord_over_a_low_note_for_a_measure() -> None:
    cues, odds = MeasureCues(CUE_WEIGHTS), {}
    for beat, frame, features in chords(48, 4, seed=3):
        found = cues.step(features, 0.8, 0.2, float(frame), FRAMES)
        if found is not None:
            odds[beat - 1] = found
    late = {beat: value for beat, value in odds.items() if beat >= 8}
    others = [value for beat, value in late.items() if beat % 4]
    assert min(value for beat, value in late.items() if beat % 4 == 0) > max(others) + 0.5
    assert np.mean(others) < 0.0
    cues.clear()
    assert cues.step(np.zeros(2 * BAND_COUNT, np.float32), 0.0, 0.0, 39.0, FRAMES) is None


def test_weights_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="cues of shape"):
        MeasureCues(np.zeros(CUES))


@pytest.mark.long
def test_cues_find_the_line_where_the_network_is_silent_about_it() -> None:
    activations = groove(116.0, 4, 60.0)
    activations.downbeat[:] = 0.25 * activations.beat
    pointer, passed, given = BarPointer(), -1, -1
    pointer.set_metre(4)
    found = []
    for frame in range(activations.beat.size):
        pointer.step(float(activations.beat[frame]), float(activations.downbeat[frame]))
        number = int(np.searchsorted(activations.truth, frame)) - 1
        if number != passed:
            passed = number
            found.append((number, pointer.beat))
        if number != given and number > 4 and frame - activations.truth[number] > 0.7 * 60.0 * 86.13 / 116.0:
            given = number
            pointer.add_measure_cue(1.0 if (number - 1) % 4 == 1 else -0.4)  # measures begin with beat 1, 5, 9 ...
    late = [(number, beat) for number, beat in found if number > 70]
    assert np.mean([(number - 1) % 4 == beat for number, beat in late]) > 0.9
    assert pointer.tempo == pytest.approx(116.0, rel=0.01)


@pytest.mark.long
def test_cues_do_not_move_a_line_set_by_hand() -> None:
    activations = groove(120.0, 4, 60.0)
    pointer = BarPointer()
    follow(pointer, activations, 0, 1000)
    pointer.set_downbeat(float(1000 - activations.truth[21]))  # the second beat of a measure
    before = pointer._states.share.copy()
    for _ in range(50):
        pointer.add_measure_cue(1.5)
    np.testing.assert_array_equal(pointer._states.share, before)
    followed = follow(pointer, activations, 1000)
    assert beat_number_accuracy(followed, activations, 4, 13.0) == 0.0  # all are one off, as they were set


def test_slots_of_other_grids_are_left_alone() -> None:
    rng = np.random.default_rng(2)
    pointer = BarPointer()
    states = pointer._states
    states.share[:] = rng.random(states.share.shape).astype(np.float32)
    states.head[:] = rng.integers(0, states.length)
    before, factors = states.share.copy(), rng.random(SLOTS).astype(np.float32)
    weigh_slots(states.share, states.head, states.offset, states.length, 60.0, 0.7, 0.08, factors)
    phase = states.positions() / states.row_interval
    near = (np.abs(states.row_interval / 60.0 - 1.0) <= 0.08) & (np.abs(phase - 0.7) <= 0.25 + 1e-6)
    expected = np.where(near[:, None], before * factors, before)
    np.testing.assert_allclose(states.share, expected, rtol=1e-6)


def test_features_of_a_frame_are_those_of_its_moment() -> None:
    """The network answers for two frames at once; each keeps its own features."""
    sound = groove_sound(120, 44_100, 2.0)
    one, rows = ActivationStream(44_100, BeatNetwork(NetworkWeights.from_arrays(random_weights()))), []
    for start in range(0, sound.size, 512):
        rows += [one.features[frame].copy() for frame in range(one.feed(sound[start : start + 512]))]
    whole = ActivationStream(44_100, BeatNetwork(NetworkWeights.from_arrays(random_weights())))
    count = whole.feed(sound)
    np.testing.assert_array_equal(np.array(rows), whole.features[:count])
    assert np.abs(np.diff(np.array(rows), axis=0)).max(axis=1).min() > 0.0  # no frame is its neighbour's copy
