"""The dancer's body as capsules, for contact: a trunk with an elliptical cross-section, arms with a radius.

The trunk's axis goes from the hips towards the neck through the chest; its wide side follows the line between the hips
below and the line between the shoulders above. Sizes are those of the usual drawn body within 3 cm, 1 cm on average.
"""

from typing import Final

import numpy as np

from live.base.arrays import Int32
from live.motion.skeleton import SKELETON

TRUNK_HALF_WIDTH: Final = 0.125
"""Half the trunk's width [m]; the waist is 1.7 cm narrower, hips and chest 1.5 cm wider."""
TRUNK_HALF_DEPTH: Final = 0.09
"""Half the trunk's depth [m]."""
TRUNK_END: Final = 0.09
"""How far the trunk goes beyond both ends of its axis [m]."""
TRUNK_AXIS_SHARE: Final = 0.85
"""Share of the way from the hips to the neck at which the axis ends."""
FOREARM_RADIUS: Final = 0.03
"""Radius of a forearm [m]: 0.034 at the elbow, 0.025 at the wrist."""
ARMS_APART: Final = 2.0 * FOREARM_RADIUS
"""The axes of two arms that touch are this far apart [m]."""
HAND_TO_TRUNK: Final = 0.12
"""A wrist that touches another's trunk is this far from the line between that one's hips and neck [m]."""
TRUNK_JOINTS: Final[Int32] = np.array(
    [
        SKELETON.index(name)
        for name in ("hips", "chest", "neck", "leftUpperLeg", "rightUpperLeg", "leftShoulder", "rightShoulder")
    ],
    np.int32,
)
"""Joints that place the trunk: its axis, the bend of it, and the wide side below and above, shape (7,)."""
ARM_CHAINS: Final[Int32] = np.array(
    [[SKELETON.index(side + joint) for joint in ("UpperArm", "LowerArm", "Hand")] for side in ("left", "right")],
    np.int32,
)
"""Shoulder, elbow and wrist of the left and the right arm, shape (2, 3)."""
