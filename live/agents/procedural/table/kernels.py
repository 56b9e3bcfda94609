"""The table of elements: its columns, and who of them acts at a beat (T105, T132)."""

import numpy as np
import numpy.typing as npt

from live.agents.procedural.kinds import KIND_COUNT
from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# columns of the table (E, COLUMNS), float64
START, END, LEVEL, KIND, STRENGTH = 0, 1, 2, 3, 4
CORNERS, CLOSED, RADIUS, DECAY, SEPARATION = 5, 6, 7, 8, 9
ALIGNMENT, COHESION, FLOW_KIND, SLOT, TARGET = 10, 11, 12, 13, 14
TARGET_GROUP, WEDGE, SERIAL, X, Z = 15, 16, 17, 18, 19
COLUMNS = 20

ALL_BITS: np.uint64 = np.uint64(0xFFFFFFFFFFFFFFFF)
_NONE: np.uint64 = np.uint64(0)


@kernel("b1(u8,u8)")
def addresses(mask: np.uint64, groups: np.uint64) -> bool:
    """Whether an element of group mask `mask` means a dancer of `groups`; all bits mean everybody."""
    return mask == ALL_BITS or (mask & groups) != _NONE


@kernel("i8(f8[:,::1],i8,f8,f8,i4[::1])")
def refresh_table(table: Float64, count: int, beat: float, fade: float, active: Int32) -> int:
    """Set every row's level at `beat` and list those that act, by kind; returns how many have ended.

    table (E, 20): the first `count` rows; `fade` in beats; active (E + KIND_COUNT + 1,): first where each kind's rows
    begin (KIND_COUNT + 1 numbers), then the rows that act, sorted by kind, oldest first.
    """
    ended = 0
    for k in range(KIND_COUNT + 1):
        active[k] = 0
    for row in range(count):
        into, left = beat - table[row, START], table[row, END] - beat
        level = 0.0
        if left <= 0.0:
            ended += 1
        elif into > 0.0:
            level = min(1.0, into / fade, left / fade)
        table[row, LEVEL] = level
        if level > 0.0:
            active[int(table[row, KIND]) + 1] += 1
    for k in range(KIND_COUNT):
        active[k + 1] += active[k]
    for row in range(count - 1, -1, -1):
        if table[row, LEVEL] > 0.0:
            # each kind is filled from its end, and the ends move down to the beginnings
            kind = int(table[row, KIND]) + 1
            active[kind] -= 1
            active[KIND_COUNT + 1 + active[kind]] = row
    for k in range(KIND_COUNT):
        active[k] = active[k + 1]
    total = 0
    for row in range(count):
        if table[row, LEVEL] > 0.0:
            total += 1
    active[KIND_COUNT] = total
    return ended
