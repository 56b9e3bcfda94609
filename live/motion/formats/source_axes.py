"""Detection of the up axis and the length unit of a motion file that does not state them.

Both are decided by plausibility: people mostly stand upright and are 1.2 to 2.2 m tall.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion.formats.source_motion import LocalPose, SourceMotion, UpAxis, WorldPose, world_pose
from live.motion.retarget.source_body import SourceBody
from live.motion.skeleton import BODY_HEIGHT, SKELETON

ENGINE_LEG: Final = float(
    np.linalg.norm(SKELETON.offsets[SKELETON.index("leftLowerLeg")])
    + np.linalg.norm(SKELETON.offsets[SKELETON.index("leftFoot")])
)
"""Length of the engine's leg from hip to ankle [m]."""
BODY_HEIGHT_RANGE: Final = (1.2, 2.2)
"""Plausible body heights [m]."""
UNITS: Final = (1.0, 0.01, 0.1, 0.001, 0.0254, 0.3048, 0.0254 / 0.45)
"""Usual metres per unit: m, cm, dm, mm, inch, foot, and the CMU's Acclaim unit (0.45 units per inch)."""


def leg_length(body: SourceBody, positions: Float) -> float:
    """Leg length, hip to ankle along the bones [file units], median of frames and both sides; `positions` (T, J, 3)."""
    lengths = []
    for side in ("left", "right"):
        hip, knee, ankle = (body.joint(side + name) for name in ("UpperLeg", "LowerLeg", "Foot"))
        bones = (positions[:, knee] - positions[:, hip], positions[:, ankle] - positions[:, knee])
        lengths.append(sum(np.linalg.norm(bone, axis=-1) for bone in bones))
    return float(np.median(lengths))


def body_height(leg: float) -> float:
    """Return the body height for this leg length from hip to ankle (same unit), by the engine's proportions."""
    return leg * BODY_HEIGHT / ENGINE_LEG


def find_unit(leg: float) -> float | None:
    """Metres per unit that give a body height nearest to 1.7 m for `leg` units; None if none is plausible."""
    if not leg > 0.0:
        return None
    best = min(UNITS, key=lambda unit: abs(math.log(body_height(leg) * unit / BODY_HEIGHT)))
    low, high = BODY_HEIGHT_RANGE
    return best if low <= body_height(leg) * best <= high else None


def find_up(body: SourceBody, positions: Float) -> UpAxis | None:
    """Return the axis along which the body stands most of the time; None if unclear; `positions` (T, J, 3)."""
    feet = 0.5 * (positions[:, body.joint("leftFoot")] + positions[:, body.joint("rightFoot")])
    shoulders = 0.5 * (positions[:, body.joint("leftUpperArm")] + positions[:, body.joint("rightUpperArm")])
    body_axis = shoulders - feet
    length = np.linalg.norm(body_axis, axis=-1, keepdims=True)
    mean = np.mean(body_axis / np.maximum(length, 1e-9), axis=0)
    if max(mean[1], mean[2]) < 0.4:
        return None
    return "Y" if mean[1] >= mean[2] else "Z"


def standing_pose(motion: SourceMotion, body: SourceBody, up: UpAxis | None) -> tuple[WorldPose, UpAxis]:
    """Return the world pose in file units and axes, and the up axis: `up`, else the format's, else detected."""
    world = world_pose(motion.parents, LocalPose(motion.translation, motion.rotation))
    return world, up or motion.up or find_up(body, world.positions) or "Y"
