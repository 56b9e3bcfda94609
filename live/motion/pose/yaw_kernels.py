"""Rotation about the vertical axis on the stage plane."""

import math

from live.base.jit import kernel


@kernel("UniTuple(f8,2)(f8,f8,f8)")
def yaw_rotate(x: float, z: float, yaw: float) -> tuple[float, float]:
    """Rotate the stage vector (x, z) by `yaw` about +Y: (0, 1), the audience, becomes (sin yaw, cos yaw) (as in
    K001)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return (x * c + z * s, z * c - x * s)
