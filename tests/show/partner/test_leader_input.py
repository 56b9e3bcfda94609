"""Where an answer is between the frames of its leader, and how long it goes on without one."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.show.partner.leader_input import MAX_EXTRAPOLATION, answer_position, frames_since


def read(since):
    """A leader `since` frames after her latest one, whose answer goes 1 m along x in half a frame, then 2 m."""
    root = np.array([[0.0, 0.9, 4.0], [1.0, 0.9, 4.0], [3.0, 0.9, 4.0]], np.float32)
    return SimpleNamespace(root=root, frames_since=lambda danced: since)


@pytest.mark.parametrize(
    ("since", "x"), [(-1.0, 0.0), (0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.75, 2.0), (1.0, 3.0), (1.5, 5.0)]
)
def test_an_answer_is_on_the_lines_between_what_was_made_for_its_frame(since, x):
    np.testing.assert_allclose(answer_position(read(since), 0.0), [x, 4.0], atol=1e-6)


def test_an_answer_stops_some_time_after_its_latest_frame():
    assert frames_since(read(9.0), 0.0) == MAX_EXTRAPOLATION
    np.testing.assert_array_equal(answer_position(read(9.0), 0.0), answer_position(read(MAX_EXTRAPOLATION), 0.0))
