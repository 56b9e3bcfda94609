"""Formations: milliseconds to make the places, by shape and pattern; transformed groups and their neighbours."""

import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import shapely

from bench._material import FIRST_SEED, material_rows
from live.agents.formations.drawing import drawing_of
from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from live.cli.bench import Row

HEART = "M 0 3 C -5 -1 -2 -4 0 -1.5 C 2 -4 5 -1 0 3 Z"
TABLES: dict[str, dict[str, Any]] = {
    "circle, even": {"shape": "circle"},
    "star, even": {"shape": "star"},
    "text, even": {"shape": "text", "text": "LIVE"},
    "line, weighted": {"shape": "line", "weights": [1, 4, 1]},
    "circle, grid": {"shape": "circle", "pattern": "grid"},
    "circle, diagonal": {"shape": "circle", "pattern": "diagonal"},
    "circle, concentric": {"shape": "circle", "pattern": "concentric"},
    "circle, Poisson disk": {"shape": "circle", "pattern": "poisson"},
    "circle, even inside": {"shape": "circle", "dancers": "inside"},
    "circle, weighted inside": {"shape": "circle", "dancers": "inside", "focus": [0, 2]},
    "circle, Poisson disk, mirrored": {"shape": "circle", "pattern": "poisson", "mirror": "left-right"},
    "heart, grid": {"shape": "path", "path": HEART, "pattern": "grid"},
    "heart, concentric": {"shape": "path", "path": HEART, "pattern": "concentric"},
    "heart, Poisson disk": {"shape": "path", "path": HEART, "pattern": "poisson"},
}
BAR_50_MS = 5.0


def run(full: bool, shared: Path | None) -> list[Row]:
    """Processor time of one formation whose shape and count have been seen before, as when it is called live again."""
    rows: list[Row] = []
    for dancers in (50, 200, 1000) if full else (50, 200):
        for name, table in TABLES.items():
            milliseconds = _milliseconds(table, dancers)
            bar = BAR_50_MS if dancers == 50 else None
            peers = {"dart throwing": _thrown(table, dancers)} if name == "circle, Poisson disk" else {}
            rows.append(Row(f"{dancers} dancers: {name}", milliseconds, "ms", bar, peers=peers))
    return rows + material_rows(range(FIRST_SEED, FIRST_SEED + (40 if full else 4)))


def _milliseconds(table: dict[str, Any], dancers: int) -> float:
    spec = spec_from_table(table)
    formation_of(spec, dancers, 0)
    return _median(lambda seed: formation_of(spec, dancers, seed))


def _median(make: Any) -> float:
    took = []
    for seed in range(15):
        begin = time.process_time_ns()
        make(seed)
        took.append((time.process_time_ns() - begin) * 1e-6)
    return median(took)


def _thrown(table: dict[str, Any], dancers: int) -> float:
    """The same by dart throwing with a radius that shrinks until all find room (numpy and shapely)."""
    region = drawing_of(spec_from_table(table)).region
    low_x, low_z, high_x, high_z = region.bounds

    def throw(seed: int) -> None:
        chance = np.random.default_rng(seed)
        radius = 0.75 * float(np.sqrt(2.0 * region.area / (np.sqrt(3.0) * dancers)))
        placed = np.zeros((0, 2))
        while len(placed) < dancers:
            darts = chance.uniform((low_x, low_z), (high_x, high_z), (50, 2))
            for dart in darts[shapely.contains_xy(region, darts[:, 0], darts[:, 1])]:
                if len(placed) < dancers and (((placed - dart) ** 2).sum(axis=1) >= radius**2).all():
                    placed = np.concatenate([placed, dart[None]])
            radius *= 0.98

    return _median(throw)
