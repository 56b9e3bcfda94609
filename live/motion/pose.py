"""PoseBuffer: the preallocated arrays of all dancers' poses, and the calls that fill them."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.motion.kernels import pose_forward, pose_sample
from live.motion.skeleton import SKELETON

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]


class PoseBuffer:
    """Poses of A dancers on the engine's skeleton of J joints; nothing is allocated after the start."""

    def __init__(self, dancer_count: int) -> None:
        joints = SKELETON.joint_count
        self.root_position: Float32 = np.zeros((dancer_count, 3), np.float32)
        """World position of the hips [m], shape (A, 3)."""
        self.local_rotation: Float32 = np.zeros((dancer_count, joints, 4), np.float32)
        """Local rotations, the root's in the world, shape (A, J, 4)."""
        self.world_position: Float32 = np.zeros((dancer_count, joints, 3), np.float32)
        """World positions of the joints [m], shape (A, J, 3)."""
        self.world_rotation: Float32 = np.zeros((dancer_count, joints, 4), np.float32)
        """World rotations of the joints, shape (A, J, 4)."""
        self._offsets = np.array(SKELETON.offsets)
        self._parents = np.array(SKELETON.parents)
        self._scratch_root = np.zeros((1, 3), np.float32)
        self._scratch_rotation = np.zeros((1, joints, 4), np.float32)

    def sample(
        self,
        clip_root: Float32,
        clip_rotation: Float32,
        *,
        sample_a: Float64,
        sample_b: Float64,
        weight: Float64,
        placement_a: Float64,
        placement_b: Float64,
        out: tuple[npt.NDArray[Any], npt.NDArray[Any]] | None = None,
    ) -> None:
        """Sample, blend and place all dancers, then forward kinematics.

        Arguments as in `kernels.pose_sample`. `out` takes the world positions and rotations instead of
        `world_position` and `world_rotation` (the drawing snapshot, so that nothing is copied).
        """
        pose_sample(
            self.root_position,
            self.local_rotation,
            clip_root,
            clip_rotation,
            sample_a,
            sample_b,
            weight,
            placement_a,
            placement_b,
            self._scratch_root,
            self._scratch_rotation,
        )
        position, rotation = out if out is not None else (self.world_position, self.world_rotation)
        pose_forward(position, rotation, self.root_position, self.local_rotation, self._offsets, self._parents)
