"""An answer comes in over a measure and takes its dancer to it, no faster than said; who is far goes there first."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.show.partner.partner_pairs import Pair, PartnerSettings
from live.show.partner.response_path import MAX_PULL_SPEED, MAX_SEEK_MEASURES, MIN_SEEK_DISTANCE, ResponsePath

DT = 1.0 / 60.0
ASKED = PartnerSettings("duet", "1", "2")
LEADER, FOLLOWER = 0, 1


def go(along, x, *, wanted=True, measures=0.0, own_place=False, asked=ASKED, hips=None):
    """A tick in which the answer rests at x m; `hips` (2, 2), at the origin at first, are taken along."""
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


def test_an_answer_comes_in_over_a_measure_and_goes_out_over_one():
    along, levels = ResponsePath(2), []
    for wanted in (True, False):
        for _ in range(8):
            go(along, 0.0, wanted=wanted, measures=0.125)
            levels.append(along.level[FOLLOWER])
    np.testing.assert_array_equal(levels, [*np.arange(1, 9) / 8, *np.arange(7, -1, -1) / 8])
    assert not along.following.any()
    assert not along.leading.any()


def test_who_answers_is_shown_as_much_of_it_as_the_fader_says_and_her_leader_leads():
    along = ResponsePath(2)
    go(along, 0.0, wanted=False)
    nothing = PartnerSettings("duet", "1", "2", amount=0.0)
    for _ in range(600):
        go(along, 0.0, measures=0.25)
    assert along.weight[FOLLOWER] == pytest.approx(1.0)
    assert along.following.tolist() == [False, True]
    assert along.leading.tolist() == [True, False]
    for _ in range(9):  # a half-life of the way
        go(along, 0.0, asked=nothing)
    assert along.weight[FOLLOWER] == pytest.approx(0.5)


@pytest.mark.parametrize("own_place", [False, True])
def test_she_is_brought_to_her_place_no_faster_than_said_and_not_at_all_on_her_own(own_place):
    along, hips, moved = ResponsePath(2), np.zeros((2, 2), np.float32), []
    for _ in range(600):
        go(along, 0.8 * MIN_SEEK_DISTANCE, measures=0.25, own_place=own_place, hips=hips)
        moved.append(np.hypot(*along.displacement[FOLLOWER]))
    assert max(moved) <= (0.0 if own_place else MAX_PULL_SPEED * DT + 1e-9)
    np.testing.assert_allclose(hips[FOLLOWER], [0.0 if own_place else 0.8 * MIN_SEEK_DISTANCE, 0.0], atol=1e-3)
    np.testing.assert_array_equal(hips[LEADER], 0.0)


def test_who_is_far_goes_there_first_until_patience_ends():
    along, waited = ResponsePath(2), 0
    go(along, 2.0 * MIN_SEEK_DISTANCE, measures=0.25)
    while along.seeking[FOLLOWER]:
        waited += 1
        assert along.level[FOLLOWER] == 0.0
        np.testing.assert_allclose(along.goal[FOLLOWER], [2.0 * MIN_SEEK_DISTANCE, 0.0], atol=1e-6)
        go(along, 2.0 * MIN_SEEK_DISTANCE, measures=0.25)
    assert waited == MAX_SEEK_MEASURES / 0.25
    assert along.level[FOLLOWER] == 0.25
