"""Tests of quaternion arrays against scipy's Rotation, an independent implementation."""

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation, Slerp

from live.motion import quaternion

Float = npt.NDArray[np.float64]


def wxyz(rotation: Rotation) -> Float:
    return np.asarray(rotation.as_quat()[..., [3, 0, 1, 2]])


def same(a: Float, b: Float) -> bool:
    return bool(np.allclose(np.abs(np.sum(a * b, axis=-1)), 1.0, atol=1e-12))


@pytest.fixture
def random() -> np.random.Generator:
    return np.random.default_rng(11)


def test_product_and_rotation_match_scipy(random: np.random.Generator) -> None:
    a, b = Rotation.random(50, random), Rotation.random(50, random)
    vectors = random.normal(size=(50, 3))
    assert same(quaternion.mul(wxyz(a), wxyz(b)), wxyz(a * b))
    assert np.allclose(quaternion.rotate(wxyz(a), vectors), a.apply(vectors))
    assert np.allclose(quaternion.rotate(quaternion.inverse(wxyz(a)), vectors), a.inv().apply(vectors))


def test_slerp_takes_the_shorter_arc(random: np.random.Generator) -> None:
    for _ in range(20):
        ends = Rotation.random(2, random)
        a, b = wxyz(ends)
        times = np.linspace(0.0, 1.0, 7)
        expected = wxyz(Slerp([0.0, 1.0], ends)(times))
        for sign in (1.0, -1.0):
            assert same(quaternion.slerp(a, sign * b, times), expected)


def test_slerp_of_equal_ends_is_constant() -> None:
    one = np.array(quaternion.IDENTITY)
    assert np.allclose(quaternion.slerp(one, one, np.linspace(0.0, 1.0, 3)), one)


def test_rotations_from_axes_and_columns_match_scipy(random: np.random.Generator) -> None:
    vectors = random.normal(size=(50, 3))
    angles = np.linalg.norm(vectors, axis=1)
    assert same(quaternion.from_axis_angle(vectors, angles), wxyz(Rotation.from_rotvec(vectors)))
    half_turns = Rotation.from_rotvec(np.pi * np.eye(3))
    for rotations in (Rotation.random(50, random), half_turns):
        columns = np.moveaxis(rotations.as_matrix(), -1, 0)
        assert same(quaternion.from_columns(*columns), wxyz(rotations))
        assert np.allclose(quaternion.to_matrix(wxyz(rotations)), rotations.as_matrix(), atol=1e-12)


def test_rotation_between_vectors_maps_first_to_second(random: np.random.Generator) -> None:
    a, b = random.normal(size=(2, 50, 3))
    b[0], b[1] = -a[0], a[1]  # opposite and equal ones too
    turned = quaternion.rotate(quaternion.from_two_vectors(a, b), quaternion.unit(a))
    assert np.allclose(turned, quaternion.unit(b))


def test_aligned_signs_are_continuous_and_keep_rotations() -> None:
    turn = Rotation.from_rotvec(np.linspace(0.0, 12.0, 60)[:, None] * (0.0, 0.0, 1.0))
    jumping = wxyz(turn) * np.where(np.arange(60) % 3 == 1, -1.0, 1.0)[:, None]
    smooth = quaternion.align_signs(jumping)
    assert same(smooth, jumping)
    assert (np.sum(smooth[1:] * smooth[:-1], axis=1) > 0.9).all()


def test_rotation_vectors_match_scipy(random: np.random.Generator) -> None:
    rotations = Rotation.random(50, random)
    vectors = rotations.as_rotvec()
    assert same(quaternion.from_rotation_vector(vectors), wxyz(rotations))
    assert np.allclose(quaternion.to_rotation_vector(-wxyz(rotations)), vectors, atol=1e-9)
    small = 1e-10 * vectors
    assert np.allclose(quaternion.to_rotation_vector(quaternion.from_rotation_vector(small)), small, atol=1e-14)
