"""Fair attraction: majorities win, one phone captures no dancer, and velocity varies smoothly between places."""

import numpy as np
import pytest

from live.agents.elements.element import Element
from live.base.element_kinds import ATTRACTOR
from tests.agents.elements.made_stage import StageHarness


def phone_attractors(x, z, count, groups=(1 << 64) - 1):
    """`count` phones at one place, 5 cm apart."""
    places = ((x + 0.05 * (k % 5), z + 0.05 * (k // 5 % 5)) for k in range(count))
    return [Element(ATTRACTOR, (place,), fair=True, groups=groups) for place in places]


def test_agents_without_phones_stay_still():
    assert (StageHarness([[0, 0], [3, 1]]).wish() == 0.0).all()


def test_hundred_phones_outweigh_one_near_phone():
    stage = StageHarness(
        [[5.0, 0.0], [-5.0, 0.0], [0.0, 3.0]], *phone_attractors(-5.0, 0.0, 100), *phone_attractors(5.2, 0.0, 1)
    )
    wish = stage.wish()
    assert wish[0, 0] < -0.9  # although one phone lies 20 cm from the agent
    assert wish[2, 0] < -0.5


def test_one_far_phone_has_negligible_effect():
    stage = StageHarness([[-1.0, 0.0], [1.0, 2.0]], *phone_attractors(0.0, 0.0, 20))
    alone = stage.wish()
    stage.field.add(phone_attractors(6.0, 4.0, 1)[0])
    assert stage.wish() == pytest.approx(alone, abs=0.02)


def test_nearer_of_two_equal_places_wins_smoothly():
    x = np.linspace(-5.0, 5.0, 201)
    stage = StageHarness(np.stack([x, 0 * x], 1), *phone_attractors(-4.0, 0.0, 30), *phone_attractors(4.0, 0.0, 30))
    wish = stage.wish()[:, 0]
    assert wish[70] < -0.4  # at -1.5 m
    assert wish[130] > 0.4
    assert np.abs(np.diff(wish)).max() < 0.08


def test_one_phone_pulls_a_quarter_of_four():
    one = StageHarness([[0, 0]], *phone_attractors(4.0, 0.0, 1)).wish()[0, 0]
    four = StageHarness([[0, 0]], *phone_attractors(4.0, 0.0, 4)).wish()[0, 0]
    assert four == pytest.approx(1.0 - np.exp(-4.0 / 1.2), abs=0.01)
    assert one == pytest.approx(four / 4.0, abs=0.01)


def test_attraction_is_independent_of_phone_order():
    chance = np.random.default_rng(4)
    places = chance.normal(size=(60, 2)) * [3.0, 2.0]
    elements = [Element(ATTRACTOR, (tuple(p),), fair=True) for p in places]
    agents = chance.uniform(-5, 5, (20, 2))
    wish = StageHarness(agents, *elements).wish()
    assert StageHarness(agents, *reversed(elements)).wish() == pytest.approx(wish, abs=1e-4)


def test_phones_of_different_groups_are_weighed_separately():
    stage = StageHarness(
        [[0.0, 0.0], [0.0, 1.0]],
        *phone_attractors(-5.0, 0.0, 100, groups=1),
        *phone_attractors(5.0, 0.0, 5, groups=2),
        groups=[1, 2],
    )
    wish = stage.wish()
    assert wish[0, 0] < -0.8
    assert wish[1, 0] > 0.8


def test_crowd_moves_to_the_majority_of_phones():
    chance = np.random.default_rng(2)
    start = chance.uniform([-5, -3], [5, 3], (12, 2))
    stage = StageHarness(start, *phone_attractors(3.5, 1.5, 40), *phone_attractors(-3.5, -2.0, 12), separation=0.7)
    end = stage.run(9.0)[-1]
    assert (np.hypot(*(end - (3.5, 1.5)).T) < 2.2).sum() >= 9
