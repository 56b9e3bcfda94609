"""What the dance does with a body, read from the clips at ticks: where the head goes, and the kinetic energy."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.base.scalar_kernels import angle_wrap
from live.motion.pose.pipeline_kernels import NEXT, PRESENT, head_turn

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

HEAD_YAW, TURN, ENERGY = range(3)
"""Columns of what `measure_dance` writes: heading of the head [rad], its turn in the next LEAD_S [rad], and kinetic
energy [J/kg]."""
LEAD_S = 0.2
"""So far ahead [s] eyes follow where the head will be."""
ENERGY_SAMPLES = 2
"""Kinetic energy is measured between samples so far before and after the present one."""
HEAD_JOINT, CHEST_JOINT = 5, 3
"""Joints of head and upper chest; the joints from the hips to the head are 0 to 5, each the next one's parent."""
_ONE: Any = np.float32(1.0)
_TWO: Any = np.float32(2.0)


@kernel(
    "void(f4[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], f8[:,:,::1], f4[::1], f8[::1], i4[::1], i4[::1], i4[::1], b1,"
    " f8[::1], f8[::1], f8[::1], f8, f8[::1], f4[::1], i8, i8, i8)"
)
def measure_dance(
    out: Float32, clip_root: Float32, clip_rotation: Float32, sample: Float64, placement: Float64, into_next: Float32,
    phase: Float64, past: Int32, present: Int32, coming: Int32, decided: bool, node_first: Float64, node_last: Float64,
    node_lead: Float64, measure_s: float, head: Float64, inertia: Float32, odd: int, begin: int, end: int,
) -> None:  # fmt: skip
    """Measure what the clips of every second of the dancers begin..end-1 do now: `out` (A, 3), columns HEAD_YAW, TURN
    and ENERGY.

    In: the clips (S, 3) and (S, J, 4) and the requests `sample` (4, A), `placement` (4, A, 4) and `into_next` (A,) of
    the pose pipeline; `phase` (A,) in the present measure; nodes (A,) of past, present and coming measure, whether the
    last are `decided`; first, last and earliest sample (N,) of nodes; length of a measure now [s]; `head` (A,) share of
    the head's turn to the audience; `inertia` (J,) moments of inertia per mass of what each joint moves [m²]; `odd`: 1
    for the second, fourth ... dancer, 0 for the others.
    """
    joints, samples = clip_rotation.shape[1], clip_rotation.shape[0]
    for i in range(begin + (begin + odd) % 2, end, 2):
        node, row, after = present[i], PRESENT, coming[i] if decided else -1
        if phase[i] < 0.0 and past[i] >= 0:
            node, after = past[i], present[i]
        elif phase[i] > 1.0 and decided:
            node, after = coming[i], -1
        if into_next[i] > 0.5 and after >= 0:
            node, row = after, NEXT
        node = max(node, 0)
        rate = (node_last[node] - node_first[node]) / measure_s
        lowest, highest = int(node_lead[node]), min(int(node_last[node]), samples - 1)
        at = sample[row, i]
        here = min(max(int(at + 0.5), lowest), highest)
        later = min(max(int(at + rate * LEAD_S + 0.5), lowest), highest)
        yaw, now, then = placement[row, i, 3], 0.0, 0.0
        for soon in range(2):
            k, chest = later if soon else here, 0.0
            w, x, y, z = clip_rotation[k, 0, 0], clip_rotation[k, 0, 1], clip_rotation[k, 0, 2], clip_rotation[k, 0, 3]
            for j in range(1, HEAD_JOINT + 1):
                p, q, r, s = (
                    clip_rotation[k, j, 0], clip_rotation[k, j, 1], clip_rotation[k, j, 2], clip_rotation[k, j, 3],
                )  # fmt: skip
                w, x, y, z = (
                    w * p - x * q - y * r - z * s,
                    w * q + x * p + y * s - z * r,
                    w * r - x * s + y * p + z * q,
                    w * s + x * r - y * q + z * p,
                )
                if j == CHEST_JOINT:
                    chest = yaw + math.atan2(_TWO * (x * z + w * y), _ONE - _TWO * (x * x + y * y))
            forward_x, forward_z = _TWO * (x * z + w * y), _ONE - _TWO * (x * x + y * y)
            turned = chest
            if forward_x * forward_x + forward_z * forward_z > 0.04:  # else the head looks at the floor or the sky
                turned = yaw + math.atan2(forward_x, forward_z)
            if head[i] > 0.0:
                turned += head[i] * angle_wrap(chest + head_turn(chest) - turned)
            now, then = now if soon else turned, turned
        out[i, HEAD_YAW], out[i, TURN] = angle_wrap(now), angle_wrap(then - now)
        a, b = max(here - ENERGY_SAMPLES, lowest), min(here + ENERGY_SAMPLES, highest)
        energy = 0.0
        for j in range(joints):
            w, x, y, z = clip_rotation[a, j, 0], clip_rotation[a, j, 1], clip_rotation[a, j, 2], clip_rotation[a, j, 3]
            p, q, r, s = clip_rotation[b, j, 0], clip_rotation[b, j, 1], clip_rotation[b, j, 2], clip_rotation[b, j, 3]
            u = w * q - x * p - y * s + z * r
            v = w * r + x * s - y * p - z * q
            t = w * s - x * r + y * q - z * p
            energy += inertia[j] * 4.0 * (u * u + v * v + t * t)
        for c in range(3):
            moved = clip_root[b, c] - clip_root[a, c]
            energy += moved * moved
        speed = rate / max(b - a, 1)
        out[i, ENERGY] = 0.5 * energy * speed * speed
