"""Element table: its columns, the rows that act at a beat (T105, T132), and their copy to a drawing snapshot."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import ALIGNMENT as WANTS_ALIGNMENT
from live.agents.agent_command import COHESION as WANTS_COHESION
from live.agents.agent_command import PRESENCE
from live.agents.agent_command import SEPARATION as WANTS_SEPARATION
from live.base.element_kinds import KIND_COUNT
from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# columns of the table (E, COLUMNS), float64: first what an element tells, as in `Element.table_row`
START, END, KIND, STRENGTH, CORNERS, OUTLINE = 0, 1, 2, 3, 4, 5
CLOSED, RADIUS, DECAY, SEPARATION, ALIGNMENT, COHESION = 6, 7, 8, 9, 10, 11
FLOW_KIND, TARGET, TARGET_GROUP, WEDGE, X, Z = 12, 13, 14, 15, 16, 17
ELEMENT_COLUMNS = 18
LEVEL, SLOT, SERIAL = 18, 19, 20
COLUMNS = 21

# columns of the sums that the passes over the agents share (A, SUM_COLUMNS), float64
SUM_X, SUM_Z, REMAINING_SPEED, INFLUENCE, ADDRESSED_LEVEL = 0, 1, 2, 3, 4
SUM_COLUMNS = 5
# indices of the parameters of a call
TIME, SEED, HALF_WIDTH, HALF_DEPTH, SWITCHED, PLACE_COUNT = 0, 1, 2, 3, 4, 5
PARAMETER_COUNT = 6
ACTIVE_START = KIND_COUNT + 1
"""Start of the list of acting rows in `active`."""

ALL_BITS = np.uint64(0xFFFFFFFFFFFFFFFF)
_NONE = np.uint64(0)


@inline_kernel
def addresses(mask: np.uint64, groups: np.uint64) -> bool:
    """Whether a group mask addresses a dancer of `groups`; ALL_BITS addresses every dancer."""
    return bool(mask == ALL_BITS or (mask & groups) != _NONE)


@inline_kernel
def newest(table: Float64, masks: UInt64, active: Int32, kind: int, groups: np.uint64) -> int:
    """Return the newest acting element of a kind that addresses these groups, or -1."""
    found = -1
    for k in range(ACTIVE_START + active[kind], ACTIVE_START + active[kind + 1]):
        if addresses(masks[active[k]], groups):
            found = active[k]
    return found


@inline_kernel
def add_velocity(sums: Float64, i: int, x: float, z: float, influence: float, switched: bool) -> None:
    """Add a preferred velocity to an agent's sum: in full (blended), or up to the remaining speed (switched)."""
    if switched:
        size = math.sqrt(x * x + z * z)
        if size > sums[i, REMAINING_SPEED]:
            x, z, size = (
                x * sums[i, REMAINING_SPEED] / size,
                z * sums[i, REMAINING_SPEED] / size,
                sums[i, REMAINING_SPEED],
            )
        sums[i, REMAINING_SPEED] -= size
    sums[i, SUM_X] += x
    sums[i, SUM_Z] += z
    sums[i, INFLUENCE] = max(sums[i, INFLUENCE], influence)


@kernel("void(f8[:,::1],u8[::1],i4[::1],f4[:,::1],u8[::1],f8[:,::1])")
def reset_sums(table: Float64, masks: UInt64, active: Int32, commands: Float32, groups: UInt64, sums: Float64) -> None:
    """Reset the sums (A, 5) and raise the neighbour weights in `commands` (A, 8) to those of the acting elements.

    sums[:, ADDRESSED_LEVEL] becomes the largest level of the elements that address a present agent; 0: none does.
    """
    for i in range(commands.shape[0]):
        sums[i, SUM_X], sums[i, SUM_Z], sums[i, REMAINING_SPEED], sums[i, INFLUENCE], sums[i, ADDRESSED_LEVEL] = (
            0.0,
            0.0,
            1.0,
            0.0,
            0.0,
        )
        if commands[i, PRESENCE] <= 0.0:
            continue
        heard, apart, align, cohere = 0.0, 0.0, 0.0, 0.0
        for k in range(ACTIVE_START, ACTIVE_START + active[KIND_COUNT]):
            row = active[k]
            if addresses(masks[row], groups[i]):
                level = table[row, LEVEL]
                heard = max(heard, level)
                apart = max(apart, level * table[row, SEPARATION])
                align = max(align, level * table[row, ALIGNMENT])
                cohere = max(cohere, level * table[row, COHESION])
        sums[i, ADDRESSED_LEVEL] = heard
        commands[i, WANTS_SEPARATION] = max(commands[i, WANTS_SEPARATION], apart)
        commands[i, WANTS_ALIGNMENT] = max(commands[i, WANTS_ALIGNMENT], align)
        commands[i, WANTS_COHESION] = max(commands[i, WANTS_COHESION], cohere)


@kernel("f8(f8)")
def fade_in_level(share: float) -> float:
    """Return the fade-in level, 0 to 1, at this fraction of the fade.

    The slope is steepest at the start, so that agents react within two frames, and 0 at the end. The lag of the
    accelerations prevents a jolt.
    """
    rest = max(1.0 - share, 0.0) ** 2
    return 1.0 - rest * rest


@kernel("i8(f8[:,::1],i8,f8,f8,i4[::1])")
def refresh_table(table: Float64, count: int, beat: float, fade: float, active: Int32) -> int:
    """Set every row's level at `beat` and list the acting rows by kind; return how many have ended.

    table (E, 20): the first `count` rows; `fade` in beats; active (E + KIND_COUNT + 1,): first the start of each kind's
    rows (KIND_COUNT + 1 numbers), then the acting rows, sorted by kind, oldest first.
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
            level = min(fade_in_level(into / fade), left / fade)
        table[row, LEVEL] = level
        if level > 0.0:
            active[int(table[row, KIND]) + 1] += 1
    for k in range(KIND_COUNT):
        active[k + 1] += active[k]
    for row in range(count - 1, -1, -1):
        if table[row, LEVEL] > 0.0:
            # each kind is filled from its end, so that the end indices become start indices
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


@kernel(
    "i8(f8[:,::1], i4[::1], f4[:,:,::1], i4[::1], f4[:,::1], f4[::1], f4[::1], f4[::1], i4[::1], i4[::1], i4[::1],"
    " f4[:,::1])"
)
def copy_active_elements(
    table: Float64, active: Int32, outlines: Float32,
    kind: Int32, position: Float32, level: Float32, radius: Float32, strength: Float32, flow: Int32,
    first: Int32, corners: Int32, corner: Float32,
) -> int:  # fmt: skip
    """Copy the acting rows into the arrays of a `StageView`, up to their capacity; return their number.

    `table`, `active`, `outlines` as in `ElementTable`. A line or region whose corners exceed the capacity of `corner`
    stays a point; a closed one repeats its first corner at the end.
    """
    count: int = min(active[KIND_COUNT], kind.shape[0])
    used = 0
    for k in range(count):
        row = active[ACTIVE_START + k]
        kind[k], flow[k] = int(table[row, KIND]), int(table[row, FLOW_KIND])
        position[k, 0], position[k, 1] = table[row, X], table[row, Z]
        level[k], radius[k], strength[k] = table[row, LEVEL], table[row, RADIUS], table[row, STRENGTH]
        corners[k] = 0
        size, closed = int(table[row, OUTLINE]), int(table[row, CLOSED])
        if size <= 1 or used + size + closed > corner.shape[0]:
            continue
        first[k], corners[k] = used, size + closed
        for n in range(size + closed):
            place = n if n < size else 0
            corner[used + n, 0], corner[used + n, 1] = outlines[row, place, 0], outlines[row, place, 1]
        used += size + closed
    return count
