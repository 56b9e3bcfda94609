"""Kernels of the renderer: joints into the texels of the pose texture, and the tips of limbs."""

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,::1], f4[:,:,::1])")
def pose_texels(position: Float32, rotation: Float32, rest: Float32, out: Float32) -> None:
    """Dual quaternions that carry the rest pose to each dancer's pose (Kavan et al. 2007).

    position (A, J, 3), rotation (A, J, 4) wxyz, rest (J, 3); out (H, B*2J, 4): dancer a stands in row a mod H from
    texel (a // H)*2J on; a joint takes two texels, the rotation (x, y, z, w) and the dual part (x, y, z, w).
    """
    height = out.shape[0]
    joints = rest.shape[0]
    for a in range(position.shape[0]):
        row = a % height
        first = (a // height) * 2 * joints
        for j in range(joints):
            w = rotation[a, j, 0]
            x = rotation[a, j, 1]
            y = rotation[a, j, 2]
            z = rotation[a, j, 3]
            rx = rest[j, 0]
            ry = rest[j, 1]
            rz = rest[j, 2]
            # translation = position - rotation(rest); v + 2w(u x v) + 2u x (u x v)
            cx = y * rz - z * ry
            cy = z * rx - x * rz
            cz = x * ry - y * rx
            tx = position[a, j, 0] - (rx + 2.0 * (w * cx + y * cz - z * cy))
            ty = position[a, j, 1] - (ry + 2.0 * (w * cy + z * cx - x * cz))
            tz = position[a, j, 2] - (rz + 2.0 * (w * cz + x * cy - y * cx))
            texel = first + 2 * j
            out[row, texel, 0] = x
            out[row, texel, 1] = y
            out[row, texel, 2] = z
            out[row, texel, 3] = w
            out[row, texel + 1, 0] = 0.5 * (tx * w + ty * z - tz * y)
            out[row, texel + 1, 1] = 0.5 * (ty * w + tz * x - tx * z)
            out[row, texel + 1, 2] = 0.5 * (tz * w + tx * y - ty * x)
            out[row, texel + 1, 3] = -0.5 * (tx * x + ty * y + tz * z)


@kernel("void(f4[:,:,::1], f4[:,:,::1], b1[::1], i4[::1], f4[:,::1], f4[:,:,::1])")
def limb_tips(position: Float32, rotation: Float32, present: Bool, joint: Int32, offset: Float32, out: Float32) -> None:
    """Where places that hang on joints are: `offset` (L, 3) from `joint` (L,) in the rest pose's axes.

    position (A, J, 3), rotation (A, J, 4) wxyz, present (A,); out (A or more, L, 4): place and 1 for who is present.
    """
    for a in range(position.shape[0]):
        for k in range(joint.shape[0]):
            j = joint[k]
            w = rotation[a, j, 0]
            x = rotation[a, j, 1]
            y = rotation[a, j, 2]
            z = rotation[a, j, 3]
            ox = offset[k, 0]
            oy = offset[k, 1]
            oz = offset[k, 2]
            cx = y * oz - z * oy
            cy = z * ox - x * oz
            cz = x * oy - y * ox
            out[a, k, 0] = position[a, j, 0] + ox + 2.0 * (w * cx + y * cz - z * cy)
            out[a, k, 1] = position[a, j, 1] + oy + 2.0 * (w * cy + z * cx - x * cz)
            out[a, k, 2] = position[a, j, 2] + oz + 2.0 * (w * cz + x * cy - y * cx)
            out[a, k, 3] = 1.0 if present[a] else 0.0
