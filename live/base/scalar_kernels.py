"""Scalar kernels for use in other kernels: angle wrap, ease, damper."""

import math

from live.base.jit import kernel


@kernel("f8(f8)")
def angle_wrap(angle: float) -> float:
    """Return the same angle in [-π, π) (radians)."""
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
