"""Faces, fingers and feet of all dancers, all in close-up: their cost beside the poses of the same frames.

The pose pass is what a frame asks of the dancers: clips, transitions, feet, arms that keep off others.
"""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from bench._show import crowd
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.show.dancers import expression
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.show import Show

SHARE: Final = 0.1
"""Faces and fingers may cost so much of the pose pass, ..."""
ALL: Final = 0.15
"""... and feet that point as well."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Shares of the pose pass, and microseconds of a tick, for 50 and 200 dancers."""
    loaded, rows = load_show(DEFAULT_PATCH), []
    for dancers in (50, 200):
        spent = _spent(crowd(dancers, loaded), 64 * (24 if full else 8))
        poses = spent["pose"]
        faces, whole = spent["draw_expressions"] / poses, spent["show"] / poses
        rows += [
            Row(f"{dancers} dancers, faces and fingers, share of the pose pass", faces, "×", SHARE, "at most"),
            Row(f"{dancers} dancers, with pointed feet and Python, share", whole, "×", ALL, "at most"),
            Row(f"{dancers} dancers, decisions of a tick", spent["tick"] / 1e3, "µs", None, "at most"),
        ]
    return rows


def _spent(show: Show, ticks: int) -> dict[str, float]:
    """Nanoseconds of the parts of a frame and a tick, the lower quartile of each."""
    view, state = show.view(), show.expression
    view.detailed = True
    taken: dict[str, list[int]] = {}
    parts: tuple[tuple[Any, str], ...] = (
        (expression, "draw_expressions"), (show.dancers, "pose"), (state, "show"), (state, "tick"),
    )  # fmt: skip
    before = [(part, name, getattr(part, name)) for part, name in parts]
    try:
        for part, name, work in before:
            setattr(part, name, _timed(work, taken.setdefault(name, [])))
        for tick in range(1, ticks + 1):
            show.tick(tick * TICK)
            show.fill(view, tick * TICK)
    finally:
        for part, name, work in before:
            setattr(part, name, work)
    return {name: float(np.percentile(times[64:], 25)) for name, times in taken.items()}


def _timed(work: Callable[..., Any], times: list[int]) -> Callable[..., Any]:
    def timed(*args: Any, **named: Any) -> Any:
        begin = time.perf_counter_ns()
        done = work(*args, **named)
        times.append(time.perf_counter_ns() - begin)
        return done

    return timed
