"""Tests of the response path: fade over a measure, pull speed limit and seek of distant followers."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.show.partner.partner_pairs import Pair, PartnerSettings
from live.show.partner.response_path import MAX_PULL_SPEED, MAX_SEEK_MEASURES, MIN_SEEK_DISTANCE, ResponsePath

DT = 1.0 / 60.0
ASKED = PartnerSettings("duet", "1", "2")
LEADER, FOLLOWER = 0, 1


def move_one_tick(along, x, *, wanted=True, measures=0.0, own_place=False, asked=ASKED, hips=None):
    """One tick with the answer at x m; `hips` (2, 2), initially at the origin, are displaced."""
    read = SimpleNamespace(
        root=np.array([[x, 0.9, 0.0]] * 3, np.float32), frames_since=lambda danced: 0.0, has_answer=True, held=False
    )
    hips = np.zeros((2, 2), np.float32) if hips is None else hips
    along.begin_tick()
    along.move_follower(
        Pair(0, LEADER, FOLLOWER, own_place), asked, read, wanted=wanted, danced_beats=0.0, measures=measures,
        hips=hips, agents=hips, dt=DT,
    )  # fmt: skip
    hips += along.displacement.astype(np.float32)


def test_answer_fades_in_and_out_over_one_measure():
    along, levels = ResponsePath(2), []
    for wanted in (True, False):
        for _ in range(8):
            move_one_tick(along, 0.0, wanted=wanted, measures=0.125)
            levels.append(along.level[FOLLOWER])
    np.testing.assert_array_equal(levels, [*np.arange(1, 9) / 8, *np.arange(7, -1, -1) / 8])
    assert not along.following.any()
    assert not along.leading.any()


def test_answer_weight_follows_fader_and_leader_is_marked():
    along = ResponsePath(2)
    move_one_tick(along, 0.0, wanted=False)
    nothing = PartnerSettings("duet", "1", "2", amount=0.0)
    for _ in range(600):
        move_one_tick(along, 0.0, measures=0.25)
    assert along.weight[FOLLOWER] == pytest.approx(1.0)
    assert along.following.tolist() == [False, True]
    assert along.leading.tolist() == [True, False]
    for _ in range(9):  # a half-life of the way
        move_one_tick(along, 0.0, asked=nothing)
    assert along.weight[FOLLOWER] == pytest.approx(0.5)


@pytest.mark.parametrize("own_place", [False, True])
def test_follower_is_pulled_within_speed_limit_unless_at_own_place(own_place):
    along, hips, moved = ResponsePath(2), np.zeros((2, 2), np.float32), []
    for _ in range(600):
        move_one_tick(along, 0.8 * MIN_SEEK_DISTANCE, measures=0.25, own_place=own_place, hips=hips)
        moved.append(np.hypot(*along.displacement[FOLLOWER]))
    assert max(moved) <= (0.0 if own_place else MAX_PULL_SPEED * DT + 1e-9)
    np.testing.assert_allclose(hips[FOLLOWER], [0.0 if own_place else 0.8 * MIN_SEEK_DISTANCE, 0.0], atol=1e-3)
    np.testing.assert_array_equal(hips[LEADER], 0.0)


def test_distant_follower_seeks_goal_before_answer_until_timeout():
    along, waited = ResponsePath(2), 0
    move_one_tick(along, 2.0 * MIN_SEEK_DISTANCE, measures=0.25)
    while along.seeking[FOLLOWER]:
        waited += 1
        assert along.level[FOLLOWER] == 0.0
        np.testing.assert_allclose(along.goal[FOLLOWER], [2.0 * MIN_SEEK_DISTANCE, 0.0], atol=1e-6)
        move_one_tick(along, 2.0 * MIN_SEEK_DISTANCE, measures=0.25)
    assert waited == MAX_SEEK_MEASURES / 0.25
    assert along.level[FOLLOWER] == 0.25
