"""Tests of the path leash: a walk is kept near its path smoothly and is unchanged where it is near."""

import numpy as np

from live.motion.clip import Clip
from live.motion.partner.path_leader import keep_near_path
from live.motion.partner.point_clouds import hip_projections
from live.motion.skeleton import JOINT_COUNT


def walking_clip(place: np.ndarray) -> Clip:
    root = np.stack((place.imag, np.full(len(place), 0.9), place.real), axis=1).astype(np.float32)
    rotation = np.zeros((len(place), JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    return Clip("walk", root, rotation, 60.0, np.zeros((len(place), 2), np.bool_))


def test_walk_beyond_path_end_is_kept_near_smoothly() -> None:
    time = np.arange(300) / 60.0
    path = np.minimum(time, 3.0) * (1.0 + 0.5j)
    cloud = hip_projections(path, np.full(300, 1j), 60.0)
    walked = np.minimum(time, 3.5) * (1.0 + 0.5j)
    clip = walking_clip(walked)
    kept = keep_near_path(clip, cloud, 0.1)
    hips = kept.root_position[:, 2] + 1j * kept.root_position[:, 0]
    assert np.abs(hips - path).max() < 0.101
    assert np.abs(walked - path).max() > 0.5
    assert np.array_equal(kept.root_position[:150], clip.root_position[:150])
    assert np.abs(np.diff(hips)).max() < 1.6 * np.abs(np.diff(walked)).max()
    assert keep_near_path(clip, hip_projections(walked, np.full(300, 1j), 60.0), 0.1) is clip
