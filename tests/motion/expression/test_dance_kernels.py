"""Tests of what is measured of a dance: heads that turn, and the kinetic energy against that of all segments."""

import math

import numpy as np
import pytest

from live.graph.step_library import build_library
from live.library.step_folder import load_folder
from live.motion import quaternion
from live.motion.editing.body_mass import SEGMENTS, joint_inertias
from live.motion.expression.dance_kernels import ENERGY, HEAD_JOINT, HEAD_YAW, LEAD_S, TURN, measure_dance
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from tests.fixtures.made_steps import made_clip
from tests.places import ROOT

MEASURE_S = 2.0
INERTIA = joint_inertias().astype(np.float32)


def measured(library, sample, *, yaw=0.0, head=0.0):
    """What is measured at the `sample` (A,) of node 0 of a library, (A, 3)."""
    count = len(sample)
    out, nodes = np.zeros((count, 3), np.float32), np.zeros(count, np.int32)
    placement = np.zeros((4, count, 4))
    placement[..., 3] = yaw
    for odd in (0, 1):
        measure_dance(
            out, library.store.root, library.store.rotation, np.tile(np.asarray(sample, np.float64), (4, 1)), placement,
            np.zeros(count, np.float32), np.full(count, 0.5), nodes - 1, nodes, nodes - 1, False, library.node_first,
            library.node_last, library.node_lead, MEASURE_S, np.full(count, head), INERTIA, odd, 0, count,
        )  # fmt: skip
    return out


def test_head_of_a_spin_is_known_ahead():
    library = build_library([made_clip("spin", turn=2.0 * math.pi)])
    sample = np.linspace(library.node_first[0], library.node_last[0] - 8.0, 5)
    found = measured(library, np.round(sample), yaw=0.3)
    rate = 2.0 * math.pi / MEASURE_S
    assert found[:, TURN] == pytest.approx(rate * LEAD_S, abs=rate * MEASURE_S / 32.0)  # a sample
    share = (np.round(sample) - library.node_first[0]) / 32.0
    off = np.angle(np.exp(1j * (found[:, HEAD_YAW] - 2.0 * math.pi * share - 0.3)))
    assert np.abs(off).max() < 1e-3


def test_head_that_faces_the_public_turns_as_it_is_drawn():
    """With the chest at most 60 degrees aside the head stays on the public, whatever the body does."""
    library = build_library([made_clip("spin", turn=2.0 * math.pi)])
    sample = library.node_first[0] + np.array([0.0, 1.0])
    found = measured(library, sample, head=1.0)
    assert np.abs(found[:, HEAD_YAW]).max() < 1e-3
    assert np.abs(found[:, TURN]).max() < 0.05


def test_turn_does_not_go_beyond_the_end_of_a_clip():
    library = build_library([made_clip("spin", turn=2.0 * math.pi)])
    assert measured(library, np.array([library.node_last[0]]))[0, TURN] == 0.0


def exact_energy(clip, rate):
    """Kinetic energy per kilogram at the samples of a clip but the first and last two, by forward kinematics: the sum
    of ½ m v² and ½ I ω² of all segments."""
    position, rotation = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    energy = np.zeros(len(position) - 4)
    for joint, (share, at, radii) in SEGMENTS.items():
        centre = position[:, joint] + quaternion.rotate(rotation[:, joint], at)
        velocity = (centre[4:] - centre[:-4]) * rate / 4.0
        turn = quaternion.mul(quaternion.inverse(rotation[:-4, joint]), rotation[4:, joint])
        spin = 2.0 * turn[:, 1:] * np.sign(turn[:, :1]) * rate / 4.0
        energy += 0.5 * share * ((velocity**2).sum(axis=-1) + ((radii * spin) ** 2).sum(axis=-1))
    return energy


@pytest.mark.long
def test_energy_follows_that_of_all_segments():
    """In time within each step, and from step to step."""
    means, alike = [], []
    for clip in load_folder(ROOT / "patches" / "steps"):
        if clip.mirrored or clip.unjoined:
            continue
        library = build_library([clip])
        first, last = int(library.node_first[0]), int(library.node_last[0])
        sample = np.arange(first + 2, last - 2)
        found = measured(library, sample)[:, ENERGY]
        exact = exact_energy(clip.clip, (last - first) / MEASURE_S)[sample - 2]
        means.append((found.mean(), exact.mean()))
        alike.append(np.corrcoef(found, exact)[0, 1])
    found, exact = np.array(means).T
    assert np.median(alike) > 0.85
    assert np.corrcoef(np.log(found), np.log(exact))[0, 1] > 0.85
    assert 0.8 < np.median(found / exact) < 1.8


def test_chain_from_hips_to_head_is_the_first_six_joints():
    assert SKELETON.names[HEAD_JOINT] == "head"
    assert SKELETON.parents[: HEAD_JOINT + 1].tolist() == [-1, 0, 1, 2, 3, 4]
