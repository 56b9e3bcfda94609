"""Tests of found steps: measures that are alike, wherever they are danced, and measures that belong together."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.graph.build.metric import Metric, joint_weights, window_weights
from live.graph.build.transitions import all_pairs
from live.graph.vocabulary.measures import Measures, measure_distances
from live.graph.vocabulary.repeats import alike_measures, find_steps
from live.motion.skeleton import JOINT_COUNT

POSES = 17


def made_measures(kinds, seed=0, noise=0.03, recordings=None):
    """Measures of the given kinds: each a motion of its own, danced anywhere on the stage, a little differently."""
    kinds = np.asarray(kinds)
    swing = np.random.default_rng(7).normal(0.0, 0.3, (max(kinds, default=0) + 1, 1, JOINT_COUNT, 3))
    phase = np.linspace(0.0, 1.0, POSES)[None, :, None, None]
    body = np.random.default_rng(8).normal((0.0, 1.0, 0.0), 0.3, (1, 1, JOINT_COUNT, 3))
    pose = (body + swing * np.sin(2.0 * np.pi * phase))[kinds]
    chance = np.random.default_rng(seed)
    pose = pose + noise * chance.normal(size=(len(kinds), 1, JOINT_COUNT, 3))
    yaw = chance.uniform(-3, 3, (len(kinds), 1, 1))
    x, z = pose[..., 0].copy(), pose[..., 2].copy()
    pose[..., 0] = x * np.cos(yaw) + z * np.sin(yaw) + chance.uniform(-4, 4, (len(kinds), 1, 1))
    pose[..., 2] = z * np.cos(yaw) - x * np.sin(yaw) + chance.uniform(-4, 4, (len(kinds), 1, 1))
    recording = np.zeros(len(kinds), np.int32) if recordings is None else np.asarray(recordings, np.int32)
    number = np.concatenate([np.arange(n) for n in np.bincount(recording)]).astype(np.int32)
    contact = np.ones((len(kinds), POSES, 2), np.bool_)
    return Measures(recording, number, pose, contact, np.full(len(kinds), 2.0), 4)


def steps_of(measures):
    """Length and starts of the found steps, in order."""
    found = find_steps(measures, measure_distances(measures))
    return [(step.measures, sorted(step.starts)) for step in found]


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 12))
def test_distances_are_those_of_whole_measures_in_any_place(seed, count):
    measures = made_measures(np.random.default_rng(seed).integers(0, 4, count), seed)
    table = all_pairs(measures.pose, measures.pose, Metric(joint_weights(), window_weights(POSES, 0.0)))
    assert measure_distances(measures) == pytest.approx(np.minimum(table.distance, table.distance.T), abs=2e-4)


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 5), min_size=1, max_size=40), st.integers(0, 2**32 - 1))
def test_measures_of_one_kind_are_one_cluster(kinds, seed):
    """Numbered in order of their first appearance."""
    found = alike_measures(measure_distances(made_measures(kinds, seed)))
    first = list(dict.fromkeys(kinds))
    assert found.tolist() == [first.index(kind) for kind in kinds]


def test_a_basic_of_two_measures_is_one_step():
    assert steps_of(made_measures([0, 1, 0, 1, 2, 0, 1, 3])) == [(2, [0, 2, 5]), (1, [4]), (1, [7])]


def test_a_phrase_of_four_measures_is_one_step_and_no_longer_one():
    phrase = [0, 1, 2, 3]
    assert steps_of(made_measures([*phrase, 9, *phrase])) == [(4, [0, 5]), (1, [4])]
    long = [0, 1, 2, 3, 4, 5]
    assert all(length <= 4 for length, _ in steps_of(made_measures([*long, 9, *long])))


def test_a_measure_that_is_also_danced_elsewhere_stays_alone():
    """0 is followed by 1 three times of seven: they are two steps."""
    assert (1, [0, 2, 4, 6, 8, 10, 12]) in steps_of(made_measures([0, 1, 0, 2, 0, 1, 0, 3, 0, 4, 0, 5, 0, 1]))


def test_steps_do_not_go_from_one_recording_into_the_next():
    measures = made_measures([0, 1, 0, 1, 0, 1], recordings=range(6))
    assert steps_of(measures) == [(1, [0, 2, 4]), (1, [1, 3, 5])]
    measures = made_measures([0, 1, 0, 1, 0, 1], recordings=[0, 1, 1, 2, 2, 3])
    assert steps_of(measures) == [(1, [0, 2, 4]), (1, [1, 3, 5])]


def test_one_measure_five_hundred_times_is_one_step():
    ((step,),) = (find_steps(m, measure_distances(m)) for m in [made_measures([0] * 500, noise=0.02)])
    assert step.measures == 1
    assert sorted(step.starts) == list(range(500))
    assert 0.01 < step.spread_m < 0.06


def test_the_typical_occurrence_comes_first():
    """Of three, the one between the others."""
    measures = made_measures([0, 0, 0], noise=0.0)
    for n, shift in enumerate((0.0, 0.04, 0.08)):
        measures.pose[n, :, :8] += np.array((0.0, shift, 0.0))
    (step,) = find_steps(measures, measure_distances(measures))
    assert step.starts[0] == 1
