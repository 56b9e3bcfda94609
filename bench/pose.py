"""The pose pipeline: sample two clips, blend by SLERP, place, forward kinematics; dancers per millisecond."""

import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

from live.cli.bench import Row
from live.graph.library import StepLibrary
from live.motion import quaternion
from live.motion.forward import forward_kinematics
from live.motion.pose import PoseBuffer
from live.show.load import load_show
from live.show.patch_file import DEFAULT_PATCH

Float64 = npt.NDArray[np.float64]


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
            peers = {"vectorised numpy": _numpy(library, samples, dancers)} if weight else {}
            rows.append(Row(f"{dancers} dancers, {name}", dancers / best, "dancers/ms", sense="at least", peers=peers))
    return rows


def _numpy(library: StepLibrary, samples: list[Float64], dancers: int) -> float:
    """The same job in plain numpy, all dancers at once: dancers per millisecond, the best of some runs."""
    best = 1e9
    for _ in range(5):
        begin = time.process_time_ns()
        parts = []
        for at in samples:
            low = at.astype(np.int64)
            t = (at - low).astype(np.float32)[:, None]
            a, b = library.clip_rotation[low], library.clip_rotation[low + 1]
            parts.append((quaternion.slerp(a, b, t), library.clip_root[low]))
        half = np.full((dancers, 1), 0.5, np.float32)
        turned = quaternion.slerp(parts[0][0], parts[1][0], half)
        forward_kinematics(0.5 * (parts[0][1] + parts[1][1]), turned)
        best = min(best, (time.process_time_ns() - begin) * 1e-6)
    return dancers / best
