"""Captured poses: what is remembered is found, at the memory's ends too; from pose to pose no limb swings round."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.captured.kernels import (
    ASKED,
    BEAT,
    CAUGHT,
    KEY,
    SHARE,
    TIME,
    TURNED,
    WANTED,
    find_places,
    put_agents,
    take_dance_along,
    wear,
    where_captured,
)
from live.motion.forward import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, MIRROR, SKELETON

OFFSETS, PARENTS = np.array(SKELETON.offsets), np.array(SKELETON.parents)
OTHER = np.array(MIRROR, np.int32)


def memory(size, count, turn=0.0):
    """`count` poses, one a second, that go 1 m along x each; of `size` that there is room for."""
    root, turned = np.zeros((size + 1, 3), np.float32), np.zeros((size + 1, JOINT_COUNT, 4), np.float32)
    turned[..., 0] = 1.0
    stamp = np.full((size, 2), -np.inf)
    for n in range(max(count - size, 0), count):
        root[n % size] = n, 0.9, 0.0
        turned[n % size, 0] = np.cos(turn * n / 2), 0.0, np.sin(turn * n / 2), 0.0
        stamp[n % size] = n, 2.0 * n
    return root, turned, stamp


def asked(**columns):
    row = np.zeros((1, ASKED))
    row[0, CAUGHT] = 1.0
    for name, value in columns.items():
        row[0, {"key": KEY, "wanted": WANTED, "share": SHARE, "caught": CAUGHT, "turned": TURNED}[name]] = value
    return row


@pytest.mark.parametrize(("size", "count"), [(4, 1), (4, 3), (4, 4), (4, 6), (4, 9)])
def test_every_remembered_moment_is_found_and_none_beyond(size, count):
    root, turned, stamp = memory(size, count)
    place = np.zeros((1, 4))
    for wanted in (-1.0, 0.0, count - 2.25, count - 1.0, count + 7.0):
        for key, scale in ((TIME, 1.0), (BEAT, 2.0)):
            row = asked(key=key, wanted=scale * wanted)
            where_captured(place, row, root, turned, stamp, count, 1.0, False)
            assert place[0, 0] == pytest.approx(np.clip(wanted, max(count - size, 0), count - 1.0))


def test_a_pose_comes_back_from_the_one_that_was_held():
    root, turned, stamp = memory(4, 3)
    root[4] = -8.0, 0.9, 0.0
    place = np.zeros((1, 4))
    for caught, x in ((0.0, -8.0), (0.5, -3.0), (1.0, 2.0)):
        where_captured(place, asked(wanted=2.0, caught=caught), root, turned, stamp, 3, 1.0, False)
        assert place[0, 0] == pytest.approx(x)


def test_shares_go_from_the_own_pose_to_the_captured_one_the_way_that_was_counted():
    root, turned, stamp = memory(4, 2)
    turned[1, 0] = np.cos(1.5), 0.0, np.sin(1.5), 0.0  # 3 rad
    own = np.zeros((1, JOINT_COUNT, 4))
    own[..., 0] = 1.0
    place = np.array([[5.0, 0.8, 1.0]])
    for counted, way in ((3.0, 3.0), (3.0 - 2.0 * np.pi, 3.0 - 2.0 * np.pi)):
        for share in (0.25, 0.5, 1.0):
            position, rotation = (each.astype(np.float32) for each in forward_kinematics(place, own))
            row = asked(wanted=1.0, share=share, turned=counted)
            wear(
                position,
                rotation,
                np.zeros(1, np.int64),
                row,
                root,
                turned,
                stamp,
                2,
                1.0,
                False,
                OFFSETS,
                PARENTS,
                OTHER,
            )
            np.testing.assert_allclose(position[0, 0], [5.0 - 4.0 * share, 0.8 + 0.1 * share, 1.0 - share], atol=1e-5)
            there = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(share * way))
            assert abs(there @ rotation[0, 0]) == pytest.approx(1.0, abs=1e-5)


def test_places_agents_and_what_is_planned_go_along_with_who_is_wholly_captured():
    root, turned, stamp = memory(4, 3)
    rows, dancers = np.array([1, 2]), 3
    shown = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 4.0]], np.float32)
    legs = np.zeros((dancers, 9, 4), np.float32)
    legs[..., 0] = 1.0
    row = np.concatenate([asked(wanted=2.0, share=1.0), asked(wanted=1.0, share=0.5)])
    there, way, away = np.empty((2, 2)), np.empty((2, 2)), np.array([9.0, 0.0])
    live = np.array([True, False])
    find_places(there, way, away, rows, live, row, root, turned, stamp, 3, 1.0, False, shown, legs)
    np.testing.assert_allclose(there, [[2.0, 0.0], [0.5, 2.0]])
    np.testing.assert_allclose(way, [[1.0, -1.0], [0.0, 0.0]])
    np.testing.assert_allclose(away, 0.0, atol=1e-6)
    flat, place, speed = np.ones(8 * dancers, np.float32), np.zeros((dancers, 2)), np.zeros((dancers, 2))
    led = np.array([False, True, True])
    put_agents(rows, live, there, place, speed, led, flat, 0.5, 2.0, 0.5)
    assert flat[:6].tolist() == [1.0, 1.0, 2.0, 0.0, 1.0, 1.0]
    assert flat[6:12].tolist() == [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]  # half of 4 m/s, of which 2 are believed
    assert flat[12:].tolist() == [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0]
    plans = [np.zeros((dancers, columns)) for columns in (3, 3, 3, 2, 2, 2)]
    paths, lock = [np.zeros((dancers, 5, 2), np.float32) for _ in range(2)], np.ones((dancers, 2, 12), np.float32)
    take_dance_along(rows[:1], way[:1], *plans, *paths, shown, lock)
    assert shown.tolist() == [[0.0, 0.0], [2.0, 0.0], [0.0, 4.0]]
    for plan in (*plans, *(path[:, -1] for path in paths)):
        assert plan[:, :2].tolist() == [[0.0, 0.0], [1.0, -1.0], [0.0, 0.0]]
    assert lock.sum(axis=(1, 2)).tolist() == [24.0, 0.0, 24.0]
