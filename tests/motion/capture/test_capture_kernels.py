"""Remembered poses are found, at the memory's ends too, and come back from what was held."""

import numpy as np
import pytest

from live.motion.capture.capture_kernels import BEAT, TIME, captured_hips
from tests.motion.capture.made_memory import asked, memory


@pytest.mark.parametrize(("size", "count"), [(4, 1), (4, 3), (4, 4), (4, 6), (4, 9)])
def test_every_remembered_moment_is_found_and_none_beyond(size, count):
    root, turned, stamp = memory(size, count)
    place = np.zeros((1, 4))
    for wanted in (-1.0, 0.0, count - 2.25, count - 1.0, count + 7.0):
        for key, scale in ((TIME, 1.0), (BEAT, 2.0)):
            row = asked(key=key, wanted=scale * wanted)
            captured_hips(place, row, root, turned, stamp, count, 1.0, False)
            assert place[0, 0] == pytest.approx(np.clip(wanted, max(count - size, 0), count - 1.0))


def test_a_pose_comes_back_from_the_one_that_was_held():
    root, turned, stamp = memory(4, 3)
    root[4] = -8.0, 0.9, 0.0
    place = np.zeros((1, 4))
    for caught, x in ((0.0, -8.0), (0.5, -3.0), (1.0, 2.0)):
        captured_hips(place, asked(wanted=2.0, caught=caught), root, turned, stamp, 3, 1.0, False)
        assert place[0, 0] == pytest.approx(x)
