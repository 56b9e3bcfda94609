"""Tests of charts: continuous angles that reproduce the rotations, also for circling arms and turning dancers."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.quaternion import euler_to_quaternion
from live.motion.texture.frequency_bands import ORDERS, VECTOR, choose_charts, euler_angles

CHANCE = np.random.default_rng(2)


def _rotation_error(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(np.abs(np.sum(a * b, axis=-1)) - 1.0).max())


@pytest.mark.parametrize("order", ORDERS)
def test_euler_angles_invert_rotation(order: str) -> None:
    angles = CHANCE.uniform((-3.1, -1.5, -3.1), (3.1, 1.5, 3.1), (500, 3))
    assert np.abs(euler_angles(euler_to_quaternion(angles, order), order) - angles).max() < 1e-6


def _motion(count: int = 300) -> np.ndarray:
    """Hips that turn six times, an arm that circles three times with a wobble, and a joint that sways."""
    t = np.linspace(0.0, 1.0, count)
    hips = euler_to_quaternion(np.stack((12.0 * np.pi * t, 0.4 * np.sin(9 * t), 0.3 * np.cos(8 * t)), -1), "YXZ")
    arm = euler_to_quaternion(np.stack((6.0 * np.pi * t, 0.5 * np.sin(20 * t), 0.2 * np.sin(13 * t)), -1), "XYZ")
    sway = quaternion.from_rotation_vector(0.8 * np.stack((np.sin(9 * t), np.cos(7 * t), np.sin(5 * t)), -1))
    return np.stack((hips, arm, sway), axis=1)


def test_chosen_charts_are_continuous_and_invertible() -> None:
    rotation = _motion()
    charts = choose_charts(rotation)
    assert charts[0].kind[0] == "Y"
    assert charts[1].kind in ORDERS
    assert charts[2].kind == VECTOR
    for joint, chart in enumerate(charts):
        angles = chart.angles(rotation[:, joint])
        assert chart.margin > 0.3
        assert np.abs(np.diff(angles, axis=0)).max() < 0.3  # no jump at full turns
        assert _rotation_error(chart.rotations(angles), rotation[:, joint]) < 1e-12
    heading = charts[0].angles(rotation[:, 0])[:, 0]
    assert abs((heading[-1] - heading[0]) - 12.0 * np.pi) < 0.1  # the full turns are counted


def test_charts_ignore_quaternion_signs() -> None:
    rotation = _motion()
    flipped = rotation * CHANCE.choice((-1.0, 1.0), rotation.shape[:2])[..., None]
    for one, other, joint in zip(choose_charts(rotation), choose_charts(flipped), range(3), strict=True):
        assert one.kind == other.kind
        assert np.abs(one.angles(rotation[:, joint]) - other.angles(flipped[:, joint])).max() < 1e-6
