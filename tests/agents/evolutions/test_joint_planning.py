"""Joint planning: groups that move in the same measures neither overlap nor meet (T147)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.evolutions.collision_check import TOLERANCE
from live.agents.evolutions.dry_run import simulate_plan
from live.agents.evolutions.facing import Facing, Orientation
from live.agents.evolutions.intention import (
    Evolve,
    Hold,
    PathMode,
    Pause,
    Places,
    Procedural,
    Repertoire,
    Segment,
    Trajectory,
)
from live.agents.evolutions.joint_planning import MEETING_GAP
from live.agents.evolutions.running_plan import BEATS_HELD, Plan
from live.agents.groups.roster import Roster

RADIUS, BEATS, MOMENTS = 0.25, 4.0, 128
BLOCK = np.stack([np.tile(np.arange(2.0), 4), np.repeat(np.arange(4.0) - 1.5, 2)], 1)
"""Eight places, 1 m apart."""
LEFT, RIGHT = BLOCK - np.array([4.5, 0.0]), BLOCK + np.array([3.5, 0.0])


def places(name, slots):
    return Places(name, np.asarray(slots, float), np.zeros(len(slots)))


def made(start, goals, *, order=None, intentions=None, measures=2, **options):
    """Return a plan of groups of eight dancers and their starts."""
    names = [f"goal {n}" for n in range(len(goals))]
    repertoire = Repertoire({name: places(name, goal) for name, goal in zip(names, goals, strict=True)})
    ends = np.cumsum([len(goal) for goal in goals])
    segments = [
        Segment((intentions or {}).get(n, Evolve(name)), f"{end - len(goal) + 1}-{end}", 0, measures)
        for n, (name, goal, end) in enumerate(zip(names, goals, ends, strict=True))
    ]
    segments = segments if order is None else [segments[n] for n in order]
    return Plan(Roster.create(len(start)), repertoire, segments, radius=RADIUS, **options)


def danced(plan, start, measures=2):
    plan.begin_measure(0, start, np.zeros(len(start)))
    plan.finish()
    beats = np.linspace(0.0, measures * BEATS, measures * MOMENTS + 1)
    return np.array([plan.state_at(beat).position.copy() for beat in beats], np.float64)


def nearest(ways):
    """Return how near each pair comes [m], straight between moments, (A, A)."""
    apart = ways[:, :, None] - ways[:, None]
    move, begin = np.diff(apart, axis=0), apart[:-1]
    square = np.maximum((move**2).sum(-1), 1e-18)
    at = np.clip(-(begin * move).sum(-1) / square, 0.0, 1.0)
    found = np.hypot(*np.moveaxis(begin + at[..., None] * move, -1, 0)).min(axis=0)
    np.fill_diagonal(found, np.inf)
    return found


def length(ways):
    return np.hypot(*np.moveaxis(np.diff(ways, axis=0), -1, 0)).sum()


SIDES = np.concatenate([LEFT, RIGHT])


def test_groups_that_change_sides_do_not_meet():
    plan = made(SIDES, [RIGHT, LEFT])
    ways = danced(plan, SIDES)
    straight = np.linspace(SIDES, ways[-1], 65)
    assert (nearest(straight) < 2 * RADIUS).any()
    assert nearest(ways).min() >= 2 * RADIUS + MEETING_GAP - 0.01
    assert length(ways) < 1.1 * length(straight)
    assert {tuple(place) for place in ways[-1].round(3)} == {tuple(place) for place in SIDES.round(3)}
    assert np.abs(ways[0] - SIDES).max() < 1e-6
    assert np.hypot(*np.moveaxis(np.diff(ways, axis=0)[[0, -1]], -1, 0)).max() < 0.01  # they start and stop softly


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 4))
def test_random_groups_never_overlap(seed, groups):
    chance = np.random.default_rng(seed)
    corners = np.array([[-4.5, -2.5], [3.5, -2.5], [3.5, 2.5], [-4.5, 2.5]])[:groups]
    blocks = [corner + BLOCK + chance.uniform(-0.12, 0.12, BLOCK.shape) for corner in corners]
    start = np.concatenate(blocks)
    goals = [blocks[n] + chance.uniform(-0.08, 0.08, BLOCK.shape) for n in chance.permutation(groups)]
    ways = danced(made(start, goals, half=(7.0, 5.0)), start)
    assert nearest(ways).min() >= 2 * RADIUS - 1e-4
    assert np.abs(ways[..., 0]).max() <= 7.0
    assert np.abs(ways[..., 1]).max() <= 5.0


def test_order_of_segments_does_not_matter():
    goals = [RIGHT, LEFT]
    one, other = (danced(made(SIDES, goals, order=order), SIDES) for order in ((0, 1), (1, 0)))
    assert np.array_equal(one, other)
    assert np.array_equal(one, danced(made(SIDES, goals), SIDES))


def scattered(seed=3):
    return SIDES + np.random.default_rng(seed).uniform(-0.1, 0.1, SIDES.shape)


def test_turned_stage_gives_turned_ways():
    """Half a turn of everything turns the ways, and nothing else."""
    start = scattered()
    goals = [RIGHT + 0.03, LEFT - 0.05]
    ways, turned = danced(made(start, goals), start), danced(made(-start, [-goal for goal in goals]), -start)
    assert turned == pytest.approx(-ways, abs=0.02)


def test_way_back_is_as_safe_and_as_long():
    start = scattered()
    ways = danced(made(start, [RIGHT, LEFT]), start)
    back = danced(made(ways[-1], [start[:8], start[8:]]), ways[-1])
    assert nearest(back).min() >= 2 * RADIUS + MEETING_GAP - 0.02
    assert length(back) == pytest.approx(length(ways), rel=0.02)


def test_another_group_makes_nobody_overlap():
    third = BLOCK - [0.5, 0.0]
    start = np.concatenate([SIDES, third])
    ways = danced(made(start, [RIGHT, LEFT, third + np.array([0.0, 0.4])], half=(7.0, 5.0)), start)
    assert nearest(ways).min() >= 2 * RADIUS - 1e-4


def test_group_that_stands_is_walked_around():
    """A group that pauses, and one that an earlier segment holds, stay; others go through without touching."""
    row = np.stack([np.zeros(4), np.arange(4) * 2.0 - 3.0], 1)
    start = np.concatenate([LEFT, row])
    repertoire = Repertoire({"right": places("right", RIGHT), "row": places("row", row)})
    for held in (Segment(Pause(), "9-12", 0, 3), Segment(Hold("row"), "9-12", 0)):
        segments = [held, Segment(Evolve("right"), "1-8", 1, 2)]
        plan = Plan(Roster.create(12), repertoire, segments, radius=RADIUS)
        danced(plan, start, 1)
        plan.begin_measure(1, start, np.zeros(12))
        plan.finish()
        ways = np.array([plan.state_at(4.0 + beat).position.copy() for beat in np.linspace(0.0, 8.0, 257)], np.float64)
        assert np.abs(ways[:, 8:] - row).max() < 1e-5
        assert nearest(ways).min() >= 2 * RADIUS - 1e-4


def test_straight_ways_stay_straight_and_others_give_way():
    left = np.stack([np.full(4, -4.0), np.arange(4) * 1.6 - 2.4], 1)
    right = left * [-1.0, 1.0] + [0.0, 0.3]
    start = np.concatenate([left, right])
    straight = Evolve("goal 0", path_mode=PathMode.STRAIGHT)
    ways = danced(made(start, [left * [-1.0, 1.0], right * [-1.0, 1.0]], intentions={0: straight}), start)
    assert np.abs(ways[:, :4, 1] - left[:, 1]).max() < 1e-5
    assert nearest(ways).min() >= 2 * RADIUS + MEETING_GAP - 0.01


def test_drawn_lines_keep_their_shape_more_than_ways():
    line = np.array([[-4.0, 0.0], [4.0, 0.0]])
    one, others = np.array([[-4.0, 0.0]]), np.array([[4.0, 0.1], [4.0, 1.1]])
    repertoire = Repertoire({"goal": places("goal", others * [-1.0, 1.0])}, {"line": line})
    segments = [Segment(Trajectory("line"), "1", 0, 2), Segment(Evolve("goal"), "2-3", 0, 2)]
    start = np.concatenate([one, others])
    ways = danced(Plan(Roster.create(3), repertoire, segments, radius=RADIUS), start)
    assert nearest(ways).min() >= 2 * RADIUS - 1e-4
    off = np.abs(ways[:, 0, 1]).max()
    assert off < np.abs(ways[:, 1, 1] - np.interp(ways[:, 1, 0], [-4, 4], [0.1, 0.1])).max() / 2


def test_single_group_is_planned_as_before():
    start, repertoire = LEFT, Repertoire({"goal": places("goal", RIGHT)})
    plan = Plan(Roster.create(8), repertoire, [Segment(Evolve("goal"), measures=2)], radius=RADIUS)
    danced(plan, start)
    assert plan.motions[0].motion.locomotion.path_knots.shape == (8, 2, 2)


def test_far_groups_are_left_as_they_are():
    start = np.concatenate([LEFT, RIGHT])
    plan = made(start, [LEFT + np.array([0.0, 0.5]), RIGHT + np.array([0.0, 0.5])])
    danced(plan, start)
    assert {motion.motion.locomotion.path_knots.shape[1] for motion in plan.motions} == {2}


def test_same_places_are_neither_reached_nor_endless():
    """Two groups with the same goal: planning ends, and the pairs that overlap are told."""
    repertoire = Repertoire({"goal": places("goal", BLOCK)})
    segments = [Segment(Evolve("goal"), "1-8", 0, 2), Segment(Evolve("goal"), "9-16", 0, 2)]
    done = simulate_plan(Roster.create(16), repertoire, segments, SIDES, measures=2)
    assert len({(one.first, one.second) for one in done.too_near}) >= 8
    assert np.isfinite(done.places).all()


@pytest.mark.parametrize("measures", [1, 7])
def test_groups_of_one_and_hardly_any_time(measures):
    """Dancers one by one; ways that are too long are planned all the same, and told by the dry run."""
    start = np.array([[-5.0, 0.0], [5.0, 0.0], [0.0, 4.0], [0.0, -4.0]])
    goals = [-start[n : n + 1] for n in range(4)]
    ways = danced(made(start, goals, measures=measures, half=(7.0, 5.0)), start, measures)
    assert nearest(ways).min() >= 2 * RADIUS - 1e-4
    assert ways[-1] == pytest.approx(-start, abs=1e-4)


def test_two_hundred_dancers_are_planned_in_small_pieces():
    x, z = np.meshgrid(np.arange(10.0), np.arange(10.0))
    block = np.stack([x.ravel(), z.ravel() - 4.5], 1) * 1.2
    start = np.concatenate([block - [14.0, 0.0], block + np.array([3.0, 0.0])])
    plan = made(start, [start[100:], start[:100]], measures=8, half=(16.0, 8.0))
    plan.prepare(0, start, np.zeros(200))
    for _ in range(40):
        assert not plan.idle
        plan.work()
    plan.begin_measure(0, start, np.zeros(200))
    for _ in range(600):
        plan.work()
    assert plan.idle  # it has given up: what has been found is danced


def test_tangent_headings_follow_the_bent_way():
    along = {n: Evolve(f"goal {n}", orientation=Orientation(Facing.TANGENT)) for n in (0, 1)}
    plan = made(SIDES, [RIGHT, LEFT], intentions=along)
    ways = danced(plan, SIDES)
    step = 1e-3
    for beat in (2.5, 4.0, 5.5):
        before = plan.state_at(beat - step).position.astype(np.float64)
        state = plan.state_at(beat + step)
        move = state.position.astype(np.float64) - before
        off = np.abs(np.mod(np.arctan2(*move.T) - state.heading + np.pi, 2 * np.pi) - np.pi)
        assert off.max() < 0.25
    assert nearest(ways).min() >= 2 * RADIUS - 1e-4


def test_late_planning_does_not_make_anybody_jump():
    """Planned only when the measure has begun: during the first beat everybody is where they were to be."""
    plan = made(SIDES, [RIGHT, LEFT])
    plan.begin_measure(0, SIDES, np.zeros(16))
    early = [plan.state_at(beat).position.copy() for beat in (0.5, BEATS_HELD)]
    while not plan.idle:
        plan.work()
    for beat, place in zip((0.5, BEATS_HELD), early, strict=True):
        assert plan.state_at(beat).position == pytest.approx(place, abs=0.02)
    beats = np.linspace(0.0, 8.0, 257)
    ways = np.array([plan.state_at(beat).position.copy() for beat in beats], np.float64)
    assert nearest(ways).min() >= 2 * RADIUS - 1e-4


def test_prepared_ways_are_those_of_a_dry_run():
    plan = made(SIDES, [RIGHT, LEFT])
    plan.prepare(0, SIDES, np.zeros(16))
    while not plan.idle:
        plan.work()
    plan.begin_measure(0, SIDES, np.zeros(16))
    other = made(SIDES, [RIGHT, LEFT])
    danced(other, SIDES)
    assert np.array_equal(plan.state_at(3.3).position, other.state_at(3.3).position)


def test_released_and_procedural_dancers_are_left_out():
    plan = made(SIDES, [RIGHT, LEFT], intentions={1: Procedural()})
    ways = danced(plan, SIDES)
    assert plan.motions[0].motion.locomotion.path_knots.shape[1] == 2
    assert np.isfinite(ways[:, :8]).all()
    gone = np.arange(16) >= 8
    plan = made(SIDES, [RIGHT, LEFT])
    plan.prepare(0, SIDES, np.zeros(16))
    plan.begin_measure(0, SIDES, np.zeros(16))
    plan.release(gone)
    plan.finish()
    assert plan.state_at(4.0).controlled.tolist() == [1] * 8 + [0] * 8
    assert {motion.motion.locomotion.path_knots.shape[1] for motion in plan.motions} == {2}


def test_canon_of_one_way_is_planned_with_its_delay():
    plan = made(SIDES, [RIGHT, LEFT])
    first, second = plan.segments
    late = Plan(Roster.create(16), plan.repertoire, [first, replace(second, delay=2.0)], radius=RADIUS)
    ways = danced(late, SIDES, 3)
    ways[: MOMENTS // 2, 8:] = SIDES[8:]
    assert nearest(ways).min() >= 2 * RADIUS - TOLERANCE
