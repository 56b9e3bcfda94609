"""The pose pipeline: sample two clips, blend by SLERP, place, forward kinematics; dancers per millisecond."""

import time
from pathlib import Path

import numpy as np

from live.cli.bench import Row
from live.motion.pose import PoseBuffer
from live.show.load import load_show
from live.show.patch_file import DEFAULT_PATCH


def run(full: bool, shared: Path | None) -> list[Row]:
    """One core, 22 joints, every dancer in the middle of a transition (the dear case) and outside one."""
    library = load_show(DEFAULT_PATCH).graph.library
    chance = np.random.default_rng(1)
    rows: list[Row] = []
    for dancers in (100, 1000, 10000) if full else (100, 1000):
        buffer = PoseBuffer(dancers)
        last = len(library.clip_root) - 1
        samples = [chance.uniform(0, last, dancers) for _ in range(2)]
        places = [chance.uniform(-5, 5, (dancers, 4)) for _ in range(2)]
        for name, weight in (("blending", 0.5), ("one clip", 0.0)):
            weights = np.full(dancers, weight)
            best = 1e9
            for _ in range(30 if dancers < 10000 else 8):
                begin = time.process_time_ns()
                buffer.sample(
                    library.clip_root,
                    library.clip_rotation,
                    sample_a=samples[0],
                    sample_b=samples[1],
                    weight=weights,
                    placement_a=places[0],
                    placement_b=places[1],
                )
                best = min(best, (time.process_time_ns() - begin) * 1e-6)
            rows.append(Row(f"{dancers} dancers, {name}", dancers / best, "dancers/ms", sense="at least"))
    return rows
