"""Kernels for captured bodies: retargeting to the engine's skeleton, unpacking of poses, sampling of buffered poses.

Rotations are quaternions (w, x, y, z) in double precision. The loops cover the 22 joints of few dancers, so there are
no blocks.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.pose.hand_hold_kernels import multiply

Float32 = npt.NDArray[np.float32]
UInt8 = npt.NDArray[np.uint8]

QUANTIZATION_STEPS = 16383
"""Quantization steps of a component on each side of zero: 15 bits."""


@kernel("void(f4[:,::1], u1[::1])")
def read_rotations(rotation: Float32, data: UInt8) -> None:
    """Decode `rotation` (J, 4) from six bytes of `data` per joint (see `live.motion.capture.packed_pose`)."""
    scale = 1.0 / (math.sqrt(2.0) * QUANTIZATION_STEPS)
    kept = np.empty(3)
    for j in range(rotation.shape[0]):
        bits = 0
        for k in range(6):
            bits = bits * 256 + data[6 * j + k]
        out, squares = (bits >> 45) & 3, 0.0
        for k in range(3):
            kept[k] = (((bits >> (30 - 15 * k)) & 0x7FFF) - QUANTIZATION_STEPS) * scale
            squares += kept[k] * kept[k]
        # malformed input may contain components that form no unit quaternion
        last, size = math.sqrt(max(1.0 - squares, 0.0)), math.sqrt(max(squares, 1.0))
        n = 0
        for c in range(4):
            if c == out:
                rotation[j, c] = last / size
            else:
                rotation[j, c] = kept[n] / size
                n += 1


Vector = tuple[float, float, float]
Rotation = tuple[float, float, float, float]


@inline_kernel
def rotate_vector(q: Rotation, x: float, y: float, z: float) -> Vector:
    """Return the vector rotated by q."""
    tx, ty, tz = 2.0 * (q[2] * z - q[3] * y), 2.0 * (q[3] * x - q[1] * z), 2.0 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@inline_kernel
def inverse(q: Rotation) -> Rotation:
    """Return the inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@inline_kernel
def shortest_turn(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Rotation:
    """Return the shortest rotation from direction a to direction b; the identity for opposite directions."""
    scale = 1.0 / math.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    w = 1.0 + (ax * bx + ay * by + az * bz) * scale
    x, y, z = (ay * bz - az * by) * scale, (az * bx - ax * bz) * scale, (ax * by - ay * bx) * scale
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if size < 1e-6:
        return 1.0, 0.0, 0.0, 0.0
    return w / size, x / size, y / size, z / size


@inline_kernel
def nlerp(a: Rotation, b: Rotation, t: float) -> Rotation:
    """Interpolate from a to b along the shorter arc by the share t: the chord, normalized."""
    sign = 1.0 if a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] >= 0.0 else -1.0
    w, x = a[0] + t * (sign * b[0] - a[0]), a[1] + t * (sign * b[1] - a[1])
    y, z = a[2] + t * (sign * b[2] - a[2]), a[3] + t * (sign * b[3] - a[3])
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if size < 1e-9:
        return a
    return w / size, x / size, y / size, z / size


@inline_kernel
def heading(q: Rotation) -> float:
    """Return the twist of q about the vertical [rad]."""
    return 2.0 * math.atan2(q[2], q[0])


@inline_kernel
def _logarithm(q: Rotation) -> Vector:
    """Return the logarithm of q: axis times half the angle."""
    sine = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    sign = 1.0 if q[0] >= 0.0 else -1.0
    scale = sign * math.atan2(sine, abs(q[0])) / sine if sine > 1e-9 else sign
    return q[1] * scale, q[2] * scale, q[3] * scale


@inline_kernel
def interpolate_from_rest(a: Rotation, b: Rotation, t: float) -> Rotation:
    """Interpolate between a and b linearly in their rotation vectors from the rest pose.

    The shorter arc between a and b can flip from one moment to the next, and a limb would jump. No joint turns by half
    a turn from its rest pose, so this interpolation is continuous.
    """
    ax, ay, az = _logarithm(a)
    bx, by, bz = _logarithm(b)
    x, y, z = ax + t * (bx - ax), ay + t * (by - ay), az + t * (bz - az)
    half = math.sqrt(x * x + y * y + z * z)
    scale = math.sin(half) / half if half > 1e-9 else 1.0
    return math.cos(half), x * scale, y * scale, z * scale


@inline_kernel
def rotation_row(rows: Any, n: int) -> Rotation:
    """Return row n of `rows` (N, 4)."""
    return rows[n, 0], rows[n, 1], rows[n, 2], rows[n, 3]


@inline_kernel
def yaw_rotation(angle: float) -> Rotation:
    """Return the rotation by `angle` [rad] about the vertical."""
    return math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0


Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

SUPPORT_HEIGHT = 0.05
"""The weight of a foot in placing the hips falls by a factor e per this height [m] over the lower foot."""
MIN_BONE_LENGTH = 0.02
"""A joint nearer to its parent than this [m] defines no bone direction."""
MIN_LEG, MAX_LEG = 0.3, 1.8
"""Range of plausible leg lengths [m]."""


@inline_kernel
def _forward_kinematics(
    theirs: Float64, ours: Float64, rotation: Float64, bones: Float64, known: Bool, root: Float64,
    offsets: Float32, parents: Int32, limb: Bool,
) -> None:  # fmt: skip
    """Compute all joints in the world: `theirs` (J, 7) position and rotation, `ours` (J, 4) rotation.

    Writes the local rotations to `rotation`.
    """
    for j in range(parents.shape[0]):
        p = max(parents[j], 0)
        q = (bones[j, 3], bones[j, 4], bones[j, 5], bones[j, 6]) if known[j] else (1.0, 0.0, 0.0, 0.0)
        above, x, y, z = (root[3], root[4], root[5], root[6]), root[0], root[1], root[2]
        if j > 0:
            above = theirs[p, 3], theirs[p, 4], theirs[p, 5], theirs[p, 6]
            x, y, z = theirs[p, 0], theirs[p, 1], theirs[p, 2]
        if known[j]:
            dx, dy, dz = rotate_vector(above, bones[j, 0], bones[j, 1], bones[j, 2])
            x, y, z = x + dx, y + dy, z + dz
        world = multiply(above, q)
        theirs[j, 0], theirs[j, 1], theirs[j, 2] = x, y, z
        theirs[j, 3], theirs[j, 4], theirs[j, 5], theirs[j, 6] = world
        if limb[j] and known[j + 1]:
            bx, by, bz = bones[j + 1, 0], bones[j + 1, 1], bones[j + 1, 2]
            if bx * bx + by * by + bz * bz > MIN_BONE_LENGTH * MIN_BONE_LENGTH:
                world = multiply(
                    world, shortest_turn(offsets[j + 1, 0], offsets[j + 1, 1], offsets[j + 1, 2], bx, by, bz)
                )
        ours[j, 0], ours[j, 1], ours[j, 2], ours[j, 3] = world
        local = multiply(inverse(rotation_row(ours, p)), world) if j > 0 else world
        rotation[j, 0], rotation[j, 1], rotation[j, 2], rotation[j, 3] = local


@inline_kernel
def _leg_ratio(bones: Float64, known: Bool, offsets: Float32, legs: Int32) -> float:
    """Return our leg length divided by theirs; 0 if theirs is unknown or implausible."""
    length, own = 0.0, 0.0
    for side in range(2):
        for k in range(1, 3):
            j = legs[4 * side + k]
            if not known[j]:
                return 0.0
            length += math.sqrt(bones[j, 0] ** 2 + bones[j, 1] ** 2 + bones[j, 2] ** 2)
            own += math.sqrt(offsets[j, 0] ** 2 + offsets[j, 1] ** 2 + offsets[j, 2] ** 2)
    return own / length if 2.0 * MIN_LEG < length < 2.0 * MAX_LEG else 0.0


@inline_kernel
def _foot_position(
    hips: Float64, ours: Float64, offsets: Float32, legs: Int32, soles: Float64, foot: Float64, side: int
) -> None:
    """Compute the ankle position and the sole height of a side: `foot` (4,) [m]."""
    x, y, z, p = hips[0], hips[1], hips[2], 0
    for k in range(4):
        j = legs[4 * side + k]
        dx, dy, dz = rotate_vector(rotation_row(ours, p), offsets[j, 0], offsets[j, 1], offsets[j, 2])
        x, y, z, p = x + dx, y + dy, z + dz, j
        if k == 2:
            foot[0], foot[1], foot[2] = x, y, z
    foot[3] = min(foot[1] - soles[0], y - soles[1])


@kernel("f8(f8[::1], f8[:,::1], f8[:,::1], b1[::1], f8[::1], f4[:,::1], i4[::1], b1[::1], i4[::1], f8[::1])")
def retarget_pose(
    hips: Float64, rotation: Float64, bones: Float64, known: Bool, root: Float64,
    offsets: Float32, parents: Int32, limb: Bool, legs: Int32, soles: Float64,
) -> float:  # fmt: skip
    """Retarget a captured pose: writes `hips` (3,) [m] and local `rotation` (J, 4); returns the lowest sole's height
    [m].

    In: `bones` (J, 7) position relative to the parent [m] and local rotation of the `known` (J,) joints, in our axes
    and with our rest pose; `root` (7,) pose of that skeleton's origin; `limb` (J,) joints whose bone to the next joint
    points where the source's does; `legs` (8,) upper leg, lower leg, foot and toes of both sides; `soles` (2,) heights
    [m] of ankle and toe joint of a standing foot. Sizes are scaled by leg length. The hips are placed so that the lower
    foot is at the scaled position of the source's.
    """
    joints = parents.shape[0]
    theirs, ours, feet = np.empty((joints, 7)), np.empty((joints, 4)), np.empty((2, 4))
    _forward_kinematics(theirs, ours, rotation, bones, known, root, offsets, parents, limb)
    ratio = _leg_ratio(bones, known, offsets, legs)
    scale = ratio if ratio > 0.0 else 1.0
    for c in range(3):
        hips[c] = scale * theirs[0, c]
    for side in range(2):
        _foot_position(hips, ours, offsets, legs, soles, feet[side], side)
    left, right = scale * theirs[legs[2], 1], scale * theirs[legs[6], 1]
    one, two = 0.0, 0.0
    if ratio > 0.0:
        one = math.exp(-min(max(left - right, 0.0) / SUPPORT_HEIGHT, 20.0))
        two = math.exp(-min(max(right - left, 0.0) / SUPPORT_HEIGHT, 20.0))
        one, two = one / (one + two), two / (one + two)
    raised = 0.0
    for c in range(3):
        way = one * (scale * theirs[legs[2], c] - feet[0, c]) + two * (scale * theirs[legs[6], c] - feet[1, c])
        hips[c] += way
        if c == 1:
            raised = way
    lowest: float = min(feet[0, 3], feet[1, 3]) + raised
    return lowest


TIME, BEAT = range(2)
"""Columns of `stamp`: arrival time of a buffered pose [s], and the danced beat at that time."""
STAMP_COLUMN, STAMP, GAP_BLEND, BLEND, ORIGIN_X, ORIGIN_Z, YAW, LAST_TURN, REQUEST_COLUMNS = range(9)
"""Columns of a request: column of `stamp` to search; the stamp to sample; weight of that pose against the one held
before a gap; weight of the captured pose against the dancer's own; position [m] and turn [rad] of the capture's origin
on the stage; and the dancer's last turn from the own heading [rad], including whole turns."""


@inline_kernel
def find_stamps(stamp: Float64, count: int, key: int, target: float) -> tuple[int, int, float]:
    """Return the two buffered poses around `target`, and the interpolation share between them."""
    size = stamp.shape[0]
    newer = (count - 1) % size
    if stamp[newer, key] <= target:
        return newer, newer, 0.0
    for back in range(2, min(count, size) + 1):
        older = (count - back) % size
        if stamp[older, key] <= target:
            gap = stamp[newer, key] - stamp[older, key]
            return older, newer, (target - stamp[older, key]) / gap if gap > 1e-9 else 1.0
        newer = older
    return newer, newer, 0.0


@inline_kernel
def _interpolate_hips(root: Float32, held: int, i: int, j: int, t: float, caught: float, c: int) -> float:
    """Return a coordinate of the hips between two buffered poses, blended with the held one by `caught`."""
    value = root[i, c] + t * (root[j, c] - root[i, c])
    mixed: float = root[held, c] + caught * (value - root[held, c])
    return mixed


@inline_kernel
def hips_on_stage(
    root: Float32, held: int, i: int, j: int, t: float, request: Float64, n: int, scale: float, mirrored: bool
) -> Vector:
    """Return the hip position on the stage [m] for row `n` of the requests."""
    caught = request[n, GAP_BLEND]
    x = _interpolate_hips(root, held, i, j, t, caught, 0) * (-scale if mirrored else scale)
    y = _interpolate_hips(root, held, i, j, t, caught, 1)
    z = _interpolate_hips(root, held, i, j, t, caught, 2) * scale
    c, s = math.cos(request[n, YAW]), math.sin(request[n, YAW])
    return request[n, ORIGIN_X] + c * x + s * z, y, request[n, ORIGIN_Z] + c * z - s * x


@inline_kernel
def interpolate_rotation(
    rotation: Float32, held: int, i: int, j: int, t: float, caught: float, joint: int, mirrored: bool
) -> Any:
    """Return a joint's local rotation between two buffered poses, blended with the held one by `caught`."""
    q = nlerp(rotation_row(rotation[i], joint), rotation_row(rotation[j], joint), t)
    if caught < 1.0:
        q = nlerp(rotation_row(rotation[held], joint), q, caught)
    return (q[0], q[1], -q[2], -q[3]) if mirrored else q


@kernel("void(f8[:,::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1)")
def captured_hips(
    place: Float64, request: Float64, root: Float32, rotation: Float32, stamp: Float64, count: int, scale: float,
    mirrored: bool,
) -> None:  # fmt: skip
    """Compute hip positions on the stage for the requests `request` (n, 8): `place` (n, 4), x, y, z [m] and heading
    [rad].

    The other parameters are as in `capture_blend_kernels.blend_captured`.
    """
    held = stamp.shape[0]
    for n in range(request.shape[0]):
        i, j, t = find_stamps(stamp, count, int(request[n, STAMP_COLUMN]), request[n, STAMP])
        place[n, 0], place[n, 1], place[n, 2] = hips_on_stage(root, held, i, j, t, request, n, scale, mirrored)
        place[n, 3] = request[n, YAW] + heading(
            interpolate_rotation(rotation, held, i, j, t, request[n, GAP_BLEND], 0, mirrored)
        )
