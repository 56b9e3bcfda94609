"""Headings along the path (T102, T126-T128)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents.evolutions import facing

ANGLES = st.floats(-30, 30)


def test_smoothed_turn_matches_thesis_figure_5_5():
    """Five measures facing the audience, then 80°: turns of 20°, 40°, 20° at measures 5, 6, 7."""
    headings = np.radians([0] * 5 + [80] * 5)
    turned = np.degrees(np.diff(facing.smoothed(headings)))  # entry k is the turn at measure k + 2
    assert turned == pytest.approx([0, 0, 0, 20, 40, 20, 0, 0, 0], abs=1e-9)


@given(st.lists(ANGLES, min_size=1, max_size=12))
def test_unwrapped_headings_keep_direction_without_jumps(headings):
    flat = facing.unwrap(headings)
    assert np.cos(flat) == pytest.approx(np.cos(headings), abs=1e-6)
    assert np.sin(flat) == pytest.approx(np.sin(headings), abs=1e-6)
    assert (np.abs(np.diff(flat)) <= np.pi + 1e-9).all()


@given(st.lists(ANGLES, min_size=2, max_size=12), ANGLES)
def test_smoothed_headings_stay_within_neighbors_and_rotate_equivariantly(headings, turn):
    flat = facing.unwrap(headings)
    smooth = facing.smoothed(headings)
    padded = np.concatenate([flat[:1], flat, flat[-1:]])
    around = np.stack([padded[:-2], padded[1:-1], padded[2:]])
    assert (smooth <= around.max(axis=0) + 1e-9).all()
    assert (smooth >= around.min(axis=0) - 1e-9).all()
    assert facing.smoothed(flat + turn) - (flat[0] + turn) == pytest.approx(smooth - flat[0], abs=1e-6)


@given(ANGLES, ANGLES)
def test_turn_takes_the_shorter_direction(before, after):
    turn = float(facing.shortest_turn(before, after))
    assert -np.pi - 1e-9 <= turn <= np.pi + 1e-9
    assert np.cos(before + turn) == pytest.approx(np.cos(after), abs=1e-6)
    knots = facing.linear_turns(np.array([[2.0, 6.0]]), [before], [after])
    assert knots[0, :, 0].tolist() == [2.0, 6.0]
    assert knots[0, 1, 1] == pytest.approx(before + turn)


def test_tangent_facing_turns_before_and_after_travel():
    ways = np.array([[[0, 0], [2, 0], [2, 2]]], np.float32)  # to the right, then towards the audience
    knots = facing.tangent_turns(ways, [0, 0.5, 1], np.array([[1.0, 9.0]]), 1.0, [0.0], [-0.5])
    beats, heading = knots[0].T
    assert beats[0] == 0.0
    assert beats[-1] == 10.0
    assert (np.diff(beats) >= 0).all()
    at = lambda beat: np.interp(beat, beats, heading)  # noqa: E731
    assert at(0.0) == 0.0
    assert at(1.0) == pytest.approx(np.pi / 2)
    assert at(3.0) == pytest.approx(np.pi / 2)
    assert at(7.0) == pytest.approx(0.0, abs=1e-9)
    assert at(10.0) == pytest.approx(-0.5)


def test_stationary_dancer_turns_evenly_and_pause_keeps_heading():
    ways = np.array([[[1, 1]] * 4, [[0, 0], [0, 0], [1, 0], [1, 0]]], np.float32)
    knots = facing.tangent_turns(ways, np.linspace(0, 1, 4), np.array([[0.0, 8.0]] * 2), 1.0, [0.0, 0.0], [1.0, 0.0])
    beats, heading = knots[0].T
    assert heading == pytest.approx((beats - beats[0]) / (beats[-1] - beats[0]), abs=1e-9)
    travelling = knots[1][facing.TURN_KNOTS : -facing.TURN_KNOTS, 1]
    assert travelling == pytest.approx(np.pi / 2)


def test_measure_headings_follow_travel_and_face_audience_at_rest():
    lines = np.array([[[0, 0]], [[1, 0]], [[1, 0.02]], [[1, -1]]], np.float32)
    assert facing.travel_headings(lines, [0.0]) == pytest.approx(np.array([[np.pi / 2, 0.0, np.pi]]))
    knots = facing.turns_by_measure(8.0, 4.0, [0.0], [[np.pi / 2, 0.0, np.pi]])
    assert knots[0, :, 0].tolist() == [8.0, 12.0, 16.0, 20.0]
    assert knots[0, :2, 1] == pytest.approx([0.0, np.pi / 2])
