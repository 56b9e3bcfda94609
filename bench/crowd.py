"""Crowds: does everybody arrive, without overlaps, and how smoothly, beside RVO2 on the same scenarios."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench._crowd_rows import GAP_SECONDS, Peer, quality_rows, thesis_rows
from bench._crowd_rvo2 import HORIZONS
from bench._crowd_rvo2 import simulate as simulate_rvo2
from bench._peers import installed
from live.agents.crowd.agent_state import Avoidance
from live.agents.scenarios.generate import SCENARIOS, one_point
from live.agents.scenarios.metrics import Metrics, measure
from live.agents.scenarios.run import simulate
from live.agents.scenarios.scenario import Scenario
from live.cli.bench import Row

SEEDS = 3
SYMMETRIC = ("headon-2", "sym-4")
"""These have one start: another seed is the same run."""
QUICK = (*SYMMETRIC, "circle-20", "cross-50", "formation-hung")
"""What RVO2 is run on when there is a minute; our crowd runs on all scenarios even then."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Rows of every scenario; in the quick form RVO2 runs on the small ones only, and the large ones with one seed."""
    rows = []
    for name in SCENARIOS:
        compared = full or name in QUICK
        seeds = range(SEEDS if compared else 1)
        starts = seeds[:1] if name in SYMMETRIC else seeds
        ours = [_ours(name, seed, "predictive") for seed in starts]
        peers = []
        if installed("pyrvo") and compared:  # RVO2's perturbation has a seed even where the start has none
            peers = [Peer(horizon, [_rvo2(name, horizon, seed) for seed in seeds]) for horizon in HORIZONS]
        rows += quality_rows(name, ours, peers)
        if compared:
            rows += thesis_rows(name, [_ours(name, seed, "thesis") for seed in starts])
    moved = max(_moved_at_one_point(40, seed) for seed in range(SEEDS))
    rows.append(Row("one-point-40: farthest move in the last of 30 seconds", moved, "m", 0.01))
    return rows


def _moved_at_one_point(count: int, seed: int) -> float:
    """How far the restless one of `count` agents sent to one point still goes [m] in the last second of 30."""
    _, position, _ = simulate(replace(one_point(count, seed), duration=30.0), seed=seed)
    return float(np.linalg.norm(position[-1] - position[-65], axis=1).max())


def _ours(name: str, seed: int, avoidance: Avoidance) -> Metrics:
    scenario = _scenario(name, seed)
    time, position, _ = simulate(scenario, avoidance=avoidance, seed=seed, stop_when_settled=True)
    return measure(scenario, time, position)


def _rvo2(name: str, horizon: float, seed: int) -> Metrics:
    scenario = _scenario(name, seed)
    return measure(scenario, *simulate_rvo2(scenario, horizon, seed))


def _scenario(name: str, seed: int) -> Scenario:
    scenario = SCENARIOS[name](seed)
    return replace(scenario, duration=GAP_SECONDS) if name.startswith("bottleneck") else scenario
