"""Poses for pictures, from a separate small forward kinematics: joint rotations [degrees] in world axes
of the parent, on top of the rest pose.
"""

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Turns = dict[str, tuple[float, float, float]]

ARMS_DOWN: Turns = {
    "leftUpperArm": (0, 0, -72),
    "rightUpperArm": (0, 0, 72),
    "leftLowerArm": (0, -18, -6),
    "rightLowerArm": (0, 18, 6),
}
REST: Turns = {}
PLIE: Turns = {
    "leftUpperLeg": (-70, 25, 20),
    "leftLowerLeg": (100, 0, 0),
    "leftFoot": (-32, 0, 0),
    "rightUpperLeg": (-70, -25, -20),
    "rightLowerLeg": (100, 0, 0),
    "rightFoot": (-32, 0, 0),
    "leftUpperArm": (0, -25, -35),
    "rightUpperArm": (0, 25, 35),
    "leftLowerArm": (0, -70, 0),
    "rightLowerArm": (0, 70, 0),
}
LUNGE: Turns = {
    "hips": (0, 25, 0),
    "leftUpperLeg": (-82, 10, 8),
    "leftLowerLeg": (88, 0, 0),
    "leftFoot": (-5, 0, 0),
    "rightUpperLeg": (32, 0, -8),
    "rightLowerLeg": (12, 0, 0),
    "rightFoot": (20, 0, 0),
    "rightToes": (-40, 0, 0),
    "spine": (8, 0, 0),
    "chest": (-6, -20, 6),
    "head": (-8, -20, 0),
    "leftUpperArm": (0, -20, 45),
    "leftLowerArm": (0, -30, 10),
    "rightUpperArm": (0, 30, 10),
    "rightLowerArm": (0, 12, 0),
}
ARABESQUE: Turns = {
    "hips": (28, 60, 0),
    "rightUpperLeg": (78, 0, -4),
    "rightLowerLeg": (6, 0, 0),
    "rightFoot": (55, 0, 0),
    "rightToes": (15, 0, 0),
    "leftUpperLeg": (-28, 0, 4),
    "leftLowerLeg": (2, 0, 0),
    "leftFoot": (0, 0, 0),
    "spine": (-18, 0, 0),
    "chest": (-20, 0, 0),
    "upperChest": (-14, 0, 0),
    "neck": (-6, 0, 0),
    "head": (-8, 0, 0),
    "leftUpperArm": (0, -70, 22),
    "rightUpperArm": (0, 12, 6),
    "leftLowerArm": (0, -10, 0),
    "leftHand": (0, 0, -12),
    "rightHand": (0, 0, 12),
}
REACH: Turns = {
    "leftShoulder": (0, 0, 12),
    "rightShoulder": (0, 0, -12),
    "leftUpperArm": (0, -10, 62),
    "rightUpperArm": (0, 10, -62),
    "leftLowerArm": (0, -20, 22),
    "rightLowerArm": (0, 20, -22),
    "leftHand": (0, 0, 12),
    "rightHand": (0, 0, -12),
    "head": (-14, 0, 0),
    "rightUpperLeg": (-55, -30, -25),
    "rightLowerLeg": (110, 0, 0),
    "rightFoot": (40, 0, 0),
    "upperChest": (-8, 0, 0),
}
STEP: Turns = {
    "hips": (0, -12, 3),
    "spine": (0, 6, -3),
    "chest": (0, 14, -4),
    "leftUpperLeg": (-38, 0, 6),
    "leftLowerLeg": (42, 0, 0),
    "leftFoot": (6, 0, 0),
    "rightUpperLeg": (10, 0, -4),
    "rightLowerLeg": (14, 0, 0),
    "rightFoot": (12, 0, 0),
    "rightToes": (-25, 0, 0),
    "leftUpperArm": (0, 35, -58),
    "leftLowerArm": (0, -50, -10),
    "rightUpperArm": (0, 45, 62),
    "rightLowerArm": (0, 60, 10),
}
SIT: Turns = {
    "leftUpperLeg": (-100, 0, 6),
    "leftLowerLeg": (110, 0, 0),
    "rightUpperLeg": (-100, 0, -6),
    "rightLowerLeg": (110, 0, 0),
    "spine": (25, 0, 0),
    "chest": (20, 0, 0),
    "leftUpperArm": (0, -95, -15),
    "rightUpperArm": (0, 95, 15),
    "leftLowerArm": (0, -100, 0),
    "rightLowerArm": (0, 100, 0),
    "head": (20, 0, 0),
}
ALL = {
    "rest": REST,
    "stand": ARMS_DOWN,
    "plie": PLIE,
    "lunge": LUNGE,
    "arabesque": ARABESQUE,
    "reach": REACH,
    "step": STEP,
    "sit": SIT,
}


def _turn(degrees: tuple[float, float, float]) -> Float64:
    """Rotation matrix: about x first, then y, then z."""
    x, y, z = np.deg2rad(degrees)
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    about_z = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def quaternion(matrix: Float64) -> Float64:
    """Unit quaternion w, x, y, z of a rotation matrix."""
    values, vectors = np.linalg.eigh(
        np.array(
            [
                [matrix[0, 0] - matrix[1, 1] - matrix[2, 2], 0, 0, 0],
                [matrix[0, 1] + matrix[1, 0], matrix[1, 1] - matrix[0, 0] - matrix[2, 2], 0, 0],
                [
                    matrix[0, 2] + matrix[2, 0],
                    matrix[1, 2] + matrix[2, 1],
                    matrix[2, 2] - matrix[0, 0] - matrix[1, 1],
                    0,
                ],
                [
                    matrix[2, 1] - matrix[1, 2],
                    matrix[0, 2] - matrix[2, 0],
                    matrix[1, 0] - matrix[0, 1],
                    np.trace(matrix),
                ],
            ]
        )
        / 3.0
    )
    x, y, z, w = vectors[:, int(np.argmax(values))]
    return np.array([w, x, y, z])


def pose(turns: Turns, place: tuple[float, float] = (0.0, 0.0), heading_deg: float = 0.0) -> tuple[Float32, Float32]:
    """World positions (22, 3) [m] and rotations (22, 4) of a pose, with the lowest joint on the floor."""
    world = np.zeros((JOINT_COUNT, 3, 3))
    position = np.zeros((JOINT_COUNT, 3))
    for joint, name in enumerate(SKELETON.names):
        parent = int(SKELETON.parents[joint])
        local = _turn(turns.get(name, (0, 0, 0)))
        if parent < 0:
            world[joint] = _turn((0, heading_deg, 0)) @ local
            position[joint] = SKELETON.offsets[joint]
        else:
            world[joint] = world[parent] @ local
            position[joint] = position[parent] + world[parent] @ SKELETON.offsets[joint]
    ankles = [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")]
    toes = [SKELETON.index("leftToes"), SKELETON.index("rightToes")]
    lowest = min(float((position[ankles, 1] - 0.085).min()), float((position[toes, 1] - 0.02).min()))
    position[:, 1] -= lowest
    position[:, [0, 2]] += np.array(place) - position[0, [0, 2]]
    return position.astype(np.float32), np.array([quaternion(m) for m in world], np.float32)


def stage_view(dancers: list[tuple[Turns, tuple[float, float], float, int]]) -> StageView:
    """A view of dancers given as (pose, place, heading [degrees], group)."""
    view = StageView.allocate(len(dancers), JOINT_COUNT)
    for index, (turns, place, heading, group) in enumerate(dancers):
        view.joint_position[index], view.joint_rotation[index] = pose(turns, place, heading)
        view.group[index] = group
    return view
