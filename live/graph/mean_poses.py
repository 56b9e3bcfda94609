"""Mean poses of all nodes of a library at once: for each joint the mean in log space about itself (T058)."""

import numpy as np

from live.base.arrays import Float32, Int64
from live.graph.storage_kernels import mean_turns, rotation_moments
from live.motion import quaternion


def mean_poses(rotation: Float32, first: Int64, last: Int64) -> Float32:
    """Return the mean rotation of each joint over samples first to last (inclusive, (N,)) of (S, J, 4), (N, J, 4).

    The initial value maximises the summed squared cosine (an eigenvector); one step in log space gives the mean of
    q_mean^-1 q. Its sign is that of the first sample.
    """
    joints = rotation.shape[1]
    moments = np.zeros((len(first), joints, 4, 4))
    rotation_moments(rotation, first, last, moments)
    centre = np.ascontiguousarray(np.linalg.eigh(moments)[1][..., -1])
    turn = np.empty((len(first), joints, 3))
    mean_turns(rotation, first, last, centre, turn)
    angle = np.linalg.norm(turn, axis=-1)
    axis = turn / np.maximum(angle, 1e-12)[..., None]
    centre = quaternion.mul(centre, quaternion.from_axis_angle(axis, angle))
    away = np.sum(centre * rotation[first], axis=-1, keepdims=True) < 0.0
    return np.asarray(np.where(away, -centre, centre), np.float32)
