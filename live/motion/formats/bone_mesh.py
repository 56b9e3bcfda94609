"""The figure of dancers without a body in files: a spindle for each bone."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.stage_motion import FigureMesh
from live.motion.skeleton import BONE_TIPS, SKELETON

_THICKEST_AT: Final = 0.2
"""Fraction of the bone's length at which the spindle is thickest."""
_THICKNESS: Final = 0.14
"""Half of its width there as a fraction of its length."""
_FACES: Final = np.array(
    ((0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (5, 2, 1), (5, 3, 2), (5, 4, 3), (5, 1, 4)), np.int64
)
"""Triangles of a spindle, counterclockwise seen from outside: joint 0, belly 1 to 4, end 5."""


def bone_mesh() -> FigureMesh:
    """Return spindles for all bones of the engine's skeleton, including the tips of head, hands and toes."""
    rest = SKELETON.rest_positions().astype(np.float64)
    bones = [(int(SKELETON.parents[joint]), rest[joint]) for joint in range(1, SKELETON.joint_count)]
    bones += [(joint, rest[joint] + tip) for joint, tip in BONE_TIPS.items()]
    corners = np.concatenate([_spindle(rest[joint], end)[_FACES] for joint, end in bones])
    normals = quaternion.unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    count = 3 * len(corners)
    joints = np.zeros((count, 4), np.uint8)
    joints[:, 0] = np.repeat([joint for joint, _ in bones], 3 * len(_FACES))
    weights = np.zeros((count, 4), np.float32)
    weights[:, 0] = 1.0
    return FigureMesh(
        positions=corners.reshape(-1, 3).astype(np.float32),
        normals=np.repeat(normals, 3, axis=0).astype(np.float32),
        joints=joints,
        weights=weights,
        indices=np.arange(count, dtype=np.uint16),
    )


def _spindle(start: npt.NDArray[np.float64], end: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return six points: the start, four around the thickest part, the end."""
    along = end - start
    length = float(np.linalg.norm(along))
    turn = quaternion.from_two_vectors(np.array((0.0, 1.0, 0.0)), along)
    width = _THICKNESS * length
    belly = [(x * width, _THICKEST_AT * length, z * width) for x, z in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    return np.asarray(start + quaternion.rotate(turn, np.array([(0.0, 0.0, 0.0), *belly, (0.0, length, 0.0)])))
