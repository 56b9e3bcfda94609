"""Tests of the live texture kernels against numpy, at the ends of clips and with numbers beyond them."""

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.texture import live_texture_kernels as kernels
from live.motion.texture.live_bank import TextureBank, leg_positions
from live.motion.texture.texture_settings import UPPER
from tests.motion.texture.made_dance import dance

BANK = TextureBank.of([dance(8.0, seed) for seed in (1, 2)])
CHANCE = np.random.default_rng(5)
OFFSETS, PARENTS = np.array(SKELETON.offsets), np.array(SKELETON.parents)


def apply_texture(
    local: np.ndarray, root: np.ndarray, danced: float, level: float, came: float, told: np.ndarray | None = None
) -> tuple[np.ndarray, ...]:
    """Textured local poses (A, J, 4); source 0 begins at sample 0, source 1 at sample 40 of the first clip.

    `told` (A, 3, 39) was told at the last eighth of a beat.
    """
    position, rotation = (a.astype(np.float32) for a in forward_kinematics(root, local))
    count = len(local)
    limits = np.zeros((2, count, 2), np.int32)
    limits[..., 1] = BANK.clip_last[0]
    origin = np.zeros((2, count))
    origin[1] = 40.0
    kernels.blend_upper_bodies(
        position, rotation, np.full(count, danced), np.full(count, level, np.float32), origin, limits,
        np.full(count, danced - came), 1.0, np.zeros((2, count), np.int64), BANK.upper, OFFSETS, PARENTS,
        np.zeros(count, np.float32), np.zeros((count, 3, 39), np.float32) if told is None else told,
        np.full(count, int(np.floor(8.0 * danced)), np.int64),
    )  # fmt: skip
    return position, rotation


def random_poses(count: int = 3) -> tuple[np.ndarray, np.ndarray]:
    local = quaternion.from_rotation_vector(0.4 * CHANCE.normal(size=(count, JOINT_COUNT, 3)))
    return local, CHANCE.normal(size=(count, 3))


def test_full_texture_shows_upper_joints_of_sample() -> None:
    local, root = random_poses()
    wanted = local.copy()
    wanted[:, list(UPPER)] = BANK.upper[32]
    position, rotation = apply_texture(local, root, 2.0, 1.0, 1.0)
    expected = forward_kinematics(root, wanted)
    assert np.abs(position - expected[0]).max() < 1e-5
    assert np.abs(np.abs(np.sum(rotation * expected[1], axis=-1)) - 1.0).max() < 1e-5


def test_half_texture_is_midpoint_of_slerp() -> None:
    local, root = random_poses()
    wanted = local.copy()
    there = np.broadcast_to(BANK.upper[48], local[:, list(UPPER)].shape)
    wanted[:, list(UPPER)] = quaternion.slerp(local[:, list(UPPER)], there, np.full(there.shape[:2], 0.5))
    position, _ = apply_texture(local, root, 3.0, 0.5, 1.0)
    assert np.abs(position - forward_kinematics(root, wanted)[0]).max() < 1e-5


def test_source_change_blends_from_old_to_new() -> None:
    local, root = random_poses()
    for came, sample in ((0.0, 40 + 16), (1.0, 16)):
        wanted = local.copy()
        wanted[:, list(UPPER)] = BANK.upper[sample]
        position, _ = apply_texture(local, root, 1.0, 1.0, came)
        assert np.abs(position - forward_kinematics(root, wanted)[0]).max() < 1e-5


def test_clip_is_held_beyond_its_ends() -> None:
    local, root = random_poses()
    for danced, sample in ((-1e6, 0), (1e6, int(BANK.clip_last[0]))):
        wanted = local.copy()
        wanted[:, list(UPPER)] = BANK.upper[sample]
        position, _ = apply_texture(local, root, danced, 1.0, 1.0)
        assert np.abs(position - forward_kinematics(root, wanted)[0]).max() < 1e-5


def test_what_is_told_turns_recorded_joints_along_a_curve_without_kinks() -> None:
    local, root = random_poses(1)
    told = CHANCE.normal(size=(1, 3, 39)).astype(np.float32)

    def at(danced: float, points: np.ndarray) -> np.ndarray:
        return apply_texture(local, root, danced, 1.0, 1.0, points)[1]

    for part in (0.0, 0.5, 0.875):
        danced = 1.0 + part / 8.0
        weights = 0.5 * (1.0 - part) ** 2, 0.5 + part * (1.0 - part), 0.5 * part**2
        vector = sum(weight * one for weight, one in zip(weights, told[0].astype(np.float64), strict=True))
        turn = quaternion.from_rotation_vector(np.asarray(vector).reshape(13, 3))
        wanted = local.copy()
        still = apply_texture(local, root, danced, 1.0, 1.0)[1][:, list(UPPER)]
        parents = apply_texture(local, root, danced, 1.0, 1.0)[1][:, [SKELETON.parents[n] for n in UPPER]]
        own = quaternion.mul(quaternion.inverse(parents), still)
        wanted[:, list(UPPER)] = quaternion.mul(turn, own)
        expected = forward_kinematics(root, wanted)[1]
        assert np.abs(np.abs(np.sum(at(danced, told) * expected, axis=-1)) - 1.0).max() < 1e-5
    following = np.concatenate((told[:, 1:], CHANCE.normal(size=(1, 1, 39)).astype(np.float32)), axis=1)
    before, after = at(1.125 - 1e-9, told), at(1.125, following)
    assert np.abs(np.abs(np.sum(before * after, axis=-1)) - 1.0).max() < 1e-5


def test_legs_are_followed_at_every_eighth_as_numpy_does() -> None:
    told = BANK.told
    assert told.centres.shape[1] > 10
    kept = np.zeros((2, 16, 12), np.float32)
    tracks = leg_positions(np.asarray(dance(8.0, 3).clip.rotation[::4], np.float64))
    for moment in range(16, 33):
        kept[:, moment % 16] = tracks[moment]
    out, at = np.zeros((2, 3, 39), np.float32), np.full(2, kernels.NEVER, np.int64)
    near = np.zeros(told.centres.shape[1], np.float32)
    wanted = np.array([True, False])
    beat = np.full(2, 32.4 / 8.0)
    for _ in range(2):  # the second time nothing is due
        kernels.follow_legs(
            out, at, wanted, beat, kept, near, told.middle, told.scale, told.centres, told.weights, told.slopes
        )  # fmt: skip
    expected = told.predict(tracks[32 - np.arange(9)].reshape(1, -1))[0]
    assert at.tolist() == [32, kernels.NEVER]
    assert np.abs(expected).max() > 0.05
    assert out[0] == pytest.approx(np.tile(expected, (3, 1)), abs=1e-4)
    assert not out[1].any()
    kept[:, 33 % 16] = tracks[50]
    kernels.follow_legs(
        out, at, wanted, beat + 0.125, kept, near, told.middle, told.scale, told.centres, told.weights, told.slopes
    )  # fmt: skip
    assert out[0, :2] == pytest.approx(np.tile(expected, (2, 1)), abs=1e-4)
    assert np.abs(out[0, 2] - expected).max() > 1e-3


def test_continuing_fragment_is_preferred_within_margin() -> None:
    far = np.zeros(BANK.count, np.float32)
    own = np.ascontiguousarray(BANK.leg_features[:, 7]) + np.float32(1e-3)
    apart = ((BANK.leg_features - own[:, None]) ** 2).sum(axis=0)
    assert kernels.nearest_fragment(far, BANK.leg_features, own, -1, 0.0, 0.0, 1, 2) == int(np.argmin(apart)) == 7
    assert np.allclose(far, apart, rtol=1e-4)
    other = 9
    gap = float(apart[other] - apart[7])
    assert kernels.nearest_fragment(far, BANK.leg_features, own, other, 0.9 * gap, 0.0, 1, 2) == 7
    assert kernels.nearest_fragment(far, BANK.leg_features, own, other, 1.1 * gap, 0.0, 1, 2) == other


def test_hash_is_uniform_and_differs_by_seed() -> None:
    drawn = np.array([[kernels.hash_24bit(seed, 3, f) for f in range(400)] for seed in (1, 2**31 - 1)]) / 2.0**24
    assert np.all((drawn >= 0.0) & (drawn < 1.0))
    assert np.all(np.abs(drawn.mean(axis=1) - 0.5) < 0.06)
    assert abs(float(np.corrcoef(drawn)[0, 1])) < 0.15


def test_moments_are_recorded_where_passed() -> None:
    kept = np.zeros((2, 16, 12), np.float32)
    before, now = np.zeros((2, 12), np.float32), np.ones((2, 12), np.float32)
    kernels.record_moments(kept, before, now, np.array([0.9, -0.3]), np.array([1.1, -0.1]), 8)
    assert np.allclose(kept[0, 8], 0.5)  # slot 8, halfway
    assert np.allclose(kept[1, 14], 0.25)  # slot 14, a quarter of the way
    assert np.allclose(kept[1, 15], 0.875)
    assert np.count_nonzero(np.abs(kept).sum(axis=-1)) == 3
    kernels.record_moments(kept, before, now, np.array([50.0, 0.0]), np.array([1.0, 90.0]), 8)  # jumps back and forward


def test_leg_positions_are_in_hip_axes() -> None:
    from live.motion.pose.pose_pipeline import PoseSkeleton

    local, root = random_poses()
    joints = PoseSkeleton.legs_only()[1]
    position, rotation = forward_kinematics(root, local)
    out = np.zeros((3, 12), np.float32)
    legs = [np.ascontiguousarray(a[:, joints], np.float32) for a in (position, rotation)]
    kernels.measure_legs(out, *legs)
    assert np.abs(out - leg_positions(local)).max() < 1e-5
    bits = kernels.signs_of(
        BANK.upper, -5.0, np.zeros(2, np.int32), 1e6, np.array([0, 90], np.int32), 3, BANK.mean_rotations, True
    )
    assert 0 <= bits < 1 << kernels.UPPER_COUNT
