"""Goals of the agents, written as steering commands; way points are goals taken in order.

Agents at their goal give way if they block agents that have not arrived.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import AgentCommand
from live.agents.goals.goal_kernels import ARRIVE, NO_SLOWING_RATE, advance_way_points, seek_goals
from live.base.arrays import Float32, Float64, Int32

ARRIVAL_RATE: Final = 1.0
"""Speed per metre of remaining distance [1/s] near a goal, under ARRIVE."""
CROWD_GAP: Final = 0.12
"""Bodies with at most this [m] between them stand next to each other."""
SAME_TARGET: Final = 1e-3
"""Targets less than this apart are one [m]."""
NO_WALLS: Final = np.zeros((0, 4))


class Goals:
    """One goal for each of A agents; the caller may change `target`, `preferred` and `rate` at any time."""

    def __init__(
        self,
        target: npt.ArrayLike,
        preferred: float | Float64 | Float32,
        *,
        law: int = ARRIVE,
        rate: float = ARRIVAL_RATE,
    ) -> None:
        """`target` (A, 2) [m]; `preferred` speed [m/s], one number or (A,); `law` and `rate` as in `goal_kernels`."""
        self.target: Float32 = np.array(target, np.float32, order="C").reshape(-1, 2)
        self.preferred: Float32 = np.zeros(len(self.target), np.float32)
        self.preferred[:] = preferred
        self.law = law
        self.rate: Float32 = np.full(len(self.target), rate, np.float32)
        self._reached: Int32 = np.zeros(len(self.target), np.int32)
        self._factor: Float32 = np.zeros(len(self.target), np.float32)

    def __call__(self, commands: AgentCommand, position: Float32, reach: float = 0.3) -> Int32:
        """Write `wants.velocity` for all; return the indices of the agents within `reach` [m] of their targets.

        The result is a view that the next call overwrites.
        """
        count = seek_goals(
            commands.rows,
            self._reached,
            self._factor,
            position,
            self.target,
            self.preferred,
            self.rate,
            self.law,
            reach,
        )
        return self._reached[:count]


class WayPoints:
    """Paths of A agents, each through one or more points in order; agents stay at the last one."""

    def __init__(self, ways: Sequence[npt.ArrayLike], walls: Float64 = NO_WALLS, rate: float = ARRIVAL_RATE) -> None:
        """`ways`: the points (K, 2) [m] of each agent, K >= 1; `walls` (W, 4) [m] block the way to a next point;
        `rate`: slowing down for the last point, as in `Goals`.
        """
        points = [np.asarray(way, np.float64).reshape(-1, 2) for way in ways]
        if any(len(way) == 0 for way in points):
            raise ValueError("every path needs at least one point")
        self._points: Float64 = np.concatenate([np.zeros((0, 2)), *points])
        self._start: Int32 = np.concatenate([[0], np.cumsum([len(way) for way in points])]).astype(np.int32)
        self._walls: Float64 = np.ascontiguousarray(walls, np.float64)
        self._rate = rate
        self.at: Int32 = self._start[:-1].copy()

    @property
    def current(self) -> Float64:
        """Current way point of each agent [m], shape (A, 2)."""
        return self._points[self.at]

    @property
    def heading_to_last(self) -> npt.NDArray[np.bool_]:
        """Whether each agent is on the way to its last point, shape (A,)."""
        there: npt.NDArray[np.bool_] = self.at == self._start[1:] - 1
        return there

    def begin(self, goals: Goals) -> None:
        """Set each agent's first point as its goal; `goals.rate` is managed from now on, too."""
        self.at[:] = self._start[:-1]
        goals.target[:] = self.current
        goals.rate[:] = np.where(self.heading_to_last, self._rate, NO_SLOWING_RATE)

    def __call__(self, goals: Goals, position: Float32, reach: float, gate: float) -> None:
        """Set the next way point as goal for agents at or past the current one (see `advance_way_points`)."""
        advance_way_points(
            goals.target, goals.rate, self.at, position, self._points, self._start, self._walls, reach, gate, self._rate
        )


Bools = npt.NDArray[np.bool_]


def _clusters(position: npt.NDArray[np.floating], near: float, target: npt.NDArray[np.floating] | None = None) -> Int32:
    """Return the number of each agent's cluster, shape (A,): connected by distances of at most `near` [m].

    `target` (A, 2): only agents with the same target are connected.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(position).query_pairs(near, output_type="ndarray")
    if target is not None:
        pairs = pairs[np.linalg.norm(target[pairs[:, 0]] - target[pairs[:, 1]], axis=1) < SAME_TARGET]
    links = coo_array((np.ones(len(pairs), np.bool_), (pairs[:, 0], pairs[:, 1])), shape=(len(position),) * 2)
    numbers: Int32 = connected_components(links, directed=False)[1]
    return numbers


def yielding_agents(position: npt.NDArray[np.floating], arrived: Bools, near: float) -> Bools:
    """Return which of the `arrived` (A,) agents belong to a cluster with an agent that has not arrived, shape (A,).

    A cluster is connected by distances of at most `near` [m]; so agents in the back rows make room for those in front.
    """

    count = len(position)
    if count < 2 or arrived.all() or not arrived.any():
        return np.zeros(count, np.bool_)
    throng = _clusters(position, near)
    pressed = np.zeros(count, np.bool_)
    pressed[throng[~arrived]] = True
    there: Bools = arrived & pressed[throng]
    return there


def crowded_out_agents(
    position: npt.NDArray[np.floating], target: npt.NDArray[np.floating], radius: float, reach: float
) -> Bools:
    """Return which agents stand in a crowd around a target that others of it occupy, shape (A,).

    A target is occupied by an agent within `reach` [m] of it. Agents with the same target who stand next to that
    agent, or to another one of the crowd, cannot come nearer: they have arrived as far as possible.
    """
    there: Bools = np.linalg.norm(position - target, axis=1) <= reach
    shared: Bools = np.zeros(len(position), np.bool_)
    if not there.any() or there.all():
        return shared
    crowd = _clusters(position, 2.0 * radius + CROWD_GAP, target)
    shared[np.isin(crowd, crowd[there]) & ~there] = True
    return shared
