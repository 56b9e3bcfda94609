"""Motion: what is asked of an agent becomes an acceleration, within her limits (T081, T083)."""

import math

import numpy as np
import numpy.typing as npt

from live.agents.crowd.cells.kernels import NEIGHBOUR_RANGE
from live.agents.crowd.neighbours.kernels import (
    ALIGNMENT,
    AVOID_X,
    AVOID_Z,
    COHESION,
    FLOCK_X,
    FLOCK_Z,
    HORIZON,
    PER_SEPARATION2,
    PUSH_X,
    PUSH_Z,
    WEIGHT,
)
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

SEPARATION_PEAK = 25.0 * math.sqrt(5.0) / 16.0
"""1 over the largest value of s (1 - s²)², which is at s = 1/√5."""
FIRM_HORIZON = 0.4
"""Seconds that a firm agent looks ahead: her way has been planned."""
FIRM_SWERVE = 0.25
"""Seconds for which a firm agent's avoiding acceleration counts in her velocity."""


@kernel("UniTuple(f8,2)(f8,f8,f8)")
def shorten(x: float, z: float, most: float) -> tuple[float, float]:
    """The vector, not longer than `most`."""
    size = math.sqrt(x * x + z * z)
    if size > most:
        return x * most / size, z * most / size
    return x, z


@kernel("UniTuple(f8,2)(f8,f8,f8,f8,f8)")
def limit_turn(x: float, z: float, old_x: float, old_z: float, most: float) -> tuple[float, float]:
    """Velocity (x, z) [m/s], turned at most `most` [rad] from the old one; nobody who hardly moves is limited."""
    dot, cross = x * old_x + z * old_z, old_x * z - old_z * x
    speed = math.sqrt(x * x + z * z)
    old = math.sqrt(old_x * old_x + old_z * old_z)
    if old < 0.1 or speed < 0.1:
        return x, z
    cosine = math.cos(most)
    if dot >= cosine * speed * old:
        return x, z
    sine = math.sin(most) * (1.0 if cross >= 0.0 else -1.0)
    # what she cannot turn she brakes: only the share along the way that she can take is kept
    dx, dz = (cosine * old_x - sine * old_z) / old, (sine * old_x + cosine * old_z) / old
    keep = max(x * dx + z * dz, 0.0)
    return dx * keep, dz * keep


@kernel("void(f4[:,::1], f4[:,::1], i4[::1], i8, f4[::1])")
def ask_agents(asks: Float32, wants: Float32, slot_agent: Int32, n: int, params: Float32) -> None:
    """Fill `asks`: what the neighbour pass has to know of each sorted agent."""
    one, horizon = np.float32(1.0), params[6]
    for s in range(n):
        i = slot_agent[s]
        separation = min(max(wants[i, 3], np.float32(1e-3)), np.float32(NEIGHBOUR_RANGE))
        asks[PER_SEPARATION2, s] = one / (separation * separation)
        asks[HORIZON, s] = horizon + wants[i, 6] * (np.float32(FIRM_HORIZON) - horizon)
        asks[ALIGNMENT, s], asks[COHESION, s] = wants[i, 4], wants[i, 5]


@kernel("void(f4[::1], f4[::1], f4[:,::1], f4[:,::1], f4[:,::1], i4[::1], i8, f4[::1], f8)")
def steer_agents(
    out: Float32,
    state: Float32,
    wants: Float32,
    sums: Float32,
    moved: Float32,
    slot_agent: Int32,
    n: int,
    params: Float32,
    dt: float,
) -> None:
    """New velocities of the n sorted agents into `moved` (rows 0, 1), their accelerations into `out`."""
    a = wants.shape[0]
    most, turn, relaxation = float(params[3]), float(params[4]), max(float(params[5]), dt)
    catch_up = 1.0 - math.exp(-dt / max(float(params[12]), 1e-6))
    for s in range(n):
        i = slot_agent[s]
        vx, vz = float(state[2 * a + 2 * i]), float(state[2 * a + 2 * i + 1])
        speed, firm = max(float(wants[i, 2]), 0.0), float(wants[i, 6])
        wish_x, wish_z = shorten(wants[i, 0], wants[i, 1], speed)
        want_x, want_z = wish_x, wish_z
        if wants[i, 3] > 0.0:
            scale = SEPARATION_PEAK / wants[i, 3] * speed
            push_x, push_z = shorten(sums[PUSH_X, s] * scale, sums[PUSH_Z, s] * scale, speed)
            want_x, want_z = want_x + push_x, want_z + push_z
        weight = float(sums[WEIGHT, s]) - 1.0
        if weight > 1e-6:
            want_x += sums[FLOCK_X, s] / weight
            want_z += sums[FLOCK_Z, s] / weight
        want_x, want_z = shorten(want_x, want_z, speed)
        soft = 1.0 - firm
        ax = soft * (want_x - vx) / relaxation + sums[AVOID_X, s]
        az = soft * (want_z - vz) / relaxation + sums[AVOID_Z, s]
        ax, az = shorten(ax, az, most)
        old_x, old_z = float(state[4 * a + 2 * i]), float(state[4 * a + 2 * i + 1])
        ax, az = old_x + (ax - old_x) * catch_up, old_z + (az - old_z) * catch_up
        if ax * ax + az * az < 1e-8:
            ax, az = 0.0, 0.0
        new_x, new_z = shorten(vx + ax * dt, vz + az * dt, max(speed, math.sqrt(vx * vx + vz * vz) - most * dt))
        new_x, new_z = limit_turn(new_x, new_z, vx, vz, turn * dt)
        new_x = soft * new_x + firm * (wish_x + FIRM_SWERVE * ax)
        new_z = soft * new_z + firm * (wish_z + FIRM_SWERVE * az)
        out[4 * a + 2 * i], out[4 * a + 2 * i + 1] = ax, az
        moved[0, s], moved[1, s] = new_x, new_z
