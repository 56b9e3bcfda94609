"""What acts, copied from the table of elements into the arrays of a drawing snapshot."""

import numpy as np
import numpy.typing as npt

from live.agents.elements.element_kinds import KIND_COUNT
from live.agents.elements.table_kernels import (
    CLOSED,
    CORNERS,
    FLOW_KIND,
    KIND,
    LEVEL,
    RADIUS,
    ROWS,
    STRENGTH,
    X,
    Z,
)
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@kernel(
    "i8(f8[:,::1], i4[::1], f4[:,:,::1], i4[::1], f4[:,::1], f4[::1], f4[::1], f4[::1], i4[::1], i4[::1], i4[::1],"
    " f4[:,::1])"
)
def show_elements(
    table: Float64, active: Int32, vertices: Float32,
    kind: Int32, position: Float32, level: Float32, radius: Float32, strength: Float32, flow: Int32,
    first: Int32, corners: Int32, corner: Float32,
) -> int:  # fmt: skip
    """Copy the rows that act into the arrays of a `StageView`, as many as there is room for; returns how many.

    `table`, `active`, `vertices` as in `ElementTable`. A line or region whose corners find no room in `corner` stays a
    point; of a closed one the first corner comes once more at its end.
    """
    count: int = min(active[KIND_COUNT], kind.shape[0])
    used = 0
    for k in range(count):
        row = active[ROWS + k]
        kind[k], flow[k] = int(table[row, KIND]), int(table[row, FLOW_KIND])
        position[k, 0], position[k, 1] = table[row, X], table[row, Z]
        level[k], radius[k], strength[k] = table[row, LEVEL], table[row, RADIUS], table[row, STRENGTH]
        corners[k] = 0
        size, closed = int(table[row, CORNERS]), int(table[row, CLOSED])
        if size <= 1 or used + size + closed > corner.shape[0]:
            continue
        first[k], corners[k] = used, size + closed
        for n in range(size + closed):
            place = n if n < size else 0
            corner[used + n, 0], corner[used + n, 1] = vertices[row, place, 0], vertices[row, place, 1]
        used += size + closed
    return count
