"""Kernels of goals: velocity towards a target under two arrival laws, arrival check, and way points."""

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

ARRIVE = 0
"""Speed min(preferred, rate · d): full speed, then proportional to the remaining distance (Reynolds 1999, arrival)."""
ATTRACT = 1
"""Speed preferred · (1 - exp(-rate · d)): the attraction of T105, with the decay length 1 / rate."""

NO_SLOWING_RATE = 1e9
"""Rate at which agents do not slow down."""
_NO_SLOWING = np.float32(NO_SLOWING_RATE)
_ONE = np.float32(1.0)
_TINY = np.float32(1e-12)
_FAR = np.float32(16.0)  # exp(-16) is negligible in float32
_EXP_STEP = np.float32(-1.0 / 32.0)
_C2, _C3, _C4, _C5 = np.float32(1 / 2), np.float32(1 / 6), np.float32(1 / 24), np.float32(1 / 120)


@inline_kernel
def one_minus_exp(x: np.float32) -> np.float32:
    """Return 1 - exp(-x) for x >= 0, within 2e-6: a series for exp(-x / 32), squared five times, which vectorises."""
    y = min(x, _FAR) * _EXP_STEP
    e = _ONE + y * (_ONE + y * (_C2 + y * (_C3 + y * (_C4 + y * _C5))))
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    return _ONE - e


@kernel("i8(f4[:,::1],i4[::1],f4[::1],f4[:,::1],f4[:,::1],f4[::1],f4[::1],i8,f8)")
def seek_goals(
    rows: Float32,
    reached: Int32,
    factor: Float32,
    position: Float32,
    target: Float32,
    preferred: Float32,
    rate: Float32,
    law: int,
    reach: float,
) -> int:
    """Write each agent's velocity towards its target into columns 0 and 1 of `rows`; return how many have arrived.

    `rows` (A, 8) as in `AgentCommand`; `position`, `target` (A, 2) [m], `preferred` (A,) [m/s]; `rate` (A,) [1/m] for
    ATTRACTOR, [1/s] for ARRIVE. `reached` (A,) begins with the indices of agents within `reach` [m], ascending.
    `factor` (A,) is scratch: contiguous writes are vectorised, writes to `rows` are not.
    """
    agents = position.shape[0]
    place, goal, wish = (
        position.ravel(),
        target.ravel(),
        rows.ravel(),
    )  # flat views: LLVM cannot infer that rows have length 2
    reach32 = np.float32(reach)
    if law == ARRIVE:
        for i in range(agents):
            dx = goal[2 * i] - place[2 * i]
            dz = goal[2 * i + 1] - place[2 * i + 1]
            factor[i] = min(rate[i], preferred[i] / np.sqrt(dx * dx + dz * dz + _TINY))
    else:
        for i in range(agents):
            dx = goal[2 * i] - place[2 * i]
            dz = goal[2 * i + 1] - place[2 * i + 1]
            d = np.sqrt(dx * dx + dz * dz + _TINY)
            factor[i] = preferred[i] * one_minus_exp(d * rate[i]) / d
    count = 0
    within = reach32 * reach32
    for i in range(agents):
        dx = goal[2 * i] - place[2 * i]
        dz = goal[2 * i + 1] - place[2 * i + 1]
        wish[8 * i] = dx * factor[i]
        wish[8 * i + 1] = dz * factor[i]
        if dx * dx + dz * dz <= within:
            reached[count] = i
            count += 1
    return count


@kernel("b1(f8,f8,f8,f8,f8,f8,f8,f8)")
def segments_cross(ax: float, az: float, bx: float, bz: float, cx: float, cz: float, dx: float, dz: float) -> bool:
    """Whether the segments a-b and c-d intersect; touching counts, collinear overlap does not."""
    c = (bx - ax) * (cz - az) - (bz - az) * (cx - ax)
    d = (bx - ax) * (dz - az) - (bz - az) * (dx - ax)
    a = (dx - cx) * (az - cz) - (dz - cz) * (ax - cx)
    b = (dx - cx) * (bz - cz) - (dz - cz) * (bx - cx)
    return (c > 0.0) != (d > 0.0) and (a > 0.0) != (b > 0.0)


@kernel("b1(f8,f8,f8,f8,f8[:,::1])")
def is_blocked(ax: float, az: float, bx: float, bz: float, walls: Float64) -> bool:
    """Whether one of `walls` (W, 4) [m] blocks the way from a to b."""
    for w in range(walls.shape[0]):
        if segments_cross(ax, az, bx, bz, walls[w, 0], walls[w, 1], walls[w, 2], walls[w, 3]):
            return True
    return False


@kernel("void(f4[:,::1],f4[::1],i4[::1],f4[:,::1],f8[:,::1],i4[::1],f8[:,::1],f8,f8,f8)")
def advance_way_points(
    target: Float32,
    rate: Float32,
    at: Int32,
    position: Float32,
    points: Float64,
    start: Int32,
    walls: Float64,
    reach: float,
    gate: float,
    last_rate: float,
) -> None:
    """Advance each agent at or past its way point to the next one; write it into `target` (A, 2).

    `points` (P, 2) [m] holds all way points, those of agent i at start[i]:start[i + 1]; `at` (A,) is the current index.
    Agents slow down only for their last point: `rate` (A,) then becomes `last_rate`. At a point: within `reach` [m].
    Past it: within `gate` [m], beyond the line through it perpendicular to the way to the next, and none of `walls` (W,
    4) blocks the way to the next. Without this rule a crowd would turn back for a point in a door. Who has been pushed
    back behind a wall returns to the point before.
    """
    for i in range(position.shape[0]):
        last = start[i + 1] - 1
        here = at[i]
        px, pz = float(position[i, 0]), float(position[i, 1])
        if here > start[i] and walls.shape[0] > 0:
            wx, wz = points[here - 1, 0], points[here - 1, 1]
            away2 = (px - wx) * (px - wx) + (pz - wz) * (pz - wz)
            if (
                away2 > reach * reach
                and is_blocked(px, pz, points[here, 0], points[here, 1], walls)
                and not is_blocked(px, pz, wx, wz, walls)
            ):
                at[i] = here - 1
                target[i, 0], target[i, 1], rate[i] = np.float32(wx), np.float32(wz), _NO_SLOWING
                continue
        if here >= last:
            continue
        wx, wz = points[here, 0], points[here, 1]
        nx, nz = points[here + 1, 0], points[here + 1, 1]
        d2 = (px - wx) * (px - wx) + (pz - wz) * (pz - wz)
        passed = d2 <= reach * reach
        if not passed and d2 <= gate * gate and (px - wx) * (nx - wx) + (pz - wz) * (nz - wz) > 0.0:
            passed = not is_blocked(px, pz, nx, nz, walls)
        if passed:
            at[i] = here + 1
            target[i, 0] = np.float32(nx)
            target[i, 1] = np.float32(nz)
            if here + 1 == last:
                rate[i] = np.float32(last_rate)
