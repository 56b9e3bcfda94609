"""Rules that change goals while a scenario runs: through a gap, and on to a new place for ever."""

from collections.abc import Callable

import numpy as np

from live.agents.scenarios.scenario import Float64, Rule


def through_gap(goal: Float64) -> Callable[[], Rule]:
    """Out of a room through a gap about (4, 0) to (4.4, 0), then to `goal` (A, 2) [m].

    x < 3.6: aim at (3.8, z within ±0.3); 3.6 <= x < 4.45: at (4.6, z within ±0.3); else at the goal.
    """

    def rule(position: Float64, target: Float64) -> None:
        x, z = position.T
        inside, in_gap = x < 3.6, x < 4.45
        target[:] = goal
        target[in_gap, 0] = np.where(inside, 3.8, 4.6)[in_gap]
        target[in_gap, 1] = np.clip(z, -0.3, 0.3)[in_gap]

    return lambda: rule


def ever_on(seed: int, half_width: float, reach: float = 0.3) -> Callable[[], Rule]:
    """A new goal, uniform in the square of ±`half_width` [m], for whoever is within `reach` [m] of hers.

    Each agent draws from a stream of her own, so that her goals depend on nobody else's arrival.
    """

    def make() -> Rule:
        streams: dict[int, np.random.Generator] = {}

        def rule(position: Float64, target: Float64) -> None:
            there = np.flatnonzero(np.linalg.norm(target - position, axis=1) <= reach)
            for agent in map(int, there):
                if agent not in streams:
                    streams[agent] = np.random.default_rng([1000 + seed, agent])
                target[agent] = streams[agent].uniform(-half_width, half_width, 2)

        return rule

    return make
