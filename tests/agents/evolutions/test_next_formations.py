"""Formations that could come next: laws of their ranking, and what it costs."""

import time
from dataclasses import replace

import numpy as np
import pytest

from live.agents.evolutions.intention import Evolve, Places, Repertoire, Segment
from live.agents.evolutions.next_formations import Standing, busiest_share, rank_formations, rank_in_pieces
from live.agents.evolutions.running_plan import Plan
from live.agents.formations.formation import formation_of
from live.agents.formations.formation_notation import parse_formation
from live.agents.groups.roster import Roster

WORDS = ("line", "circle", "grid", "triangle", "star", "spiral", "arc", "rectangle", "polygon:7")
COUNT = 12


def places(words, count=COUNT, *, scale=1.0, at=(0.0, 0.0)):
    found = formation_of(parse_formation(words), count, 0)
    return Places(words, found.slots * scale + np.array(at), found.heading, found.marks)


def all_places(count=COUNT, scale=1.0):
    return [places(words, count, scale=scale) for words in WORDS]


def standing(position, *, groups=1, reach=1.5, **more):
    count = len(position)
    values = {
        "position": np.asarray(position, np.float64),
        "group": np.arange(count, dtype=np.int32) * groups // max(count, 1),
        "attributes": (frozenset(),) * count,
        "reach": np.full(count, reach),
        "radius": np.full(count, 0.25),
        "half_stage": (6.0, 4.0),
    }
    return Standing(**values | more)


def scattered(seed, count=COUNT):
    return np.random.default_rng(seed).uniform((-5.5, -3.5), (5.5, 3.5), (count, 2))


def names(ranked):
    return [one.formation for one in ranked]


@pytest.mark.parametrize("words", WORDS)
def test_formation_in_which_dancers_nearly_stand_already_comes_first(words):
    here = places(words).slots + np.random.default_rng(5).uniform(-0.1, 0.1, (COUNT, 2))
    for groups in (1, 3):
        ranked = rank_formations(standing(here, groups=groups), all_places())
        assert ranked[0].formation == words
        assert ranked[0].measures == 1
        assert ranked[0].longest_m < 0.15
        assert ranked[0].cost < 0.5 * ranked[1].cost


def test_formation_out_of_reach_is_never_suggested():
    """However good: a dancer who cannot get there in time rules it out; with more time it is there again."""
    here = places("line").slots - np.array([0.0, 3.5])
    line = places("line")
    for measures in (1, 2, 3, 4, 6):
        for reach in (0.3, 0.8, 1.5):
            state = standing(here, reach=reach, measures=measures)
            way = 3.5
            reachable = way * busiest_share(measures) <= reach
            assert ("line" in names(rank_formations(state, [line]))) == reachable
    slow = standing(here, reach=1.5)
    slow.reach[3] = 0.05
    assert rank_formations(slow, [line]) == ()


@pytest.mark.long
def test_measures_are_enough_for_steps_and_one_less_would_not_be():
    """The plan that the show would dance keeps within the steps' reach in every measure."""
    for seed in range(8):
        here = scattered(seed)
        for one in rank_formations(standing(here, reach=0.9), all_places()):
            assert farthest_in_a_measure(one.formation, here, one.measures) <= 0.9 + 1e-4
            if one.measures > 1:
                assert farthest_in_a_measure(one.formation, here, one.measures - 1) > 0.9


def farthest_in_a_measure(words, here, measures):
    found = places(words)
    segment = Segment(Evolve(words, path_mode="straight"), measures=measures)
    plan = Plan(Roster.create(COUNT), Repertoire({words: found}), [segment], half=(6.0, 4.0))
    plan.begin_measure(0, here.astype(np.float32), np.zeros(COUNT))
    plan.finish()
    lines = [plan.predicted_state(4.0 * measure).position.copy() for measure in range(1, measures + 1)]
    steps = np.diff(np.array([here, *lines]), axis=0)
    return float(np.hypot(steps[..., 0], steps[..., 1]).max())


def test_same_dancers_get_the_same_ranking_again_and_in_any_order():
    rng = np.random.default_rng(2)
    for seed in range(6):
        here = scattered(seed) if seed else places("grid").slots  # a grid has many equal assignments
        state = standing(here, groups=3, before=places("circle").slots)
        ranked = rank_formations(state, all_places())
        assert rank_formations(state, all_places()) == ranked
        for _ in range(4):
            order = rng.permutation(COUNT)
            mixed = replace(
                state, position=here[order], group=state.group[order], reach=state.reach[order],
                attributes=tuple(state.attributes[index] for index in order),
            )  # fmt: skip
            assert rank_formations(mixed, all_places()) == ranked


def test_pieces_give_the_same_as_the_whole():
    state = standing(scattered(1), groups=2)
    found, count = [], 0

    def collected():
        found.append((yield from rank_in_pieces(state, all_places())))

    for _ in collected():
        count += 1
    assert found == [rank_formations(state, all_places())]
    assert count >= len(WORDS)


def test_formation_just_left_ranks_lower():
    here = scattered(3)
    plain = rank_formations(standing(here), all_places())
    former = next(words for words in WORDS if words == plain[0].formation)
    again = rank_formations(standing(here, before=places(former).slots), all_places())
    assert names(again)[0] != former
    assert next(one for one in again if one.formation == former).repeat == pytest.approx(1.0)
    moved = replace(places(former), slots=places(former).slots + np.array([0.4, 0.0]))
    likeness = next(one.repeat for one in rank_formations(standing(here, before=moved.slots), all_places())
                    if one.formation == former)  # fmt: skip
    assert likeness == pytest.approx(0.6, abs=0.05)


def test_formation_that_keeps_groups_apart_ranks_higher():
    """Two blocks: their own blocks moved forward, or the same places with both groups in turns."""
    rows = np.array([[x, z] for x in (-4.0, -3.0, -2.0, 2.0, 3.0, 4.0) for z in (0.0, 1.0)])
    state = standing(rows, groups=2)
    apart = Places("apart", rows + np.array([0.0, -1.5]), np.zeros(COUNT), ["first"] * 6 + ["second"] * 6)
    taken = Places("mixed", rows + np.array([0.0, -1.5]), np.zeros(COUNT), ["first", "second"] * 6)
    words = tuple(frozenset({"first" if group == 0 else "second"}) for group in state.group)
    ranked = rank_formations(replace(state, attributes=words), [taken, apart])
    assert names(ranked) == ["apart", "mixed"]
    assert ranked[0].mixing == 0.0
    assert ranked[1].mixing > 0.3


def test_meetings_cost():
    """The same places, reserved so that two must pass through each other, come after those without a meeting."""
    here = np.array([[-2.0, 0.0], [2.0, 0.0]])
    words = (frozenset({"a"}), frozenset({"b"}))
    there = np.array([[2.0, 0.0], [-2.0, 0.0]])
    through = Places("through", there, np.zeros(2), ["a", "b"])
    aside = Places("aside", here + np.array([0.0, -3.5]), np.zeros(2), ["a", "b"])
    ranked = rank_formations(standing(here, attributes=words, reach=2.0), [through, aside])
    assert [(one.formation, one.meetings) for one in ranked] == [("aside", 0), ("through", 1)]


def test_places_of_dancers_who_stay_cost():
    here = np.array([[-2.0, 0.0], [2.0, 0.0]])
    taken, free = (
        Places("taken", here + np.array([0.0, 1.0]), np.zeros(2)),
        Places("free", here - np.array([0.0, 1.2]), np.zeros(2)),
    )
    assert names(rank_formations(standing(here), [taken, free])) == ["taken", "free"]
    others = here[:1] + np.array([0.1, 1.2])
    ranked = rank_formations(standing(here, others=others), [taken, free])
    assert [(one.formation, one.meetings) for one in ranked] == [("free", 0), ("taken", 1)]


def test_impossible_formations_are_left_out():
    here = scattered(4)
    few = Places("few", places("grid").slots[:5], np.zeros(5))
    off = Places("off", places("grid").slots + np.array([4.0, 0.0]), np.zeros(COUNT))
    tight = Places("tight", places("grid").slots * 0.1, np.zeros(COUNT))
    reserved = Places("reserved", places("grid").slots, np.zeros(COUNT), ["nobody"] * COUNT)
    assert rank_formations(standing(here), [few, off, tight, reserved]) == ()
    assert rank_formations(standing(np.zeros((0, 2))), all_places()) == ()
    assert names(rank_formations(standing(np.zeros((1, 2))), [places("line", 1)])) == ["line"]


def test_fifty_dancers_take_some_milliseconds():
    """All nine are planned. The bound is loose: other processes share the machine."""
    state = standing(scattered(0, 50), groups=3, reach=3.0, half_stage=(14.0, 10.0), before=scattered(1, 50))
    candidates = [places(words, 50, scale=3.5) for words in WORDS]
    assert len(rank_formations(state, candidates)) == len(WORDS)
    spent = []
    for _ in range(5):
        begin = time.perf_counter()
        rank_formations(state, candidates)
        spent.append(time.perf_counter() - begin)
    assert min(spent) < 0.2
