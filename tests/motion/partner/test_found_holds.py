"""Tests of hold detection: palms near each other for long enough, each hand in one hold at a time."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from live.motion.clip import Clip
from live.motion.partner.answer import palms
from live.motion.partner.evaluation import RELEASE_FACTOR, HoldCriterion, detect_holds
from tests.motion.partner.made_examples import standing

RATE = 60.0


def side_by_side_pair(gap: np.ndarray) -> tuple[Clip, Clip]:
    """T-pose clips with the same heading; the leader's left palm is `gap` (T,) [m] from the follower's right one."""
    leader = standing(len(gap), RATE)
    span = float(np.linalg.norm(palms(leader)[0, 0] - palms(leader)[0, 1]))
    return leader, translate_clip(leader, np.stack((span + gap, np.zeros(len(gap))), axis=1))


def translate_clip(clip: Clip, way: np.ndarray) -> Clip:
    """The clip moved over the floor by `way` (T, 2) [m]."""
    root = clip.root_position.copy()
    root[:, ::2] += way.astype(np.float32)
    return replace(clip, root_position=root)


def test_hold_begins_at_distance_and_ends_at_release_distance() -> None:
    gap = np.concatenate((np.linspace(0.5, 0.0, 101), np.linspace(0.0, 0.5, 101)[1:]))
    found = detect_holds(*side_by_side_pair(gap), HoldCriterion(0.1, 0.4))
    (one,) = found
    assert (one.leader_hand, one.follower_hand) == (0, 1)
    assert one.begin == pytest.approx(80.0, abs=1.0)  # rounding decides at the exact distance
    assert one.end == pytest.approx(100.0 + 100.0 * 0.1 * RELEASE_FACTOR / 0.5, abs=1.0)


def test_short_or_distant_contact_is_not_a_hold() -> None:
    gap = np.full(240, 0.5)
    gap[60:80] = 0.05
    gap[120:150] = 0.12  # near enough to continue, not to begin
    assert detect_holds(*side_by_side_pair(gap), HoldCriterion(0.1, 0.4)) == ()
    assert [(one.begin, one.end) for one in detect_holds(*side_by_side_pair(gap), HoldCriterion(0.1, 0.3))] == [
        (60.0, 79.0)
    ]
    gap[80:120] = 0.05
    assert [(one.begin, one.end) for one in detect_holds(*side_by_side_pair(gap), HoldCriterion(0.1, 0.4))] == [
        (60.0, 149.0)
    ]


@pytest.mark.parametrize("seed", range(5))
def test_each_hand_is_in_one_hold_at_a_time(seed: int) -> None:
    chance = np.random.default_rng(seed)
    ways = np.tanh(np.cumsum(chance.normal(0.0, 0.05, (2, 400, 2)), axis=1))
    leader, follower = (translate_clip(standing(400, RATE), 0.8 * way) for way in ways)
    found = detect_holds(leader, follower, HoldCriterion(0.6, 0.05))
    assert len(found) > 1
    for hand in ("leader_hand", "follower_hand"):
        for side in range(2):
            own = sorted((one.begin, one.end) for one in found if getattr(one, hand) == side)
            assert all(before[1] < after[0] for before, after in pairwise(own))
