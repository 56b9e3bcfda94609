"""Agent command kernels before and after choreography, against array formulas."""

import numpy as np

from live.agents.agent_command import ABSENT, FIRM, ON_STAGE, PASSING, PRESENCE, SEPARATION, SPEED, AgentCommand
from live.agents.agent_command_kernels import hold_on_leash, write_presence

COUNT = 40


def random_commands(seed=1):
    chance = np.random.default_rng(seed)
    wants = AgentCommand(COUNT)
    wants.rows[:] = chance.uniform(-1.0, 1.0, wants.rows.shape)
    return chance, wants


def test_reset_keeps_only_presence_speed_and_separation():
    chance, wants = random_commands()
    before, speed = wants.rows.copy(), chance.uniform(0.5, 2.0, COUNT).astype(np.float32)
    wants.reset(speed, 0.9)
    expected = np.zeros_like(before)
    expected[:, PRESENCE], expected[:, SPEED], expected[:, SEPARATION] = before[:, PRESENCE], speed, np.float32(0.9)
    np.testing.assert_array_equal(wants.rows, expected)


def test_only_firm_agents_get_a_higher_speed():
    chance, wants = random_commands()
    before, speed = wants.rows.copy(), chance.uniform(0.5, 2.0, COUNT).astype(np.float32)
    wants.raise_firm_speeds(speed, 1.6)
    firm = before[:, FIRM] > 0.0
    assert 0 < firm.sum() < COUNT
    np.testing.assert_array_equal(wants.speed, np.where(firm, speed * np.float32(1.6), before[:, SPEED]))


def test_presence_follows_state_and_passing_agents_are_counted():
    chance, wants = random_commands()
    presence = np.array([ABSENT, ABSENT, PASSING, ON_STAGE, PASSING], np.float32)
    state = chance.integers(0, 5, COUNT).astype(np.int8)
    assert write_presence(wants.rows, state, presence, PASSING) == np.isin(state, (2, 4)).sum()
    np.testing.assert_array_equal(wants.presence, presence[state])


def test_leash_limits_only_visible_agents_without_plan():
    chance, wants = random_commands()
    wants.rows[:, FIRM] = chance.integers(0, 2, COUNT)
    state = chance.integers(0, 5, COUNT).astype(np.int8)
    position = chance.uniform(-3.0, 3.0, (COUNT, 2)).astype(np.float32)
    dancer, pace, velocity = (np.zeros((COUNT, 2), np.float32) for _ in range(3))
    before = np.hypot(*position.T)
    hold_on_leash(position, velocity, dancer, pace, wants.rows, state, 2, 3, 0.6, 0.9, np.zeros(COUNT, np.float32))
    free = (state < 2) | (wants.rows[:, FIRM] > 0.0)
    most = np.where(free, np.inf, np.where(state == 3, 0.6, 0.9))
    np.testing.assert_allclose(np.hypot(*position.T), np.minimum(before, most), atol=1e-6)
