"""The fingers of all dancers, eased at ticks towards the hand shapes that steps, groups or people ask for."""

import math

import numpy as np
import numpy.typing as npt

from live.base.body.hand_shapes import OPEN, RELAXED
from live.base.jit import kernel
from live.motion.expression.face_kernels import EFFORT, chance

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int8 = npt.NDArray[np.int8]
Int32 = npt.NDArray[np.int32]

SOFT = 6
"""Column of a hand's state after those of `live.base.body.expression`: how soft the shape is, 0 to 1."""
HAND_COLUMNS = 7
VALUE, SPEED = range(2)
"""Rows of the state: columns now, and their speeds [1/s]."""
EASE_RATE = 15.0
"""Rate of the critically damped approach to a shape [1/s]: half of it in 0.11 s, nearly all in 0.3 s."""
OWN_CURL = 0.05
"""Soft fingers of one dancer are curled more or less than those of others by so much at most."""
ENERGY_OPENS = 0.45
"""Share by which hands without a shape open in the hardest dance."""


@kernel(
    "void(f4[:,:,:,::1], f4[:,::1], f4[::1], i4[::1], i1[:,:,::1], i4[::1], i4[::1], i4[::1], b1, f8[::1], f8[::1],"
    " f4[:,::1], i8, f8, i8, i8)"
)
def advance_hands(
    state: Float32, shapes: Float32, softness: Float32, asked: Int32, cues: Int8, past: Int32, present: Int32,
    coming: Int32, decided: bool, phase: Float64, group_shape: Float64, number: Float32, seed: int, dt: float,
    begin: int, end: int,
) -> None:  # fmt: skip
    """Advance the hands of the dancers begin..end-1 by `dt` [s].

    In and out: `state` (2, A, 2, HAND_COLUMNS). In: `shapes` (K, 6) and their `softness` (K,); `asked` (A,) shape that
    a person asks for now, -1 for none; `cues` (N, Q, 2) shapes of left and right hand in each of the Q equal parts of
    a measure of each node, -1 for none; nodes (A,) of past, present and coming measure, whether the last are `decided`,
    `phase` (A,) in the present one; `group_shape` (A,) shape of each dancer's group, -1 for none; `number` of the
    faces.
    """
    fall = math.exp(-EASE_RATE * dt)
    parts = cues.shape[1]
    for i in range(begin, end):
        node, at = present[i], phase[i]
        if at < 0.0 and past[i] >= 0:
            node, at = past[i], at + 1.0
        elif at > 1.0 and decided:
            node, at = coming[i], at - 1.0
        part = min(max(int(at * parts), 0), parts - 1)
        opened = ENERGY_OPENS * number[i, EFFORT]
        for side in range(2):
            shape = asked[i]
            if shape < 0 and node >= 0:
                shape = cues[node, part, side]
            if shape < 0:
                shape = int(group_shape[i])
            own = shape
            if shape < 0:
                own = RELAXED
            soft = softness[own]
            vary = OWN_CURL * soft * (2.0 * chance(seed, i, 1 + side) - 1.0)
            for c in range(HAND_COLUMNS):
                if c == SOFT:
                    goal = soft
                else:
                    goal = shapes[own, c] + vary
                    if shape < 0:
                        goal += opened * (shapes[OPEN, c] - shapes[RELAXED, c])
                    goal = min(max(goal, -1.0 if c == SOFT - 1 else 0.0), 1.0)
                away = state[VALUE, i, side, c] - goal
                bend = state[SPEED, i, side, c] + EASE_RATE * away
                state[VALUE, i, side, c] = goal + fall * (away + bend * dt)
                state[SPEED, i, side, c] = fall * (state[SPEED, i, side, c] - EASE_RATE * bend * dt)
