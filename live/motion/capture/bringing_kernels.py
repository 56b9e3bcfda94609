"""A captured body's pose brought over: a strange skeleton's bones and places onto ours."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.motion.capture.rotations_kernels import inverse, row_of, shortest_turn, times, turn_vector

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

NEAR = 0.05
"""A foot this high [m] over the lower one counts e times less when the hips are placed."""
SHORT = 0.02
"""What is nearer to its parent than this [m] says nothing of where the bone points."""
LEAST_LEG, MOST_LEG = 0.3, 1.8
"""Legs [m] that are believed."""


@part
def _chain(
    theirs: Float64, ours: Float64, rotation: Float64, bones: Float64, known: Bool, root: Float64,
    offsets: Float32, parents: Int32, limb: Bool,
) -> None:  # fmt: skip
    """Every joint in the world, `theirs` (J, 7) place and rotation, of `ours` (J, 4) the rotation; and that locally."""
    for j in range(parents.shape[0]):
        p = max(parents[j], 0)
        q = (bones[j, 3], bones[j, 4], bones[j, 5], bones[j, 6]) if known[j] else (1.0, 0.0, 0.0, 0.0)
        above, x, y, z = (root[3], root[4], root[5], root[6]), root[0], root[1], root[2]
        if j > 0:
            above = theirs[p, 3], theirs[p, 4], theirs[p, 5], theirs[p, 6]
            x, y, z = theirs[p, 0], theirs[p, 1], theirs[p, 2]
        if known[j]:
            dx, dy, dz = turn_vector(above, bones[j, 0], bones[j, 1], bones[j, 2])
            x, y, z = x + dx, y + dy, z + dz
        world = times(above, q)
        theirs[j, 0], theirs[j, 1], theirs[j, 2] = x, y, z
        theirs[j, 3], theirs[j, 4], theirs[j, 5], theirs[j, 6] = world
        if limb[j] and known[j + 1]:
            bx, by, bz = bones[j + 1, 0], bones[j + 1, 1], bones[j + 1, 2]
            if bx * bx + by * by + bz * bz > SHORT * SHORT:
                world = times(world, shortest_turn(offsets[j + 1, 0], offsets[j + 1, 1], offsets[j + 1, 2], bx, by, bz))
        ours[j, 0], ours[j, 1], ours[j, 2], ours[j, 3] = world
        local = times(inverse(row_of(ours, p)), world) if j > 0 else world
        rotation[j, 0], rotation[j, 1], rotation[j, 2], rotation[j, 3] = local


@part
def _ratio(bones: Float64, known: Bool, offsets: Float32, legs: Int32) -> float:
    """How long our legs are, theirs being 1; 0 where that is not known or not believed."""
    length, own = 0.0, 0.0
    for side in range(2):
        for k in range(1, 3):
            j = legs[4 * side + k]
            if not known[j]:
                return 0.0
            length += math.sqrt(bones[j, 0] ** 2 + bones[j, 1] ** 2 + bones[j, 2] ** 2)
            own += math.sqrt(offsets[j, 0] ** 2 + offsets[j, 1] ** 2 + offsets[j, 2] ** 2)
    return own / length if 2.0 * LEAST_LEG < length < 2.0 * MOST_LEG else 0.0


@part
def _leg(hips: Float64, ours: Float64, offsets: Float32, legs: Int32, soles: Float64, foot: Float64, side: int) -> None:
    """Where the ankle of a side is, and how high the sole: `foot` (4,) [m]."""
    x, y, z, p = hips[0], hips[1], hips[2], 0
    for k in range(4):
        j = legs[4 * side + k]
        dx, dy, dz = turn_vector(row_of(ours, p), offsets[j, 0], offsets[j, 1], offsets[j, 2])
        x, y, z, p = x + dx, y + dy, z + dz, j
        if k == 2:
            foot[0], foot[1], foot[2] = x, y, z
    foot[3] = min(foot[1] - soles[0], y - soles[1])


@kernel("f8(f8[::1], f8[:,::1], f8[:,::1], b1[::1], f8[::1], f4[:,::1], i4[::1], b1[::1], i4[::1], f8[::1])")
def bring_over(
    hips: Float64, rotation: Float64, bones: Float64, known: Bool, root: Float64,
    offsets: Float32, parents: Int32, limb: Bool, legs: Int32, soles: Float64,
) -> float:  # fmt: skip
    """A captured skeleton's pose on ours: writes `hips` (3,) [m] and local `rotation` (J, 4); returns the height [m]
    of the lowest sole.

    In: `bones` (J, 7) place from the parent [m] and local rotation of the joints that are `known` (J,), in our axes,
    rest pose as ours; `root` (7,) where that skeleton stands; `limb` (J,) joints whose bone, to the next joint, shall
    point where the source's does; `legs` (8,) upper leg, lower leg, foot and toes of both sides; `soles` (2,) heights
    [m] of ankle and toe joint of a standing foot. Sizes are scaled by the length of the legs; the hips are placed so
    that the lower foot is where the source's, scaled, is.
    """
    joints = parents.shape[0]
    theirs, ours, feet = np.empty((joints, 7)), np.empty((joints, 4)), np.empty((2, 4))
    _chain(theirs, ours, rotation, bones, known, root, offsets, parents, limb)
    ratio = _ratio(bones, known, offsets, legs)
    scale = ratio if ratio > 0.0 else 1.0
    for c in range(3):
        hips[c] = scale * theirs[0, c]
    for side in range(2):
        _leg(hips, ours, offsets, legs, soles, feet[side], side)
    left, right = scale * theirs[legs[2], 1], scale * theirs[legs[6], 1]
    one, two = 0.0, 0.0
    if ratio > 0.0:
        one = math.exp(-min(max(left - right, 0.0) / NEAR, 20.0))
        two = math.exp(-min(max(right - left, 0.0) / NEAR, 20.0))
        one, two = one / (one + two), two / (one + two)
    raised = 0.0
    for c in range(3):
        way = one * (scale * theirs[legs[2], c] - feet[0, c]) + two * (scale * theirs[legs[6], c] - feet[1, c])
        hips[c] += way
        if c == 1:
            raised = way
    lowest: float = min(feet[0, 3], feet[1, 3]) + raised
    return lowest
