"""Drawn joints: those of the skeleton, and joints for fingers, face, breath and muscles that only the picture has.

A detail joint turns about its pivot by a rotation vector that is linear in the columns of a dancer's expression
(`live.base.body.expression`) and in angles of the skeleton's joints (`Driver`): two terms, each a column or a driver,
and the rotation vector for 1. The vector is in the axes of the rest pose. Detail joints hang on a joint of the
skeleton, or on another detail joint before them.
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
    GAZE_PITCH,
    GAZE_YAW,
    HAND_SIZE,
    MOUTH_OPEN,
    SMILE,
    SPREAD,
)
from live.motion.skeleton import SKELETON
from live.render.body.fingers import FINGERS, PHALANGES, Vector
from live.render.body.head_cage import EYE_CENTRE
from live.render.body.muscles import MUSCLES, Driver

Term = tuple[int | Driver, Vector]

EXPRESSION_SIZE: Final = FACE_SIZE + 2 * HAND_SIZE
"""Numbers of a dancer's expression: the face, the left hand, the right hand."""
_NONE: Final[Term] = (0, (0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True)
class DetailJoint:
    """A joint of fingers, face, breath or muscles."""

    name: str
    parent: str
    pivot: Vector
    """Centre of its rotation in the rest pose [m]."""
    first: Term
    """Column of the expression or driver, and the rotation vector [rad] for 1 of it."""
    second: Term = _NONE


def _mirrored_point(point: Vector, sign: float) -> Vector:
    return sign * point[0], point[1], point[2]


def _mirrored_turn(turn: Vector, sign: float) -> Vector:
    """Reflect a rotation vector (a pseudovector) in the plane x = 0."""
    return turn[0], sign * turn[1], sign * turn[2]


def _hand(side: str, sign: float, start: int) -> list[DetailJoint]:
    rows = []
    for number, finger in enumerate(FINGERS):
        parent = f"{side}Hand"
        for phalanx, (name, turn) in enumerate(zip(PHALANGES, finger.curl, strict=True)):
            curl = (start + CURL.start + number, _mirrored_turn(turn, sign))
            spread = (start + SPREAD, _mirrored_turn(finger.spread, sign))
            place = _mirrored_point(finger.places[phalanx], sign)
            rows.append(DetailJoint(f"{side}{finger.name}{name}", parent, place, curl, _NONE if phalanx else spread))
            parent = rows[-1].name
    return rows


def _muscles(side: str, sign: float) -> list[DetailJoint]:
    return [
        DetailJoint(
            side + muscle.name,
            muscle.parent if muscle.parent in SKELETON.names else side + muscle.parent,
            _mirrored_point(muscle.pivot, sign),
            (
                Driver(side + muscle.driver.joint, _mirrored_turn(muscle.driver.axis, sign), muscle.driver.least),
                _mirrored_turn(muscle.turn, sign),
            ),
        )
        for muscle in MUSCLES
    ]


def _half_face(side: str, sign: float, blink: int) -> list[DetailJoint]:
    eye = _mirrored_point(EYE_CENTRE, sign)
    return [
        DetailJoint(f"{side}Eye", "head", eye, (GAZE_YAW, (0.0, 1.0, 0.0)), (GAZE_PITCH, (-1.0, 0.0, 0.0))),
        # the upper lid closes over the eye, and goes with a gaze up or down
        DetailJoint(f"{side}Lid", "head", eye, (blink, (0.88, 0.0, 0.0)), (GAZE_PITCH, (-0.55, 0.0, 0.0))),
        # far pivots: brows and corners of the mouth glide more than they turn
        DetailJoint(f"{side}Brow", "head", (0.0, 1.610, 0.0), (BROW, _mirrored_turn((-0.075, 0.0, 0.03), sign))),
        DetailJoint(f"{side}Mouth", "head", (0.0, 1.560, 0.0), (SMILE, _mirrored_turn((-0.115, 0.095, 0.0), sign))),
    ]


DETAIL_JOINTS: Final = (
    *_hand("left", 1.0, FACE_SIZE),
    *_hand("right", -1.0, FACE_SIZE + HAND_SIZE),
    *_half_face("left", 1.0, BLINK_LEFT),
    *_half_face("right", -1.0, BLINK_RIGHT),
    DetailJoint("jaw", "head", (0.0, 1.578, 0.012), (MOUTH_OPEN, (0.22, 0.0, 0.0))),
    DetailJoint("breath", "upperChest", (0.0, 1.200, -0.090), (BREATH, (-0.028, 0.0, 0.0))),
    *_muscles("left", 1.0),
    *_muscles("right", -1.0),
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
        while parent in of:
            parent = of[parent]
        found.append(SKELETON.index(parent))
    return np.array(found, np.int32)


ANCHORS: Final = _anchors()
"""The joint of the skeleton that each detail joint hangs on, directly or by its parents, shape (DRAWN_COUNT - J,)."""
DRIVERS: Final = tuple(
    dict.fromkeys(
        source for joint in DETAIL_JOINTS for source, _ in (joint.first, joint.second) if isinstance(source, Driver)
    )
)
"""All drivers; their numbers follow the columns of the expression."""


def _source_number(source: int | Driver) -> int:
    return EXPRESSION_SIZE + DRIVERS.index(source) if isinstance(source, Driver) else source


def driver_rows() -> Float32:
    """Return for each driver two texels, shape (D, 2, 4): axis and joint; the joint's parent and the least
    angle."""
    rows = np.zeros((len(DRIVERS), 2, 4), np.float32)
    for number, driver in enumerate(DRIVERS):
        joint = SKELETON.index(driver.joint)
        rows[number, 0] = (*driver.axis, joint)
        rows[number, 1, :2] = SKELETON.parents[joint], driver.least
    return rows


def shader_rows() -> Float32:
    """Return for each detail joint four texels, shape (D, 4, 4): pivot and skeleton joint; rotation vector and number
    of column or driver of both terms; the parent's number among the detail joints, -1 if it hangs on the skeleton."""
    names = [joint.name for joint in DETAIL_JOINTS]
    rows = np.zeros((len(DETAIL_JOINTS), 4, 4), np.float32)
    for number, joint in enumerate(DETAIL_JOINTS):
        rows[number, 0] = (*joint.pivot, ANCHORS[number])
        rows[number, 1] = (*joint.first[1], _source_number(joint.first[0]))
        rows[number, 2] = (*joint.second[1], _source_number(joint.second[0]))
        rows[number, 3, 0] = names.index(joint.parent) if joint.parent in names else -1
    return rows
