"""Tests of motion beats against chance: dancers who stop on the beats or anywhere, laws of chance, and no beats."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.quality.beat_chance import compare_with_chance, shift_beats
from live.motion.quality.metrics import ALIGNMENT_DEVIATION, mean_speed, motion_beats

RATE = 60.0
BEAT = 0.5


def motion_beats_of_stops(stops):
    """Motion beats of a dancer who goes to and fro and stands still at these times [s], ascending."""
    time = np.arange(int(stops[-1] * RATE) + 1) / RATE
    place = np.interp(time, stops, np.arange(len(stops)))
    position = np.zeros((len(time), 2, 3))
    position[..., 0] = 0.2 * np.cos(np.pi * place)[:, None]
    return motion_beats(mean_speed(position, RATE), RATE)


def expected_chance(beat):
    """The Gaussian's mean over all distances from 0 to half a beat."""
    return (
        math.sqrt(2.0 * math.pi)
        * ALIGNMENT_DEVIATION
        * math.erf(beat / (2.0 * math.sqrt(2.0) * ALIGNMENT_DEVIATION))
        / beat
    )


def test_dancer_who_stops_on_beats_is_far_above_chance():
    beats = np.arange(1.0, 60.0, BEAT)
    found = compare_with_chance(beats, [motion_beats_of_stops(np.arange(0.0, 61.1, BEAT))])
    assert found.alignment["music"] > 0.97
    assert found.alignment["kinematic"] > 0.9  # stops before and after the music count
    assert found.alignment["music_ratio"] > 3.8
    assert found.alignment["kinematic_ratio"] > 3.6
    assert np.median(np.abs(found.offset)) < 0.01


def test_dancer_who_stops_anywhere_is_at_chance():
    """Within three standard deviations of m stops, 3 x 1.35 / sqrt(m); the music has more beats than that."""
    stops = np.cumsum(np.random.default_rng(3).uniform(0.35, 0.75, 1000))
    own = motion_beats_of_stops(stops)
    assert len(own) > 950
    beats = np.arange(1.0, stops[-1], BEAT)
    found = compare_with_chance(beats, [own])
    assert found.alignment["kinematic_ratio"] == pytest.approx(1.0, abs=4.05 / math.sqrt(len(own)))
    assert found.alignment["music_ratio"] == pytest.approx(1.0, abs=4.05 / math.sqrt(len(own)))
    medians = [np.median(np.abs(each)) for each in (found.offset, found.chance_offset)]
    assert medians[0] == pytest.approx(medians[1], rel=0.1)


@given(st.lists(st.floats(0.0, 20.0), min_size=1, max_size=20), st.sampled_from([0.3, 0.5, 1.0]))
def test_chance_of_even_beats_is_the_same_for_all_stops(stops, beat):
    """It is the kernel's mean over half a beat, in closed form."""
    found = compare_with_chance(np.arange(0.0, 20.01 + beat, beat), [np.sort(stops)])
    assert found.alignment["kinematic_chance"] == pytest.approx(expected_chance(beat), rel=1e-3)


def test_chance_of_offsets_is_even_over_half_a_beat():
    found = compare_with_chance(np.arange(0.0, 20.0, BEAT), [np.arange(-1.0, 21.0, BEAT) + 0.07])
    size = np.abs(found.chance_offset)
    assert np.percentile(size, [25, 50, 95]) == pytest.approx([BEAT / 8, BEAT / 4, 0.475 * BEAT], abs=BEAT / 32)
    assert found.alignment["music_chance"] == pytest.approx(expected_chance(BEAT), rel=1e-3)


def test_figures_are_means_of_dancers():
    beats, good, bad = np.arange(20.0), np.arange(20.0), np.arange(20.0) + 0.4
    both = compare_with_chance(beats, [good, bad]).alignment
    alone = [compare_with_chance(beats, [own]).alignment for own in (good, bad)]
    for name in ("music", "kinematic", "music_chance", "kinematic_chance"):
        assert both[name] == pytest.approx(np.mean([each[name] for each in alone]))
    assert both["music_ratio"] == pytest.approx(both["music"] / both["music_chance"])
    assert alone[1]["music_ratio"] < 0.01


def test_beats_are_shifted_by_their_own_length():
    beats = np.array([0.0, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(shift_beats(beats, 0.5), [0.25, 0.75, 1.5, 2.5])
    np.testing.assert_allclose(shift_beats(beats, -0.5), [-0.25, 0.25, 0.75, 1.5])
    np.testing.assert_array_equal(shift_beats(beats, 0.0), beats)


@pytest.mark.parametrize(
    ("beats", "motion"),
    [([], [[1.0, 2.0]]), ([1.0], [[1.0, 2.0]]), ([1.0, 2.0], [[], []]), ([1.0, 2.0], []), ([], [[]]), ([], [])],
)
def test_without_beats_chance_is_none(beats, motion):
    found = compare_with_chance(np.array(beats), [np.array(own) for own in motion])
    json.dumps(found.alignment, allow_nan=False)
    for name in ("music_chance", "kinematic_chance", "music_ratio", "kinematic_ratio"):
        assert found.alignment[name] is None
    assert len(found.chance_offset) == 0


def test_still_dancer_counts_as_missed_beats_only():
    """As in the figure itself: beats without a move count 0, moves that are not there are not counted."""
    beats, own = np.arange(10.0), np.arange(10.0) + 0.03
    one, two = (compare_with_chance(beats, motion).alignment for motion in ([own], [own, np.zeros(0)]))
    assert two["music"] == pytest.approx(one["music"] / 2)
    assert two["music_chance"] == pytest.approx(one["music_chance"] / 2)
    assert two["kinematic_chance"] == pytest.approx(one["kinematic_chance"])
