"""Combination: the legs of one clip under the arms of another clip of the same step (T044)."""

from dataclasses import replace
from typing import Final

import numpy as np

from live.motion.same_step import check_same_step, samples_in
from live.motion.sampling import read_clip
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip

LOWER: Final = tuple(
    joint
    for joint, name in enumerate(SKELETON.names)
    if name == "hips" or name.endswith(("UpperLeg", "LowerLeg", "Foot", "Toes"))
)
"""Joints of the lower body: hips and legs."""
UPPER: Final = tuple(joint for joint in range(SKELETON.joint_count) if joint not in LOWER)
"""Joints of the upper body: the spine and all above."""


def combine(lower: StepClip, upper: StepClip) -> StepClip:
    """The step of `lower`, with the rotations of all joints from the spine upwards taken from `upper` (T044).

    Aligned by the measure, because both are the same step; structure, way and contacts are those of `lower`, whose
    samples it has. ValueError for clips of different steps.
    """
    check_same_step(lower, upper)
    rotation = lower.clip.rotation.copy()
    if lower.first == upper.first and lower.samples_per_measure == upper.samples_per_measure:
        count = min(lower.clip.sample_count, upper.clip.sample_count)
        rotation[:count, UPPER] = upper.clip.rotation[:count, UPPER]
        rotation[count:, UPPER] = upper.clip.rotation[count - 1, UPPER]
    else:
        rotation[:, UPPER] = np.asarray(read_clip(upper.clip, samples_in(upper, lower))[1], np.float32)[:, UPPER]
    name = f"{lower.clip.name}, upper body of {upper.clip.name}"
    return replace(lower, clip=replace(lower.clip, name=name, rotation=rotation))
