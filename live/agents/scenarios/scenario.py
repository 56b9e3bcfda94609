"""Scenario: starts and goals of agents, walls, duration, and rules that change goals during a run."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from live.base.arrays import Float64

Rule = Callable[[Float64, Float64], None]
"""Called before each tick with positions (A, 2) [m] and targets (A, 2) [m]; it may change the targets in place."""


@dataclass(frozen=True, slots=True, eq=False)
class Scenario:
    """A agents with radii and goals; metres, seconds; points are (x, z)."""

    duration: float
    """Duration of the run [s]."""
    radius: float
    """Body radius of all agents [m]."""
    preferred_speed: float
    """Speed at which agents walk without obstruction [m/s]."""
    max_speed: float
    """Maximum speed [m/s]."""
    goal_radius: float
    """An agent that has been within this distance of their last goal has arrived [m]."""
    start: Float64
    """Positions at time 0, at rest [m], shape (A, 2)."""
    goals: tuple[Float64, ...]
    """For each agent the points to go to in order [m], shapes (K, 2), K >= 1."""
    stage: tuple[float, float, float, float] | None = None
    """The rectangle x0, z0, x1, z1 [m] that confines the agents; None: the plane."""
    walls: Float64 = field(default_factory=lambda: np.zeros((0, 4)))
    """Wall segments x1, z1, x2, z2 [m], shape (W, 4)."""
    rule: Callable[[], Rule] | None = None
    """Makes, for each run, the rule that changes targets; None: the goals are fixed."""
    endless: bool = False
    """Whether goals are redrawn without end, so that no agent arrives."""

    @property
    def agent_count(self) -> int:
        """Number of agents A."""
        return len(self.start)

    @property
    def last_goal(self) -> Float64:
        """Final goals [m], shape (A, 2)."""
        return np.array([way[-1] for way in self.goals]).reshape(-1, 2)

    @property
    def straight_distance(self) -> Float64:
        """Length of the path from the start through all goals [m], shape (A,)."""
        ways = (np.vstack([start, way]) for start, way in zip(self.start, self.goals, strict=True))
        return np.array([np.linalg.norm(np.diff(way, axis=0), axis=1).sum() for way in ways]).reshape(-1)


def through_gap(goal: Float64) -> Callable[[], Rule]:
    """Return a rule that leads out of a room through a gap about (4, 0) to (4.4, 0), then to `goal` (A, 2) [m].

    x < 3.6: aim at (3.8, z within ±0.3); 3.6 <= x < 4.45: at (4.6, z within ±0.3); else at the goal.
    """

    def rule(position: Float64, target: Float64) -> None:
        x, z = position.T
        inside, in_gap = x < 3.6, x < 4.45
        target[:] = goal
        target[in_gap, 0] = np.where(inside, 3.8, 4.6)[in_gap]
        target[in_gap, 1] = np.clip(z, -0.3, 0.3)[in_gap]

    return lambda: rule


def through_door(goal: Float64, reach: float) -> Callable[[], Rule]:
    """Return a rule that leads through a door in the wall x = 0 in both directions, then to `goal` (A, 2) [m].

    Agents on the other side of the wall than their goal aim just behind the door, within ±`reach` [m] of its middle.
    """
    side = np.sign(goal[:, 0])

    def rule(position: Float64, target: Float64) -> None:
        before = position[:, 0] * side < 0.1
        target[:] = goal
        target[before, 0] = 0.3 * side[before]
        target[before, 1] = np.clip(position[before, 1], -reach, reach)

    return lambda: rule


def endless_goals(seed: int, half_width: float, reach: float = 0.3) -> Callable[[], Rule]:
    """Return a rule that gives a new goal, uniform in ±`half_width` [m], to each agent within `reach` [m] of theirs.

    Each agent has its own random stream, so its goals do not depend on the arrival of others.
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
