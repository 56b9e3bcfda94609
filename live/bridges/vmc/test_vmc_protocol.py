"""Tests of the VMC decoder: packets built by python-osc, and malformed packets."""

import math
import random
import struct

import numpy as np
import pytest
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from live.bridges.vmc.vmc_protocol import BONES, MAX_PACKET_BYTES, UNUSED_BONE, decode_vmc, vmc_packets
from live.control.registry.rejections import Reason, Tally
from live.motion import quaternion
from live.motion.skeleton import JOINT_COUNT, SKELETON

HIPS = ("Hips", 0.1, 0.9, 0.2, 0.0, 0.0, 0.0, 1.0)


class RecordingListener:
    """Records the decoded messages."""

    def __init__(self):
        self.bones, self.roots, self.states, self.times = {}, [], [], []

    def bone(self, joint, bone):
        self.bones[joint] = bone

    def root(self, bone):
        self.roots.append(bone)

    def tracked(self, on):
        self.states.append(on)

    def sender_time(self, time):
        self.times.append(time)


def message(address, *values):
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)
    return builder.build()


def bundle(*contents):
    builder = OscBundleBuilder(IMMEDIATELY)
    for each in contents:
        builder.add_content(each)
    return builder.build()


def decode(data):
    listener, tally = RecordingListener(), Tally()
    decode_vmc(data, listener, tally)
    return listener, tally.as_dict()


def test_foreign_bundle_is_decoded_with_axes_converted():
    half = math.sqrt(0.5)
    left = message("/VMC/Ext/Bone/Pos", "LeftUpperArm", -0.1, 0.2, 0.3, half, 0.0, 0.0, half)
    turned = message("/VMC/Ext/Root/Pos", "root", 1.0, 0.0, 2.0, 0.0, half, 0.0, half)
    listener, refused = decode(
        bundle(
            message("/VMC/Ext/OK", 1, 3, 0, 1), turned, bundle(left), message("/VMC/Ext/Bone/Pos", *HIPS),
            message("/VMC/Ext/T", 12.5), message("/VMC/Ext/Blend/Val", "Joy", 1.0), message("/VMC/Ext/Blend/Apply"),
        ).dgram
    )  # fmt: skip
    assert refused == {}
    assert (listener.states, listener.times) == ([True], [12.5])
    assert set(listener.bones) == {0, SKELETON.index("leftUpperArm")}
    arm = listener.bones[SKELETON.index("leftUpperArm")]
    assert arm == pytest.approx((0.1, 0.2, 0.3, half, half, 0.0, 0.0))  # Unity's left is at -x, ours at +x
    (root,) = listener.roots
    forward = quaternion.rotate(np.array(root[3:]), np.array([0.0, 0.0, 1.0]))
    # in Unity a turn of +90 degrees about y looks to +x, which is our -x
    assert forward == pytest.approx((-1.0, 0.0, 0.0), abs=1e-6)


def test_unity_bones_are_known_and_extra_data_is_ignored():
    assert sum(joint != UNUSED_BONE for joint in BONES.values()) == JOINT_COUNT
    for data in (
        message("/VMC/Ext/Bone/Pos", "LeftThumbProximal", *HIPS[1:]),
        message("/VMC/Ext/Bone/Pos", "LastBone", *HIPS[1:]),
        message("/VMC/Ext/Hmd/Pos", "x"),
        message("/VMC/Ext/Blend/Apply"),
    ):
        listener, refused = decode(data.dgram)
        assert (listener.bones, refused) == ({}, {})
    listener, refused = decode(message("/VMC/Ext/Bone/Pos", *HIPS, 3, "more").dgram)
    assert (set(listener.bones), refused) == ({0}, {})
    assert decode(message("/VMC/Ext/OK", 1).dgram)[0].states == [True]
    for state in ((0,), (1, 2, 0), (1, 3, 0, 0)):
        assert decode(message("/VMC/Ext/OK", *state).dgram)[0].states == [False]


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (message("/VMC/Ext/Bone/Pos", *HIPS[:7]).dgram, Reason.MISSING),
        (message("/VMC/Ext/Bone/Pos", *HIPS[:7], 1).dgram, Reason.WRONG_TYPE),
        (message("/VMC/Ext/Bone/Pos", 1, *HIPS[1:]).dgram, Reason.WRONG_TYPE),
        (message("/VMC/Ext/Bone/Pos", "Tail", *HIPS[1:]).dgram, Reason.NAME),
        (message("/VMC/Ext/Bone/Pos", *HIPS[:4], 0.0, 0.0, 0.0, 0.2).dgram, Reason.OUT_OF_RANGE),
        (message("/VMC/Ext/Bone/Pos", *HIPS[:4], 0.0, 0.0, 0.0, 0.0).dgram, Reason.OUT_OF_RANGE),
        (message("/VMC/Ext/Bone/Pos", "Hips", 1e30, *HIPS[2:]).dgram, Reason.OUT_OF_RANGE),
        (message("/VMC/Ext/Bone/Pos", "Hips", math.nan, *HIPS[2:]).dgram, Reason.NOT_FINITE),
        (message("/VMC/Ext/Bone/Pos", *HIPS[:7], math.inf).dgram, Reason.NOT_FINITE),
        (message("/VMC/Ext/OK").dgram, Reason.MISSING),
        (message("/VMC/Ext/OK", "yes").dgram, Reason.WRONG_TYPE),
        (message("/VMC/Ext/T", 3).dgram, Reason.WRONG_TYPE),
        (message("/dance/attract", 1.0, 2.0).dgram, Reason.UNKNOWN_ADDRESS),
        (b"", Reason.PACKET_SIZE),
        (b"\0" * (MAX_PACKET_BYTES + 4), Reason.PACKET_SIZE),
        (b"abc", Reason.ALIGNMENT),
        (b"#bundle\0" + bytes(8) + struct.pack(">i", -4) + bytes(8), Reason.ELEMENT_SIZE),
        (b"#bundle\0" + bytes(8) + struct.pack(">i", 4000) + bytes(8), Reason.ELEMENT_SIZE),
        (b"#bundle\0" + bytes(4), Reason.TRUNCATED),
        (bundle(bundle(bundle(bundle(bundle(message("/VMC/Ext/T", 1.0)))))).dgram, Reason.DEPTH),
        (bundle(*[message("/VMC/Ext/Blend/Apply")] * 257).dgram, Reason.MANY_MESSAGES),
    ],
    ids=lambda value: str(len(value)) if isinstance(value, bytes) else None,
)
def test_malformed_packet_is_refused_with_its_reason(data, reason):
    listener, refused = decode(data)
    assert (listener.bones, listener.roots, listener.states) == ({}, [], [])
    assert refused == {reason: 1}


def test_invalid_bone_does_not_affect_other_bones():
    listener, refused = decode(
        bundle(
            message("/VMC/Ext/Bone/Pos", "Head", math.nan, *HIPS[2:]),
            message("/VMC/Ext/Bone/Pos", *HIPS),
        ).dgram
    )
    assert set(listener.bones) == {0}
    assert refused == {Reason.NOT_FINITE: 1}


def test_mutated_packets_give_finite_numbers_or_refusals():
    chance = random.Random(11)
    rotation = np.zeros((JOINT_COUNT, 4))
    rotation[:, 0] = 1.0
    good = [*vmc_packets(np.array([0.1, 0.9, 0.2]), rotation, 3.0), bundle(message("/VMC/Ext/OK", 1, 3, 0, 1)).dgram]
    listener, tally = RecordingListener(), Tally()
    for _ in range(2000):
        data = bytearray(chance.choice(good))
        for _ in range(chance.choice((1, 1, 2, 8))):
            data = data if len(data) >= 4 else bytearray(4)
            match chance.randrange(4):
                case 0:
                    data[chance.randrange(len(data))] = chance.randrange(256)
                case 1:
                    at = 4 * chance.randrange(len(data) // 4)
                    data[at : at + 4] = chance.choice(
                        (b"\xff\xff\xff\xfc", b"\x7f\xc0\0\0", b"\x7f\xff\xff\xff", bytes(4))
                    )
                case 2:
                    del data[4 * chance.randrange(max(len(data) // 4, 1)) :]
                case _:
                    at = 4 * chance.randrange(len(data) // 4)
                    data[at:at] = bytes(data[at : at + 4 * chance.randrange(8)])
        decode_vmc(bytes(data), listener, tally)
    assert tally.total > 300
    assert all(math.isfinite(value) for bone in (*listener.bones.values(), *listener.roots) for value in bone)
