"""The neighbor pass against plain numpy, pair by pair, and the power law of its avoidance force."""

import math

import numpy as np
import pytest

from live.agents.crowd.agent_state import Steering
from live.agents.crowd.contact_kernels import CONTACT_MARGIN
from live.agents.crowd.spatial_grid_kernels import (
    AVOID_X,
    AVOID_Z,
    FLOCK_X,
    FLOCK_Z,
    NEIGHBOUR_RANGE,
    PUSH_X,
    PUSH_Z,
    REQUEST_ROWS,
    SLEEP_TIME,
    SORTED_ROWS,
    SUM_ROWS,
    WEIGHT,
    sort_agents,
)
from live.agents.crowd.step_kernels import CELL_ROWS, PERSONAL_GAP, SPARE_COLUMNS, sum_neighbours


def _sums(position, velocity, give=None, separation=1.2, horizon=3.0, steering=None, asleep=()):
    """Sums (SUM_ROWS, A) in the order of the agents, and the pairs near contact."""
    a = len(position)
    width = a + SPARE_COLUMNS
    state = np.zeros(8 * a, np.float32)
    state[: 2 * a], state[2 * a : 4 * a] = position.ravel(), velocity.ravel()
    wants = np.zeros((a, 8), np.float32)
    wants[:, 0], wants[:, 2], wants[:, 7] = 5.0, 1.0, 1.0
    for i in asleep:
        wants[i, 0], state[6 * a + i] = 0.0, SLEEP_TIME
    model = np.zeros((a, 2), np.float32)
    model[:, 0], model[:, 1] = 0.25, 1.0 if give is None else 2.0 - np.asarray(give)
    rows, slots = np.zeros((SORTED_ROWS, width), np.float32), np.zeros(width, np.int32)
    cells, grid = np.zeros((CELL_ROWS, 8 * a + 258), np.int32), np.empty(4)
    n = sort_agents(state, wants.ravel(), model.ravel(), rows, slots, np.zeros(2 * width, np.int32), cells, grid)
    assert n == a
    asks = np.zeros((REQUEST_ROWS, width), np.float32)
    asks[:] = np.array([1.0 / separation**2, 1.0 / horizon, 0.4, 0.2, PERSONAL_GAP])[:, None]
    sums, pairs = np.zeros((SUM_ROWS, width), np.float32), np.zeros(12 * width, np.int32)
    params = (steering or Steering()).vector()
    count = sum_neighbours(rows, cells[0], grid, asks, sums, params, cells[1], *np.zeros((3, width), np.int32), pairs)
    ordered = np.zeros((SUM_ROWS, a))
    ordered[:, slots[:a]] = sums[:, :a]
    found = {tuple(sorted(slots[pairs[2 * p : 2 * p + 2]].tolist())) for p in range(count)}
    return ordered, found


def _one_pair(dx, dz, ux, uz, give, separation, horizon, steering):
    """Sums that one neighbor adds to an agent; (dx, dz) from neighbor to agent, (ux, uz) relative velocity; floats."""
    d2 = dx * dx + dz * dz
    out = np.zeros(SUM_ROWS)
    push = max(1 - d2 / separation**2, 0.0) ** 2
    seen = max(1 - d2 / NEIGHBOUR_RANGE**2, 0.0)
    out[PUSH_X], out[PUSH_Z], out[WEIGHT] = push * dx, push * dz, seen**2
    out[FLOCK_X], out[FLOCK_Z] = -(seen**2) * (0.4 * ux + 0.2 * dx), -(seen**2) * (0.4 * uz + 0.2 * dz)
    tx, tz = dx + steering.side * dz, dz - steering.side * dx
    closing, u2, reach2 = -(tx * ux + tz * uz), ux * ux + uz * uz, (0.5 + PERSONAL_GAP) ** 2
    c = max(d2 - reach2, 1e-3)
    disc = closing**2 - u2 * c
    if closing > 0 and disc > 0:
        w = min((closing + math.sqrt(disc)) / c, 1 / 0.15)
        h = max(w - 1 / horizon, 0.0)
        gate = give * min(4 * seen, 1.0) * math.sqrt(disc) / (disc + 0.05 * u2 * reach2 + 1e-9)
        force = steering.strength * min(h * (2 * h + 1 / steering.horizon) * gate, 40.0)
        out[AVOID_X], out[AVOID_Z] = force * (tx * w + ux), force * (tz * w + uz)
    return out


@pytest.mark.parametrize("count", [2, 7, 60])
def test_neighbor_sums_equal_sums_over_all_pairs(count):
    chance, steering = np.random.default_rng(count), Steering()
    position = chance.uniform(-4, 4, (count, 2)).astype(np.float32)
    velocity = chance.normal(0, 0.8, (count, 2)).astype(np.float32)
    give = chance.uniform(0.2, 2.0, count)
    sums, pairs = _sums(position, velocity, give)
    for i in range(count):
        expected = np.zeros(SUM_ROWS)
        expected[WEIGHT] = 1.0  # the agent itself
        for j in set(range(count)) - {i}:
            d, u = (position[i] - position[j]).astype(float), (velocity[i] - velocity[j]).astype(float)
            one = _one_pair(*d, *u, give[j], 1.2, 3.0, steering)
            one[[AVOID_X, AVOID_Z]] *= 2.0 - give[i]
            expected += one
        assert sums[:, i] == pytest.approx(expected, rel=2e-3, abs=2e-3)
    close = np.hypot(*(position[:, None] - position[None]).transpose(2, 0, 1)) < 0.5 + CONTACT_MARGIN
    assert pairs == {(i, j) for i in range(count) for j in range(i + 1, count) if close[i, j]}


@pytest.mark.parametrize("time", [0.3, 0.5, 1.0])
def test_head_on_force_is_power_law_gradient(time):
    # Karamouzas, Skinner & Guy 2014: E = k exp(-t / t0) / t²; head on the gradient of t along the way is 1 / speed
    speed, k, t0 = 2.0, 4.0, 30.0
    steering = Steering(side=0.0, strength=k, horizon=t0)
    position = np.array([[0.0, 0.0], [0.5 + PERSONAL_GAP + speed * time, 0.0]], np.float32)
    velocity = np.array([[speed / 2, 0.0], [-speed / 2, 0.0]], np.float32)
    sums, _ = _sums(position, velocity, horizon=1e6, steering=steering)
    energy = lambda t: k * math.exp(-t / t0) / t**2  # noqa: E731
    expected = (energy(time + 1e-5) - energy(time - 1e-5)) / 2e-5 / speed
    fade = min(4 * (1 - position[1, 0] ** 2 / NEIGHBOUR_RANGE**2), 1.0)
    assert sums[AVOID_X, 0] == pytest.approx(expected * fade, rel=0.05)
    assert sums[AVOID_X, 1] == pytest.approx(-sums[AVOID_X, 0], rel=1e-5)
    assert abs(sums[AVOID_Z, 0]) < 1e-6


def test_all_coincident_agents_are_counted():
    position = np.zeros((300, 2), np.float32)
    sums, _ = _sums(position, np.zeros_like(position))
    assert (sums[WEIGHT] == 300).all()
    assert np.isfinite(sums).all()


def test_neighbors_out_of_range_add_nothing():
    position = np.array([[0.0, 0.0], [NEIGHBOUR_RANGE + 0.01, 0.0]], np.float32)
    sums, _ = _sums(position, np.array([[2.0, 0.0], [-2.0, 0.0]], np.float32))
    assert (sums[[PUSH_X, PUSH_Z, FLOCK_X, FLOCK_Z, AVOID_X, AVOID_Z]] == 0).all()


def test_sums_are_independent_of_agents_out_of_range():
    chance = np.random.default_rng(5)
    position = chance.uniform(-3, 3, (40, 2)).astype(np.float32)
    velocity = chance.normal(0, 0.8, (40, 2)).astype(np.float32)
    position[0], position[1] = (-3, -3), (3, 3)  # these two span the grid
    alone, _ = _sums(position, velocity, np.ones(40))
    for gone in range(2, 40):
        near = np.hypot(*(position - position[gone]).T) <= NEIGHBOUR_RANGE
        stay = np.arange(40) != gone
        fewer, _ = _sums(position[stay], velocity[stay], np.ones(39))
        assert (fewer[:, ~near[stay]] == alone[:, ~near]).all()


def test_only_agents_near_an_awake_agent_are_summed():
    position = np.stack([np.arange(0.1, 12.0, 0.9), np.zeros(14)], 1).astype(np.float32)
    sums, _ = _sums(position, np.zeros_like(position), asleep=range(1, 14))
    assert (sums[:, position[:, 0] > 5] == 0).all()
    near = position[:, 0] < NEIGHBOUR_RANGE
    assert (sums[WEIGHT, near] > 1).all()
    assert (sums[:, near] == _sums(position, np.zeros_like(position))[0][:, near]).all()
    assert (_sums(position, np.zeros_like(position), asleep=range(14))[0] == 0).all()
