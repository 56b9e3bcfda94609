"""Tests of VMC input: bones become full poses on the engine's skeleton with capture times; seats of performers."""

import socket

import numpy as np
import pytest

from live.base.event_queue import EventQueue, PriorityQueue
from live.bridges.vmc.test_vmc_protocol import bundle, message
from live.bridges.vmc.vmc_input import DEFAULT_PERFORMER, SEAT_TIMEOUT, Seat, Seats, VmcInput, VmcStream
from live.bridges.vmc.vmc_protocol import vmc_packets
from live.clock.time_source import ManualClock
from live.control.registry.rejections import Reason, Tally
from live.control.udp_input import MAX_PER_WINDOW
from live.motion import quaternion
from live.motion.capture.packed_pose import unpack_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, SKELETON
from tests.control.waiting import wait_for


def poses(count, seed=2):
    """Hips (n, 3) and rotations (n, J, 4) with small motion in all joints, feet near the floor."""
    chance = np.random.default_rng(seed)
    way = chance.normal(scale=0.2, size=(JOINT_COUNT, 3))
    phase = np.linspace(0.0, 3.0, count)[:, None, None]
    rotation = quaternion.from_rotation_vector(way * np.sin(phase))
    hips = np.column_stack([np.sin(phase[:, 0, 0]), np.full(count, 0.935), np.cos(phase[:, 0, 0])])
    positions, _ = forward_kinematics(hips, rotation)
    hips[:, 1] -= (positions[:, [SKELETON.index(s + "Foot") for s in ("left", "right")], 1] - 0.085).min(axis=1)
    return hips, rotation


def stream(seat=lambda time: Seat("anna")):
    given, tally = [], Tally()
    return VmcStream(seat, tally, given.append), given, tally


def test_sent_poses_are_received_unchanged():
    hips, rotation = poses(60)
    hearing, given, tally = stream(lambda time: Seat("anna", floor=False))
    for n in range(60):
        for data in vmc_packets(hips[n], rotation[n], n / 60.0):
            hearing.handle(data, 5.0 + n / 60.0)
    assert tally.as_dict() == {}
    assert [frame.time for frame in given] == pytest.approx([5.0 + n / 60.0 for n in range(60)])
    assert {frame.performer for frame in given} == {"anna"}
    came = [unpack_pose(frame.pose) for frame in given]
    np.testing.assert_allclose([root for root, _ in came], hips, atol=1e-4)
    turned = np.array([q for _, q in came])
    assert np.abs(np.sum(turned * rotation, axis=-1)).min() > 1.0 - 1e-6


def unity_bones(scale, hips, rotation, arm=(0.0, 0.0, 0.0)):
    """A pose sent by a body `scale` times as long as the engine's, with upper arms offset by `arm` in its rest pose."""
    told = []
    for joint, name in enumerate(SKELETON.names):
        x, y, z = scale * (SKELETON.offsets[joint] if joint else hips) + (arm if name.endswith("LowerArm") else 0.0)
        w, i, j, k = rotation[joint]
        told.append(message("/VMC/Ext/Bone/Pos", name[0].upper() + name[1:], *map(float, (-x, y, z, i, -j, -k, w))))
    return told


def test_longer_body_gives_same_pose_with_scaled_feet():
    hips, rotation = poses(3)
    for n in range(3):
        hearing, given, _ = stream()
        hearing.handle(bundle(*unity_bones(1.25, hips[n], rotation[n])).dgram, 1.0)
        root, turned = unpack_pose(given[0].pose)
        feet = [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")]
        there = forward_kinematics(root[None].astype(float), turned[None].astype(float))[0][0, feet]
        stood = forward_kinematics(hips[n : n + 1], rotation[n : n + 1])[0][0, feet]
        np.testing.assert_allclose(there[:, ::2], stood[:, ::2], atol=1e-3)
        assert np.abs(np.sum(turned * rotation[n], axis=-1)).min() > 1.0 - 1e-6


def test_bone_directions_match_sender_in_any_rest_pose():
    hips, rotation = poses(1)
    hearing, given, _ = stream()
    lean = np.array([0.0, -0.1, 0.02])
    hearing.handle(bundle(*unity_bones(1.0, hips[0], rotation[0], lean)).dgram, 1.0)
    _, turned = unpack_pose(given[0].pose)
    ours, _ = forward_kinematics(np.zeros((1, 3)), turned[None].astype(float))
    _, world = forward_kinematics(np.zeros((1, 3)), rotation)
    for side in ("left", "right"):
        upper, lower = SKELETON.index(side + "UpperArm"), SKELETON.index(side + "LowerArm")
        hers = quaternion.rotate(world[0, upper], SKELETON.offsets[lower] + lean)
        bone = ours[0, lower] - ours[0, upper]
        assert bone @ hers / np.linalg.norm(bone) / np.linalg.norm(hers) > 1.0 - 1e-6


def test_feet_are_moved_to_floor_and_jumps_kept():
    hearing, given, _ = stream()
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    for n in range(300):
        jump = 0.3 * max(np.sin(np.pi * (n - 200) / 30.0), 0.0) if 200 <= n < 230 else 0.0
        for data in vmc_packets(np.array([0.0, 1.7 + jump, 0.0]), rotation, n / 60.0):
            hearing.handle(data, n / 60.0)
    heights = np.array([unpack_pose(frame.pose)[0][1] for frame in given])
    rest = SKELETON.offsets[0, 1]
    np.testing.assert_allclose(heights[:200], rest, atol=0.02)
    np.testing.assert_allclose(heights[200:230].max() - rest, 0.3, atol=0.03)


def test_incomplete_or_untracked_poses_are_dropped():
    hips, rotation = poses(4)
    hearing, given, tally = stream()
    packets = [list(vmc_packets(hips[n], rotation[n], n / 60.0)) for n in range(4)]
    for n, some in enumerate((packets[0], packets[1][1:], packets[2], packets[3])):
        for data in some:
            hearing.handle(data, n / 60.0)
    assert [round(60.0 * frame.time) for frame in given] == [0, 2, 3]
    alone = message("/VMC/Ext/Bone/Pos", "Head", 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0).dgram
    for _ in range(3):
        hearing.handle(alone, 1.0)
    assert tally.as_dict() == {Reason.TRUNCATED: 1 + 2}
    for n in (4, 5):
        for data in vmc_packets(hips[0], rotation[0], n / 60.0):
            hearing.handle(data, n / 60.0)
    assert len(given) == 5
    hearing.handle(message("/VMC/Ext/OK", 0).dgram, 1.0)
    body = [message("/VMC/Ext/Bone/Pos", name[0].upper() + name[1:], 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0)
            for name in SKELETON.names]  # fmt: skip
    hearing.handle(bundle(*body).dgram, 1.1)
    assert len(given) == 5


def test_body_with_fewer_bones_gives_full_poses():
    hips, rotation = poses(1)
    hearing, given, _ = stream()
    fewer = [
        each
        for each in unity_bones(1.0, hips[0], rotation[0])
        if b"UpperChest" not in each.dgram and b"Toes" not in each.dgram
    ]
    for n in range(4):
        hearing.handle(bundle(*fewer).dgram, n / 60.0)
    assert [round(60.0 * frame.time) for frame in given] == [2, 3]
    chest = unpack_pose(given[0].pose)[1][SKELETON.index("upperChest")]
    np.testing.assert_allclose(chest, [1.0, 0.0, 0.0, 0.0], atol=1e-6)


def test_sender_clock_evens_arrival_times_and_may_jump():
    hips, rotation = poses(1)
    hearing, given, _ = stream()
    chance = np.random.default_rng(4)
    late = chance.uniform(0.0, 0.02, 120)
    late[0] = 0.0
    for n in range(120):
        sent = n / 30.0 + (500.0 if n >= 60 else 0.0)
        for data in vmc_packets(hips[0], rotation[0], sent):
            hearing.handle(data, 3.0 + n / 30.0 + late[n])
    times = np.array([frame.time for frame in given])
    np.testing.assert_allclose(np.diff(times[:60]), 1 / 30.0, atol=1e-4)
    np.testing.assert_allclose(np.diff(times[62:]), 1 / 30.0, atol=0.02)
    assert (times <= 3.0 + np.arange(120) / 30.0 + late + 1e-6).all()


def test_seats_are_assigned_by_host_port_then_order():
    seats = Seats((Seat("any"), Seat("second"), Seat("lab", sender="10.0.0.7"), Seat("phone", port=39541)))

    def name(who, port, host, time):
        seat = seats.find((who, host, port), port, host, time)
        return None if seat is None else seat.name

    assert name("a", 39539, "10.0.0.7", 0.0) == "lab"
    assert name("b", 39541, "10.0.0.9", 0.0) == "phone"
    assert name("c", 39539, "10.0.0.1", 0.0) == "any"
    assert name("d", 39539, "10.0.0.2", 0.5) == "second"
    assert name("e", 39539, "10.0.0.3", 0.5) is None
    assert name("c", 39539, "10.0.0.1", 1.0) == "any"
    assert name("e", 39539, "10.0.0.3", 0.6 + SEAT_TIMEOUT) == "second"
    assert Seats(()).find("x", 1, "h", 0.0).name == DEFAULT_PERFORMER


def test_poses_of_each_sender_are_queued_and_malformed_data_refused():
    inbox, clock = EventQueue(), ManualClock()
    hearing = VmcInput((("127.0.0.1", 0), ("127.0.0.1", 0)), (Seat("anna"), Seat("ben")), inbox.add_queue(), clock)
    hearing.start()
    hips, rotation = poses(3)
    try:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as two,
        ):
            sent = 0
            for n in range(3):
                clock.set(1.0 + n)
                for sock, port in zip((one, two), hearing.ports, strict=True):
                    for data in (b"rubbish!", *vmc_packets(hips[n], rotation[n], float(n))):
                        sock.sendto(data, ("127.0.0.1", port))
                        sent += 1
                assert wait_for(lambda sent=sent: hearing.received == sent, 2.0)
        frames = inbox.drain()
        assert {(frame.performer, frame.time) for frame in frames} == {
            (name, time) for name in ("anna", "ben") for time in (1.0, 2.0, 3.0)
        }
        assert hearing.status()["performers"]["anna"]["bones"] == JOINT_COUNT
        assert hearing.rejected.as_dict() == {Reason.NO_TYPES: 6} or hearing.rejected.total == 6
    finally:
        hearing.stop()
    hearing.stop()


def test_flood_of_datagrams_is_refused_unread():
    lane, clock = PriorityQueue(), ManualClock()
    hearing = VmcInput((), (), lane, clock)

    class Rubbish:
        def read(self):
            return [(b"x", ("10.0.0.1", 1))] * 256

    hearing._stopping.set()  # nothing is waited for
    for _ in range(20):
        hearing.receive(Rubbish(), 39539)
    assert hearing.rejected.as_dict() == {Reason.ALIGNMENT: MAX_PER_WINDOW, Reason.FLOOD: 20 * 256 - MAX_PER_WINDOW}
