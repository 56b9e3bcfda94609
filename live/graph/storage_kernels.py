"""Kernels of the library's storage: quaternion signs along clips, sums for mean poses, and alike measures."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]


@kernel("void(f4[:,:,::1], i8[::1])")
def align_signs(rotation: Float32, clip_start: Int64) -> None:
    """Make the signs of rotations (S, J, 4) consistent for interpolation, in place.

    Within a clip each quaternion is nearest to the one before; the sign of each joint's sequence is the one nearest to
    the rest pose where they are closest. `clip_start` (clips + 1,): starts of the clips, and the end of the last.
    """
    for clip in range(clip_start.shape[0] - 1):
        first, last = clip_start[clip], clip_start[clip + 1]
        for j in range(rotation.shape[1]):
            nearest = 0.0
            for s in range(first, last):
                dot = 0.0
                if s > first:
                    for c in range(4):
                        dot += rotation[s, j, c] * rotation[s - 1, j, c]
                if dot < 0.0:
                    for c in range(4):
                        rotation[s, j, c] = -rotation[s, j, c]
                if abs(rotation[s, j, 0]) > abs(nearest):
                    nearest = rotation[s, j, 0]
            if nearest < 0.0:
                for s in range(first, last):
                    for c in range(4):
                        rotation[s, j, c] = -rotation[s, j, c]


@kernel("void(f4[:,:,::1],i8[::1],i8[::1],f8[:,:,:,::1])")
def rotation_moments(rotation: Float32, first: Int64, last: Int64, out: Float64) -> None:
    """Sum q qᵀ over the samples first to last (inclusive) of N nodes into out (N, J, 4, 4), which must be 0."""
    for n in range(first.shape[0]):
        for s in range(first[n], last[n] + 1):
            for j in range(rotation.shape[1]):
                for a in range(4):
                    q = float(rotation[s, j, a])
                    for b in range(4):
                        out[n, j, a, b] += q * float(rotation[s, j, b])


@kernel("void(f4[:,:,::1],i8[::1],i8[::1],f8[:,:,::1],f8[:,:,::1])")
def mean_turns(rotation: Float32, first: Int64, last: Int64, centre: Float64, out: Float64) -> None:
    """Write mean rotation vectors from `centre` (N, J, 4) over samples first to last of N nodes to out (N, J, 3)."""
    for n in range(first.shape[0]):
        count = float(last[n] + 1 - first[n])
        for j in range(rotation.shape[1]):
            cw, cx, cy, cz = centre[n, j, 0], -centre[n, j, 1], -centre[n, j, 2], -centre[n, j, 3]
            tx, ty, tz = 0.0, 0.0, 0.0
            for s in range(first[n], last[n] + 1):
                qw, qx = float(rotation[s, j, 0]), float(rotation[s, j, 1])
                qy, qz = float(rotation[s, j, 2]), float(rotation[s, j, 3])
                w = cw * qw - cx * qx - cy * qy - cz * qz
                x = cw * qx + cx * qw + cy * qz - cz * qy
                y = cw * qy - cx * qz + cy * qw + cz * qx
                z = cw * qz + cx * qy - cy * qx + cz * qw
                if w < 0.0:
                    w, x, y, z = -w, -x, -y, -z
                size = math.sqrt(x * x + y * y + z * z)
                share = 2.0 * math.atan2(size, w) / size if size > 1e-9 else 2.0
                tx += share * x
                ty += share * y
                tz += share * z
            out[n, j, 0], out[n, j, 1], out[n, j, 2] = tx / count, ty / count, tz / count


@kernel("void(i8[::1],i8[::1],b1[:,:,::1],f4[:,:,:,::1],i8,f8,f8,b1[:,::1])")
def alike_measures(
    rows: Int64, others: Int64, contact: Bool, rotation: Float32, differing: int, least: float, least_root: float,
    alike: Bool,
) -> None:  # fmt: skip
    """Keep in `alike` (n, m) only pairs of the measures `rows` (n,) and `others` (m,) that may be mixed.

    `contact` (N, P, 2) and local `rotation` (N, P, J, 4) at P moments of each of the N measures; the root's is relative
    to the first moment. At most `differing` contacts may differ, and no joint may be turned so far that the dot product
    is below `least`, the root below `least_root`.
    """
    for i in range(rows.shape[0]):
        for k in range(others.shape[0]):
            if not alike[i, k]:
                continue
            u, v, off = rows[i], others[k], 0
            for p in range(contact.shape[1]):
                off += (contact[u, p, 0] != contact[v, p, 0]) + (contact[u, p, 1] != contact[v, p, 1])
            if off > differing:
                alike[i, k] = False
                continue
            for p in range(rotation.shape[1]):
                for j in range(rotation.shape[2]):
                    dot = np.float32(0.0)
                    for c in range(4):
                        dot += rotation[u, p, j, c] * rotation[v, p, j, c]
                    if abs(dot) < (least if j > 0 else least_root):
                        alike[i, k] = False
                        break
                if not alike[i, k]:
                    break
