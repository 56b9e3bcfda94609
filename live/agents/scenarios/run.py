"""Simulation of a scenario, tick by tick, without a show."""

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Avoidance, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.goals.goal_kernels import NO_SLOWING_RATE
from live.agents.goals.goals import Goals, WayPoints, crowded_out_agents, yielding_agents
from live.agents.scenarios.scenario import Scenario
from live.base.arrays import Float64

TICK = 1.0 / 64.0
APPROACH_GAIN = 1.0
"""Speed per metre of remaining distance [1/s] when agents slow down for their last goal."""
THRONG_GAP = 0.3
"""Bodies with less than this [m] between them form a throng; in it, agents at their goals give way."""
GIVE_WAY_INTERVAL = 8
"""Ticks between two updates of which agents give way."""


class Simulation:
    """One run of a scenario; the ticks do not depend on how they are requested."""

    def __init__(self, scenario: Scenario, *, avoidance: Avoidance = "predictive", seed: int = 0) -> None:
        self._scenario = scenario
        stage = scenario.stage
        self._middle = np.zeros(2) if stage is None else np.array([stage[0] + stage[2], stage[1] + stage[3]]) / 2.0
        sides = (None, None) if stage is None else ((stage[2] - stage[0]) / 2.0, (stage[3] - stage[1]) / 2.0)
        count = scenario.agent_count
        model = AgentModel(
            np.full(count, scenario.radius, np.float32),
            np.ones(count, np.float32),
            Steering(half_width=sides[0], half_depth=sides[1], avoidance=avoidance),
            seed,
        )
        self._advance = CrowdStepper(model)
        self._surroundings = Surroundings()
        walls = scenario.walls - np.tile(self._middle, 2)
        for number, (x1, z1, x2, z2) in enumerate(walls.tolist()):
            self._surroundings.set_wall(f"wall {number + 1}", x1, z1, x2, z2)
        self._state = AgentState.at_rest(scenario.start - self._middle)
        self._spare = AgentState.at_rest(scenario.start - self._middle)
        self._commands = AgentCommand(count)
        self._commands.speed[:] = scenario.max_speed
        self._way_points = WayPoints([way - self._middle for way in scenario.goals], walls, APPROACH_GAIN)
        self._goals = Goals(self._way_points.current, scenario.preferred_speed)
        self._way_points.begin(self._goals)
        self._rule = scenario.rule() if scenario.rule is not None else None
        self._targets = self._way_points.current + self._middle
        self._arrived = np.full(count, np.nan)
        self._gives_way = np.zeros(count, np.bool_)
        self._tick = 0
        self._record_arrivals()

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self._tick * TICK

    @property
    def position(self) -> Float64:
        """Positions of all agents [m], shape (A, 2)."""
        return self._state.position.astype(np.float64) + self._middle

    @property
    def arrived(self) -> Float64:
        """Time at which each agent was first within goal_radius of their last goal [s], NaN if not yet, shape (A,)."""
        return self._arrived.copy()

    def tick(self) -> None:
        """Advance by one tick."""
        scenario, wants = self._scenario, self._commands
        if self._rule is not None:
            self._rule(self.position, self._targets)
            self._goals.target[:] = self._targets - self._middle
            passing = (self._targets != scenario.last_goal).any(axis=1) & (not scenario.endless)
            self._goals.rate[:] = np.where(passing, NO_SLOWING_RATE, APPROACH_GAIN)
        else:
            gate = 3.0 * max(scenario.goal_radius, scenario.radius)
            self._way_points(self._goals, self._state.position, scenario.goal_radius, gate)
        if self._tick % GIVE_WAY_INTERVAL == 0:
            near = 2.0 * scenario.radius + THRONG_GAP
            self._gives_way = yielding_agents(self._state.position, ~np.isnan(self._arrived), near)
            self._gives_way |= crowded_out_agents(
                self._state.position, self._goals.target, scenario.radius, scenario.goal_radius
            )
        wants.clear()
        self._goals(wants, self._state.position, scenario.goal_radius)
        wants.velocity[self._gives_way] = 0.0
        self._advance(
            self._state, self._spare, commands=wants, surroundings=self._surroundings, time=self.time, dt=TICK
        )
        self._state, self._spare = self._spare, self._state
        self._tick += 1
        self._record_arrivals()

    def _record_arrivals(self) -> None:
        scenario = self._scenario
        if scenario.endless or scenario.agent_count == 0:
            return
        away = np.linalg.norm(self.position - scenario.last_goal, axis=1)
        there = (away <= scenario.goal_radius) & np.isnan(self._arrived)
        if self._rule is None:
            there &= self._way_points.heading_to_last
        self._arrived[there] = self.time


def ticks_in(duration: float) -> int:
    """Return the number of ticks that reach `duration` [s]."""
    return int(np.ceil(duration / TICK - 1e-9))


def simulate(
    scenario: Scenario, *, avoidance: Avoidance = "predictive", seed: int = 0, stop_when_settled: bool = False
) -> tuple[Float64, Float64, Float64]:
    """Run a scenario: time (T,) [s], position (T, A, 2) [m] with the start, arrival times (A,) [s], NaN if never.

    With `stop_when_settled` the run ends early when all agents are within 0.2 m of their last goals.
    """
    run = Simulation(scenario, avoidance=avoidance, seed=seed)
    ticks = ticks_in(scenario.duration)
    position = np.empty((ticks + 1, scenario.agent_count, 2))
    position[0] = run.position
    last = 0
    while last < ticks:
        run.tick()
        last += 1
        position[last] = run.position
        if stop_when_settled and last % 16 == 0 and not scenario.endless and _settled(scenario, position[last]):
            break
    time: Float64 = np.arange(last + 1, dtype=np.float64) * TICK
    return time, position[: last + 1], run.arrived


def _settled(scenario: Scenario, position: Float64) -> bool:
    return bool((np.linalg.norm(position - scenario.last_goal, axis=1) <= 0.2).all())
