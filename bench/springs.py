"""Springs of characters: milliseconds a tick for dancers with 40 bones each, against plain numpy over all dancers."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32
from live.cli.bench import Row
from live.motion import quaternion
from live.motion.cloth.spring_kernels import swing
from live.motion.cloth.spring_rig import DRAG, GRAVITY_X, GRAVITY_Z, HIT_RADIUS, STIFFNESS, SpringRig
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]

TICK = 1.0 / 64.0
STRANDS, BONES = 8, 5
BUDGET_MS = 2.0
"""Most that 50 dancers may take."""
TIMES_NUMPY = 5.0
"""How many times faster than numpy, at least."""
REST = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)
HEAD = SKELETON.index("head")


def run(full: bool, shared: Path | None) -> list[Row]:
    """Time of a tick, without the poses."""
    rig, rows = _rig(), []
    for dancers in (50, 200):
        tick = _kernel(rig, dancers)
        own, peer = _milliseconds(tick, 200 if full else 60), _milliseconds(_Numpy(rig, dancers).tick, 10)
        bar = BUDGET_MS if dancers == 50 else None
        name = f"{dancers} dancers, {rig.count} bones each"
        rows += [
            Row(name, own, "ms/tick", bar, "at most", {"numpy": peer}),
            Row(f"{name}, times numpy", peer / own, "×", TIMES_NUMPY, "at least"),
        ]
    return rows


def _kernel(rig: SpringRig, dancers: int) -> Callable[[], None]:
    """Return a function that advances the dancers' springs by a tick."""
    position, rotation = (np.repeat(each, dancers, axis=0) for each in _body())
    now, before = (np.zeros((dancers, rig.count, 3), np.float32) for _ in range(2))
    turn, start = np.zeros((dancers, rig.count, 4), np.float32), np.ones(dancers, np.uint8)

    def tick() -> None:
        swing(
            position, rotation, REST, rig.parent, rig.joint, rig.centre, rig.head, rig.tail, rig.setting, rig.hits,
            rig.collider_joint, rig.collider, start, TICK, now, before, turn,
        )  # fmt: skip
        start[:] = 0

    return tick


def _milliseconds(tick: Callable[[], object], repeats: int) -> float:
    tick()
    spent = []
    for _ in range(repeats):
        begin = time.process_time()
        tick()
        spent.append(time.process_time() - begin)
    return 1000.0 * float(np.median(spent))


def _body() -> tuple[Float32, Float32]:
    turn = np.zeros((1, len(REST), 4), np.float32)
    turn[..., 0] = 1.0
    return REST[None].copy(), turn


def _rig() -> SpringRig:
    """Strands around the back of a head, with spheres for head, neck and shoulders."""
    angle = np.pi * (np.repeat(np.arange(STRANDS), BONES) / (STRANDS - 1) - 0.5)
    down = np.tile(np.arange(BONES), STRANDS)[:, None] * np.array([0.0, -0.06, -0.01])
    head = REST[HEAD] + np.column_stack([0.1 * np.sin(angle), np.full(len(angle), 0.1), -0.1 * np.cos(angle)]) + down
    count = len(head)
    parent = np.where(np.arange(count) % BONES == 0, -1, np.arange(count) - 1).astype(np.int32)
    setting = np.tile(np.array([0.8, 0.4, 0.0, -0.4, 0.0, 0.02], np.float32), (count, 1))
    places = REST[HEAD] + np.array([[0, 0.06, 0], [0, -0.05, 0], [0.12, -0.12, 0], [-0.12, -0.12, 0], [0, -0.2, 0]])
    collider = np.column_stack([places, places, [0.09, 0.06, 0.07, 0.07, 0.11]]).astype(np.float32)
    return SpringRig(
        parent, np.full(count, HEAD, np.int32), np.full(count, -1, np.int32), head.astype(np.float32),
        (head + np.array([0.0, -0.06, -0.01])).astype(np.float32), setting, np.full(count, 31, np.int64),
        np.full(len(places), HEAD, np.int32), collider,
    )  # fmt: skip


class _Numpy:
    """The same bones in the same order, each for all dancers at once, of a body at rest."""

    def __init__(self, rig: SpringRig, dancers: int) -> None:
        self._rig, self._count = rig, dancers
        self._now = np.repeat(rig.tail[:, None].astype(np.float64), self._count, axis=1)
        self._before = self._now.copy()

    def tick(self) -> None:
        """Advance by a tick."""
        rig, ends = self._rig, self._now.copy()
        turns = [np.tile((1.0, 0.0, 0.0, 0.0), (self._count, 1))] * rig.count
        for bone, parent in enumerate(rig.parent.tolist()):
            head = np.tile(rig.head[bone].astype(np.float64), (self._count, 1)) if parent < 0 else ends[parent]
            above = turns[parent] if parent >= 0 else turns[bone]
            way = (rig.tail[bone] - rig.head[bone]).astype(np.float64)
            length, setting = float(np.linalg.norm(way)), rig.setting[bone]
            rest = quaternion.rotate(above, way / length)
            inertia = (self._now[bone] - self._before[bone]) * (1.0 - setting[DRAG])
            pull = TICK * (setting[STIFFNESS] * rest + setting[GRAVITY_X : GRAVITY_Z + 1])
            tip = head + length * quaternion.unit(self._now[bone] + inertia + pull - head)
            for row in rig.collider:
                away = tip - row[:3]
                far = np.linalg.norm(away, axis=1, keepdims=True)
                out = tip + away / far * np.maximum(row[6] + setting[HIT_RADIUS] - far, 0.0)
                tip = head + length * quaternion.unit(out - head)
            ends[bone] = tip
            turns[bone] = quaternion.mul(quaternion.from_two_vectors(rest, (tip - head) / length), above)
        self._before, self._now = self._now, ends
