"""Masses of the body's segments on the engine's skeleton: centre of mass and angular momentum about it.

Shares of the mass, centres and radii of gyration are those of men in de Leva (1996, "Adjustments to
Zatsiorsky-Seluyanov's segment inertia parameters", J. Biomech. 29, table 4), on our bones: limbs are scaled by their
own bone, trunk and head by the height. The middle of the trunk is divided between `spine` and `chest`. All is per
kilogram, so the weight of the dancer does not matter.

A point of a segment is the hips plus X a: X (3, 3J) are all world rotations side by side, and a (3J,) has the bones on
the way from the hips. So with r = X a and v = Ẋ a of all mass points, Σ m r vᵀ = X K Ẋᵀ with one constant matrix
K = Σ m a aᵀ, and the angular momentum is the axial vector of that.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion.skeleton import SKELETON

_SEGMENTS: Final = (
    # joint, share of the mass, centre in the joint's rest axes [m], radii of gyration about x, y, z [m]
    ("hips", 0.1117, (0.0, -0.009, 0.0), (0.078, 0.084, 0.088)),
    ("spine", 0.08165, (0.0, 0.045, 0.0), (0.061, 0.098, 0.086)),
    ("chest", 0.08165, (0.0, 0.031, 0.0), (0.061, 0.098, 0.086)),
    ("upperChest", 0.1596, (0.0, 0.065, 0.0), (0.076, 0.110, 0.119)),
    ("head", 0.0694, (0.0, 0.066, 0.0), (0.075, 0.062, 0.072)),
)
_LIMBS: Final = (
    # the same for the left side
    ("UpperArm", 0.0271, (0.153, 0.0, 0.0), (0.042, 0.073, 0.073)),
    ("LowerArm", 0.0162, (0.112, 0.0, 0.0), (0.030, 0.066, 0.066)),
    ("Hand", 0.0061, (0.067, 0.0, 0.0), (0.034, 0.053, 0.043)),
    ("UpperLeg", 0.1416, (0.0, -0.170, 0.0), (0.137, 0.062, 0.137)),
    ("LowerLeg", 0.0433, (0.0, -0.174, 0.0), (0.098, 0.040, 0.098)),
    ("Foot", 0.0137, (0.0, -0.045, 0.060), (0.063, 0.063, 0.031)),
)


def _segments() -> dict[int, tuple[float, Float64, Float64]]:
    rows = {SKELETON.index(name): (share, np.array(at), np.array(radii)) for name, share, at, radii in _SEGMENTS}
    for name, share, at, radii in _LIMBS:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            rows[SKELETON.index(side + name)] = share, np.array(at) * (sign, 1.0, 1.0), np.array(radii)
    return rows


SEGMENTS: Final = _segments()
"""By joint: share of the body's mass, centre in the joint's axes [m] (3,), radii of gyration about them [m] (3,)."""


def _levers() -> tuple[Float64, Float64]:
    joints = SKELETON.joint_count
    way = np.zeros((joints, 3 * joints))
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            way[joint] = way[parent]
            way[joint, 3 * parent : 3 * parent + 3] += SKELETON.offsets[joint]
    centre, moment = np.zeros(3 * joints), np.zeros((3 * joints, 3 * joints))
    for joint, (share, at, radii) in SEGMENTS.items():
        own = slice(3 * joint, 3 * joint + 3)
        lever = way[joint].copy()
        lever[own] += at
        centre += share * lever
        moment += share * np.outer(lever, lever)
        moment[own, own] += share * np.diag(0.5 * (radii**2).sum() - radii**2)
    return centre, moment - np.outer(centre, centre)


CENTRE_LEVER, MOMENT_MATRIX = _levers()
"""The centre of mass is the hips plus X `CENTRE_LEVER` (3J,) [m]; K about it is `MOMENT_MATRIX` (3J, 3J) [m²]."""


def rotation_row(matrices: Float) -> Float64:
    """Return world rotation matrices (..., J, 3, 3) side by side, X (..., 3, 3J)."""
    moved = np.swapaxes(matrices, -3, -2)
    return np.ascontiguousarray(moved, np.float64).reshape(*moved.shape[:-2], -1)


def centre_of_mass(hips: Float, row: Float64) -> Float64:
    """Return the centre of mass (..., 3) [m] of poses with the hips at (..., 3) [m] and rotations X (..., 3, 3J)."""
    return np.asarray(hips + row @ CENTRE_LEVER, np.float64)


def angular_momentum(row: Float64, rate: float) -> Float64:
    """Return the angular momentum about the centre of mass between consecutive poses, per mass [m²/s].

    `row` (..., T, 3, 3J) are their rotations X, `rate` their number per second; the result is (..., T - 1, 3).
    """
    turned = (row[..., :-1, :, :] @ MOMENT_MATRIX) @ np.swapaxes(row[..., 1:, :, :], -1, -2)
    return axial(turned) * rate


def axial(matrix: Float64) -> Float64:
    """Return the vector a (..., 3) with a_k = Σ ε_kij A_ij of matrices A (..., 3, 3): Σ r × v for A = Σ r vᵀ."""
    return np.stack(
        (
            matrix[..., 1, 2] - matrix[..., 2, 1],
            matrix[..., 2, 0] - matrix[..., 0, 2],
            matrix[..., 0, 1] - matrix[..., 1, 0],
        ),
        axis=-1,
    )


def joint_inertias() -> Float64:
    """Return the moments of inertia that rotations of each joint move, per kilogram of the body [m²], shape (J,).

    In the rest pose with the arms lowered halfway, averaged over all axes; the root's is that of the whole body about
    the hips. With them the kinetic energy of a dance is found without forward kinematics, up to the coupling of joints.
    """
    place = SKELETON.rest_positions().astype(np.float64)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        shoulder = place[SKELETON.index(f"{side}UpperArm")].copy()
        for name in ("LowerArm", "Hand"):
            joint = SKELETON.index(side + name)
            way = abs(place[joint, 0] - shoulder[0]) * math.sqrt(0.5)
            place[joint] = shoulder + np.array((sign * way, -way, 0.0))
    inertia = np.zeros(SKELETON.joint_count)
    for joint, (share, at, radii) in SEGMENTS.items():
        own = share * float(np.square(radii).sum()) / 3.0
        moved = joint
        while moved >= 0:
            inertia[moved] += own + share * 2.0 / 3.0 * float(np.square(place[joint] + at - place[moved]).sum())
            moved = int(SKELETON.parents[moved])
    return inertia
