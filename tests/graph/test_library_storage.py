"""Tests of library storage: mean poses and signs of all nodes at once against those of one clip."""

import numpy as np
import pytest

from live.graph.mean_poses import mean_poses
from live.graph.step_library import build_library, joined_library
from live.graph.storage_kernels import align_signs
from live.motion import quaternion
from tests.fixtures.made_steps import made_clip, made_steps


def _rotations(seed, count):
    chance = np.random.default_rng(seed)
    turns = np.cumsum(chance.normal(0, 0.1, (count, 5, 3)), axis=0)
    angle = np.linalg.norm(turns, axis=-1)
    return quaternion.from_axis_angle(turns / angle[..., None], angle).astype(np.float32)


def test_mean_poses_equal_mean_pose_of_each_node_alone():
    rotation = np.concatenate([_rotations(1, 70), -_rotations(2, 50)])
    first, last = np.array([0, 30, 70, 119]), np.array([29, 69, 118, 119])
    found = mean_poses(rotation, first, last)
    for n, (a, b) in enumerate(zip(first, last, strict=True)):
        alone = mean_poses(rotation[a : b + 1], np.array([0]), np.array([b - a]))
        assert found[n] == pytest.approx(alone[0], abs=1e-6)


def test_signs_are_continuous_and_nearest_to_rest_pose():
    clips = [_rotations(seed, 40) for seed in (1, 2, 3)]
    chance = np.random.default_rng(4)
    flipped = [clip * chance.choice([-1, 1], clip.shape[:2])[..., None].astype(np.float32) for clip in clips]
    together = np.concatenate(flipped)
    align_signs(together, np.array([0, 40, 80, 120]))
    for n, clip in enumerate(flipped):
        found = together[40 * n : 40 * n + 40]
        assert np.abs(found) == pytest.approx(np.abs(clip))
        assert np.array_equal(found, quaternion.align_signs(found).astype(np.float32))
        nearest = np.argmax(np.abs(found[..., 0]), axis=0)
        assert (np.take_along_axis(found[..., 0], nearest[None], axis=0) > 0).all()


def test_joined_library_has_same_samples():
    clips = [*made_steps(), made_clip("new", measures=2), made_clip("sway", arm=0.7)]
    whole, joined = build_library(clips), joined_library(build_library(clips[:8]), build_library(clips[8:]))
    assert joined.steps == whole.steps
    assert np.array_equal(joined.node_step, whole.node_step)
    assert np.array_equal(joined.node_clip, whole.node_clip)
    assert joined.node_first == pytest.approx(whole.node_first)
    assert np.array_equal(joined.clip_rotation, whole.clip_rotation)
    assert joined.store.rotation is joined.clip_rotation
    assert np.array_equal(joined.leg_store.rotation, whole.leg_store.rotation)
    assert np.array_equal(joined.clip_height, whole.clip_height)
    assert joined.clip_height.shape == joined.clip_contact.shape
    assert joined.store.mean == pytest.approx(whole.store.mean, abs=1e-6)
