"""RVO2 (ORCA, van den Berg et al. 2011) on the crowd scenarios, through pyrvo: the peer of the crowd bench."""

import numpy as np

from live.agents.scenarios.scenario import Scenario
from live.base.arrays import Float64

TICK = 1.0 / 120.0
HORIZONS = (0.5, 2.0, 5.0)
"""Time horizons [s]; RVO2 does best with a different one in each scenario, so all are tried."""
PERTURBATION = 1e-4
"""Speed [m/s] of the perturbation that RVO2's own examples add against perfect symmetry."""


def simulate(scenario: Scenario, horizon: float, seed: int) -> tuple[Float64, Float64]:
    """Run RVO2: times (T,) [s] at 60 Hz and positions (T, A, 2) [m], until all are within 0.2 m or the time is up."""
    import pyrvo

    sim = pyrvo.RVOSimulator(
        TICK, 10.0 if horizon >= 5.0 else 5.0, 10, horizon, min(horizon, 1.0), scenario.radius, scenario.max_speed
    )
    for x, z in scenario.start:
        sim.add_agent((float(x), float(z)))
    for x1, z1, x2, z2 in scenario.walls:
        sim.add_obstacle([(float(x1), float(z1)), (float(x2), float(z2))])
    sim.process_obstacles()
    chance = np.random.default_rng([7, seed])
    position, goal = scenario.start.copy(), scenario.last_goal
    rule = scenario.rule() if scenario.rule is not None else None
    times, frames = [0.0], [position.copy()]
    for tick in range(1, round(scenario.duration / TICK) + 1):
        if rule is not None:
            rule(position, goal)
        wish = goal - position
        distance = np.linalg.norm(wish, axis=1, keepdims=True)
        wish *= np.minimum(1.0, scenario.preferred_speed / np.maximum(distance, 1e-9))
        angle, length = chance.uniform(0, 2 * np.pi, len(wish)), chance.uniform(0, PERTURBATION, len(wish))
        wish += np.stack([np.cos(angle), np.sin(angle)], axis=1) * length[:, None]
        for agent, velocity in enumerate(wish.tolist()):
            sim.set_agent_pref_velocity(agent, velocity)
        sim.do_step()
        for agent in range(len(position)):
            place = sim.get_agent_position(agent)
            position[agent, 0], position[agent, 1] = place.x, place.y
        if tick % 2 == 0:
            times.append(tick * TICK)
            frames.append(position.copy())
            if not scenario.endless and (np.linalg.norm(scenario.last_goal - position, axis=1) <= 0.2).all():
                break
    return np.array(times), np.array(frames)
