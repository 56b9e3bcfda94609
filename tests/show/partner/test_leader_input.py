"""Tests of the answer position between frames of the leader, and of its extrapolation limit."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.show.partner.leader_input import MAX_EXTRAPOLATION, answer_position, frames_since


def make_leader(since):
    """A leader `since` frames after the latest one; the answer moves 1 m along x in half a frame, then 2 m."""
    root = np.array([[0.0, 0.9, 4.0], [1.0, 0.9, 4.0], [3.0, 0.9, 4.0]], np.float32)
    return SimpleNamespace(root=root, frames_since=lambda danced: since)


@pytest.mark.parametrize(
    ("since", "x"), [(-1.0, 0.0), (0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.75, 2.0), (1.0, 3.0), (1.5, 5.0)]
)
def test_answer_position_is_interpolated_linearly_between_samples(since, x):
    np.testing.assert_allclose(answer_position(make_leader(since), 0.0), [x, 4.0], atol=1e-6)


def test_answer_stops_at_maximum_extrapolation():
    assert frames_since(make_leader(9.0), 0.0) == MAX_EXTRAPOLATION
    np.testing.assert_array_equal(
        answer_position(make_leader(9.0), 0.0), answer_position(make_leader(MAX_EXTRAPOLATION), 0.0)
    )
