"""Motion of all drawn joints by plain matrices, independent of the shader."""

import numpy as np
import numpy.typing as npt

from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.body.drawn_joints import DETAIL_JOINTS, EXPRESSION_SIZE
from live.render.body.muscles import Driver

Float64 = npt.NDArray[np.float64]
JOINTS = {joint.name: joint for joint in DETAIL_JOINTS}


def rodrigues(around: Float64) -> Float64:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(around))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = around / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


def matrix(q: npt.ArrayLike) -> Float64:
    """Rotation matrix of a quaternion w, x, y, z."""
    w, *v = np.asarray(q, np.float64)
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.asarray(np.eye(3) + 2.0 * w * cross + 2.0 * (cross @ cross))


def twist(turn: Float64, axis: Float64) -> float:
    """Angle about an axis of the rotation that is left when the shortest one that tilts the axis as far is undone."""
    tilted = turn @ axis
    across = np.cross(axis, tilted)
    sine = float(np.linalg.norm(across))
    swing = rodrigues(across / sine * np.arctan2(sine, float(axis @ tilted))) if sine > 1e-12 else np.eye(3)
    rest = swing.T @ turn
    beside = np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0])
    beside /= np.linalg.norm(beside)
    moved = rest @ beside
    return float(np.arctan2(np.cross(beside, moved) @ axis, beside @ moved))


def value(source: int | Driver, rotation: Float64, expression: Float64) -> float:
    """Value of a column or a driver."""
    if not isinstance(source, Driver):
        return float(expression[source])
    joint = SKELETON.index(source.joint)
    beside = matrix(rotation[SKELETON.parents[joint]]).T @ matrix(rotation[joint])
    return max(twist(beside, np.array(source.axis)), source.least)


def drawn_motions(
    position: npt.NDArray[np.floating], rotation: npt.NDArray[np.floating], expression: Float64 | None = None
) -> tuple[Float64, Float64]:
    """Return for each drawn joint how it moves the rest pose: rotation matrices (D, 3, 3) and translations (D, 3)."""
    given = np.zeros(EXPRESSION_SIZE) if expression is None else expression
    turns = np.zeros((JOINT_COUNT + len(DETAIL_JOINTS), 3, 3))
    moves = np.zeros((len(turns), 3))
    rest = SKELETON.rest_positions().astype(np.float64)
    for joint in range(JOINT_COUNT):
        turns[joint] = matrix(rotation[joint])
        moves[joint] = position[joint] - turns[joint] @ rest[joint]
    for number, joint in enumerate(DETAIL_JOINTS):
        around = sum(
            value(source, rotation.astype(np.float64), given) * np.array(turn)
            for source, turn in (joint.first, joint.second)
        )
        own = rodrigues(np.asarray(around))
        parent = [*SKELETON.names, *JOINTS].index(joint.parent)
        turns[JOINT_COUNT + number] = turns[parent] @ own
        moves[JOINT_COUNT + number] = turns[parent] @ (joint.pivot - own @ joint.pivot) + moves[parent]
    return turns, moves
