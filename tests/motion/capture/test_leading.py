"""Tests of capture leading: position, agent and plans move with a fully captured dancer."""

import numpy as np

from live.motion.capture.capture_blend_kernels import find_positions, move_agents, translate_plans
from tests.motion.capture.made_memory import make_memory, request_row


def test_agents_and_plans_move_with_fully_captured_dancers():
    root, turned, stamp = make_memory(4, 3)
    rows, dancers = np.array([1, 2]), 3
    shown = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 4.0]], np.float32)
    legs = np.zeros((dancers, 9, 4), np.float32)
    legs[..., 0] = 1.0
    row = np.concatenate([request_row(wanted=2.0, share=1.0), request_row(wanted=1.0, share=0.5)])
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
    assert flat[6:12].tolist() == [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]  # half of 4 m/s, limited to 2
    assert flat[12:].tolist() == [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0]
    plans = [np.zeros((dancers, columns)) for columns in (3, 3, 3, 2, 2, 2)]
    paths, lock = [np.zeros((dancers, 5, 2), np.float32) for _ in range(2)], np.ones((dancers, 2, 12), np.float32)
    translate_plans(rows[:1], way[:1], *plans, *paths, shown, lock)
    assert shown.tolist() == [[0.0, 0.0], [2.0, 0.0], [0.0, 4.0]]
    for plan in (*plans, *(path[:, -1] for path in paths)):
        assert plan[:, :2].tolist() == [[0.0, 0.0], [1.0, -1.0], [0.0, 0.0]]
    assert lock.sum(axis=(1, 2)).tolist() == [24.0, 0.0, 24.0]
