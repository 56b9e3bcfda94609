"""Fair attraction: majorities win, one alone captures nobody, and nobody trembles between two places."""

import numpy as np
import pytest

from live.agents.elements.element import Element
from live.agents.elements.element_kinds import ATTRACTOR
from tests.agents.elements.made_stage import MadeStage


def voices(x, z, count, groups=(1 << 64) - 1):
    """`count` phones at one place, a hand's breadth apart."""
    places = ((x + 0.05 * (k % 5), z + 0.05 * (k // 5 % 5)) for k in range(count))
    return [Element(ATTRACTOR, (place,), fair=True, groups=groups) for place in places]


def test_without_voices_nobody_moves():
    assert (MadeStage([[0, 0], [3, 1]]).wish() == 0.0).all()


def test_a_hundred_phones_beat_one_even_beside_it():
    stage = MadeStage([[5.0, 0.0], [-5.0, 0.0], [0.0, 3.0]], *voices(-5.0, 0.0, 100), *voices(5.2, 0.0, 1))
    wish = stage.wish()
    assert wish[0, 0] < -0.9  # although one phone lies 20 cm from her
    assert wish[2, 0] < -0.5


def test_one_far_phone_moves_nobody_noticeably():
    stage = MadeStage([[-1.0, 0.0], [1.0, 2.0]], *voices(0.0, 0.0, 20))
    alone = stage.wish()
    stage.field.add(voices(6.0, 4.0, 1)[0])
    assert stage.wish() == pytest.approx(alone, abs=0.02)


def test_where_two_places_have_as_many_the_nearer_one_wins_and_the_wish_is_smooth():
    x = np.linspace(-5.0, 5.0, 201)
    stage = MadeStage(np.stack([x, 0 * x], 1), *voices(-4.0, 0.0, 30), *voices(4.0, 0.0, 30))
    wish = stage.wish()[:, 0]
    assert wish[70] < -0.4  # at -1.5 m
    assert wish[130] > 0.4
    assert np.abs(np.diff(wish)).max() < 0.08


def test_a_lone_phone_pulls_a_quarter_and_four_pull_fully():
    one = MadeStage([[0, 0]], *voices(4.0, 0.0, 1)).wish()[0, 0]
    four = MadeStage([[0, 0]], *voices(4.0, 0.0, 4)).wish()[0, 0]
    assert four == pytest.approx(1.0 - np.exp(-4.0 / 1.2), abs=0.01)
    assert one == pytest.approx(four / 4.0, abs=0.01)


def test_the_order_of_the_phones_does_not_matter():
    chance = np.random.default_rng(4)
    places = chance.normal(size=(60, 2)) * [3.0, 2.0]
    elements = [Element(ATTRACTOR, (tuple(p),), fair=True) for p in places]
    agents = chance.uniform(-5, 5, (20, 2))
    wish = MadeStage(agents, *elements).wish()
    assert MadeStage(agents, *reversed(elements)).wish() == pytest.approx(wish, abs=1e-4)


def test_audiences_of_different_groups_do_not_outvote_each_other():
    stage = MadeStage(
        [[0.0, 0.0], [0.0, 1.0]], *voices(-5.0, 0.0, 100, groups=1), *voices(5.0, 0.0, 5, groups=2), groups=[1, 2]
    )
    wish = stage.wish()
    assert wish[0, 0] < -0.8
    assert wish[1, 0] > 0.8


def test_a_crowd_goes_where_most_of_the_audience_points():
    chance = np.random.default_rng(2)
    start = chance.uniform([-5, -3], [5, 3], (12, 2))
    stage = MadeStage(start, *voices(3.5, 1.5, 40), *voices(-3.5, -2.0, 12), separation=0.7)
    end = stage.run(9.0)[-1]
    assert (np.hypot(*(end - (3.5, 1.5)).T) < 2.2).sum() >= 9
