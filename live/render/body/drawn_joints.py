"""Drawn joints: those of the skeleton, and joints for fingers, face and breath that only the picture has.

A detail joint turns about its pivot by a rotation vector that is linear in the columns of a dancer's expression
(`live.base.body.expression`): two terms, each a column and the rotation vector for 1. The vector is in the axes of the
rest pose. Detail joints hang on a joint of the skeleton, or on another detail joint that hangs on one.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Int32
from live.base.body.expression import (
    BLINK_LEFT,
    BLINK_RIGHT,
    BREATH,
    BROW,
    CURL,
    FACE_SIZE,
    FINGERS,
    GAZE_PITCH,
    GAZE_YAW,
    HAND_SIZE,
    MOUTH_OPEN,
    SMILE,
    SPREAD,
)
from live.motion.skeleton import SKELETON

Vector = tuple[float, float, float]
Term = tuple[int, Vector]

EXPRESSION_SIZE: Final = FACE_SIZE + 2 * HAND_SIZE
"""Numbers of a dancer's expression: the face, the left hand, the right hand."""
_NONE: Final[Term] = (0, (0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True)
class DetailJoint:
    """A joint of fingers, face or breath."""

    name: str
    parent: str
    pivot: Vector
    """Centre of its rotation in the rest pose [m]."""
    first: Term
    """Column of the expression, and the rotation vector [rad] for 1 in it."""
    second: Term = _NONE


# Left hand: knuckle and middle joint [m], rotation vectors of both for a fist, and of the knuckle for spread fingers.
_FINGER: Final[dict[str, tuple[Vector, Vector, Vector, Vector, Vector]]] = {
    "Thumb": ((0.702, 1.374, 0.016), (0.740, 1.368, 0.040), (0.25, 0.55, -0.45), (0.2, 0.75, -0.3), (0.0, -0.35, 0.1)),
    "Index": ((0.765, 1.378, 0.020), (0.802, 1.375, 0.021), (0.0, 0.0, -1.35), (0.0, 0.0, -1.65), (0.0, -0.16, 0.0)),
    "Middle": ((0.768, 1.379, 0.000), (0.808, 1.376, 0.000), (0.0, 0.0, -1.40), (0.0, 0.0, -1.65), (0.0, -0.03, 0.0)),
    "Ring": ((0.765, 1.378, -0.019), (0.802, 1.375, -0.020), (0.0, 0.0, -1.45), (0.0, 0.0, -1.65), (0.0, 0.10, 0.0)),
    "Little": ((0.758, 1.376, -0.037), (0.786, 1.373, -0.039), (0.0, 0.0, -1.50), (0.0, 0.0, -1.6), (0.0, 0.24, 0.0)),
}


def _mirrored_point(point: Vector, sign: float) -> Vector:
    return sign * point[0], point[1], point[2]


def _mirrored_turn(turn: Vector, sign: float) -> Vector:
    """Reflect a rotation vector (a pseudovector) in the plane x = 0."""
    return turn[0], sign * turn[1], sign * turn[2]


def _hand(side: str, sign: float, start: int) -> list[DetailJoint]:
    rows = []
    for number, name in enumerate(FINGERS):
        knuckle, middle, turn, bend, spread = _FINGER[name]
        curl = start + CURL.start + number
        rows += [
            DetailJoint(
                f"{side}{name}Proximal", f"{side}Hand", _mirrored_point(knuckle, sign),
                (curl, _mirrored_turn(turn, sign)), (start + SPREAD, _mirrored_turn(spread, sign)),
            ),
            DetailJoint(
                f"{side}{name}Distal", f"{side}{name}Proximal", _mirrored_point(middle, sign),
                (curl, _mirrored_turn(bend, sign)),
            ),
        ]  # fmt: skip
    return rows


def _half_face(side: str, sign: float, blink: int) -> list[DetailJoint]:
    eye = _mirrored_point((0.0315, 1.600, 0.066), sign)
    return [
        DetailJoint(f"{side}Eye", "head", eye, (GAZE_YAW, (0.0, 1.0, 0.0)), (GAZE_PITCH, (-1.0, 0.0, 0.0))),
        # the upper lid closes over the eye, and goes with a gaze up or down
        DetailJoint(f"{side}Lid", "head", eye, (blink, (0.62, 0.0, 0.0)), (GAZE_PITCH, (-0.55, 0.0, 0.0))),
        # far pivots: brows and corners of the mouth glide more than they turn
        DetailJoint(f"{side}Brow", "head", (0.0, 1.610, 0.0), (BROW, _mirrored_turn((-0.075, 0.0, 0.03), sign))),
        DetailJoint(f"{side}Mouth", "head", (0.0, 1.560, 0.0), (SMILE, _mirrored_turn((-0.070, 0.055, 0.0), sign))),
    ]


DETAIL_JOINTS: Final = (
    *_hand("left", 1.0, FACE_SIZE),
    *_hand("right", -1.0, FACE_SIZE + HAND_SIZE),
    *_half_face("left", 1.0, BLINK_LEFT),
    *_half_face("right", -1.0, BLINK_RIGHT),
    DetailJoint("jaw", "head", (0.0, 1.578, 0.012), (MOUTH_OPEN, (0.22, 0.0, 0.0))),
    DetailJoint("breath", "upperChest", (0.0, 1.200, -0.090), (BREATH, (-0.028, 0.0, 0.0))),
)
"""All detail joints; their numbers follow those of the skeleton."""
DRAWN_NAMES: Final = (*SKELETON.names, *(joint.name for joint in DETAIL_JOINTS))
"""Names of all drawn joints by number."""
DRAWN_COUNT: Final = len(DRAWN_NAMES)
"""Number of drawn joints."""


def _opposite(name: str) -> str:
    for side, other in (("left", "right"), ("right", "left")):
        if name.startswith(side):
            return other + name.removeprefix(side)
    return name


DRAWN_MIRROR: Final = tuple(DRAWN_NAMES.index(_opposite(name)) for name in DRAWN_NAMES)
"""For each drawn joint the number of the opposite one."""


def _anchors() -> Int32:
    of = {joint.name: joint.parent for joint in DETAIL_JOINTS}
    found = []
    for joint in DETAIL_JOINTS:
        parent = joint.parent
        found.append(SKELETON.index(of.get(parent, parent)))
    return np.array(found, np.int32)


ANCHORS: Final = _anchors()
"""The joint of the skeleton that each detail joint hangs on, directly or by its parent, shape (DRAWN_COUNT - J,)."""


def shader_rows() -> Float32:
    """Return for each detail joint four texels, shape (D, 4, 4): pivot and skeleton joint; rotation vector and column
    of both terms; the parent's number among the detail joints, -1 if it hangs on the skeleton."""
    names = [joint.name for joint in DETAIL_JOINTS]
    rows = np.zeros((len(DETAIL_JOINTS), 4, 4), np.float32)
    for number, joint in enumerate(DETAIL_JOINTS):
        rows[number, 0] = (*joint.pivot, ANCHORS[number])
        rows[number, 1] = (*joint.first[1], joint.first[0])
        rows[number, 2] = (*joint.second[1], joint.second[0])
        rows[number, 3, 0] = names.index(joint.parent) if joint.parent in names else -1
    return rows
