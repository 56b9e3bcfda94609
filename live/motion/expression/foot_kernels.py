"""Feet of drawn poses that point or flex in the air, and toes that bend where the heel leaves the floor first.

Recordings seldom have toes. Near the floor toes stay flat on it while the foot rolls over the ball; nothing changes
while a sole lies on the floor, so contacts and foot locks stay as they are.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

LEFT_KNEE, LEFT_ANKLE, LEFT_TOES = (SKELETON.index(f"left{name}") for name in ("LowerLeg", "Foot", "Toes"))
RIGHT_KNEE, RIGHT_ANKLE, RIGHT_TOES = (SKELETON.index(f"right{name}") for name in ("LowerLeg", "Foot", "Toes"))
TOES_DOWN, TOES_AHEAD = (float(SKELETON.offsets[LEFT_TOES, axis]) for axis in (1, 2))
"""Toe joint from the ankle in the rest pose [m]: up (below 0), and forward."""
TOE_LENGTH = 0.07
"""From the toe joint to the tip [m]."""
AIR_FROM, AIR_AT = 0.03, 0.2
"""A foot is in the air from this height on [m], and wholly at that one."""
POINTED, FLEXED = math.radians(62.0), math.radians(-22.0)
"""Angle between foot and shin beyond a right one, pointed and flexed as in ballet [rad]."""
TOES_POINTED, TOES_FLEXED = math.radians(22.0), math.radians(-18.0)
"""Bend of the toes with it, downwards [rad]."""
FLOOR_FROM, FLOOR_AT = 0.06, 0.025
"""Toes whose joint comes so near to the floor [m] begin to lie flat, and are flat."""
MOST_BEND = math.radians(70.0)
"""Toes bend upwards by so much [rad], as on high half point."""
TIP_CLEARANCE = 0.035
"""Pointed feet keep the tips of straight toes so far above the floor [m]: they are bent."""


@inline_kernel
def _smooth(t: float) -> float:
    """Return the smooth step of t clamped to [0, 1]."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


_PER_AIR: Any = 1.0 / (AIR_AT - AIR_FROM)
_PER_FLOOR: Any = 1.0 / (FLOOR_FROM - FLOOR_AT)


@kernel("void(f4[:,:,::1], f4[:,:,::1], b1[::1], f8[::1], i8, i8)")
def point_feet(position: Float32, rotation: Float32, there: Bool, point: Float64, begin: int, end: int) -> None:
    """Point the feet and bend the toes of the dancers begin..end-1 who are `there` (A,), in place.

    `position` (A, J, 3) [m] and `rotation` (A, J, 4) are drawn poses; `point` (A,): -1 flexed, 0 as danced, 1
    pointed.
    """
    for i in range(begin, end):
        if not there[i]:
            continue
        for side in range(2):
            knee, ankle, toes = LEFT_KNEE, LEFT_ANKLE, LEFT_TOES
            if side:
                knee, ankle, toes = RIGHT_KNEE, RIGHT_ANKLE, RIGHT_TOES
            high, tip = position[i, ankle, 1] - SOLE_BELOW_ANKLE, position[i, toes, 1] - TOES_OVER_SOLE
            w, x, y, z = rotation[i, ankle, 0], rotation[i, ankle, 1], rotation[i, ankle, 2], rotation[i, ankle, 3]
            ahead_y = 2.0 * (y * z - w * x)
            air = _smooth((min(high, tip) - AIR_FROM) * _PER_AIR) * point[i]
            # toes stay on the floor where the heel is higher
            floor = _smooth((FLOOR_FROM - position[i, toes, 1]) * _PER_FLOOR) * _smooth(-10.0 * ahead_y - 0.5)
            if air == 0.0 and floor == 0.0:
                continue
            turn = 0.0
            if air != 0.0:
                ahead_x, ahead_z = 2.0 * (x * z + w * y), 1.0 - 2.0 * (x * x + y * y)
                shin_x = position[i, ankle, 0] - position[i, knee, 0]
                shin_y = position[i, ankle, 1] - position[i, knee, 1]
                shin_z = position[i, ankle, 2] - position[i, knee, 2]
                along = shin_x * ahead_x + shin_y * ahead_y + shin_z * ahead_z
                along /= math.sqrt(shin_x * shin_x + shin_y * shin_y + shin_z * shin_z) + 1e-6
                now = math.asin(min(max(along, -1.0), 1.0))
                turn = air * max(POINTED - now, 0.0) if air > 0.0 else -air * min(FLEXED - now, 0.0)
                # the tip falls by about its way forward; it stops over the floor
                up_y = 1.0 - 2.0 * (x * x + z * z)
                reach = TOES_AHEAD + TOE_LENGTH
                far = position[i, ankle, 1] + TOES_DOWN * up_y + reach * ahead_y - TIP_CLEARANCE
                sine, cosine = math.sin(turn), math.cos(turn)
                lower = far + TOES_DOWN * ((cosine - 1.0) * up_y + sine * ahead_y)
                lower += reach * ((cosine - 1.0) * ahead_y - sine * up_y)
                if turn > 0.0 and lower < 0.0:
                    turn *= max(far, 0.0) / (far - lower)
            # the foot about its own axis from side to side
            c, s = math.cos(0.5 * turn), math.sin(0.5 * turn)
            aw, ax, ay, az = c * w - s * x, c * x + s * w, c * y + s * z, c * z - s * y
            tw, tx, ty, tz = rotation[i, toes, 0], rotation[i, toes, 1], rotation[i, toes, 2], rotation[i, toes, 3]
            # how the toes are bent against the foot, about that axis
            own_w, own_x = w * tw + x * tx + y * ty + z * tz, w * tx - x * tw - y * tz + z * ty
            bent = 2.0 * math.atan2(own_x, own_w)
            bent -= 2.0 * math.pi * round(bent / (2.0 * math.pi))
            flat = -min(math.asin(min(max(2.0 * (aw * ax - ay * az), 0.0), 1.0)), MOST_BEND)
            wanted, aloft = TOES_POINTED if air > 0.0 else TOES_FLEXED, abs(air)
            more = aloft * (wanted - bent) + (1.0 - aloft) * floor * (flat - bent)
            # new toes = new foot, old bend, more bend; the first two are the old toes turned with the foot
            gw, gx = aw * w + ax * x + ay * y + az * z, -aw * x + ax * w - ay * z + az * y
            gy, gz = -aw * y + ax * z + ay * w - az * x, -aw * z - ax * y + ay * x + az * w
            nw, nx = gw * tw - gx * tx - gy * ty - gz * tz, gw * tx + gx * tw + gy * tz - gz * ty
            ny, nz = gw * ty - gx * tz + gy * tw + gz * tx, gw * tz + gx * ty - gy * tx + gz * tw
            c, s = math.cos(0.5 * more), math.sin(0.5 * more)
            rotation[i, toes, 0], rotation[i, toes, 1] = c * nw - s * nx, c * nx + s * nw
            rotation[i, toes, 2], rotation[i, toes, 3] = c * ny + s * nz, c * nz - s * ny
            if turn == 0.0:
                continue
            # the toe joint goes with the foot
            rotation[i, ankle, 0], rotation[i, ankle, 1] = aw, ax
            rotation[i, ankle, 2], rotation[i, ankle, 3] = ay, az
            oy, oz = TOES_DOWN, TOES_AHEAD
            px, py, pz = 2.0 * (ay * oz - az * oy), -2.0 * ax * oz, 2.0 * ax * oy
            position[i, toes, 0] = position[i, ankle, 0] + aw * px + ay * pz - az * py
            position[i, toes, 1] = position[i, ankle, 1] + oy + aw * py + az * px - ax * pz
            position[i, toes, 2] = position[i, ankle, 2] + oz + aw * pz + ax * py - ay * px
