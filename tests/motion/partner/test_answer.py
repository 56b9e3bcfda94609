"""Tests of the partner answer: the copied follower, its placement, and continuity where units meet."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.partner.answer import answer, enforce_holds, hold_error, palms
from live.motion.partner.decoder import Reading
from live.motion.partner.evaluation import joint_positions
from live.motion.partner.partner_synthesis import SearchSettings, find_partner
from live.motion.partner.point_clouds import ends_cloud
from live.motion.partner.units import Example, Hold, Units, cut_units
from live.motion.skeleton import JOINT_COUNT, SKELETON
from tests.motion.partner.made_examples import standing

RATE = 60.0


def random_dance_clip(seed: int, samples: int, name: str = "dance") -> Clip:
    """Clip of a body that walks and swings its limbs smoothly at random."""
    chance = np.random.default_rng(seed)
    time = np.arange(samples)[:, None] / RATE
    vector = np.zeros((samples, JOINT_COUNT, 3))
    for wave in range(1, 4):
        size = 0.3 / wave * chance.normal(size=(1, JOINT_COUNT, 3))
        vector += size * np.sin(2.0 * np.pi * 0.35 * wave * time[..., None] + chance.uniform(0, 6, (1, JOINT_COUNT, 3)))
    root = SKELETON.rest_positions()[0] + np.concatenate(
        [np.sin(0.5 * time + 1), 0.03 * np.sin(5 * time), np.cos(0.7 * time)], axis=1
    )
    rotation = quaternion.from_rotation_vector(vector)
    contact = np.zeros((samples, 2), np.bool_)
    return Clip(name, root.astype(np.float32), rotation.astype(np.float32), RATE, contact)


def pair_of(seed: int, samples: int = 600, holds: tuple[Hold, ...] = ()) -> tuple[Clip, Units]:
    leader, follower = random_dance_clip(seed, samples, "leader"), random_dance_clip(seed + 1, samples, "follower")
    cuts = np.arange(20.0, samples - 20.0, 43.0)
    beats = np.arange(20.0, samples - 20.0, 21.5)
    example = Example("pair", ends_cloud(leader), ends_cloud(follower), follower, cuts, beats, holds)
    return leader, cut_units([example])


def transform_clip(clip: Clip, yaw: float, x: float, z: float) -> Clip:
    root = clip.root_position.astype(np.float64)
    place = np.exp(1j * yaw) * (root[:, 2] + 1j * root[:, 0]) + z + 1j * x
    rotation = clip.rotation.astype(np.float64).copy()
    rotation[:, 0] = quaternion.mul(np.array((np.cos(yaw / 2), 0.0, np.sin(yaw / 2), 0.0)), rotation[:, 0])
    new = np.stack((place.imag, root[:, 1], place.real), axis=1)
    return Clip(clip.name, new.astype(np.float32), rotation.astype(np.float32), RATE, clip.contact)


def test_database_leader_gets_recorded_follower_at_any_placement() -> None:
    """With the leader turned by 50 degrees and moved by 2 m, the answer is the recorded follower, transformed alike."""
    leader, units = pair_of(41)
    there = transform_clip(leader, 0.9, 2.0, -1.0)
    found = find_partner(there, ends_cloud(there), units, SearchSettings(hold_feet=False))
    expected = joint_positions(transform_clip(units.examples[0].follower, 0.9, 2.0, -1.0))
    inner = slice(40, -40)
    frame = np.linalg.norm(np.diff(expected, axis=0), axis=-1).max()  # boundaries lie on whole frames
    assert frame < 0.06
    assert np.linalg.norm(joint_positions(found.clip) - expected, axis=-1)[inner].max() < 1.5 * frame
    assert found.reading.count >= 10


def _unrelated_units(units: Units) -> Reading:
    """Reading of two units that do not follow each other, with motions that do not fit."""
    return Reading(
        np.array([2, 7]), np.array([0, 43]), np.array([43, 43]), np.array([1.0, np.exp(0.3j)]),
        np.array([0.0, 0.2 + 0.1j]), np.zeros(2), np.zeros(1), 0.0, RATE,
    )  # fmt: skip


def test_smoothed_joins_are_continuous_and_unsmoothed_joins_jump() -> None:
    _, units = pair_of(43)
    steps, kinks = {}, {}
    for smoothing in ("none", "linear", "eased"):
        joints = joint_positions(answer(_unrelated_units(units), units, 87, smoothing).clip)
        step = np.linalg.norm(np.diff(joints, axis=0), axis=-1).max(axis=1)
        kink = np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1).max(axis=1)
        steps[smoothing], kinks[smoothing] = step[42], kink[41:43].max()
        usual = np.median(step)
    assert steps["none"] > 0.1
    assert steps["linear"] < 0.25 * steps["none"]
    assert steps["eased"] < 5.0 * usual
    assert kinks["eased"] < 0.6 * kinks["linear"]


def test_joins_do_not_change_ends_of_answer() -> None:
    _, units = pair_of(44)
    plain = answer(_unrelated_units(units), units, 87, "none").clip
    eased = answer(_unrelated_units(units), units, 87, "eased").clip
    np.testing.assert_allclose(joint_positions(eased)[[0, -1]], joint_positions(plain)[[0, -1]], atol=1e-5)


def test_holds_are_copied_and_merged_across_consecutive_units() -> None:
    hold = Hold(0, 1, 120.0, 170.0)
    _, units = pair_of(45, holds=(hold,))
    # units 2 and 3 are samples 106 to 192: danced one after another at half speed from sample 10 on
    reading = Reading(
        np.array([2, 3]), np.array([10, 96]), np.array([86, 86]), np.ones(2, np.complex128),
        np.zeros(2, np.complex128), np.zeros(2), np.zeros(1), 0.0, RATE,
    )  # fmt: skip
    found = answer(reading, units, 190).holds
    assert len(found) == 1
    assert (found[0].leader_hand, found[0].follower_hand) == (0, 1)
    assert found[0].begin == pytest.approx(10 + 2 * (120 - 106))
    assert found[0].end == pytest.approx(10 + 2 * (170 - 106))


def test_held_hands_meet_with_constant_bone_lengths() -> None:
    follower = standing(120, RATE)
    leader = transform_clip(standing(120, RATE), np.pi, 0.0, 0.75)
    rotation = leader.rotation.copy()
    right = SKELETON.index("rightUpperArm")
    rotation[:, right] = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.array(1.3))
    leader = Clip("leader", leader.root_position.copy(), rotation, RATE, leader.contact)
    hold = (Hold(1, 0, 40.0, 80.0),)
    before = hold_error(follower, leader, hold)
    held = enforce_holds(follower, leader, hold)
    after = hold_error(held, leader, hold)
    assert before is not None
    assert after is not None
    assert before > 0.3
    assert after < 0.02
    np.testing.assert_allclose(palms(held)[[0, -1]], palms(follower)[[0, -1]], atol=1e-6)  # free before and after
    joints = joint_positions(held)
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            length = np.linalg.norm(joints[:, joint] - joints[:, parent], axis=-1)
            np.testing.assert_allclose(length, np.linalg.norm(SKELETON.offsets[joint]), atol=1e-5)
