"""Steering kernels against plain formulas and laws."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents import kernels
from live.agents.advance import Advance
from live.agents.elements import ATTRACTOR, REPULSOR, SPREADER, Element, ElementField
from live.agents.model import AgentModel, AgentState, Steering

TICK = 1 / 64


def run(position, elements, seconds, *, speed=1.0, steering=None, seed=3):
    """Agents from `position` under `elements` (in force from the start) for some seconds; the last state."""
    steering = steering or Steering()
    count = len(position)
    model = AgentModel(np.full(count, 0.25, np.float32), steering, seed)
    state, spare = AgentState.at(np.array(position, float)), AgentState.at(np.zeros((count, 2)))
    field = ElementField()
    for element in elements:
        field.add(element)
    field.refresh(10.0)
    advance = Advance(model)
    limit = np.full(count, speed, np.float32)
    for tick in range(round(seconds / TICK)):
        advance(state, spare, speed=limit, dancer=state.position, field=field, time=tick * TICK, dt=TICK)
        state, spare = spare, state
    return state


def element(kind, x=0.0, z=0.0, strength=1.0):
    return Element(kind, x, z, strength, 0.0, 1e9)


@given(st.integers(0, 40), st.integers(0, 2**31 - 1))
def test_cells_hold_every_agent_once_in_the_right_cell(count, seed):
    position = np.random.default_rng(seed).uniform(-8, 8, (count, 2)).astype(np.float32)
    start, order = np.zeros(5 * 4 + 1, np.int32), np.zeros(count, np.int32)
    kernels.sort_into_cells(position, 6.0, 4.0, 2.5, start, order)
    assert sorted(order) == list(range(count))
    assert start[0] == 0
    assert start[-1] == count
    for cell in range(20):
        members = order[start[cell] : start[cell + 1]]
        assert list(members) == sorted(members)
        for x, z in position[members].astype(float):
            column = min(max(math.floor((x + 6) / 2.5), 0), 4)
            row = min(max(math.floor((z + 4) / 2.5), 0), 3)
            assert row * 5 + column == cell


@pytest.mark.parametrize(("kind", "sign"), [(ATTRACTOR, 1.0), (REPULSOR, -1.0)])
def test_a_source_pulls_with_one_minus_f_and_pushes_with_f(kind, sign):
    """T105: f(d) = exp(-d / decay); the direction is that to, or from, the source."""
    params = Steering().vector()
    decay = Steering().attract_decay if kind == ATTRACTOR else Steering().repel_decay
    for distance in (0.2, 1.0, 4.0):
        wish = kernels.steer_sources(
            0.0, 0.0, np.array([kind], np.int32), np.array([[0.6 * distance, 0.8 * distance]], np.float32),
            np.ones(1, np.float32), 1, params, 1, 0,
        )  # fmt: skip
        f = math.exp(-distance / decay)
        level = (1 - f) if kind == ATTRACTOR else f
        assert wish == pytest.approx((sign * 0.6 * level, sign * 0.8 * level), abs=1e-6)


def test_only_the_nearest_attractor_acts():
    """T106: a mix would pull everybody to the centre of mass; here the two sides part."""
    start = [(-1.0, 0.3), (-1.5, -1), (1.0, 0.2), (1.6, -0.9)]
    end = run(start, [element(ATTRACTOR, -4.0), element(ATTRACTOR, 4.0)], 12).position
    assert (end[:2, 0] < -3).all()
    assert (end[2:, 0] > 3).all()


def test_repelled_agents_leave_and_those_far_away_stay():
    start = [(0.5, 0.0), (-0.4, 0.6), (5.0, 3.0)]
    end = run(start, [element(REPULSOR)], 8).position
    assert (np.hypot(*end[:2].T) > 2.0).all()
    assert np.hypot(*(end[2] - start[2])) < 0.6


def test_spreading_from_a_clump_fills_the_stage():
    """T109's own criterion: variance to mean of the counts on coarse cells falls; random places have about 1."""
    chance = np.random.default_rng(5)
    start = chance.uniform((-5.5, -3.5), (-2.5, 3.5), (48, 2))
    steering = Steering()

    def evenness(position):
        counts = np.histogram2d(*position.T, bins=[3, 2], range=[[-6, 6], [-4, 4]])[0]
        return counts.var() / counts.mean()

    end = run(start, [element(SPREADER)], 25, steering=steering).position
    assert evenness(start) > 5
    assert evenness(end) < 0.5


def test_agents_in_one_place_part_without_nan():
    end = run([(1.0, 1.0)] * 5, [], 6)
    assert np.isfinite(end.position).all()
    apart = np.hypot(*(end.position[:, None] - end.position[None]).transpose(2, 0, 1))[np.triu_indices(5, 1)]
    assert apart.min() > 0.5


def test_head_on_agents_pass_each_other():
    steering = Steering()
    start = [(-3.0, 0.0), (3.0, 0.0)]
    model = AgentModel(np.full(2, 0.25, np.float32), steering, 1)
    nearest = math.inf
    state, spare = AgentState.at(np.array(start)), AgentState.at(np.zeros((2, 2)))
    state.velocity[:] = [[1, 0], [-1, 0]]
    left, right = ElementField(), ElementField()
    left.add(element(ATTRACTOR, -4.5))
    right.add(element(ATTRACTOR, 4.5))
    for field in (left, right):
        field.refresh(10.0)
    one, two = Advance(model), Advance(model)
    other = AgentState.at(np.zeros((2, 2)))
    for tick in range(64 * 20):  # each agent has its own attractor: take each one's half of two advances
        limit = np.ones(2, np.float32)
        one(state, spare, speed=limit, dancer=state.position, field=right, time=tick * TICK, dt=TICK)
        two(state, other, speed=limit, dancer=state.position, field=left, time=tick * TICK, dt=TICK)
        spare.position[1], spare.velocity[1] = other.position[1], other.velocity[1]
        state, spare = spare, state
        nearest = min(nearest, float(np.hypot(*(state.position[0] - state.position[1]))))
    assert state.position[0, 0] > 3.0
    assert state.position[1, 0] < -3.0
    assert nearest > 0.4


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 30), st.integers(0, 10**6), st.lists(st.integers(0, 2), max_size=4))
def test_nobody_leaves_the_stage_goes_too_fast_or_becomes_nan(count, seed, kinds):
    chance = np.random.default_rng(seed)
    start = chance.uniform((-6, -4), (6, 4), (count, 2))
    elements = [element(kind, *chance.uniform(-7, 7, 2), strength=10.0) for kind in kinds]
    end = run(start, elements, 1.5, speed=1.3, seed=seed)
    assert np.isfinite(end.position).all()
    assert np.isfinite(end.velocity).all()
    assert (np.abs(end.position) <= np.array([6, 4]) + 1e-5).all()
    assert (np.hypot(*end.velocity.T) <= 1.3 + 1e-4).all()


def test_the_order_of_the_agents_does_not_matter():
    chance = np.random.default_rng(11)
    start = chance.uniform(-3, 3, (20, 2))
    turned = chance.permutation(20)
    once = run(start, [element(ATTRACTOR, 1.0, 1.0)], 3).position
    again = run(start[turned], [element(ATTRACTOR, 1.0, 1.0)], 3).position
    assert again == pytest.approx(once[turned], abs=2e-3)


def test_an_agent_waits_for_its_dancer():
    model = AgentModel(np.full(1, 0.25, np.float32), Steering(), 1)
    field = ElementField()
    field.add(element(ATTRACTOR, 5.0))
    field.refresh(10.0)
    ways = []
    for follows in (True, False):
        state, spare = AgentState.at(np.zeros((1, 2))), AgentState.at(np.zeros((1, 2)))
        advance = Advance(model)
        still = np.zeros((1, 2), np.float32)
        for tick in range(64 * 6):
            dancer = state.position if follows else still
            advance(state, spare, speed=np.ones(1, np.float32), dancer=dancer, field=field, time=tick * TICK, dt=TICK)
            state, spare = spare, state
        ways.append(state.position[0, 0])
    assert ways[0] > 4.0
    assert ways[1] < 2.5


def test_seeded_chance_is_even_and_depends_on_each_argument():
    values = np.array([kernels.hash_unit(1, agent, 2) for agent in range(4000)])
    assert values.min() >= 0.0
    assert values.max() < 1.0
    assert np.histogram(values, 10, (0, 1))[0].min() > 320
    assert len({kernels.hash_unit(*key) for key in [(1, 2, 3), (2, 2, 3), (1, 3, 3), (1, 2, 4)]}) == 4
