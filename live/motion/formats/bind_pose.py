"""The rest pose that a skin was made in: a better one than the nodes' own, which is whatever pose was exported."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.gltf_accessors import Accessors
from live.motion.formats.json_place import JsonPlace

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

SKEWED: Final = 0.05
"""Where a bind matrix is further than this from rotation times one factor, it is passed over."""


def bind_rotations(skin: JsonPlace, joints: list[int], accessors: Accessors) -> dict[int, Float]:
    """World rotation of each joint node when the skin was bound, quaternions (4,); empty where the skin says nothing.

    The inverse of an inverse bind matrix is where the joint was in the mesh's space; what turns that space as a whole
    is left out, and does not matter to what compares a pose with its own rest pose.
    """
    if not skin.has("inverseBindMatrices"):
        return {}
    matrices = accessors.read(skin.whole("inverseBindMatrices", below=1 << 40), "MAT4")
    if len(matrices) < len(joints):
        words = f"has {len(matrices)} matrices for {len(joints)} joints"
        raise skin.error("inverseBindMatrices", words, "one for each joint expected")
    found: dict[int, Float] = {}
    for joint, numbers in zip(joints, matrices, strict=False):
        columns = numbers.reshape(4, 4)[:3, :3]  # the file holds column after column: the rows here are columns
        size = np.cbrt(np.linalg.det(columns))
        if size > 1e-9 and np.abs(columns @ columns.T / size**2 - np.eye(3)).max() < SKEWED:
            turn = quaternion.from_columns(*quaternion.unit(columns))
            found[joint] = quaternion.inverse(turn)
    return found


def rest_rotations(parents: list[int], nodes: Float64, bound: list[Float | None]) -> Float64:
    """Local rotations of the rest pose, (J, 4): those of the skin where it knows them, else those of the nodes.

    `nodes` (J, 4) are the nodes' own local rotations, `bound` the skin's world rotations; parents come first.
    """
    world = np.empty_like(nodes)
    local = np.empty_like(nodes)
    for joint, parent in enumerate(parents):
        known = bound[joint]
        if parent < 0:
            world[joint] = nodes[joint] if known is None else known
            local[joint] = world[joint]
        else:
            world[joint] = quaternion.mul(world[parent], nodes[joint]) if known is None else known
            local[joint] = quaternion.mul(quaternion.inverse(world[parent]), world[joint])
    return local
