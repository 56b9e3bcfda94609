"""Arm clearance: nobody's arms pass through the own trunk, or through another's arms and trunk; applied to poses."""

from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.pose.arm_clearance_kernels import clear_arms
from live.motion.pose.body_capsules import ARM_CHAINS, TRUNK_JOINTS
from live.motion.pose.hand_hold import HeldArms

NOBODY_HELD: Final = HeldArms(0)
"""No dancer's arm is in a hold."""


def apply_arm_clearance(
    position: Float32, rotation: Float32, share: Float64, *, held: HeldArms | None = None, visible: Bool | None = None
) -> None:
    """Move arms in poses (A, J, 3) [m] and (A, J, 4), in place, by the share `share` (A,) of what is needed.

    Arms in a hold are not moved, and the arms of a couple may touch; without `held` nobody holds hands. Dancers who are
    not `visible` (A,) are in nobody's way; without it all are visible. There is no state: the same poses give the same.
    """
    held = NOBODY_HELD if held is None else held
    visible = np.ones(len(position), np.bool_) if visible is None else visible
    clear_arms(position, rotation, share, held.share, held.partner, held.together, visible, TRUNK_JOINTS, ARM_CHAINS)


def clear_own_trunk(clip: Clip) -> Clip:
    """Return the clip with the arms pushed out of the own trunk, as in the live show; other joints are unchanged."""
    position, rotation = forward_kinematics(clip.root_position, clip.rotation)
    world = np.ascontiguousarray(position, np.float32), np.ascontiguousarray(rotation, np.float32)
    before = world[1].copy()
    samples = clip.sample_count
    apply_arm_clearance(*world, np.ones(samples), visible=np.zeros(samples, np.bool_))
    moved = (world[1] != before).any(axis=(1, 2))
    mended = clip.rotation.copy()
    mended[moved] = local_rotations(world[1][moved])
    return replace(clip, rotation=np.ascontiguousarray(quaternion.align_signs(mended), np.float32))
