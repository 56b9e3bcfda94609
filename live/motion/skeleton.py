"""The engine's skeleton: 22 joints with VRM humanoid names, 1.7 m tall, T-pose facing +z as rest pose.

In the rest pose every joint rotation is the identity (world axes), the arms point along ±x (left = +x, because the
dancer faces the audience at +z), Y is up and the soles are at y = 0. `BONE_TIPS` gives the ends of the last bones
(crown, fingertips, toe tips) for file formats that need them.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Int32

BODY_HEIGHT: Final = 1.7
"""Height of the crown over the floor in the rest pose [m]."""
SOLE_BELOW_ANKLE: Final = 0.085
"""Height [m] of the ankle joint (`leftFoot`) over the floor when the foot is flat."""


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """Joints in depth-first order; offsets are in the parent's rest axes (J joints)."""

    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, -1 for the root, shape (J,)."""
    offsets: Float32
    """From the parent to the joint in the rest pose [m], shape (J, 3); the root's is its rest position."""

    @property
    def joint_count(self) -> int:
        """Number of joints J."""
        return len(self.names)

    def index(self, name: str) -> int:
        """Return the index of the joint called `name`; raises ValueError if there is none."""
        return self.names.index(name)

    def rest_positions(self) -> Float32:
        """World positions of the joints in the rest pose [m], shape (J, 3)."""
        positions = np.array(self.offsets, np.float32)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                positions[joint] += positions[parent]
        return positions


# name, parent, offset from the parent [m]; proportions of an adult dancer 1.70 m tall
_SPINE: Final = (
    ("hips", "", (0.0, 0.935, 0.0)),
    ("spine", "hips", (0.0, 0.095, 0.0)),
    ("chest", "spine", (0.0, 0.120, -0.005)),
    ("upperChest", "chest", (0.0, 0.125, -0.005)),
    ("neck", "upperChest", (0.0, 0.150, 0.0)),
    ("head", "neck", (0.0, 0.090, 0.010)),
)
_ARM: Final = (
    ("Shoulder", "upperChest", (0.030, 0.105, 0.005)),
    ("UpperArm", "Shoulder", (0.135, 0.0, -0.005)),
    ("LowerArm", "UpperArm", (0.265, 0.0, 0.0)),
    ("Hand", "LowerArm", (0.245, 0.0, 0.0)),
)
_LEG: Final = (
    ("UpperLeg", "hips", (0.090, -0.045, 0.0)),
    ("LowerLeg", "UpperLeg", (0.0, -0.415, 0.0)),
    ("Foot", "LowerLeg", (0.0, -0.390, 0.0)),
    ("Toes", "Foot", (0.0, -0.065, 0.130)),
)


def _side_rows(
    rows: tuple[tuple[str, str, tuple[float, float, float]], ...], side: str, sign: float
) -> list[tuple[str, str, tuple[float, float, float]]]:
    own = {name for name, _, _ in rows}
    return [
        (side + name, side + parent if parent in own else parent, (sign * x, y, z)) for name, parent, (x, y, z) in rows
    ]


def _build() -> Skeleton:
    rows = list(_SPINE)
    rows += _side_rows(_ARM, "left", 1.0) + _side_rows(_ARM, "right", -1.0)
    rows += _side_rows(_LEG, "left", 1.0) + _side_rows(_LEG, "right", -1.0)
    names = tuple(name for name, _, _ in rows)
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in rows], np.int32)
    offsets = np.array([offset for _, _, offset in rows], np.float32)
    parents.setflags(write=False)
    offsets.setflags(write=False)
    return Skeleton(names, parents, offsets)


SKELETON: Final = _build()
"""The skeleton of every dancer."""

JOINT_COUNT: Final = SKELETON.joint_count
"""Number of joints of the engine's skeleton: 22."""

MIRROR: Final = tuple(
    SKELETON.index(name.replace("left", "right", 1) if name.startswith("left") else name.replace("right", "left", 1))
    for name in SKELETON.names
)
"""For each joint the index of the opposite joint (T042)."""


_HEAD: Final = float(SKELETON.rest_positions()[SKELETON.index("head"), 1])
_HAND: Final = 0.18
"""From the wrist to the fingertips [m]."""
_TOES: Final = 0.07
"""From the ball of the foot to the toe tip [m]."""

BONE_TIPS: Final = {
    SKELETON.index("head"): (0.0, round(BODY_HEIGHT - _HEAD, 6), 0.0),
    SKELETON.index("leftHand"): (_HAND, 0.0, 0.0),
    SKELETON.index("rightHand"): (-_HAND, 0.0, 0.0),
    SKELETON.index("leftToes"): (0.0, 0.0, _TOES),
    SKELETON.index("rightToes"): (0.0, 0.0, _TOES),
}
"""For each joint without children the end of its bone in the rest pose, relative to the joint [m]."""
