"""Who wears a captured pose wholly stands where it stands, with her agent and all that is planned of her."""

import numpy as np

from live.motion.capture.capture_blend_kernels import find_positions, move_agents, translate_plans
from tests.motion.capture.made_memory import asked, memory


def test_places_agents_and_what_is_planned_go_along_with_who_is_wholly_captured():
    root, turned, stamp = memory(4, 3)
    rows, dancers = np.array([1, 2]), 3
    shown = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 4.0]], np.float32)
    legs = np.zeros((dancers, 9, 4), np.float32)
    legs[..., 0] = 1.0
    row = np.concatenate([asked(wanted=2.0, share=1.0), asked(wanted=1.0, share=0.5)])
    there, way, away = np.empty((2, 2)), np.empty((2, 2)), np.array([9.0, 0.0])
    live = np.array([True, False])
    find_positions(there, way, away, rows, live, row, root, turned, stamp, 3, 1.0, False, shown, legs)
    np.testing.assert_allclose(there, [[2.0, 0.0], [0.5, 2.0]])
    np.testing.assert_allclose(way, [[1.0, -1.0], [0.0, 0.0]])
    np.testing.assert_allclose(away, 0.0, atol=1e-6)
    flat, place, speed = np.ones(8 * dancers, np.float32), np.zeros((dancers, 2)), np.zeros((dancers, 2))
    led = np.array([False, True, True])
    move_agents(rows, live, there, place, speed, led, flat, 0.5, 2.0, 0.5)
    assert flat[:6].tolist() == [1.0, 1.0, 2.0, 0.0, 1.0, 1.0]
    assert flat[6:12].tolist() == [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]  # half of 4 m/s, of which 2 are believed
    assert flat[12:].tolist() == [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0]
    plans = [np.zeros((dancers, columns)) for columns in (3, 3, 3, 2, 2, 2)]
    paths, lock = [np.zeros((dancers, 5, 2), np.float32) for _ in range(2)], np.ones((dancers, 2, 12), np.float32)
    translate_plans(rows[:1], way[:1], *plans, *paths, shown, lock)
    assert shown.tolist() == [[0.0, 0.0], [2.0, 0.0], [0.0, 4.0]]
    for plan in (*plans, *(path[:, -1] for path in paths)):
        assert plan[:, :2].tolist() == [[0.0, 0.0], [1.0, -1.0], [0.0, 0.0]]
    assert lock.sum(axis=(1, 2)).tolist() == [24.0, 0.0, 24.0]
