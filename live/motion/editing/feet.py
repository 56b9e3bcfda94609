"""Where the feet of a clip are: balls, ankles and the height of the soles."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

Float = npt.NDArray[np.floating]

ANKLES: Final = (SKELETON.index("leftFoot"), SKELETON.index("rightFoot"))
BALLS: Final = (SKELETON.index("leftToes"), SKELETON.index("rightToes"))
"""The toe joints: the balls of the feet, on which dancers pivot and which stay when a heel rises."""


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """World positions [m] of the left and the right foot at T samples, float64."""

    ankle: Float
    """Ankle joints, shape (T, 2, 3)."""
    ball: Float
    """Toe joints, shape (T, 2, 3)."""

    @property
    def height(self) -> Float:
        """Height of each sole over the floor [m]: of heel and ball the lower, shape (T, 2)."""
        heel = self.ankle[..., 1] - SOLE_BELOW_ANKLE
        return np.asarray(np.minimum(heel, self.ball[..., 1] - TOES_OVER_SOLE))


def find_feet(clip: Clip) -> Feet:
    """Positions of the feet of a clip, computed in float64."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return Feet(positions[:, ANKLES], positions[:, BALLS])
