"""Steering: agent updates per second of the crowd with everything on, against pyrvo in the same run, one thread."""

import math
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench._peers import absence, installed
from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.goals.goal_kernels import ATTRACT
from live.agents.goals.goals import Goals
from live.cli.bench import Row

TICK = 1.0 / 120.0
DENSITY = 0.5
RADIUS = 0.25
SPEED = 1.5
REACH = 0.5
Float64 = npt.NDArray[np.float64]


class Crowd:
    """The workload of all engines: half an agent per square metre, each drawn to an attractor of its own.

    About 14 neighbours within 3 m; separation under 1.5 m, alignment and cohesion, predicted collisions, stage edges.
    """

    def __init__(self, agents: int) -> None:
        self._half = 0.5 * math.sqrt(agents / DENSITY)
        self._chance = np.random.default_rng(1)
        self._advance = CrowdStepper(
            AgentModel(
                np.full(agents, RADIUS, np.float32),
                np.ones(agents, np.float32),
                Steering(half_width=self._half, half_depth=self._half),
                seed=1,
            )
        )
        self._state, self._spare = AgentState.at_rest(self._places(agents)), AgentState(agents)
        self._wants, self._surroundings = AgentCommand(agents), Surroundings()
        self._goals = Goals(self._places(agents), SPEED, law=ATTRACT, rate=1.0)
        self._wants.speed[:] = SPEED
        self._wants.separation[:] = 1.5
        self._wants.alignment[:] = 0.3
        self._wants.cohesion[:] = 0.1
        self._time = 0.0

    def _places(self, count: int) -> Float64:
        return self._chance.uniform(-self._half, self._half, (count, 2))

    def tick(self) -> None:
        """One tick: goals, and the advance of all."""
        reached = self._goals(self._wants, self._state.position, REACH)
        if len(reached):
            self._goals.target[reached] = self._places(len(reached))
        self._advance(
            self._state, self._spare, commands=self._wants, surroundings=self._surroundings, time=self._time, dt=TICK
        )
        self._state, self._spare = self._spare, self._state
        self._time += TICK


class Peer:
    """The same workload in pyrvo; only what its user cannot do without is timed: positions, velocities, its step."""

    def __init__(self, agents: int) -> None:
        import pyrvo

        self._half = 0.5 * math.sqrt(agents / DENSITY)
        self._chance = np.random.default_rng(1)
        self._simulator = pyrvo.RVOSimulator(TICK, 3.0, 10, 1.5, 1.5, RADIUS, SPEED)
        for x, z in self._places(agents):
            self._simulator.add_agent((float(x), float(z)))
        self._goals = self._places(agents)
        self.spent = 0.0

    def _places(self, count: int) -> Float64:
        return self._chance.uniform(-self._half, self._half, (count, 2))

    def tick(self) -> None:
        """One step; `spent` grows by the time [s] that getters, setters and the step take."""
        simulator, count = self._simulator, len(self._goals)
        begin = time.thread_time_ns()
        positions = [simulator.get_agent_position(i) for i in range(count)]
        self.spent += (time.thread_time_ns() - begin) * 1e-9
        way = self._goals - np.array([(p.x, p.y) for p in positions])
        distance = np.hypot(way[:, 0], way[:, 1])
        reached = distance < REACH
        self._goals[reached] = self._places(int(reached.sum()))
        wish = (way * (SPEED * (1.0 - np.exp(-distance)) / np.maximum(distance, 1e-9))[:, None]).tolist()
        begin = time.thread_time_ns()
        for i in range(count):
            simulator.set_agent_pref_velocity(i, (wish[i][0], wish[i][1]))
        simulator.do_step()
        self.spent += (time.thread_time_ns() - begin) * 1e-9


def _best(crowd: Crowd, ticks: int, turns: int) -> float:
    """Time of this thread for a tick [s]: the best of several runs, after the crowd has spread."""
    for _ in range(ticks):
        crowd.tick()
    best = math.inf
    for _ in range(turns):
        begin = time.thread_time_ns()
        for _ in range(ticks):
            crowd.tick()
        best = min(best, (time.thread_time_ns() - begin) * 1e-9 / ticks)
    return best


def _best_of_peer(agents: int, ticks: int, turns: int) -> float:
    peer = Peer(agents)
    for _ in range(ticks):
        peer.tick()
    best = math.inf
    for _ in range(turns):
        peer.spent = 0.0
        for _ in range(ticks):
            peer.tick()
        best = min(best, peer.spent / ticks)
    return best


def run(full: bool, shared: Path | None) -> list[Row]:
    """Ticks of 50 to 20,000 agents; the ratio to pyrvo with 2,000; how the cost of an agent grows with their number."""
    turns = 15 if full else 7
    spent = {
        agents: _best(Crowd(agents), max(10, 100_000 // agents // 2), turns) for agents in (50, 500, 2000, 10000, 20000)
    }
    peers: dict[str, float] = {}
    ratio = None
    if installed("pyrvo"):
        peer = _best_of_peer(2000, 10, turns)
        peers, ratio = {"pyrvo: tick [µs]": peer * 1e6}, peer / spent[2000]
    rows = [
        Row("2000 agents: times as fast as pyrvo", ratio, "1", 27.0, "at least", peers, absence("pyrvo")),
        Row("50 agents: tick", spent[50] * 1e6, "µs", bar=10.0),
        Row("an agent of 20000 : one of 2000", spent[20000] / spent[2000] / 10.0, "1", bar=1.3),
    ]
    for agents, seconds in spent.items():
        rows.append(Row(f"{agents} agents: updates", agents / seconds, "1/s", sense="at least"))
        rows.append(Row(f"{agents} agents: tick", seconds * 1e6, "µs"))
    return rows
