"""Paths drawn live (H019): limits of length, progress of the dancers, offsets, waiting at the end."""

import numpy as np

from live.show.selection.drawn_paths import ARRIVED, MOST_POINTS, REACHED, WAIT_BEATS, DrawnPath


class Walk:
    """Three dancers, of whom the first two walk along a path."""

    def __init__(self):
        self.place = np.array([[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]], np.float32)
        self.seeks, self.goal = np.zeros(3, np.bool_), np.zeros((3, 2))
        self.path = DrawnPath([0, 1], self.place)

    def tick(self, beats=0.5):
        """Advance the path; return whether it goes on."""
        return self.path.tick(self.place, self.seeks, self.goal, beats)


def test_path_without_points_moves_no_dancer():
    walk = Walk()
    assert walk.tick(100.0)
    assert not walk.seeks.any()


def test_dancers_keep_their_offsets_from_the_middle():
    walk = Walk()
    walk.path.add((3.0, 2.0))
    assert walk.tick()
    assert walk.seeks.tolist() == [True, True, False]
    np.testing.assert_allclose(walk.goal[:2], [[2.5, 2.0], [3.5, 2.0]])
    np.testing.assert_array_equal(walk.goal[2], 0.0)


def test_next_point_is_the_goal_once_a_point_is_reached():
    walk = Walk()
    walk.path.add((0.5, 1.0))
    walk.path.add((0.5, 3.0))
    walk.place[0] = (0.0, 1.0 - 1.1 * REACHED)
    walk.tick()
    assert walk.goal[0].tolist() == [0.0, 1.0]
    walk.place[0] = (0.0, 1.0 - 0.9 * REACHED)
    walk.tick()
    assert walk.goal[0].tolist() == [0.0, 3.0]
    assert walk.goal[1].tolist() == [1.0, 1.0]


def test_full_path_drops_its_oldest_points():
    walk = Walk()
    for n in range(MOST_POINTS + 3):
        walk.path.add((0.5, float(n)))
    walk.tick()
    assert walk.goal[0].tolist() == [0.0, 3.0]


def test_dropped_points_move_no_dancer_back_or_ahead():
    walk = Walk()
    for n in range(MOST_POINTS):
        walk.path.add((0.5, float(n)))
    for _ in range(12):
        walk.tick()
        walk.place[:2, 1] = walk.goal[:2, 1]
    walk.tick()
    reached = walk.goal[0, 1]
    assert reached == 13.0
    walk.place[:2, 1] = reached - 1.1 * REACHED
    walk.path.add((0.5, float(MOST_POINTS)))
    walk.tick()
    assert walk.goal[0, 1] == reached


def test_path_ends_after_all_dancers_waited_at_its_end():
    walk = Walk()
    walk.path.add((0.5, 1.0))
    walk.place[:2] = [(0.0, 1.0), (1.0, 1.0 - 1.1 * ARRIVED)]
    assert all(walk.tick(1.0) for _ in range(20))
    walk.place[1] = (1.0, 1.0)
    ticks = [walk.tick(1.0) for _ in range(int(WAIT_BEATS))]
    assert all(ticks[:-1])
    assert not ticks[-1]


def test_new_point_starts_the_wait_again():
    walk = Walk()
    walk.path.add((0.5, 0.0))
    assert walk.tick(WAIT_BEATS - 1.0)
    walk.path.add((0.5, 0.0))
    assert walk.tick(WAIT_BEATS - 1.0)
    assert not walk.tick(1.0)
