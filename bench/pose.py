"""The pose pipeline at 31 joints: two clips sampled, SLERP, warp, amplitude; with heads and feet; dancers per ms."""

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench._peers import absence, installed
from live.cli.bench import Row
from live.motion import quaternion
from live.motion.editing.time_warp import MeasureWarps, draw_measure_warps
from live.motion.pose.pipeline_kernels import INTO_NEXT, NEXT, PRESENT
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline, PoseSkeleton
from live.motion.skeleton import SKELETON
from live.show.stages.row_threads import row_threads

Float64 = npt.NDArray[np.float64]

SAMPLES = 60 * 128
"""Samples of motion at 60 Hz: 64 measures of two seconds."""
MEASURE = 120.0
REALISTIC, AMBITIOUS = 12.0, 24.0
"""How many times the batched numpy of upc-pymotion: what the field calls good, and what we aim for."""
WITH_FEET = 1000.0
"""Dancers per millisecond with heads and feet."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Throughput of one core and of two threads; the peer does less: no amplitude, no warp, no heads, no feet."""
    store, skeleton = _motion(), _skeleton()
    rows: list[Row] = []
    for dancers in (100, 1000, 10000):
        repeats = (200 if full else 60) if dancers < 10000 else (20 if full else 8)
        plain, edited = _Crowd(store, skeleton, dancers), _Crowd(store, skeleton, dancers, heads_and_feet=True)
        peer = _pymotion(plain, repeats // 4)
        speed = _speed(plain.frame, dancers, repeats)
        peers = {} if peer is None else {"upc-pymotion, numpy, SLERP and forward kinematics": peer}
        rows.append(
            Row(f"{dancers} dancers, SLERP, amplitude, warp", speed, "dancers/ms", sense="at least", peers=peers)
        )
        with_feet = _speed(edited.frame, dancers, repeats)
        bar = WITH_FEET if dancers == 1000 else None
        rows.append(Row(f"{dancers} dancers, and head and feet", with_feet, "dancers/ms", bar, "at least", peers))
        bar, ratio = REALISTIC if dancers == 1000 else None, None if peer is None else speed / peer
        rows.append(
            Row(f"{dancers} dancers, times upc-pymotion", ratio, "×", bar, "at least", note=absence("upc-pymotion"))
        )
        with row_threads(2):
            two = _speed(plain.frame, dancers, repeats, wall=True)
        rows.append(Row(f"{dancers} dancers, two threads", two, "dancers/ms", sense="at least"))
    return rows


class _Crowd:
    """Dancers in the middle of transitions (the dear case), each somewhere else in the motion, each varied."""

    def __init__(self, store: ClipStore, skeleton: PoseSkeleton, dancers: int, *, heads_and_feet: bool = False) -> None:
        chance = np.random.default_rng(1)
        self.store, self.dancers = store, dancers
        self.pipeline = PosePipeline(dancers, skeleton)
        self.pipeline.placement[:] = chance.uniform(-5, 5, (4, dancers, 4))
        self.pipeline.placement[..., 3] = self.pipeline.placement[..., 2]
        self.pipeline.share[INTO_NEXT] = chance.uniform(0.01, 0.99, dancers)
        self.pipeline.amplitude[:] = chance.choice([0.8, 1.2], dancers)
        self.pipeline.mean[:] = chance.integers(0, len(store.mean), (2, dancers))
        self.measure = MEASURE * chance.integers(0, len(store.mean) - 1, (2, dancers))
        self.warps: MeasureWarps = draw_measure_warps(chance, dancers)
        self.phase = chance.uniform(0.0, 1.0, dancers)
        if heads_and_feet:
            self.pipeline.head[:] = 1.0
            self.pipeline.feet[:, :, :2] = chance.normal(0.0, 0.05, (dancers, 2, 2))
            self.pipeline.lock = True

    def frame(self) -> None:
        """What one frame does: warp the phases, ask for all poses."""
        phase = self.warps.phase(self.phase)
        self.pipeline.sample[PRESENT] = self.measure[0] + MEASURE * phase
        self.pipeline.sample[NEXT] = self.measure[1] + MEASURE * phase
        self.pipeline.run(self.store)


def _motion() -> ClipStore:
    """Smooth motion of 31 joints, up to 0.9 rad about a pose, and the mean pose of each measure."""
    chance = np.random.default_rng(2)
    seconds = np.arange(SAMPLES)[:, None, None] / 60.0
    waves = [
        np.sin(2 * math.pi * (rate * seconds + chance.uniform(0, 1, (1, 31, 3)))) for rate in (0.25, 0.5, 1.0, 2.0)
    ]
    turns = 0.15 * sum(waves) + 1e-6
    around = quaternion.unit(chance.normal(0, 1, (31, 4)))
    size = np.linalg.norm(turns, axis=-1)
    rotation = quaternion.mul(around, quaternion.from_axis_angle(turns / size[..., None], size))
    root = np.zeros((SAMPLES, 3), np.float32)
    root[:, 1] = 0.93
    mean = np.repeat(around[None], int(SAMPLES // MEASURE), axis=0)
    return ClipStore.of(root, rotation.astype(np.float32), mean.astype(np.float32))


def _skeleton() -> PoseSkeleton:
    """The engine's skeleton with nine joints more in the hands: 31, as the peers' bench has."""
    own = PoseSkeleton.whole()
    more, first = 9, int(own.legs[0])
    hands = [SKELETON.index("leftHand")] * 5 + [SKELETON.index("rightHand")] * 4
    moved = np.where(own.parents >= first, own.parents + more, own.parents)
    body = own.body.copy()
    body[1] += more
    return PoseSkeleton(
        offsets=np.insert(own.offsets, [first] * more, np.array((0.05, 0.0, 0.02), np.float32), axis=0),
        parents=np.concatenate([moved[:first], hands, moved[first:]]).astype(np.int32),
        body=body,
        legs=(own.legs + more).astype(np.int32),
    )


def _speed(frame: Callable[[], None], dancers: int, repeats: int, *, wall: bool = False) -> float:
    """Dancers per millisecond, the best of `repeats` runs; processor time of one thread, or wall time of several."""
    clock = time.perf_counter_ns if wall else time.process_time_ns
    best = math.inf
    for _ in range(repeats):
        begin = clock()
        frame()
        best = min(best, (clock() - begin) * 1e-6)
    return dancers / best


def _pymotion(crowd: _Crowd, repeats: int) -> float | None:
    """The same crowd in upc-pymotion's numpy, both clips at whole samples; None where it is not installed."""
    if not installed("upc-pymotion"):
        return None
    from pymotion.ops.skeleton import fk
    from pymotion.rotations.quat import slerp

    skeleton, store = crowd.pipeline.skeleton, crowd.store
    offsets, parents = skeleton.offsets.astype(np.float32), np.maximum(skeleton.parents, 0)
    one, other = (crowd.measure + MEASURE * crowd.phase).astype(np.int64)
    share = crowd.pipeline.share[INTO_NEXT][:, None, None]

    def frame() -> None:
        fk(slerp(store.rotation[one], store.rotation[other], share), store.root[one], offsets, parents)

    return _speed(frame, crowd.dancers, max(repeats, 5))
