"""Moods learnt from examples: one step danced in several moods (T143; style translation of Hsu et al. 2005).

Hsu, Pulli and Popović translate a style into another by a linear model between aligned performances of one content.
Steps are aligned by construction, because their measures are; and a model that must move any other step, of which no
example exists, keeps only what does not depend on the step: of each joint a constant rotation (posture), of the upper
body its size, and how low the hips are. The ends of the moods are found by least squares about the parametric ones, so
a mood without examples stays as it is.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.pose.mood_pose import FIRST, LAST, MAX_DROP, MAX_SIZE, PARAMETRIC, UPPER, MoodEnds
from live.motion.skeleton import MIRROR
from live.motion.step_clip import StepClip

PRIOR_EXAMPLES: Final = 0.1
"""Weight of the parametric ends, in examples: one example at its end counts ten times as much."""
MAX_BEND: Final = np.radians(60.0)
"""Largest rotation of a joint that is learnt [rad]."""
_MIRRORED_JOINT: Final = np.asarray(MIRROR)[FIRST:LAST] - FIRST


def learnt_ends(clips: Sequence[StepClip]) -> MoodEnds:
    """Return the ends of the moods by the examples among `clips`, the parametric ones if there are none.

    An example is compared with the clips of its step without a mood: those of its direction, or all of them.
    """
    wanted = {clip.step for clip in clips if clip.mood}
    if not wanted:
        return PARAMETRIC
    plain: dict[str, list[tuple[str, Float64]]] = {}
    for clip in clips:
        if clip.step in wanted and not clip.unjoined and not clip.mirrored:
            plain.setdefault(clip.step, []).append((clip.direction, _features(clip)))
    rows, changes = [], []
    for clip in clips:
        there = plain.get(clip.step)
        if not clip.mood or clip.mirrored or there is None:
            continue
        same = [features for direction, features in there if direction == clip.direction]
        changes.append(_change(same or [features for _, features in there], _features(clip)))
        mood = np.array(clip.mood)
        rows.append(np.concatenate((np.maximum(mood, 0.0), np.maximum(-mood, 0.0))))
    return _fitted(np.array(rows), np.array(changes)) if rows else PARAMETRIC


def _features(step: StepClip) -> Float64:
    """Return mean rotations of the upper body, size and hips' height [m] of the danced measures, (4 UPPER + 2,)."""
    samples = np.arange(round(step.first), round(step.first + step.measures * step.samples_per_measure))
    rotation = step.clip.rotation[samples, FIRST:LAST].astype(np.float64)
    mean = quaternion.mean_rotation(rotation)
    away = quaternion.mul(quaternion.inverse(mean), rotation)
    turn = quaternion.to_rotation_vector(away)
    size = 0.5 * np.log(np.mean(np.sum(turn**2, axis=-1)) + 1e-6)
    return np.concatenate((mean.ravel(), (size, step.clip.root_position[samples, 1].mean(dtype=np.float64))))


def _change(plain: Sequence[Float64], example: Float64) -> Float64:
    """Return what an example has else than the mean of plain clips: bend, size, drop, (3 UPPER + 2,)."""
    mean = quaternion.mean_rotation(np.array([one[:-2].reshape(UPPER, 4) for one in plain]))
    turn = quaternion.mul(example[:-2].reshape(UPPER, 4), quaternion.inverse(mean))
    bend = quaternion.to_rotation_vector(turn)
    angle = np.maximum(np.linalg.norm(bend, axis=-1, keepdims=True), 1e-9)
    bend *= 2.0 * np.tan(0.5 * np.minimum(angle, MAX_BEND)) / angle  # as `_bend_joints` bends
    size, height = example[-2:] - np.mean([one[-2:] for one in plain], axis=0)
    size, drop = np.clip(size, -2.0 * np.log(MAX_SIZE), np.log(MAX_SIZE)), np.clip(-height, -MAX_DROP, MAX_DROP)
    return np.concatenate((_symmetric(bend).ravel(), (size, drop)))


def _symmetric(bend: Float) -> Float64:
    """Return the mean of bends (UPPER, 3) and their mirror image: a mood is not on one side."""
    return np.asarray(0.5 * (bend + bend[_MIRRORED_JOINT] * (1.0, -1.0, -1.0)))


def _fitted(ends: Float64, changes: Float64) -> MoodEnds:
    """Return the ends that explain the `changes` (n, 3 UPPER + 2) of examples at `ends` (n, 12), shrunk to the
    parametric ones."""
    before = np.concatenate((
        PARAMETRIC.bend.reshape(12, -1), PARAMETRIC.size.reshape(12, 1), PARAMETRIC.drop.reshape(12, 1)
    ), axis=1).astype(np.float64)  # fmt: skip
    normal = ends.T @ ends + PRIOR_EXAMPLES * np.eye(12)
    after = before + np.linalg.solve(normal, ends.T @ (changes - ends @ before))
    return MoodEnds(
        np.ascontiguousarray(after[:, :-2].reshape(2, 6, UPPER, 3), np.float32),
        after[:, -2].reshape(2, 6).copy(),
        after[:, -1].reshape(2, 6).copy(),
    )
