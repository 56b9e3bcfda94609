"""Tests of live holds: closed and opened smoothly, one at a time, only within reach, reproducibly."""

import pickle

import numpy as np
import pytest

from live.motion.partner_live.hand_holds import NOBODY, HoldRequest, LiveHandHolds
from live.motion.pose.hand_hold import LEFT, RIGHT
from tests.motion.pose.test_arms import facing

TICK = 1.0 / 64.0
ALL = np.ones(2)


def hold_requests(left: int = NOBODY, right: int = NOBODY, amount: float = 1.0) -> list[HoldRequest]:
    return [HoldRequest(0, 1, (left, right), amount)]


class FacingPair:
    """Poses of two dancers facing each other at a distance [m], the leader raised by `higher` [m]."""

    def __init__(self, distance: float = 0.3, higher: float = 0.0) -> None:
        self.poses = facing(distance)
        self.poses[0][0, :, 1] += np.float32(higher)

    def __call__(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.poses[0][rows], self.poses[1][rows]


def run_holds(holding: LiveHandHolds, wanted: list[HoldRequest], see: FacingPair, seconds: float) -> np.ndarray:
    """How far both holds of dancer 1 are closed at each tick, (ticks, 2)."""
    closed = []
    for _ in range(round(seconds / TICK)):
        holding.tick(wanted, see, TICK)
        closed.append(holding.closed[0, 1].copy())
    return np.array(closed)


def test_hold_closes_and_opens_smoothly_and_is_removed() -> None:
    holding, see = LiveHandHolds(2), FacingPair()
    way = np.concatenate(
        [run_holds(holding, hold_requests(right=LEFT), see, 1.0), run_holds(holding, hold_requests(), see, 1.5)]
    )
    assert way[:, 0].max() == 0.0
    assert way[60, 1] > 0.98
    assert holding.held_count == 0
    assert way[-1, 1] == 0.0
    assert np.abs(np.diff(way[:, 1], n=2)).max() < 0.05  # the rest is cut off at OPEN, within the easing
    assert np.diff(way[:60, 1]).min() >= 0.0
    before = see.poses[0].copy(), see.poses[1].copy()
    holding.apply(*see.poses, ALL, 0.0)
    assert all(np.array_equal(was, now) for was, now in zip(before, see.poses, strict=True))


def test_hand_opens_before_holding_other_hand() -> None:
    holding, see = LiveHandHolds(2), FacingPair(0.3, 0.3)
    run_holds(holding, hold_requests(right=LEFT), see, 1.0)
    history = []
    for _ in range(96):
        holding.tick(hold_requests(right=RIGHT), see, TICK)
        history.append((int(holding.hand[1, 1]), float(holding.closed[0, 1, 1])))
    over = next(n for n, (hand, _) in enumerate(history) if hand == RIGHT)
    assert history[over - 1][1] < 0.05
    assert history[-1][1] > 0.95


def test_hold_out_of_reach_is_counted_once_and_closes_when_near() -> None:
    holding, far, near = LiveHandHolds(2), FacingPair(1.4), FacingPair()
    assert run_holds(holding, hold_requests(RIGHT, LEFT), far, 1.0).max() == 0.0
    assert holding.missed_count == 2  # both hands
    assert run_holds(holding, hold_requests(RIGHT, LEFT), near, 1.0)[-1].min() > 0.95
    assert run_holds(holding, hold_requests(RIGHT, LEFT), far, 2.5)[-1].max() == 0.0
    assert holding.missed_count == 4
    run_holds(holding, hold_requests(), far, 1.0)
    assert holding.statistics() == {"held": 0, "out_of_reach": 4}


@pytest.mark.parametrize(("aside", "higher"), [(-0.1, 0.4), (-0.1, 0.5), (0.0, 0.5), (0.2, 0.5)])
def test_hand_passing_shoulder_is_released_smoothly(aside: float, higher: float) -> None:
    """The leader passes beside or through the follower at 1.5 m/s: no joint jerks as an arm that turns over would."""
    holding, see = LiveHandHolds(2), FacingPair(higher=higher)
    see.poses[0][0, :, 0] += np.float32(aside)
    run_holds(holding, hold_requests(RIGHT, LEFT), see, 1.5)
    ways = []
    for _ in range(64):
        see.poses[0][0, :, 2] += np.float32(1.5 * TICK)
        holding.tick(hold_requests(RIGHT, LEFT), see, TICK)
        position, rotation = (one.copy() for one in see.poses)
        holding.apply(position, rotation, ALL, 0.0)
        ways.append(position[1])
    way = np.array(ways)
    assert np.abs(way[0] - way[-1]).max() > 0.1
    assert np.array_equal(way[-1], see.poses[0][1])
    kinks = np.linalg.norm(np.diff(way, n=2, axis=0), axis=-1) / TICK
    assert kinks.max() < 1.5  # [m/s] from tick to tick, as at the leader's start; an arm that turns over has 3 to 18


def test_hold_amount_changes_smoothly_and_zero_keeps_pose() -> None:
    holding, see = LiveHandHolds(2), FacingPair()
    run_holds(holding, hold_requests(right=LEFT), see, 1.5)
    gaps = []
    for _ in range(64):
        holding.tick(hold_requests(right=LEFT, amount=0.0), see, TICK)
        position, rotation = (one.copy() for one in see.poses)
        holding.apply(position, rotation, ALL, 0.0)
        gaps.append(float(np.abs(position - see.poses[0]).max()))
    assert gaps[0] > 0.1
    assert gaps[-1] < 0.02 * gaps[0]
    assert max(-np.diff(gaps)) < 0.08 * gaps[0]
    again = LiveHandHolds(2)
    run_holds(again, hold_requests(right=LEFT, amount=0.0), see, 1.0)
    position, rotation = (one.copy() for one in see.poses)
    again.apply(position, rotation, ALL, 0.0)
    assert np.array_equal(position, see.poses[0])


def test_pickled_holds_continue_identically_and_apply_keeps_state() -> None:
    one, see = LiveHandHolds(2), FacingPair()
    run_holds(one, hold_requests(RIGHT, LEFT), see, 0.2)
    data = pickle.dumps(one)
    other = pickle.loads(data)
    one.apply(*(each.copy() for each in see.poses), ALL, 0.005)
    assert pickle.dumps(one) == data
    assert np.array_equal(
        run_holds(one, hold_requests(RIGHT, LEFT), see, 0.3), run_holds(other, hold_requests(RIGHT, LEFT), see, 0.3)
    )


def test_hands_are_extrapolated_between_ticks() -> None:
    holding, see = LiveHandHolds(2), FacingPair()
    run_holds(holding, hold_requests(right=LEFT), see, 0.15)
    late, later = (tuple(one.copy() for one in see.poses) for _ in range(2))
    holding.apply(*late, ALL, TICK)
    holding.tick(hold_requests(right=LEFT), see, TICK)
    holding.apply(*later, ALL, 0.0)
    assert np.abs(late[0] - later[0]).max() < 0.01
