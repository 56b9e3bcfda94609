"""Tests of the all-pairs metric (K003) against closed form K001, a search over angles, and its invariances."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from live.graph.build.transitions import WINDOW_SAMPLES, all_pairs, joint_weights, transition_windows, window_weights
from live.graph.step_library import build_library
from live.motion.skeleton import JOINT_COUNT
from tests.fixtures.made_steps import made_steps


def _clouds(seed, count):
    return np.random.default_rng(seed).normal(0, 0.5, (count, WINDOW_SAMPLES, JOINT_COUNT, 3))


def _weights():
    return np.outer(window_weights(), joint_weights()).reshape(-1)


def _transform_points(points, x, z, yaw):
    """K001's transform of points (P, 3)."""
    c, s = math.cos(yaw), math.sin(yaw)
    px, py, pz = points.T
    return np.stack([px * c + pz * s + x, py, -px * s + pz * c + z], axis=1)


def _closed_form(first, second, w):
    """K001 as printed by Kovar, with atan2."""
    (x, _, z), (xs, _, zs) = first.T, second.T
    total = w.sum()
    bx, bz, bxs, bzs = (w * x).sum(), (w * z).sum(), (w * xs).sum(), (w * zs).sum()
    yaw = math.atan2(
        (w * (x * zs - xs * z)).sum() - (bx * bzs - bxs * bz) / total,
        (w * (x * xs + z * zs)).sum() - (bx * bxs + bz * bzs) / total,
    )
    x0 = (bx - bxs * math.cos(yaw) - bzs * math.sin(yaw)) / total
    z0 = (bz + bxs * math.sin(yaw) - bzs * math.cos(yaw)) / total
    return x0, z0, yaw


def test_all_pairs_equal_closed_form():
    first, second, w = _clouds(1, 3), _clouds(2, 4), _weights()
    found = all_pairs(first, second)
    for i in range(3):
        for j in range(4):
            a, b = first[i].reshape(-1, 3), second[j].reshape(-1, 3)
            x0, z0, yaw = _closed_form(a, b, w)
            assert found.yaw[i, j] == pytest.approx(yaw, abs=1e-9)
            assert found.shift[i, j] == pytest.approx((x0, z0), abs=1e-9)
            squared = (w * ((a - _transform_points(b, x0, z0, yaw)) ** 2).sum(1)).sum()
            assert found.distance[i, j] ** 2 == pytest.approx(squared, rel=1e-9)


def test_found_rigid_motion_minimizes_distance():
    first, second, w = _clouds(3, 1), _clouds(4, 1), _weights()
    found = all_pairs(first, second)
    a, b = first[0].reshape(-1, 3), second[0].reshape(-1, 3)

    def squared(motion):
        return (w * ((a - _transform_points(b, *motion)) ** 2).sum(1)).sum()

    best = min(minimize(squared, (0, 0, angle)).fun for angle in np.linspace(-3, 3, 7))
    assert found.distance[0, 0] ** 2 == pytest.approx(best, rel=1e-6)


@settings(max_examples=40, deadline=None)
@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3.1, 3.1))
def test_transform_of_moved_cloud_is_recovered(x, z, yaw):
    cloud = _clouds(5, 1)
    moved = _transform_points(cloud.reshape(-1, 3), x, z, yaw).reshape(cloud.shape)
    found = all_pairs(moved, cloud)
    assert found.distance[0, 0] < 1e-5
    assert math.cos(found.yaw[0, 0] - yaw) == pytest.approx(1.0, abs=1e-9)
    assert found.shift[0, 0] == pytest.approx((x, z), abs=1e-6)


def test_periodic_step_follows_itself_at_zero_distance():
    library = build_library(made_steps())
    found = all_pairs(*transition_windows(library, 0.2))
    same = np.diag(found.distance)
    assert same.max() < 1e-3
    spin = library.steps.index("spin")
    node = int(np.flatnonzero(library.node_step == spin)[0])
    assert math.cos(found.yaw[node, node]) == pytest.approx(1.0, abs=1e-6)
    glide = int(np.flatnonzero(library.node_travel[:, 1] > 0.5)[0])
    assert found.shift[glide, glide] == pytest.approx((0.0, 0.8), abs=1e-4)
