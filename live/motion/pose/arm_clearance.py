"""Arm clearance: nobody's arms pass through the own trunk, or through another's arms and trunk; applied to poses."""

import numpy as np

from live.base.arrays import Bool, Float32
from live.motion.body_capsules import ARM_CHAINS, TRUNK_JOINTS
from live.motion.pose.arm_clearance_kernels import clear_arms
from live.motion.pose.hand_hold import HeldArms
from live.motion.pose.neighbour_clearance_kernels import draw_back_arms


def apply_arm_clearance(
    position: Float32, rotation: Float32, share: Float32, *, held: HeldArms | None = None, visible: Bool | None = None
) -> None:
    """Move arms in poses (A, J, 3) [m] and (A, J, 4), in place, by the share `share` (A,) of what is needed.

    Arms in a hold are not moved, and the arms of a couple may touch; without `held` nobody holds hands. Dancers who are
    not `visible` (A,) are in nobody's way; without it all are visible. There is no state: the same poses give the same.
    """
    count = len(position)
    held = HeldArms(count) if held is None else held
    visible = np.ones(count, np.bool_) if visible is None else visible
    drawn = np.empty((count, 2, 2, 3), np.float32)
    draw_back_arms(
        position, rotation, drawn, share, held.share, held.partner, held.together, visible, TRUNK_JOINTS, ARM_CHAINS
    )
    clear_arms(position, rotation, drawn, share, held.share, TRUNK_JOINTS, ARM_CHAINS)
