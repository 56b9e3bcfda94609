"""What a motion file does not say: which axis is up, how long a unit is, what the root's OFFSET is for.

All three are decided by plausibility: people mostly stand upright, are 1.2 to 2.2 m tall and keep a foot on the floor.
"""

import math
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.motion.bvh import BvhMotion
from live.motion.bvh_pose import LocalPose, WorldPose, local_pose, world_pose
from live.motion.joint_map import SourceBody
from live.motion.skeleton import BODY_HEIGHT, SKELETON

Float = npt.NDArray[np.floating]
UpAxis = Literal["Y", "Z"]

ENGINE_LEG: Final = float(
    np.linalg.norm(SKELETON.offsets[SKELETON.index("leftLowerLeg")])
    + np.linalg.norm(SKELETON.offsets[SKELETON.index("leftFoot")])
)
"""Length of the engine's leg from hip to ankle [m]."""
BODY_HEIGHT_RANGE: Final = (1.2, 2.2)
"""Heights [m] that are believed."""
UNITS: Final = (1.0, 0.01, 0.1, 0.001, 0.0254, 0.3048, 0.0254 / 0.45)
"""Metres per unit in use: m, cm, dm, mm, inch, foot, and the CMU's Acclaim unit (0.45 units to the inch)."""


def leg_length(body: SourceBody, positions: Float) -> float:
    """Hip to ankle along the bones [file units], median over the frames and both sides; `positions` (T, J, 3)."""
    lengths = []
    for side in ("left", "right"):
        hip, knee, ankle = (body.joint(side + name) for name in ("UpperLeg", "LowerLeg", "Foot"))
        bones = (positions[:, knee] - positions[:, hip], positions[:, ankle] - positions[:, knee])
        lengths.append(sum(np.linalg.norm(bone, axis=-1) for bone in bones))
    return float(np.median(lengths))


def body_height(leg: float) -> float:
    """Height of a person with legs of this length from hip to ankle (same unit), by the engine's proportions."""
    return leg * BODY_HEIGHT / ENGINE_LEG


def find_unit(leg: float) -> float | None:
    """Metres per unit for which a person with legs of `leg` units is nearest to 1.7 m; None if none is believable."""
    if not leg > 0.0:
        return None
    best = min(UNITS, key=lambda unit: abs(math.log(body_height(leg) * unit / BODY_HEIGHT)))
    low, high = BODY_HEIGHT_RANGE
    return best if low <= body_height(leg) * best <= high else None


def find_up(body: SourceBody, positions: Float) -> UpAxis | None:
    """The axis along which the body stands most of the time; None if it lies or hangs; `positions` (T, J, 3)."""
    feet = 0.5 * (positions[:, body.joint("leftFoot")] + positions[:, body.joint("rightFoot")])
    shoulders = 0.5 * (positions[:, body.joint("leftUpperArm")] + positions[:, body.joint("rightUpperArm")])
    body_axis = shoulders - feet
    length = np.linalg.norm(body_axis, axis=-1, keepdims=True)
    mean = np.mean(body_axis / np.maximum(length, 1e-9), axis=0)
    if max(mean[1], mean[2]) < 0.4:
        return None
    return "Y" if mean[1] >= mean[2] else "Z"


def find_root_offset(
    motion: BvhMotion, body: SourceBody, positions: Float, up: UpAxis
) -> Literal["zero", "add", "replace"] | None:
    """Whether the root's OFFSET is to be added to its position channels, or is already in them.

    `positions` (T, J, 3) are those with the OFFSET added, as the format says (T164). The reading that brings the
    lowest joint nearer to zero height wins; one frame alone is no evidence (None: then add).
    """
    if not motion.offsets[0].any() or not any(letter.islower() for letter in motion.channels[0]):
        return "zero"
    if motion.frame_count < 2:
        return None
    axis = "XYZ".index(up)
    floor = float(np.median(positions[:, :, axis].min(axis=1)))
    raised = float(motion.offsets[0, axis])
    if abs(raised) < 0.05 * leg_length(body, positions):
        return None  # both readings stand equally well
    return "add" if abs(floor) <= abs(floor - raised) else "replace"


def standing_pose(motion: BvhMotion, body: SourceBody, up: UpAxis | None) -> tuple[LocalPose, WorldPose, UpAxis]:
    """Local and world pose with the root's OFFSET used as it should be, and the up axis (found unless given)."""
    local = local_pose(motion)
    world = world_pose(motion, local)
    axis: UpAxis = up or find_up(body, world.positions) or "Y"
    if find_root_offset(motion, body, world.positions, axis) == "replace":
        local = local_pose(motion, "replace")
        world = world_pose(motion, local)
    return local, world, axis
