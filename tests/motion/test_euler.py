"""Tests of Euler angles in every order against products of rotation matrices."""

from itertools import permutations, product

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.quaternion import euler_to_quaternion

ORDERS = ["".join(p) for n in (1, 2, 3) for p in permutations("XYZ", n)] + ["ZXZ", "YXY"]


def matrix(axis: str, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return {
        "X": np.array(((1, 0, 0), (0, c, -s), (0, s, c))),
        "Y": np.array(((c, 0, s), (0, 1, 0), (-s, 0, c))),
        "Z": np.array(((c, -s, 0), (s, c, 0), (0, 0, 1))),
    }[axis]


@pytest.mark.parametrize("order", ORDERS)
def test_first_named_axis_is_applied_last(order: str) -> None:
    rng = np.random.default_rng(len(order) + ord(order[0]))
    angles = rng.uniform(-2 * np.pi, 2 * np.pi, (20, len(order)))
    quaternions = euler_to_quaternion(angles, order)
    for row, q in zip(angles, quaternions, strict=True):
        expected = np.eye(3)
        for axis, angle in zip(order, row, strict=True):
            expected = expected @ matrix(axis, angle)
        np.testing.assert_allclose(quaternion.rotate(q, np.eye(3)).T, expected, atol=1e-12)


def test_no_axis_gives_identity_and_shapes_are_kept() -> None:
    assert euler_to_quaternion(np.zeros((4, 5, 0)), "").tolist() == np.tile([1.0, 0, 0, 0], (4, 5, 1)).tolist()
    assert euler_to_quaternion(np.zeros((4, 5, 3)), "ZXY").shape == (4, 5, 4)


def test_all_quaternions_are_unit() -> None:
    grid = np.array(list(product((-np.pi, 0.0, 0.7, np.pi / 2), repeat=3)))
    for order in ORDERS:
        q = euler_to_quaternion(grid[:, : len(order)], order)
        np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1.0, atol=1e-12)


def test_wrong_number_of_angles_is_refused() -> None:
    with pytest.raises(ValueError, match="2 angles for the axes 'ZXY'"):
        euler_to_quaternion(np.zeros((1, 2)), "ZXY")
