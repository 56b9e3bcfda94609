"""What the search compares besides the leader now: what the leader did before and after, and where a learnt follower is
expected."""

from dataclasses import replace

import numpy as np

from live.motion.clip import Clip
from live.motion.partner.partner_synthesis import SearchSettings, StageTimer, decode_input, find_partner, no_clock
from live.motion.partner.point_clouds import Cloud, ends_cloud, leader_cloud
from live.motion.partner.units import Example, Units, cut_units
from tests.motion.partner.test_answer import RATE, random_dance_clip, transform_clip

UNIT = 42
"""Samples of a unit."""
ALONE = SearchSettings(rate=RATE / 6.0, stretch=0.0, k=0.0, context=(), free_ends=False)
"""Units that fit best alone, whatever came before."""


def _joined(name: str, seeds: tuple[int, ...]) -> Clip:
    parts = [random_dance_clip(seed, UNIT + (n == len(seeds) - 1)) for n, seed in enumerate(seeds)]
    return Clip(
        name, np.concatenate([one.root_position for one in parts]), np.concatenate([one.rotation for one in parts]),
        RATE, np.concatenate([one.contact for one in parts]),
    )  # fmt: skip


def _example(leader: Clip, side: float) -> Example:
    follower = transform_clip(leader, 0.0, side, 0.0)
    cuts = np.arange(0.0, leader.sample_count, UNIT)
    return Example("pair", ends_cloud(leader), ends_cloud(follower), follower, cuts, cuts)


def _danced(x: Cloud, units: Units, search: SearchSettings) -> list[int]:
    _, reading = decode_input(x, units, search, StageTimer(no_clock))
    return [int(units.example[unit]) for unit in reading.unit]


def test_what_the_leader_did_before_tells_units_apart_that_are_the_same_now() -> None:
    leaders = [_joined("leader", (1, 5, 6, 3)), _joined("leader", (2, 5, 6, 4))]
    units = cut_units([_example(leader, side) for leader, side in zip(leaders, (-1.0, 1.0), strict=True)])
    x = ends_cloud(leaders[1])
    assert _danced(x, units, ALONE) == [1, 0, 1, 1]  # the second units are the same, so the first of them is taken
    for context in ((0.4,), (-1.2,), (0.5, 1.5, -0.5)):
        assert _danced(x, units, replace(ALONE, context=context)) == [1, 1, 1, 1]


def test_context_of_a_leader_who_dances_as_recorded_changes_nothing() -> None:
    leader = random_dance_clip(11, 10 * UNIT + 1)
    units = cut_units([_example(leader, 1.0)])
    for context in ((), (0.5, 1.5, -0.5)):
        search = SearchSettings(context=context, free_ends=False)
        _, reading = decode_input(ends_cloud(leader), units, search, StageTimer(no_clock))
        assert reading.unit.tolist() == list(range(10))
        assert reading.distance.sum() < 1e-9


def test_an_expected_follower_decides_between_followers_of_the_same_leader() -> None:
    leader = random_dance_clip(7, 6 * UNIT + 1)
    units = cut_units([_example(leader, side) for side in (-1.0, 1.0)])
    x, search = ends_cloud(leader), SearchSettings(free_ends=False, hold_feet=False)
    for side, example in ((1.5, 1), (-1.5, 0)):
        expected = leader_cloud(transform_clip(leader, 0.0, side, 0.0))
        found = find_partner(leader, x, units, search, expected=expected)
        assert set(_of(units, found.reading.unit)) == {example}


def _of(units: Units, which: np.ndarray) -> list[int]:
    return [int(units.example[unit]) for unit in which]
