"""Pose kernels against the vectorised numpy versions and scipy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion import quaternion
from live.motion.forward import forward_kinematics
from live.motion.kernels import yaw_rotate
from live.motion.pose import PoseBuffer
from live.motion.skeleton import JOINT_COUNT, SKELETON


def _clips(seed, samples=12):
    chance = np.random.default_rng(seed)
    rotation = chance.normal(0, 1, (samples, JOINT_COUNT, 4))
    rotation /= np.linalg.norm(rotation, axis=-1, keepdims=True)
    return chance.normal(0, 1, (samples, 3)).astype(np.float32), rotation.astype(np.float32)


def _at(root, rotation, sample):
    low = math.floor(sample)
    high = min(low + 1, len(root) - 1)
    t = sample - low
    turned = quaternion.slerp(rotation[low].astype(float), rotation[high].astype(float), np.full(JOINT_COUNT, t))
    return (1 - t) * root[low] + t * root[high], turned


def _placed(root, rotation, place):
    x, z, path_yaw, body_yaw = place
    c, s = math.cos(path_yaw), math.sin(path_yaw)
    at = np.array([x + root[0] * c + root[2] * s, root[1], z + root[2] * c - root[0] * s])
    turn = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(body_yaw))
    turned = rotation.copy()
    turned[0] = quaternion.mul(turn, rotation[0])
    return at, turned


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 11), st.floats(0, 11), st.floats(0, 1))
def test_sample_blend_place_and_forward_kinematics(seed, first, second, weight):
    root, rotation = _clips(seed)
    chance = np.random.default_rng(seed + 1)
    places = chance.uniform(-3, 3, (2, 1, 4))
    buffer = PoseBuffer(1)
    buffer.sample(
        root, rotation, sample_a=np.array([first]), sample_b=np.array([second]), weight=np.array([weight]),
        placement_a=places[0], placement_b=places[1],
    )  # fmt: skip
    a_root, a = _placed(*_at(root, rotation, first), places[0, 0])
    b_root, b = _placed(*_at(root, rotation, second), places[1, 0])
    blended = quaternion.slerp(a, b, np.full(JOINT_COUNT, weight))
    at = (1 - weight) * a_root + weight * b_root
    positions, rotations = forward_kinematics(at[None], blended[None])
    # near half a turn apart both ways round are shortest, and float32 may choose the other one
    clear = np.abs((a * b).sum(-1)).min() > 0.02 or weight in (0.0, 1.0)
    if clear and _clear(rotation, first) and _clear(rotation, second):
        assert buffer.world_position[0] == pytest.approx(positions[0], abs=2e-3)
        assert np.abs((buffer.world_rotation[0] * rotations[0]).sum(-1)) == pytest.approx(1.0, abs=1e-4)
    assert np.linalg.norm(buffer.world_rotation[0], axis=-1) == pytest.approx(1.0, abs=1e-4)


def _clear(rotation, sample):
    low = math.floor(sample)
    high = min(low + 1, len(rotation) - 1)
    return np.abs((rotation[low] * rotation[high]).sum(-1)).min() > 0.02


@given(st.floats(-4, 4), st.floats(-4, 4), st.floats(-7, 7))
def test_yaw_turns_the_public_towards_plus_x(x, z, yaw):
    """K001's rotation: as complex numbers x + iz it is a multiplication by exp(-i yaw)."""
    turned = complex(x, z) * np.exp(-1j * yaw)
    assert yaw_rotate(x, z, yaw) == pytest.approx((turned.real, turned.imag), abs=1e-9)
    assert yaw_rotate(0.0, 1.0, math.pi / 2) == pytest.approx((1.0, 0.0), abs=1e-12)


def test_bones_keep_their_lengths():
    root, rotation = _clips(7)
    buffer = PoseBuffer(5)
    samples = np.linspace(0, 11, 5)
    place = np.random.default_rng(1).uniform(-3, 3, (5, 4))
    buffer.sample(
        root, rotation, sample_a=samples, sample_b=samples[::-1].copy(), weight=np.full(5, 0.4), placement_a=place,
        placement_b=place,
    )  # fmt: skip
    parents = SKELETON.parents
    bones = buffer.world_position[:, 1:] - buffer.world_position[:, parents[1:]]
    wanted = np.linalg.norm(SKELETON.offsets[1:], axis=1)
    assert np.linalg.norm(bones, axis=2) == pytest.approx(np.tile(wanted, (5, 1)), abs=1e-5)
    assert buffer.world_position[:, 0] == pytest.approx(buffer.root_position)
