"""Steering: agent updates per second with attractors, a repulsor, separation and avoidance, one thread."""

import math
import time
from pathlib import Path

import numpy as np

from live.agents.advance import Advance
from live.agents.elements import ATTRACTOR, REPULSOR, SPREADER, Element, ElementField
from live.agents.model import AgentModel, AgentState, Steering
from live.cli.bench import Row

TICK = 1.0 / 64.0


def run(full: bool, shared: Path | None) -> list[Row]:
    """Half an agent per square metre, as on a stage; the best of several runs of a hundred ticks."""
    rows: list[Row] = []
    for agents in (50, 500, 2000, 10000) if full else (50, 500, 2000):
        side = math.sqrt(agents / 0.5)
        chance = np.random.default_rng(1)
        model = AgentModel(
            np.full(agents, 0.25, np.float32), Steering(half_width=side / 2, half_depth=side / 2), seed=1
        )
        state = AgentState.at(chance.uniform(-side / 2, side / 2, (agents, 2)))
        spare = AgentState.at(np.zeros((agents, 2)))
        field = ElementField()
        for kind, x in ((ATTRACTOR, 0.3), (ATTRACTOR, -0.3), (REPULSOR, 0.0), (SPREADER, 0.0)):
            field.add(Element(kind, x * side, 0.0, 1.0, 0.0, 1e9))
        field.refresh(10.0)
        advance = Advance(model)
        speed = np.full(agents, 1.2, np.float32)
        best = 1e9
        for turn in range(5):
            begin = time.process_time_ns()
            for tick in range(100):
                now = (turn * 100 + tick) * TICK
                advance(state, spare, speed=speed, dancer=state.position, field=field, time=now, dt=TICK)
                state, spare = spare, state
            best = min(best, (time.process_time_ns() - begin) * 1e-9 / 100)
        rows.append(Row(f"{agents} agents: updates", agents / best, "1/s", sense="at least"))
        rows.append(Row(f"{agents} agents: tick", best * 1e6, "µs"))
    return rows
