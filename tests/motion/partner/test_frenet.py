"""Tests of paths as controls: two points across the path at a constant distance."""

import numpy as np

from live.motion.partner.path_leader import frenet_cloud
from live.motion.partner.point_clouds import HIP_DISTANCE, path_cloud
from tests.motion.partner.made_examples import standing


def test_points_on_circle_lie_on_radius() -> None:
    time = np.linspace(0.0, 8.0, 801)
    place = 2.0 * np.stack((np.sin(0.5 * time), np.cos(0.5 * time)), axis=1)  # towards +x from (0, 2)
    cloud = frenet_cloud(time, place, 30.0)
    assert cloud.count == 241
    inner = cloud.floor[5:-5]
    np.testing.assert_allclose(np.abs(inner[:, 0] - inner[:, 1]), HIP_DISTANCE, atol=1e-9)
    # a dancer going from the front of the stage toward +x has the center at her left
    np.testing.assert_allclose(np.abs(inner[:, 0]), 2.0 - HIP_DISTANCE / 2, atol=1e-3)
    np.testing.assert_allclose(np.abs(inner[:, 1]), 2.0 + HIP_DISTANCE / 2, atol=1e-3)


def test_heading_is_held_while_path_rests() -> None:
    time = np.array((0.0, 1.0, 2.0, 3.0))
    place = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    cloud = frenet_cloud(time, place, 20.0)
    across = (cloud.floor[:, 0] - cloud.floor[:, 1]) / HIP_DISTANCE
    facing = across / 1j
    np.testing.assert_allclose(facing[5:38], 1j, atol=1e-6)  # towards +x, also while standing
    np.testing.assert_allclose(facing[45:], 1.0, atol=1e-6)


def test_path_and_aligned_body_have_same_control() -> None:
    """The left point is the left hip."""
    clip = standing(10, 60.0)
    hips = path_cloud(clip)
    left, right = hips.floor[0]
    assert left.imag > right.imag  # a dancer who faces the audience has her left at +x
    time = np.linspace(0.0, 1.0, 11)
    path = frenet_cloud(time, np.stack((0.0 * time, time), axis=1), 60.0)
    np.testing.assert_allclose(path.floor[0] - path.floor[0].mean(), hips.floor[0] - hips.floor[0].mean(), atol=1e-9)
