"""Tests of capture kernels: lookup of stored poses, also at the ends of memory, and blending from a held pose."""

import numpy as np
import pytest

from live.motion.capture.capture_kernels import BEAT, TIME, captured_hips
from tests.motion.capture.made_memory import make_memory, request_row


@pytest.mark.parametrize(("size", "count"), [(4, 1), (4, 3), (4, 4), (4, 6), (4, 9)])
def test_stored_poses_are_found_and_times_are_clamped(size, count):
    root, turned, stamp = make_memory(size, count)
    place = np.zeros((1, 4))
    for wanted in (-1.0, 0.0, count - 2.25, count - 1.0, count + 7.0):
        for key, scale in ((TIME, 1.0), (BEAT, 2.0)):
            row = request_row(key=key, wanted=scale * wanted)
            captured_hips(place, row, root, turned, stamp, count, 1.0, False)
            assert place[0, 0] == pytest.approx(np.clip(wanted, max(count - size, 0), count - 1.0))


def test_pose_is_blended_from_held_pose():
    root, turned, stamp = make_memory(4, 3)
    root[4] = -8.0, 0.9, 0.0
    place = np.zeros((1, 4))
    for caught, x in ((0.0, -8.0), (0.5, -3.0), (1.0, 2.0)):
        captured_hips(place, request_row(wanted=2.0, caught=caught), root, turned, stamp, 3, 1.0, False)
        assert place[0, 0] == pytest.approx(x)
