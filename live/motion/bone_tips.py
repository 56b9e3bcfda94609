"""Where the engine's last bones end: crown, fingertips and tips of the toes, for files that must say so."""

from typing import Final

from live.motion.skeleton import BODY_HEIGHT, SKELETON

_HEAD: Final = float(SKELETON.rest_positions()[SKELETON.index("head"), 1])
_HAND: Final = 0.18
"""From the wrist to the fingertips [m]."""
_TOES: Final = 0.07
"""From the ball of the foot to the tip of the toes [m]."""

BONE_TIPS: Final = {
    SKELETON.index("head"): (0.0, round(BODY_HEIGHT - _HEAD, 6), 0.0),
    SKELETON.index("leftHand"): (_HAND, 0.0, 0.0),
    SKELETON.index("rightHand"): (-_HAND, 0.0, 0.0),
    SKELETON.index("leftToes"): (0.0, 0.0, _TOES),
    SKELETON.index("rightToes"): (0.0, 0.0, _TOES),
}
"""For each joint without children the end of its bone in the rest pose, seen from the joint [m]."""
