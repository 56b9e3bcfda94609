"""Bank of motion capture cut at its beats, for texturing of upper bodies in real time (P024).

The published method needs future samples for low bands and for the end of a fragment. In real time a fragment is one
beat. It is chosen by the legs' last half beat and the first quarter of the current beat (the prefix); see
`live_texture_kernels.py`.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Float, Float32, Float64, Int32, Int64
from live.motion import quaternion
from live.motion.clip import read_clip
from live.motion.quaternion import mean_rotation
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.driver_choice import GROUPS
from live.motion.texture.frequency_bands import RATE, sample_clip
from live.motion.texture.live_prediction import LivePrediction, learn_live_prediction
from live.motion.texture.live_texture_kernels import DERIVATIVE, DIMENSIONS, PER_BEAT, SLOTS, UPPER_COUNT
from live.motion.texture.take_splits import Choreographies, Fold, choreographies, find_copies, make_folds
from live.motion.texture.texture_settings import UPPER

BEATS_AFTER: Final = 3
"""A fragment is chosen within its first beat and left within three beats, so its clip must last this long after it."""
SPREAD_FACTOR: Final = 1.5
"""Times the gain that leaves the least squared error. Then a quarter of what it gains over the mean pose is used for
liveliness; with a factor of 2 nothing would be gained (the error is quadratic in the factor)."""
SAME_BEATS: Final = 8
"""Beats of one recording nearer than this are too alike to be compared."""
GAIN_STEPS: Final = 64
"""Gains are rounded to this fraction, so that they are the same on all machines."""
_LEGS: Final = tuple(
    tuple(SKELETON.index(side + joint) for joint in ("UpperLeg", "LowerLeg", "Foot")) for side in ("left", "right")
)


@dataclass(frozen=True, slots=True, eq=False)
class TextureBank:
    """All recordings, concatenated, at 16 samples a beat: S samples, F fragments of one beat."""

    upper: Float32
    """Local rotations of the upper joints, (S, 13, 4), with continuous signs within each clip: what is recorded and not
    `told`, brought nearer to `mean_rotations` by `scale`."""
    mean_rotations: Float32
    """Mean rotation of each upper joint, (13, 4): reference for the sign of quaternions."""
    begin: Int32
    """Sample at which each fragment begins, (F,)."""
    clip_first: Int32
    """First sample of the clip of each fragment, (F,)."""
    clip_last: Int32
    """Last sample of the clip of each fragment, (F,)."""
    leg_features: Float32
    """Leg features around the beginning of each fragment, (DIMENSIONS, F)."""
    spread: float
    """Mean squared distance of two fragments: the unit of distances."""
    scale: Float32
    """Share of each joint's recorded deviation from the prediction that is danced, (13,)."""
    told: LivePrediction
    """What legs tell of the upper body. `upper` is what it leaves, turned to the mean."""
    recordings: str
    """Short hash of the recordings from which all this follows."""

    @property
    def count(self) -> int:
        """Number of fragments F."""
        return len(self.begin)

    def digest(self) -> str:
        """Return a short hash of the recordings."""
        return self.recordings

    @classmethod
    def empty(cls) -> "TextureBank":
        """Return an empty bank; no dancer is textured."""
        none, numbers = np.zeros(0, np.int32), np.zeros((DIMENSIONS, 0), np.float32)
        middle = np.tile(np.array((1.0, 0.0, 0.0, 0.0), np.float32), (UPPER_COUNT, 1))
        return cls(
            np.zeros((0, UPPER_COUNT, 4), np.float32),
            middle,
            none,
            none,
            none,
            numbers,
            1.0,
            np.ones(UPPER_COUNT, np.float32),
            LivePrediction.nothing(),
            "",
        )

    @classmethod
    def of(cls, clips: Sequence[StepClip]) -> "TextureBank":
        """Return the beats of these recordings.

        Recordings with fewer than four beats are skipped. Raises ValueError if none is left.
        """
        upper, tracks, begin, first, last = [], [], [], [], []
        used: list[StepClip] = []
        start = 0
        for clip in clips:
            beat = clip.samples_per_measure / clip.beats_per_measure
            beats = int((clip.clip.sample_count - 1 - clip.first) / beat + 1e-9)
            if beats <= BEATS_AFTER:
                continue
            at = clip.first + np.arange(beats * PER_BEAT + 1) * (beat / PER_BEAT)
            _, rotation, _ = read_clip(clip.clip, at)
            upper.append(quaternion.align_signs(rotation[:, list(UPPER)]))
            tracks.append(leg_positions(rotation))
            used.append(clip)
            count = beats - BEATS_AFTER + 1
            begin.append(start + PER_BEAT * np.arange(count))
            first.append(np.full(count, start))
            last.append(np.full(count, start + len(at) - 1))
            start += len(at)
        if not upper:
            raise ValueError("no recording holds four beats")
        begins, firsts, lasts = (np.concatenate(part).astype(np.int32) for part in (begin, first, last))
        rotations = np.concatenate(upper)
        middle = np.asarray(mean_rotation(rotations), np.float64)
        legs = prefix_features(np.concatenate(tracks), begins, firsts)
        spread = 2.0 * float(legs.var(axis=1).sum())
        dances = choreographies(len(used), find_copies([sample_clip(clip.clip) for clip in used]))
        starts = np.cumsum([0, *(len(part) for part in upper)]).tolist()
        parts = (rotations.astype(np.float32), begins, legs.astype(np.float32))
        known = hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()[:16]
        told, left_out = learn_live_prediction(
            np.concatenate(tracks), _turns_from(rotations, middle), starts, _folds(used, starts, dances)
        )
        left = quaternion.mul(quaternion.from_rotation_vector(-left_out.reshape(-1, UPPER_COUNT, 3)), rotations)
        take = np.repeat(np.arange(len(used)), [len(part) for part in begin])
        gains = live_gains(left, middle, begins, legs, dances.number[take])
        scale = np.minimum(SPREAD_FACTOR * gains, 1.0).astype(np.float32)
        vectors = deviations(left, middle) * scale[:, None]
        scaled = quaternion.mul(middle, quaternion.from_rotation_vector(vectors))
        kept = np.concatenate([quaternion.align_signs(scaled[a:b]) for a, b in pairwise(starts)])
        return cls(
            np.ascontiguousarray(kept, np.float32), np.ascontiguousarray(middle, np.float32),
            begins, firsts, lasts, np.ascontiguousarray(legs, np.float32), max(spread, 1e-9), scale, told, known,
        )  # fmt: skip


def _turns_from(rotations: Float, middle: Float64) -> Float64:
    """Return the rotation vectors (S, 3 n) of rotations (S, n, 4) from their means (n, 4), in their parents' axes."""
    away = quaternion.mul(np.asarray(rotations, np.float64), quaternion.inverse(middle))
    return np.asarray(quaternion.to_rotation_vector(away), np.float64).reshape(len(rotations), -1)


def _folds(used: Sequence[StepClip], starts: Sequence[int], dances: Choreographies) -> list[Fold]:
    """Return the splits of the samples of all clips, PER_BEAT a beat, that leave out choreographies."""
    offset = np.zeros(len(used), np.int64)
    for n, step in enumerate(used):
        seconds = step.samples_per_measure / step.beats_per_measure / step.clip.sample_rate
        first = step.first / step.clip.sample_rate
        offset[n] = round((float(dances.offset[n]) / RATE + first) / seconds * PER_BEAT)
    return make_folds(np.diff(starts).tolist(), Choreographies(dances.number, offset))


def deviations(rotations: Float, middle: Float64) -> Float64:
    """Return the rotation vectors (S, n, 3) of rotations (S, n, 4) from their means (n, 4)."""
    away = quaternion.mul(quaternion.inverse(middle), np.asarray(rotations, np.float64))
    return np.asarray(quaternion.to_rotation_vector(away), np.float64)


def live_gains(rotations: Float, middle: Float64, begin: Int32, legs: Float64, dance: Int64) -> Float64:
    """Return how far upper joints chosen by the legs can be trusted, (13,), from 0 (not at all) to 1.

    Each fragment's upper body, for a beat from the time of the choice, is compared with that of the fragment of another
    choreography (`dance` (F,)) whose legs (DIMENSIONS, F) are most alike. The gain is the factor of the deviation from
    the mean, common to a group of joints, that leaves the least squared error. With one choreography the fragments
    far enough away in time take the place of others.
    """
    squares = (legs * legs).sum(axis=0)
    far = squares[:, None] + squares - 2.0 * (legs.T @ legs)
    if dance.max(initial=0) > 0:
        same = dance[:, None] == dance
    else:
        same = np.abs(begin[:, None] - begin) < SAME_BEATS * PER_BEAT
    far[same] = np.inf
    chosen = np.argmin(far, axis=1)
    good = np.isfinite(far[np.arange(len(far)), chosen])
    gains = np.ones(UPPER_COUNT)
    if not good.any():
        return gains
    vectors = deviations(rotations, middle)
    window = PER_BEAT // 4 + np.arange(PER_BEAT)
    real = vectors[begin[good][:, None] + window]
    made = vectors[begin[chosen[good]][:, None] + window]
    for joints in GROUPS.values():
        rows = [UPPER.index(joint) for joint in joints]
        a, b = real[:, :, rows], made[:, :, rows]
        gain = float((a * b).sum() / max(float((b * b).sum()), 1e-12))
        gains[rows] = np.round(np.clip(gain, 0.0, 1.0) * GAIN_STEPS) / GAIN_STEPS
    return gains


def leg_positions(rotation: Float) -> Float64:
    """Return knees and ankles in the axes of the hips [m], (T, FEATURES), from local rotations (T, J, 4)."""
    if rotation.shape[1] != JOINT_COUNT:
        raise ValueError(f"{rotation.shape[1]} joints: {JOINT_COUNT} expected")
    offsets = SKELETON.offsets.astype(np.float64)
    places = []
    for thigh, shin, foot in _LEGS:
        knee = offsets[thigh] + quaternion.rotate(rotation[:, thigh], offsets[shin])
        bent = quaternion.mul(rotation[:, thigh], rotation[:, shin])
        places += [knee, knee + quaternion.rotate(bent, offsets[foot])]
    return np.concatenate(places, axis=-1)


def prefix_features(tracks: Float64, begin: Int32, first: Int32) -> Float64:
    """Return leg features from half a beat before to a quarter after the samples `begin` (F,), (DIMENSIONS, F)."""
    moments = (np.arange(SLOTS) - SLOTS // 2 - 1) * (PER_BEAT // 8)
    at = np.maximum(begin[None] + moments[:, None], first[None])
    return stack_features(tracks[at])


def stack_features(moments: Float) -> Float64:
    """Return the features to compare, (DIMENSIONS, F), of legs at SLOTS moments, (SLOTS, F, FEATURES)."""
    change = DERIVATIVE * np.diff(moments, axis=0)
    both = np.concatenate((moments, change)).astype(np.float64)
    return np.asarray(both.transpose(0, 2, 1).reshape(DIMENSIONS, -1))
