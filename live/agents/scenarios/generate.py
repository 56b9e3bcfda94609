"""The scenarios for comparing avoidance engines: head on, circles, crossings, a gap, corridors, formations."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.optimize import linear_sum_assignment

from live.agents.scenarios.scenario import Scenario, endless_goals, through_door, through_gap
from live.base.arrays import Float64

RADIUS: Final = 0.25
PREFERRED: Final = 1.3
MAXIMUM: Final = 1.8
GOAL_RADIUS: Final = 0.3


def dart_throwing(
    rng: np.random.Generator, count: int, spacing: float, low: tuple[float, float], high: tuple[float, float]
) -> Float64:
    """Return uniform places in a rectangle, none closer than `spacing` [m] to another (Poisson disk), (count, 2)."""
    places = np.empty((0, 2))
    for _ in range(400 * count + 10000):
        if len(places) == count:
            return places
        dart = rng.uniform(low, high)
        if len(places) == 0 or np.min(np.sum((places - dart) ** 2, axis=1)) >= spacing * spacing:
            places = np.vstack([places, dart])
    raise ValueError(f"{count} places {spacing} m apart do not fit between {low} and {high}")


def _scenario(duration: float, start: Float64, goal: Float64, walls: Float64 | None = None) -> Scenario:
    return Scenario(
        duration,
        RADIUS,
        PREFERRED,
        MAXIMUM,
        GOAL_RADIUS,
        start,
        tuple(point.reshape(1, 2) for point in goal),
        walls=np.zeros((0, 4)) if walls is None else walls,
    )


def opposite(points: list[tuple[float, float]]) -> Scenario:
    """Exactly symmetric: each agent goes to the opposite point."""
    start = np.array(points, float)
    return _scenario(30.0, start, -start)


def circle(count: int, ring: float, seed: int) -> Scenario:
    """Agents on a circle of radius `ring` [m], started within a centimetre of their places, go to the far side."""
    angle = np.arange(count) * (2.0 * np.pi / count)
    exact = ring * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    jitter = np.random.default_rng(1000 + seed).uniform(-0.01, 0.01, exact.shape)
    return _scenario(60.0, exact + jitter, -exact)


def cross(half: int, spacing: float, seed: int) -> Scenario:
    """Crossing (T110): two groups of `half` agents change sides, each to their mirror image."""
    chance = np.random.default_rng(1000 + seed)
    left = dart_throwing(chance, half, spacing, (-7.5, -4.5), (-1.0, 4.5))
    right = dart_throwing(chance, half, spacing, (1.0, -4.5), (7.5, 4.5))
    start = np.concatenate([left, right])
    return _scenario(60.0, start, start * (-1.0, 1.0))


def bottleneck(count: int, seed: int) -> Scenario:
    """Agents leave a room of 8 m x 8 m through a gap 1.2 m wide and 0.4 m long."""
    chance = np.random.default_rng(1000 + seed)
    start = dart_throwing(chance, count, 0.65, (-3.6, -3.6), (2.6, 3.6))
    goal = np.stack([np.full(count, 9.0), chance.uniform(-3.0, 3.0, count)], axis=1)
    walls = [[-4.0, -4.0, -4.0, 4.0]]
    for side in (-1.0, 1.0):
        walls += [[-4.0, 4.0 * side, 4.4, 4.0 * side], [4.0, 0.6 * side, 4.4, 0.6 * side]]
        walls += [[x, 0.6 * side, x, 4.0 * side] for x in (4.0, 4.4)]
    return replace(_scenario(120.0, start, goal, np.array(walls)), rule=through_gap(goal))


def formation(seed: int) -> Scenario:
    """Fifty dancers go from random places to a grid of 10 x 5 at 1 m, assigned for the least total path length."""
    chance = np.random.default_rng(1000 + seed)
    start = dart_throwing(chance, 50, 0.9, (-6.5, -4.5), (6.5, 4.5))
    grid = np.stack(np.meshgrid(np.arange(10) - 4.5, np.arange(5) - 2.0), axis=-1).reshape(-1, 2)
    _, column = linear_sum_assignment(np.linalg.norm(start[:, None] - grid[None], axis=2))
    return _scenario(60.0, start, grid[column])


def random_goals(count: int, seed: int) -> Scenario:
    """Half a dancer per square metre, each going to random places one after another without end."""
    half_width = float(np.sqrt(count / 0.5)) / 2.0
    chance = np.random.default_rng(1000 + seed)
    start = dart_throwing(chance, count, 0.8, (-half_width, -half_width), (half_width, half_width))
    goal = chance.uniform(-half_width, half_width, (count, 2))
    return replace(_scenario(60.0, start, goal), rule=endless_goals(seed, half_width), endless=True)


def corridor(half: int, seed: int) -> Scenario:
    """Two opposite streams of `half` agents in the 20 m of a corridor 4 m wide; their goals are 11 m ahead."""
    chance = np.random.default_rng(1000 + seed)
    spacing = min(0.9, 0.6 * float(np.sqrt(50.0 / half)))
    left = dart_throwing(chance, half, spacing, (-10.0, -1.65), (-1.0, 1.65))
    right = dart_throwing(chance, half, spacing, (1.0, -1.65), (10.0, 1.65))
    ahead = np.repeat([[11.0, 0.0], [-11.0, 0.0]], half, axis=0)
    start = np.concatenate([left, right])
    walls = np.array([[-12.0, side * 2.0, 12.0, side * 2.0] for side in (-1.0, 1.0)])
    return _scenario(60.0, start, start + ahead, walls)


def door(left: int, right: int, width: float, seed: int) -> Scenario:
    """Two rooms of 6 m x 6 m with a door of `width` [m] between them; all change rooms, `left` from the left one."""
    chance = np.random.default_rng(1000 + seed)
    start = np.concatenate([
        dart_throwing(chance, left, 0.7, (-5.5, -2.6), (-1.0, 2.6)),
        dart_throwing(chance, right, 0.7, (1.0, -2.6), (5.5, 2.6)),
    ])  # fmt: skip
    goal = np.concatenate([
        dart_throwing(chance, left, 0.7, (1.5, -2.6), (5.5, 2.6)),
        dart_throwing(chance, right, 0.7, (-5.5, -2.6), (-1.5, 2.6)),
    ])  # fmt: skip
    walls = [[0.0, side * width / 2.0, 0.0, side * 3.0] for side in (-1.0, 1.0)]
    walls += [[-6.0, side * 3.0, 6.0, side * 3.0] for side in (-1.0, 1.0)]
    walls += [[side * 6.0, -3.0, side * 6.0, 3.0] for side in (-1.0, 1.0)]
    reach = max(width / 2.0 - RADIUS - 0.05, 0.0)
    return replace(_scenario(120.0, start, goal, np.array(walls)), rule=through_door(goal, reach))


def one_point(count: int, seed: int) -> Scenario:
    """Agents anywhere on a stage are sent to its middle; only the first can stand there."""
    chance = np.random.default_rng(1000 + seed)
    start = dart_throwing(chance, count, 0.7, (-5.0, -4.0), (5.0, 4.0))
    return _scenario(40.0, start, np.zeros((count, 2)))


SCENARIOS: Final[dict[str, Callable[[int], Scenario]]] = {
    "headon-2": lambda _seed: opposite([(-4, 0), (4, 0)]),
    "sym-4": lambda _seed: opposite([(-4, 0), (4, 0), (0, -4), (0, 4)]),
    "circle-20": lambda seed: circle(20, 4.0, seed),
    "circle-50": lambda seed: circle(50, 8.0, seed),
    "circle-100": lambda seed: circle(100, 16.0, seed),
    "cross-50": lambda seed: cross(25, 0.90, seed),
    "cross-100": lambda seed: cross(50, 0.72, seed),
    "corridor-50": lambda seed: corridor(25, seed),
    "corridor-100": lambda seed: corridor(50, seed),
    "bottleneck-60": lambda seed: bottleneck(60, seed),
    "door-20-20": lambda seed: door(20, 20, 0.8, seed),
    "door-30-10": lambda seed: door(30, 10, 1.2, seed),
    "formation-hung": formation,
    "random-100": lambda seed: random_goals(100, seed),
}
"""Every scenario by name, made from a seed; the symmetric ones have one start."""
