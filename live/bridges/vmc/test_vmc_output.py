"""Tests of VMC output: dancers as decoded by python-osc, and the round trip through the VMC input."""

import socket

import numpy as np
import pytest
from pythonosc.osc_bundle import OscBundle

from live.base.errors import PersonError
from live.bridges.vmc.test_vmc_input import poses, stream
from live.bridges.vmc.vmc_input import Seat
from live.bridges.vmc.vmc_output import AvatarTarget, VmcOutput, pack_dancers
from live.bridges.vmc.vmc_output_service import parse_avatars
from live.clock.time_source import SystemClock
from live.control.helper_process import HelperProcess
from live.motion.capture.packed_pose import unpack_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, SKELETON


@pytest.fixture
def receivers():
    """Two sockets at consecutive ports."""
    for _ in range(100):
        one, two = (socket.socket(type=socket.SOCK_DGRAM) for _ in range(2))
        one.bind(("127.0.0.1", 0))
        try:
            two.bind(("127.0.0.1", one.getsockname()[1] + 1))
        except OSError:
            one.close()
            two.close()
            continue
        for each in (one, two):
            each.settimeout(10.0)
        yield one, two
        one.close()
        two.close()
        return


def make_dancers():
    """Two dancers in the world: positions (2, J, 3) and rotations (2, J, 4)."""
    hips, rotation = poses(2)
    return hips, rotation, *(each.astype(np.float32) for each in forward_kinematics(hips, rotation))


def receive(ear, datagrams=2):
    return [ear.recv(4096) for _ in range(datagrams)]


def test_python_osc_reads_every_bone_in_unity_axes(receivers):
    hips, rotation, position, world = make_dancers()
    out = VmcOutput(*receivers[0].getsockname())
    out.send_dancers(2.5, pack_dancers(np.array([0, 1]), position, world))
    out.close()
    for dancer, ear in enumerate(receivers):
        messages = [message for data in receive(ear) for message in OscBundle(data)]
        assert messages[0].address == "/VMC/Ext/OK"
        assert messages[0].params[0] == 1
        assert (messages[-1].address, messages[-1].params) == ("/VMC/Ext/T", [2.5])
        assert messages[1].params == ["root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        bones = {message.params[0]: message.params[1:] for message in messages if "Bone" in message.address}
        assert len(bones) == JOINT_COUNT
        x, y, z = hips[dancer]
        assert bones["Hips"][:3] == pytest.approx((-x, y, z), abs=1e-5)
        for joint, name in enumerate(SKELETON.names):
            i, j, k, w = bones[name[0].upper() + name[1:]][3:]
            # mirrored in x, a turn about y or z goes the other way
            assert abs(np.dot((w, i, -j, -k), rotation[dancer, joint])) == pytest.approx(1.0, abs=1e-5)
    assert out.failed == 0


def test_pose_sent_by_helper_process_is_received_unchanged(receivers):
    hips, rotation, position, world = make_dancers()
    helper = HelperProcess(
        "live.bridges.vmc.vmc_output", SystemClock(), {"targets": [receivers[0].getsockname()]}, lambda: None
    )
    try:
        helper.start()
        assert helper.send((0, 1.0, pack_dancers(np.array([1]), position, world)))
        hearing, given, tally = stream(lambda time: Seat("anna", floor=False))
        for data in receive(receivers[0]):
            hearing.handle(data, 7.0)
    finally:
        helper.stop()
    root, turned = unpack_pose(given[0].pose)
    assert tally.total == 0
    np.testing.assert_allclose(root, hips[1], atol=1e-4)
    assert np.abs(np.sum(turned * rotation[1], axis=-1)).min() > 1.0 - 1e-6


def test_avatar_targets_are_parsed():
    assert parse_avatars("39540") == AvatarTarget("127.0.0.1", 39540)
    assert parse_avatars("10.0.0.2:39539=ember & 1-3@30") == AvatarTarget("10.0.0.2", 39539, "ember & 1-3", 30.0)
    for text in ("", "=1", "host", "1.2.3.4:1@0", "1.2.3.4:1@500", "1.2.3.4:1="):
        with pytest.raises(PersonError):
            parse_avatars(text)
