"""Wants before and after choreography: the same as said in arrays at once."""

import numpy as np

from live.agents.agent_command import ABSENT, FIRM, ON_STAGE, PASSING, PRESENCE, SEPARATION, SPEED, AgentCommand
from live.agents.agent_command_kernels import hold_on_leash, write_presence

COUNT = 40


def drawn(seed=1):
    chance = np.random.default_rng(seed)
    wants = AgentCommand(COUNT)
    wants.rows[:] = chance.uniform(-1.0, 1.0, wants.rows.shape)
    return chance, wants


def test_nobody_wants_anything_but_room_and_her_speed():
    chance, wants = drawn()
    before, speed = wants.rows.copy(), chance.uniform(0.5, 2.0, COUNT).astype(np.float32)
    wants.reset(speed, 0.9)
    expected = np.zeros_like(before)
    expected[:, PRESENCE], expected[:, SPEED], expected[:, SEPARATION] = before[:, PRESENCE], speed, np.float32(0.9)
    np.testing.assert_array_equal(wants.rows, expected)


def test_only_the_firm_hurry():
    chance, wants = drawn()
    before, speed = wants.rows.copy(), chance.uniform(0.5, 2.0, COUNT).astype(np.float32)
    wants.raise_firm_speeds(speed, 1.6)
    firm = before[:, FIRM] > 0.0
    assert 0 < firm.sum() < COUNT
    np.testing.assert_array_equal(wants.speed, np.where(firm, speed * np.float32(1.6), before[:, SPEED]))


def test_presence_follows_the_state_and_who_passes_is_counted():
    chance, wants = drawn()
    presence = np.array([ABSENT, ABSENT, PASSING, ON_STAGE, PASSING], np.float32)
    state = chance.integers(0, 5, COUNT).astype(np.int8)
    assert write_presence(wants.rows, state, presence, PASSING) == np.isin(state, (2, 4)).sum()
    np.testing.assert_array_equal(wants.presence, presence[state])


def test_leashes_are_for_those_who_are_seen_and_under_no_plan():
    chance, wants = drawn()
    wants.rows[:, FIRM] = chance.integers(0, 2, COUNT)
    state = chance.integers(0, 5, COUNT).astype(np.int8)
    position = chance.uniform(-3.0, 3.0, (COUNT, 2)).astype(np.float32)
    dancer, pace, velocity = (np.zeros((COUNT, 2), np.float32) for _ in range(3))
    before = np.hypot(*position.T)
    hold_on_leash(position, velocity, dancer, pace, wants.rows, state, 2, 3, 0.6, 0.9, np.zeros(COUNT, np.float32))
    free = (state < 2) | (wants.rows[:, FIRM] > 0.0)
    most = np.where(free, np.inf, np.where(state == 3, 0.6, 0.9))
    np.testing.assert_allclose(np.hypot(*position.T), np.minimum(before, most), atol=1e-6)
