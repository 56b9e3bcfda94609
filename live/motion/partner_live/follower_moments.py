"""Moments of recorded pairs: what a leader did, and where the follower was in the frame of the leader's hips."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Complex128, Float64, Int64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.point_clouds import END_JOINTS
from live.motion.partner.units import Example, Units
from live.motion.partner_live.follower_kernels import write_features
from live.motion.skeleton import JOINT_COUNT, MIRROR

MOMENT_RATE: Final = 7.5
"""Moments per second."""
MAX_MOMENTS: Final = 3600
"""Moments that are learnt from; of more, stretches of STRETCH_MOMENTS are left out evenly."""
STRETCH_MOMENTS: Final = 64
LAGS: Final = (0.0, 0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0)
"""How long ago [s] a leader's points count ..."""
ROUNDING: Final = 1e-6
"""What is learnt is rounded to this, so that the last bits of a library do not matter."""
JOINT_COLUMNS: Final = 3 * JOINT_COUNT
FACING: Final = slice(JOINT_COLUMNS, JOINT_COLUMNS + 2)
HOLDS: Final = slice(JOINT_COLUMNS + 2, JOINT_COLUMNS + 6)
TARGET_COLUMNS: Final = JOINT_COLUMNS + 6
"""Columns of what is predicted: joints (22 · z, y, x) [m] in the frame of the leader's hips, facing (z, x), and whether
each pair of palms holds: the leader's left with the follower's left and right, the leader's right with both."""
END_COLUMNS: Final = tuple(3 * joint + axis for joint in END_JOINTS for axis in range(3))


def root_track(clip: Clip) -> tuple[Complex128, Complex128]:
    """Return the hips of a clip on the floor (z + i x) and their facing as unit complex numbers, (T,) each."""
    front = quaternion.rotate(clip.rotation[:, 0].astype(np.float64), np.array((0.0, 0.0, 1.0)))
    facing = front[:, 2] + 1j * front[:, 0]
    root = clip.root_position.astype(np.float64)
    return np.asarray(root[:, 2] + 1j * root[:, 0]), np.asarray(facing / np.maximum(np.abs(facing), 1e-9))


def leader_frame(floor: Complex128) -> tuple[Complex128, Complex128]:
    """Return the middle of the hips and their facing from points (..., P), the hip joints first."""
    across = floor[..., 0] - floor[..., 1]
    size = np.abs(across)
    facing = np.where(size > 1e-9, -1j * across / np.maximum(size, 1e-9), 1.0)
    return np.asarray(0.5 * (floor[..., 0] + floor[..., 1])), np.asarray(facing)


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """M moments of some recordings."""

    example: Int64
    """Index of each one's recording, (M,)."""
    sample: Float64
    """Its sample there, (M,)."""
    follows: Int64
    """How many moments of the recording follow without a gap, at most 2, (M,)."""
    unit: Int64
    """Unit that it belongs to, the nearest one outside of all, (M,)."""
    phase: Float64
    """Share of the unit that has passed, (M,); before the first unit and after the last it goes on."""
    feature: Float64
    """What the leader did, (M, D); not yet scaled."""
    target: Float64
    """Where the follower was, (M, TARGET_COLUMNS)."""
    mirrored: Bool
    """Whether it is a mirror image, which is learnt from and never danced, (M,)."""


def rounded(values: Float64) -> Float64:
    """Return values rounded to ROUNDING."""
    return np.asarray(np.round(values / ROUNDING) * ROUNDING)


def read_moments(units: Units, n: int, rate: float, stride: int, lags: Int64) -> Moments:
    """Return the moments of recording `n`: every `stride`th frame at `rate` [Hz], and the leader before."""
    example = units.examples[n]
    cloud, clip = example.live_control, example.follower
    last = min(cloud.count, clip.sample_count) - 1
    frames = int(last / units.rate * rate + 1e-6) + 1
    thin = cloud.at(np.asarray(np.arange(frames) * units.rate / rate, np.float64))
    at = np.arange(0, frames, stride)
    features = np.zeros((len(at), len(lags) * (3 * thin.floor.shape[1] - 1)))
    floor, height = np.ascontiguousarray(thin.floor), np.ascontiguousarray(thin.height)
    for row, frame in zip(features, at.tolist(), strict=True):
        write_features(frame, 0, floor, height, lags, row)
    sample = np.asarray(at * units.rate / rate, np.float64)
    own = np.flatnonzero(units.example == n)
    which = own[np.clip(np.searchsorted(units.start[own], sample + 1e-6, side="right") - 1, 0, len(own) - 1)]
    return Moments(
        np.full(len(at), n, np.int64),
        sample,
        np.minimum(np.arange(len(at))[::-1], 2).astype(np.int64),
        which.astype(np.int64),
        (sample - units.start[which]) / units.length[which],
        features,
        _targets(example, thin.floor[at], np.round(sample).astype(np.int64)),
        np.zeros(len(at), np.bool_),
    )


def mirror_moments(moments: Moments) -> Moments:
    """Return the mirror image of both dancers, left and right exchanged."""
    feature = moments.feature.reshape(len(moments.sample), len(LAGS), -1).copy()
    points = feature[..., 3:-2].reshape(*feature.shape[:2], -1, 3)
    feature[..., 3:-2] = points[..., [n ^ 1 for n in range(points.shape[2])], :].reshape(*feature.shape[:2], -1)
    feature[..., 2::3] *= -1.0
    feature[..., -1] *= -1.0
    target = moments.target.copy()
    joints = target[:, :JOINT_COLUMNS].reshape(len(target), -1, 3)[:, MIRROR] * (1.0, 1.0, -1.0)
    target[:, :JOINT_COLUMNS] = joints.reshape(len(target), -1)
    target[:, FACING.start + 1] *= -1.0
    target[:, HOLDS] = target[:, HOLDS][:, ::-1]
    whole = np.ones(len(target), np.bool_)
    return replace(moments, feature=feature.reshape(len(target), -1), target=target, mirrored=whole)


def _targets(example: Example, floor: Complex128, at: Int64) -> Float64:
    """Return the follower at the samples `at` in the frame of the leader with points `floor` (n, P)."""
    clip = example.follower
    middle, front = leader_frame(floor)
    joints, _ = forward_kinematics(clip.root_position[at].astype(np.float64), clip.rotation[at].astype(np.float64))
    place = (joints[..., 2] + 1j * joints[..., 0] - middle[:, None]) * front.conj()[:, None]
    facing = root_track(clip)[1][at] * front.conj()
    found = np.zeros((len(at), TARGET_COLUMNS))
    found[:, :JOINT_COLUMNS] = np.stack((place.real, joints[..., 1], place.imag), axis=-1).reshape(len(at), -1)
    found[:, FACING] = np.stack((facing.real, facing.imag), axis=1)
    for hold in example.holds:
        found[(at >= hold.begin) & (at <= hold.end), HOLDS.start + 2 * hold.leader_hand + hold.follower_hand] = 1.0
    return rounded(found)


def joined_moments(parts: list[Moments]) -> Moments:
    """Return all moments of all `parts`, in order."""
    return Moments(*(np.concatenate([getattr(one, name) for one in parts]) for name in Moments.__dataclass_fields__))


def thinned_moments(moments: Moments) -> Moments:
    """Return at most about MAX_MOMENTS of them, in whole stretches."""
    count = len(moments.sample)
    if count <= MAX_MOMENTS:
        return moments
    stretch = np.arange(count) // STRETCH_MOMENTS
    kept = (stretch + 1) * MAX_MOMENTS // count > stretch * MAX_MOMENTS // count
    follows = moments.follows.copy()
    for ahead in (2, 1):
        gone = np.flatnonzero(~kept) - ahead
        follows[gone[gone >= 0]] = np.minimum(follows[gone[gone >= 0]], ahead - 1)
    fields = {name: getattr(moments, name) for name in Moments.__dataclass_fields__} | {"follows": follows}
    return selected_moments(Moments(**fields), kept)


def selected_moments(moments: Moments, which: Bool) -> Moments:
    """Return the moments `which` (M,)."""
    return Moments(*(getattr(moments, name)[which] for name in Moments.__dataclass_fields__))
