"""Tests of packed poses: round trips, invalid poses and damaged text."""

import base64

import numpy as np
import pytest

from live.control.events.event_json import event_from_json, event_to_row
from live.control.events.events import MocapFrame
from live.motion.capture.packed_pose import PACKED_LENGTH, pack_pose, unpack_pose
from live.motion.skeleton import JOINT_COUNT


def _rotations(seed: int) -> np.ndarray:
    rotation = np.random.default_rng(seed).normal(size=(JOINT_COUNT, 4))
    return rotation / np.linalg.norm(rotation, axis=1, keepdims=True)


def test_rotations_round_trip_within_hundredth_of_degree() -> None:
    for seed in range(50):
        rotation, hips = _rotations(seed), np.array([1.25, 0.875, -3.5])
        packed = pack_pose(hips, rotation)
        root, turned = unpack_pose(packed)
        assert len(packed) == PACKED_LENGTH
        assert root.tolist() == hips.tolist()
        apart = np.minimum(np.linalg.norm(turned - rotation, axis=1), np.linalg.norm(turned + rotation, axis=1))
        assert np.degrees(4.0 * np.arcsin(apart.max() / 2.0)) < 0.009


def test_any_component_may_be_largest_with_either_sign() -> None:
    for axis in range(4):
        for sign in (1.0, -1.0):
            rotation = np.zeros((JOINT_COUNT, 4))
            rotation[:, axis] = sign
            _, turned = unpack_pose(pack_pose(np.zeros(3), rotation))
            np.testing.assert_array_equal(turned, rotation * sign)


@pytest.mark.parametrize(
    ("hips", "rotation"),
    [
        ([0.0, np.nan, 0.0], _rotations(1)),
        ([0.0, 1e9, 0.0], _rotations(1)),
        ([0.0, 1.0, 0.0], np.zeros((JOINT_COUNT, 4))),
        ([0.0, 1.0, 0.0], np.full((JOINT_COUNT, 4), np.nan)),
        ([0.0, 1.0, 0.0], _rotations(1)[:-1]),
    ],
)
def test_invalid_pose_is_not_packed(hips: list[float], rotation: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"pose|expected"):
        pack_pose(hips, rotation)


def test_damaged_text_is_refused_or_gives_unit_rotations() -> None:
    packed = pack_pose([0.0, 1.0, 0.0], _rotations(3))
    for text in ("", packed[:-4], packed + "AAAA", "!" * PACKED_LENGTH, "é" * PACKED_LENGTH, packed[:-1] + "="):
        with pytest.raises(ValueError, match=r"pose|expected"):
            unpack_pose(text)
    nowhere = base64.b64encode(np.array([np.inf, 0.0, 0.0], "<f4").tobytes() + b"\xff" * 132).decode()
    with pytest.raises(ValueError, match=r"pose|expected"):
        unpack_pose(nowhere)
    _, turned = unpack_pose(base64.b64encode(bytes(12) + b"\x1f\xff\xff\xff\xff\xff" * JOINT_COUNT).decode())
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1.0, atol=1e-6)


def test_mocap_frame_round_trips_through_journal() -> None:
    frame = MocapFrame(time=12.345678901, source="vmc", performer="anna", pose=pack_pose(np.ones(3), _rotations(5)))
    assert event_from_json(event_to_row(frame)) == frame
