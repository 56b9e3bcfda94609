"""Scalar kernels that all others build on: quaternions (w, x, y, z) as tuples of scalars, angles, dampers."""

import math

from live.base.jit import kernel

Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]


@kernel("UniTuple(f8,4)(f8,f8,f8,f8,f8,f8,f8,f8)")
def quat_mul(aw: float, ax: float, ay: float, az: float, bw: float, bx: float, by: float, bz: float) -> Quaternion:
    """Hamilton product a b: rotate by b first, then by a."""
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


@kernel("UniTuple(f8,3)(f8,f8,f8,f8,f8,f8,f8)")
def quat_rotate(w: float, x: float, y: float, z: float, vx: float, vy: float, vz: float) -> Vector:
    """Rotate the vector v by the unit quaternion (w, x, y, z)."""
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


@kernel("UniTuple(f8,4)(f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def quat_slerp(
    aw: float, ax: float, ay: float, az: float, bw: float, bx: float, by: float, bz: float, t: float
) -> Quaternion:
    """SLERP along the shorter arc, a at t = 0, b at t = 1 (the geodesic on S³, T045)."""
    dot = aw * bw + ax * bx + ay * by + az * bz
    sign = 1.0
    if dot < 0.0:
        dot, sign = -dot, -1.0
    if dot > 0.9995:  # nearly equal: the chord is the arc, and sin(angle) is too small to divide by
        wa, wb = 1.0 - t, sign * t
    else:
        angle = math.acos(dot)
        inverse = 1.0 / math.sin(angle)
        wa, wb = math.sin((1.0 - t) * angle) * inverse, sign * math.sin(t * angle) * inverse
    w, x, y, z = wa * aw + wb * bw, wa * ax + wb * bx, wa * ay + wb * by, wa * az + wb * bz
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return (w * scale, x * scale, y * scale, z * scale)


@kernel("f8(f8)")
def angle_wrap(angle: float) -> float:
    """The same angle in [-π, π) (radians)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@kernel("f8(f8)")
def ease(t: float) -> float:
    """Cubic ease (smoothstep) of t clamped to [0, 1]: 0 → 0, 1 → 1, no velocity at both ends."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel("f8(f8,f8,f8,f8)")
def damper(value: float, goal: float, halflife: float, dt: float) -> float:
    """Exponential approach that covers half the way each `halflife` [s], right for any dt [s]."""
    return goal + (value - goal) * math.exp(-0.6931471805599453 * dt / (halflife + 1e-9))
